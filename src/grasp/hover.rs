//! The hovering cost, which tests whether barriers measure force closure.
//!
//! With a small distance weight, a hand that floats off the object has nearly the energy of one that holds it. Every path
//! is then a release and a regrasp, and barriers say nothing about force closure.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::energy::{EnergySettingsError, GraspEnergy};
use crate::energy::Energy;
use crate::optimize::{QuenchSettings, quench};

/// Clearances of the report, metres.
pub const CLEARANCES_M: [f64; 3] = [0.002, 0.005, 0.010];

/// Stiffness of the penalty that keeps the hand away, as a multiple of the distance weight.
const STIFFNESS: f64 = 30.0;

/// Energy of a hand held off the object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HoverCost {
    /// Required clearance, metres.
    pub clearance_m: f64,
    /// Median of the clearance reached, metres.
    pub reached_m: f64,
    /// Quartiles over the grasps of E(hovering) − E(minimum).
    pub quartiles: [f64; 3],
}

/// For each of [`CLEARANCES_M`], the least energy near each of `minima` with every surface point of the hand at least that
/// far off the object, relative to the energy of the minimum.
///
/// # Errors
/// Never for an existing energy, whose settings are valid.
pub fn hover_costs(
    energy: &GraspEnergy,
    minima: &[&[f64]],
) -> Result<Vec<HoverCost>, EnergySettingsError> {
    CLEARANCES_M
        .iter()
        .map(|&clearance_m| {
            let weight = STIFFNESS * energy.settings().distance_weight.max(1.0);
            let held_off = GraspEnergy::new(
                energy.hand().clone(),
                energy.object().clone(),
                *energy.settings(),
            )?
            .with_clearance(clearance_m, weight);
            let costs: Vec<(f64, f64)> = minima
                .par_iter()
                .map(|minimum| {
                    let settings = QuenchSettings::default().with_gradient_tolerance(1e-4);
                    let end = quench(&held_off, minimum, &settings);
                    let mut unused = vec![0.0; energy.space().tangents()];
                    let above = energy.evaluate(&end.x, &mut unused)
                        - energy.evaluate(minimum, &mut unused);
                    (above, energy.clearance_m(&end.x))
                })
                .collect();
            let sorted = |mut values: Vec<f64>| {
                values.sort_by(f64::total_cmp);
                values
            };
            let above = sorted(costs.iter().map(|(above, _)| *above).collect());
            let reached = sorted(costs.iter().map(|(_, reached)| *reached).collect());
            let at = |values: &[f64], quarter: usize| {
                values
                    .get((values.len().max(1) - 1) * quarter / 4)
                    .copied()
                    .unwrap_or(f64::NAN)
            };
            Ok(HoverCost {
                clearance_m,
                reached_m: at(&reached, 2),
                quartiles: [at(&above, 1), at(&above, 2), at(&above, 3)],
            })
        })
        .collect()
}
