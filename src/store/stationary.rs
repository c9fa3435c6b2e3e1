//! `stationary.parquet`: every stationary point of a searched surface with its audit.

use std::path::Path;

use super::atomic::AtomicFolder;
use super::columns::Columns;
use super::error::StoreError;
use super::landscape::{read_table, table_head};
use super::table::{FLOAT, TEXT, VECTOR, WHOLE};

const STATIONARY: &str = "stationary.parquet";

/// A row of `stationary.parquet`: a minimum or a saddle.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StationaryRow {
    /// Number of negative curvatures: 0 for a minimum, 1 for a saddle.
    pub index: u64,
    /// Number among those of its index, by rising energy.
    pub id: u64,
    /// The minima it joins, the lower first (twice its own number for a minimum).
    pub ends: [u64; 2],
    /// Its energy.
    pub energy: f64,
    /// Where it is.
    pub coordinates: Vec<f64>,
    /// Norm of the gradient there, energy per length.
    pub gradient_norm: f64,
    /// Curvatures by rising value, free motions left out.
    pub curvatures: Vec<f64>,
    /// How many searches ended there.
    pub searches: u64,
    /// What its audit says.
    pub verdict: String,
}

impl StationaryRow {
    /// Writes the table; the same bytes for the same rows.
    ///
    /// # Errors
    /// If a number is not finite, or the folder cannot be written.
    pub fn write(rows: &[Self], folder: &AtomicFolder) -> Result<(), StoreError> {
        let all = || rows.iter();
        let mut columns = Columns::default();
        columns.wholes("index", all().map(|row| row.index));
        columns.wholes("id", all().map(|row| row.id));
        columns.wholes("a", all().map(|row| row.ends[0]));
        columns.wholes("b", all().map(|row| row.ends[1]));
        columns.floats("energy", all().map(|row| row.energy));
        columns.vectors("coordinates", all().map(|row| row.coordinates.as_slice()));
        columns.floats("gradient_norm", all().map(|row| row.gradient_norm));
        columns.vectors("curvatures", all().map(|row| row.curvatures.as_slice()));
        columns.wholes("searches", all().map(|row| row.searches));
        columns.texts("verdict", all().map(|row| row.verdict.as_str()));
        let path = folder.path().join(STATIONARY);
        folder.write(STATIONARY, &columns.encode(&path, table_head(STATIONARY))?)
    }

    /// Reads the table of a finished landscape.
    ///
    /// # Errors
    /// If the file is missing, damaged, altered, of another landscape or of another version.
    pub fn read(folder: &Path) -> Result<Vec<Self>, StoreError> {
        let table = read_table(folder, STATIONARY)?;
        let mut index = table.required("index", &WHOLE)?.into_iter();
        let mut id = table.required("id", &WHOLE)?.into_iter();
        let mut a = table.required("a", &WHOLE)?.into_iter();
        let mut b = table.required("b", &WHOLE)?.into_iter();
        let mut energy = table.required("energy", &FLOAT)?.into_iter();
        let mut coordinates = table.required("coordinates", &VECTOR)?.into_iter();
        let mut gradient_norm = table.required("gradient_norm", &FLOAT)?.into_iter();
        let mut curvatures = table.required("curvatures", &VECTOR)?.into_iter();
        let mut searches = table.required("searches", &WHOLE)?.into_iter();
        let mut verdict = table.required("verdict", &TEXT)?.into_iter();
        let row = || {
            Some(Self {
                index: index.next()?,
                id: id.next()?,
                ends: [a.next()?, b.next()?],
                energy: energy.next()?,
                coordinates: coordinates.next()?,
                gradient_norm: gradient_norm.next()?,
                curvatures: curvatures.next()?,
                searches: searches.next()?,
                verdict: verdict.next()?,
            })
        };
        Ok(std::iter::from_fn(row).collect())
    }
}
