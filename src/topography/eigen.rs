//! An energy in scaled tangents, with its Hessian and curvatures.

use nalgebra::{DMatrix, DVector, DVectorView, SymmetricEigen};

use crate::energy::Energy;
use crate::space::Space;
use crate::space::vector::{add, dot, norm, product, scale, times};

/// Fraction of the largest curvature (outliers excluded) below which a curvature has no sign.
const FLAT: f64 = 1e-6;
/// Error of curvatures relative to the largest of all. Finite differences take a circle, for example, for a straight line.
const NOISE: f64 = 1e-8;
/// A curvature above this multiple of the median is an outlier.
const OUTLYING: f64 = 30.0;

/// Halvings of the interval of a level shift.
const BISECTIONS: usize = 40;

/// Sweeps of the eigenvalue iteration for each row, far more than needed.
const SWEEPS: usize = 100;

/// An energy in tangents divided by the step scales.
pub(super) struct Scaled<'e> {
    energy: &'e dyn Energy,
    pub(super) scales: Vec<f64>,
}

/// Curvatures and their scaled tangents, lowest first, without the free directions.
#[derive(Clone)]
pub(super) struct Modes {
    pub(super) curvatures: Vec<f64>,
    pub(super) tangents: Vec<Vec<f64>>,
}

impl Modes {
    pub(super) fn stiffest(&self) -> f64 {
        self.curvatures
            .iter()
            .fold(0.0, |most, c| most.max(c.abs()))
    }

    /// Greatest absolute curvature, cut to [`OUTLYING`] times the median: a few stiff directions must not set the scale.
    pub(super) fn stiffness(&self) -> f64 {
        let stiffest = self.stiffest();
        let sizes = self.curvatures.iter().map(|curvature| curvature.abs());
        let mut sizes: Vec<f64> = sizes.filter(|size| *size > NOISE * stiffest).collect();
        sizes.sort_by(f64::total_cmp);
        let median = sizes.get(sizes.len().saturating_sub(1) / 2);
        median.map_or(stiffest, |median| stiffest.min(OUTLYING * median))
    }

    /// Curvatures of smaller size have no sign.
    pub(super) fn flat(&self) -> f64 {
        (FLAT * self.stiffness()).max(NOISE * self.stiffest())
    }

    /// `hessian` in scaled tangents, with outlying directions shortened to the stiffness [`Modes::stiffness`].
    pub(super) fn tempered(&self, mut hessian: DMatrix<f64>) -> DMatrix<f64> {
        let most = self.stiffness();
        for (curvature, tangent) in self.curvatures.iter().zip(&self.tangents) {
            if curvature.abs() > most {
                let tangent = DVector::from_column_slice(tangent);
                let cut = 1.0 - (most / curvature.abs()).sqrt();
                let bent = &hessian * &tangent;
                let square = cut * cut * tangent.dot(&bent);
                hessian += &tangent * tangent.transpose() * square
                    - (&bent * tangent.transpose() + &tangent * bent.transpose()) * cut;
            }
        }
        hessian
    }

    /// The longest Newton step along a mode that is not flat, for a gradient in scaled tangents.
    pub(super) fn newton_step(&self, gradient: &[f64]) -> f64 {
        let flat = self.flat();
        let modes = self.curvatures.iter().zip(&self.tangents);
        modes
            .filter(|(curvature, _)| curvature.abs() > flat)
            .map(|(curvature, mode)| dot(gradient, mode).abs() / curvature.abs())
            .fold(0.0, f64::max)
    }

    /// The mode with the greatest overlap with `tangent`; the lowest of equal ones.
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

    /// Numbers of negative curvatures and of curvatures without sign.
    pub(super) fn index(&self) -> (usize, usize) {
        let flat = self.flat();
        let count =
            |kind: &dyn Fn(f64) -> bool| self.curvatures.iter().filter(|c| kind(**c)).count();
        (count(&|c| c < -flat), count(&|c| c.abs() <= flat))
    }
}

impl<'e> Scaled<'e> {
    pub(super) fn new(energy: &'e dyn Energy) -> Self {
        Self {
            energy,
            scales: energy.space().step_scales(),
        }
    }

    /// The energy in plain tangents, so that its curvatures are those of the surface.
    pub(super) fn plain(energy: &'e dyn Energy) -> Self {
        Self {
            energy,
            scales: vec![1.0; energy.space().tangents()],
        }
    }

    pub(super) fn energy(&self) -> &'e dyn Energy {
        self.energy
    }

    pub(super) fn space(&self) -> &'e dyn Space {
        self.energy.space()
    }

    /// Energy, and the gradient in scaled tangents.
    pub(super) fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let energy = self.energy.evaluate(x, gradient);
        for (g, s) in gradient.iter_mut().zip(&self.scales) {
            *g *= s;
        }
        energy
    }

    pub(super) fn moved(&self, x: &[f64], step: &[f64]) -> Vec<f64> {
        let mut x = x.to_vec();
        self.space().exp(&mut x, &times(step, &self.scales));
        x
    }

    /// Norm, in the metric, of a gradient in scaled tangents.
    pub(super) fn size(&self, gradient: &[f64]) -> f64 {
        let plain = gradient.iter().zip(&self.scales).map(|(g, s)| g / s);
        plain.map(|g| g * g).sum::<f64>().sqrt()
    }

    pub(super) fn scaled(&self, tangent: &[f64]) -> Vec<f64> {
        tangent
            .iter()
            .zip(&self.scales)
            .map(|(t, s)| t / s)
            .collect()
    }

    /// Orthonormal scaled tangents of the free directions, along which the energy is constant.
    pub(super) fn free(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let mut free: Vec<Vec<f64>> = Vec::new();
        for mode in self
            .space()
            .zero_modes(x)
            .chunks_exact(self.scales.len().max(1))
        {
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

    /// Orthonormal scaled tangents perpendicular to the free ones, as columns.
    fn across(&self, x: &[f64]) -> DMatrix<f64> {
        let (n, mut mirrors) = (self.scales.len(), self.free(x));
        let free = mirrors.len();
        // Reflections map the free directions to the first axes, one after the other.
        for k in 0..free {
            let (mirror, later) = mirrors[k..].split_first_mut().expect("k is one of them");
            mirror[..k].fill(0.0);
            mirror[k] += norm(mirror).copysign(mirror[k]);
            let length = norm(mirror);
            scale(mirror, length.recip());
            for direction in later {
                reflect(direction, mirror);
            }
        }
        // They map the other axes to the perpendicular directions.
        let mut across = DMatrix::zeros(n, n - free);
        // In a space of dimension 0, chunks of size 0 are avoided.
        let columns = across.as_mut_slice().chunks_exact_mut(n.max(1));
        for (j, column) in columns.enumerate() {
            column[free + j] = 1.0;
            for (k, mirror) in mirrors.iter().enumerate().rev() {
                reflect(&mut column[k..], &mirror[k..]);
            }
        }
        across
    }

    /// Symmetrised Hessian between the columns of `axes` (scaled tangents), from the energy or by differences of the
    /// gradient. `None` next to the edge of the domain.
    fn hessian_between(
        &self,
        axes: &DMatrix<f64>,
        x: &[f64],
        difference: f64,
    ) -> Option<DMatrix<f64>> {
        let bent = match self.known_hessian(x) {
            Some(whole) => product(&whole, axes),
            None => self.differences(axes, x, difference)?,
        };
        let between = product(&axes.transpose(), &bent);
        let between = 0.5 * (&between + between.transpose());
        let finite = between.iter().all(|entry| entry.is_finite());
        finite.then_some(between)
    }

    pub(super) fn hessian(&self, x: &[f64], difference: f64) -> Option<DMatrix<f64>> {
        let n = self.scales.len();
        self.hessian_between(&DMatrix::identity(n, n), x, difference)
    }

    /// The energy's own Hessian in scaled tangents, if it has one.
    fn known_hessian(&self, x: &[f64]) -> Option<DMatrix<f64>> {
        let n = self.scales.len();
        let mut hessian = DMatrix::zeros(n, n);
        if !self.energy.hessian(x, hessian.as_mut_slice()) {
            return None;
        }
        let columns = hessian.as_mut_slice().chunks_exact_mut(n.max(1));
        for (column, b) in columns.zip(&self.scales) {
            for (entry, a) in column.iter_mut().zip(&self.scales) {
                *entry *= a * b;
            }
        }
        Some(hessian)
    }

    /// Change of the gradient along each column of `axes`, by central differences.
    fn differences(&self, axes: &DMatrix<f64>, x: &[f64], difference: f64) -> Option<DMatrix<f64>> {
        let mut changes = DMatrix::zeros(axes.nrows(), axes.ncols());
        let (mut there, mut step) = (x.to_vec(), vec![0.0; self.scales.len()]);
        let (mut ahead, mut behind) = (step.clone(), step.clone());
        for (axis, mut change) in axes.column_iter().zip(changes.column_iter_mut()) {
            let mut at = |difference: f64, gradient: &mut [f64]| {
                there.copy_from_slice(x);
                for (step, (along, scale)) in step.iter_mut().zip(axis.iter().zip(&self.scales)) {
                    *step = difference * along * scale;
                }
                self.space().exp(&mut there, &step);
                self.evaluate(&there, gradient)
            };
            let up = at(difference, &mut ahead);
            let down = at(-difference, &mut behind);
            if !(up.is_finite() && down.is_finite()) {
                return None;
            }
            for (change, (ahead, behind)) in change.iter_mut().zip(ahead.iter().zip(&behind)) {
                *change = (ahead - behind) / (2.0 * difference);
            }
        }
        Some(changes)
    }

    /// Eigenvalues and eigenvectors of the Hessian without the free directions; `None` if the Hessian is not finite.
    pub(super) fn modes(&self, x: &[f64], difference: f64) -> Option<Modes> {
        let axes = self.across(x);
        if axes.ncols() == 0 {
            // For an empty space or a single atom, all directions are free.
            return Some(Modes {
                curvatures: Vec::new(),
                tangents: Vec::new(),
            });
        }
        let between = self.hessian_between(&axes, x, difference)?;
        let eigen = SymmetricEigen::try_new(between, f64::EPSILON, SWEEPS * self.scales.len())?;
        let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
        order.sort_by(|i, j| {
            eigen.eigenvalues[*i]
                .total_cmp(&eigen.eigenvalues[*j])
                .then(i.cmp(j))
        });
        let tangents = product(&axes, &eigen.eigenvectors);
        let tangent = |k: &usize| tangents.column(*k).as_slice().to_vec();
        Some(Modes {
            curvatures: order.iter().map(|k| eigen.eigenvalues[*k]).collect(),
            tangents: order.iter().map(tangent).collect(),
        })
    }
}

/// Lengths of a step along modes, no longer than `longest` together. `lengths` gives them for curvatures raised by a shift;
/// the least sufficient shift is found by bisection. Unlike a shorter step in the same direction, such a step still goes to
/// the bottom along stiff modes. `slope` is the norm of the gradient.
pub(super) fn shifted(slope: f64, longest: f64, lengths: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let whole = lengths(0.0);
    if norm(&whole) <= longest {
        return whole;
    }
    let (mut low, mut high) = (0.0, slope / longest);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        *(if norm(&lengths(middle)) > longest {
            &mut low
        } else {
            &mut high
        }) = middle;
    }
    lengths(high)
}

/// (1 − 2 m mᵀ) v for a unit vector m.
fn reflect(vector: &mut [f64], mirror: &[f64]) {
    let n = vector.len();
    // This dot product uses eight independent sums, which is faster than one.
    let share = DVectorView::from_slice(vector, n).dot(&DVectorView::from_slice(mirror, n));
    add(vector, -2.0 * share, mirror);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::model::LennardJones;

    #[test]
    fn curvatures_are_those_of_the_whole_hessian_but_for_the_free_ones() {
        // A regular tetrahedron of atoms, not aligned with any axis.
        let energy = LennardJones::new(4);
        let surface = Scaled::new(&energy);
        let half = 0.5 * libm::pow(2.0_f64, 1.0 / 6.0) / 2.0_f64.sqrt();
        let corners = [
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ];
        let x: Vec<f64> = corners.iter().flatten().map(|c| 0.3 + half * c).collect();
        let whole = surface.hessian(&x, 1e-5).unwrap().symmetric_eigenvalues();
        let mut whole = whole.as_slice().to_vec();
        whole.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        let (free, stiff) = whole.split_at(6);
        assert!(free.iter().all(|c| c.abs() < 1e-4), "{free:?}");
        let modes = surface.modes(&x, 1e-5).unwrap();
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

    /// The same surface without its second derivatives.
    struct Silent(LennardJones);

    impl Energy for Silent {
        fn space(&self) -> &dyn Space {
            self.0.space()
        }

        fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
            self.0.evaluate(x, gradient)
        }
    }

    #[test]
    fn a_known_hessian_is_taken_as_a_measured_one() {
        let (energy, silent) = (LennardJones::new(3), Silent(LennardJones::new(3)));
        let x = [0.0, 0.1, 0.0, 1.1, 0.0, 0.2, 0.4, 1.0, -0.1];
        let surface = Scaled::new(&energy);
        let axes = surface.across(&x);
        assert_eq!(axes.shape(), (9, 3));
        assert!((axes.tr_mul(&axes) - DMatrix::identity(3, 3)).amax() < 1e-14);
        let known = surface.hessian_between(&axes, &x, 1e-5).unwrap();
        let surface = Scaled::new(&silent);
        let measured = surface.hessian_between(&axes, &x, 1e-5).unwrap();
        assert!((&known - &measured).amax() < 1e-6 * known.amax());
    }

    #[test]
    fn beside_the_edge_of_the_domain_there_are_no_modes() {
        let energy = LennardJones::new(2);
        let surface = Scaled::new(&energy);
        assert!(surface.modes(&[0.0; 6], 1e-5).is_none());
    }

    #[test]
    fn free_motions_do_not_count() {
        // A pair of atoms has one mode and five free motions. V″ = 36 · 4^⅓ along r; the mode of both atoms has twice that.
        let energy = LennardJones::new(2);
        let surface = Scaled::new(&energy);
        let x = [0.0, 0.0, 0.0, libm::pow(2.0_f64, 1.0 / 6.0), 0.0, 0.0];
        let modes = surface.modes(&x, 1e-5).unwrap();
        assert_eq!(modes.curvatures.len(), 1);
        assert!(
            (modes.curvatures[0] - 2.0 * 36.0 * libm::pow(4.0_f64, 1.0 / 3.0)).abs() < 1e-3,
            "{}",
            modes.curvatures[0]
        );
    }
}
