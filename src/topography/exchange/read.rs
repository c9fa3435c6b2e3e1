//! Reading `min.data` and `ts.data`.

use std::collections::BTreeMap;

use super::{Database, MinimumEntry, TransitionStateEntry, Vibrations};

/// The program whose layout the files have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Six and eight columns.
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
pub enum ExchangeError {
    /// A line has a number of columns that no layout has.
    #[error(
        "{file}, line {line}: it has {found} fields, but a line has {} (PATHSAMPLE) or {} (topsearch)",
        .expected[0],
        .expected[1]
    )]
    Fields {
        /// `min.data` or `ts.data`.
        file: &'static str,
        /// Number of the line.
        line: usize,
        /// Number of fields on it.
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
        /// Number of the line.
        line: usize,
        /// Number of fields on it.
        found: usize,
        /// Layout of this line.
        layout: Layout,
        /// Layout of the first line of `min.data`.
        first: Layout,
    },
    /// A field has an invalid value.
    #[error("{file}, line {line}, field {field}: `{text}` is not {expected}")]
    Field {
        /// `min.data` or `ts.data`.
        file: &'static str,
        /// Number of the line.
        line: usize,
        /// Number of the field.
        field: usize,
        /// Text of the field.
        text: String,
        /// Description of a valid value.
        expected: &'static str,
    },
    /// The number of a minimum occurs twice.
    #[error("{file}, line {line}, field {field}: minimum {number} is already on line {first}")]
    Twice {
        /// `min.data`.
        file: &'static str,
        /// Number of the line.
        line: usize,
        /// Number of the field.
        field: usize,
        /// The number of the minimum.
        number: usize,
        /// Line of the first occurrence.
        first: usize,
    },
    /// A transition state joins a minimum that does not exist.
    #[error(
        "{file}, line {line}, field {field}: there is no minimum {number} in min.data, which holds {count} minima, \
         counted from {from}"
    )]
    NoSuchMinimum {
        /// `ts.data`.
        file: &'static str,
        /// Number of the line.
        line: usize,
        /// Number of the field.
        field: usize,
        /// The number of the minimum.
        number: usize,
        /// Number of minima in `min.data`.
        count: usize,
        /// Number of the first minimum.
        from: usize,
    },
    /// A transition state is lower than a minimum that it joins.
    #[error(
        "{file}, line {line}, field {field}: the energy {energy} lies below that of minimum {number} ({minimum}, line \
         {minimum_line} of min.data), which this transition state joins"
    )]
    BelowMinimum {
        /// `ts.data`.
        file: &'static str,
        /// Number of the line.
        line: usize,
        /// Number of the field that holds the energy.
        field: usize,
        /// The energy of the transition state.
        energy: f64,
        /// The number of the minimum.
        number: usize,
        /// Its energy.
        minimum: f64,
        /// Number of its line.
        minimum_line: usize,
    },
    /// The file holds no minima.
    #[error("{0} holds no minima")]
    Empty(&'static str),
}

const MINIMA: &str = "min.data";
const STATES: &str = "ts.data";

impl Database {
    /// Reads `min.data` and `ts.data` in either layout. Empty lines are skipped; Fortran exponents (`1.5D-3`) are read.
    ///
    /// # Errors
    /// If a line or field is invalid, or if a transition state is lower than a minimum that it joins.
    pub fn parse(min_data: &str, ts_data: &str) -> Result<(Self, Layout), ExchangeError> {
        let mut database = Self::default();
        // Row of each minimum by its number in the file, and its line.
        let mut rows: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
        let mut first = None;
        for (row, line) in lines(min_data, MINIMA).enumerate() {
            let layout = line.layout([6, 2], &mut first)?;
            let (number, energy, vibrations) = match layout {
                Layout::Pathsample => {
                    let vibrations = line.vibrations([1, 2, 3])?;
                    (row + 1, line.number(0)?, Some(vibrations))
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
        for line in lines(ts_data, STATES) {
            line.layout([8, 3], &mut first)?;
            let ([a, b], height, vibrations) = match layout {
                Layout::Pathsample => ([3, 4], 0, Some(line.vibrations([1, 2, 5])?)),
                Layout::Topsearch => ([0, 1], 2, None),
            };
            let energy = line.number(height)?;
            let end = |field: usize| {
                let number = line.whole(field)?;
                let Some((row, minimum_line)) = rows.get(&number).copied() else {
                    return Err(ExchangeError::NoSuchMinimum {
                        file: STATES,
                        line: line.number,
                        field: field + 1,
                        number,
                        count: rows.len(),
                        from: usize::from(layout == Layout::Pathsample),
                    });
                };
                let minimum = database.minima[row].energy;
                if energy < minimum {
                    return Err(ExchangeError::BelowMinimum {
                        file: STATES,
                        line: line.number,
                        field: height + 1,
                        energy,
                        number,
                        minimum,
                        minimum_line,
                    });
                }
                Ok(row)
            };
            database.transition_states.push(TransitionStateEntry {
                energy,
                ends: [end(a)?, end(b)?],
                vibrations,
            });
        }
        Ok((database, layout))
    }
}

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
    /// The layout of a line by its number of fields. It must be the layout of the `first` line.
    fn layout(
        &self,
        expected: [usize; 2],
        first: &mut Option<Layout>,
    ) -> Result<Layout, ExchangeError> {
        let (file, line, found) = (self.file, self.number, self.fields.len());
        let layout = match expected.iter().position(|count| *count == found) {
            Some(0) => Layout::Pathsample,
            Some(_) => Layout::Topsearch,
            None => {
                return Err(ExchangeError::Fields {
                    file,
                    line,
                    found,
                    expected,
                });
            }
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
        let text = self.fields[field].replace(['D', 'd'], "e");
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.wrong(field, "a finite number"))
    }

    fn whole(&self, field: usize) -> Result<usize, ExchangeError> {
        let number = self.fields[field].parse().ok();
        number.ok_or_else(|| self.wrong(field, "the number of a minimum"))
    }

    /// Reads the vibrational data. The arguments are the fields of the ln-product, the order and the first moment.
    fn vibrations(
        &self,
        [product, order, moments]: [usize; 3],
    ) -> Result<Vibrations, ExchangeError> {
        let operations = self.fields[order].parse().ok().filter(|order| *order > 0);
        let [a, b, c] = [0, 1, 2].map(|k| self.number(moments + k));
        Ok(Vibrations {
            log_product: self.number(product)?,
            point_group_order: operations
                .ok_or_else(|| self.wrong(order, "a whole number of operations, 1 or more"))?,
            moments_of_inertia: [a?, b?, c?],
            negative_curvature: None,
        })
    }
}
