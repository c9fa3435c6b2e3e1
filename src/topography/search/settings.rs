//! Settings of the search.

use serde::{Deserialize, Serialize};

use super::Draw;
use crate::energy::Energy;
use crate::optimize::{Quench, QuenchSettings, StopReason};
use crate::sample::{Task, stream};
use crate::topography::audit::AuditSettings;
use crate::topography::minima::MatchTolerance;
use crate::topography::scales::{PROBES, Scales};

/// Gradient at the end of a descent above which it is unfinished, in tolerances.
const STEEP: f64 = 1e4;

/// Settings of [`explore`](super::explore). [`SearchSettings::measured`] takes all units from the surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SearchSettings {
    /// Distance over which the curvature of the surface changes: the longest step of a search.
    pub length: f64,
    /// Energy of the largest curvatures over that distance, without outliers (see [`Scales`]).
    pub energy: f64,
    /// Settings of the descents.
    pub quench: QuenchSettings,
    /// Tolerance within which two stationary points are the same.
    pub sameness: MatchTolerance,
    /// Greatest number of steps of a search at first. Where more searches end by it than at a saddle, it is doubled, up to four
    /// times, with the greatest number of evaluations of a descent.
    pub steps: usize,
    /// Number of modes followed from each minimum in both directions, softest first.
    pub modes: usize,
    /// The search ends when (searches since the last new point) reaches this number times (stationary points found).
    pub patience: usize,
    /// Greatest number of searches.
    pub max_searches: usize,
    /// Seed of all random draws.
    pub seed: u64,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl SearchSettings {
    /// A number of searches that no search reaches, for searches that a time limits.
    pub const NO_LIMIT: usize = 1_000_000_000;

    /// Settings for a surface whose curvature changes over `length` and whose energy rises by about `energy` over it.
    pub fn for_scales(energy: f64, length: f64) -> Self {
        let scales = Scales { energy, length };
        Self {
            length,
            energy,
            quench: scales.quench(),
            sameness: scales.sameness(),
            steps: 80,
            modes: 1000,
            patience: 120,
            max_searches: 100_000,
            seed: 0,
        }
    }

    /// Settings measured on the surface: its [`Scales`] below a few random points.
    pub fn measured(energy: &dyn Energy, draw: &Draw<'_>, seed: u64) -> Self {
        let points: Vec<Vec<f64>> = (0..PROBES as u64)
            .map(|id| draw(&mut stream(seed, Task::Start, u64::MAX - id)))
            .collect();
        let scales = Scales::below(energy, &points, seed);
        Self {
            seed,
            ..Self::for_scales(scales.energy, scales.length)
        }
    }

    /// Whether a descent ended where the gradient does not vanish: at a kink or jump, at the edge of the domain, or on the way
    /// down a hole.
    pub(super) fn is_unfinished(&self, end: &Quench) -> bool {
        // A gradient that is not a number is not small.
        let resting = end.gradient_norm <= STEEP * self.quench.gradient_tolerance;
        end.stop != StopReason::Converged && end.energy < f64::INFINITY && !resting
    }

    #[cfg(feature = "chemistry")]
    /// Whether a descent ended at what may be a minimum.
    pub(super) fn is_finished(&self, end: &Quench) -> bool {
        end.stop != StopReason::Budget && end.energy.is_finite() && !self.is_unfinished(end)
    }

    /// Settings of the audit of the points found.
    pub fn audit(&self) -> AuditSettings {
        AuditSettings::for_descents(&self.quench, &self.sameness, self.length)
    }
}
