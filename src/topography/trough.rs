//! Walks along sets of stationary points that are not isolated: rings, troughs and plateaus, and the passes that are rings.

use super::audit::AuditSettings;
use super::eigen::{Modes, Scaled};
use crate::space::vector::{add, dot, norm, scale, times};

/// Directions of lower curvature than this fraction of the greatest are level. Differences of gradients leave about 10⁻⁸ of
/// the curvature of a straight direction, and a step of a walk ends off the level direction, where the curvature is not 0.
const LEVEL: f64 = 1e-4;
/// Greatest number of steps of Newton's method back to the set.
const RETURNS: usize = 12;
/// Length of a step of a walk as a fraction of the distance between its ends: a ring has at least 25 steps around it.
const STEP: f64 = 0.125;
/// Length of the step from the end of a trough into it, in distance tolerances.
const INWARD: f64 = 10.0;
/// Greatest number of steps of a walk in one sense.
const STEPS: usize = 96;

/// A stationary point of a set, with its modes.
pub(super) struct Place {
    pub(super) x: Vec<f64>,
    pub(super) energy: f64,
    modes: Modes,
}

impl Place {
    /// The level directions, as orthonormal scaled tangents.
    fn level(&self) -> Vec<Vec<f64>> {
        let most = LEVEL * self.modes.stiffest();
        let modes = self.modes.curvatures.iter().zip(&self.modes.tangents);
        let level = modes.filter(|(curvature, _)| curvature.abs() <= most);
        level.map(|(_, tangent)| tangent.clone()).collect()
    }
}

/// The stationary point that Newton's method reaches from `start` in all directions but the level ones, whatever the index.
/// `None` if there is none within `reach` (in scaled tangents).
pub(super) fn settle(
    surface: &Scaled<'_>,
    start: &[f64],
    reach: f64,
    settings: &AuditSettings,
) -> Option<Place> {
    let mut x = start.to_vec();
    let mut gradient = vec![0.0; surface.space().tangents()];
    for _ in 0..RETURNS {
        let energy = surface.evaluate(&x, &mut gradient);
        let modes = surface.modes(&x, settings.difference)?;
        if !energy.is_finite() {
            return None;
        }
        if surface.size(&gradient) <= settings.gradient_tolerance {
            return Some(Place { x, energy, modes });
        }
        let most = LEVEL * modes.stiffest();
        let mut step = vec![0.0; gradient.len()];
        for (curvature, tangent) in modes.curvatures.iter().zip(&modes.tangents) {
            if curvature.abs() > most {
                add(&mut step, -dot(&gradient, tangent) / curvature, tangent);
            }
        }
        let length = norm(&step);
        if length > reach {
            return None;
        }
        x = surface.moved(&x, &step);
    }
    None
}

/// The minimum `from` as a place of its set. At the end of a trough no direction is level, so that place is a step inward.
fn beginning(
    surface: &Scaled<'_>,
    from: &[f64],
    gap: f64,
    settings: &AuditSettings,
) -> Option<Place> {
    let start = settle(surface, from, gap, settings)?;
    if !start.level().is_empty() {
        return Some(start);
    }
    let inward = |length: f64| {
        let mut step = start.modes.tangents.first()?.clone();
        scale(&mut step, length);
        let place = settle(surface, &surface.moved(&start.x, &step), gap, settings)?;
        (!place.level().is_empty()).then_some(place)
    };
    let length = INWARD * settings.sameness.distance;
    inward(length).or_else(|| inward(-length))
}

/// Whether a walk along the level directions leads from the minimum `from` to `to`, always at the height of `from`.
/// `arrived` tells whether the rest of the way, from a point to `to`, is level.
///
/// Along a single level direction it walks in both senses, so it follows every bend. Where there are several, it walks
/// toward `to` as long as it comes nearer.
pub(super) fn joins(
    surface: &Scaled<'_>,
    from: &[f64],
    to: &[f64],
    settings: &AuditSettings,
    arrived: &dyn Fn(&[f64]) -> bool,
) -> bool {
    let gap = surface.space().distance(from, to);
    let Some(start) = beginning(surface, from, gap, settings) else {
        return false;
    };
    let senses: &[f64] = match start.level().len() {
        1 => &[1.0, -1.0],
        _ => &[1.0],
    };
    senses.iter().any(|sense| {
        let mut heading = start.level()[0].clone();
        scale(&mut heading, *sense);
        let mut toward = vec![0.0; surface.space().tangents()];
        let mut rest = surface.space().log(&start.x, to, &mut toward);
        let (mut at, mut level) = (start.x.clone(), start.level());
        for _ in 0..STEPS {
            if arrived(&at) {
                return true;
            }
            // A single level direction leads on, whatever the bend.
            let leads_on = level.len() == 1;
            let wanted = if leads_on {
                heading
            } else {
                surface.scaled(&toward)
            };
            let Some(step) = within(&level, &wanted) else {
                return false;
            };
            heading = step;
            let mut step = heading.clone();
            // In plain tangents, a step has the length of the metric.
            let plain = norm(&times(&step, &surface.scales));
            let length = (STEP * gap).min(0.5 * rest);
            scale(&mut step, length / plain.max(f64::MIN_POSITIVE));
            let beside = surface.moved(&at, &step);
            let Some(next) = settle(surface, &beside, norm(&step), settings) else {
                return false;
            };
            let left = surface.space().log(&next.x, to, &mut toward);
            let is_level = (next.energy - start.energy).abs() <= settings.sameness.energy;
            if !is_level || (!leads_on && left >= rest) {
                return false;
            }
            (rest, level, at) = (left, next.level(), next.x);
        }
        false
    })
}

/// The unit vector of the part of `wanted` within the orthonormal `directions`; `None` if it has none.
fn within(directions: &[Vec<f64>], wanted: &[f64]) -> Option<Vec<f64>> {
    let mut part = vec![0.0; wanted.len()];
    for direction in directions {
        add(&mut part, dot(wanted, direction), direction);
    }
    let length = norm(&part);
    scale(&mut part, length.recip());
    (length > 0.0).then_some(part)
}
