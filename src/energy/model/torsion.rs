//! Independent torsion angles.

use crate::energy::Energy;
use crate::space::{Space, Torus};

/// A sum of independent torsion angles: known minima and barriers on a space that wraps.
///
/// ```text
/// V(θ) = Σ_i h_i (1 − cos k_i θ_i)
/// ```
///
/// h: heights, k: folds, θ: angles in radians. The number of minima, all at energy 0, is the product of the folds. The pass
/// of an angle is at 2h, so merges happen at twice the heights in ascending order.
#[derive(Debug, Clone)]
pub struct Torsion {
    space: Torus,
    heights: Vec<f64>,
    folds: Vec<u8>,
}

impl Torsion {
    /// One angle for each pair of a height (positive) and a number of minima around the circle.
    pub fn new(heights_and_folds: &[(f64, u8)]) -> Self {
        let (heights, folds): (Vec<_>, Vec<_>) = heights_and_folds.iter().copied().unzip();
        Self {
            space: Torus::new(heights.len()),
            heights,
            folds,
        }
    }
}

impl Energy for Torsion {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let n = self.heights.len();
        assert_eq!((x.len(), gradient.len()), (n, n));
        let mut energy = 0.0;
        for i in 0..n {
            let fold = f64::from(self.folds[i]);
            let (sine, cosine) = libm::sincos(fold * x[i]);
            energy += self.heights[i] * (1.0 - cosine);
            gradient[i] = self.heights[i] * fold * sine;
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
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn minima_at_zero_and_saddles_at_twice_the_height() {
        let surface = Torsion::new(&[(0.5, 3), (2.0, 1)]);
        let mut gradient = [0.0; 2];
        for (x, height) in [
            ([2.0 * PI / 3.0, 0.0], 0.0),
            ([PI, 0.0], 1.0),
            ([0.0, PI], 4.0),
        ] {
            approx::assert_abs_diff_eq!(
                surface.evaluate(&x, &mut gradient),
                height,
                epsilon = 1e-14
            );
            approx::assert_abs_diff_eq!(gradient.as_slice(), [0.0; 2].as_slice(), epsilon = 1e-14);
        }
    }
}
