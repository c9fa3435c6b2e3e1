//! Walks along sets of stationary points that are not isolated: rings, troughs and plateaus, and the passes that are rings.

use super::audit::AuditSettings;
use super::eigen::{Modes, Piece};
use crate::space::vector::{add, dot, norm, scale, times};

/// Directions of lower curvature than this fraction of the greatest are level. Differences of gradients leave about 10⁻⁸ of
/// the curvature of a straight direction, and a step of a walk ends off the level direction, where the curvature is not 0.
const LEVEL: f64 = 1e-4;
/// Greatest number of steps of Newton's method back to the set.
const RETURNS: usize = 12;
/// Length of a step of a walk as a fraction of the distance between its ends: a ring has at least 25 steps around it.
const STEP: f64 = 0.125;
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
    fn level(&self) -> Vec<&Vec<f64>> {
        let most = LEVEL * self.modes.stiffest();
        let modes = self.modes.curvatures.iter().zip(&self.modes.tangents);
        let level = modes.filter(|(curvature, _)| curvature.abs() <= most);
        level.map(|(_, tangent)| tangent).collect()
    }
}

/// The stationary point that Newton's method reaches from `start` in all directions but the level ones, whatever the index.
/// `None` if there is none within `reach` (in scaled tangents).
pub(super) fn settle(
    piece: &Piece<'_>,
    start: &[f64],
    reach: f64,
    settings: &AuditSettings,
) -> Option<Place> {
    let mut x = start.to_vec();
    let mut gradient = vec![0.0; piece.space().tangents()];
    for _ in 0..RETURNS {
        let energy = piece.evaluate(&x, &mut gradient);
        let modes = piece.modes(&x, settings.difference)?;
        if !energy.is_finite() {
            return None;
        }
        if piece.size(&gradient) <= settings.gradient_tolerance {
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
        x = piece.moved(&x, &step);
    }
    None
}

/// Whether a walk along the level directions leads from the stationary point `from` to `to`, always at the height of `from`.
/// `arrived` tells whether the rest of the way, from a point to `to`, is level.
///
/// Along a single level direction it walks in both senses, so it follows every bend. Where there are several, it walks
/// toward `to` as long as it comes nearer.
pub(super) fn joins(
    piece: &Piece<'_>,
    from: &[f64],
    to: &[f64],
    settings: &AuditSettings,
    arrived: &dyn Fn(&[f64]) -> bool,
) -> bool {
    let gap = piece.space().distance(from, to);
    let Some(start) = settle(piece, from, gap, settings) else {
        return false;
    };
    let senses: &[f64] = match start.level().len() {
        0 => &[],
        1 => &[1.0, -1.0],
        _ => &[1.0],
    };
    senses.iter().any(|sense| {
        let mut sense = *sense;
        let mut toward = vec![0.0; piece.space().tangents()];
        let mut rest = piece.space().log(&start.x, to, &mut toward);
        let mut at = start.x.clone();
        let mut level: Vec<Vec<f64>> = start.level().into_iter().cloned().collect();
        let mut before: Option<Vec<f64>> = None;
        for _ in 0..STEPS {
            if arrived(&at) {
                return true;
            }
            let mut step = match (&level[..], before.take()) {
                ([], _) => return false,
                ([only], None) => {
                    let mut step = only.clone();
                    scale(&mut step, sense);
                    step
                }
                ([only], Some(last)) => {
                    sense = dot(only, &last).signum();
                    let mut step = only.clone();
                    scale(&mut step, sense);
                    step
                }
                (several, _) => {
                    let wanted = piece.scaled(&toward);
                    let mut step = vec![0.0; wanted.len()];
                    for tangent in several {
                        add(&mut step, dot(&wanted, tangent), tangent);
                    }
                    let length = norm(&step);
                    if length <= 0.0 {
                        return false;
                    }
                    scale(&mut step, length.recip());
                    step
                }
            };
            let direction = step.clone();
            let length = (STEP * gap).min(0.5 * rest);
            // In plain tangents, a step has the length of the metric.
            let plain = norm(&times(&step, &piece.scales));
            scale(&mut step, length / plain.max(f64::MIN_POSITIVE));
            let beside = piece.moved(&at, &step);
            let Some(next) = settle(piece, &beside, norm(&step), settings) else {
                return false;
            };
            if (next.energy - start.energy).abs() > settings.sameness.energy {
                return false;
            }
            let left = piece.space().log(&next.x, to, &mut toward);
            if level.len() > 1 && left >= rest {
                return false;
            }
            rest = left;
            level = next.level().into_iter().cloned().collect();
            before = Some(direction);
            at = next.x;
        }
        false
    })
}
