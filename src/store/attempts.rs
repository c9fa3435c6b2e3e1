//! `attempts.parquet`: the chains and geodesics that were tried between minima, and what each of them found.
//!
//! A row is an attempt to join minima `a` and `b`. `start` is `forward` or `backward` for a chain from a to b or from b to a,
//! and `straight` or `round` for the geodesics. `barrier` is the raw barrier of the chain, or the least height of the roughly
//! relaxed straight line. `found_a`, `found_b` and `found_height` list the passes on the path relaxed from it. The support
//! of merges follows from these rows, and `landscape build --onto` needs them.

use std::path::Path;

use super::atomic::AtomicFolder;
use super::columns::Columns;
use super::error::{Fault, StoreError};
use super::landscape::{has_table, read_table, table_head};
use super::row::{self, Column, columns};
use crate::topography::{Attempt, MinimumId, Start};

const ATTEMPTS: &str = "attempts.parquet";

#[derive(Debug, Clone, PartialEq, Default)]
struct AttemptRow {
    a: u64,
    b: u64,
    start: String,
    barrier: Option<f64>,
    found_a: Vec<u64>,
    found_b: Vec<u64>,
    found_height: Vec<f64>,
}

const COLUMNS: &[Column<AttemptRow>] =
    columns![a, b, start, barrier, found_a, found_b, found_height];

impl From<&Attempt> for AttemptRow {
    fn from(attempt: &Attempt) -> Self {
        let ends = |end: fn(&(MinimumId, MinimumId, f64)) -> MinimumId| {
            let found = attempt.found.iter();
            found.map(|found| end(found).0 as u64).collect()
        };
        Self {
            a: attempt.from.0 as u64,
            b: attempt.to.0 as u64,
            start: match attempt.start {
                Start::Chain {
                    backward: false, ..
                } => "forward",
                Start::Chain { backward: true, .. } => "backward",
                Start::Straight => "straight",
                Start::Round => "round",
            }
            .to_owned(),
            barrier: attempt.barrier,
            found_a: ends(|found| found.0),
            found_b: ends(|found| found.1),
            found_height: attempt.found.iter().map(|found| found.2).collect(),
        }
    }
}

/// Writes the attempts, if there are any. Equal attempts give equal bytes.
///
/// # Errors
/// If a number is not finite, or the folder cannot be written.
pub fn write_attempts(attempts: &[Attempt], folder: &AtomicFolder) -> Result<(), StoreError> {
    if attempts.is_empty() {
        return Ok(());
    }
    let rows: Vec<AttemptRow> = attempts.iter().map(AttemptRow::from).collect();
    let mut columns = Columns::default();
    row::write(COLUMNS, &rows, &mut columns);
    let path = folder.path().join(ATTEMPTS);
    folder.write(ATTEMPTS, &columns.encode(&path, &table_head(ATTEMPTS))?)
}

/// Reads the attempts of a finished landscape with `minima` minima. There are none if the folder has no such table.
///
/// # Errors
/// If the table is damaged, altered, or of another landscape, version or set of minima.
pub fn read_attempts(folder: &Path, minima: usize) -> Result<Vec<Attempt>, StoreError> {
    if !has_table(folder, ATTEMPTS)? {
        return Ok(Vec::new());
    }
    let table = read_table(folder, ATTEMPTS)?;
    let mut rows = vec![AttemptRow::default(); table.rows];
    row::read(COLUMNS, &table, &mut rows)?;
    let mut attempts: Vec<Attempt> = Vec::with_capacity(rows.len());
    for (number, row) in rows.into_iter().enumerate() {
        let unexpected = |column: &str, value: String, expected: String| {
            let column = column.to_owned();
            let fault = Fault::Unexpected {
                column,
                value,
                expected,
            };
            table.fault(number, fault)
        };
        let end = |column: &str, value: u64| {
            let known = usize::try_from(value).ok().filter(|id| *id < minima);
            let expected = || format!("one of the {minima} minima");
            let known = known.map(MinimumId);
            known.ok_or_else(|| unexpected(column, value.to_string(), expected()))
        };
        let (from, to) = (end("a", row.a)?, end("b", row.b)?);
        let start = match row.start.as_str() {
            "forward" | "backward" => {
                let backward = row.start == "backward";
                // Replicas count the chains of a pair and direction.
                let replica = match attempts.last() {
                    Some(Attempt {
                        from: a,
                        to: b,
                        start:
                            Start::Chain {
                                backward: way,
                                replica,
                            },
                        ..
                    }) if (*a, *b, *way) == (from, to, backward) => replica + 1,
                    _ => 0,
                };
                Start::Chain { backward, replica }
            }
            "straight" => Start::Straight,
            "round" => Start::Round,
            other => {
                let expected = "forward, backward, straight or round".to_owned();
                return Err(unexpected("start", other.to_owned(), expected));
            }
        };
        let lengths = [row.found_a.len(), row.found_b.len()];
        if let Some(found) = lengths
            .into_iter()
            .find(|len| *len != row.found_height.len())
        {
            let fault = Fault::Length {
                column: "found_a, found_b".to_owned(),
                found,
                expected: row.found_height.len(),
            };
            return Err(table.fault(number, fault));
        }
        let ends = row.found_a.iter().zip(&row.found_b);
        let found = ends
            .zip(&row.found_height)
            .map(|((a, b), height)| Ok((end("found_a", *a)?, end("found_b", *b)?, *height)));
        attempts.push(Attempt {
            from,
            to,
            start,
            barrier: row.barrier,
            found: found.collect::<Result<_, StoreError>>()?,
        });
    }
    Ok(attempts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::LandscapeFiles;

    #[test]
    fn attempts_come_back() {
        let attempt = |(a, b), start, barrier, found| Attempt {
            from: MinimumId(a),
            to: MinimumId(b),
            start,
            barrier,
            found,
        };
        let chain = |backward, replica| Start::Chain { backward, replica };
        let found = vec![
            (MinimumId(0), MinimumId(2), 0.4),
            (MinimumId(1), MinimumId(2), 0.1 + 0.2),
        ];
        let attempts = [
            attempt((0, 1), chain(false, 0), Some(0.5), Vec::new()),
            attempt((0, 1), chain(false, 1), None, found.clone()),
            attempt((0, 1), chain(true, 0), Some(0.6), Vec::new()),
            attempt((0, 1), Start::Straight, Some(0.7), found),
            attempt((1, 2), chain(true, 0), None, Vec::new()),
            attempt((1, 2), Start::Round, None, Vec::new()),
        ];
        let place = tempfile::tempdir().unwrap();
        let folder = AtomicFolder::open(&place.path().join("a.landscape"), false).unwrap();
        write_attempts(&attempts, &folder).unwrap();
        LandscapeFiles::default().write(&folder).unwrap();
        assert_eq!(read_attempts(folder.path(), 3).unwrap(), attempts);
        let error = read_attempts(folder.path(), 2).unwrap_err();
        assert!(error.to_string().contains("one of the 2 minima"), "{error}");
    }
}
