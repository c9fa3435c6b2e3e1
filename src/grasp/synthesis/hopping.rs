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
/// Difference of energy below which two ends count as one.
const SAME_ENERGY: f64 = 1e-4;
/// Longest step of a descent, metres: no digit passes through a thin wall in one step.
const LONGEST_STEP_M: f64 = 0.02;

/// Descends from `state`, then `steps − 1` times from the lowest end so far after a random displacement of
/// [`hop_length_m`](SynthesisSettings::hop_length_m). An end replaces the one before if its energy is lower (basin hopping
/// at temperature zero; Wales and Doye 1997). The start is shown first, then the lowest end after each descent. With `all`
/// the other ends count as well, if they differ in energy.
pub(super) fn hop(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    steps: u32,
    start: State,
    all: bool,
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
    let mut others = Vec::new();
    for step in 0..steps.max(1) {
        let mut from = best.coordinates.clone();
        if let Some(length_m) = settings.hop_length_m.filter(|_| step > 0) {
            displace(energy.space(), &mut from, length_m, rng);
        }
        let end = quench(energy, &from, &rough);
        evaluations += end.evaluations as u64;
        let mut end = State {
            coordinates: end.x,
            energy: end.energy,
            ..State::default()
        };
        if end.energy < best.energy {
            std::mem::swap(&mut end, &mut best);
        }
        others.push(end);
        observe(step + 1, &best);
    }
    best.discrete = energy.contacts(&best.coordinates);
    others.retain(|end| all && end.energy > best.energy + SAME_ENERGY && end.energy.is_finite());
    others.sort_by(|a, b| a.energy.total_cmp(&b.energy));
    others.dedup_by(|higher, lower| higher.energy <= lower.energy + SAME_ENERGY);
    for end in &mut others {
        end.discrete = energy.contacts(&end.coordinates);
    }
    End {
        raw: best.clone(),
        refined: best,
        others,
        evaluations,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::grasp::EnergySettings;
    use crate::grasp::synthesis::start::start;
    use crate::hand::Hand;
    use crate::object::Object;
    use crate::sample::{Task, stream};

    #[test]
    fn other_ends_are_higher_and_apart() {
        let hand = Arc::new(Hand::named("gripper_three_finger").unwrap());
        let object = Arc::new(Object::named("box").unwrap());
        let energy = GraspEnergy::new(hand, object, EnergySettings::closed()).unwrap();
        let settings = SynthesisSettings::closed();
        let hopped = |all| {
            let mut rng = stream(3, Task::Synthesis, 1);
            let from = start(&energy, &settings, 1, &mut rng);
            hop(&energy, &settings, 5, from, all, &mut rng, &mut |_, _| ())
        };
        let lowest_alone = hopped(false);
        assert!(lowest_alone.others.is_empty());
        let end = hopped(true);
        assert_eq!(end.refined, lowest_alone.refined);
        assert_eq!(end.evaluations, lowest_alone.evaluations);
        assert!(!end.others.is_empty() && end.others.len() < 5);
        let mut last = end.refined.energy;
        for other in &end.others {
            assert!(other.energy > last + SAME_ENERGY);
            assert!(!other.discrete.is_empty());
            last = other.energy;
        }
    }
}
