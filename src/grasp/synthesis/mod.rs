//! Grasp synthesis: one chain from a start pose to a grasp.

mod annealed;
mod released;
mod settings;
mod start;

use rand::RngExt;
use serde::{Deserialize, Serialize};

use self::annealed::{Schedule, anneal};
pub use self::settings::{
    ContactMoves, Refinement, Sampler, Start, SynthesisSettings, SynthesisSettingsError,
};
pub use self::start::Given;
use super::Grasp;
use super::closing::{ClosingSettings, close_hand, preload};
use super::energy::GraspEnergy;
use super::filter::passes_strict;
pub use super::kernel::StepScales;
use crate::energy::{Energy, Piecewise};
use crate::optimize::{self, QuenchSettings};
use crate::sample::{Rng, State, Task, stream};

/// The result of a chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Synthesized {
    /// Number of the chain, which selects its random stream.
    pub chain: u64,
    /// The end of the chain, before refinement.
    pub raw: Grasp,
    /// The grasp after refinement on the envelope, with its best contact set.
    pub refined: Grasp,
    /// E(H, O) of the refined grasp.
    pub energy: f64,
    /// Steps of the chain.
    pub steps: u64,
    /// Energy evaluations spent, including refinement.
    pub evaluations: u64,
}

/// Callback for every state of a chain, with the number of steps so far.
type Observe<'a> = &'a mut dyn FnMut(u32, &State);

/// Runs chain number `chain` with the given seed and refines its end.
///
/// Chains are independent: the result depends only on the energy, the settings, the seed and the number.
///
/// # Panics
/// If `settings` has no attempts.
pub fn synthesize(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    refine: &QuenchSettings,
    seed: u64,
    chain: u64,
) -> Synthesized {
    synthesize_observed(energy, settings, refine, seed, chain, &mut |_, _| ())
}

/// Like [`synthesize`], but the chain starts from a given grasp. Each attempt starts at the same pose with a new random
/// displacement, at most at [`SynthesisSettings::given_temperature`], and with full weights. With [`Sampler::Descent`] and
/// without displacement there is one attempt.
///
/// With other samplers, if the displacement is zero, a direct descent from the pose may replace the end of the chain. It does so if it alone
/// passes the strict filter, or if both or neither pass and its energy is lower. With [`Refinement::Pressed`] passing
/// includes preload. With other refinements than [`Refinement::Quench`] and this one, the end of the chain always counts.
///
/// # Panics
/// If the pose belongs to another hand.
pub fn synthesize_from(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    refine: &QuenchSettings,
    seed: u64,
    chain: u64,
    given: &Given<'_>,
) -> Synthesized {
    run(
        energy,
        settings,
        refine,
        [seed, chain],
        Some(given),
        &mut |_, _| (),
    )
}

/// Like [`synthesize`], and shows `observe` every state of the chain: the start as number 0, and the state after step n as
/// number n. A further attempt shows its start with the number of steps before it.
///
/// The energy of a state is the one that the chain uses. While the annealed sampler changes weights, it is E(H, x, O) with
/// the weights of that step ([`GraspEnergy::evaluate_ramped`]).
///
/// # Panics
/// If `settings` has no attempts.
pub fn synthesize_observed(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    refine: &QuenchSettings,
    seed: u64,
    chain: u64,
    observe: &mut dyn FnMut(u32, &State),
) -> Synthesized {
    run(energy, settings, refine, [seed, chain], None, observe)
}

fn run(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    refine: &QuenchSettings,
    [seed, chain]: [u64; 2],
    given: Option<&Given<'_>>,
    observe: Observe<'_>,
) -> Synthesized {
    let settings = &SynthesisSettings {
        ramp_depths: settings.ramp_depths && energy.object().thin_share < MOSTLY_THIN,
        ..*settings
    };
    let mut rng = stream(seed, Task::Synthesis, chain);
    let mut guide = None;
    let mut best: Option<(Synthesized, bool)> = None;
    let (mut steps, mut evaluations) = (0, 0);
    let steps_or_one = settings.steps.max(1);
    let attempts = match settings.sampler {
        // Without displacement all descents from the given grasp are the same.
        Sampler::Descent if given.is_some_and(|given| given.displacement_m == 0.0) => 1,
        Sampler::Descent => steps_or_one,
        Sampler::Annealed | Sampler::Released => settings.attempts.min(steps_or_one),
    };
    let only = attempts == 1;
    for attempt in 0..attempts {
        // Divides the steps as evenly as possible.
        let share = match settings.sampler {
            Sampler::Descent => 1,
            _ => settings.steps / attempts + u32::from(attempt < settings.steps % attempts),
        };
        if attempt % ATTEMPTS_OF_A_GRIP == 0
            && let Some(grips) = settings.grips.filter(|_| given.is_none())
        {
            guide = energy.for_grip(grips.draw(energy.hand(), &mut rng));
        }
        let (start, schedule) = match given {
            None => {
                evaluations += u64::from(settings.start_candidates);
                let start = start::start(energy, settings, chain, &mut rng);
                (start, Schedule::new(settings, share))
            }
            Some(given) => {
                let start = start::given_start(energy, given, &mut rng);
                (start, Schedule::from_given(settings, share))
            }
        };
        evaluations += u64::from(share);
        let end = walk(
            guide.as_ref().unwrap_or(energy),
            settings,
            &schedule,
            start,
            &mut rng,
            &mut |n, state| {
                observe(steps + n, state);
            },
        );
        steps += share;
        let missed = (guide.as_ref()).is_some_and(|guide| misses_grip(guide, &end.raw));
        if missed && best.is_some() {
            evaluations += end.evaluations;
        } else {
            let (found, passes) = finish(energy, settings, refine, end, only);
            evaluations += found.evaluations;
            let done = passes && !missed;
            let is_better = |known: &(Synthesized, bool)| !known.1 && found.energy < known.0.energy;
            if done || best.as_ref().is_none_or(is_better) {
                best = Some((found, passes));
            }
            if done {
                break;
            }
        }
    }
    let (mut best, _) = best.expect("there is at least one attempt");
    if let Some(given) = given.filter(|given| given.displacement_m == 0.0)
        && settings.sampler != Sampler::Descent
        && matches!(
            settings.refinement,
            Refinement::Quench | Refinement::Pressed
        )
    {
        let pressed = settings.refinement == Refinement::Pressed;
        let mut refined = refine_given(energy, refine, given);
        if pressed {
            close(energy, &mut refined);
        }
        evaluations += refined.evaluations;
        let rank = |end: &Synthesized| !is_grasp(energy, settings.refinement, end);
        let order = rank(&refined).cmp(&rank(&best));
        if order.then(refined.energy.total_cmp(&best.energy)).is_lt() {
            best = refined;
        }
    }
    Synthesized {
        chain,
        steps: u64::from(steps),
        evaluations,
        ..best
    }
}

/// Whether the parts of a grip alone do not hold. Then the hand may close to a grasp that was not asked for.
fn misses_grip(guide: &GraspEnergy, end: &State) -> bool {
    let compliance = guide.compliance(&end.coordinates);
    compliance.is_some_and(|compliance| compliance > MISSED_COMPLIANCE)
}

fn refine_given(energy: &GraspEnergy, refine: &QuenchSettings, given: &Given<'_>) -> Synthesized {
    let start = Grasp::best(energy, given.x.to_vec());
    let mut found = Synthesized {
        chain: 0,
        raw: start.clone(),
        refined: start,
        energy: f64::NAN,
        steps: 0,
        evaluations: 0,
    };
    descend(energy, refine, &mut found);
    found
}

/// End of a walk: its last state, and the refined one if the sampler refines by itself.
struct End {
    raw: State,
    refined: State,
    evaluations: u64,
}

fn walk(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    schedule: &Schedule,
    start: State,
    rng: &mut Rng,
    observe: Observe<'_>,
) -> End {
    match settings.sampler {
        Sampler::Annealed => {
            let raw = anneal(energy, settings, schedule, start, rng, observe);
            End {
                refined: raw.clone(),
                raw,
                evaluations: 0,
            }
        }
        Sampler::Descent => descend_roughly(energy, &start, observe),
        Sampler::Released => {
            let mut chain = released::Chain::new(energy, start);
            chain.run(settings, schedule.steps, rng, observe);
            let raw = chain.state().clone();
            let mut evaluations = 0;
            if settings.refinement == Refinement::Noisy {
                evaluations = u64::from(chain.refine(rng));
            }
            End {
                raw,
                refined: chain.state().clone(),
                evaluations,
            }
        }
    }
}

/// Gradient at which the descent of a chain ends, energy per metre, and its largest number of evaluations: enough to tell
/// whether the parts of its grip hold.
const ROUGH_TOLERANCE: f64 = 1e-3;
const ROUGH_EVALUATIONS: usize = 500;
/// Longest step of this descent, metres: no digit passes through a thin wall in one step.
const LONGEST_STEP_M: f64 = 0.02;

fn descend_roughly(energy: &GraspEnergy, start: &State, observe: Observe<'_>) -> End {
    let rough = QuenchSettings::default()
        .with_gradient_tolerance(ROUGH_TOLERANCE)
        .with_max_evaluations(ROUGH_EVALUATIONS)
        .with_max_step(LONGEST_STEP_M);
    observe(0, start);
    let end = optimize::quench(energy, &start.coordinates, &rough);
    let raw = State {
        discrete: energy.contacts(&end.x),
        coordinates: end.x,
        energy: end.energy,
        ..State::default()
    };
    observe(1, &raw);
    End {
        refined: raw.clone(),
        raw,
        evaluations: end.evaluations as u64,
    }
}

/// Fraction of thin walls above which depth weights are never reduced, since a hand in a wall stays there.
const MOSTLY_THIN: f64 = 0.5;

/// Settings of a rough descent that only tells whether an attempt found a grasp.
fn trial_settings(refine: &QuenchSettings) -> QuenchSettings {
    refine
        .clone()
        .with_gradient_tolerance(TRIAL_TOLERANCE.max(refine.gradient_tolerance))
        .with_max_evaluations(TRIAL_EVALUATIONS.min(refine.max_evaluations))
}

/// Compliance above which the parts of a grip have let go and the attempt has failed. It is far above that of a hand that
/// holds, since the descent on the energy itself still presses the pads on: with the bound of the strict filter in its place,
/// nearly all pinches count as missed.
const MISSED_COMPLIANCE: f64 = 0.4;

/// Attempts at a grip before another one is drawn: some grips hold nowhere on an object, or not with this hand.
const ATTEMPTS_OF_A_GRIP: u32 = 3;

/// Energy per metre. Over the last millimetres this is far less than the differences between grasps.
const TRIAL_TOLERANCE: f64 = 1e-2;
const TRIAL_EVALUATIONS: usize = 300;

/// Refines the end of a walk and returns whether it passes the strict filter (not tested for the only attempt). Of several
/// attempts, one that fails after a rough descent is not refined further.
fn finish(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    refine: &QuenchSettings,
    end: End,
    only: bool,
) -> (Synthesized, bool) {
    let grasp = |state: State| Grasp::new(state.coordinates, state.discrete);
    let mut found = Synthesized {
        chain: 0,
        raw: grasp(end.raw),
        refined: grasp(end.refined),
        energy: f64::NAN,
        steps: 0,
        evaluations: end.evaluations,
    };
    let passes = |found: &Synthesized| !only && is_grasp(energy, settings.refinement, found);
    match settings.refinement {
        Refinement::Quench => {
            if !only {
                descend(energy, &trial_settings(refine), &mut found);
                if !passes(&found) {
                    return (found, false);
                }
            }
            descend(energy, refine, &mut found);
        }
        Refinement::Pressed => {
            // Pressing moves the hand farther than the last digits of a descent.
            descend(energy, &trial_settings(refine), &mut found);
            if !only && !is_grasp(energy, Refinement::Quench, &found) {
                return (found, false);
            }
            close(energy, &mut found);
        }
        Refinement::Held => {
            let held = &found.refined.contacts;
            let quench = optimize::quench_piece(energy, held, &found.refined.pose, refine);
            found.evaluations += quench.evaluations as u64;
            found.refined.pose = quench.x.into();
            found.energy = quench.energy;
        }
        Refinement::Noisy | Refinement::None => {
            found.energy = energy_of(energy, &found.refined);
        }
    }
    let passes = passes(&found);
    (found, passes)
}

/// Whether an end passes the strict filter and, if hands are pressed, is firm.
fn is_grasp(energy: &GraspEnergy, refinement: Refinement, found: &Synthesized) -> bool {
    // A hand that gives needs no judgement.
    energy.withstands_loads(&found.refined.pose) != Some(false)
        && passes_strict(energy, &found.refined)
        && (refinement != Refinement::Pressed
            || preload(energy, &found.refined.pose).is_sufficient())
}

fn close(energy: &GraspEnergy, found: &mut Synthesized) {
    let settings = ClosingSettings::default();
    let pose = close_hand(energy, &found.refined, &settings);
    found.refined = Grasp::best(energy, pose);
    found.energy = energy_of(energy, &found.refined);
    found.evaluations += 1;
}

/// The energy for the contact set of the grasp.
fn energy_of(energy: &GraspEnergy, grasp: &Grasp) -> f64 {
    let mut unused = vec![0.0; energy.space().tangents()];
    energy.evaluate_piece(&grasp.pose, &grasp.contacts, &mut unused)
}

fn descend(energy: &GraspEnergy, settings: &QuenchSettings, found: &mut Synthesized) {
    let quench = optimize::quench(energy, &found.refined.pose, settings);
    found.evaluations += quench.evaluations as u64;
    found.refined = Grasp::best(energy, quench.x);
    found.energy = quench.energy;
}

/// Metropolis: replaces `state` by `proposal` with probability min(1, eʳ).
fn accept(state: &mut State, proposal: &mut State, log_ratio: f64, rng: &mut Rng) -> bool {
    let accepted = libm::log(rng.random::<f64>()) < log_ratio;
    if accepted {
        std::mem::swap(state, proposal);
    }
    accepted
}
