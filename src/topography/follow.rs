//! Eigenvector following: a search that goes uphill along one mode and downhill along all others to a saddle of index 1.

use super::eigen::{Modes, Scaled, shifted};
use crate::space::vector::{add, dot, norm, scale, times};

/// Steps between two Hessians; the last one is used in between. Correcting it with Bofill's update saves a fifth of the
/// evaluations for a cluster of 7 or 8 atoms, but takes 60 % more time because of the extra diagonalisations.
const REFRESH: usize = 3;
/// Limits of the error of the predicted energy change, relative to the sum of its parts. Above the first limit a step is
/// rejected, above the second the next one is shorter, and below the third the next one may be longer.
const ERRORS: [f64; 3] = [1.0, 0.5, 0.2];
/// Shortest trust radius, relative to the longest. Steps below it are never rejected.
const SHORTEST: f64 = 1e-3;
/// Relative energy difference attributed to rounding.
const ROUNDING: f64 = 1e-13;
/// Length of the step away from a point of higher index, relative to the longest step.
const KICK: f64 = 0.3;

/// Settings of [`Scaled::follow`].
#[derive(Clone, Copy)]
pub(super) struct Following<'a> {
    /// Converged when the norm of the gradient is at most this, energy per length.
    pub(super) tolerance: f64,
    /// Longest step, in scaled tangents.
    pub(super) longest: f64,
    /// Length at which the step along one mode saturates, in scaled tangents.
    pub(super) saturation: f64,
    /// Where the curvature of the uphill mode has no sign, the search goes on if the slope there matters more than any such
    /// curvature over this length, in scaled tangents. If it is infinite, the search ends there.
    pub(super) level: f64,
    /// Step of the finite differences of gradients, in scaled tangents.
    pub(super) difference: f64,
    pub(super) steps: usize,
    /// How often the search may continue from a point of higher index, along its second mode.
    pub(super) kicks: usize,
    /// Whether the search keeps to its mode even where the surface curves up along it and down along another. On a surface
    /// with ripples it must not: modes that resemble the first one only by chance lead up walls.
    pub(super) keeps_mode: bool,
    /// Greatest energy of interest. A search that starts higher must not rise.
    pub(super) ceiling: f64,
    /// Returns the number of the known saddle at a point of this energy. A search that reaches a known saddle stops.
    pub(super) known: &'a dyn Fn(&[f64], f64) -> Option<usize>,
}

impl Following<'_> {
    /// Whether neither the curvature nor the slope along the mode leads anywhere. Between a minimum and a saddle the curvature
    /// vanishes and the slope does not; where a fragment moves off, both do.
    fn is_level(&self, modes: &Modes, mode: usize, gradient: &[f64]) -> bool {
        let flat = modes.flat();
        let slope = dot(gradient, &modes.tangents[mode]).abs();
        modes.curvatures[mode].abs() <= flat && slope / self.level <= flat
    }
}

/// Reason why a search found no saddle.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Lost {
    /// It reached a known saddle.
    Known(usize),
    /// It left the domain.
    Outside,
    /// It rose above the ceiling.
    High,
    /// It did not converge within the steps allowed.
    Steps,
    /// It converged to a point of another index.
    Index,
    /// It converged to a point of this energy where one curvature is too small to have a sign and all others are positive.
    Undecided(Vec<f64>, f64),
    /// The curvature of the uphill mode vanished: a fragment moved off to infinity.
    Flat,
}

/// An index-1 stationary point of one smooth surface of the energy.
pub(super) struct Saddle {
    pub(super) x: Vec<f64>,
    pub(super) energy: f64,
    pub(super) residual: f64,
    /// Curvatures in scaled tangents, lowest first. Only the first is negative.
    pub(super) curvatures: Vec<f64>,
    /// Plain unit tangents of the modes.
    pub(super) modes: Vec<Vec<f64>>,
    /// Whether the search passed a point of higher index.
    pub(super) kicked: bool,
}

struct Here {
    x: Vec<f64>,
    energy: f64,
    gradient: Vec<f64>,
    /// Whether the modes were measured at this point.
    exact: bool,
}

impl Scaled<'_> {
    /// Follows the mode most similar to `hint` (a plain tangent; without it, the lowest mode) uphill and all others
    /// downhill to a stationary point of index 1. Once the followed mode is the only one with negative curvature, the
    /// lowest mode is followed. Before that the search keeps to its mode, because one that switches between modes can
    /// oscillate for ever.
    ///
    /// The steps follow D. J. Wales, J. Chem. Phys. 101, 3750 (1994): along each mode 2g / (|λ| (1 + √(1 + 4 g²/(λ² s²)))).
    /// This is g/|λ| for short steps and saturates at the length s (1 in the paper, whatever the unit). The trust radius
    /// adapts to the error of the predicted energy. The Hessian comes from central differences, at every third step and at
    /// the end.
    pub(super) fn follow(
        &self,
        start: &[f64],
        hint: Option<&[f64]>,
        settings: &Following<'_>,
    ) -> Result<Saddle, Lost> {
        let difference = settings.difference;
        let mut gradient = vec![0.0; self.scales.len()];
        let mut here = Here {
            energy: self.evaluate(start, &mut gradient),
            x: start.to_vec(),
            gradient,
            exact: false,
        };
        if !here.energy.is_finite() {
            return Err(Lost::Outside);
        }
        let mut modes = self.measure(&mut here, difference)?;
        let ceiling = settings.ceiling.max(here.energy);
        let mut followed: Option<Vec<f64>> = hint.map(|tangent| self.scaled(tangent));
        let (mut trust, mut kicks) = (settings.longest, settings.kicks);
        for k in 1..=settings.steps {
            if here.energy > ceiling {
                return Err(Lost::High);
            }
            if let Some(saddle) = (settings.known)(&here.x, here.energy) {
                return Err(Lost::Known(saddle));
            }
            if self.size(&here.gradient) <= settings.tolerance {
                if !here.exact {
                    modes = self.measure(&mut here, difference)?;
                }
                match modes.index() {
                    (1, _) => return Ok(self.saddle(here, modes, kicks < settings.kicks)),
                    (0, 1) => return Err(Lost::Undecided(here.x, here.energy)),
                    (0, _) => return Err(Lost::Index),
                    _ if kicks == 0 => return Err(Lost::Index),
                    _ => {
                        kicks -= 1;
                        let mut kick = modes.tangents[1].clone();
                        scale(&mut kick, KICK * settings.longest);
                        here.x = self.moved(&here.x, &kick);
                        here.energy = self.evaluate(&here.x, &mut here.gradient);
                        modes = self.measure(&mut here, difference)?;
                        followed = None;
                        continue;
                    }
                }
            }
            let mut uphill = followed.as_ref().map_or(0, |hint| modes.most_like(hint));
            if !settings.keeps_mode && modes.curvatures[uphill] > 0.0 && modes.curvatures[0] < 0.0 {
                uphill = 0;
            }
            if settings.is_level(&modes, uphill, &here.gradient) {
                return Err(Lost::Flat);
            }
            let reached = uphill == 0 && modes.index().0 == 1;
            followed = (!reached).then(|| modes.tangents[uphill].clone());
            let step = Step::new(&modes, &here.gradient, uphill, trust, settings);
            let x = self.moved(&here.x, &step.tangent);
            let mut gradient = vec![0.0; self.scales.len()];
            let energy = self.evaluate(&x, &mut gradient);
            let error = (energy - here.energy - step.rise).abs()
                / (step.parts + ROUNDING * here.energy.abs());
            // A step whose error is NaN is rejected too.
            if (error.is_nan() || error > ERRORS[0]) && step.length > SHORTEST * settings.longest {
                trust = 0.25 * step.length;
                if !here.exact {
                    modes = self.measure(&mut here, difference)?;
                }
                continue;
            }
            if error > ERRORS[1] {
                trust = 0.5 * step.length;
            } else if error < ERRORS[2] {
                trust = settings.longest.min(2.0 * trust);
            }
            (here.x, here.energy, here.gradient, here.exact) = (x, energy, gradient, false);
            if k % REFRESH == 0 {
                modes = self.measure(&mut here, difference)?;
            }
        }
        Err(Lost::Steps)
    }

    fn measure(&self, here: &mut Here, difference: f64) -> Result<Modes, Lost> {
        here.exact = true;
        self.modes(&here.x, difference).ok_or(Lost::Outside)
    }

    fn saddle(&self, here: Here, modes: Modes, kicked: bool) -> Saddle {
        let plain = |mode: &Vec<f64>| {
            let mut mode = times(mode, &self.scales);
            let length = norm(&mode);
            scale(&mut mode, length.recip());
            mode
        };
        Saddle {
            residual: self.size(&here.gradient),
            x: here.x,
            energy: here.energy,
            curvatures: modes.curvatures,
            modes: modes.tangents.iter().map(plain).collect(),
            kicked,
        }
    }
}

/// A step in scaled tangents with the prediction of the quadratic model.
struct Step {
    tangent: Vec<f64>,
    length: f64,
    /// Predicted change of energy.
    rise: f64,
    /// Sum of the absolute contributions of the modes to the change.
    parts: f64,
}

impl Step {
    /// A step up along mode `uphill` and down along all others, of length at most `trust`.
    fn new(
        modes: &Modes,
        gradient: &[f64],
        uphill: usize,
        trust: f64,
        settings: &Following<'_>,
    ) -> Self {
        let flat = modes.flat();
        let slopes: Vec<f64> = modes
            .tangents
            .iter()
            .map(|mode| dot(gradient, mode))
            .collect();
        let along = shifted(norm(gradient), trust, |shift| {
            (modes.curvatures.iter().zip(&slopes).enumerate())
                .map(|(m, (curvature, slope))| {
                    if curvature.abs() < flat && slope.abs() <= settings.tolerance {
                        // This is a symmetry that the space does not declare. A step along it would be noise divided by
                        // noise.
                        return 0.0;
                    }
                    let stiffness = curvature.abs().max(f64::MIN_POSITIVE) + shift;
                    let ratio = 2.0 * slope / (stiffness * settings.saturation);
                    let length = 2.0 * slope / (stiffness * (1.0 + (1.0 + ratio * ratio).sqrt()));
                    if m == uphill { length } else { -length }
                })
                .collect()
        });
        let mut step = Self {
            tangent: vec![0.0; gradient.len()],
            length: norm(&along),
            rise: 0.0,
            parts: 0.0,
        };
        for (m, length) in along.iter().enumerate() {
            add(&mut step.tangent, *length, &modes.tangents[m]);
            let part = length * (slopes[m] + 0.5 * modes.curvatures[m] * length);
            step.rise += part;
            step.parts += part.abs();
        }
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::Energy;
    use crate::energy::model::{DoubleWell, ThreeHole};
    use crate::space::{Euclidean, Space};

    fn following(tolerance: f64) -> Following<'static> {
        Following {
            tolerance,
            longest: 0.1,
            saturation: 1.0,
            level: f64::INFINITY,
            difference: 1e-5,
            steps: 60,
            kicks: 0,
            keeps_mode: true,
            ceiling: f64::INFINITY,
            known: &|_, _| None,
        }
    }

    #[test]
    fn a_hilltop_is_not_a_saddle() {
        let energy = ThreeHole::new();
        let surface = Scaled::new(&energy);
        let top = [0.0, 0.519186741892];
        let found = surface.follow(&top, Some(&[1.0, 0.0]), &following(1e-6));
        assert_eq!(found.err(), Some(Lost::Index));
    }

    #[test]
    fn a_search_may_go_on_from_a_hilltop() {
        // The hilltop has four saddles around it at height 1, one on each side.
        let energy = DoubleWell::new(2);
        let kicked = Following {
            kicks: 1,
            keeps_mode: true,
            ..following(1e-8)
        };
        let found = Scaled::new(&energy).follow(&[0.0, 0.0], None, &kicked);
        assert!((found.ok().unwrap().energy - 1.0).abs() < 1e-12);
    }

    /// 5 (√(x² + y²) − 1)² + (z² − 1)², which is symmetric about the z axis, like grasps of a bottle.
    struct Ring(Euclidean);

    impl Energy for Ring {
        fn space(&self) -> &dyn Space {
            &self.0
        }

        fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
            let radius = libm::hypot(x[0], x[1]);
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
        let surface = Scaled::new(&energy);
        let found = surface.follow(&[0.7, 0.4, 0.2], Some(&[0.0, 0.1, 1.0]), &following(1e-9));
        let saddle = found.ok().unwrap();
        assert!((saddle.energy - 1.0).abs() < 1e-12, "{}", saddle.energy);
        assert!(saddle.modes[0][2].abs() > 0.999999);
    }
}
