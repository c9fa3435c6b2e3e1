//! Attraction–diffusion: a chain is attracted from one minimum to another. Its highest energy bounds the barrier.
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

/// Target acceptance rate of the step-length adaptation: optimal for Langevin moves (Roberts and Rosenthal, 1998).
const ACCEPTANCE: f64 = 0.574;

/// Settings of [`chain`]. [`ChainSettings::for_scales`] sets all that have units from one energy and one length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ChainSettings {
    /// Temperature T. A tenth of the typical barrier explores; half of it melts the landscape.
    pub temperature: f64,
    /// Attracting force F = αT, energy per length. It must exceed the steepest slope on the way. The α of the altered
    /// distribution exp(−(E/T + α d)) is [`ChainSettings::alpha`].
    pub force: f64,
    /// Factor on the force after a failure.
    pub escalation: f64,
    /// Number of forces tried before a direction counts as not reached.
    pub attempts: usize,
    /// Number of independent chains in each direction.
    pub replicas: usize,
    /// Length ε of the first step. Unlike the published one, it adapts to the target acceptance rate.
    pub step: f64,
    /// Distance δ from the target at which the chain is quenched to test whether it has arrived.
    pub arrival: f64,
    /// M: the chain stops after this many consecutive steps without a new least distance.
    pub patience: usize,
    /// Greatest number of steps of a chain.
    pub max_steps: usize,
    /// Least distance between two stored points of the path. Smaller loops are cut off.
    pub spacing: f64,
}

impl Default for ChainSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl ChainSettings {
    /// Settings for a surface with typical barriers of height `energy` and minima about `length` apart.
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

    /// α = F/T of the published distribution exp(−(E/T + α d)), per length.
    pub fn alpha(&self) -> f64 {
        self.force / self.temperature
    }
}

/// Outcome of one chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// Whether it reached the target's own minimum.
    pub arrived: bool,
    /// Highest energy met (without the attraction), an upper bound of the barrier if the chain arrived. Between two states
    /// the energy is taken from the cubic through their values and slopes, so that a step across a ridge is not mistaken
    /// for a pass below it. The bound holds up to the fourth power of the step length.
    pub barrier: f64,
    /// The stored points of the path from start to target, with energies.
    pub path: Path,
    /// Steps made.
    pub steps: usize,
    /// Evaluations spent, including quenches.
    pub evaluations: usize,
}

/// Runs one chain from the minimum `from` toward the minimum `to` with the attracting `force`.
///
/// The chain samples exp(−(E + F d(x, x*))/T). It ends when it is within δ of the target and a descent from there ends in
/// that minimum (otherwise δ is halved); or when M consecutive steps bring no new least distance (a last descent then
/// decides); or when its highest energy exceeds `bound`.
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
    // The copy of the target that the chain starts toward.
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
        // In many dimensions the thermal cloud around the target is wider than δ, so a descent decides.
        let end = quench(energy, &state.coordinates, descent);
        quenching += end.evaluations;
        arrived = sameness.holds(space, &end.x, end.energy, to);
    }
    barrier = barrier.max(to.energy);
    if arrived {
        // The descent may have led to another copy of the target.
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

/// Whether a free chain is still in the minimum `from` when its patience ends (by a descent), and the evaluations spent.
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

/// Walks freely from the minimum `from` until a descent ends in another one. A descent is made whenever the patience has
/// passed, `rounds` times at most. Returns that minimum, the points of the way, and the evaluations spent.
pub(super) fn leave(
    energy: &dyn Energy,
    kernel: &dyn Kernel,
    from: &Minimum,
    settings: &ChainSettings,
    rounds: usize,
    (descent, sameness): (&QuenchSettings, &MatchTolerance),
    rng: &mut Rng,
) -> (Option<(Minimum, Path)>, usize) {
    let law = TargetDensity {
        temperature: settings.temperature,
        attraction: None,
    };
    let mut walk = Walk::new(kernel, &from.coordinates, settings);
    let mut kept = Path {
        images: vec![from.coordinates.clone()],
        energies: vec![from.energy],
    };
    let mut quenching = 0;
    for round in 1..=rounds {
        while walk.steps < round * settings.patience {
            if walk.advance(&law, rng).is_some() {
                keep(&mut kept, &walk.state, energy, settings.spacing);
            }
        }
        let end = quench(energy, &walk.state.coordinates, descent);
        quenching += end.evaluations;
        if !sameness.holds(kernel.space(), &end.x, end.energy, from) {
            let reached = Minimum::bare(end.x, end.energy);
            return (Some((reached, kept)), 1 + walk.steps + quenching);
        }
    }
    (None, 1 + walk.steps + quenching)
}

struct Walk<'a> {
    kernel: &'a dyn Kernel,
    state: State,
    proposal: State,
    step: f64,
    steps: usize,
}

impl<'a> Walk<'a> {
    fn new(kernel: &'a dyn Kernel, start: &[f64], settings: &ChainSettings) -> Self {
        Self {
            kernel,
            state: kernel.start(start),
            proposal: State::default(),
            step: settings.step,
            steps: 0,
        }
    }

    /// Makes one step. Returns its highest energy if the proposal was accepted.
    fn advance(&mut self, law: &TargetDensity<'_>, rng: &mut Rng) -> Option<f64> {
        self.steps += 1;
        let ratio = self
            .kernel
            .propose(&self.state, law, self.step, rng, &mut self.proposal);
        let accepted = libm::log(rng.random::<f64>()) < ratio;
        // The adaptation fades (Robbins and Monro): early steps find the scale, and late ones hardly change the
        // distribution. Steps that rest have no length, so they are excluded.
        if self.proposal.coordinates != self.state.coordinates {
            let chance = libm::exp(ratio).min(1.0);
            self.step *= libm::exp((chance - ACCEPTANCE) / libm::pow(self.steps as f64, 0.6));
        }
        if !accepted {
            return None;
        }
        std::mem::swap(&mut self.state, &mut self.proposal);
        Some(self.top_of_step())
    }

    /// Highest energy between the previous state, now in `proposal`, and the current one.
    fn top_of_step(&self) -> f64 {
        let (before, here) = (&self.proposal, &self.state);
        let ends = before.energy.max(here.energy);
        if before.coordinates == here.coordinates {
            return ends;
        }
        // One tangent gives the slopes at both ends, because the way back is its negative.
        let mut tangent = vec![0.0; here.gradient.len()];
        let space = self.kernel.space();
        space.log_near(&before.coordinates, &here.coordinates, &mut tangent);
        let slope = |state: &State| dot(&state.gradient, &tangent);
        cubic_top([before.energy, here.energy], [slope(before), slope(here)])
    }
}

/// Maximum on [0, 1] of the cubic with the given values and slopes at its ends.
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

/// Appends the state if it is far enough from the last stored point. A loop back to an earlier point is cut off.
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
        // t (1 − t)²: maximum 4/27 at 1/3.
        assert!((cubic_top([0.0, 0.0], [1.0, 0.0]) - 4.0 / 27.0).abs() < 1e-12);
        // t² (1 − t): maximum 4/27 at 2/3.
        assert!((cubic_top([0.0, 0.0], [0.0, -1.0]) - 4.0 / 27.0).abs() < 1e-12);
        // Straight lines and valleys have their maximum at an end.
        assert!((cubic_top([1.0, 3.0], [2.0, 2.0]) - 3.0).abs() < 1e-12);
        assert!((cubic_top([1.0, 1.0], [-4.0, 4.0]) - 1.0).abs() < 1e-12);
        assert!((cubic_top([2.0, 2.0], [0.0, 0.0]) - 2.0).abs() < 1e-12);
    }
}
