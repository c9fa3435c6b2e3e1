//! Synthesis: descents, and observation of states.
#![cfg(feature = "grasp")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::sync::{Arc, LazyLock};

use landscape::energy::Energy;
use landscape::grasp::closing::capsule_touches;
use landscape::grasp::grip::GripShares;
use landscape::grasp::synthesis::{
    SynthesisSettings, Synthesized, synthesize, synthesize_observed,
};
use landscape::grasp::{EnergySettings, GraspEnergy, judge};
use landscape::hand::{Hand, LinkId, PosedHand};
use landscape::object::Object;
use landscape::optimize::QuenchSettings;
use landscape::sample::State;
use landscape::space::object_from_hand;

static HAND: LazyLock<Arc<Hand>> = LazyLock::new(|| Arc::new(Hand::human()));
static BALL: LazyLock<Arc<Object>> = LazyLock::new(|| Arc::new(Object::named("ball").unwrap()));
static BOTTLE: LazyLock<Arc<Object>> =
    LazyLock::new(|| Arc::new(Object::named("bottle_round").unwrap()));

fn energy(object: &Arc<Object>, settings: EnergySettings) -> GraspEnergy {
    GraspEnergy::new(HAND.clone(), object.clone(), settings).unwrap()
}

fn refine() -> QuenchSettings {
    QuenchSettings::default().with_gradient_tolerance(1e-2)
}

fn observed(
    energy: &GraspEnergy,
    settings: &SynthesisSettings,
    chain: u64,
) -> (Synthesized, Vec<(u32, State)>) {
    let mut seen = Vec::new();
    let end = synthesize_observed(energy, settings, &refine(), 1, chain, &mut |n, state| {
        seen.push((n, state.clone()));
    });
    (end, seen)
}

/// The first descent of a chain is that of a chain with a single one, a chain ends with the first grasp, and every descent
/// shows its start and its end.
#[test]
fn descents_end_with_the_first_grasp() {
    let energy = energy(&BALL, EnergySettings::default());
    let settings = |steps| SynthesisSettings {
        steps,
        ..SynthesisSettings::default()
    };
    let strict = |end: &Synthesized| judge(&energy, &end.refined).passes_strict();
    for chain in 0..4 {
        let one = synthesize(&energy, &settings(1), &refine(), 1, chain);
        let (best, seen) = observed(&energy, &settings(4), chain);
        assert_eq!((one.chain, one.steps), (chain, 1));
        assert_eq!(seen.len() as u64, 2 * best.steps);
        assert_eq!(
            object_from_hand(&seen[1].1.coordinates),
            object_from_hand(&one.raw.pose)
        );
        if best.steps < 4 {
            assert!(
                strict(&best),
                "chain {chain} gave up after {} descents",
                best.steps
            );
        }
    }
}

/// Chains end in minima that pass the strict filter with little compliance, and the same chain has the
/// same bits.
#[test]
fn closed_hands() {
    let energy = energy(&BALL, EnergySettings::default());
    let settings = SynthesisSettings::default();
    let refine = QuenchSettings::default().with_gradient_tolerance(1e-5);
    let ends: Vec<Synthesized> = (0..4)
        .map(|chain| synthesize(&energy, &settings, &refine, 7, chain))
        .collect();
    for end in &ends {
        let judgement = judge(&energy, &end.refined);
        assert_eq!(judgement.strict_objection(), None);
        assert!(judgement.compliance.unwrap() < 0.1);
        let mut gradient = vec![0.0; energy.space().tangents()];
        assert!((energy.evaluate(&end.refined.pose, &mut gradient) - end.energy).abs() < 1e-12);
        let steepest = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
        assert!(steepest < 1e-5, "{steepest}");
    }
    assert_eq!(ends[3], synthesize(&energy, &settings, &refine, 7, 3));
}

/// Chains whose grip is a pinch end in minima of the same energy in which palm and other fingers rest.
#[test]
fn a_pinch_is_a_minimum_beside_the_grasps_of_the_whole_hand() {
    let energy = energy(&BOTTLE, EnergySettings::default());
    let pinch = GripShares {
        whole: 0.0,
        digits: 0.0,
        quadpod: 0.0,
        tripod: 0.0,
        pinch: 1.0,
        tips: 0.0,
    };
    let settings = SynthesisSettings {
        grips: pinch,
        ..SynthesisSettings::default()
    };
    let refine = QuenchSettings::default().with_gradient_tolerance(1e-5);
    let mut pinches = 0;
    for chain in 0..6 {
        let end = synthesize(&energy, &settings, &refine, 11, chain);
        if !judge(&energy, &end.refined).passes_strict() {
            continue;
        }
        let mut posed = PosedHand::default();
        energy.hand().pose(&end.refined.pose, &mut posed);
        let touches = capsule_touches(&energy.object().exact, energy.hand(), &posed, 0.001);
        let digit = |link: LinkId| energy.hand().links[link.0].digit;
        let mut digits: Vec<usize> = touches.iter().map(|touch| digit(touch.link)).collect();
        digits.sort_unstable();
        digits.dedup();
        pinches += usize::from(digits == [1, 2]);
    }
    assert!(pinches >= 3, "{pinches} of 6");
}
