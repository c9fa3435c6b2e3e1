//! Eigenvector following: uphill along one mode and downhill along all others, to a stationary point of index 1.

use super::eigen::{Modes, Piece};
use crate::space::vector::{add, dot, norm, scale, times};

/// Steps between two Hessians; in between the last one stands. Correcting it (Bofill's update) saves a fifth of the
/// evaluations of a cluster of 7 or 8 atoms and costs six tenths more time, for its modes.
const REFRESH: usize = 3;
/// Errors of the predicted change of energy, as shares of its parts: above the first a step is taken back, above the
/// second the next one is shorter, below the third it may be longer.
const ERRORS: [f64; 3] = [1.0, 0.5, 0.2];
/// Shortest trust radius, as a share of the longest: a step is never taken back below.
const SHORTEST: f64 = 1e-3;
/// Energies closer than this share of their size differ by rounding only.
const ROUNDING: f64 = 1e-13;
/// Length of a step off a point of higher index, as a share of the longest.
const KICK: f64 = 0.3;

/// How to follow.
#[derive(Clone, Copy)]
pub(super) struct Following<'a> {
    /// Converged when the norm of the gradient is at most this, energy per length.
    pub(super) tolerance: f64,
    /// Longest step, by scaled tangents.
    pub(super) longest: f64,
    /// Length at which the step along one mode levels off, by scaled tangents.
    pub(super) saturation: f64,
    /// Distance over which gradients are differenced, by scaled tangents.
    pub(super) difference: f64,
    /// Steps allowed.
    pub(super) steps: usize,
    /// How often to go on, along its second mode, from a point of higher index.
    pub(super) kicks: usize,
    /// Energy above which nothing is sought; a search that starts higher must not rise.
    pub(super) ceiling: f64,
    /// The number of the known saddle at a point of this energy: a search that comes to one has nothing more to measure.
    pub(super) known: &'a dyn Fn(&[f64], f64) -> Option<usize>,
}

/// Why a search brings no saddle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lost {
    /// It came to a known one.
    Known(usize),
    /// It left the domain.
    Outside,
    /// It rose above the ceiling.
    High,
    /// It did not converge within the steps allowed.
    Steps,
    /// It converged to a point of another index.
    Index,
    /// It came to where the way up has no curvature: part of it left for infinity.
    Flat,
}

/// An index-1 stationary point of a piece.
pub(super) struct Saddle {
    pub(super) x: Vec<f64>,
    pub(super) energy: f64,
    /// Norm of the gradient, energy per length.
    pub(super) residual: f64,
    /// Curvatures by scaled tangents, lowest first: only the first is negative.
    pub(super) curvatures: Vec<f64>,
    /// Plain unit tangents along which they are taken.
    pub(super) modes: Vec<Vec<f64>>,
    /// Whether the search met a point of higher index first.
    pub(super) kicked: bool,
}

/// Where a search is, and what is known of the surface there.
struct Here {
    x: Vec<f64>,
    energy: f64,
    gradient: Vec<f64>,
    /// Whether the modes were measured here.
    exact: bool,
}

impl Piece<'_> {
    /// Follows the mode most like `hint` (a plain tangent; the lowest mode if none) uphill and all others downhill, to a
    /// stationary point of index 1. Once the followed mode is the only one of negative curvature it is the lowest, and
    /// stays so; while there are others it is kept to, since a search that changes between them can go to and fro for ever.
    ///
    /// Steps after D. J. Wales, J. Chem. Phys. 101, 3750 (1994): along each mode 2g / (|λ| (1 + √(1 + 4 g²/(λ² s²)))),
    /// which is g/|λ| where that is short and levels off at the length s (1 in the paper, whatever the unit), within a
    /// trust radius that follows the error of the predicted energy; the Hessian by central differences, every third step
    /// and at the end.
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
            let uphill = followed.as_ref().map_or(0, |hint| modes.most_like(hint));
            if modes.curvatures[uphill].abs() <= modes.flat() {
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
            // An error that is not a number refuses as well.
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

    /// Measures the Hessian, and its modes.
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

/// A step by scaled tangents and what the quadratic model expects of it.
struct Step {
    tangent: Vec<f64>,
    length: f64,
    /// Expected change of energy.
    rise: f64,
    /// Sum of the sizes of its parts along the modes.
    parts: f64,
}

impl Step {
    /// Up along mode `uphill`, down along all others, at most `trust` long.
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
        let mut along: Vec<f64> = (modes.curvatures.iter().zip(&slopes).enumerate())
            .map(|(m, (curvature, slope))| {
                if curvature.abs() < flat && slope.abs() <= settings.tolerance {
                    // A symmetry the space does not name: a step along it would be noise over noise.
                    return 0.0;
                }
                let stiffness = curvature.abs().max(f64::MIN_POSITIVE);
                let ratio = 2.0 * slope / (stiffness * settings.saturation);
                let length = 2.0 * slope / (stiffness * (1.0 + (1.0 + ratio * ratio).sqrt()));
                if m == uphill { length } else { -length }
            })
            .collect();
        let length = norm(&along);
        if length > trust {
            scale(&mut along, trust / length);
        }
        let mut step = Self {
            tangent: vec![0.0; gradient.len()],
            length: length.min(trust),
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
    use crate::energy::model::{DoubleWell, MullerBrown, ThreeHole};
    use crate::space::{Euclidean, Space};

    fn following(tolerance: f64) -> Following<'static> {
        Following {
            tolerance,
            longest: 0.1,
            saturation: 1.0,
            difference: 1e-5,
            steps: 60,
            kicks: 0,
            ceiling: f64::INFINITY,
            known: &|_, _| None,
        }
    }

    #[test]
    fn finds_published_saddles() {
        let energy = MullerBrown::new();
        let piece = Piece::new(&energy, Vec::new());
        for (start, tangent, height) in [
            ([-0.75, 0.65], [-0.7, 0.7], -40.664843508657),
            ([0.2, 0.35], [0.8, -0.6], -72.248940112325),
        ] {
            let saddle = piece
                .follow(&start, Some(&tangent), &following(1e-8))
                .ok()
                .unwrap();
            assert!((saddle.energy - height).abs() < 1e-8, "{}", saddle.energy);
        }
    }

    #[test]
    fn a_hilltop_is_not_a_saddle() {
        let energy = ThreeHole::new();
        let piece = Piece::new(&energy, Vec::new());
        let top = [0.0, 0.519186741892];
        let found = piece.follow(&top, Some(&[1.0, 0.0]), &following(1e-6));
        assert_eq!(found.err(), Some(Lost::Index));
    }

    #[test]
    fn a_search_may_go_on_from_a_hilltop() {
        // Of the four saddles around it at height 1, one a side.
        let energy = DoubleWell::new(2);
        let kicked = Following {
            kicks: 1,
            ..following(1e-8)
        };
        let found = Piece::new(&energy, Vec::new()).follow(&[0.0, 0.0], None, &kicked);
        assert!((found.ok().unwrap().energy - 1.0).abs() < 1e-12);
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
        let found = piece.follow(&[0.7, 0.4, 0.2], Some(&[0.0, 0.1, 1.0]), &following(1e-9));
        let saddle = found.ok().unwrap();
        assert!((saddle.energy - 1.0).abs() < 1e-12, "{}", saddle.energy);
        assert!(saddle.modes[0][2].abs() > 0.999999);
    }
}
