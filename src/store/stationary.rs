//! `stationary.parquet`: all stationary points of a searched surface with their audits.

use std::path::Path;

use super::atomic::AtomicFolder;
use super::columns::Columns;
use super::error::StoreError;
use super::landscape::{read_table, table_head};
use super::row::{self, Column, columns};

const STATIONARY: &str = "stationary.parquet";

const COLUMNS: &[Column<StationaryRow>] = columns![
    index,
    id,
    a = ends[0],
    b = ends[1],
    energy,
    coordinates,
    gradient_norm,
    curvatures if present,
    searches,
    verdict,
];

/// A row of `stationary.parquet`: a minimum or a saddle.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StationaryRow {
    /// Number of negative curvatures: 0 for a minimum, 1 for a saddle.
    pub index: u64,
    /// Number among the points of the same index, in ascending order of energy.
    pub id: u64,
    /// The minima that it joins, the lower first. For a minimum, its own number twice.
    pub ends: [u64; 2],
    /// Its energy.
    pub energy: f64,
    /// Its coordinates.
    pub coordinates: Vec<f64>,
    /// Norm of the gradient, energy per length.
    pub gradient_norm: f64,
    /// Curvatures in ascending order, without free motions. Empty where they are unknown, as on a face of a box; a table in
    /// which all are empty lacks the column.
    pub curvatures: Vec<f64>,
    /// Number of searches that ended there.
    pub searches: u64,
    /// Result of its audit: `sound`, `degenerate` if the point is not isolated, or `duplicate` if it is the saddle of an earlier
    /// row, which joins other minima as well.
    pub verdict: String,
}

impl StationaryRow {
    /// Writes the table. Equal rows give equal bytes.
    ///
    /// # Errors
    /// If a number is not finite, or the folder cannot be written.
    pub fn write(rows: &[Self], folder: &AtomicFolder) -> Result<(), StoreError> {
        let mut columns = Columns::default();
        row::write(COLUMNS, rows, &mut columns);
        let path = folder.path().join(STATIONARY);
        folder.write(STATIONARY, &columns.encode(&path, &table_head(STATIONARY))?)
    }

    /// Reads the table of a finished landscape.
    ///
    /// # Errors
    /// If the file is missing, damaged, altered, or of another landscape or version.
    pub fn read(folder: &Path) -> Result<Vec<Self>, StoreError> {
        let table = read_table(folder, STATIONARY)?;
        let mut rows = vec![Self::default(); table.rows];
        row::read(COLUMNS, &table, &mut rows)?;
        Ok(rows)
    }
}
