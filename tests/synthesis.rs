//! Synthesis: starts, attempts, refinements, and observation of states.
#![cfg(feature = "grasp")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::sync::{Arc, LazyLock};

use landscape::energy::{Energy, Piecewise};
use landscape::grasp::closing::capsule_touches;
use landscape::grasp::energy::{Candidates, Ramp};
use landscape::grasp::grip::GripShares;
use landscape::grasp::synthesis::{
    Refinement, Start, SynthesisSettings, Synthesized, synthesize, synthesize_observed,
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

/// The first of several attempts equals a single attempt, and a chain makes further attempts only while it has no
/// grasp.
#[test]
fn attempts_end_with_the_first_grasp() {
    let energy = energy(&BALL, EnergySettings::four_points());
    let one = SynthesisSettings {
        steps: 300,
        attempts: 1,
        start_candidates: 30,
        ..SynthesisSettings::four_points()
    };
    let four = SynthesisSettings {
        steps: 1200,
        attempts: 4,
        ..one
    };
    let strict = |end: &Synthesized| judge(&energy, &end.refined).passes_strict();
    let (mut ended_early, mut helped) = (0, 0);
    for chain in 0..24 {
        let first = synthesize(&energy, &one, &refine(), 1, chain);
        let best = synthesize(&energy, &four, &refine(), 1, chain);
        assert_eq!((first.chain, best.chain), (chain, chain));
        assert!(best.steps >= 300 && best.steps <= 1200 && best.steps.is_multiple_of(300));
        if best.steps == 300 {
            assert_eq!(first.raw, best.raw);
            ended_early += 1;
        }
        if best.steps < 1200 {
            assert!(
                strict(&best),
                "chain {chain} gave up after {} steps",
                best.steps
            );
        }
        helped += u32::from(strict(&best) && !strict(&first));
        assert_eq!(best, synthesize(&energy, &four, &refine(), 1, chain));
    }
    assert!(ended_early > 0 && helped > 0, "{ended_early} {helped}");
}

/// Step numbers run from the start to the end of each attempt without a gap, and the last state is the raw end.
#[test]
fn a_watcher_sees_every_state() {
    let energy = energy(&BALL, EnergySettings::four_points());
    for settings in [
        SynthesisSettings {
            steps: 300,
            attempts: 1,
            ..SynthesisSettings::four_points()
        },
        SynthesisSettings {
            steps: 300,
            ..SynthesisSettings::released()
        },
    ] {
        let (end, seen) = observed(&energy, &settings, 3);
        let numbers: Vec<u32> = seen.iter().map(|(n, _)| *n).collect();
        assert_eq!(numbers, (0..=300).collect::<Vec<u32>>());
        let (_, last) = seen.last().unwrap();
        assert_eq!(
            (&last.coordinates[..], &last.discrete),
            (&end.raw.pose[..], &end.raw.contacts)
        );
        let distance = energy
            .space()
            .distance(&seen[0].1.coordinates, &last.coordinates);
        assert!(distance > 1e-4, "the chain moved by {distance} m");
    }
}

/// Even starts face the surface points one after the other. Chosen starts have a better score than others at the same
/// point.
#[test]
fn starts_are_even_and_chosen() {
    let energy = energy(&BOTTLE, EnergySettings::four_points());
    let settings = |start_candidates| SynthesisSettings {
        steps: 1,
        attempts: 1,
        start_candidates,
        refinement: Refinement::None,
        ..SynthesisSettings::four_points()
    };
    let ramp = Ramp {
        distance: 0.02,
        depth: 0.02,
    };
    let (mut chosen, mut any) = (0.0, 0.0);
    let (mut off_by_m, mut tilts_rad) = (Vec::new(), Vec::new());
    for chain in 0..20 {
        let faced = BOTTLE.surface_samples[usize::try_from(chain).unwrap()];
        for candidates in [1, 50] {
            let (_, seen) = observed(&energy, &settings(candidates), chain);
            let x = &seen[0].1.coordinates;
            let palm = object_from_hand(x) * nalgebra::Point3::from(HAND.palm.centre);
            // The palm's centre lies 35 mm proximal of a point that is up to 40 mm off the faced one. The normal tilt decides
            // how the two lengths add up.
            let off_m = (palm.coords - faced.point).norm();
            assert!(
                off_m < 0.075,
                "chain {chain}: palm {off_m} m from its point"
            );
            off_by_m.push(off_m);
            let volar = object_from_hand(x) * HAND.palm.volar;
            tilts_rad.push(volar.angle(&-faced.normal));
            let promise = energy.start_score(x, ramp).0;
            *(if candidates == 1 {
                &mut any
            } else {
                &mut chosen
            }) += promise / 20.0;
        }
    }
    assert!(chosen < 0.5 * any, "{chosen} against {any}");
    off_by_m.sort_by(f64::total_cmp);
    tilts_rad.sort_by(f64::total_cmp);
    // Two normal angles of 0.35 rad have a median of 0.41 rad; random palms have a quarter of a turn.
    assert!(tilts_rad[20] < 0.6, "median tilt {} rad", tilts_rad[20]);
    // Without tilt, the distance is at most the root of the sum of the squares.
    assert!(off_by_m[20] < 0.053, "median {} m", off_by_m[20]);
}

/// The refinement of the authors' code is a walk at temperature 0.001 that never changes the contact set.
#[test]
fn the_noisy_refinement_cools_and_keeps_the_contacts() {
    let energy = energy(&BALL, EnergySettings::released());
    let settings = SynthesisSettings {
        steps: 200,
        ..SynthesisSettings::released()
    };
    for chain in 0..3 {
        let end = synthesize(&energy, &settings, &refine(), 1, chain);
        assert_eq!(end.refined.contacts, end.raw.contacts);
        assert_eq!(end.evaluations, 1 + 200 + 1000);
        let mut unused = vec![0.0; energy.space().tangents()];
        let before = energy.evaluate_piece(&end.raw.pose, &end.raw.contacts, &mut unused);
        assert!(end.energy < before, "{before} to {}", end.energy);
    }
    // Their start: about the object's centroid, in units of 120 mm, and turned anyhow.
    let (_, seen) = observed(
        &energy,
        &SynthesisSettings {
            start: Start::Gaussian,
            ..settings
        },
        0,
    );
    let offset = object_from_hand(&seen[0].1.coordinates).translation.vector - BALL.centroid;
    assert!(offset.norm() > 0.01 && offset.norm() < 0.6);
}

/// The refinement that the paper describes is a descent with a fixed contact set.
#[test]
fn the_refinement_of_the_paper_keeps_the_contacts() {
    let energy = energy(&BALL, EnergySettings::paper());
    let settings = SynthesisSettings {
        steps: 200,
        ..SynthesisSettings::paper()
    };
    for chain in 0..3 {
        let end = synthesize(&energy, &settings, &refine(), 1, chain);
        assert_eq!(end.refined.contacts, end.raw.contacts);
        let mut unused = vec![0.0; energy.space().tangents()];
        let before = energy.evaluate_piece(&end.raw.pose, &end.raw.contacts, &mut unused);
        let after = energy.evaluate_piece(&end.refined.pose, &end.refined.contacts, &mut unused);
        assert_eq!(after.to_bits(), end.energy.to_bits());
        assert!(after < before - 0.01, "{before} to {after}");
    }
}

/// If only fingertips are candidates, nothing else becomes a contact, neither in the chain nor in the envelope.
#[test]
fn contacts_can_be_restricted_to_fingertips() {
    let settings = EnergySettings {
        candidates: Candidates::Fingertips,
        ..EnergySettings::four_points()
    };
    let energy = energy(&BALL, settings);
    let tips = energy.contact_candidates();
    let shares = tips.len() as f64 / HAND.surface.len() as f64;
    assert!((0.05..0.3).contains(&shares), "{shares}");
    let digits = |set: &[u32]| -> Vec<usize> {
        let mut digits: Vec<usize> = set
            .iter()
            .map(|&i| HAND.links[HAND.surface[i as usize].link.0].digit)
            .collect();
        digits.sort_unstable();
        digits.dedup();
        digits
    };
    assert_eq!(digits(tips), [1, 2, 3, 4, 5]);
    let chain = SynthesisSettings {
        steps: 100,
        attempts: 1,
        ..SynthesisSettings::four_points()
    };
    let (end, seen) = observed(&energy, &chain, 0);
    let sets = seen
        .iter()
        .map(|(_, state)| &state.discrete)
        .chain([&end.refined.contacts]);
    for set in sets {
        assert!(set.iter().all(|index| tips.contains(index)), "{set:?}");
    }
    let few = EnergySettings {
        contacts: 8,
        ..settings
    };
    assert!(GraspEnergy::new(Arc::new(HAND.thinned(40)), BALL.clone(), few).is_err());
}

/// The preset `closed`: chains end in minima that pass the strict filter with little compliance, and the same chain has the
/// same bits.
#[test]
fn closed_hands() {
    let energy = energy(&BALL, EnergySettings::closed());
    let settings = SynthesisSettings::closed();
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
    let energy = energy(&BOTTLE, EnergySettings::closed());
    let pinch = GripShares {
        whole: 0.0,
        digits: 0.0,
        quadpod: 0.0,
        tripod: 0.0,
        pinch: 1.0,
        tips: 0.0,
    };
    let settings = SynthesisSettings {
        grips: Some(pinch),
        ..SynthesisSettings::closed()
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
