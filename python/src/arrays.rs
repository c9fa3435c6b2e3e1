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
    if values.len() == count {
        Ok(values)
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
