//! The sampler of the authors' code (`PhysicsGuide.optimize` and `refine`), with details missing in the paper.

use crate::sample::standard_normal;
use nalgebra::{Isometry3, UnitQuaternion};
use rand::RngExt;

use super::{Observe, SynthesisSettings, accept};
use crate::energy::Energy;
use crate::grasp::energy::AUTHORS_UNIT_M;
use crate::grasp::energy::GraspEnergy;
use crate::grasp::kernel::GraspKernel;
use crate::sample::{Rng, State};
use crate::space::{joints_of, pose_coordinates, quaternion_of, translation_of};

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

/// Steps, temperature and step size of the refinement.
const REFINEMENT_STEPS: u32 = 1000;
const REFINEMENT_TEMPERATURE: f64 = 1e-3;
const REFINEMENT_STEP: f64 = 0.1;

/// A chain of the authors' sampler with its own preconditioner (theirs is shared by a batch, which couples the chains).
pub(super) struct Chain<'a> {
    energy: &'a GraspEnergy,
    kernel: GraspKernel<'a>,
    scales: Vec<f64>,
    mean: Vec<f64>,
    state: State,
    proposal: State,
}

impl<'a> Chain<'a> {
    pub(super) fn new(energy: &'a GraspEnergy, mut state: State) -> Self {
        let kernel = GraspKernel::new(energy);
        kernel.evaluate(&mut state);
        let scales = natural_scales(energy);
        Self {
            energy,
            kernel,
            mean: vec![0.0; scales.len()],
            scales,
            state,
            proposal: State::default(),
        }
    }

    /// The main loop. Replacement contacts are drawn uniformly from all candidates.
    pub(super) fn run(
        &mut self,
        settings: &SynthesisSettings,
        steps: u32,
        rng: &mut Rng,
        observe: Observe<'_>,
    ) {
        let mut rejections = 0;
        observe(0, &self.state);
        for n in 0..steps {
            let temperature = (BASE + TEMPERATURE_SLOPE * self.state.energy).max(1e-6);
            if rejections < PATIENCE && rng.random::<f64>() >= settings.contact_probability {
                self.propose_pose(BASE + STEP_SLOPE * self.state.energy, rng);
            } else {
                let candidates = self.energy.contact_candidates();
                self.proposal.clone_from(&self.state);
                let slot = rng.random_range(0..self.proposal.discrete.len());
                self.proposal.discrete[slot] = candidates[rng.random_range(0..candidates.len())];
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
    pub(super) fn refine(&mut self, rng: &mut Rng) -> u32 {
        for _ in 0..REFINEMENT_STEPS {
            self.propose_pose(REFINEMENT_STEP, rng);
            self.decide(REFINEMENT_TEMPERATURE, rng);
        }
        REFINEMENT_STEPS
    }

    pub(super) fn state(&self) -> &State {
        &self.state
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
        self.energy
            .space()
            .exp(&mut self.proposal.coordinates, &tangent);
    }

    /// Plain Metropolis at `temperature`, without correction for the drift or for a state-dependent temperature.
    fn decide(&mut self, temperature: f64, rng: &mut Rng) -> bool {
        self.kernel.evaluate(&mut self.proposal);
        let log_ratio = (self.state.energy - self.proposal.energy) / temperature;
        accept(&mut self.state, &mut self.proposal, log_ratio, rng)
    }
}

/// Length of the natural unit of each tangent: 120 mm, 1 rad, and 1 rad for each joint.
fn natural_scales(energy: &GraspEnergy) -> Vec<f64> {
    let metric = energy.pose_space().metric();
    let mut scales = vec![AUTHORS_UNIT_M; 3];
    scales.extend([metric.radius_of_gyration_m; 3]);
    scales.extend(&metric.joint_levers_m);
    scales
}

/// The authors' start, independent of the object: every coordinate is a standard normal. The unit of the hand's origin
/// about the object's centroid is 120 mm, and joint angles are in radians. The authors' six numbers of a rotation,
/// orthonormalised, are uniform over rotations; so are the four of a quaternion.
pub(super) fn gaussian_pose(energy: &GraspEnergy, rng: &mut Rng) -> Vec<f64> {
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
