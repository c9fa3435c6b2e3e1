//! The sampler: Langevin steps of the pose, uniform moves of the contact set, and refinement.
//!
//! It is Algorithm 1 with the details that the text leaves out and the authors' code has (`PhysicsGuide.optimize` and
//! `refine`): temperature and step size depend on the energy, the gradient is divided by a running mean of its magnitude, and
//! two rejections in a row force a move of the contact set.

use nalgebra::{Isometry3, UnitQuaternion};
use rand::RngExt;

use super::{PaperEnergy, Reading};
use crate::grasp::Grasp;
use crate::grasp::energy::AUTHORS_UNIT_M;
use crate::optimize::{QuenchSettings, quench};
use crate::sample::{Rng, Task, standard_normal, stream};
use crate::space::{Space, joints_of, pose_coordinates, quaternion_of, translation_of};

/// Temperature and step size at energy zero.
const BASE: f64 = 0.026_007_07;
/// Increase of temperature and step size with the energy.
const TEMPERATURE_SLOPE: f64 = 0.039_503_57;
const STEP_SLOPE: f64 = 3.95e-5;
/// Noise relative to the step size.
const NOISE: f64 = 0.1;
/// Weight of the *new* gradient in the running mean of its magnitude.
const MEAN_WEIGHT: f64 = 0.98;
/// Consecutive rejections after which a contact is replaced.
const PATIENCE: u32 = 2;
/// Probability of a move of the contact set, 1 − ρ.
const CONTACT_PROBABILITY: f64 = 0.15;

/// Steps, temperature and step size of the refinement of the code.
const REFINEMENT_STEPS: u32 = 1000;
const REFINEMENT_TEMPERATURE: f64 = 1e-3;
const REFINEMENT_STEP: f64 = 0.1;

/// A state of a chain.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct State {
    /// Pose of the hand.
    pub coordinates: Vec<f64>,
    /// Contact set.
    pub contacts: Vec<u32>,
    /// Energy of both.
    pub energy: f64,
    /// Derivative of the energy along each tangent of the pose.
    gradient: Vec<f64>,
}

/// The result of a chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Number of the chain, which selects its random stream.
    pub chain: u64,
    /// The end of the chain.
    pub raw: Grasp,
    /// The same after refinement, with the same contact set.
    pub refined: Grasp,
    /// Energy of the refined grasp.
    pub energy: f64,
}

/// Runs chain number `chain` and refines its end. `observe` sees every state: the start as number 0, and the state after
/// step n as number n.
pub fn sample(
    energy: &PaperEnergy,
    seed: u64,
    chain: u64,
    observe: &mut dyn FnMut(u32, &State),
) -> Sample {
    let mut rng = stream(seed, Task::Synthesis, chain);
    let mut walker = Walker::new(energy, &mut rng);
    walker.run(energy.settings().steps, &mut rng, observe);
    let grasp = |state: &State| Grasp::new(state.coordinates.clone(), state.contacts.clone());
    let raw = grasp(&walker.state);
    let (refined, height) = match energy.settings().reading {
        Reading::Printed => {
            let held = energy.held(&raw.contacts);
            let end = quench(&held, &raw.pose, &QuenchSettings::default());
            (Grasp::new(end.x, raw.contacts.clone()), end.energy)
        }
        Reading::Released => {
            walker.refine(&mut rng);
            (grasp(&walker.state), walker.state.energy)
        }
    };
    Sample {
        chain,
        raw,
        refined,
        energy: height,
    }
}

/// A chain with its own preconditioner. That of the authors is shared by a batch, which couples the chains.
struct Walker<'a> {
    energy: &'a PaperEnergy,
    scales: Vec<f64>,
    mean: Vec<f64>,
    state: State,
    proposal: State,
}

impl<'a> Walker<'a> {
    fn new(energy: &'a PaperEnergy, rng: &mut Rng) -> Self {
        let coordinates = start(energy, rng);
        let mut contacts: Vec<u32> = Vec::new();
        while contacts.len() < energy.settings().contacts {
            let index = draw(energy.candidates(), rng);
            if !contacts.contains(&index) {
                contacts.push(index);
            }
        }
        let mut state = State {
            coordinates,
            contacts,
            ..State::default()
        };
        evaluate(energy, &mut state);
        let scales = natural_scales(energy);
        Self {
            energy,
            mean: vec![0.0; scales.len()],
            scales,
            state,
            proposal: State::default(),
        }
    }

    fn run(&mut self, steps: u32, rng: &mut Rng, observe: &mut dyn FnMut(u32, &State)) {
        let mut rejections = 0;
        observe(0, &self.state);
        for n in 0..steps {
            let temperature = (BASE + TEMPERATURE_SLOPE * self.state.energy).max(1e-6);
            if rejections < PATIENCE && rng.random::<f64>() >= CONTACT_PROBABILITY {
                self.propose_pose(BASE + STEP_SLOPE * self.state.energy, rng);
            } else {
                self.proposal.clone_from(&self.state);
                let slot = rng.random_range(0..self.proposal.contacts.len());
                self.proposal.contacts[slot] = draw(self.energy.candidates(), rng);
            }
            if self.decide(temperature, rng) {
                rejections = 0;
            } else {
                rejections += 1;
            }
            observe(n + 1, &self.state);
        }
    }

    /// The refinement as coded: noisy steps of four times the length at a low temperature, with a fixed contact set.
    fn refine(&mut self, rng: &mut Rng) {
        for _ in 0..REFINEMENT_STEPS {
            self.propose_pose(REFINEMENT_STEP, rng);
            self.decide(REFINEMENT_TEMPERATURE, rng);
        }
    }

    fn propose_pose(&mut self, step: f64, rng: &mut Rng) {
        self.proposal.clone_from(&self.state);
        let mut tangent = vec![0.0; self.scales.len()];
        for (k, scale) in self.scales.iter().enumerate() {
            let slope = self.state.gradient[k] * scale;
            self.mean[k] = MEAN_WEIGHT * slope.abs() + (1.0 - MEAN_WEIGHT) * self.mean[k];
            let noise = standard_normal(rng);
            let drift = -0.5 * step * step * slope / (self.mean[k] + 1e-12);
            tangent[k] = scale * (drift + NOISE * step * noise);
        }
        let space = self.energy.space();
        space.exp(&mut self.proposal.coordinates, &tangent);
    }

    /// Plain Metropolis at `temperature`, without correction for the drift or for a state-dependent temperature.
    fn decide(&mut self, temperature: f64, rng: &mut Rng) -> bool {
        evaluate(self.energy, &mut self.proposal);
        let log_ratio = (self.state.energy - self.proposal.energy) / temperature;
        let accepted = libm::log(rng.random::<f64>()) < log_ratio;
        if accepted {
            std::mem::swap(&mut self.state, &mut self.proposal);
        }
        accepted
    }
}

fn evaluate(energy: &PaperEnergy, state: &mut State) {
    state.gradient.resize(energy.space().tangents(), 0.0);
    state.energy = energy.evaluate(&state.coordinates, &state.contacts, &mut state.gradient);
}

fn draw(candidates: &[u32], rng: &mut Rng) -> u32 {
    candidates[rng.random_range(0..candidates.len())]
}

/// Length of the natural unit of each tangent: 120 mm, 1 rad, and 1 rad for each joint.
fn natural_scales(energy: &PaperEnergy) -> Vec<f64> {
    let metric = energy.space().metric();
    let mut scales = vec![AUTHORS_UNIT_M; 3];
    scales.extend([metric.radius_of_gyration_m; 3]);
    scales.extend(&metric.joint_levers_m);
    scales
}

/// The authors' start, independent of the object: every coordinate is a standard normal. The unit of the hand's origin
/// about the object's centroid is 120 mm, and joint angles are in radians. The authors' six numbers of a rotation,
/// orthonormalised, are uniform over rotations; so are the four of a quaternion.
fn start(energy: &PaperEnergy, rng: &mut Rng) -> Vec<f64> {
    let mut x: Vec<f64> = (0..energy.space().coordinates())
        .map(|_| standard_normal(rng))
        .collect();
    let centroid = energy.object().centroid;
    for k in 0..3 {
        x[k] = centroid[k] + AUTHORS_UNIT_M * x[k];
    }
    let rotation = UnitQuaternion::from_quaternion(quaternion_of(&x));
    let pose = Isometry3::from_parts(translation_of(&x).into(), rotation);
    pose_coordinates(&pose, joints_of(&x))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::grasp::paper::PaperSettings;
    use crate::hand::Hand;
    use crate::object::Object;
    use crate::space::object_from_hand;

    /// Both refinements keep the contacts and lower the energy, every state is seen, and the same chain has the same bits.
    #[test]
    fn a_chain_is_seen_and_refined() {
        let (hand, ball) = (Hand::human(), Object::named("ball").unwrap());
        let (hand, ball) = (Arc::new(hand), Arc::new(ball));
        for settings in [PaperSettings::printed(), PaperSettings::released()] {
            let settings = PaperSettings {
                steps: 200,
                fingertips_only: true,
                ..settings
            };
            let energy = PaperEnergy::new(hand.clone(), ball.clone(), settings);
            let mut seen = Vec::new();
            let end = sample(&energy, 1, 2, &mut |n, state| seen.push((n, state.clone())));
            let numbers: Vec<u32> = seen.iter().map(|(n, _)| *n).collect();
            assert_eq!(numbers, (0..=200).collect::<Vec<u32>>());
            let offset = object_from_hand(&seen[0].1.coordinates).translation.vector;
            let offset = (offset - ball.centroid).norm();
            assert!(offset > 0.01 && offset < 0.6, "{offset}");
            let (_, last) = &seen[200];
            assert_eq!(last.contacts, end.raw.contacts);
            assert_eq!(end.raw.contacts, end.refined.contacts);
            assert!(
                end.raw
                    .contacts
                    .iter()
                    .all(|c| energy.candidates().contains(c))
            );
            assert!(end.energy < last.energy, "{} {}", end.energy, last.energy);
            assert_eq!(end, sample(&energy, 1, 2, &mut |_, _| ()));
        }
    }
}
