//! `attempts.parquet`: the searches and geodesics that were tried between minima, and what each of them found.
//!
//! A row is an attempt to join minima `a` and `b`. `start` is `forward` or `backward` for the chain of a search from a to b or
//! from b to a, and `straight` or `round` for the geodesics. `search` is the number of the search in the map (0 for a geodesic), `temperature`
//! and `force` are those of its chain, `free_temperature` is that of the free walk before it, if there was one, and `barrier` is the highest energy of the chain. `height` is that of the way that was
//! relaxed from it. The support of merges follows from these rows, and `landscape build --onto` needs them.

use std::path::Path;

use serde_json::Value;

use super::atomic::AtomicFolder;
use super::columns::Columns;
use super::error::{Fault, StoreError};
use super::landscape::{LandscapeFiles, has_table, read_table, table_head};
use super::row::{self, Column, columns};
use crate::topography::{Attempt, Attempts, MinimumId, Start};

const ATTEMPTS: &str = "attempts.parquet";

/// More searches than any map makes. Numbers of searches name random streams.
const MOST_SEARCHES: usize = 1 << 32;

#[derive(Debug, Clone, PartialEq, Default)]
struct AttemptRow {
    a: u64,
    b: u64,
    start: String,
    search: u64,
    temperature: Option<f64>,
    force: Option<f64>,
    free_temperature: Option<f64>,
    barrier: Option<f64>,
    height: Option<f64>,
}

const COLUMNS: &[Column<AttemptRow>] = columns![
    a,
    b,
    start,
    search,
    temperature,
    force,
    free_temperature,
    barrier,
    height
];

impl From<&Attempt> for AttemptRow {
    fn from(attempt: &Attempt) -> Self {
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
            search: match attempt.start {
                Start::Chain { replica, .. } => replica as u64,
                Start::Straight | Start::Round => 0,
            },
            temperature: attempt.law.map(|law| law[0]),
            force: attempt.law.map(|law| law[1]),
            free_temperature: attempt.free_temperature,
            barrier: attempt.barrier,
            height: attempt.height,
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

/// Reads the attempts of the finished landscape of `files`. There are none if the folder has no such table.
///
/// # Errors
/// If the table is damaged, altered, or of another landscape, version or set of minima.
pub fn read_attempts(folder: &Path, files: &LandscapeFiles) -> Result<Attempts, StoreError> {
    if !has_table(folder, ATTEMPTS)? {
        return Ok(Attempts::default());
    }
    let minima = files.minima.len();
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
                let number = usize::try_from(row.search).ok();
                let large = || unexpected("search", row.search.to_string(), "a number".to_owned());
                Start::Chain {
                    backward: row.start == "backward",
                    replica: number
                        .filter(|number| *number < MOST_SEARCHES)
                        .ok_or_else(large)?,
                }
            }
            "straight" => Start::Straight,
            "round" => Start::Round,
            other => {
                let expected = "forward, backward, straight or round".to_owned();
                return Err(unexpected("start", other.to_owned(), expected));
            }
        };
        attempts.push(Attempt {
            from,
            to,
            start,
            law: row.temperature.zip(row.force).map(|(t, f)| [t, f]),
            free_temperature: row.free_temperature,
            barrier: row.barrier,
            height: row.height,
        });
    }
    Ok(files.attempts(attempts))
}

impl LandscapeFiles {
    /// These attempts on this landscape, whose settings have the tolerance of heights.
    pub fn attempts(&self, list: Vec<Attempt>) -> Attempts {
        let tolerance = self.manifest.settings.pointer("/sameness/energy");
        let tolerance = tolerance.and_then(Value::as_f64).unwrap_or(0.0);
        Attempts { list, tolerance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::MinimumRow;

    #[test]
    fn attempts_come_back() {
        let attempt = |(a, b), start, law: Option<[f64; 2]>, height: Option<f64>| Attempt {
            from: MinimumId(a),
            to: MinimumId(b),
            start,
            law,
            free_temperature: law.map(|law| 2.0 * law[0]),
            barrier: height.filter(|_| law.is_some()),
            height,
        };
        let chain = |backward, replica| Start::Chain { backward, replica };
        let law = Some([0.01, 0.1 + 0.2]);
        let list = vec![
            attempt((0, 1), Start::Straight, None, Some(0.7)),
            attempt((0, 1), chain(false, 0), law, Some(0.5)),
            attempt((0, 1), chain(true, 3), law, None),
            attempt((1, 2), Start::Round, None, None),
        ];
        let place = tempfile::tempdir().unwrap();
        let folder = AtomicFolder::open(&place.path().join("a.landscape"), false).unwrap();
        write_attempts(&list, &folder).unwrap();
        let mut files = LandscapeFiles::default();
        files.minima.resize(3, MinimumRow::default());
        files.manifest.settings = serde_json::json!({ "sameness": { "energy": 0.005 } });
        files.write(&folder).unwrap();
        let tolerance = 0.005;
        let all = Attempts { list, tolerance };
        assert_eq!(read_attempts(folder.path(), &files).unwrap(), all);
        files.minima.pop();
        let error = read_attempts(folder.path(), &files).unwrap_err();
        assert!(error.to_string().contains("one of the 2 minima"), "{error}");
    }
}
