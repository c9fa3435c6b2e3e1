//! Settings of paths.

use serde::{Deserialize, Serialize};

/// Settings of path relaxation. Lengths and forces are in the units of the surface; [`PathSettings::for_scales`] sets
/// all of them from one energy and one length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PathSettings {
    /// What keeps the images of a path apart.
    pub method: PathMethod,
    /// Springs, for a band.
    pub band: BandSettings,
    /// Segments of a path before any is split.
    pub segments: usize,
    /// The way round between two points that is not the shortest is tried as well if it is at most this many times as long.
    pub detour: f64,
    /// Looks, before a top is refined, for segments along which the surface departs from what their ends say of it; those
    /// are split.
    pub insertions: usize,
    /// What departs: a share of the barrier.
    pub departure: f64,
    /// Iterations before the lowest of several starts is chosen.
    pub coarse_iterations: usize,
    /// A rough path is a rival, and relaxed as well, if it would win by sinking this share of its barrier.
    pub rivalry: f64,
    /// Iterations after each pass found, and after doubling.
    pub iterations: usize,
    /// Passes refined at most.
    pub rounds: usize,
    /// Farthest an image moves in an iteration, a length of the space.
    pub max_step: f64,
    /// Greatest force at the top of a relaxed path, energy per length.
    pub force_tolerance: f64,
    /// Greatest change of the height under doubling, as a share of the barrier.
    pub height_tolerance: f64,
    /// Steps of the refinement of one pass.
    pub refinement_steps: usize,
    /// Length at which such a step along one mode of the surface levels off, however far away Newton's method expects the
    /// pass along it.
    pub saturation: f64,
    /// Length of the first step down from a pass.
    pub push: f64,
    /// For an energy with discrete choices whose kinks lie close: tops are lowered seam by seam instead of pass by pass.
    pub seams: Option<SeamSettings>,
    /// Height above the higher end below which images are evaluated exactly; see
    /// [`Piecewise::evaluate_roughly_above`](crate::energy::Piecewise::evaluate_roughly_above).
    pub exact_below: f64,
    /// Differences of height below this mean nothing.
    pub energy_tolerance: f64,
}

/// How the tops of paths over a kinked energy are lowered.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeamSettings {
    /// Greatest distance of neighbouring points of such a path, a length of the space: less than that of neighbouring kinks.
    pub spacing: f64,
    /// Moves of the top at most, before each halving and after.
    pub moves: usize,
    /// How often the distance of its points is halved at most, to see whether the height holds.
    pub halvings: usize,
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
            method: PathMethod::default(),
            band: BandSettings::for_scales(energy, length),
            segments: 12,
            detour: 1.5,
            insertions: 3,
            departure: 0.05,
            coarse_iterations: 60,
            rivalry: 0.25,
            iterations: 60,
            rounds: 4,
            max_step: 0.05 * length,
            force_tolerance: 0.01 * energy / length,
            height_tolerance: 0.01,
            refinement_steps: 60,
            saturation: length,
            push: 0.01 * length,
            seams: None,
            exact_below: 3.0 * energy,
            energy_tolerance: 1e-6 * energy,
        }
    }
}

impl PathSettings {
    /// Change of height that counts as none for a barrier of this height.
    pub(super) fn slack(&self, barrier: f64) -> f64 {
        self.height_tolerance * barrier + self.energy_tolerance
    }
}

/// How the images of a path are kept apart while it relaxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PathMethod {
    /// The string method: images are put back at even distances.
    #[default]
    String,
    /// The nudged elastic band: springs hold them.
    Band,
}

/// Settings of an elastic band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BandSettings {
    /// Stiffness of the springs at first, energy per length squared. It grows while the images are spread unevenly and
    /// falls while they are not.
    pub spring: f64,
    /// Whether the highest image climbs to the top once the band is roughly relaxed.
    pub climbing: bool,
    /// Whether the part of the springs' force across the path that does not work against the surface acts too (S. A.
    /// Trygubenko and D. J. Wales, J. Chem. Phys. 120, 2082 (2004)): no kinks, and a little off the true path.
    pub doubly_nudged: bool,
}

impl BandSettings {
    /// Settings for a surface whose typical barrier is `energy` high and `length` wide.
    pub fn for_scales(energy: f64, length: f64) -> Self {
        Self {
            spring: 10.0 * energy / (length * length),
            climbing: true,
            doubly_nudged: false,
        }
    }
}
