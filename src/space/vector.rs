//! Arithmetic on tangents, which are plain slices because their basis is orthonormal.

use nalgebra::DMatrix;

/// a · b.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// ‖a‖.
pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// y ← y + factor · x.
pub(crate) fn add(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

/// y ← factor · y.
pub(crate) fn scale(y: &mut [f64], factor: f64) {
    for y in y {
        *y *= factor;
    }
}

/// Componentwise product of a and b.
pub(crate) fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

/// The product A B, column by column: bitwise equal on every processor, unlike nalgebra's product of large matrices, which
/// chooses its code by the processor.
pub(crate) fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(a.nrows(), b.ncols());
    // Chunks of size 0 are not allowed.
    let (rows, inner) = (a.nrows().max(1), b.nrows().max(1));
    let columns = product.as_mut_slice().chunks_exact_mut(rows);
    for (column, factors) in columns.zip(b.as_slice().chunks_exact(inner)) {
        for (factor, axis) in factors.iter().zip(a.as_slice().chunks_exact(rows)) {
            add(column, *factor, axis);
        }
    }
    product
}
