//! What a stationary point is worth: gradient, index of the Hessian, duplicate, evaporated.

use serde::{Deserialize, Serialize};

use super::eigen::Piece;
use super::minima::Sameness;
use crate::energy::Energy;
use crate::optimize::{QuenchSettings, quench};
use crate::space::vector::norm;

/// How much tighter the tolerance of the descent is that tells a minimum from a point that is still drifting.
const TIGHTER: f64 = 1e-3;

/// What an audit says of a point that was taken for a stationary one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// It is what it was taken for.
    Sound,
    /// The gradient does not vanish.
    Moving,
    /// It is stationary, but with another index.
    Index,
    /// The gradient nearly vanishes, but the point drifts on and on: part of it left for infinity.
    Evaporated,
    /// The same as an earlier one.
    Duplicate,
    /// The energy or its curvature is not finite around it.
    Outside,
}

impl Verdict {
    /// The lower-case name used in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sound => "sound",
            Self::Moving => "moving",
            Self::Index => "index",
            Self::Evaporated => "evaporated",
            Self::Duplicate => "duplicate",
            Self::Outside => "outside",
        }
    }
}

/// The audit of one point. Curvatures are those of the smooth piece of the energy that is lowest there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Audit {
    /// What comes of it.
    pub verdict: Verdict,
    /// The earlier point it duplicates.
    pub duplicate_of: Option<usize>,
    /// Norm of the gradient, energy per length.
    pub gradient_norm: f64,
    /// Eigenvalues of the Hessian by rising value, the free motions of the space projected out; energy per length
    /// squared.
    pub curvatures: Vec<f64>,
    /// Number of negative ones: 0 for a minimum, 1 for a saddle.
    pub index: usize,
    /// Number of those that are zero within the accuracy of the Hessian: symmetries the space does not name, or a loose
    /// part.
    pub flat: usize,
}

/// Settings of an audit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AuditSettings {
    /// Greatest norm of the gradient, energy per length.
    pub gradient_tolerance: f64,
    /// Distance over which gradients are differenced, a length of the space.
    pub difference: f64,
    /// When two points are one.
    pub sameness: Sameness,
    /// The descent that shows whether a point with flat directions drifts.
    pub quench: QuenchSettings,
}

impl Default for AuditSettings {
    fn default() -> Self {
        Self {
            gradient_tolerance: 1e-6,
            difference: 1e-5,
            sameness: Sameness::default(),
            quench: QuenchSettings::default(),
        }
    }
}

/// Audits points that were taken for stationary ones of index `index` (0: minima, 1: saddles), in their order.
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
        if audit.verdict == Verdict::Sound {
            let same = |k: &usize| {
                audits[*k].verdict == Verdict::Sound
                    && (energies[*k] - height).abs() <= settings.sameness.energy
                    && space.distance(&points[*k], x) <= settings.sameness.distance
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

/// Energy and audit of one point by itself.
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
    let piece = Piece::plain(energy, energy.choice(x));
    let Some(modes) = piece.modes(x, settings.difference) else {
        return (height, audit);
    };
    (audit.index, audit.flat) = modes.index();
    audit.curvatures = modes.curvatures;
    // A gradient that is not a number is no small one.
    let resting = audit.gradient_norm <= settings.gradient_tolerance;
    audit.verdict = if !resting {
        Verdict::Moving
    } else if audit.flat > 0 && drifts(energy, x, settings) {
        Verdict::Evaporated
    } else if audit.index == index {
        Verdict::Sound
    } else {
        Verdict::Index
    };
    (height, audit)
}

/// Whether a much stricter descent leads away from `x`: where the surface levels off a gradient may be as small as one
/// likes and still mean something.
fn drifts(energy: &dyn Energy, x: &[f64], settings: &AuditSettings) -> bool {
    let stricter = settings
        .quench
        .clone()
        .with_gradient_tolerance(TIGHTER * settings.gradient_tolerance);
    let end = quench(energy, x, &stricter);
    let space = energy.space();
    space.distance(x, &end.x) > settings.sameness.distance
}
