//! The outcome of one search.

use serde::{Deserialize, Serialize};

use crate::topography::barrier::Crossing;
use crate::topography::minima::QuenchRecord;

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SearchEnd {
    /// At a saddle whose descents reached minima.
    Arrived,
    /// At a saddle from which a descent reached no minimum.
    Evaporated,
    /// At a stationary point of another index.
    Index,
    /// At a point that is stationary within the tolerances, where one curvature is too small to have a sign and no known minimum
    /// lies. Minima and saddles that are close together cannot be distinguished there.
    Undecided,
    /// The curvature of the uphill mode vanished: a fragment moved off to infinity.
    Flat,
    /// Far above all known stationary points.
    High,
    /// It did not converge within the steps allowed.
    Steps,
    /// Outside the domain.
    Outside,
}

impl SearchEnd {
    /// The lower-case name used in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Arrived => "arrived",
            Self::Evaporated => "evaporated",
            Self::Index => "index",
            Self::Undecided => "undecided",
            Self::Flat => "flat",
            Self::High => "high",
            Self::Steps => "steps",
            Self::Outside => "outside",
        }
    }

    /// Where the search ended, in plain words.
    pub const fn told(self) -> &'static str {
        match self {
            Self::Arrived => "at a saddle",
            Self::Evaporated => "at a saddle from which a descent reached no minimum",
            Self::Index => {
                "at a point that is neither a minimum nor a saddle, or back at a minimum"
            }
            Self::Undecided => "where a minimum and a saddle cannot be distinguished",
            Self::Flat => "where the surface is flat along the way up",
            Self::High => "far above all points found",
            Self::Steps => "at the limit of steps",
            Self::Outside => "outside the domain",
        }
    }
}

#[derive(Serialize, Deserialize)]
pub(super) struct Outcome {
    pub(super) fate: SearchEnd,
    /// The saddle it reached, if already known when the search began.
    pub(super) known: Option<usize>,
    /// The saddle it reached, if not.
    pub(super) found: Option<Crossing>,
    /// Paths from that saddle to further minima, if more than two valleys meet there.
    pub(super) branches: Vec<Crossing>,
    /// The end of the descent from a random point.
    pub(super) drawn: Option<QuenchRecord>,
    /// Where it ended and the energy there, if one curvature is too small there to have a sign.
    pub(super) undecided: Option<(Vec<f64>, f64)>,
    /// Whether that descent ended where the gradient does not vanish.
    pub(super) unfinished: bool,
    pub(super) evaluations: usize,
}
