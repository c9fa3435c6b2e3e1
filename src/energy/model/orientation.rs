//! A surface on the rotations.

use crate::energy::Energy;
use crate::space::{Rotation, Space};

/// A quartic of the quaternion: a surface on SO(3) whose critical points are all known.
///
/// ```text
/// V(q) = −Σ_i cᵢ qᵢ⁴,   q = (w, x, y, z) a unit quaternion, cᵢ > 0
/// ```
///
/// V(q) = V(−q), so it is a function of the rotation. On the sphere ∇V is parallel to q if cᵢ qᵢ² = 1/σ for all i in a set
/// S of coordinates, σ = Σ_{i∈S} 1/cᵢ, and qᵢ = 0 otherwise; there V = −1/σ. Its second derivative along the unit sphere is
/// −12/σ + 4/σ within S and 4/σ across. A quaternion turns by half the angle, so per radian of rotation the curvatures are
/// −2/σ (|S| − 1 times) and 1/σ (4 − |S| times): the point is nondegenerate, of index |S| − 1. Signs up to a common one
/// give 2^(|S|−1) rotations for each S: 4 minima at −cᵢ, 12 saddles (two for each pair of minima, one for each direction of
/// rotation), 16 points of index 2 and 8 maxima. Morse theory requires 4 − 12 + 16 − 8 = 0 on SO(3). Minima i and j are
/// joined directly at −1/(1/cᵢ + 1/cⱼ), which rises as either weight falls: the two deepest merge first, and every other
/// minimum merges at its pass to the deepest one.
#[derive(Debug, Clone)]
pub struct Orientation {
    space: Rotation,
    weights: [f64; 4],
}

impl Orientation {
    /// The surface with the weights c of w, x, y and z.
    ///
    /// # Panics
    /// If a weight is not positive and finite.
    pub fn new(weights: [f64; 4]) -> Self {
        assert!(
            weights.iter().all(|c| *c > 0.0 && c.is_finite()),
            "weights are positive, not {weights:?}"
        );
        Self {
            space: Rotation::new(1.0),
            weights,
        }
    }
}

impl Energy for Orientation {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        assert_eq!((x.len(), gradient.len()), (4, 3));
        let norm = x.iter().map(|q| q * q).sum::<f64>().sqrt();
        let [w, i, j, k] = [0, 1, 2, 3].map(|n| x[n] / norm);
        let cubes = [w, i, j, k].map(|q| q * q * q);
        let slope: [f64; 4] = std::array::from_fn(|n| -4.0 * self.weights[n] * cubes[n]);
        // dq = ½ q ∘ (0, u) for a rotation u in the body's frame.
        let turns = [[-i, w, k, -j], [-j, -k, w, i], [-k, j, -i, w]];
        for (g, turn) in gradient.iter_mut().zip(turns) {
            *g = 0.5 * slope.iter().zip(turn).map(|(s, t)| s * t).sum::<f64>();
        }
        let energy: f64 = [w, i, j, k]
            .iter()
            .zip(cubes)
            .zip(self.weights)
            .map(|((q, cube), c)| -c * q * cube)
            .sum();
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
    fn stationary_where_it_should_be() {
        let weights = [1.0, 1.5, 2.0, 3.0];
        let surface = Orientation::new(weights);
        let mut gradient = [0.0; 3];
        for set in 1..16_u8 {
            let inside = |n: usize| set >> n & 1 == 1;
            let sum: f64 = (0..4)
                .filter(|n| inside(*n))
                .map(|n| 1.0 / weights[n])
                .sum();
            let x: [f64; 4] = std::array::from_fn(|n| {
                if inside(n) {
                    (1.0 / (weights[n] * sum)).sqrt()
                } else {
                    0.0
                }
            });
            let energy = surface.evaluate(&x, &mut gradient);
            approx::assert_abs_diff_eq!(energy, -1.0 / sum, epsilon = 1e-15);
            approx::assert_abs_diff_eq!(gradient.as_slice(), [0.0; 3].as_slice(), epsilon = 1e-15);
        }
    }
}
