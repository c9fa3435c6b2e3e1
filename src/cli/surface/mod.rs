//! `landscape surface`: all minima and saddles of a model, or of an energy that another program computes.

mod adelm;
mod program;
mod search;

use std::error::Error;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow, ensure};
use clap::{Args, ValueEnum};
use program::{Region, command_hash, region};
use search::Extent;

use super::args::{Again, Common, FamilyBarrier, WithPage, pair_named, within};
use super::output::check_place;
use super::run::{Unfinished, Watch, check_resumable};
use super::{interruption, report};
use crate::cli::printing::{complain, explain, explain_settings, print_landscapes};
use crate::energy::model::MODELS;
use crate::energy::{Counted, Energy, External, InBox, Protocol, model};
use crate::limits::SEARCHES;
use crate::store::{Source, content_hash};
use crate::study::{
    self, Searched, StudyError, StudyRun, Subject, SurfaceConfiguration, SurfaceReport,
    SurfaceSearch, WrittenLandscape, in_region, onto, search_surface,
};
use crate::topography::{
    Attempt, FamilySettings, GuardedJournal, LowestSettings, PairSearch, Run, SearchSettings,
    probe_size,
};

/// Map a surface.
#[derive(Debug, Args)]
pub(super) struct Surface {
    /// The model and its arguments, as listed below.
    #[arg(
        value_name = "MODEL",
        required_unless_present = "command",
        conflicts_with = "command",
        allow_negative_numbers = true
    )]
    model: Vec<String>,
    /// A program that computes the energy, as a shell command.
    #[arg(long, value_name = "COMMAND", requires = "region")]
    command: Option<String>,
    /// Region of random starts: low:high for each coordinate; `-1:1x21` means 21 equal ranges.
    #[arg(long, value_name = "LOW:HIGH,...", allow_hyphen_values = true)]
    region: Option<String>,
    /// Kind of coordinates of the program's energy.
    #[arg(long, value_enum, default_value_t = Coordinates::Flat, requires = "command")]
    coordinates: Coordinates,
    /// Elements of the atoms, such as `Ar,Ar,Kr` or `Ar2,Kr`, with `--coordinates atoms`, `fixed-frame` or `periodic`: only
    /// atoms of one element are the same. Without it all atoms of `atoms` are equal.
    #[arg(long, value_name = "LIST", requires = "command")]
    elements: Option<String>,
    /// Permutations and changes of sign of flat coordinates or angles that leave the energy as it is: a text file with one
    /// on each line, as a signed number for each coordinate, counted from 1 (`2 1 -3` exchanges the first two and negates
    /// the third). Copies then count as one point.
    #[arg(long, value_name = "FILE", requires = "command", value_hint = clap::ValueHint::FilePath)]
    symmetries: Option<PathBuf>,
    /// Greatest time for one answer of the program.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = External::ANSWER_LIMIT.as_secs_f64(),
        requires = "command",
        allow_negative_numbers = true
    )]
    answer_seconds: f64,
    /// How the program is asked and answers.
    #[arg(long, value_enum, default_value_t, requires = "command")]
    protocol: Exchange,
    /// The folder to write; by default the name of the model with the ending `.landscape`.
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Stop after this many searches without new results for every minimum and saddle found.
    #[arg(long, value_name = "N")]
    patience: Option<usize>,
    /// Stop after about this many searches in any case.
    #[arg(long, value_name = "N")]
    searches: Option<usize>,
    #[command(flatten)]
    extent: Extent,
    /// Spend more on two minima, as the same command without this flag names them (m3, m17): 40 further searches by
    /// attraction–diffusion for a lower way between them, when the usual ones have ended. The search goes on from the saddles
    /// that they cross. If this renumbers the minima, the summary lists both names.
    #[arg(long, num_args = 2, value_names = ["FROM", "TO"])]
    connect: Option<Vec<String>>,
    /// File (TOML) with any of the settings that `landscape config surface` prints. Flags override it.
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    config: Option<PathBuf>,
    #[command(flatten)]
    families: FamilyBarrier,
    /// Seed of all random draws; 0 by default.
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    page: WithPage,
    #[command(flatten)]
    again: Again,
}

impl Surface {
    /// Whether a time limits the search and no number of searches does.
    fn has_time_alone(&self, configuration: &SurfaceConfiguration) -> bool {
        self.extent.budget().is_some()
            && self.searches.is_none()
            && !configuration.limits_searches()
    }

    /// The searches of `--connect`, if the search has found `count` minima.
    fn pair(&self, count: usize) -> anyhow::Result<Option<PairSearch>> {
        let names = self.connect.as_deref();
        names.map(|names| pair_named(names, count)).transpose()
    }

    /// Refuses `--connect` where the names of minima do not last, or no further searches between them can be made.
    fn check_connect(&self, lowest: bool) -> anyhow::Result<()> {
        let Some(names) = &self.connect else {
            return Ok(());
        };
        let flag = format!("--connect {}", names.join(" "));
        ensure!(
            self.extent.budget().is_none(),
            "{flag}: with --budget, the names of minima depend on the speed of the machine; limit the search by --searches"
        );
        ensure!(
            !lowest,
            "{flag}: only the lowest part of this landscape is searched, which spends most on the highest barriers by itself; \
             `--search all` takes --connect, and --searches limits it"
        );
        Ok(())
    }

    /// Refuses names of `--connect` that no minimum has.
    fn check_names(&self, searched: &Searched) -> anyhow::Result<()> {
        if searched.found.further.is_some() {
            return Ok(());
        }
        let kept = |error| anyhow!("{error}; the same command with other names goes on from here");
        self.pair(searched.found.minima.len()).map_err(kept)?;
        Ok(())
    }

    /// The settings, without the usual limit of searches if a time is the only one.
    fn without_limit(
        &self,
        mut settings: SearchSettings,
        configuration: &SurfaceConfiguration,
    ) -> SearchSettings {
        if self.has_time_alone(configuration) {
            settings.max_searches = SearchSettings::NO_LIMIT;
        }
        settings
    }
}

/// Kinds of coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Coordinates {
    /// Numbers in a flat space.
    Flat,
    /// Angles in radians, which are periodic.
    Angles,
    /// Positions x, y, z of equal atoms; moved, rotated, mirrored and renumbered copies are the same.
    Atoms,
    /// Numbers that never leave the region: a minimum may lie on a face, an edge or a corner of it.
    Box,
    /// Numbers that wrap: each with the length of its side of the region as its period. With --elements they are positions
    /// of atoms, and those of one element are renumbered. Copies moved as a whole differ: keep one atom fixed by leaving its
    /// coordinates out.
    Periodic,
    /// Positions x, y, z of atoms among others that stay, such as a surface: those of one element (--elements) are
    /// renumbered, and moved copies differ.
    FixedFrame,
    /// A unit quaternion w, x, y, z; the gradient has three numbers, by rotation about the body's own axes.
    Rotation,
}

impl From<Coordinates> for study::Coordinates {
    fn from(coordinates: Coordinates) -> Self {
        match coordinates {
            Coordinates::Flat | Coordinates::FixedFrame => Self::Flat,
            Coordinates::Angles => Self::Angles,
            Coordinates::Atoms => Self::Atoms,
            Coordinates::Box => Self::Box,
            Coordinates::Periodic => Self::Periodic,
            Coordinates::Rotation => Self::Rotation,
        }
    }
}

/// How a program is asked and answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Exchange {
    /// A line of JSON for each question and each answer.
    #[default]
    Json,
    /// Numbers of 64 bits (little-endian): the coordinates; then the energy and the gradient.
    Binary,
    /// As binary for many points at once, which suits programs that compute them together: the number of points, then the
    /// points; then their answers.
    Batch,
}

impl From<Exchange> for Protocol {
    fn from(exchange: Exchange) -> Self {
        match exchange {
            Exchange::Json => Self::Json,
            Exchange::Binary => Self::Binary,
            Exchange::Batch => Self::Batch,
        }
    }
}

pub(super) fn examples() -> String {
    let models = MODELS.iter().map(|model| {
        let call = format!("{} {}", model.name, model.arguments);
        format!("  {call:<40}{}\n", model.about)
    });
    format!(
        "{EXAMPLES}\n\nModels:\n{}",
        models.collect::<String>().trim_end()
    )
}

pub(super) const EXAMPLES: &str = r#"Searches for all minima and all saddles between them. The search uses only the energy and random points: it climbs from
minima along their modes and from random points, descends on both sides of each saddle, and stops when it has found
nothing new for a long time. The summary estimates how complete the result is.

If descents from random points suggest more minima than 100,000 searches can visit (or --searches, if that is more),
only the lowest part of the landscape is searched: basin hopping at several temperatures finds the lowest minima,
paths and climbs join them, and effort goes to the highest barriers until the tree of the lowest minima no longer
changes. The summary lists barriers and estimates what is missing.

Examples:
  landscape surface muller-brown                           writes muller-brown.landscape/
  landscape surface lj 7 -o seven.landscape                7 Lennard-Jones atoms: 4 minima, 12 saddles
  landscape surface lj 38 --budget 10m                     the lowest part of a landscape too large to enumerate
  landscape surface lj 7 --connect m0 m3                   search more between two minima of the same command without this
  landscape surface lj 7 --from seven.landscape            begin with known points, here those of another run
  landscape surface lj 7 --search adelm -o adelm.landscape attraction–diffusion alone, as published
  landscape surface --command "python3 my_energy.py" --region=-1.5:1,-0.3:1.8
                                                           your own energy, starts drawn from this box

Your program reads one line of JSON for each point and answers with one line (docs/external_energy.md has a full example):
  it reads from standard input      {"x": [0.5, -1.25]}
  it writes to standard output      {"energy": 3.5, "gradient": [0.25, -1.0]}   or {"energy": null} outside the domain
If "gradient" is missing, it is computed by differences. One copy of the program runs on each thread.

Writes the files of `landscape build` and stationary.parquet, which contains all minima and saddles with their curvatures;
min.data, ts.data, points.min and points.ts are for PATHSAMPLE. report.html shows everything in a browser
(--no-report leaves it out). An interrupted run continues where it stopped when the same command is given again;
--resume demands this, and --fresh starts over."#;

/// Returns the error of the energy, if any.
type Check<'a> = dyn Fn() -> anyhow::Result<()> + Sync + 'a;

pub(super) fn run(command: &Surface, common: &Common) -> anyhow::Result<()> {
    let started = Instant::now();
    for (flag, value) in [
        ("patience", command.patience),
        ("searches", command.searches),
    ] {
        if let Some(value) = value {
            within(&format!("--{flag}"), SEARCHES, value as f64)?;
        }
    }
    command.families.checked()?;
    command.extent.checked()?;
    // Which minima there are is known after the search.
    command.pair(usize::MAX)?;
    command.check_connect(command.extent.is_lowest())?;
    if let Some(output) = &command.output {
        check_place(output)?;
    }
    let configuration = SurfaceConfiguration::read(command.config.as_deref())?;
    let region = command.region.as_deref().map(region).transpose()?;
    match &command.command {
        None => run_model(command, common, &configuration, region, started),
        Some(program) => {
            let region = region.context("--command needs --region")?;
            run_program(command, common, &configuration, (program, region), started)
        }
    }
}

fn run_model(
    command: &Surface,
    common: &Common,
    configuration: &SurfaceConfiguration,
    region: Option<Region>,
    started: Instant,
) -> anyhow::Result<()> {
    let surface = model::named(&command.model)?;
    let needed = surface.low.len();
    let (low, high) = region.unwrap_or((surface.low, surface.high));
    ensure!(
        low.len() == needed,
        "--region: `{}` has {needed} coordinates, not {}",
        surface.name,
        low.len()
    );
    let subject = Subject {
        name: &surface.name,
        energy: &*surface.energy,
        coordinates: surface.coordinates.to_owned(),
        low,
        high,
        source: Source {
            name: surface.name.clone(),
            content_hash: content_hash(&[surface.name.as_bytes()]),
        },
    };
    let sought = Sought {
        shown: &subject,
        unrolled: None,
        started,
    };
    map(command, common, configuration, &sought, &|| Ok(()))
}

fn run_program(
    command: &Surface,
    common: &Common,
    configuration: &SurfaceConfiguration,
    (program, (low, high)): (&str, Region),
    started: Instant,
) -> anyhow::Result<()> {
    let external = program::start(command, program, (&low, &high))?;
    let subject = Subject {
        name: program,
        energy: &external,
        coordinates: program::kind(command)?.name(),
        low,
        high,
        source: Source {
            name: program.to_owned(),
            content_hash: command_hash(program),
        },
    };
    let check = || program::check(&external);
    let mut sought = Sought {
        shown: &subject,
        unrolled: None,
        started,
    };
    if command.coordinates != Coordinates::Box {
        return map(command, common, configuration, &sought, &check);
    }
    let (low, high) = (subject.low.clone(), subject.high.clone());
    let boxed = InBox::new(&low, &high, |x, gradient| external.evaluate(x, gradient));
    let point = |u: &[f64]| boxed.point(u);
    let coordinates = |x: &[f64]| boxed.coordinates(x);
    let unrolled = Unrolled {
        energy: &boxed,
        region: boxed.region(),
        point: &point,
        coordinates: &coordinates,
    };
    sought.unrolled = Some(&unrolled);
    map(command, common, configuration, &sought, &check)
}

/// What is searched, and since when.
struct Sought<'a> {
    shown: &'a Subject<'a>,
    /// The subject as the search sees it, if it is a box.
    unrolled: Option<&'a Unrolled<'a>>,
    started: Instant,
}

impl<'a> Sought<'a> {
    /// The subject as the search sees it.
    fn subject(&self) -> Subject<'a> {
        let mut subject = self.shown.clone();
        if let Some(unrolled) = self.unrolled {
            subject.energy = unrolled.energy;
            (subject.low, subject.high) = unrolled.region.clone();
        }
        subject
    }

    /// Moves points of the user onto the space of the search.
    fn fit(&self, known: &mut [Vec<f64>]) -> anyhow::Result<()> {
        for (row, point) in known.iter_mut().enumerate() {
            match self.unrolled {
                Some(unrolled) => *point = (unrolled.coordinates)(point),
                None => onto(self.shown.energy.space(), point),
            }
            ensure!(
                point.iter().all(|number| number.is_finite()),
                "--from: point {} is not a quaternion, since its length is 0",
                row + 1
            );
        }
        Ok(())
    }
}

/// A box as the search sees it.
struct Unrolled<'a> {
    energy: &'a dyn Energy,
    region: Region,
    point: &'a dyn Fn(&[f64]) -> Vec<f64>,
    coordinates: &'a dyn Fn(&[f64]) -> Vec<f64>,
}

fn map(
    command: &Surface,
    common: &Common,
    configuration: &SurfaceConfiguration,
    sought: &Sought<'_>,
    check: &Check<'_>,
) -> anyhow::Result<()> {
    let &Sought {
        shown,
        unrolled,
        started,
    } = sought;
    let enough = |share: f64| {
        let over = |budget: Duration| started.elapsed() >= budget.mul_f64(share);
        command.extent.budget().is_some_and(over)
    };
    if command.extent.is_adelm() {
        return adelm::map(command, common, configuration, sought, check);
    }
    let subject = &sought.subject();
    let (mut known, known_hash) = command.extent.known(subject.low.len())?;
    sought.fit(&mut known)?;
    let draw = in_region(subject.energy.space(), (&subject.low, &subject.high));
    let measuring = Counted::new(subject.energy);
    // The seed also draws the points at which the surface is measured.
    let seed = command.seed.or(configuration.seed()).unwrap_or(0);
    let measured = SearchSettings::measured(&measuring, &draw, seed);
    check()?;
    let settings = searching(command, configuration, measured)?;
    let mut probed = 0;
    let usual = configuration.lowest(LowestSettings::default())?;
    let lowest = command.extent.settings(&settings, &usual, || {
        let probe = probe_size(subject.energy, &draw, &settings, &enough);
        probed = probe.evaluations as u64;
        probe
    });
    check()?;
    command.check_connect(lowest.is_some())?;

    let work = Work {
        output: output_of(command, subject),
        fingerprint: content_hash(&[
            subject.source.content_hash.as_bytes(),
            subject.coordinates.as_bytes(),
            format!("{:?}", (&subject.low, &subject.high)).as_bytes(),
            serde_json::to_string(&(&settings, &lowest))?.as_bytes(),
            known_hash.as_bytes(),
            env!("CARGO_PKG_VERSION").as_bytes(),
        ]),
        enough: &enough,
        check,
    };
    let mut families = configuration.families(FamilySettings::of_saddles())?;
    families.barrier = command.families.family_barrier.or(families.barrier);
    explain(|| {
        format!(
            "the {} is searched for",
            if lowest.is_some() {
                "lowest part"
            } else {
                "whole"
            }
        )
    });
    if let (Some(note), false) = (command.extent.unused(lowest.is_none()), common.quiet) {
        complain(&note);
    }
    // The usual limit decides what is searched for, and an interrupted run may go on with a time or without.
    let settings = command.without_limit(settings, configuration);
    let search = SurfaceSearch {
        settings: &settings,
        lowest: lowest.as_ref(),
        known: &known,
        pair: command.pair(usize::MAX)?,
    };
    let (mut searched, begun) = work.run(command, common, |run| {
        search_surface(subject, &search, &families, run)
    })?;
    command.check_names(&searched)?;
    if let Some(unrolled) = unrolled {
        searched.shown_as(unrolled.point, shown, &settings);
        check()?;
    }
    let report = SurfaceReport {
        subject: shown,
        found: &searched.found,
        landscape: &searched.landscape,
        settings: &settings,
        lowest: searched.lowest.as_ref(),
        command: common.provenance.command.clone(),
        measuring: measuring.evaluations() + probed,
    };
    let written = report.write(&begun.unfinished.folder)?;
    begun.conclude(command, common, written, &searched.landscape.attempts.list)
}

/// A search that can be interrupted.
struct Work<'a> {
    output: PathBuf,
    fingerprint: String,
    enough: &'a (dyn Fn(f64) -> bool + Sync),
    check: &'a Check<'a>,
}

/// A search that has begun, whose folder lacks its final name.
struct Begun {
    output: PathBuf,
    unfinished: Unfinished,
    watch: Watch,
}

impl Work<'_> {
    /// Begins or continues the search. If it finds nothing to map, nothing is left of it.
    fn run<T>(
        self,
        command: &Surface,
        common: &Common,
        search: impl FnOnce(&StudyRun<'_>) -> Result<T, StudyError>,
    ) -> anyhow::Result<(T, Begun)> {
        let Self {
            output,
            fingerprint,
            enough,
            check,
        } = self;
        check_resumable(&command.again, std::slice::from_ref(&output))?;
        let unfinished = Unfinished::open(&output, &fingerprint, &command.again, common.quiet)?;
        let watch = Watch::new(common.quiet);
        let run = StudyRun {
            run: Run {
                journal: &GuardedJournal {
                    journal: &unfinished.journal,
                    check: &|| {
                        interruption::check()?;
                        Ok(check().map_err(Box::<dyn Error + Send + Sync>::from)?)
                    },
                },
                observer: &|news| watch.see(news),
                enough,
            },
            stage_ended: &|name, evaluations| watch.lap(name, evaluations),
        };
        let found = search(&run);
        check()?;
        match found {
            Err(error @ (StudyError::NoMinimum { .. } | StudyError::OneMinimumOfSurface(_))) => {
                unfinished.discard()?;
                Err(error.into())
            }
            found => {
                let found = found?;
                let begun = Begun {
                    output,
                    unfinished,
                    watch,
                };
                Ok((found, begun))
            }
        }
    }
}

impl Begun {
    /// Writes the page and gives the folder its final name.
    fn conclude(
        self,
        command: &Surface,
        common: &Common,
        written: WrittenLandscape,
        attempts: &[Attempt],
    ) -> anyhow::Result<()> {
        if !command.page.no_report {
            report::write_surface(&self.unfinished.folder, &written, attempts, common)?;
        }
        self.unfinished.conclude(self.watch, |_| written.text)?;
        print_landscapes(common, &[self.output])
    }
}

/// The settings of the search: as measured, but as the file and the flags say.
fn searching(
    command: &Surface,
    configuration: &SurfaceConfiguration,
    measured: SearchSettings,
) -> anyhow::Result<SearchSettings> {
    let seed = measured.seed;
    let mut settings = configuration.search(measured)?;
    settings.seed = seed;
    settings.patience = command.patience.unwrap_or(settings.patience);
    settings.max_searches = command.searches.unwrap_or(settings.max_searches);
    explain_settings("settings of the search", &settings);
    Ok(settings)
}

/// The folder to write.
fn output_of(command: &Surface, subject: &Subject<'_>) -> PathBuf {
    let named = || PathBuf::from(format!("{}.landscape", file_name(subject.name)));
    command.output.clone().unwrap_or_else(named)
}

fn file_name(name: &str) -> String {
    let parts = name.split(|c: char| !c.is_alphanumeric() && c != '.');
    let parts: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
    parts.join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_file_names() {
        assert_eq!(file_name("lj 7"), "lj-7");
        assert_eq!(
            file_name("python3 ./a b/my_energy.py"),
            "python3-.-a-b-my-energy.py"
        );
    }
}
