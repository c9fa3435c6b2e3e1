//! Flat space ℝⁿ.

use super::Space;

/// Flat space ℝⁿ with the usual distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Euclidean {
    dimensions: usize,
}

impl Euclidean {
    /// ℝⁿ with `dimensions` = n.
    pub const fn new(dimensions: usize) -> Self {
        Self { dimensions }
    }
}

impl Space for Euclidean {
    fn coordinates(&self) -> usize {
        self.dimensions
    }

    fn tangents(&self) -> usize {
        self.dimensions
    }

    fn exp(&self, x: &mut [f64], tangent: &[f64]) {
        assert_eq!(x.len(), tangent.len());
        for (coordinate, step) in x.iter_mut().zip(tangent) {
            *coordinate += step;
        }
    }

    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        assert_eq!(a.len(), b.len());
        for ((step, from), to) in tangent.iter_mut().zip(a).zip(b) {
            *step = to - from;
        }
        tangent.iter().map(|step| step * step).sum::<f64>().sqrt()
    }

    /// The point itself.
    fn landmarks(&self, x: &[f64]) -> Vec<f64> {
        x.to_vec()
    }
}
