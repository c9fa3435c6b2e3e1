//! Attraction–diffusion: a chain drawn from one minimum to another, whose highest energy bounds the barrier from above.
//!
//! M. Hill, E. Nijkamp and S.-C. Zhu, *Building a telescope to look into high-dimensional image spaces*, Quarterly of
//! Applied Mathematics 77, 269 (2019), arXiv:1803.01043.

use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::minima::Sameness;
use super::network::Minimum;
use super::path::{Path, near};
use crate::energy::Energy;
use crate::optimize::{QuenchSettings, quench};
use crate::sample::{Attraction, Kernel, Law, Rng, State};

/// Acceptance rate the step length is steered to: optimal for Langevin moves (Roberts and Rosenthal, 1998).
const ACCEPTANCE: f64 = 0.574;

/// Settings of [`chain`]. Energies, lengths and forces are in the units of the surface;
/// [`ChainSettings::for_scales`] sets all of them from one energy and one length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ChainSettings {
    /// Temperature T. A tenth of the typical barrier explores; half of it melts the landscape.
    pub temperature: f64,
    /// Size F = αT of the pull, energy per length: what must beat the steepest slope on the way.
    pub force: f64,
    /// Factor on the force after a failure.
    pub escalation: f64,
    /// Forces tried before a direction counts as unreached.
    pub attempts: usize,
    /// Independent chains in each direction.
    pub replicas: usize,
    /// Length ε of the first step; then steered to the best acceptance rate.
    pub step: f64,
    /// Distance δ from the target at which the chain is quenched, to see whether it has arrived.
    pub arrival: f64,
    /// M: the chain gives up after this many steps in a row without a new least distance.
    pub patience: usize,
    /// Most steps of a chain.
    pub max_steps: usize,
    /// Least distance between two points of the path kept; smaller loops are cut off.
    pub spacing: f64,
}

impl Default for ChainSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl ChainSettings {
    /// Settings for a surface whose typical barrier is `energy` high and `length` wide (the distance between
    /// neighbouring minima).
    pub fn for_scales(energy: f64, length: f64) -> Self {
        Self {
            temperature: 0.05 * energy,
            force: 4.0 * energy / length,
            escalation: 2.0,
            attempts: 3,
            replicas: 1,
            step: 0.01 * length,
            arrival: 0.1 * length,
            patience: 200,
            max_steps: 1500,
            spacing: 0.05 * length,
        }
    }
}

/// What one chain came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// Whether it reached the target's own minimum.
    pub arrived: bool,
    /// Highest unaltered energy met: an upper bound of the barrier (up to the length of a step) if it arrived.
    pub barrier: f64,
    /// The points of the way kept, from start to target, with their energies (of the chain's own discrete part).
    pub path: Path,
    /// Steps made.
    pub steps: usize,
    /// Evaluations spent, quenches included.
    pub evaluations: usize,
}

/// Runs one chain from the minimum `from` toward the minimum `to`, at `force`.
///
/// It moves under exp(−(E + F d(x, x*))/T) until it is within δ of the target and a descent from there ends in the
/// target's own minimum (else δ is halved), or until M steps in a row bring no new least distance (then a last descent
/// decides), or until its highest energy exceeds `bound`.
#[expect(
    clippy::too_many_arguments,
    reason = "a chain is named by two minima, two laws and three ways to stop"
)]
pub fn chain(
    energy: &dyn Energy,
    kernel: &dyn Kernel,
    (from, to): (&Minimum, &Minimum),
    force: f64,
    settings: &ChainSettings,
    (descent, sameness): (&QuenchSettings, &Sameness),
    bound: f64,
    rng: &mut Rng,
) -> Chain {
    let space = kernel.space();
    let mut toward = vec![0.0; space.tangents()];
    let mut nearest = space.toward(&from.coordinates, &to.coordinates, &mut toward);
    // The copy of the target the chain sets out for.
    let mut target = from.coordinates.clone();
    space.shift(&mut target, &toward);
    let law = Law {
        temperature: settings.temperature,
        attraction: Some(Attraction {
            target: &target,
            force,
        }),
    };
    let mut state = kernel.start(&from.coordinates);
    let mut proposal = State::default();
    let mut kept = Path {
        images: vec![from.coordinates.clone()],
        energies: vec![from.energy],
    };
    let mut barrier = from.energy;
    let (mut idle, mut arrival, mut step) = (0, settings.arrival, settings.step);
    let (mut steps, mut quenching) = (0, 0);
    let mut arrived = nearest <= sameness.distance;
    while !arrived && steps < settings.max_steps && idle < settings.patience && barrier <= bound {
        steps += 1;
        idle += 1;
        let ratio = kernel.propose(&state, &law, step, rng, &mut proposal);
        let accepted = rng.random::<f64>().ln() < ratio;
        // Fading steering (Robbins and Monro): early steps find the scale, late ones leave the law alone.
        let chance = ratio.exp().min(1.0);
        step *= ((chance - ACCEPTANCE) / (steps as f64).powf(0.6)).exp();
        if !accepted {
            continue;
        }
        std::mem::swap(&mut state, &mut proposal);
        barrier = barrier.max(state.energy);
        keep(&mut kept, &state, energy, settings.spacing);
        let distance = near(space, &state.coordinates, &target);
        if distance < nearest {
            nearest = distance;
            idle = 0;
        }
        if distance <= arrival {
            let end = quench(energy, &state.coordinates, descent);
            quenching += end.evaluations;
            arrived = sameness.holds(space, &end.x, end.energy, to);
            arrival = 0.5 * distance;
        }
    }
    if !arrived && barrier <= bound {
        // In many dimensions the thermal cloud about the target is wider than δ: the descent decides.
        let end = quench(energy, &state.coordinates, descent);
        quenching += end.evaluations;
        arrived = sameness.holds(space, &end.x, end.energy, to);
    }
    barrier = barrier.max(to.energy);
    if arrived {
        kept.images.push(target);
        kept.energies.push(to.energy);
    }
    Chain {
        arrived,
        barrier,
        path: kept,
        steps,
        evaluations: steps + 1 + quenching,
    }
}

/// Appends the state if it is far enough from the last point kept. If it has come back to an earlier point, the loop in
/// between is cut off: the shortcut is no longer than a spacing.
fn keep(path: &mut Path, state: &State, energy: &dyn Energy, spacing: f64) {
    let distance = |image: &Vec<f64>| near(energy.space(), image, &state.coordinates);
    if path
        .images
        .last()
        .is_some_and(|last| distance(last) < spacing)
    {
        return;
    }
    let back = path
        .images
        .iter()
        .position(|image| distance(image) < spacing);
    if let Some(earlier) = back {
        path.images.truncate(earlier + 1);
        path.energies.truncate(earlier + 1);
    } else {
        path.images.push(state.coordinates.clone());
        path.energies.push(state.energy);
    }
}
