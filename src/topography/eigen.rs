//! One smooth piece of an energy, with its Hessian and curvatures.

use nalgebra::{DMatrix, DVectorView, SymmetricEigen};

use crate::energy::Energy;
use crate::space::Space;
use crate::space::vector::{add, dot, norm, scale, times};

/// Curvatures smaller than this share of the largest have no sign.
pub(super) const FLAT: f64 = 1e-6;

/// Sweeps of the eigenvalue iteration for each row, far more than it ever takes.
const SWEEPS: usize = 100;

/// One smooth piece of an energy: its discrete choice held, in tangents divided by the step scales.
pub(super) struct Piece<'e> {
    energy: &'e dyn Energy,
    choice: Vec<u32>,
    pub(super) scales: Vec<f64>,
}

/// Curvatures and the scaled tangents along which they are taken, lowest first, the free directions left out.
pub(super) struct Modes {
    pub(super) curvatures: Vec<f64>,
    pub(super) tangents: Vec<Vec<f64>>,
}

impl Modes {
    /// Greatest curvature of either sign.
    pub(super) fn stiffest(&self) -> f64 {
        self.curvatures
            .iter()
            .fold(0.0, |most, c| most.max(c.abs()))
    }

    /// The mode with the greatest overlap with `tangent`, the lowest of those that tie.
    pub(super) fn most_like(&self, tangent: &[f64]) -> usize {
        let overlaps: Vec<f64> = self
            .tangents
            .iter()
            .map(|mode| dot(mode, tangent).abs())
            .collect();
        (0..overlaps.len())
            .max_by(|i, j| overlaps[*i].total_cmp(&overlaps[*j]).then(j.cmp(i)))
            .unwrap_or(0)
    }

    /// Numbers of negative curvatures and of those that have no sign.
    pub(super) fn index(&self) -> (usize, usize) {
        let flat = FLAT * self.stiffest();
        let count =
            |kind: &dyn Fn(f64) -> bool| self.curvatures.iter().filter(|c| kind(**c)).count();
        (count(&|c| c < -flat), count(&|c| c.abs() <= flat))
    }
}

impl<'e> Piece<'e> {
    /// The piece with `choice` (empty for a smooth energy).
    pub(super) fn new(energy: &'e dyn Energy, choice: Vec<u32>) -> Self {
        Self {
            energy,
            choice,
            scales: energy.space().step_scales(),
        }
    }

    /// The piece with `choice` in plain tangents: its curvatures are those of the surface.
    pub(super) fn plain(energy: &'e dyn Energy, choice: Vec<u32>) -> Self {
        Self {
            energy,
            choice,
            scales: vec![1.0; energy.space().tangents()],
        }
    }

    pub(super) fn space(&self) -> &'e dyn Space {
        self.energy.space()
    }

    /// Energy, and the gradient by scaled tangents.
    pub(super) fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let energy = if self.choice.is_empty() {
            self.energy.evaluate(x, gradient)
        } else {
            self.energy.evaluate_choice(x, &self.choice, gradient)
        };
        for (g, s) in gradient.iter_mut().zip(&self.scales) {
            *g *= s;
        }
        energy
    }

    /// `x` moved by a scaled tangent.
    pub(super) fn moved(&self, x: &[f64], step: &[f64]) -> Vec<f64> {
        let mut x = x.to_vec();
        self.space().shift(&mut x, &times(step, &self.scales));
        x
    }

    /// Norm of a gradient by scaled tangents, in the metric.
    pub(super) fn size(&self, gradient: &[f64]) -> f64 {
        let plain = gradient.iter().zip(&self.scales).map(|(g, s)| g / s);
        plain.map(|g| g * g).sum::<f64>().sqrt()
    }

    /// A plain tangent, scaled.
    pub(super) fn scaled(&self, tangent: &[f64]) -> Vec<f64> {
        tangent
            .iter()
            .zip(&self.scales)
            .map(|(t, s)| t / s)
            .collect()
    }

    /// Orthonormal scaled tangents along which nothing changes.
    fn free(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let mut free: Vec<Vec<f64>> = Vec::new();
        for mode in self.space().zero_modes(x).chunks_exact(self.scales.len()) {
            let mut mode = self.scaled(mode);
            for known in &free {
                let share = dot(known, &mode);
                add(&mut mode, -share, known);
            }
            let length = norm(&mode);
            scale(&mut mode, length.recip());
            free.push(mode);
        }
        free
    }

    /// Reflections that turn the free directions at `x` into the first axes, one after the other.
    fn mirrors(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let mut free = self.free(x);
        for k in 0..free.len() {
            let (mirror, later) = free[k..].split_first_mut().expect("k is one of them");
            mirror[..k].fill(0.0);
            mirror[k] += norm(mirror).copysign(mirror[k]);
            let length = norm(mirror);
            scale(mirror, length.recip());
            for direction in later {
                reflect(direction, mirror);
            }
        }
        free
    }

    /// Hessian by central differences of the gradient, symmetrised; `None` next to the edge of the domain.
    pub(super) fn hessian(&self, x: &[f64], difference: f64) -> Option<DMatrix<f64>> {
        self.mirrored_hessian(x, difference, &[])
    }

    /// The Hessian between those axes that `mirrors` turned nothing into.
    fn mirrored_hessian(
        &self,
        x: &[f64],
        difference: f64,
        mirrors: &[Vec<f64>],
    ) -> Option<DMatrix<f64>> {
        let (n, first) = (self.scales.len(), mirrors.len());
        let mut columns = DMatrix::zeros(n - first, n - first);
        let (mut there, mut step) = (x.to_vec(), vec![0.0; n]);
        let (mut ahead, mut behind, mut axis) = (step.clone(), step.clone(), step.clone());
        for j in first..n {
            axis.fill(0.0);
            axis[j] = 1.0;
            unmirror(&mut axis, mirrors);
            let mut at = |difference: f64, gradient: &mut [f64]| {
                there.copy_from_slice(x);
                for (step, (along, scale)) in step.iter_mut().zip(axis.iter().zip(&self.scales)) {
                    *step = difference * along * scale;
                }
                self.space().shift(&mut there, &step);
                self.evaluate(&there, gradient)
            };
            let up = at(difference, &mut ahead);
            let down = at(-difference, &mut behind);
            if !(up.is_finite() && down.is_finite()) {
                return None;
            }
            add(&mut ahead, -1.0, &behind);
            for mirror in mirrors {
                reflect(&mut ahead, mirror);
            }
            for i in first..n {
                columns[(i - first, j - first)] = ahead[i] / (2.0 * difference);
            }
        }
        Some(DMatrix::from_fn(n - first, n - first, |i, j| {
            f64::midpoint(columns[(i, j)], columns[(j, i)])
        }))
    }

    /// Eigenvalues and eigenvectors of the Hessian of the directions that are not free, as [`Piece::hessian`] measures it;
    /// `None` if it is not finite.
    pub(super) fn modes(&self, x: &[f64], difference: f64) -> Option<Modes> {
        let (n, mirrors) = (self.scales.len(), self.mirrors(x));
        let first = mirrors.len();
        let inner = self.mirrored_hessian(x, difference, &mirrors)?;
        if !inner.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        let eigen = SymmetricEigen::try_new(inner, f64::EPSILON, SWEEPS * n)?;
        let mut order: Vec<usize> = (0..n - first).collect();
        order.sort_by(|i, j| {
            eigen.eigenvalues[*i]
                .total_cmp(&eigen.eigenvalues[*j])
                .then(i.cmp(j))
        });
        let tangent = |k: &usize| {
            let mut tangent = vec![0.0; n];
            tangent[first..].copy_from_slice(eigen.eigenvectors.column(*k).as_slice());
            unmirror(&mut tangent, &mirrors);
            tangent
        };
        Some(Modes {
            curvatures: order.iter().map(|k| eigen.eigenvalues[*k]).collect(),
            tangents: order.iter().map(tangent).collect(),
        })
    }
}

/// (1 − 2 m mᵀ) v for a unit vector m.
fn reflect(vector: &mut [f64], mirror: &[f64]) {
    let n = vector.len();
    // Eight sums side by side: one after the other they would wait for each other.
    let share = DVectorView::from_slice(vector, n).dot(&DVectorView::from_slice(mirror, n));
    add(vector, -2.0 * share, mirror);
}

/// Undoes reflections that were done one after the other.
fn unmirror(vector: &mut [f64], mirrors: &[Vec<f64>]) {
    for mirror in mirrors.iter().rev() {
        reflect(vector, mirror);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::model::LennardJones;

    #[test]
    fn curvatures_are_those_of_the_whole_hessian_but_for_the_free_ones() {
        // A regular tetrahedron of atoms, away from any axis.
        let energy = LennardJones::new(4);
        let piece = Piece::new(&energy, Vec::new());
        let half = 0.5 * 2.0_f64.powf(1.0 / 6.0) / 2.0_f64.sqrt();
        let corners = [
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ];
        let x: Vec<f64> = corners.iter().flatten().map(|c| 0.3 + half * c).collect();
        let whole = piece.hessian(&x, 1e-5).unwrap().symmetric_eigenvalues();
        let mut whole = whole.as_slice().to_vec();
        whole.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        let (free, stiff) = whole.split_at(6);
        assert!(free.iter().all(|c| c.abs() < 1e-4), "{free:?}");
        let modes = piece.modes(&x, 1e-5).unwrap();
        assert_eq!(modes.curvatures.len(), stiff.len());
        for (curvature, expected) in modes.curvatures.iter().zip(stiff) {
            assert!(
                (curvature - expected).abs() < 1e-4,
                "{curvature} {expected}"
            );
        }
        for mode in &modes.tangents {
            assert!((norm(mode) - 1.0).abs() < 1e-12);
            let moved = [0, 1, 2].map(|k| mode.iter().skip(k).step_by(3).sum::<f64>());
            assert!(norm(&moved) < 1e-12);
        }
    }

    #[test]
    fn free_motions_do_not_count() {
        // A pair of atoms has one mode besides five free motions: V″ = 36 · 4^⅓ along r, twice that for both atoms.
        let energy = LennardJones::new(2);
        let piece = Piece::new(&energy, Vec::new());
        let x = [0.0, 0.0, 0.0, 2.0_f64.powf(1.0 / 6.0), 0.0, 0.0];
        let modes = piece.modes(&x, 1e-5).unwrap();
        assert_eq!(modes.curvatures.len(), 1);
        assert!(
            (modes.curvatures[0] - 2.0 * 36.0 * 4.0_f64.powf(1.0 / 3.0)).abs() < 1e-3,
            "{}",
            modes.curvatures[0]
        );
    }
}
