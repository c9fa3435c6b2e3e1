//! Independent double wells.

use crate::energy::Energy;
use crate::space::{Euclidean, Space};

/// A sum of independent double wells: many minima, whose barriers are known in closed form.
///
/// ```text
/// V(x) = Σ_i (x_i² − 1)² + c x_i
/// ```
///
/// Without tilt c: 2ᵈ minima at energy 0 (every coordinate ±1), d 2ᵈ⁻¹ saddles at 1, and every merge happens at 1.
/// With |c| < 8/(3√3) each well keeps two unequal minima and the landscape is the product of d copies of it.
#[derive(Debug, Clone)]
pub struct DoubleWell {
    space: Euclidean,
    tilt: f64,
}

impl DoubleWell {
    /// `dimensions` untilted wells.
    pub const fn new(dimensions: usize) -> Self {
        Self {
            space: Euclidean::new(dimensions),
            tilt: 0.0,
        }
    }

    /// The same with slope `tilt` added along every coordinate.
    #[must_use]
    pub const fn with_tilt(self, tilt: f64) -> Self {
        Self { tilt, ..self }
    }
}

impl Energy for DoubleWell {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let n = self.space.coordinates();
        assert_eq!((x.len(), gradient.len()), (n, n));
        let mut energy = 0.0;
        for (coordinate, slope) in x.iter().zip(gradient) {
            let well = coordinate * coordinate - 1.0;
            energy += well * well + self.tilt * coordinate;
            *slope = 4.0 * coordinate * well + self.tilt;
        }
        if energy.is_finite() {
            energy
        } else {
            f64::INFINITY
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minima_at_zero_and_saddles_at_one() {
        let surface = DoubleWell::new(3);
        let mut gradient = [0.0; 3];
        for (x, height) in [([1.0, -1.0, 1.0], 0.0), ([1.0, -1.0, 0.0], 1.0)] {
            approx::assert_abs_diff_eq!(
                surface.evaluate(&x, &mut gradient),
                height,
                epsilon = 1e-15
            );
            approx::assert_abs_diff_eq!(gradient.as_slice(), [0.0; 3].as_slice(), epsilon = 1e-15);
        }
    }

    #[test]
    fn a_tilt_shifts_the_wells_apart() {
        // 4x(x² − 1) + c = 0 at x = 1/2 for c = 3/2; then V = 9/16 + 3/4.
        let mut gradient = [0.0];
        let energy = DoubleWell::new(1)
            .with_tilt(1.5)
            .evaluate(&[0.5], &mut gradient);
        approx::assert_abs_diff_eq!(energy, 1.3125, epsilon = 1e-15);
        approx::assert_abs_diff_eq!(gradient[0], 0.0, epsilon = 1e-15);
    }
}
