//! Grasp synthesis: one chain from start poses to a grasp.

mod settings;
mod start;
mod wish;

use serde::{Deserialize, Serialize};

pub use self::settings::{SynthesisSettings, SynthesisSettingsError};
pub use self::start::Given;
pub use self::wish::Wish;
use super::Grasp;
use super::energy::GraspEnergy;
use super::filter::passes_strict;
use crate::optimize::{self, QuenchSettings};
use crate::sample::{State, Task, stream};

/// The result of a chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Synthesized {
    /// Number of the chain, which selects its random stream.
    pub chain: u64,
    /// The end of the rough descent, before refinement.
    pub raw: Grasp,
    /// The minimum after refinement, with its contact set.
    pub refined: Grasp,
    /// E(H, O) of the refined grasp.
    pub energy: f64,
    /// Descents of the chain.
    pub steps: u64,
    /// Energy evaluations spent, including refinement.
    pub evaluations: u64,
}

/// Callback for the states of a chain, with the number of descents so far.
type Observe<'a> = &'a mut dyn FnMut(u32, &State);

/// Runs chain number `chain` with the given seed: descents from new starts, until one ends in a grasp.
///
/// Each descent closes the parts of a random grip first ([`GripShares`](super::grip::GripShares)). Chains are independent: the
/// result depends only on the energy, the settings, the seed and the number.
pub fn synthesize(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    refine: &QuenchSettings,
    seed: u64,
    chain: u64,
) -> Synthesized {
    synthesize_observed(energy, settings, refine, seed, chain, &mut |_, _| ())
}

/// Like [`synthesize`], but serves a wish: starts and parts that close are those of the wish, and the first end that passes the
/// strict filter and is what was asked for ends the chain. With a given grasp, descents start from there.
///
/// If no end is what was asked for, that of least energy counts, and [`Wish::grants`] says so.
///
/// # Panics
/// If the given pose or the wish belongs to another hand.
pub fn synthesize_towards(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    refine: &QuenchSettings,
    [seed, chain]: [u64; 2],
    given: Option<&Given<'_>>,
    wish: &dyn Wish,
) -> Synthesized {
    let asked = Asked {
        given,
        wish: Some(wish),
    };
    run(
        energy,
        settings,
        refine,
        [seed, chain],
        asked,
        &mut |_, _| (),
    )
}

/// Like [`synthesize`], but the descents start from a given grasp, each with a new random displacement. Without displacement
/// there is one descent.
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
    let asked = Asked {
        given: Some(given),
        wish: None,
    };
    run(
        energy,
        settings,
        refine,
        [seed, chain],
        asked,
        &mut |_, _| (),
    )
}

/// Like [`synthesize`], and shows `observe` the start and the end of every descent.
pub fn synthesize_observed(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    refine: &QuenchSettings,
    seed: u64,
    chain: u64,
    observe: &mut dyn FnMut(u32, &State),
) -> Synthesized {
    let asked = Asked::default();
    run(energy, settings, refine, [seed, chain], asked, observe)
}

/// Where a chain starts, and what it is to find.
#[derive(Clone, Copy, Default)]
struct Asked<'a> {
    given: Option<&'a Given<'a>>,
    wish: Option<&'a dyn Wish>,
}

impl Asked<'_> {
    fn grants(self, energy: &GraspEnergy, end: &Grasp) -> bool {
        self.wish.is_none_or(|wish| wish.grants(energy, &end.pose))
    }
}

fn run(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    refine: &QuenchSettings,
    [seed, chain]: [u64; 2],
    asked: Asked<'_>,
    observe: Observe<'_>,
) -> Synthesized {
    let Asked { given, wish } = asked;
    let mut rng = stream(seed, Task::Synthesis, chain);
    let mut guide = None;
    let mut best: Option<(Synthesized, bool)> = None;
    let (mut steps, mut evaluations) = (0, 0);
    let attempts = match given {
        // Without displacement all descents from the given grasp are the same.
        Some(given) if given.displacement_m == 0.0 => 1,
        _ => settings.steps.max(1),
    };
    let only = attempts == 1;
    for attempt in 0..attempts {
        let mut begun = None;
        if let Some(wish) = wish {
            let (start, parts) = wish.begin(energy, chain, attempt, &mut rng);
            guide = Some(energy.for_grip(&parts));
            begun = Some(start);
        } else if given.is_none() && attempt % ATTEMPTS_OF_A_GRIP == 0 {
            let grip = settings.grips.draw(energy.hand(), &mut rng);
            guide = Some(energy.for_grip(&grip.parts(energy.hand())));
        }
        let start = match (given, begun) {
            (Some(given), _) => start::given_start(energy, given, &mut rng),
            (None, Some(begun)) => begun,
            (None, None) => {
                evaluations += 1;
                start::start(energy, chain, &mut rng)
            }
        };
        evaluations += 1;
        let mut observe = |n, state: &State| observe(steps + n, state);
        let guiding = guide.as_ref().unwrap_or(energy);
        let end = descend_roughly(guiding, start, &mut observe);
        steps += 1;
        let missed =
            wish.is_none() && (guide.as_ref()).is_some_and(|guide| misses_grip(guide, &end.raw));
        if missed && best.is_some() {
            evaluations += end.evaluations;
            continue;
        }
        let (found, passes) = finish(energy, refine, end, only, asked);
        evaluations += found.evaluations;
        let done = passes && !missed && asked.grants(energy, &found.refined);
        // A grasp of another grip than the one asked for is kept until one of that grip is found.
        let is_better = |known: &(Synthesized, bool)| !known.1 && found.energy < known.0.energy;
        if done || best.as_ref().is_none_or(is_better) {
            best = Some((found, passes));
        }
        if done {
            break;
        }
    }
    let (mut best, passes) = best.expect("there is at least one attempt");
    best.evaluations = evaluations;
    if passes && !asked.grants(energy, &best.refined) {
        // It was left after the trial, since it is not what was asked for.
        descend(energy, refine, &mut best);
    }
    Synthesized {
        chain,
        steps: u64::from(steps),
        ..best
    }
}

/// Whether the parts of a grip alone do not hold. Then the hand may close to a grasp that was not asked for.
fn misses_grip(guide: &GraspEnergy, end: &Grasp) -> bool {
    guide.compliance(&end.pose) > MISSED_COMPLIANCE
}

/// End of a rough descent.
struct End {
    raw: Grasp,
    evaluations: u64,
}

/// Gradient at which a rough descent ends, energy per metre, and its largest number of evaluations: enough to tell whether the
/// parts of its grip hold.
const ROUGH_TOLERANCE: f64 = 1e-3;
const ROUGH_EVALUATIONS: usize = 500;
/// Longest step of this descent, metres: no digit passes through a thin wall in one step.
const LONGEST_STEP_M: f64 = 0.02;

fn descend_roughly(energy: &GraspEnergy, start: Vec<f64>, observe: Observe<'_>) -> End {
    let rough = QuenchSettings::default()
        .with_gradient_tolerance(ROUGH_TOLERANCE)
        .with_max_evaluations(ROUGH_EVALUATIONS)
        .with_max_step(LONGEST_STEP_M);
    let start = State {
        coordinates: start,
        ..State::default()
    };
    observe(0, &start);
    let end = optimize::quench(energy, &start.coordinates, &rough);
    let raw = State {
        coordinates: end.x,
        energy: end.energy,
        ..State::default()
    };
    observe(1, &raw);
    End {
        raw: Grasp::best(energy, raw.coordinates),
        evaluations: end.evaluations as u64,
    }
}

/// Settings of a descent that only tells whether an attempt found a grasp.
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

/// Refines the end of a rough descent and returns whether it passes the strict filter (not tested for the only attempt). Of
/// several attempts, one that fails after a trial is not refined further.
fn finish(
    energy: &GraspEnergy,
    refine: &QuenchSettings,
    end: End,
    only: bool,
    asked: Asked<'_>,
) -> (Synthesized, bool) {
    let mut found = Synthesized {
        chain: 0,
        refined: end.raw.clone(),
        raw: end.raw,
        energy: f64::NAN,
        steps: 0,
        evaluations: end.evaluations,
    };
    if !only {
        descend(energy, &trial_settings(refine), &mut found);
        if !is_grasp(energy, &found) {
            return (found, false);
        }
        if !asked.grants(energy, &found.refined) {
            return (found, true);
        }
    }
    descend(energy, refine, &mut found);
    let passes = !only && is_grasp(energy, &found);
    (found, passes)
}

/// Whether an end passes the strict filter. A hand that gives needs no judgement.
fn is_grasp(energy: &GraspEnergy, found: &Synthesized) -> bool {
    energy.withstands_loads(&found.refined.pose) && passes_strict(energy, &found.refined)
}

fn descend(energy: &GraspEnergy, settings: &QuenchSettings, found: &mut Synthesized) {
    let quench = optimize::quench(energy, &found.refined.pose, settings);
    found.evaluations += quench.evaluations as u64;
    found.refined = Grasp::best(energy, quench.x);
    found.energy = quench.energy;
}
