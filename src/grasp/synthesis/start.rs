//! The first state of a chain.

use crate::sample::standard_normal;
use rand::RngExt;

use super::annealed::Schedule;
use super::released::gaussian_pose;
use super::{Start, SynthesisSettings};
use crate::energy::Energy;
use crate::grasp::energy::GraspEnergy;
use crate::grasp::start::start_pose_facing;
use crate::sample::{Rng, State};
use crate::space::Space;
use crate::space::vector::norm;

/// A grasp from which a chain starts instead of a random pose.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a> {
    /// Its pose: coordinates of [`PoseSpace`](crate::space::PoseSpace).
    pub x: &'a [f64],
    /// Length of its initial displacement in a random direction, in metres of that space.
    pub displacement_m: f64,
}

/// The displaced given pose with its best contact set.
pub(super) fn given_start(energy: &GraspEnergy, given: &Given<'_>, rng: &mut Rng) -> State {
    let space = energy.space();
    let mut coordinates = given.x.to_vec();
    if given.displacement_m > 0.0 {
        displace(space, &mut coordinates, given.displacement_m, rng);
    }
    State {
        discrete: energy.contacts(&coordinates),
        coordinates,
        ..State::default()
    }
}

/// Moves `coordinates` by `length_m` in a random direction. Step scales keep joints from turning farther than others move.
pub(super) fn displace(space: &dyn Space, coordinates: &mut [f64], length_m: f64, rng: &mut Rng) {
    let mut tangent: Vec<f64> = space
        .step_scales()
        .iter()
        .map(|scale| {
            let noise = standard_normal(rng);
            scale * noise
        })
        .collect();
    let factor = length_m / norm(&tangent);
    for t in &mut tangent {
        *t *= factor;
    }
    space.exp(coordinates, &tangent);
}

/// Draws the first state of chain number `chain`.
pub(super) fn start(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    chain: u64,
    rng: &mut Rng,
) -> State {
    let samples = &energy.object().surface_samples;
    let faced = match settings.start {
        Start::Gaussian => None,
        Start::Surface => Some(&samples[rng.random_range(0..samples.len())]),
        Start::EvenSurface => {
            let place = usize::try_from(chain % samples.len() as u64)
                .expect("less than the number of samples");
            Some(&samples[place])
        }
    };
    let pose = |rng: &mut Rng| match faced {
        None => gaussian_pose(energy, rng),
        Some(faced) => start_pose_facing(energy.hand(), faced, rng),
    };
    if settings.start_candidates == 1 {
        let coordinates = pose(rng);
        return State {
            coordinates,
            discrete: random_contacts(energy, rng),
            ..State::default()
        };
    }
    let ramp = Schedule::new(settings, 1).ramp(0);
    let mut best: Option<(f64, State)> = None;
    for _ in 0..settings.start_candidates {
        let coordinates = pose(rng);
        let (promise, discrete) = energy.start_score(&coordinates, ramp);
        if best.as_ref().is_none_or(|(least, _)| promise < *least) {
            let state = State {
                coordinates,
                discrete,
                ..State::default()
            };
            best = Some((promise, state));
        }
    }
    best.expect("there is at least one candidate").1
}

fn random_contacts(energy: &GraspEnergy, rng: &mut Rng) -> Vec<u32> {
    let candidates = energy.contact_candidates();
    let mut contacts: Vec<u32> = Vec::new();
    while contacts.len() < energy.settings().contacts {
        let index = candidates[rng.random_range(0..candidates.len())];
        if !contacts.contains(&index) {
            contacts.push(index);
        }
    }
    contacts
}
