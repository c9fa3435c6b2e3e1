//! Settings for maps of grasps.

use crate::grasp::GraspEnergy;
use crate::topography::{ChainSettings, MapSettings, MatchTolerance, PathSettings, SeamSettings};

/// The slope of the distance term of one contact, energy per metre. It is the unit of a chain's force, which must exceed
/// the slope of all contacts together.
pub(super) fn contact_slope(energy: &GraspEnergy) -> f64 {
    energy.settings().distance_weight / energy.unit_m()
}

/// Settings of [`build_landscape`](crate::topography::build_landscape) for the grasps of a hand, as in `landscape build`.
/// Energies are of order 0.1, and lengths are centimetres. Minima that differ by less than the spacing of the hand's
/// surface points are one grasp.
pub fn settings_for_grasps(energy: &GraspEnergy) -> MapSettings {
    let mut settings = MapSettings::for_scales(0.3, 0.04);
    settings.neighbours = 6;
    settings.retry_rounds = 1;
    settings.decisive_replicas = 3;
    settings.quench = settings
        .quench
        .with_gradient_tolerance(1e-5)
        .with_max_step(0.01)
        .with_max_evaluations(1000);
    settings.sameness = MatchTolerance {
        energy: 0.02,
        distance: 0.005,
    };
    settings.chain = ChainSettings {
        temperature: 0.01,
        force: 8.0 * contact_slope(energy),
        attempts: 1,
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
        iterations: 30,
        rounds: 3,
        max_step: 0.004,
        force_tolerance: 2.0,
        // Longer than any step, so that Newton steps are not limited.
        saturation: 1.0,
        seams: Some(SeamSettings {
            spacing: 5e-4,
            moves: 100,
            halvings: 2,
        }),
        exact_below: 0.5,
        energy_tolerance: 0.02,
        ..settings.path
    };
    settings
}
