//! Basin hopping: descents from random displacements of the best end so far.

use crate::energy::Energy;
use crate::grasp::energy::GraspEnergy;
use crate::optimize::{QuenchSettings, quench};
use crate::sample::{Rng, State};

use super::start::displace;
use super::{End, Observe, SynthesisSettings};

/// Gradient at which a descent between hops ends, energy per metre, and its largest number of evaluations: enough to
/// compare two ends.
const ROUGH_TOLERANCE: f64 = 1e-3;
const ROUGH_EVALUATIONS: usize = 500;
/// Longest step of a descent, metres: no digit passes through a thin wall in one step.
const LONGEST_STEP_M: f64 = 0.02;

/// Descends from `state`, then `steps − 1` times from the lowest end so far after a random displacement of
/// [`hop_length_m`](SynthesisSettings::hop_length_m). An end replaces the one before if its energy is lower (basin hopping
/// at temperature zero; Wales and Doye 1997). The start is shown first, then the lowest end after each descent.
pub(super) fn hop(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    steps: u32,
    start: State,
    rng: &mut Rng,
    observe: Observe<'_>,
) -> End {
    let rough = QuenchSettings::default()
        .with_gradient_tolerance(ROUGH_TOLERANCE)
        .with_max_evaluations(ROUGH_EVALUATIONS)
        .with_max_step(LONGEST_STEP_M);
    let mut best = start;
    let mut unused = vec![0.0; energy.space().tangents()];
    best.energy = energy.evaluate(&best.coordinates, &mut unused);
    observe(0, &best);
    best.energy = f64::INFINITY;
    let mut evaluations = 1;
    for step in 0..steps.max(1) {
        let mut from = best.coordinates.clone();
        if let Some(length_m) = settings.hop_length_m.filter(|_| step > 0) {
            displace(energy.space(), &mut from, length_m, rng);
        }
        let end = quench(energy, &from, &rough);
        evaluations += end.evaluations as u64;
        if end.energy < best.energy {
            best = State {
                coordinates: end.x,
                energy: end.energy,
                ..State::default()
            };
        }
        observe(step + 1, &best);
    }
    best.discrete = energy.contacts(&best.coordinates);
    End {
        raw: best.clone(),
        refined: best,
        evaluations,
    }
}
