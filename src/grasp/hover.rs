//! The hovering cost, which tests whether barriers measure force closure.
//!
//! With a small distance weight, a hand that floats off the object has nearly the energy of one that holds it. Every path
//! is then a release and a regrasp, and barriers say nothing about force closure.

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

/// Energies that keep the hand off the object, one for each of [`CLEARANCES_M`].
#[derive(Debug)]
pub struct HeldOff<'a> {
    energy: &'a GraspEnergy,
    held_off: Vec<GraspEnergy>,
}

impl<'a> HeldOff<'a> {
    /// The energies beside `energy`.
    ///
    /// # Errors
    /// Never for an existing energy, whose settings are valid.
    pub fn new(energy: &'a GraspEnergy) -> Result<Self, EnergySettingsError> {
        let weight = STIFFNESS * energy.settings().distance_weight.max(1.0);
        let held_off = CLEARANCES_M.iter().map(|&clearance_m| {
            let (hand, object) = (energy.hand().clone(), energy.object().clone());
            let held_off = GraspEnergy::new(hand, object, *energy.settings())?;
            Ok(held_off.with_clearance(clearance_m, weight))
        });
        Ok(Self {
            energy,
            held_off: held_off.collect::<Result<_, _>>()?,
        })
    }

    /// The least energy near `minimum` with every surface point of the hand at least `CLEARANCES_M[clearance]` off the
    /// object, relative to the energy of the minimum, and the clearance that is reached, metres.
    ///
    /// # Panics
    /// If there is no such clearance, or if the minimum belongs to another hand.
    pub fn probe(&self, clearance: usize, minimum: &[f64]) -> [f64; 2] {
        let settings = QuenchSettings::default().with_gradient_tolerance(1e-4);
        let end = quench(&self.held_off[clearance], minimum, &settings);
        let mut unused = vec![0.0; self.energy.space().tangents()];
        let mut energy = |x: &[f64]| self.energy.evaluate(x, &mut unused);
        let above = energy(&end.x) - energy(minimum);
        [above, self.energy.clearance_m(&end.x)]
    }
}

impl HoverCost {
    /// Medians and quartiles of what [`HeldOff::probe`] has found for one clearance.
    pub fn of(clearance_m: f64, probed: &[[f64; 2]]) -> Self {
        let quarter = |values: fn(&[f64; 2]) -> f64, quarter: usize| {
            let mut sorted: Vec<f64> = probed.iter().map(values).collect();
            sorted.sort_by(f64::total_cmp);
            let place = (sorted.len().max(1) - 1) * quarter / 4;
            sorted.get(place).copied().unwrap_or(f64::NAN)
        };
        Self {
            clearance_m,
            reached_m: quarter(|[_, reached_m]| *reached_m, 2),
            quartiles: [1, 2, 3].map(|k| quarter(|[above, _]| *above, k)),
        }
    }
}
