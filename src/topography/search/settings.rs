//! Settings of the search, and how they are measured.

use serde::{Deserialize, Serialize};

use super::Draw;
use crate::energy::Energy;
use crate::optimize::QuenchSettings;
use crate::sample::{Task, stream};
use crate::topography::audit::AuditSettings;
use crate::topography::minima::MatchTolerance;
use crate::topography::path::PathMethod;
use crate::topography::scales::{PROBES, Scales};

/// Settings of [`explore`](super::explore). [`SearchSettings::measured`] sets everything that has a unit from the surface
/// itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SearchSettings {
    /// Distance over which the surface's curvature changes: the longest step of a search.
    pub length: f64,
    /// Energy of its largest curvatures over that distance, outlying ones left out: see [`Scales`].
    pub energy: f64,
    /// Descents.
    pub quench: QuenchSettings,
    /// When two stationary points are one.
    pub sameness: MatchTolerance,
    /// Steps of one search.
    pub steps: usize,
    /// Modes followed from each minimum, both ways; the softest first.
    pub modes: usize,
    /// Searches between two looks at what is known. Part of the result, so it must not depend on threads.
    pub batch: usize,
    /// The search ends after this many searches without anything new for every stationary point found.
    pub patience: usize,
    /// Most searches.
    pub max_searches: usize,
    /// Rounds that join minima which no saddle joins, by relaxing paths.
    pub join_rounds: usize,
    /// What keeps the images of those paths apart.
    pub paths: PathMethod,
    /// Seed of every draw.
    pub seed: u64,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl SearchSettings {
    /// Settings for a surface whose curvature changes over `length` and that rises by about `energy` over it.
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

    /// Settings from the surface: its [`Scales`] below a few random points.
    pub fn measured(energy: &dyn Energy, draw: &Draw<'_>, seed: u64) -> Self {
        let points: Vec<Vec<f64>> = (0..PROBES as u64)
            .map(|id| draw(&mut stream(seed, Task::Start, u64::MAX - id)))
            .collect();
        let scales = Scales::below(energy, &points, seed);
        Self::for_scales(scales.energy, scales.length).with_seed(seed)
    }

    /// Replaces the seed.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Replaces the number of idle searches for every stationary point found.
    #[must_use]
    pub fn with_patience(mut self, patience: usize) -> Self {
        self.patience = patience;
        self
    }

    /// How the points found are audited.
    pub fn audit(&self) -> AuditSettings {
        AuditSettings::for_descents(&self.quench, &self.sameness, self.length)
    }
}
