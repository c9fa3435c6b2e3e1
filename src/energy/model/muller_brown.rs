//! The Müller–Brown surface.

use crate::energy::Energy;
use crate::space::{Euclidean, Space};

/// The Müller–Brown surface, the usual test of path searches.
///
/// ```text
/// V(x, y) = Σ_{k=1..4} A_k exp(a_k (x − x_k)² + b_k (x − x_k)(y − y_k) + c_k (y − y_k)²)
/// ```
///
/// Three minima (−146.6995, −108.1667, −80.7678) and two saddles (−40.6648, −72.2489).
/// K. Müller and L. D. Brown, Theoretica Chimica Acta 53, 75 (1979).
#[derive(Debug, Clone)]
pub struct MullerBrown {
    space: Euclidean,
}

const HEIGHT: [f64; 4] = [-200.0, -100.0, -170.0, 15.0];
const A: [f64; 4] = [-1.0, -1.0, -6.5, 0.7];
const B: [f64; 4] = [0.0, 0.0, 11.0, 0.6];
const C: [f64; 4] = [-10.0, -10.0, -6.5, 0.7];
const X: [f64; 4] = [1.0, 0.0, -0.5, -1.0];
const Y: [f64; 4] = [0.0, 0.5, 1.5, 1.0];

impl MullerBrown {
    /// The surface with its published constants.
    pub const fn new() -> Self {
        Self {
            space: Euclidean::new(2),
        }
    }
}

impl Default for MullerBrown {
    fn default() -> Self {
        Self::new()
    }
}

impl Energy for MullerBrown {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        assert_eq!((x.len(), gradient.len()), (2, 2));
        gradient.fill(0.0);
        let mut energy = 0.0;
        for k in 0..4 {
            let (dx, dy) = (x[0] - X[k], x[1] - Y[k]);
            let value = HEIGHT[k] * libm::exp(A[k] * dx * dx + B[k] * dx * dy + C[k] * dy * dy);
            energy += value;
            gradient[0] += value * (2.0 * A[k] * dx + B[k] * dy);
            gradient[1] += value * (B[k] * dx + 2.0 * C[k] * dy);
        }
        // Far away the last, growing term overflows.
        if energy.is_finite() {
            energy
        } else {
            f64::INFINITY
        }
    }

    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool {
        assert_eq!((x.len(), hessian.len()), (2, 4));
        hessian.fill(0.0);
        for k in 0..4 {
            let (dx, dy) = (x[0] - X[k], x[1] - Y[k]);
            let value = HEIGHT[k] * libm::exp(A[k] * dx * dx + B[k] * dx * dy + C[k] * dy * dy);
            let slope = [2.0 * A[k] * dx + B[k] * dy, B[k] * dx + 2.0 * C[k] * dy];
            hessian[0] += value * (slope[0] * slope[0] + 2.0 * A[k]);
            hessian[1] += value * (slope[0] * slope[1] + B[k]);
            hessian[3] += value * (slope[1] * slope[1] + 2.0 * C[k]);
        }
        hessian[2] = hessian[1];
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_minimum() {
        let mut gradient = [0.0; 2];
        let energy = MullerBrown::new().evaluate(&[-0.558_223_6, 1.441_725_8], &mut gradient);
        assert!((energy + 146.699_517_2).abs() < 1e-6);
        assert!(gradient.iter().all(|g| g.abs() < 1e-3));
    }
}
