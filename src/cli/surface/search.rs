//! What is searched for, for how long, and from which points.

use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, ensure};
use clap::{Args, ValueEnum, ValueHint};

use crate::cli::args::within;
use crate::limits::{BUDGET, LOWEST, REGION};
use crate::printable::counted;
use crate::store::{StationaryRow, content_hash};
use crate::topography::exchange::{points_of_text, read_points};
use crate::topography::{LowestSettings, SearchSettings, SizeProbe};

/// Which part of the landscape is searched.
#[derive(Debug, Clone, Args)]
pub(super) struct Extent {
    /// What to search for: everything, or the lowest minima and the lowest ways between them.
    #[arg(long, value_enum, default_value_t)]
    search: Kind,
    /// How many of the lowest minima are to be joined if only these are sought; 150 by default. A note says if all are sought,
    /// so that this was not used; `--search lowest` seeks only these.
    #[arg(long, value_name = "N")]
    lowest: Option<usize>,
    /// Stop after this time, such as 90s, 10m or 1h30m, with what was found. Without a number of searches (`--searches`, or
    /// `max_searches` in the file of `--config`), only this time and the search itself end it. What is missing then depends
    /// on the clock, so the result can differ between runs; the summary names the number of searches that repeats it.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    budget: Option<Duration>,
    /// Begin with these points besides random ones: a text file with one point on each line, `points.min` of PATHSAMPLE, or
    /// the minima of a landscape folder that `surface` wrote.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::AnyPath)]
    from: Option<PathBuf>,
}

/// What is searched for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Kind {
    /// Everything, unless descents from random points suggest more minima than 100,000 searches can visit: then the lowest.
    #[default]
    Auto,
    /// All minima and saddles.
    All,
    /// The lowest minima and the lowest ways between them.
    Lowest,
    /// The minima below random points, joined by attraction–diffusion alone, as published (sequential ADELM). Every barrier
    /// is an upper bound, and families depend on the order of the points.
    Adelm,
}

impl Extent {
    /// Greatest time of the search.
    pub(super) const fn budget(&self) -> Option<Duration> {
        self.budget
    }

    /// Whether attraction–diffusion alone maps the surface.
    pub(super) fn is_adelm(&self) -> bool {
        self.search == Kind::Adelm
    }

    /// Whether only the lowest part is to be searched, however small the landscape is.
    pub(super) fn is_lowest(&self) -> bool {
        self.search == Kind::Lowest
    }

    /// The first of these flags that was given and means nothing to attraction–diffusion alone.
    pub(super) fn not_of_adelm(&self) -> Option<&'static str> {
        let given = [
            (self.lowest.is_some(), "--lowest"),
            (self.budget.is_some(), "--budget"),
        ];
        given
            .into_iter()
            .find_map(|(given, flag)| given.then_some(flag))
    }

    /// A sentence if `--lowest` was given to a search for everything.
    pub(super) fn unused(&self, everything: bool) -> Option<String> {
        let lowest = self.lowest.filter(|_| everything)?;
        Some(format!(
            "note: --lowest {lowest} was not used, because everything is searched for (--search lowest searches only for the \
             lowest part)"
        ))
    }

    pub(super) fn checked(&self) -> anyhow::Result<()> {
        if let Some(lowest) = self.lowest {
            within("--lowest", LOWEST, lowest as f64)?;
        }
        self.budget.map_or(Ok(()), |budget| {
            within("--budget", BUDGET, budget.as_secs_f64())
        })
    }

    /// The settings of a search for the lowest minima, if only these are sought. `probe` estimates the size of the landscape.
    pub(super) fn settings(
        &self,
        settings: &SearchSettings,
        usual: &LowestSettings,
        probe: impl FnOnce() -> SizeProbe,
    ) -> Option<LowestSettings> {
        let lowest = match self.search {
            Kind::All | Kind::Adelm => false,
            Kind::Lowest => true,
            Kind::Auto => probe().is_too_large(settings),
        };
        lowest.then(|| LowestSettings {
            minima: self.lowest.unwrap_or(usual.minima),
            ..usual.clone()
        })
    }

    /// The points of `--from` and a hash of them.
    pub(super) fn known(&self, coordinates: usize) -> anyhow::Result<(Vec<Vec<f64>>, String)> {
        let Some(path) = &self.from else {
            return Ok((Vec::new(), String::new()));
        };
        let points = if path.is_dir() {
            let rows = StationaryRow::read(path)?.into_iter();
            rows.filter(|row| row.index == 0)
                .map(|row| row.coordinates)
                .collect()
        } else {
            let bytes = fs::read(path).with_context(|| format!("--from {}", path.display()))?;
            if path.extension().is_some_and(|ending| ending == "min") {
                read_points(&bytes, coordinates).with_context(|| {
                    format!(
                        "--from {}: its {} bytes do not divide into points of {coordinates} finite coordinates",
                        path.display(),
                        bytes.len()
                    )
                })?
            } else {
                points_of_text(&bytes).with_context(|| format!("--from {}", path.display()))?
            }
        };
        for (row, point) in points.iter().enumerate() {
            ensure!(
                point.len() == coordinates,
                "--from {}: point {} has {}, and the surface has {}",
                path.display(),
                row + 1,
                counted(point.len(), "number"),
                counted(coordinates, "coordinate")
            );
            for number in point {
                within(
                    &format!("--from {}: point {}:", path.display(), row + 1),
                    REGION,
                    *number,
                )?;
            }
        }
        ensure!(
            !points.is_empty(),
            "--from {}: it contains no points",
            path.display()
        );
        let bits = points
            .iter()
            .flatten()
            .flat_map(|number| number.to_le_bytes());
        let hash = content_hash(&[&bits.collect::<Vec<u8>>()]);
        Ok((points, hash))
    }
}

/// Parses `90s`, `10m`, `1h30m`, or `1d`.
fn duration(text: &str) -> Result<Duration, String> {
    let wrong = || format!("invalid time `{text}`: expected 90s, 10m or 1h30m");
    let (mut seconds, mut digits) = (0.0, String::new());
    for c in text.trim().chars() {
        let unit = match c {
            '0'..='9' | '.' => {
                digits.push(c);
                continue;
            }
            's' => 1.0,
            'm' => 60.0,
            'h' => 3600.0,
            'd' => 86400.0,
            _ => return Err(wrong()),
        };
        let count: f64 = digits.parse().ok().ok_or_else(wrong)?;
        seconds += unit * count;
        digits.clear();
    }
    if !digits.is_empty() || text.trim().is_empty() {
        return Err(wrong());
    }
    Duration::try_from_secs_f64(seconds).ok().ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read() {
        let seconds = |text: &str| duration(text).unwrap().as_secs_f64();
        for (text, known) in [
            ("90s", 90.0),
            ("10m", 600.0),
            ("1h30m", 5400.0),
            ("0.5s", 0.5),
            ("1d", 86400.0),
        ] {
            assert!((seconds(text) - known).abs() < 1e-9, "{text}");
        }
        for wrong in [
            "",
            "10",
            "m",
            "10 m",
            "-5s",
            "1e400s",
            "5x",
            "infs",
            "99999999999999999999999999d",
        ] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
    }
}
