//! Numbers between Rust and numpy.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayLike1, PyArrayLike2, PyArrayMethods,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::error::input;

/// Rows of equal length as a two-dimensional array, without a copy of the flat numbers.
pub(crate) fn table<T: numpy::Element>(
    py: Python<'_>,
    flat: Vec<T>,
    columns: usize,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let rows = flat.len().checked_div(columns).unwrap_or(0);
    flat.into_pyarray(py).reshape([rows, columns])
}

/// A vector of numbers as an array, without a copy.
pub(crate) fn column<T: numpy::Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    values.into_pyarray(py)
}

/// An array of points, one on each row, with `columns` numbers each.
pub(crate) fn points(
    py: Python<'_>,
    name: &str,
    given: &Bound<'_, PyAny>,
    columns: usize,
) -> PyResult<Vec<Vec<f64>>> {
    let Ok(array) = given.extract::<PyArrayLike2<'_, f64, numpy::AllowTypeChange>>() else {
        return Err(input(
            py,
            format!("{name}: an array of numbers with the shape (n, {columns}) is needed"),
        ));
    };
    if array.shape()[1] != columns {
        return Err(input(
            py,
            format!(
                "{name} has the shape ({}, {}), but (n, {columns}) is needed",
                array.shape()[0],
                array.shape()[1]
            ),
        ));
    }
    let rows: Vec<Vec<f64>> = (array.as_array().rows().into_iter())
        .map(|row| row.to_vec())
        .collect();
    let odd = rows
        .iter()
        .position(|row| !row.iter().all(|x| x.is_finite()));
    match odd {
        Some(row) => Err(input(
            py,
            format!("{name}: row {row} has a number that is not finite"),
        )),
        None => Ok(rows),
    }
}

/// Largest difference of the length of a quaternion from 1: beyond it, it is none.
const NO_QUATERNION: f64 = 1e-3;
/// Largest difference of the length of a quaternion from 1 that is left as it is.
const ROUNDED: f64 = 1e-9;
/// Largest number of a pose, metres or radians.
const LARGEST: f64 = 1e6;

/// Poses of a hand, one on each row: position, unit quaternion (w, x, y, z), joints.
pub(crate) fn poses(
    py: Python<'_>,
    name: &str,
    given: &Bound<'_, PyAny>,
    columns: usize,
) -> PyResult<Vec<Vec<f64>>> {
    let mut rows = points(py, name, given, columns)?;
    for (row, x) in rows.iter_mut().enumerate() {
        onto_poses(x).map_err(|wrong| input(py, format!("{name}: row {row} {wrong}")))?;
    }
    Ok(rows)
}

/// Makes the quaternion of a pose one of unit length, or says why the numbers are no pose.
pub(crate) fn onto_poses(x: &mut [f64]) -> Result<(), String> {
    if let Some(far) = x.iter().find(|x| x.abs() > LARGEST) {
        return Err(format!("has the number {far}, which is too large"));
    }
    let length = x[3..7].iter().map(|q| q * q).sum::<f64>().sqrt();
    if (length - 1.0).abs() > NO_QUATERNION {
        return Err(format!(
            "has the quaternion (w, x, y, z) = {:?}, whose length is {length:.4} instead of 1",
            &x[3..7]
        ));
    }
    if (length - 1.0).abs() > ROUNDED {
        x[3..7].iter_mut().for_each(|q| *q /= length);
    }
    Ok(())
}

/// A vector of `count` numbers.
pub(crate) fn vector(
    py: Python<'_>,
    name: &str,
    given: &Bound<'_, PyAny>,
    count: usize,
) -> PyResult<Vec<f64>> {
    let Ok(array) = given.extract::<PyArrayLike1<'_, f64, numpy::AllowTypeChange>>() else {
        return Err(input(
            py,
            format!("{name}: an array of numbers with the shape ({count},) is needed"),
        ));
    };
    let values = array.as_array().to_vec();
    if values.len() == count && values.iter().all(|x| x.is_finite()) {
        Ok(values)
    } else if values.len() == count {
        Err(input(py, format!("{name} has a number that is not finite")))
    } else {
        Err(input(
            py,
            format!(
                "{name} has {} numbers, but {count} are needed",
                values.len()
            ),
        ))
    }
}
