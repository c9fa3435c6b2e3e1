//! Eigenvector following: from near a pass to the index-1 stationary point, on one smooth piece of an energy.

use faer::{Mat, Side};

use crate::energy::Energy;
use crate::space::Space;
use crate::space::vector::{add, dot, norm, scale, times};

/// Steps between two exact Hessians; in between it is updated.
const REFRESH: usize = 5;
/// Curvatures smaller than this share of the largest have no sign.
const FLAT: f64 = 1e-6;

/// One smooth piece of an energy: its discrete choice held, in tangents divided by the step scales.
pub(super) struct Piece<'e> {
    energy: &'e dyn Energy,
    choice: Vec<u32>,
    scales: Vec<f64>,
}

/// An index-1 stationary point of a piece.
pub(super) struct Saddle {
    pub(super) x: Vec<f64>,
    pub(super) energy: f64,
    /// Norm of the gradient, energy per length.
    pub(super) residual: f64,
    /// Unit tangent along the only negative curvature.
    pub(super) mode: Vec<f64>,
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

    /// A tangent by scaled tangents.
    pub(super) fn scaled(&self, tangent: &[f64]) -> Vec<f64> {
        let parts = tangent.iter().zip(&self.scales);
        parts.map(|(t, s)| t / s).collect()
    }

    /// Norm of a gradient by scaled tangents, in the metric.
    pub(super) fn size(&self, gradient: &[f64]) -> f64 {
        let plain = gradient.iter().zip(&self.scales).map(|(g, s)| g / s);
        plain.map(|g| g * g).sum::<f64>().sqrt()
    }

    /// Orthonormal scaled tangents along which nothing changes.
    fn free(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let mut free: Vec<Vec<f64>> = Vec::new();
        for mode in self.space().zero_modes(x).chunks_exact(self.scales.len()) {
            let mut mode: Vec<f64> = mode.iter().zip(&self.scales).map(|(m, s)| m / s).collect();
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

    /// Hessian by central differences of the gradient, symmetrised; `None` next to the edge of the domain.
    fn hessian(&self, x: &[f64], difference: f64) -> Option<Mat<f64>> {
        let n = self.scales.len();
        let mut columns = Mat::zeros(n, n);
        let mut step = vec![0.0; n];
        let (mut ahead, mut behind) = (step.clone(), step.clone());
        for j in 0..n {
            step[j] = difference;
            let up = self.evaluate(&self.moved(x, &step), &mut ahead);
            step[j] = -difference;
            let down = self.evaluate(&self.moved(x, &step), &mut behind);
            step[j] = 0.0;
            if !(up.is_finite() && down.is_finite()) {
                return None;
            }
            for i in 0..n {
                columns[(i, j)] = (ahead[i] - behind[i]) / (2.0 * difference);
            }
        }
        Some(Mat::from_fn(n, n, |i, j| {
            f64::midpoint(columns[(i, j)], columns[(j, i)])
        }))
    }

    /// Eigenvalues and eigenvectors of `hessian`, lowest first, the free directions left out.
    fn modes(&self, x: &[f64], hessian: &Mat<f64>) -> Option<Vec<(f64, Vec<f64>)>> {
        let (n, free) = (self.scales.len(), self.free(x));
        let bound = (0..n)
            .map(|i| (0..n).map(|j| hessian[(i, j)].abs()).sum::<f64>())
            .fold(0.0, f64::max);
        // P H P + 4 bound · (1 − P): the free directions go to the very top and are cut off there.
        let mut matrix = hessian.clone();
        for mode in &free {
            let image: Vec<f64> = (0..n)
                .map(|i| (0..n).map(|j| matrix[(i, j)] * mode[j]).sum())
                .collect();
            let along = dot(&image, mode) + 4.0 * bound;
            for i in 0..n {
                for j in 0..n {
                    matrix[(i, j)] +=
                        along * mode[i] * mode[j] - image[i] * mode[j] - mode[i] * image[j];
                }
            }
        }
        let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
        let values = eigen.S().column_vector();
        let vector = |k: usize| (0..n).map(|i| eigen.U()[(i, k)]).collect();
        Some(
            (0..n - free.len())
                .map(|k| (values[k], vector(k)))
                .collect(),
        )
    }

    /// Follows the mode most like `tangent` (plain) uphill and all others downhill, to a stationary point of index 1.
    ///
    /// Steps after D. J. Wales, J. Chem. Phys. 101, 3750 (1994): along each mode 2g / (|λ| (1 + √(1 + 4 g²/λ²))); the
    /// Hessian by central differences, updated in between (J. M. Bofill, J. Comput. Chem. 15, 1 (1994)). The index is
    /// that of an exact Hessian at the end. `None` if it does not converge within `steps` or the index is not one.
    pub(super) fn follow(
        &self,
        start: &[f64],
        tangent: &[f64],
        tolerance: f64,
        longest: f64,
        steps: usize,
    ) -> Option<Saddle> {
        let difference = 1e-4 * longest;
        let mut x = start.to_vec();
        let mut gradient = vec![0.0; self.scales.len()];
        let mut energy = self.evaluate(&x, &mut gradient);
        let mut hessian = self.hessian(&x, difference)?;
        let mut exact = true;
        let mut trust = longest;
        let mut followed = self.scaled(tangent);
        for k in 1..=steps {
            if !energy.is_finite() {
                return None;
            }
            if self.size(&gradient) <= tolerance {
                if !exact {
                    hessian = self.hessian(&x, difference)?;
                }
                return self.verified(x, energy, &gradient, &hessian);
            }
            let modes = self.modes(&x, &hessian)?;
            let uphill = (0..modes.len()).max_by(|i, j| {
                let overlap = |k: &usize| dot(&modes[*k].1, &followed).abs();
                overlap(i).total_cmp(&overlap(j)).then(j.cmp(i))
            })?;
            followed.clone_from(&modes[uphill].1);
            let mut step = vec![0.0; self.scales.len()];
            let largest = stiffest(&modes);
            for (m, (curvature, mode)) in modes.iter().enumerate() {
                let slope = dot(&gradient, mode);
                if curvature.abs() < FLAT * largest && slope.abs() <= tolerance {
                    // A symmetry the space does not name: a step along it would be noise over noise.
                    continue;
                }
                let stiffness = curvature.abs().max(f64::MIN_POSITIVE);
                let ratio = 2.0 * slope / stiffness;
                let length = 2.0 * slope / (stiffness * (1.0 + (1.0 + ratio * ratio).sqrt()));
                add(&mut step, if m == uphill { length } else { -length }, mode);
            }
            let length = norm(&step);
            if length > trust {
                scale(&mut step, trust / length);
            }
            let next = self.moved(&x, &step);
            let mut slope = vec![0.0; self.scales.len()];
            let energy_there = self.evaluate(&next, &mut slope);
            if !energy_there.is_finite() || norm(&slope) > 4.0 * norm(&gradient) {
                // Too far to trust the quadratic model.
                trust = 0.25 * length.min(trust);
                if trust < 1e-6 * longest {
                    return None;
                }
                if !exact {
                    hessian = self.hessian(&x, difference)?;
                    exact = true;
                }
                continue;
            }
            trust = longest.min(2.0 * trust);
            if k % REFRESH == 0 {
                hessian = self.hessian(&next, difference)?;
                exact = true;
            } else {
                update(&mut hessian, &step, &gradient, &slope);
                exact = false;
            }
            (x, energy, gradient) = (next, energy_there, slope);
        }
        None
    }

    fn verified(
        &self,
        x: Vec<f64>,
        energy: f64,
        gradient: &[f64],
        hessian: &Mat<f64>,
    ) -> Option<Saddle> {
        let modes = self.modes(&x, hessian)?;
        let largest = stiffest(&modes);
        let (lowest, second) = (modes.first()?, modes.get(1));
        let first_order =
            lowest.0 < -FLAT * largest && second.is_none_or(|(value, _)| *value > -FLAT * largest);
        if !first_order {
            return None;
        }
        let mut mode = times(&lowest.1, &self.scales);
        let length = norm(&mode);
        scale(&mut mode, length.recip());
        Some(Saddle {
            residual: self.size(gradient),
            x,
            energy,
            mode,
        })
    }
}

fn stiffest(modes: &[(f64, Vec<f64>)]) -> f64 {
    let sizes = modes.iter().map(|(curvature, _)| curvature.abs());
    sizes.fold(0.0, f64::max)
}

/// Bofill's mixture of the symmetric rank-one and the Powell update.
fn update(hessian: &mut Mat<f64>, step: &[f64], before: &[f64], after: &[f64]) {
    let n = step.len();
    let error: Vec<f64> = (0..n)
        .map(|i| after[i] - before[i] - (0..n).map(|j| hessian[(i, j)] * step[j]).sum::<f64>())
        .collect();
    let (es, ss, ee) = (dot(&error, step), dot(step, step), dot(&error, &error));
    if ee * ss == 0.0 {
        return;
    }
    let mix = es * es / (ee * ss);
    for i in 0..n {
        for j in 0..n {
            // Where es vanishes so does the share of the first update.
            let rank_one = if es == 0.0 {
                0.0
            } else {
                error[i] * error[j] / es
            };
            let powell =
                (error[i] * step[j] + step[i] * error[j]) / ss - es * step[i] * step[j] / (ss * ss);
            hessian[(i, j)] += mix * rank_one + (1.0 - mix) * powell;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::model::{LennardJones, MullerBrown, ThreeHole};
    use crate::space::Euclidean;

    #[test]
    fn finds_published_saddles() {
        let energy = MullerBrown::new();
        let piece = Piece::new(&energy, Vec::new());
        for (start, tangent, height) in [
            ([-0.75, 0.65], [-0.7, 0.7], -40.664843508657),
            ([0.2, 0.35], [0.8, -0.6], -72.248940112325),
        ] {
            let saddle = piece.follow(&start, &tangent, 1e-8, 0.1, 60).unwrap();
            assert!((saddle.energy - height).abs() < 1e-8, "{}", saddle.energy);
        }
    }

    #[test]
    fn a_hilltop_is_not_a_saddle() {
        let energy = ThreeHole::new();
        let piece = Piece::new(&energy, Vec::new());
        let top = [0.0, 0.519186741892];
        let found = piece.follow(&top, &[1.0, 0.0], 1e-6, 0.1, 0);
        assert!(found.is_none());
        let mut gradient = [0.0; 2];
        let height = piece.evaluate(&top, &mut gradient);
        let hessian = piece.hessian(&top, 1e-5).unwrap();
        assert!(
            piece
                .verified(top.to_vec(), height, &gradient, &hessian)
                .is_none()
        );
    }

    /// 5 (√(x² + y²) − 1)² + (z² − 1)²: the same all around the z axis, as grasps of a bottle are.
    struct Ring(Euclidean);

    impl Energy for Ring {
        fn space(&self) -> &dyn Space {
            &self.0
        }

        fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
            let radius = x[0].hypot(x[1]);
            let (stretch, well) = (radius - 1.0, x[2] * x[2] - 1.0);
            gradient[0] = 10.0 * stretch * x[0] / radius;
            gradient[1] = 10.0 * stretch * x[1] / radius;
            gradient[2] = 4.0 * x[2] * well;
            5.0 * stretch * stretch + well * well
        }
    }

    #[test]
    fn an_unnamed_symmetry_does_no_harm() {
        let energy = Ring(Euclidean::new(3));
        let piece = Piece::new(&energy, Vec::new());
        let found = piece.follow(&[0.7, 0.4, 0.2], &[0.0, 0.1, 1.0], 1e-9, 0.1, 60);
        let saddle = found.unwrap();
        assert!((saddle.energy - 1.0).abs() < 1e-12, "{}", saddle.energy);
        assert!(saddle.mode[2].abs() > 0.999999);
    }

    #[test]
    fn free_motions_do_not_count() {
        // A pair of atoms has one mode besides five free motions: V″ = 36 · 4^⅓ along r, twice that for both atoms.
        let energy = LennardJones::new(2);
        let piece = Piece::new(&energy, Vec::new());
        let x = [0.0, 0.0, 0.0, 2.0_f64.powf(1.0 / 6.0), 0.0, 0.0];
        let modes = piece.modes(&x, &piece.hessian(&x, 1e-5).unwrap()).unwrap();
        assert_eq!(modes.len(), 1);
        assert!(
            (modes[0].0 - 2.0 * 36.0 * 4.0_f64.powf(1.0 / 3.0)).abs() < 1e-3,
            "{}",
            modes[0].0
        );
    }
}
