//! The first state of a chain.

use rand::RngExt;

use crate::energy::Energy;
use crate::grasp::contact::CONTACTS;
use crate::grasp::energy::GraspEnergy;
use crate::grasp::start::start_pose_facing;
use crate::sample::{Rng, standard_normal};
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

/// The displaced given pose.
pub(super) fn given_start(energy: &GraspEnergy, given: &Given<'_>, rng: &mut Rng) -> Vec<f64> {
    let mut coordinates = given.x.to_vec();
    if given.displacement_m > 0.0 {
        displace(energy.space(), &mut coordinates, given.displacement_m, rng);
    }
    coordinates
}

/// Moves `coordinates` by `length_m` in a random direction. Step scales keep joints from turning farther than others move.
fn displace(space: &dyn Space, coordinates: &mut [f64], length_m: f64, rng: &mut Rng) {
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

/// Draws the first pose of chain number `chain`: the palm faces point number `chain` of an even sequence over the object's
/// surface.
pub(super) fn start(energy: &GraspEnergy, chain: u64, rng: &mut Rng) -> Vec<f64> {
    let samples = &energy.object().surface_samples;
    let place =
        usize::try_from(chain % samples.len() as u64).expect("less than the number of samples");
    let coordinates = start_pose_facing(energy.hand(), &samples[place], rng);
    skip_contacts(energy, rng);
    coordinates
}

/// Draws a random contact set that nothing uses: so a seed still gives the grasps that it gave when starts had contacts.
fn skip_contacts(energy: &GraspEnergy, rng: &mut Rng) {
    let hand = energy.hand();
    let count = (hand.surface.iter())
        .filter(|point| hand.may_touch(point))
        .count();
    let mut drawn: Vec<usize> = Vec::new();
    while drawn.len() < CONTACTS {
        let index = rng.random_range(0..count);
        if !drawn.contains(&index) {
            drawn.push(index);
        }
    }
}
