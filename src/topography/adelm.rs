//! Attraction–diffusion: a chain drawn from one minimum to another, whose highest energy bounds the barrier from above.
//!
//! M. Hill, E. Nijkamp and S.-C. Zhu, *Building a telescope to look into high-dimensional image spaces*, Quarterly of
//! Applied Mathematics 77, 269 (2019), arXiv:1803.01043.

use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::minima::MatchTolerance;
use super::network::Minimum;
use super::path::{Path, near};
use crate::energy::Energy;
use crate::optimize::{QuenchSettings, quench};
use crate::sample::{Attraction, Kernel, Rng, State, TargetDensity};
use crate::space::vector::dot;

/// Acceptance rate the step length is steered to: optimal for Langevin moves (Roberts and Rosenthal, 1998).
const ACCEPTANCE: f64 = 0.574;

/// Settings of [`chain`]. Energies, lengths and forces are in the units of the surface;
/// [`ChainSettings::for_scales`] sets all of them from one energy and one length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ChainSettings {
    /// Temperature T. A tenth of the typical barrier explores; half of it melts the landscape.
    pub temperature: f64,
    /// Size F = αT of the pull, energy per length: what must beat the steepest slope on the way. The α of the altered law
    /// exp(−(E/T + α d)) is [`ChainSettings::alpha`].
    pub force: f64,
    /// Factor on the force after a failure.
    pub escalation: f64,
    /// Forces tried before a direction counts as unreached.
    pub attempts: usize,
    /// Independent chains in each direction.
    pub replicas: usize,
    /// Length ε of the first step.
    pub step: f64,
    /// Whether later steps are steered to the best acceptance rate; else all have the length of the first, as published.
    pub steered: bool,
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
            steered: true,
            arrival: 0.1 * length,
            patience: 200,
            max_steps: 1500,
            spacing: 0.05 * length,
        }
    }

    /// α = F/T of the published law exp(−(E/T + α d)), per length.
    pub fn alpha(&self) -> f64 {
        self.force / self.temperature
    }
}

/// What one chain came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// Whether it reached the target's own minimum.
    pub arrived: bool,
    /// Highest unaltered energy met: an upper bound of the barrier if it arrived. Between two states the energy is that of
    /// the cubic through their values and slopes, so that a step across a ridge is not taken for a pass below it; the
    /// bound holds up to the fourth power of the length of a step.
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
    (descent, sameness): (&QuenchSettings, &MatchTolerance),
    bound: f64,
    rng: &mut Rng,
) -> Chain {
    let space = kernel.space();
    let mut toward = vec![0.0; space.tangents()];
    let mut nearest = space.log(&from.coordinates, &to.coordinates, &mut toward);
    // The copy of the target the chain sets out for.
    let mut target = from.coordinates.clone();
    space.exp(&mut target, &toward);
    let law = TargetDensity {
        temperature: settings.temperature,
        attraction: Some(Attraction {
            target: &target,
            force,
        }),
    };
    let mut walk = Walk::new(kernel, &from.coordinates, settings);
    let mut kept = Path {
        images: vec![from.coordinates.clone()],
        energies: vec![from.energy],
    };
    let mut barrier = from.energy;
    let (mut idle, mut arrival, mut quenching) = (0, settings.arrival, 0);
    let mut arrived = nearest <= sameness.distance;
    while !arrived
        && walk.steps < settings.max_steps
        && idle < settings.patience
        && barrier <= bound
    {
        idle += 1;
        let Some(top) = walk.advance(&law, rng) else {
            continue;
        };
        let state = &walk.state;
        barrier = barrier.max(top);
        keep(&mut kept, state, energy, settings.spacing);
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
    let Walk { state, steps, .. } = walk;
    if !arrived && barrier <= bound {
        // In many dimensions the thermal cloud about the target is wider than δ: the descent decides.
        let end = quench(energy, &state.coordinates, descent);
        quenching += end.evaluations;
        arrived = sameness.holds(space, &end.x, end.energy, to);
    }
    barrier = barrier.max(to.energy);
    if arrived {
        // The descent may have led to another copy of the target than the chain set out for.
        space.log(&state.coordinates, &to.coordinates, &mut toward);
        let mut end = state.coordinates;
        space.exp(&mut end, &toward);
        kept.images.push(end);
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

/// Whether a chain without any pull is still in the minimum `from` after as many steps as its patience allows (a descent
/// decides), and the evaluations that took.
pub(super) fn stays(
    energy: &dyn Energy,
    kernel: &dyn Kernel,
    from: &Minimum,
    settings: &ChainSettings,
    (descent, sameness): (&QuenchSettings, &MatchTolerance),
    rng: &mut Rng,
) -> (bool, usize) {
    let law = TargetDensity {
        temperature: settings.temperature,
        attraction: None,
    };
    let mut walk = Walk::new(kernel, &from.coordinates, settings);
    while walk.steps < settings.patience {
        walk.advance(&law, rng);
    }
    let end = quench(energy, &walk.state.coordinates, descent);
    let stayed = sameness.holds(kernel.space(), &end.x, end.energy, from);
    (stayed, 1 + walk.steps + end.evaluations)
}

/// A chain on its way.
struct Walk<'a> {
    kernel: &'a dyn Kernel,
    state: State,
    proposal: State,
    step: f64,
    steered: bool,
    steps: usize,
}

impl<'a> Walk<'a> {
    fn new(kernel: &'a dyn Kernel, start: &[f64], settings: &ChainSettings) -> Self {
        Self {
            kernel,
            state: kernel.start(start),
            proposal: State::default(),
            step: settings.step,
            steered: settings.steered,
            steps: 0,
        }
    }

    /// One step; the highest energy on it, if the proposal was accepted.
    fn advance(&mut self, law: &TargetDensity<'_>, rng: &mut Rng) -> Option<f64> {
        self.steps += 1;
        let ratio = self
            .kernel
            .propose(&self.state, law, self.step, rng, &mut self.proposal);
        let accepted = rng.random::<f64>().ln() < ratio;
        // Fading steering (Robbins and Monro): early steps find the scale, late ones leave the law alone. Moves of the
        // discrete part have no length, and say nothing about it.
        if self.steered && self.proposal.coordinates != self.state.coordinates {
            let chance = ratio.exp().min(1.0);
            self.step *= ((chance - ACCEPTANCE) / (self.steps as f64).powf(0.6)).exp();
        }
        if !accepted {
            return None;
        }
        std::mem::swap(&mut self.state, &mut self.proposal);
        Some(self.top_of_step())
    }

    /// Highest energy between the state before, now in `proposal`, and the state.
    fn top_of_step(&self) -> f64 {
        let (before, here) = (&self.proposal, &self.state);
        let ends = before.energy.max(here.energy);
        if before.discrete != here.discrete || before.coordinates == here.coordinates {
            return ends;
        }
        // The way back is the negated tangent, so one tangent gives the slopes at both ends.
        let mut tangent = vec![0.0; here.gradient.len()];
        let space = self.kernel.space();
        space.log_near(&before.coordinates, &here.coordinates, &mut tangent);
        let slope = |state: &State| dot(&state.gradient, &tangent);
        cubic_top([before.energy, here.energy], [slope(before), slope(here)])
    }
}

/// Greatest value on [0, 1] of the cubic with these values and slopes at its ends.
fn cubic_top([start, end]: [f64; 2], [out, back]: [f64; 2]) -> f64 {
    let rise = end - start;
    let (square, cube) = (3.0 * rise - 2.0 * out - back, out + back - 2.0 * rise);
    let value = |t: f64| start + t * (out + t * (square + t * cube));
    // Roots of out + 2 square t + 3 cube t² without cancellation.
    let root = square.mul_add(square, -3.0 * cube * out).max(0.0).sqrt();
    let sum = -(square + root.copysign(square));
    [sum / (3.0 * cube), out / sum]
        .into_iter()
        .filter(|t| (0.0..=1.0).contains(t))
        .map(value)
        .fold(start.max(end), f64::max)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tops_of_cubics() {
        // 4 t (1 − t): slope 4 at 0, −4 at 1.
        assert!((cubic_top([0.0, 0.0], [4.0, -4.0]) - 1.0).abs() < 1e-12);
        // t (1 − t)²: top 4/27 at 1/3.
        assert!((cubic_top([0.0, 0.0], [1.0, 0.0]) - 4.0 / 27.0).abs() < 1e-12);
        // t² (1 − t): top 4/27 at 2/3.
        assert!((cubic_top([0.0, 0.0], [0.0, -1.0]) - 4.0 / 27.0).abs() < 1e-12);
        // Straight lines and valleys are highest at an end.
        assert!((cubic_top([1.0, 3.0], [2.0, 2.0]) - 3.0).abs() < 1e-12);
        assert!((cubic_top([1.0, 1.0], [-4.0, 4.0]) - 1.0).abs() < 1e-12);
        assert!((cubic_top([2.0, 2.0], [0.0, 0.0]) - 2.0).abs() < 1e-12);
    }
}
