//! The Markov kernel of grasps.

use std::fmt;

use rand::RngExt;

use super::contact::CONTACTS;
use super::energy::GraspEnergy;
use crate::sample::{Kernel, Mala, Rng, State, TargetDensity};
use crate::space::Space;

/// Share of the steps that rest.
const RESTING: f64 = 0.2;

/// Langevin steps of the pose ([`Mala`]). One step in five rests.
///
/// The force and the temperature of maps were chosen with chains that redrew a contact in these steps. Contacts are no part
/// of the energy. A resting step draws as many random numbers, so that a seed still gives the same map.
pub struct GraspKernel<'a> {
    steps: Mala<'a>,
}

impl<'a> GraspKernel<'a> {
    /// The kernel of `energy`.
    pub fn new(energy: &'a GraspEnergy) -> Self {
        Self {
            steps: Mala::new(energy),
        }
    }
}

impl fmt::Debug for GraspKernel<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.steps.fmt(formatter)
    }
}

impl Kernel for GraspKernel<'_> {
    fn space(&self) -> &dyn Space {
        self.steps.space()
    }

    fn start(&self, x: &[f64]) -> State {
        self.steps.start(x)
    }

    fn propose(
        &self,
        state: &State,
        law: &TargetDensity<'_>,
        step: f64,
        rng: &mut Rng,
        proposal: &mut State,
    ) -> f64 {
        if rng.random::<f64>() >= RESTING {
            return self.steps.propose(state, law, step, rng, proposal);
        }
        let _ = (rng.random_range(0..CONTACTS), rng.random::<f64>());
        proposal.clone_from(state);
        f64::NEG_INFINITY
    }
}
