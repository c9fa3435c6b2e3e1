//! Settings of the search.

use serde::{Deserialize, Serialize};

use super::Draw;
use crate::energy::Energy;
use crate::optimize::QuenchSettings;
use crate::sample::{Task, stream};
use crate::topography::audit::AuditSettings;
use crate::topography::minima::MatchTolerance;
use crate::topography::path::PathMethod;
use crate::topography::scales::{PROBES, Scales};

/// Settings of [`explore`](super::explore). [`SearchSettings::measured`] takes all units from the surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SearchSettings {
    /// Distance over which the curvature of the surface changes: the longest step of a search.
    pub length: f64,
    /// Energy of the largest curvatures over that distance, without outliers (see [`Scales`]).
    pub energy: f64,
    /// Settings of the descents.
    pub quench: QuenchSettings,
    /// Tolerance within which two stationary points are the same.
    pub sameness: MatchTolerance,
    /// Greatest number of steps of a search.
    pub steps: usize,
    /// Number of modes followed from each minimum in both directions, softest first.
    pub modes: usize,
    /// Searches between two updates of the census. It affects the result, so it must not depend on the number of threads.
    pub batch: usize,
    /// The search ends when (searches since the last new point) reaches this number times (stationary points found).
    pub patience: usize,
    /// Greatest number of searches.
    pub max_searches: usize,
    /// Rounds that join separate components by relaxing paths.
    pub join_rounds: usize,
    /// How the images of those paths are kept apart.
    pub paths: PathMethod,
    /// Seed of all random draws.
    pub seed: u64,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl SearchSettings {
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
            batch: 32,
            patience: 30,
            max_searches: 100_000,
            join_rounds: 2,
            paths: PathMethod::default(),
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

    /// Settings of the audit of the points found.
    pub fn audit(&self) -> AuditSettings {
        AuditSettings::for_descents(&self.quench, &self.sameness, self.length)
    }
}
