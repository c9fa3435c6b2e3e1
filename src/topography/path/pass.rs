//! Refines the highest point of a path to a pass and descends on both sides.

use serde::{Deserialize, Serialize};

use super::images::Images;
use super::{Path, PathSettings, between};
use crate::energy::Energy;
use crate::optimize::{Quench, QuenchSettings, StopReason, quench_traced};
use crate::space::vector::{dot, norm, scale};
use crate::topography::eigen::Scaled;
use crate::topography::follow::Following;
use crate::topography::minima::MatchTolerance;

const GOLDEN: f64 = 0.381_966_011_250_105;
/// Golden-section probes for the top between images.
const PROBES: usize = 4;
/// How far the true top of a path may lie above its highest sample, relative to the barrier.
const SAMPLING: f64 = 0.1;
/// Number of first points of a descent that must stay on their side of the pass.
const EARLY: usize = 3;
/// How often the first step of a descent is halved at most.
const MOST_HALVINGS: usize = 5;
/// Evaluations of a descent with steps no longer than the displacement off the pass.
const CAREFUL: usize = 20;
/// Greatest number of saddles at which a descent goes on.
const MOST_RIDGES: usize = 3;

/// A stationary point where a path may cross from one basin to another: an index-1 saddle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// Coordinates of the pass.
    pub x: Vec<f64>,
    /// Its energy.
    pub energy: f64,
    /// Gradient norm, energy per length.
    pub residual: f64,
    /// The descents on both sides, from the pass to their ends.
    pub descents: [Path; 2],
}

/// The highest point of a path, between images.
pub(super) struct Peak {
    /// The nearest free image.
    pub(super) image: usize,
    pub(super) x: Vec<f64>,
    pub(super) energy: f64,
    pub(super) tangent: Vec<f64>,
}

/// The pass found by refining a peak.
pub(super) struct Refined {
    pub(super) pass: Pass,
    /// Whether a point of higher index was found first, so that the path lay on a ridge beside the pass.
    pub(super) beside: bool,
}

impl Peak {
    /// The highest point near the highest free image; `None` if all images are pinned.
    pub(super) fn of(energy: &dyn Energy, images: &Images<'_>) -> Option<Self> {
        let path = &images.path;
        let free = (0..path.images.len()).filter(|i| !images.pinned[*i]);
        let top = free.max_by(|i, j| {
            path.energies[*i]
                .total_cmp(&path.energies[*j])
                .then(j.cmp(i))
        })?;
        let space = energy.space();
        let mut tangent = vec![0.0; space.tangents()];
        let mut gradient = tangent.clone();
        let mut point = |s: f64| {
            if s < 0.0 {
                between(
                    space,
                    &path.images[top],
                    &path.images[top - 1],
                    -s,
                    &mut tangent,
                )
            } else {
                between(
                    space,
                    &path.images[top],
                    &path.images[top + 1],
                    s,
                    &mut tangent,
                )
            }
        };
        let (mut low, mut middle, mut high) = (-1.0, 0.0, 1.0);
        let mut best = path.energies[top];
        for _ in 0..PROBES {
            let right = high - middle > middle - low;
            let probe = if right {
                middle + GOLDEN * (high - middle)
            } else {
                middle - GOLDEN * (middle - low)
            };
            let height = energy.evaluate(&point(probe), &mut gradient);
            if height > best && height.is_finite() {
                *(if right { &mut low } else { &mut high }) = middle;
                (middle, best) = (probe, height);
            } else {
                *(if right { &mut high } else { &mut low }) = probe;
            }
        }
        Some(Self {
            image: top,
            x: point(middle),
            energy: best,
            tangent: images.tangent(top),
        })
    }

    /// Norm of the gradient.
    pub(super) fn residual(&self, energy: &dyn Energy) -> f64 {
        let mut gradient = vec![0.0; self.tangent.len()];
        energy.evaluate(&self.x, &mut gradient);
        norm(&gradient)
    }

    /// Refines the peak to a pass that is hardly higher, and descends on both sides.
    ///
    /// A path cannot stay below every pass, but its highest sample can, by a fraction of its height above `floor`.
    pub(super) fn refine(
        &self,
        energy: &dyn Energy,
        floor: f64,
        settings: &PathSettings,
        descent: &QuenchSettings,
        sameness: &MatchTolerance,
    ) -> Option<Refined> {
        let space = energy.space();
        let following = Following {
            tolerance: 10.0 * descent.gradient_tolerance,
            longest: settings.max_step,
            saturation: settings.saturation,
            level: f64::INFINITY,
            difference: 1e-4 * settings.max_step,
            steps: settings.refinement_steps,
            // A path along a mirror plane of the surface may peak at a point of higher index, with a pass beside it.
            kicks: 1,
            keeps_mode: settings.roughness == 0.0,
            ceiling: f64::INFINITY,
            known: &|_, _| None,
        };
        let mut found = Scaled::new(energy)
            .follow(&self.x, Some(&self.tangent), &following)
            .ok()?;
        let beside = found.kicked;
        let mut normal = found.modes.swap_remove(0);
        let (x, height, residual) = (found.x, found.energy, found.residual);
        let mut gradient = vec![0.0; space.tangents()];
        let actual = energy.evaluate(&x, &mut gradient);
        let highest = self.energy + SAMPLING * (self.energy - floor) + sameness.energy;
        if (actual - height).abs() > sameness.energy || height > highest {
            return None;
        }
        let length = norm(&normal);
        scale(&mut normal, length.recip());
        let descents = descend(energy, (&x, height), &normal, settings.push, descent)?;
        let pass = Pass {
            x,
            energy: height,
            residual,
            descents,
        };
        Some(Refined { pass, beside })
    }
}

/// Descents on both sides of a pass after a step of `push` along its unit tangent `mode`; `None` if one does not lead down.
pub(in crate::topography) fn descend(
    energy: &dyn Energy,
    pass: (&[f64], f64),
    mode: &[f64],
    push: f64,
    settings: &QuenchSettings,
) -> Option<[Path; 2]> {
    let side = |push| descend_one_way(energy, pass, mode, push, settings);
    Some([side(push)?, side(-push)?])
}

/// The descent from a pass (point and height) after a step of length `push` (negative for backward) along the unit tangent
/// `mode`; `None` if neither this step nor shorter ones lead down. A descent that crosses the pass at once is repeated with shorter steps.
pub(in crate::topography) fn descend_one_way(
    energy: &dyn Energy,
    (pass, height): (&[f64], f64),
    mode: &[f64],
    push: f64,
    settings: &QuenchSettings,
) -> Option<Path> {
    let space = energy.space();
    let mut gradient = vec![0.0; space.tangents()];
    let mut step = mode.to_vec();
    scale(&mut step, push);
    let mut start = pass.to_vec();
    space.exp(&mut start, &step);
    let mut halvings = 0;
    while energy.evaluate(&start, &mut gradient) >= height {
        if halvings == MOST_HALVINGS {
            return None;
        }
        // In a bent valley a long step leads up the side, and a short one leads down.
        halvings += 1;
        scale(&mut step, 0.5);
        start.copy_from_slice(pass);
        space.exp(&mut start, &step);
    }
    let (mut trace, mut end) = traced(energy, &start, settings);
    let mut toward = vec![0.0; space.tangents()];
    let crossed = trace.images.iter().take(EARLY).any(|x| {
        space.log_near(pass, x, &mut toward);
        dot(&toward, &step) < 0.0
    });
    if crossed {
        // If a minimum is close to the pass, a long first step leads back over the pass.
        let careful = settings
            .clone()
            .with_max_step(push.abs())
            .with_max_evaluations(CAREFUL.min(settings.max_evaluations));
        (trace, end) = traced(energy, &start, &careful);
        if end.stop != StopReason::Converged {
            let (mut rest, last) = traced(energy, &end.x, settings);
            trace.images.append(&mut rest.images);
            trace.energies.append(&mut rest.energies);
            end = last;
        }
    }
    trace.images.insert(0, pass.to_vec());
    trace.energies.insert(0, height);
    trace.images.push(end.x);
    trace.energies.push(end.energy);
    Some(trace)
}

/// Continues a descent that ended at a saddle, on one side of that saddle, until it ends at a minimum.
///
/// A descent from a symmetric pass keeps the symmetry, so it can come to rest where the surface falls to both sides. Only
/// rounding would make it leave. `difference` is the step of the differences of gradients.
pub(in crate::topography) fn leave_ridges(
    energy: &dyn Energy,
    descent: &mut Path,
    push: f64,
    difference: f64,
    settings: &QuenchSettings,
) {
    for _ in 0..MOST_RIDGES {
        let last = descent.images.len() - 1;
        let (x, height) = (&descent.images[last], descent.energies[last]);
        let surface = Scaled::plain(energy);
        let Some(modes) = surface.modes(x, difference) else {
            return;
        };
        if modes.index().0 == 0 {
            return;
        }
        let Some(further) =
            descend_one_way(energy, (x, height), &modes.tangents[0], push, settings)
        else {
            return;
        };
        descent.images.extend(further.images.into_iter().skip(1));
        descent
            .energies
            .extend(further.energies.into_iter().skip(1));
    }
}

/// The points of a descent after its start, and its end.
fn traced(energy: &dyn Energy, start: &[f64], settings: &QuenchSettings) -> (Path, Quench) {
    let mut trace = Path::default();
    let end = quench_traced(energy, start, settings, &mut |x, height| {
        trace.images.push(x.to_vec());
        trace.energies.push(height);
    });
    (trace, end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Euclidean, Space};

    /// The valley y = 50 x² with steep sides. Its floor falls from a pass at the origin.
    struct BentValley(Euclidean);

    impl Energy for BentValley {
        fn space(&self) -> &dyn Space {
            &self.0
        }

        fn evaluate(&self, at: &[f64], gradient: &mut [f64]) -> f64 {
            let (x, off) = (at[0], at[1] - 50.0 * at[0] * at[0]);
            gradient[0] = -2.0 * x + 4.0 * x.powi(3) - 2e5 * x * off;
            gradient[1] = 2e3 * off;
            -x * x + x.powi(4) + 1e3 * off * off
        }
    }

    /// The valley x = 0 falls from a pass at the origin to y = ±1, where the surface falls to both sides.
    struct Fork(Euclidean);

    impl Energy for Fork {
        fn space(&self) -> &dyn Space {
            &self.0
        }

        fn evaluate(&self, at: &[f64], gradient: &mut [f64]) -> f64 {
            let (x, y) = (at[0], at[1]);
            let fall = 0.5 - y * y;
            gradient[0] = 2.0 * x * fall + 4.0 * x.powi(3);
            gradient[1] = -2.0 * x * x * y + 4.0 * y * (y * y - 1.0);
            x * x * fall + x.powi(4) + (y * y - 1.0).powi(2)
        }
    }

    #[test]
    fn a_descent_along_a_mirror_plane_goes_on_to_a_minimum() {
        let energy = Fork(Euclidean::new(2));
        let settings = QuenchSettings::for_scales(1.0, 1.0);
        let mut down =
            descend_one_way(&energy, (&[0.0, 0.0], 1.0), &[0.0, 1.0], 0.1, &settings).unwrap();
        let end = |path: &Path| path.images[path.images.len() - 1].clone();
        assert!(end(&down)[0].abs() < 1e-12 && (end(&down)[1] - 1.0).abs() < 1e-6);
        leave_ridges(&energy, &mut down, 0.1, 1e-4, &settings);
        let mut gradient = [0.0; 2];
        let lowest = energy.evaluate(&end(&down), &mut gradient);
        assert!(
            end(&down)[0].abs() > 0.3 && norm(&gradient) < 1e-5,
            "{lowest}"
        );
        assert!(
            down.energies
                .windows(2)
                .all(|pair| pair[1] <= pair[0] + 1e-12)
        );
        // At a minimum there is nothing to leave.
        let whole = down.images.len();
        leave_ridges(&energy, &mut down, 0.1, 1e-4, &settings);
        assert_eq!(down.images.len(), whole);
    }

    #[test]
    fn a_step_down_a_bent_valley_is_shortened() {
        let energy = BentValley(Euclidean::new(2));
        let pass = [0.0, 0.0];
        let push = 2e-3;
        let mut gradient = [0.0; 2];
        assert!(energy.evaluate(&[push, 0.0], &mut gradient) > 0.0);
        let settings = QuenchSettings::for_scales(0.1, 0.1);
        let descents = descend(&energy, (&pass, 0.0), &[1.0, 0.0], push, &settings).unwrap();
        let ends = descents.map(|path| path.images[path.images.len() - 1][0]);
        assert!(ends[0] > 0.1 && ends[1] < -0.1, "{ends:?}");
        // No step along the valley's side leads down.
        assert!(descend(&energy, (&pass, 0.0), &[0.0, 1.0], push, &settings).is_none());
    }
}
