//! Reading `min.data` and `ts.data`.

use std::collections::{BTreeMap, BTreeSet};

use super::{Database, MinimumEntry, TransitionStateEntry, Vibrations};
use crate::printable::counted;

/// The program whose layout the files have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Six and eight columns, or more.
    Pathsample,
    /// Two and three columns.
    Topsearch,
}

impl Layout {
    /// The name of the program.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pathsample => "PATHSAMPLE",
            Self::Topsearch => "topsearch",
        }
    }
}

/// An error in a `min.data` or `ts.data`. Lines and fields are counted from 1.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages show the fields")]
pub enum ExchangeError {
    /// A line has a number of columns that no layout has.
    #[error(
        "{file}, line {line}: it has {found} fields, but a line has {} or more (PATHSAMPLE) or {} (topsearch)",
        .expected[0],
        .expected[1]
    )]
    Fields {
        /// `min.data` or `ts.data`.
        file: &'static str,
        line: usize,
        found: usize,
        /// Number of fields in the layouts of PATHSAMPLE and topsearch.
        expected: [usize; 2],
    },
    /// A line has another layout than the first line of `min.data`.
    #[error(
        "{file}, line {line}: it has the layout of {} ({found} fields), but min.data begins with that of {}",
        .layout.name(),
        .first.name()
    )]
    Mixed {
        /// `min.data` or `ts.data`.
        file: &'static str,
        line: usize,
        found: usize,
        layout: Layout,
        /// Layout of the first line of `min.data`.
        first: Layout,
    },
    /// A field has an invalid value.
    #[error("{file}, line {line}, field {field}: `{text}` is not {expected}")]
    Field {
        /// `min.data` or `ts.data`.
        file: &'static str,
        line: usize,
        field: usize,
        text: String,
        expected: &'static str,
    },
    /// The number of a minimum occurs twice.
    #[error("{file}, line {line}, field {field}: minimum {number} is already on line {first}")]
    Twice {
        /// `min.data`.
        file: &'static str,
        line: usize,
        field: usize,
        number: usize,
        /// Line of the first occurrence.
        first: usize,
    },
    /// A transition state joins a minimum that does not exist.
    #[error(
        "{file}, line {line}, field {field}: minimum {number} is not in min.data, which lists {}, counted from {from}",
        counted(*count, "minimum")
    )]
    NoSuchMinimum {
        /// `ts.data`.
        file: &'static str,
        line: usize,
        field: usize,
        number: usize,
        /// Number of minima in `min.data`.
        count: usize,
        /// Number of the first minimum.
        from: usize,
    },
    /// A transition state is lower than a minimum that it joins, by more than rounding.
    #[error(
        "{file}, line {line}, field {field}: the energy {energy} lies below that of minimum {number} ({minimum}, line \
         {minimum_line} of min.data), which this transition state joins"
    )]
    BelowMinimum {
        /// `ts.data`.
        file: &'static str,
        line: usize,
        /// Number of the field that holds the energy.
        field: usize,
        energy: f64,
        number: usize,
        minimum: f64,
        minimum_line: usize,
    },
    /// The file holds no minima.
    #[error("{0} contains no minima")]
    Empty(&'static str),
}

/// What is to be known of `min.data` without `ts.data`, which a search writes that has found no transition state yet.
pub const NO_TRANSITION_STATES: &str =
    "ts.data is missing, so no minimum is joined to another one, and each is a tree of its own";

const MINIMA: &str = "min.data";
const STATES: &str = "ts.data";

/// A transition state may lie below a minimum by this fraction of the range of energies: files hold rounded numbers.
const ROUNDING: f64 = 1e-9;

/// It may also lie below by one unit of its last digit, if it is written with at least this many decimals and therefore
/// looks rounded. topsearch writes five.
const DECIMALS: i32 = 3;

/// A number of Fortran as Rust spells it, in small letters. Fortran writes `D` for `E`, and no letter at all before an exponent
/// of three digits (`0.12-103`); its mantissa is then less than 10.
fn rust_number(text: &str) -> String {
    let text = text.to_ascii_lowercase().replace('d', "e");
    let sign = text.rfind(['-', '+']).filter(|at| *at > 0);
    let bare = sign
        .map(|at| text.split_at(at))
        .filter(|(mantissa, exponent)| {
            let digits = &exponent[1..];
            digits.len() == 3
                && digits.bytes().all(|digit| digit.is_ascii_digit())
                && mantissa.contains('.')
                && mantissa.parse().is_ok_and(|value: f64| value.abs() < 10.0)
        });
    match bare {
        Some((mantissa, exponent)) => format!("{mantissa}e{exponent}"),
        None => text,
    }
}

/// The unit of the last digit of a number, such as 10⁻⁵ for `-1.03163`; 0 if it has few decimals.
fn last_digit(number: &str) -> f64 {
    let number = rust_number(number);
    let (digits, exponent) = number.split_once('e').unwrap_or((&number, "0"));
    let decimals = digits.split_once('.').map_or(0, |(_, decimals)| {
        i32::try_from(decimals.len()).unwrap_or(i32::MAX)
    });
    match exponent.parse::<i32>() {
        Ok(exponent) if decimals >= DECIMALS => {
            libm::pow(10.0, f64::from(exponent) - f64::from(decimals))
        }
        _ => 0.0,
    }
}

/// What `min.data` and `ts.data` hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Minima and transition states.
    pub database: Database,
    /// The program whose layout the files have.
    pub layout: Layout,
    /// What was ignored or changed, a sentence each, without capital and full stop.
    pub notes: Vec<String>,
}

impl Database {
    /// As [`Database::read`], without its notes.
    ///
    /// # Errors
    /// As [`Database::read`].
    pub fn parse(min_data: &str, ts_data: &str) -> Result<(Self, Layout), ExchangeError> {
        let read = Self::read(min_data, ts_data)?;
        Ok((read.database, read.layout))
    }

    /// Reads `min.data` and `ts.data` in either layout. Empty lines are skipped; Fortran exponents (`1.5D-3`,
    /// `0.15-103`) are read.
    /// Columns beyond those of PATHSAMPLE's layout are ignored. A transition state that lies below a minimum by at most
    /// 10⁻⁹ of the range of all energies, or by one unit of its last digit where it has three decimals or more, is raised to
    /// it. Rows that hold the placeholders have no vibrational data.
    ///
    /// # Errors
    /// If a line or field is invalid, or if a transition state is lower than a minimum that it joins.
    pub fn read(min_data: &str, ts_data: &str) -> Result<Reading, ExchangeError> {
        let mut database = Self::default();
        let mut wide = BTreeSet::new();
        let mut rows = Rows::new();
        let mut first = None;
        for (row, line) in lines(min_data, MINIMA).enumerate() {
            let layout = line.layout([6, 2], &mut first)?;
            wide.extend(line.has_more_than(6).then_some(MINIMA));
            let (number, energy, vibrations) = match layout {
                Layout::Pathsample => {
                    let vibrations = line.vibrations([1, 2, 3])?;
                    (row + 1, line.number(0)?, vibrations)
                }
                Layout::Topsearch => (line.whole(0)?, line.number(1)?, None),
            };
            if let Some((_, first)) = rows.insert(number, (row, line.number)) {
                let (file, line, field) = (MINIMA, line.number, 1);
                return Err(ExchangeError::Twice {
                    file,
                    line,
                    field,
                    number,
                    first,
                });
            }
            database.minima.push(MinimumEntry { energy, vibrations });
        }
        let Some(layout) = first else {
            return Err(ExchangeError::Empty(MINIMA));
        };
        let slack = ROUNDING * database.range_with(ts_data, layout);
        let mut raised = 0_usize;
        for line in lines(ts_data, STATES) {
            line.layout([8, 3], &mut first)?;
            wide.extend(line.has_more_than(8).then_some(STATES));
            let (state, lifted) = line.state(layout, (&database.minima, &rows), slack)?;
            database.transition_states.push(state);
            raised += usize::from(lifted);
        }
        let mut notes: Vec<String> = (wide.into_iter())
            .map(|file| {
                format!(
                    "{file} has more columns than are supported, and the last ones were ignored"
                )
            })
            .collect();
        if raised > 0 {
            notes.push(format!(
                "transition states that lay below a minimum that they join, by no more than rounding, were raised to it: {raised}"
            ));
        }
        Ok(Reading {
            database,
            layout,
            notes,
        })
    }

    /// The greatest difference between energies of these minima and of `ts_data`; 0 if it is no number. Lines with faults
    /// are left out, and told later.
    fn range_with(&self, ts_data: &str, layout: Layout) -> f64 {
        let height = match layout {
            Layout::Pathsample => 0,
            Layout::Topsearch => 2,
        };
        let states = lines(ts_data, STATES)
            .filter(|line| line.has_more_than(height))
            .filter_map(|line| line.number(height).ok());
        let energies = self.minima.iter().map(|minimum| minimum.energy);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for energy in energies.chain(states) {
            (low, high) = (low.min(energy), high.max(energy));
        }
        Some(high - low)
            .filter(|range| range.is_finite())
            .unwrap_or(0.0)
    }
}

/// Row of each minimum by its number in the file, and its line.
type Rows = BTreeMap<usize, (usize, usize)>;

struct Line<'a> {
    file: &'static str,
    number: usize,
    fields: Vec<&'a str>,
}

fn lines<'a>(text: &'a str, file: &'static str) -> impl Iterator<Item = Line<'a>> {
    let lines = text.lines().enumerate().map(move |(row, text)| Line {
        file,
        number: row + 1,
        fields: text.split_whitespace().collect(),
    });
    lines.filter(|line| !line.fields.is_empty())
}

impl Line<'_> {
    fn has_more_than(&self, fields: usize) -> bool {
        self.fields.len() > fields
    }

    /// The layout of a line by its number of fields. It must be the layout of the `first` line.
    fn layout(
        &self,
        expected: [usize; 2],
        first: &mut Option<Layout>,
    ) -> Result<Layout, ExchangeError> {
        let (file, line, found) = (self.file, self.number, self.fields.len());
        let layout = if found >= expected[0] {
            Layout::Pathsample
        } else if found == expected[1] {
            Layout::Topsearch
        } else {
            return Err(ExchangeError::Fields {
                file,
                line,
                found,
                expected,
            });
        };
        let first = *first.get_or_insert(layout);
        if layout == first {
            Ok(layout)
        } else {
            Err(ExchangeError::Mixed {
                file,
                line,
                found,
                layout,
                first,
            })
        }
    }

    fn wrong(&self, field: usize, expected: &'static str) -> ExchangeError {
        ExchangeError::Field {
            file: self.file,
            line: self.number,
            field: field + 1,
            text: self.fields[field].to_owned(),
            expected,
        }
    }

    fn number(&self, field: usize) -> Result<f64, ExchangeError> {
        let number = rust_number(self.fields[field])
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.wrong(field, "a finite number"))
    }

    fn whole(&self, field: usize) -> Result<usize, ExchangeError> {
        let number = self.fields[field].parse().ok();
        number.ok_or_else(|| self.wrong(field, "the number of a minimum"))
    }

    /// Reads a transition state between `minima`, and tells whether it was raised to one of them, from at most `slack` below.
    fn state(
        &self,
        layout: Layout,
        (minima, rows): (&[MinimumEntry], &Rows),
        slack: f64,
    ) -> Result<(TransitionStateEntry, bool), ExchangeError> {
        let ([a, b], height, vibrations) = match layout {
            Layout::Pathsample => ([3, 4], 0, self.vibrations([1, 2, 5])?),
            Layout::Topsearch => ([0, 1], 2, None),
        };
        let energy = self.number(height)?;
        // Rounding to nearest moves both energies by half a unit, and the difference of two decimal numbers is inexact.
        let slack = slack.max(1.001 * last_digit(self.fields[height]));
        let end = |field: usize| {
            let number = self.whole(field)?;
            let Some((row, minimum_line)) = rows.get(&number).copied() else {
                return Err(ExchangeError::NoSuchMinimum {
                    file: STATES,
                    line: self.number,
                    field: field + 1,
                    number,
                    count: rows.len(),
                    from: usize::from(layout == Layout::Pathsample),
                });
            };
            let minimum = minima[row].energy;
            if energy < minimum - slack {
                return Err(ExchangeError::BelowMinimum {
                    file: STATES,
                    line: self.number,
                    field: height + 1,
                    energy,
                    number,
                    minimum,
                    minimum_line,
                });
            }
            Ok(row)
        };
        let ends = [end(a)?, end(b)?];
        let highest = ends.map(|end| minima[end].energy);
        let highest = highest[0].max(highest[1]);
        let state = TransitionStateEntry {
            energy: energy.max(highest),
            ends,
            vibrations,
        };
        Ok((state, energy < highest))
    }

    /// Reads the vibrational data; `None` if they are the placeholders. The arguments are the fields of the ln-product, the
    /// order and the first moment.
    fn vibrations(
        &self,
        [product, order, moments]: [usize; 3],
    ) -> Result<Option<Vibrations>, ExchangeError> {
        let operations = self.fields[order].parse().ok().filter(|order| *order > 0);
        let [a, b, c] = [0, 1, 2].map(|k| self.number(moments + k));
        let read = Vibrations {
            log_product: self.number(product)?,
            point_group_order: operations
                .ok_or_else(|| self.wrong(order, "a whole number of operations, 1 or more"))?,
            moments_of_inertia: [a?, b?, c?],
            negative_curvature: None,
        };
        Ok((!read.looks_unknown()).then_some(read))
    }
}
