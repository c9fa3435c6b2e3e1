//! One search: from a start to a saddle, and down both sides of it.

use serde::{Deserialize, Serialize};

use super::census::Census;
use super::start::{Place, Start};
use super::{Draw, SearchSettings};
use crate::energy::{Counted, Energy};
use crate::optimize::{Quench, StopReason};
use crate::topography::barrier::Crossing;
use crate::topography::eigen::Piece;
use crate::topography::follow::{Following, Lost};
use crate::topography::minima::QuenchRecord;
use crate::topography::path::{Pass, descend};

/// Push off a saddle, as a share of the length of the surface.
pub(super) const PUSH: f64 = 0.1;
/// Where the step along one mode levels off, in units of the length of the surface: far beyond the place where its Hessian
/// can be trusted, so that soft modes are not pushed as far as they ask.
const SATURATION: f64 = 10.0;
/// Distance over which gradients are differenced, as a share of the longest step.
const DIFFERENCE: f64 = 1e-4;
/// How often that is halved before both sides lead down.
const HALVINGS: i32 = 8;

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fate {
    /// At a saddle whose descents reach minima.
    Arrived,
    /// At a saddle from which a descent reaches no minimum.
    Evaporated,
    /// At a stationary point of another index.
    Index,
    /// Where the way up has no curvature: part of it left for infinity.
    Flat,
    /// Far above everything known.
    High,
    /// Nowhere within the steps allowed.
    Steps,
    /// Outside the domain.
    Outside,
}

impl Fate {
    /// The lower-case name used in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Arrived => "arrived",
            Self::Evaporated => "evaporated",
            Self::Index => "index",
            Self::Flat => "flat",
            Self::High => "high",
            Self::Steps => "steps",
            Self::Outside => "outside",
        }
    }
}

/// What a search brings home.
#[derive(Serialize, Deserialize)]
pub(super) struct Outcome {
    pub(super) fate: Fate,
    /// The saddle it met, if it was known when the search began.
    pub(super) known: Option<usize>,
    /// The saddle it met, if it was not.
    pub(super) found: Option<Crossing>,
    /// The end of the descent from a random point.
    pub(super) drawn: Option<QuenchRecord>,
    pub(super) evaluations: usize,
}

/// Everything a search needs but what is known so far.
pub(super) struct Searcher<'a> {
    pub(super) energy: &'a dyn Energy,
    pub(super) draw: &'a Draw<'a>,
    pub(super) settings: &'a SearchSettings,
}

impl Searcher<'_> {
    /// Search number `id`. The outcome depends on its number, its start and the census only.
    pub(super) fn run(&self, id: u64, start: Start, census: &Census) -> Outcome {
        let counted = Counted::new(self.energy);
        let counting = Searcher {
            energy: &counted,
            ..*self
        };
        let place = counting.place(id, start, census);
        let mut outcome = counting.climb(&place, census);
        outcome.drawn = place
            .drawn
            .filter(|quench: &Quench| {
                quench.stop != StopReason::Budget && quench.energy.is_finite()
            })
            .map(QuenchRecord::from);
        outcome.evaluations = usize::try_from(counted.evaluations()).unwrap_or(usize::MAX);
        outcome
    }

    fn climb(&self, place: &Place, census: &Census) -> Outcome {
        let mut outcome = Outcome {
            fate: Fate::Arrived,
            known: None,
            found: None,
            drawn: None,
            evaluations: 0,
        };
        let following = Following {
            tolerance: self.settings.quench.gradient_tolerance,
            longest: place.longest,
            saturation: SATURATION * self.settings.length,
            // Bold steps cross places where the curvature changes; differences must not.
            difference: DIFFERENCE * place.longest.min(self.settings.length),
            steps: self.settings.steps,
            kicks: 1,
            ceiling: census.ceiling(self.settings.energy),
            known: &|x, energy| census.saddle(self.energy.space(), x, energy),
        };
        let saddle = match Piece::new(self.energy, Vec::new()).follow(
            &place.x,
            place.hint.as_deref(),
            &following,
        ) {
            Ok(saddle) => saddle,
            Err(lost) => {
                match lost {
                    Lost::Known(saddle) => outcome.known = Some(saddle),
                    Lost::Outside => outcome.fate = Fate::Outside,
                    Lost::High => outcome.fate = Fate::High,
                    Lost::Steps => outcome.fate = Fate::Steps,
                    Lost::Index => outcome.fate = Fate::Index,
                    Lost::Flat => outcome.fate = Fate::Flat,
                }
                return outcome;
            }
        };
        // Behind a saddle that lies next to its minimum a push of the usual length ends above the saddle again.
        let descents = (0..HALVINGS).find_map(|halvings| {
            descend(
                self.energy,
                (&saddle.x, saddle.energy),
                &saddle.mode,
                PUSH * self.settings.length * 0.5_f64.powi(halvings),
                &self.settings.quench,
            )
        });
        match descents {
            None => outcome.fate = Fate::Evaporated,
            Some(descents) => {
                outcome.found = Some(Crossing::from(Pass {
                    x: saddle.x,
                    energy: saddle.energy,
                    seam: false,
                    residual: saddle.residual,
                    descents,
                }));
            }
        }
        outcome
    }
}
