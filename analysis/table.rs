//! A table of numbers that grows with each run.

use std::fmt::Write;
use std::path::Path;
use std::{fs, io};

/// A comma-separated table whose rows begin with the key of a run. Runs in it are not repeated.
#[derive(Debug)]
pub(crate) struct Table {
    header: String,
    rows: Vec<String>,
}

impl Table {
    /// Reads a table, which is empty if it does not exist or has another header.
    pub(crate) fn read(path: &Path, header: &str) -> io::Result<Self> {
        let text = match fs::read_to_string(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            text => text?,
        };
        let mut lines = text.lines();
        let known = lines.next() == Some(header);
        let rows = lines.filter(|_| known).map(str::to_owned).collect();
        Ok(Self {
            header: header.to_owned(),
            rows,
        })
    }

    /// The numbers of a run, row by row; empty if it was not made yet.
    pub(crate) fn of(&self, key: &str) -> Vec<Vec<f64>> {
        let of_key = self
            .rows
            .iter()
            .filter_map(|row| row.strip_prefix(key)?.strip_prefix(','));
        of_key
            .map(|row| {
                row.split(',')
                    .map(|v| v.parse().unwrap_or(f64::NAN))
                    .collect()
            })
            .collect()
    }

    /// Puts the numbers of a run in place of those that are there.
    pub(crate) fn set<'a>(&mut self, key: &str, rows: impl IntoIterator<Item = &'a [f64]>) {
        self.rows.retain(|row| !is_of(row, key));
        for numbers in rows {
            let mut row = key.to_owned();
            for number in numbers {
                let _ = write!(row, ",{number}");
            }
            self.rows.push(row);
        }
    }

    /// Writes the rows of these runs in this order; other rows are dropped.
    pub(crate) fn write(&self, path: &Path, keys: &[String]) -> io::Result<()> {
        let mut text = format!("{}\n", self.header);
        for key in keys {
            for row in self.rows.iter().filter(|row| is_of(row, key)) {
                text.push_str(row);
                text.push('\n');
            }
        }
        fs::write(path, text)
    }
}

fn is_of(row: &str, key: &str) -> bool {
    row.strip_prefix(key)
        .is_some_and(|rest| rest.starts_with(','))
}
