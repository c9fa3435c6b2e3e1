//! Audit of stationary points: gradient, index of the Hessian, duplicates, evaporation.

use serde::{Deserialize, Serialize};

use super::eigen::{Modes, Scaled};
use super::follow::Following;
use super::minima::MatchTolerance;
use super::trough::settle;
use crate::energy::Energy;
use crate::optimize::{QuenchSettings, quench};
use crate::space::vector::{dot, norm, scale};

/// Factor on the gradient tolerance for the descent that tells a minimum from a drifting point.
const TIGHTER: f64 = 1e-3;
/// Length of the step along a soft direction that tests for degeneracy, in units of the distance tolerance.
const REACH: f64 = 10.0;
/// Directions of lower curvature than this fraction of the greatest are tested. Directions along which the energy is
/// constant over the whole step are tested too: at the edge of a plateau the curvature of the other side tells nothing. A
/// direction that is merely soft leads back to the same point.
const SOFT: f64 = 1e-6;
/// Directions in which the slope on one side, at this fraction of the distance tolerance, is below `EDGE` of that on the other
/// side are tested too: a flat set may end there.
const NEAR: f64 = 0.1;
const EDGE: f64 = 0.25;
/// Difference between heights of a level set, in energy tolerances, and relative to the energy (rounding).
const RISE: f64 = 1e-4;
const ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Greatest number of steps of this test.
const STEPS: usize = 50;

/// Verdict of the audit of a supposed stationary point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The point is what it was taken for.
    Sound,
    /// Correct, but not isolated: energy and gradient are constant along some direction (rings, troughs and plateaus).
    Degenerate,
    /// The gradient is too large, in itself or for the curvatures (a Newton step would leave the point).
    Moving,
    /// The gradient jumps across zero and the energy rises on both sides: the bottom of a kink.
    Kink,
    /// The point is stationary, but has another index.
    Index,
    /// The gradient nearly vanishes, but the point keeps drifting: a fragment moved off to infinity.
    Evaporated,
    /// The point is the same as an earlier one.
    Duplicate,
    /// The energy or its curvature is not finite around the point.
    Outside,
}

impl Verdict {
    /// Whether the point is stationary with the expected index, isolated or not.
    pub const fn is_stationary(self) -> bool {
        matches!(self, Self::Sound | Self::Degenerate)
    }

    /// The lower-case name used in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sound => "sound",
            Self::Degenerate => "degenerate",
            Self::Moving => "moving",
            Self::Kink => "kink",
            Self::Index => "index",
            Self::Evaporated => "evaporated",
            Self::Duplicate => "duplicate",
            Self::Outside => "outside",
        }
    }

    /// The verdict in plain words, after a number of points.
    pub const fn told(self) -> &'static str {
        match self {
            Self::Sound => "sound",
            Self::Degenerate => "not isolated",
            Self::Moving => "where the gradient does not vanish",
            Self::Kink => "at the bottom of a kink",
            Self::Index => "with another number of negative curvatures",
            Self::Evaporated => "that keep drifting",
            Self::Duplicate => "known before",
            Self::Outside => "without finite curvatures",
        }
    }
}

/// The audit of one point. Curvatures are those of the smooth surface of the energy that is lowest there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Audit {
    /// The result of the audit.
    pub verdict: Verdict,
    /// The earlier point it duplicates.
    pub duplicate_of: Option<usize>,
    /// Norm of the gradient, energy per length.
    pub gradient_norm: f64,
    /// Eigenvalues of the Hessian, ascending, energy per length squared, with the free motions of the space projected out.
    pub curvatures: Vec<f64>,
    /// Number of negative eigenvalues: 0 for a minimum, 1 for a saddle.
    pub index: usize,
    /// Number of zero eigenvalues, within the accuracy of the Hessian (undeclared symmetries or loose fragments).
    pub flat: usize,
}

/// Settings of an audit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AuditSettings {
    /// Greatest norm of the gradient, energy per length.
    pub gradient_tolerance: f64,
    /// Step of the finite differences of gradients, a length of the space.
    pub difference: f64,
    /// Tolerance within which two points are the same.
    pub sameness: MatchTolerance,
    /// Settings of the descent that shows whether a point with flat directions drifts.
    pub quench: QuenchSettings,
}

impl AuditSettings {
    /// Settings for the ends of descents on a surface whose curvature changes over `length`.
    pub fn for_descents(quench: &QuenchSettings, sameness: &MatchTolerance, length: f64) -> Self {
        Self {
            // A descent that rounding ended a little early is still good.
            gradient_tolerance: 10.0 * quench.gradient_tolerance,
            difference: 1e-4 * length,
            sameness: *sameness,
            quench: quench.clone(),
        }
    }
}

impl AuditSettings {
    /// Greatest difference between energies of points of a level set at this height.
    pub(super) fn noise(&self, height: f64) -> f64 {
        RISE * self.sameness.energy + ROUNDING * height.abs()
    }
}

impl Default for AuditSettings {
    fn default() -> Self {
        Self {
            gradient_tolerance: 1e-6,
            difference: 1e-5,
            sameness: MatchTolerance::default(),
            quench: QuenchSettings::default(),
        }
    }
}

/// Audits supposed stationary points of index `index` (0: minima, 1: saddles), in order.
pub fn audit(
    energy: &dyn Energy,
    points: &[Vec<f64>],
    index: usize,
    settings: &AuditSettings,
) -> Vec<Audit> {
    let space = energy.space();
    let mut energies: Vec<f64> = Vec::with_capacity(points.len());
    let mut audits: Vec<Audit> = Vec::with_capacity(points.len());
    for (row, x) in points.iter().enumerate() {
        let (height, mut audit) = examine(energy, x, index, settings);
        if audit.verdict.is_stationary() {
            let same = |k: &usize| {
                audits[*k].verdict.is_stationary()
                    && (energies[*k] - height).abs() <= settings.sameness.energy
                    && space.within(&points[*k], x, settings.sameness.distance)
            };
            if let Some(first) = (0..row).find(same) {
                audit.verdict = Verdict::Duplicate;
                audit.duplicate_of = Some(first);
            }
        }
        energies.push(height);
        audits.push(audit);
    }
    audits
}

pub(super) fn examine(
    energy: &dyn Energy,
    x: &[f64],
    index: usize,
    settings: &AuditSettings,
) -> (f64, Audit) {
    let mut gradient = vec![0.0; energy.space().tangents()];
    let height = energy.evaluate(x, &mut gradient);
    let mut audit = Audit {
        verdict: Verdict::Outside,
        duplicate_of: None,
        gradient_norm: norm(&gradient),
        curvatures: Vec::new(),
        index: 0,
        flat: 0,
    };
    if !height.is_finite() {
        return (height, audit);
    }
    let surface = Scaled::plain(energy);
    let Some(modes) = surface.modes(x, settings.difference) else {
        return (height, audit);
    };
    (audit.index, audit.flat) = modes.index();
    audit.curvatures.clone_from(&modes.curvatures);
    // A NaN gradient is not small.
    let resting = audit.gradient_norm <= settings.gradient_tolerance
        && modes.newton_step(&gradient) <= settings.sameness.distance;
    audit.verdict = if !resting {
        if is_kink(energy, x, &gradient, settings) {
            Verdict::Kink
        } else {
            Verdict::Moving
        }
    } else if audit.flat > 0 && drifts(energy, x, settings) {
        Verdict::Evaporated
    } else if audit.index == index {
        if is_level(&surface, (x, height), &modes, settings) {
            Verdict::Degenerate
        } else {
            Verdict::Sound
        }
    } else {
        Verdict::Index
    };
    (height, audit)
}

/// Whether a much stricter descent leads away from `x`. The gradient may be very small far from a minimum.
fn drifts(energy: &dyn Energy, x: &[f64], settings: &AuditSettings) -> bool {
    let stricter = settings
        .quench
        .clone()
        .with_gradient_tolerance(TIGHTER * settings.gradient_tolerance);
    let end = quench(energy, x, &stricter);
    let space = energy.space();
    !space.within(x, &end.x, settings.sameness.distance)
}

/// Whether a step along a soft direction from a stationary point of index 0 or 1 leads to another one of the same height, at
/// least half the step away. The bottom of x⁴, which has zero curvature too, is found again instead, or a point beside it where
/// the gradient is within its tolerance already, which is higher.
fn is_level(
    surface: &Scaled<'_>,
    (x, height): (&[f64], f64),
    modes: &Modes,
    settings: &AuditSettings,
) -> bool {
    let reach = REACH * settings.sameness.distance;
    let again = |start: &[f64]| -> Option<(Vec<f64>, f64)> {
        if modes.index().0 == 0 {
            let end = quench(surface.energy(), start, &settings.quench);
            let resting = end.gradient_norm <= settings.gradient_tolerance;
            return resting.then_some((end.x, end.energy));
        }
        let following = Following {
            tolerance: settings.gradient_tolerance,
            longest: reach,
            saturation: 10.0 * reach,
            level: f64::INFINITY,
            difference: settings.difference,
            steps: STEPS,
            kicks: 0,
            keeps_mode: true,
            ceiling: f64::INFINITY,
            known: &|_, _| None,
        };
        // A search for a saddle goes astray on a ring of saddles, where nothing holds it in the level direction.
        let found = surface.follow(start, Some(&modes.tangents[0]), &following);
        let found = found.ok().map(|saddle| (saddle.x, saddle.energy));
        found.or_else(|| {
            let place = settle(surface, start, reach, settings)?;
            Some((place.x, place.energy))
        })
    };
    let soft = SOFT * modes.stiffest();
    let near = NEAR * settings.sameness.distance;
    let as_high = |energy: f64| (energy - height).abs() <= settings.sameness.energy;
    let mut gradient = vec![0.0; surface.space().tangents()];
    let mut directions = modes.curvatures.iter().zip(&modes.tangents);
    directions.any(|(curvature, tangent)| {
        let at = |length: f64| {
            let mut step = tangent.clone();
            scale(&mut step, length);
            surface.moved(x, &step)
        };
        let slopes = [near, -near].map(|length| {
            surface.evaluate(&at(length), &mut gradient);
            dot(&gradient, tangent).abs()
        });
        let is_edge = slopes[0].min(slopes[1]) <= EDGE * slopes[0].max(slopes[1]);
        [reach, -reach].iter().any(|length| {
            let beside = at(*length);
            let is_tested = is_edge
                || curvature.abs() <= soft
                || as_high(surface.evaluate(&beside, &mut gradient));
            is_tested
                && again(&beside).is_some_and(|(there, energy)| {
                    (energy - height).abs() <= settings.noise(height)
                        && !surface.space().within(x, &there, 0.5 * reach)
                })
        })
    })
}

/// Whether the slope along the gradient jumps from negative to positive at or very near `x`. At a kink the slope changes
/// over a tenth of a distance by as much as over the whole; on a smooth surface it changes by a tenth of that.
fn is_kink(energy: &dyn Energy, x: &[f64], gradient: &[f64], settings: &AuditSettings) -> bool {
    let space = energy.space();
    let size = norm(gradient);
    if !(size > 0.0 && size.is_finite()) {
        return false;
    }
    let mut uphill = gradient.to_vec();
    scale(&mut uphill, size.recip());
    let slope = |length: f64| {
        let (mut there, mut step) = (x.to_vec(), uphill.clone());
        scale(&mut step, length);
        space.exp(&mut there, &step);
        let mut gradient = vec![0.0; uphill.len()];
        let height = energy.evaluate(&there, &mut gradient);
        height.is_finite().then(|| dot(&gradient, &uphill))
    };
    let jump = |length: f64| {
        let (ahead, behind) = (slope(length)?, slope(-length)?);
        (ahead > 0.0 && behind < 0.0).then_some(ahead - behind)
    };
    let distances = [0.1, 1.0, 10.0, 100.0].map(|factor| factor * settings.difference);
    distances.windows(2).any(|pair| {
        let (near, far) = (jump(pair[0]), jump(pair[1]));
        near.zip(far).is_some_and(|(near, far)| near > 0.5 * far)
    })
}
