//! Shared by the programs of Figures 5, 6 and 11: chains of the paper's method and of the default one.

use std::sync::Arc;

use landscape::grasp::energy::EnergySettingsError;
use landscape::grasp::paper::{PaperEnergy, PaperSettings, Reading, sample};
use landscape::grasp::synthesis::{SynthesisSettings, synthesize_observed};
use landscape::grasp::{
    EnergySettings, Grasp, GraspEnergy, Judgement, MeasuredContact, judge, measure_contacts,
};
use landscape::hand::Hand;
use landscape::object::Object;
use landscape::optimize::QuenchSettings;
use landscape::sample::State;

/// A way of running chains of a hand on an object.
pub(crate) enum Method {
    /// The paper's method, as printed or as released.
    Paper(Box<PaperEnergy>),
    /// The default energy and sampler.
    Closed(Box<GraspEnergy>, Box<SynthesisSettings>),
}

/// The end of a chain, before and after refinement.
pub(crate) struct End {
    pub(crate) chain: u64,
    pub(crate) steps: u64,
    pub(crate) raw: Grasp,
    pub(crate) refined: Grasp,
}

impl Method {
    pub(crate) fn paper(hand: &Arc<Hand>, object: &Arc<Object>, settings: PaperSettings) -> Self {
        Self::Paper(Box::new(PaperEnergy::new(
            hand.clone(),
            object.clone(),
            settings,
        )))
    }

    pub(crate) fn closed(
        hand: &Arc<Hand>,
        object: &Arc<Object>,
    ) -> Result<Self, EnergySettingsError> {
        let energy = GraspEnergy::new(hand.clone(), object.clone(), EnergySettings::default())?;
        let synthesis = SynthesisSettings::default();
        Ok(Self::Closed(Box::new(energy), Box::new(synthesis)))
    }

    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Paper(energy) => match energy.settings().reading {
                Reading::Printed => "as printed",
                Reading::Released => "as released",
            },
            Self::Closed(..) => "closed",
        }
    }

    pub(crate) fn hand(&self) -> &Arc<Hand> {
        match self {
            Self::Paper(energy) => energy.hand(),
            Self::Closed(energy, _) => energy.hand(),
        }
    }

    pub(crate) fn object(&self) -> &Arc<Object> {
        match self {
            Self::Paper(energy) => energy.object(),
            Self::Closed(energy, _) => energy.object(),
        }
    }

    /// Runs chain number `chain`; `observe` sees every step and can have its grasp.
    pub(crate) fn run(
        &self,
        seed: u64,
        chain: u64,
        observe: &mut dyn FnMut(u32, &dyn Fn() -> Grasp),
    ) -> End {
        match self {
            Self::Paper(energy) => {
                let end = sample(energy, seed, chain, &mut |n, state| {
                    let contacts = || state.contacts.clone();
                    observe(n, &|| Grasp::new(state.coordinates.clone(), contacts()));
                });
                End {
                    chain,
                    steps: energy.settings().steps.into(),
                    raw: end.raw,
                    refined: end.refined,
                }
            }
            Self::Closed(energy, synthesis) => {
                let refine = QuenchSettings::default();
                let observe = &mut |n, state: &State| {
                    observe(n, &|| Grasp::best(energy, state.coordinates.clone()));
                };
                let end = synthesize_observed(energy, synthesis, &refine, seed, chain, observe);
                End {
                    chain,
                    steps: end.steps,
                    raw: end.raw,
                    refined: end.refined,
                }
            }
        }
    }

    pub(crate) fn judge(&self, grasp: &Grasp) -> Judgement {
        match self {
            Self::Paper(energy) => energy.judge(grasp),
            Self::Closed(energy, _) => judge(energy, grasp),
        }
    }

    pub(crate) fn contacts(&self, grasp: &Grasp) -> Vec<MeasuredContact> {
        match self {
            Self::Paper(energy) => energy.measure_contacts(grasp),
            Self::Closed(energy, _) => measure_contacts(energy, grasp),
        }
    }
}
