//! Settings of paths.

use serde::{Deserialize, Serialize};

/// Greatest change of a height under doubling, relative to the barrier.
pub(in crate::topography) const HEIGHT_TOLERANCE: f64 = 0.01;
/// Difference from the cubic through its ends above which a segment is split, relative to the barrier: several times the
/// tolerance of heights, because the top is refined afterwards.
pub(super) const DEPARTURE: f64 = 0.05;

/// Settings of path relaxation. [`PathSettings::for_scales`] sets all that have units from one energy and one length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PathSettings {
    /// Number of segments before any is split.
    pub segments: usize,
    /// The longer way round between two points is tried too if it is at most this many times as long.
    pub detour: f64,
    /// Rounds, before a top is refined, that split segments where the surface differs from the cubic through their ends.
    pub insertions: usize,
    /// Iterations before the lowest of several starts is chosen.
    pub coarse_iterations: usize,
    /// A rough path is relaxed too if it would win by sinking by this fraction of its barrier.
    pub rivalry: f64,
    /// Iterations after each pass found, and after doubling.
    pub iterations: usize,
    /// Greatest number of passes refined.
    pub rounds: usize,
    /// Longest step of an image in an iteration, a length of the space.
    pub max_step: f64,
    /// Greatest force at the top of a relaxed path, energy per length.
    pub force_tolerance: f64,
    /// Greatest number of steps in the refinement of one pass.
    pub refinement_steps: usize,
    /// Length at which such a step along one mode saturates, however far Newton's method would go.
    pub saturation: f64,
    /// Length of the first step down from a pass.
    pub push: f64,
    /// On a surface with ripples: lowers the tops of paths that decide the tree and were not led over passes.
    pub lowering: Option<LoweringSettings>,
    /// Differences of height below this are ignored.
    pub energy_tolerance: f64,
    /// Height of the ripples of a smooth surface; 0 if it has none. On a surface with ripples, paths are led over verified
    /// passes, a path that rises by less than a ripple is not refined, and minima divided by less than a ripple are one.
    #[serde(skip_serializing_if = "is_zero")]
    pub roughness: f64,
}

/// Settings for lowering the tops of paths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LoweringSettings {
    /// Greatest distance between neighbouring points of the path.
    pub spacing: f64,
    /// Greatest number of moves of the top before and after each halving.
    pub moves: usize,
    /// Greatest number of halvings of the point distance, which test whether the height is converged.
    pub halvings: usize,
}

impl Default for LoweringSettings {
    /// The settings for grasps.
    fn default() -> Self {
        Self {
            spacing: 0.002,
            moves: 100,
            halvings: 2,
        }
    }
}

impl Default for PathSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl PathSettings {
    /// Settings for a surface whose typical barrier is `energy` high and `length` wide.
    pub fn for_scales(energy: f64, length: f64) -> Self {
        Self {
            segments: 12,
            detour: 1.5,
            insertions: 3,
            coarse_iterations: 60,
            rivalry: 0.25,
            iterations: 60,
            rounds: 4,
            max_step: 0.05 * length,
            force_tolerance: 0.01 * energy / length,
            refinement_steps: 60,
            saturation: length,
            push: 0.01 * length,
            lowering: None,
            energy_tolerance: 1e-6 * energy,
            roughness: 0.0,
        }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_zero(roughness: &f64) -> bool {
    *roughness == 0.0
}

impl PathSettings {
    /// Change of height that is ignored for a barrier of this height.
    pub(super) fn slack(&self, barrier: f64) -> f64 {
        HEIGHT_TOLERANCE * barrier + self.energy_tolerance
    }
}
