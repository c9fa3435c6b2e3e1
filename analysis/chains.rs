//! Chains with the default settings, and whether their ends hold in simulation.

use std::sync::Arc;

use landscape::evaluation::stability::{Build, Drop, Protocol, Solid, simulate};
use landscape::grasp::energy::EnergySettingsError;
use landscape::grasp::synthesis::{SynthesisSettings, Synthesized, synthesize};
use landscape::grasp::{EnergySettings, GraspEnergy, Judgement, judge};
use landscape::hand::Hand;
use landscape::object::Object;
use landscape::optimize::QuenchSettings;

/// Chains of a hand on an object.
pub(crate) struct Chains {
    pub(crate) energy: GraspEnergy,
    solid: Solid,
    seed: u64,
}

impl Chains {
    pub(crate) fn new(
        hand: &Arc<Hand>,
        object: &Arc<Object>,
        seed: u64,
    ) -> Result<Self, EnergySettingsError> {
        let settings = EnergySettings::default();
        Ok(Self {
            energy: GraspEnergy::new(hand.clone(), object.clone(), settings)?,
            solid: Solid::new(&object.mesh, Build::Pieces),
            seed,
        })
    }

    /// The end of a chain.
    pub(crate) fn end(&self, chain: u64) -> Synthesized {
        let (settings, refine) = (SynthesisSettings::default(), QuenchSettings::default());
        synthesize(&self.energy, &settings, &refine, self.seed, chain)
    }

    pub(crate) fn judge(&self, end: &Synthesized) -> Judgement {
        judge(&self.energy, &end.refined)
    }

    pub(crate) fn holds(&self, end: &Synthesized, protocol: &Protocol) -> bool {
        let (hand, object) = (self.energy.hand(), self.energy.object());
        let (grasp, mass_kg) = (&end.refined, object.mass_kg);
        simulate(hand, grasp, None, &self.solid, mass_kg, protocol).is_stable()
    }
}

/// The drop test.
pub(crate) fn drop() -> Protocol {
    Protocol::Drop(Drop::default())
}

/// The drop test in which the object is let go at once.
pub(crate) fn drop_at_once() -> Protocol {
    Protocol::Drop(Drop {
        settle_s: 0.0,
        ..Drop::default()
    })
}

/// The depth that 95 % of these depths stay below, as text; a dash if there are none.
pub(crate) fn deep(mut depths_m: Vec<f64>) -> String {
    depths_m.sort_by(f64::total_cmp);
    let deep = depths_m.get(depths_m.len() * 95 / 100);
    deep.map_or("–".to_owned(), |depth| format!("{:.2} mm", 1e3 * depth))
}
