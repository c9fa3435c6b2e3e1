//! The Markov kernel of grasps: Langevin moves of the pose, heat-bath moves of the contact set.

use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::energy::{GraspEnergy, Ramp};
use crate::energy::{Energy, Piecewise};
use crate::sample::{Kernel, Rng, State, TargetDensity, langevin};
use crate::space::Space;

/// Scaling of the noise of pose moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StepScales {
    /// Scaled by the movement of the points that depend on each joint.
    Levers,
    /// Scaled by the metric of the pose space: the movement of the average point of the hand for each joint.
    Metric,
}

/// Moves (pose, contact set): with probability `contact_probability` one contact is redrawn from its conditional
/// distribution (heat bath), otherwise the pose makes a Metropolis-adjusted Langevin step. The energy of its states is E(H,
/// x, O), an upper bound of the envelope E(H, O).
#[derive(Debug, Clone)]
pub struct GraspKernel<'a> {
    energy: &'a GraspEnergy,
    scales: Vec<f64>,
    /// Probability of a contact move (1 − ρ in Liu et al. 2021, Algorithm 1).
    pub contact_probability: f64,
    /// Factors on weights (see [`GraspEnergy::evaluate_ramped`]).
    pub ramp: Ramp,
}

/// Contacts with a heat-bath weight below e⁻³⁰ of the greatest are ignored.
const NEGLIGIBLE: f64 = 30.0;

impl<'a> GraspKernel<'a> {
    /// The kernel of `energy`, with a contact move in every fifth step on average.
    pub fn new(energy: &'a GraspEnergy) -> Self {
        Self {
            energy,
            scales: energy.space().step_scales(),
            contact_probability: 0.2,
            ramp: Ramp::default(),
        }
    }

    /// Sets the scaling of the noise of pose moves.
    #[must_use]
    pub fn with_step_scales(mut self, scales: StepScales) -> Self {
        self.scales = match scales {
            StepScales::Levers => self.energy.space().step_scales(),
            StepScales::Metric => vec![1.0; self.energy.space().tangents()],
        };
        self
    }

    /// Computes the energy and gradient of `state` for its pose and contact set.
    pub fn evaluate(&self, state: &mut State) {
        state.gradient.resize(self.energy.space().tangents(), 0.0);
        state.energy = self.energy.evaluate_ramped(
            &state.coordinates,
            &state.discrete,
            self.ramp,
            &mut state.gradient,
        );
    }

    /// Proposes a Langevin step of the pose and returns the logarithm of the acceptance ratio.
    pub fn move_pose(
        &self,
        state: &State,
        law: &TargetDensity<'_>,
        step: f64,
        rng: &mut Rng,
        proposal: &mut State,
    ) -> f64 {
        proposal.discrete.clone_from(&state.discrete);
        langevin(
            self.space(),
            &self.scales,
            state,
            law,
            step,
            rng,
            proposal,
            |x, gradient| {
                self.energy
                    .evaluate_ramped(x, &state.discrete, self.ramp, gradient)
            },
        )
    }

    /// Redraws one contact given the pose and the other contacts. Returns the logarithm of the acceptance ratio.
    ///
    /// Without a rank condition this is 0 up to rounding, because the proposal *is* the conditional distribution. The rank
    /// condition is not part of the proposal ([`GraspEnergy::heat_bath_costs`]) and decides on acceptance.
    pub fn move_contact(
        &self,
        state: &State,
        temperature: f64,
        rng: &mut Rng,
        proposal: &mut State,
    ) -> f64 {
        proposal.clone_from(state);
        if state.discrete.is_empty() {
            return f64::NEG_INFINITY;
        }
        let slot = rng.random_range(0..state.discrete.len());
        let mut others = state.discrete.clone();
        others.remove(slot);
        let options = self.energy.heat_bath_costs(
            &state.coordinates,
            &others,
            self.ramp.distance,
            NEGLIGIBLE * temperature,
        );
        let least = options.iter().fold(f64::INFINITY, |m, (_, e)| m.min(*e));
        let weights: Vec<f64> = options
            .iter()
            .map(|(_, energy)| libm::exp((least - energy) / temperature))
            .collect();
        let mut left = rng.random::<f64>() * weights.iter().sum::<f64>();
        let present = state.discrete[slot];
        let mut chosen = None;
        for (option, weight) in options.iter().zip(&weights) {
            chosen = Some(*option);
            left -= weight;
            if left < 0.0 {
                break;
            }
        }
        let Some((chosen, cost)) = chosen.filter(|(index, _)| *index != present) else {
            return 0.0;
        };
        proposal.discrete[slot] = chosen;
        self.evaluate(proposal);
        // A present contact outside the options has a negligible weight and is always replaced.
        let present_cost = options.iter().find(|(index, _)| *index == present);
        present_cost.map_or(0.0, |(_, present_cost)| {
            ((state.energy - present_cost) - (proposal.energy - cost)) / temperature
        })
    }

    /// Proposes any candidate as a contact. Returns the logarithm of the acceptance ratio (−∞ if already in the set).
    pub fn move_contact_uniformly(
        &self,
        state: &State,
        temperature: f64,
        rng: &mut Rng,
        proposal: &mut State,
    ) -> f64 {
        proposal.clone_from(state);
        if state.discrete.is_empty() {
            return f64::NEG_INFINITY;
        }
        let candidates = self.energy.contact_candidates();
        let slot = rng.random_range(0..proposal.discrete.len());
        let candidate = candidates[rng.random_range(0..candidates.len())];
        if candidate == state.discrete[slot] {
            return 0.0;
        }
        if state.discrete.contains(&candidate) {
            return f64::NEG_INFINITY;
        }
        proposal.discrete[slot] = candidate;
        self.evaluate(proposal);
        (state.energy - proposal.energy) / temperature
    }
}

impl Kernel for GraspKernel<'_> {
    fn space(&self) -> &dyn Space {
        self.energy.space()
    }

    fn start(&self, x: &[f64]) -> State {
        let mut state = State {
            coordinates: x.to_vec(),
            discrete: self.energy.active_piece(x),
            ..State::default()
        };
        self.evaluate(&mut state);
        state
    }

    fn propose(
        &self,
        state: &State,
        law: &TargetDensity<'_>,
        step: f64,
        rng: &mut Rng,
        proposal: &mut State,
    ) -> f64 {
        if rng.random::<f64>() < self.contact_probability {
            self.move_contact(state, law.temperature, rng, proposal)
        } else {
            self.move_pose(state, law, step, rng, proposal)
        }
    }
}
