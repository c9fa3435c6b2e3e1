//! Synthesis: one chain from a random start to a grasp.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use super::energy::GraspEnergy;
use super::kernel::GraspKernel;
use super::start::start_pose;
use crate::energy::Energy;
use crate::optimize::{self, QuenchSettings};
use crate::sample::{Law, Rng, State, Task, stream};

/// How a chain moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampler {
    /// Metropolis-adjusted Langevin steps with an adaptive step per chain, preconditioned by what each joint really
    /// moves; geometric cooling; the distance weight rises while the chain cools; heat-bath contact moves.
    Annealed,
    /// The sampler of the authors of Liu et al. (2021) as their code has it: temperature and step size are functions of
    /// the energy, the gradient is divided by a running mean of its magnitude, plain Metropolis acceptance, uniform
    /// contact moves, and two rejections in a row force a contact move.
    Released,
}

/// Settings of a synthesis chain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SynthesisSettings {
    /// How a chain moves.
    pub sampler: Sampler,
    /// Steps of a chain; one energy evaluation each.
    pub steps: u32,
    /// Temperature of the first step (annealed sampler).
    pub temperature_start: f64,
    /// Temperature of the last step (annealed sampler).
    pub temperature_end: f64,
    /// Share of the distance weight at the first step (annealed sampler): force closure first, contact later.
    pub distance_ramp_start: f64,
    /// Share of the steps after which the full distance weight is reached.
    pub distance_ramp_share: f64,
    /// Probability of a contact move: 1 − ρ.
    pub contact_probability: f64,
    /// Acceptance rate of pose moves that the step size is adapted to (annealed sampler).
    pub acceptance: f64,
}

impl Default for SynthesisSettings {
    fn default() -> Self {
        Self {
            sampler: Sampler::Annealed,
            steps: 10_000,
            temperature_start: 0.3,
            temperature_end: 0.002,
            distance_ramp_start: 0.05,
            distance_ramp_share: 0.8,
            contact_probability: 0.2,
            acceptance: 0.57,
        }
    }
}

impl SynthesisSettings {
    /// The paper's Algorithm 1 with ρ = 0.85 and what its text leaves out.
    pub fn paper() -> Self {
        Self {
            sampler: Sampler::Released,
            contact_probability: 0.15,
            ..Self::default()
        }
    }

    /// One clear sentence on the first value that makes no sense.
    ///
    /// # Errors
    /// If a probability, share or temperature is out of its range.
    pub fn validate(&self) -> Result<(), SynthesisSettingsError> {
        let positive = [
            ("temperature_start", self.temperature_start),
            ("temperature_end", self.temperature_end),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(SynthesisSettingsError {
                    name,
                    value,
                    range: "above 0",
                });
            }
        }
        let shares = [
            ("distance_ramp_start", self.distance_ramp_start),
            ("distance_ramp_share", self.distance_ramp_share),
            ("contact_probability", self.contact_probability),
            ("acceptance", self.acceptance),
        ];
        for (name, value) in shares {
            if !(value > 0.0 && value <= 1.0) {
                return Err(SynthesisSettingsError {
                    name,
                    value,
                    range: "above 0 and at most 1",
                });
            }
        }
        Ok(())
    }
}

/// A synthesis setting out of its range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} = {value}: must be {range}")]
pub struct SynthesisSettingsError {
    name: &'static str,
    value: f64,
    range: &'static str,
}

/// What a chain ended with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Synthesized {
    /// Number of the chain: its random stream.
    pub chain: u64,
    /// Pose at the end of the chain, before refinement.
    pub raw: Vec<f64>,
    /// Contact set at the end of the chain.
    pub raw_contacts: Vec<u32>,
    /// Pose after refinement on the envelope.
    pub refined: Vec<f64>,
    /// Best contact set of the refined pose.
    pub contacts: Vec<u32>,
    /// E(H, O) of the refined pose.
    pub energy: f64,
    /// Steps of the chain.
    pub steps: u64,
    /// Energy evaluations spent, refinement included.
    pub evaluations: u64,
}

/// Steps between two changes of the distance weight; each change costs one more evaluation.
const RAMP_EVERY: u32 = 50;

/// Runs chain number `chain` under `seed` and refines its end on the envelope.
///
/// Chains are independent: the result depends on the energy, the settings, the seed and the number only.
pub fn synthesize(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    refine: &QuenchSettings,
    seed: u64,
    chain: u64,
) -> Synthesized {
    let mut rng = stream(seed, Task::Synthesis, chain);
    let state = start_state(energy, settings, &mut rng);
    let mut evaluations = u64::from(settings.steps);
    let end = match settings.sampler {
        Sampler::Annealed => anneal(energy, settings, state, &mut rng),
        Sampler::Released => released(energy, settings, state, &mut rng),
    };
    let quench = optimize::quench(energy, &end.coordinates, refine);
    evaluations += quench.evaluations as u64;
    let contacts = energy.choice(&quench.x);
    Synthesized {
        chain,
        raw: end.coordinates,
        raw_contacts: end.discrete,
        refined: quench.x,
        contacts,
        energy: quench.energy,
        steps: u64::from(settings.steps),
        evaluations,
    }
}

fn start_state(energy: &GraspEnergy, settings: &SynthesisSettings, rng: &mut Rng) -> State {
    let points = u32::try_from(energy.hand().surface.len())
        .expect("a hand has fewer than 2³² surface points");
    let mut discrete: Vec<u32> = Vec::new();
    let coordinates = match settings.sampler {
        Sampler::Annealed => start_pose(energy.hand(), energy.object(), rng),
        Sampler::Released => gaussian_pose(energy, rng),
    };
    while discrete.len() < energy.settings().contacts {
        let index = rng.random_range(0..points);
        if !discrete.contains(&index) {
            discrete.push(index);
        }
    }
    State {
        coordinates,
        discrete,
        ..State::default()
    }
}

/// Metropolis: replaces `state` by `proposal` with probability min(1, eʳ).
fn accept(state: &mut State, proposal: &mut State, log_ratio: f64, rng: &mut Rng) -> bool {
    let accepted = rng.random::<f64>().ln() < log_ratio;
    if accepted {
        std::mem::swap(state, proposal);
    }
    accepted
}

fn anneal(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    mut state: State,
    rng: &mut Rng,
) -> State {
    let mut kernel = GraspKernel::new(energy);
    let mut proposal = State::default();
    let mut log_step = (0.01f64).ln();
    let steps = f64::from(settings.steps);
    for n in 0..settings.steps {
        let progress = f64::from(n) / steps;
        let temperature = settings.temperature_start
            * (settings.temperature_end / settings.temperature_start).powf(progress);
        if n % RAMP_EVERY == 0 {
            let ramp = (progress / settings.distance_ramp_share).min(1.0);
            kernel.distance_factor = settings.distance_ramp_start.powf(1.0 - ramp);
            kernel.evaluate(&mut state);
        }
        let law = Law {
            temperature,
            attraction: None,
        };
        if rng.random::<f64>() < settings.contact_probability {
            let log_ratio = kernel.move_contact(&state, temperature, rng, &mut proposal);
            accept(&mut state, &mut proposal, log_ratio, rng);
        } else {
            let log_ratio = kernel.move_pose(&state, &law, log_step.exp(), rng, &mut proposal);
            let accepted = accept(&mut state, &mut proposal, log_ratio, rng);
            // Robbins–Monro toward the wanted acceptance, slow enough to follow the cooling without chasing noise.
            let error = f64::from(u8::from(accepted)) - settings.acceptance;
            log_step += 0.05 * error;
        }
    }
    state
}

/// Constants of the authors' code (`PhysicsGuide.optimize`): temperature and step size as functions of the energy.
const RELEASED_BASE: f64 = 0.026_007_07;
const RELEASED_TEMPERATURE_SLOPE: f64 = 0.039_503_57;
const RELEASED_STEP_SLOPE: f64 = 3.95e-5;
const RELEASED_NOISE: f64 = 0.1;
/// Weight of the *new* gradient in the running mean of its magnitude, as in the code.
const RELEASED_MEAN_WEIGHT: f64 = 0.98;

fn released(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    mut state: State,
    rng: &mut Rng,
) -> State {
    let kernel = GraspKernel::new(energy);
    let points = u32::try_from(energy.hand().surface.len())
        .expect("a hand has fewer than 2³² surface points");
    kernel.evaluate(&mut state);
    let natural = natural_scales(energy);
    let mut mean = vec![0.0; natural.len()];
    let mut proposal = State::default();
    let mut rejections = 0;
    for _ in 0..settings.steps {
        let temperature = (RELEASED_BASE + RELEASED_TEMPERATURE_SLOPE * state.energy).max(1e-6);
        proposal.clone_from(&state);
        if rejections < 2 && rng.random::<f64>() >= settings.contact_probability {
            let step = RELEASED_BASE + RELEASED_STEP_SLOPE * state.energy;
            let mut tangent = vec![0.0; natural.len()];
            for (k, scale) in natural.iter().enumerate() {
                let slope = state.gradient[k] * scale;
                mean[k] =
                    RELEASED_MEAN_WEIGHT * slope.abs() + (1.0 - RELEASED_MEAN_WEIGHT) * mean[k];
                let noise: f64 = StandardNormal.sample(rng);
                let drift = -0.5 * step * step * slope / (mean[k] + 1e-12);
                tangent[k] = scale * (drift + RELEASED_NOISE * step * noise);
            }
            energy.space().shift(&mut proposal.coordinates, &tangent);
        } else {
            let slot = rng.random_range(0..proposal.discrete.len());
            proposal.discrete[slot] = rng.random_range(0..points);
        }
        kernel.evaluate(&mut proposal);
        let log_ratio = (state.energy - proposal.energy) / temperature;
        if accept(&mut state, &mut proposal, log_ratio, rng) {
            rejections = 0;
        } else {
            rejections += 1;
        }
    }
    state
}

/// Tangent length of one natural unit along each tangent: 120 mm, 1 rad, 1 rad per joint.
fn natural_scales(energy: &GraspEnergy) -> Vec<f64> {
    let metric = energy.pose_space().metric();
    let mut scales = vec![super::filter::AUTHORS_UNIT_M; 3];
    scales.extend([metric.radius_of_gyration_m; 3]);
    scales.extend(&metric.joint_levers_m);
    scales
}

/// The authors' start: every natural coordinate a standard normal, whatever the object.
fn gaussian_pose(energy: &GraspEnergy, rng: &mut Rng) -> Vec<f64> {
    let natural = natural_scales(energy);
    let mut x = vec![0.0; energy.space().coordinates()];
    x[3] = 1.0;
    let tangent: Vec<f64> = natural
        .iter()
        .map(|scale| {
            let noise: f64 = StandardNormal.sample(rng);
            scale * noise
        })
        .collect();
    energy.space().shift(&mut x, &tangent);
    x
}
