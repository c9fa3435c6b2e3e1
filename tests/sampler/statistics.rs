//! Deviation of the means of correlated samples from their expectation, in standard deviations.

use nalgebra::{DMatrix, DVector};

/// Hotelling's T² of the batch means against `expected`, as a standard normal deviate. It tests all observables at once
/// with the covariance of the batches, which accounts for the autocorrelation of the chain (multivariate batch means, D.
/// Vats, J. M. Flegal and G. L. Jones, Biometrika 106, 321 (2019)).
///
/// `T² = B (m − μ)ᵀ S⁻¹ (m − μ)`; `(B − p)/(p (B − 1)) T²` has the F distribution with p and B − p degrees of freedom,
/// which E. Paulson's cube root (Ann. Math. Stat. 13, 233 (1942)) makes normal. Observables must be linearly independent.
pub(crate) fn deviation(batches: &[Vec<f64>], expected: &[f64]) -> f64 {
    let (count, size) = (batches.len(), expected.len());
    assert!(count > 4 * size, "{count} batches for {size} observables");
    let offset =
        |batch: &Vec<f64>| DVector::from_column_slice(batch) - DVector::from_column_slice(expected);
    let mean = batches.iter().map(offset).sum::<DVector<f64>>() / count as f64;
    let covariance = batches
        .iter()
        .map(|batch| {
            let d = offset(batch) - &mean;
            &d * d.transpose()
        })
        .sum::<DMatrix<f64>>()
        / (count - 1) as f64;
    // Observables of very different size are scaled alike before the inversion.
    let scale = covariance
        .diagonal()
        .map(|variance| variance.sqrt().recip());
    let scaled = DMatrix::from_fn(size, size, |i, j| covariance[(i, j)] * scale[i] * scale[j]);
    let mean = mean.component_mul(&scale);
    let squared = count as f64 * mean.dot(&scaled.cholesky().unwrap().solve(&mean));
    let (a, b) = (size as f64, (count - size) as f64);
    let cube_root = libm::cbrt(b / (a * (count - 1) as f64) * squared);
    let (variance_a, variance_b) = (2.0 / (9.0 * a), 2.0 / (9.0 * b));
    ((1.0 - variance_b) * cube_root - (1.0 - variance_a))
        / (variance_b * cube_root * cube_root + variance_a).sqrt()
}

/// Adds 1 to the bin of `value` between the ascending `edges`. Values above all edges are not counted, because their number
/// follows from the others.
pub(crate) fn count(value: f64, edges: &[f64], bins: &mut [f64]) {
    if let Some(bin) = edges.iter().position(|edge| value < *edge) {
        bins[bin] += 1.0;
    }
}

/// Points that divide the mass of a density on [low, high] (not normalised) into `parts` equal parts.
pub(crate) fn quantiles(low: f64, high: f64, parts: u32, density: impl Fn(f64) -> f64) -> Vec<f64> {
    const CELLS: u32 = 20_000;
    let width = (high - low) / f64::from(CELLS);
    let masses: Vec<f64> = (0..CELLS)
        .map(|k| density(low + width * (f64::from(k) + 0.5)))
        .collect();
    let total: f64 = masses.iter().sum();
    let (mut gathered, mut upper, mut edges) = (0.0, low, Vec::new());
    for mass in masses {
        while edges.len() + 1 < parts as usize {
            let wanted = total * (edges.len() + 1) as f64 / f64::from(parts);
            if gathered + mass < wanted {
                break;
            }
            edges.push(upper + width * (wanted - gathered) / mass);
        }
        gathered += mass;
        upper += width;
    }
    edges
}
