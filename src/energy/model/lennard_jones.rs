//! Clusters of Lennard-Jones atoms.

use crate::energy::Energy;
use crate::space::{Cluster, Space};

/// n equal Lennard-Jones atoms, in units ε = σ = 1.
///
/// ```text
/// V = 4 Σ_{i<j} (r_ij⁻¹² − r_ij⁻⁶)
/// ```
///
/// `x`: the atoms' positions, concatenated, 3n numbers. Infinite if two atoms coincide. The usual test of landscape codes;
/// global minima by D. J. Wales and J. P. K. Doye, J. Phys. Chem. A 101, 5111 (1997).
#[derive(Debug, Clone)]
pub struct LennardJones {
    space: Cluster,
}

impl LennardJones {
    /// A cluster of `atoms` atoms.
    pub const fn new(atoms: usize) -> Self {
        Self {
            space: Cluster::new(atoms),
        }
    }
}

impl Energy for LennardJones {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let n = self.space.coordinates();
        assert_eq!((x.len(), gradient.len()), (n, n));
        gradient.fill(0.0);
        let mut energy = 0.0;
        for i in (0..n).step_by(3) {
            let (head, tail) = gradient.split_at_mut(i + 3);
            let mut force = [0.0; 3];
            for (other, pull) in x[i + 3..].chunks_exact(3).zip(tail.chunks_exact_mut(3)) {
                let d = [x[i] - other[0], x[i + 1] - other[1], x[i + 2] - other[2]];
                let inverse2 = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).recip();
                let inverse6 = inverse2 * inverse2 * inverse2;
                energy += inverse6 * (inverse6 - 1.0);
                let slope = inverse6 * (12.0 * inverse6 - 6.0) * inverse2;
                for k in 0..3 {
                    force[k] -= slope * d[k];
                    pull[k] += 4.0 * slope * d[k];
                }
            }
            for k in 0..3 {
                head[i + k] += 4.0 * force[k];
            }
        }
        // Coincident atoms give ∞ or ∞ − ∞; at slightly lower energies the gradient overflows.
        if energy < 1e200 {
            4.0 * energy
        } else {
            f64::INFINITY
        }
    }

    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool {
        let n = self.space.coordinates();
        assert_eq!((x.len(), hessian.len()), (n, n * n));
        hessian.fill(0.0);
        for i in (0..n).step_by(3) {
            for j in (i + 3..n).step_by(3) {
                let d = [x[i] - x[j], x[i + 1] - x[j + 1], x[i + 2] - x[j + 2]];
                let inverse2 = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).recip();
                let inverse6 = inverse2 * inverse2 * inverse2;
                // V′/r, and (V″ − V′/r)/r².
                let slope = -4.0 * inverse6 * (12.0 * inverse6 - 6.0) * inverse2;
                let bend = 4.0 * inverse6 * (168.0 * inverse6 - 48.0) * inverse2 * inverse2;
                for a in 0..3 {
                    for b in 0..3 {
                        let entry = bend * d[a] * d[b] + if a == b { slope } else { 0.0 };
                        hessian[(i + a) * n + i + b] += entry;
                        hessian[(j + a) * n + j + b] += entry;
                        hessian[(i + a) * n + j + b] = -entry;
                        hessian[(j + a) * n + i + b] = -entry;
                    }
                }
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_at_its_best_distance() {
        let mut gradient = [0.0; 6];
        let energy = LennardJones::new(2).evaluate(
            &[0.0, 0.0, 0.0, 0.0, libm::pow(2.0_f64, 1.0 / 6.0), 0.0],
            &mut gradient,
        );
        approx::assert_abs_diff_eq!(energy, -1.0, epsilon = 1e-15);
        approx::assert_abs_diff_eq!(gradient.as_slice(), [0.0; 6].as_slice(), epsilon = 1e-13);
    }

    #[test]
    fn the_tetrahedron() {
        // Six bonds of length 2^(1/6), so −6.
        let s = libm::pow(2.0_f64, 1.0 / 6.0) / 8.0_f64.sqrt();
        let x = [s, s, s, s, -s, -s, -s, s, -s, -s, -s, s];
        let mut gradient = [0.0; 12];
        approx::assert_abs_diff_eq!(
            LennardJones::new(4).evaluate(&x, &mut gradient),
            -6.0,
            epsilon = 1e-14
        );
    }

    #[test]
    fn coinciding_and_nearly_coinciding_atoms_are_infinitely_bad() {
        let mut gradient = [0.0; 6];
        for gap in [0.0, 1e-200, 1e-40, 1e-20] {
            let energy =
                LennardJones::new(2).evaluate(&[1.0, 0.0, 0.0, 1.0, 0.0, gap], &mut gradient);
            assert!(energy == f64::INFINITY, "{energy} at a gap of {gap}");
        }
    }
}
