//! Settings for maps of grasps.

use serde::{Deserialize, Serialize};

use super::level::{FamilyLevel, ROUGHNESS, letting_go};
use crate::grasp::{EnergySettings, GraspEnergy};
use crate::topography::{
    ChainSettings, LoweringSettings, MapSettings, MatchTolerance, PathSettings, Run,
};

/// The slope that holds a hand at the object, energy per metre: the cost of letting go over the thickness of the layer. It is
/// the unit of a chain's force, which must exceed it several times.
pub(super) fn contact_slope(energy: &EnergySettings) -> f64 {
    let layer = energy.layer;
    letting_go(energy).unwrap_or(1.0) / (layer.skin_m[0] - layer.skin_m[1])
}

/// Force at the top of a relaxed path, as a fraction of the cost of letting go, 1/m: a path through a stiff layer that is
/// off its bottom by a thousandth of a millimetre is relaxed.
const LAYER_FORCE: f64 = 1.0;

/// Temperature of the chains over an elastic layer, as a fraction of the cost of letting go: half a ripple. Of three that
/// were tried, the lowest met the lowest barriers.
pub(super) const TEMPERATURE: f64 = 0.5 * ROUGHNESS;

/// Settings of [`build_landscape`](crate::topography::build_landscape) for the grasps of a hand, as in `landscape build`.
/// Lengths are centimetres. Minima that differ by less than the spacing of the hand's surface points are one grasp. The cost
/// of letting go sets the tolerances of energies and the level of families ([`FamilyLevel::default_of`]).
pub fn settings_for_grasps(energy: &GraspEnergy) -> MapSettings {
    map_of(energy.settings())
}

/// The settings for the default energy, of which they are the same for all hands and objects.
pub(super) fn default_map() -> MapSettings {
    map_of(&EnergySettings::default())
}

pub(super) fn map_of(energy: &EnergySettings) -> MapSettings {
    // Without a cost of letting go, energies are in units of one.
    let cost = letting_go(energy).unwrap_or(1.0);
    let mut settings = MapSettings::for_scales(0.3, 0.04);
    settings.neighbours = 10;
    settings.batch = 16;
    settings.ceiling = Some(cost);
    settings.quench = settings
        .quench
        .with_gradient_tolerance(1e-3 * cost)
        .with_max_step(0.01)
        .with_max_evaluations(1000);
    settings.sameness = MatchTolerance {
        energy: ROUGHNESS * cost,
        distance: 0.005,
    };
    settings.chain = ChainSettings {
        temperature: TEMPERATURE * cost,
        force: 8.0 * contact_slope(energy),
        replicas: 1,
        step: 1e-3,
        arrival: 0.005,
        patience: 150,
        max_steps: 1500,
        spacing: 0.003,
        ..settings.chain
    };
    settings.path = PathSettings {
        segments: 20,
        coarse_iterations: 36,
        rivalry: 0.5,
        iterations: 30,
        rounds: 3,
        max_step: 0.004,
        force_tolerance: LAYER_FORCE * cost,
        saturation: 0.04,
        // A stiff layer bends its valleys, so tops are lowered one by one as well.
        lowering: Some(LoweringSettings::default()),
        energy_tolerance: ROUGHNESS * cost,
        roughness: ROUGHNESS * cost,
        ..settings.path
    };
    settings.families.barrier = FamilyLevel::default_of(energy).map(|level| level.barrier);
    settings
}

/// Settings of [`map_population`](super::map_population).
#[derive(Debug, Clone)]
pub struct GraspMapSettings {
    /// Neighbours, descents, paths, families and seed. Its temperature and force are used only if no better ones are found.
    pub map: MapSettings,
    /// Temperature T of attraction–diffusion. `None`: the usual one of the energy.
    pub temperature: Option<f64>,
    /// Force F = αT of attraction–diffusion, energy per metre. `None` chooses the best of a few that are tried on some pairs.
    pub force: Option<f64>,
    /// How the minima are joined.
    pub search: MapSearch,
}

/// How the minima of a map are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MapSearch {
    /// By relaxed paths over verified passes, and by independent attraction–diffusion searches across every merge; see
    /// [`build_landscape`](crate::topography::build_landscape).
    #[default]
    Passes,
    /// By attraction–diffusion alone, as published; see [`sequential`](crate::topography::sequential). Every barrier is an
    /// upper bound, and the order of the minima matters.
    Adelm,
}

impl GraspMapSettings {
    /// Settings of `landscape build` without flags: [`settings_for_grasps`], with temperature and force chosen.
    pub fn new(energy: &GraspEnergy) -> Self {
        Self {
            map: settings_for_grasps(energy),
            temperature: None,
            force: None,
            search: MapSearch::default(),
        }
    }

    /// The settings of the map with the given temperature and force.
    pub fn map_settings(&self) -> MapSettings {
        let mut map = self.map.clone();
        map.chain.temperature = self.temperature.unwrap_or(map.chain.temperature);
        map.chain.force = self.force.unwrap_or(map.chain.force);
        map
    }
}

/// Journal, progress observer and stage callback of a study.
#[derive(Clone, Copy)]
pub struct StudyRun<'a> {
    /// Journal and progress observer.
    pub run: Run<'a>,
    /// Called after each stage with its name (`quench`, `choose`, `connect`) and its number of energy
    /// evaluations, as far as they were counted.
    pub stage_ended: &'a dyn Fn(&str, usize),
}

impl Default for StudyRun<'_> {
    fn default() -> Self {
        Self {
            run: Run::default(),
            stage_ended: &|_, _| (),
        }
    }
}

impl std::fmt::Debug for StudyRun<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("StudyRun").finish_non_exhaustive()
    }
}
