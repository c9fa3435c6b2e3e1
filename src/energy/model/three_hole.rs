//! The three-hole surface.

use crate::energy::Energy;
use crate::space::{Euclidean, Space};

/// Two deep holes and a shallow one. The lowest path between the deep holes leads *not* over the direct saddle but through
/// the shallow hole.
///
/// ```text
/// V(x, y) = 3 e^{−x² − (y − 1/3)²} − 3 e^{−x² − (y − 5/3)²} − 5 e^{−(x − 1)² − y²} − 5 e^{−(x + 1)² − y²}
///           + 0.2 x⁴ + 0.2 (y − 1/3)⁴
/// ```
///
/// Minima −3.994861 (twice) and −2.172154; saddles −1.646687 (twice, deep to shallow) and −1.384587 (deep to deep).
/// P. Metzner, C. Schütte and E. Vanden-Eijnden, J. Chem. Phys. 125, 084110 (2006), after S. Huo and J. E. Straub (1997).
#[derive(Debug, Clone)]
pub struct ThreeHole {
    space: Euclidean,
}

const HEIGHT: [f64; 4] = [3.0, -3.0, -5.0, -5.0];
const X: [f64; 4] = [0.0, 0.0, 1.0, -1.0];
const Y: [f64; 4] = [1.0 / 3.0, 5.0 / 3.0, 0.0, 0.0];

impl ThreeHole {
    /// The surface with its published constants.
    pub const fn new() -> Self {
        Self {
            space: Euclidean::new(2),
        }
    }
}

impl Default for ThreeHole {
    fn default() -> Self {
        Self::new()
    }
}

impl Energy for ThreeHole {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        assert_eq!((x.len(), gradient.len()), (2, 2));
        let (wall_x, wall_y) = (x[0], x[1] - 1.0 / 3.0);
        let mut energy = 0.2 * (wall_x.powi(4) + wall_y.powi(4));
        gradient[0] = 0.8 * wall_x.powi(3);
        gradient[1] = 0.8 * wall_y.powi(3);
        for k in 0..4 {
            let (dx, dy) = (x[0] - X[k], x[1] - Y[k]);
            let value = HEIGHT[k] * libm::exp(-dx * dx - dy * dy);
            energy += value;
            gradient[0] -= 2.0 * dx * value;
            gradient[1] -= 2.0 * dy * value;
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
    fn known_stationary_points() {
        // Solved to |∇V| < 1e-9 with exact Hessians; the digits here leave 1e-6.
        let known = [
            ([1.048055, -0.042094], -3.994861),
            ([-1.048055, -0.042094], -3.994861),
            ([0.0, 1.537082], -2.172154),
            ([0.617272, 1.102735], -1.646687),
            ([0.0, -0.315827], -1.384587),
        ];
        for (x, height) in known {
            let mut gradient = [0.0; 2];
            let energy = ThreeHole::new().evaluate(&x, &mut gradient);
            assert!((energy - height).abs() < 1e-6, "{x:?}: {energy}");
            assert!(
                gradient.iter().all(|g| g.abs() < 2e-5),
                "{x:?}: {gradient:?}"
            );
        }
    }
}
