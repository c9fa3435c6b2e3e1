//! Reading `min.data` and `ts.data`.

use std::collections::BTreeMap;

use super::{Database, MinimumEntry, TransitionStateEntry, Vibrations};

/// Who wrote the files.
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

/// Why a `min.data` or `ts.data` cannot be read. Lines and fields count from 1.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExchangeError {
    /// A line has no layout's number of columns.
    #[error(
        "{file}, line {line}: {found} fields, but a line has {} (PATHSAMPLE) or {} (topsearch)",
        .expected[0],
        .expected[1]
    )]
    Fields {
        /// `min.data` or `ts.data`.
        file: &'static str,
        /// Number of the line.
        line: usize,
        /// Fields on it.
        found: usize,
        /// Fields of PATHSAMPLE and of topsearch.
        expected: [usize; 2],
    },
    /// A line is of another layout than the first of `min.data`.
    #[error(
        "{file}, line {line}: the layout of {} ({found} fields), but min.data begins in that of {}",
        .layout.name(),
        .first.name()
    )]
    Mixed {
        /// `min.data` or `ts.data`.
        file: &'static str,
        /// Number of the line.
        line: usize,
        /// Fields on it.
        found: usize,
        /// Whose layout that is.
        layout: Layout,
        /// Whose layout `min.data` begins in.
        first: Layout,
    },
    /// A field is not what it should be.
    #[error("{file}, line {line}, field {field}: `{text}` is not {expected}")]
    Field {
        /// `min.data` or `ts.data`.
        file: &'static str,
        /// Number of the line.
        line: usize,
        /// Number of the field.
        field: usize,
        /// What it holds.
        text: String,
        /// What it should be.
        expected: &'static str,
    },
    /// A number of a minimum that occurs twice.
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
        /// Where it occurred first.
        first: usize,
    },
    /// A transition state of a minimum that is not there.
    #[error(
        "{file}, line {line}, field {field}: there is no minimum {number} in min.data, which holds {count} counted from {from}"
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
        /// Minima in `min.data`.
        count: usize,
        /// Number of the first.
        from: usize,
    },
    /// A transition state lies lower than a minimum that it joins.
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
    /// There is nothing to read.
    #[error("{file} holds no minima")]
    Empty {
        /// `min.data`.
        file: &'static str,
    },
}

const MINIMA: &str = "min.data";
const STATES: &str = "ts.data";

impl Database {
    /// Reads the text of a `min.data` and of its `ts.data`, of either layout. Empty lines are skipped; numbers may have
    /// Fortran's exponents (`1.5D-3`).
    ///
    /// # Errors
    /// If a line or a field does not fit: which, of which file, and what would. If a transition state lies below a minimum
    /// that it joins: no surface has one.
    pub fn parse(min_data: &str, ts_data: &str) -> Result<(Self, Layout), ExchangeError> {
        let mut database = Self::default();
        // Row of each minimum by its number in the file, and the line where it stands.
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
            return Err(ExchangeError::Empty { file: MINIMA });
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

/// A line that is not empty.
struct Line<'a> {
    file: &'static str,
    number: usize,
    fields: Vec<&'a str>,
}

/// The lines of a file that are not empty.
fn lines<'a>(text: &'a str, file: &'static str) -> impl Iterator<Item = Line<'a>> {
    let lines = text.lines().enumerate().map(move |(row, text)| Line {
        file,
        number: row + 1,
        fields: text.split_whitespace().collect(),
    });
    lines.filter(|line| !line.fields.is_empty())
}

impl Line<'_> {
    /// The layout of a line with as many fields as PATHSAMPLE's or topsearch's, which must be that of the `first` line.
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

    /// Numbers of the fields of the ln-product, of the order and of the first moment.
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
        })
    }
}
