//! The grasp energy: the gradient of every term, the exact envelope compared with brute force, and independence of history.
#![cfg(feature = "grasp")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::sync::{Arc, LazyLock};

use landscape::energy::{Energy, Piecewise};
use landscape::grasp::closure::net_wrench;
use landscape::grasp::energy::Ramp;
use landscape::grasp::layer::LayerSettings;
use landscape::grasp::start::start_pose;
use landscape::grasp::term::{NormForm, PriorForm, RankForm};
use landscape::grasp::{EnergySettings, GraspEnergy};
use landscape::hand::{Hand, PosedHand};
use landscape::object::Object;
use landscape::sample::{Rng, Task, stream};
use landscape::space::Space;
use rand::RngExt;

pub(super) static HAND: LazyLock<Arc<Hand>> = LazyLock::new(|| Arc::new(Hand::human()));
pub(super) static BOTTLE: LazyLock<Arc<Object>> =
    LazyLock::new(|| Arc::new(Object::named("bottle_round").unwrap()));
pub(super) static BALL: LazyLock<Arc<Object>> =
    LazyLock::new(|| Arc::new(Object::named("ball").unwrap()));

/// A hand of boxes and cylinders.
pub(super) static GRIPPER: LazyLock<Arc<Hand>> =
    LazyLock::new(|| Arc::new(Hand::named("gripper_three_finger").unwrap()));

fn none() -> EnergySettings {
    EnergySettings {
        force_closure_weight: 0.0,
        rank_weight: 0.0,
        distance_weight: 0.0,
        alignment_weight: 0.0,
        penetration_weight: 0.0,
        intrusion_weight: 0.0,
        self_penetration_weight: 0.0,
        joint_limits_weight: 0.0,
        prior_weight: 0.0,
        ..EnergySettings::four_points()
    }
}

#[expect(clippy::too_many_lines, reason = "a list")]
/// Every term alone, and the presets. A new term needs one line here.
fn cases() -> Vec<(&'static str, EnergySettings)> {
    vec![
        ("default", EnergySettings::four_points()),
        ("paper", EnergySettings::paper()),
        ("released", EnergySettings::released()),
        (
            "force closure",
            EnergySettings {
                force_closure_weight: 1.0,
                ..none()
            },
        ),
        (
            "force closure, squared",
            EnergySettings {
                force_closure_weight: 1.0,
                force_closure_form: NormForm::Square,
                ..none()
            },
        ),
        (
            "rank over all eigenvalues",
            EnergySettings {
                rank_weight: 1.0,
                rank_form: RankForm::Sum,
                rank_epsilon: 2.0,
                ..none()
            },
        ),
        (
            "distance, squared",
            EnergySettings {
                distance_weight: 1.0,
                distance_form: NormForm::Square,
                ..none()
            },
        ),
        (
            "alignment",
            EnergySettings {
                alignment_weight: 1.0,
                ..none()
            },
        ),
        (
            "prior of the single joints",
            EnergySettings {
                prior_weight: 1.0,
                prior_form: PriorForm::StandardScores,
                ..none()
            },
        ),
        (
            "rank",
            EnergySettings {
                rank_weight: 1.0,
                rank_epsilon: 2.0,
                ..none()
            },
        ),
        (
            "distance",
            EnergySettings {
                distance_weight: 1.0,
                ..none()
            },
        ),
        (
            "penetration",
            EnergySettings {
                penetration_weight: 1.0,
                ..none()
            },
        ),
        (
            "intrusion",
            EnergySettings {
                intrusion_weight: 1.0,
                ..none()
            },
        ),
        (
            "self-penetration",
            EnergySettings {
                self_penetration_weight: 1.0,
                ..none()
            },
        ),
        (
            "joint limits",
            EnergySettings {
                joint_limits_weight: 1.0,
                ..none()
            },
        ),
        (
            "self-penetration, rounded",
            EnergySettings {
                self_penetration_weight: 1.0,
                nearest_points_rounding: 0.01,
                ..none()
            },
        ),
        (
            "prior",
            EnergySettings {
                prior_weight: 1.0,
                ..none()
            },
        ),
    ]
}

/// The energy of an elastic layer, and each of its terms alone.
fn layer_cases() -> Vec<(&'static str, EnergySettings)> {
    let nothing = LayerSettings {
        compliance_weight: 0.0,
        reach_weight: 0.0,
        pressing_weight_per_m: 0.0,
        ..LayerSettings::default()
    };
    let alone = |layer| EnergySettings {
        layer: Some(layer),
        ..none()
    };
    vec![
        ("closed", EnergySettings::closed()),
        (
            "compliance",
            alone(LayerSettings {
                compliance_weight: 1.0,
                ..nothing
            }),
        ),
        (
            "reach",
            alone(LayerSettings {
                reach_weight: 1.0,
                ..nothing
            }),
        ),
        (
            "pressing",
            alone(LayerSettings {
                pressing_weight_per_m: 1.0,
                ..nothing
            }),
        ),
    ]
}

/// A start pose, moved by a few millimetres and curled at random so that all parts overlap somewhere.
pub(super) fn pose(hand: &Hand, object: &Object, space: &dyn Space, rng: &mut Rng) -> Vec<f64> {
    let mut x = start_pose(hand, object, rng);
    let scales = space.step_scales();
    let tangent: Vec<f64> = scales
        .iter()
        .map(|s| s * rng.random_range(-0.03..0.03))
        .collect();
    space.exp(&mut x, &tangent);
    x
}

fn random_choice(hand: &Hand, contacts: usize, rng: &mut Rng) -> Vec<u32> {
    let points = u32::try_from(hand.surface.len()).unwrap();
    let mut choice = Vec::new();
    while choice.len() < contacts {
        let index = rng.random_range(0..points);
        if !choice.contains(&index) {
            choice.push(index);
        }
    }
    choice
}

#[test]
fn every_term_is_differentiated_correctly() {
    let all = || cases().into_iter().chain(layer_cases()).collect::<Vec<_>>();
    let mug = Arc::new(Object::named("mug").unwrap());
    for (hand, object, cases) in [
        (&*HAND, &*BOTTLE, all()),
        (&*HAND, &*BALL, all()),
        (&*GRIPPER, &*BOTTLE, layer_cases()),
        (&*GRIPPER, &*BALL, layer_cases()),
        (&*GRIPPER, &mug, layer_cases()),
    ] {
        for (name, settings) in cases {
            let energy = GraspEnergy::new(hand.clone(), object.clone(), settings).unwrap();
            let space = energy.space();
            let scales = space.step_scales();
            let mut rng = stream(1, Task::Start, 0);
            let mut seen = 0.0f64;
            for _ in 0..12 {
                let x = pose(hand, object, space, &mut rng);
                let choice = random_choice(hand, settings.contacts, &mut rng);
                let mut gradient = vec![f64::NAN; space.tangents()];
                let mut unused = gradient.clone();
                let value = energy.evaluate_piece(&x, &choice, &mut gradient);
                assert!(value.is_finite(), "{name}");
                let sum: f64 = energy.terms_of(&x, &choice).iter().map(|(_, v)| v).sum();
                assert!(
                    (sum - value).abs() <= 1e-9 * (1.0 + value.abs()),
                    "{name}: {sum} {value}"
                );
                seen = gradient.iter().fold(seen, |s, g| s.max(g.abs()));
                let size = gradient
                    .iter()
                    .fold(1.0 + value.abs(), |s, g| s.max(g.abs()));
                for k in 0..gradient.len() {
                    let step = 1e-7 * scales[k];
                    let mut at = |length: f64| {
                        let mut tangent = vec![0.0; space.tangents()];
                        tangent[k] = length;
                        let mut moved = x.clone();
                        space.exp(&mut moved, &tangent);
                        energy.evaluate_piece(&moved, &choice, &mut unused)
                    };
                    let estimate = (at(step) - at(-step)) / (2.0 * step);
                    // Rounding is 1e-16 of the energy over a step of 1e-7 lengths; a depth that crosses its rounding
                    // within the step adds its curvature, 1/0.5 mm, times the step.
                    let tolerance = 2e-4 * size / scales[k].min(1.0);
                    assert!(
                        (estimate - gradient[k]).abs() < tolerance,
                        "{name} of {} on {}: ∂E/∂τ_{k} = {}, difference {estimate}",
                        hand.name,
                        object.name,
                        gradient[k]
                    );
                }
            }
            assert!(seen > 0.0, "{name} never did anything on {}", object.name);
        }
    }
}

/// The softened energy of a synthesis has the right gradient and the right weights, too.
#[test]
fn softened_weights() {
    let energy =
        GraspEnergy::new(HAND.clone(), BOTTLE.clone(), EnergySettings::four_points()).unwrap();
    let space = energy.space();
    let scales = space.step_scales();
    let mut rng = stream(2, Task::Start, 0);
    let ramp = Ramp {
        distance: 0.3,
        depth: 0.02,
    };
    for _ in 0..6 {
        let x = pose(&HAND, &BOTTLE, space, &mut rng);
        let choice = random_choice(&HAND, 4, &mut rng);
        let mut gradient = vec![0.0; space.tangents()];
        let mut unused = gradient.clone();
        let value = energy.evaluate_ramped(&x, &choice, ramp, &mut gradient);
        let factor = |name: &str| match name {
            "distance" => ramp.distance,
            "penetration" | "intrusion" | "self_penetration" => ramp.depth,
            _ => 1.0,
        };
        let terms = energy.terms_of(&x, &choice);
        let sum: f64 = terms.iter().map(|(name, v)| factor(name) * v).sum();
        assert!((sum - value).abs() <= 1e-9 * (1.0 + value.abs()));
        let size = gradient.iter().fold(1.0, |s: f64, g| s.max(g.abs()));
        for k in 0..gradient.len() {
            let step = 1e-7 * scales[k];
            let mut at = |length: f64| {
                let mut tangent = vec![0.0; space.tangents()];
                tangent[k] = length;
                let mut moved = x.clone();
                space.exp(&mut moved, &tangent);
                energy.evaluate_ramped(&moved, &choice, ramp, &mut unused)
            };
            let estimate = (at(step) - at(-step)) / (2.0 * step);
            let tolerance = 2e-4 * size / scales[k].min(1.0);
            assert!((estimate - gradient[k]).abs() < tolerance);
        }
    }
}

/// Least contact energy over all sets of `size` surface points, by brute force with public functions only.
fn least_contact_energy(energy: &GraspEnergy, x: &[f64], settings: &EnergySettings) -> f64 {
    let (hand, object) = (energy.hand(), energy.object());
    let mut posed = PosedHand::default();
    hand.pose(x, &mut posed);
    let all: Vec<u32> = (0..u32::try_from(hand.surface.len()).unwrap()).collect();
    let contacts = energy.point_contacts(x, &all);
    let square = |form| form == NormForm::Square;
    let own: Vec<f64> = posed
        .points
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let unit_m = energy.unit_m();
            let (d, r) = (object.shape.distance(p), settings.distance_rounding_m);
            let distance = if square(settings.distance_form) {
                (d / unit_m).powi(2)
            } else {
                (libm::hypot(d, r) - r) / unit_m
            };
            let agreement = hand.point_normal(&posed, i).dot(&contacts[i].inward_normal);
            let alignment = -settings.alignment_weight * agreement / settings.contacts as f64;
            settings.distance_weight * distance + alignment
        })
        .collect();
    let mut least = f64::INFINITY;
    let mut stack: Vec<(usize, Vec<usize>)> = vec![(0, vec![])];
    while let Some((from, set)) = stack.pop() {
        if set.len() == settings.contacts {
            let chosen: Vec<_> = set.iter().map(|&i| contacts[i]).collect();
            let rounding = settings.force_closure_rounding;
            let net = net_wrench(&chosen);
            let closure = if square(settings.force_closure_form) {
                net * net
            } else {
                libm::hypot(net, rounding) - rounding
            };
            let total =
                set.iter().map(|&i| own[i]).sum::<f64>() + settings.force_closure_weight * closure;
            least = least.min(total);
        } else {
            for i in from..contacts.len() {
                let mut longer = set.clone();
                longer.push(i);
                stack.push((i + 1, longer));
            }
        }
    }
    least
}

fn compare_with_brute_force(stride: usize, contacts: usize, poses: usize, off_m: f64) {
    let settings = EnergySettings {
        contacts,
        ..EnergySettings::four_points()
    };
    compare_settings_with_brute_force(stride, settings, poses, off_m);
}

fn compare_settings_with_brute_force(
    stride: usize,
    settings: EnergySettings,
    poses: usize,
    off_m: f64,
) {
    let hand = Arc::new(HAND.thinned(stride));
    let contacts = settings.contacts;
    let energy = GraspEnergy::new(hand.clone(), BOTTLE.clone(), settings).unwrap();
    let mut rng = stream(7, Task::Start, stride as u64);
    for n in 0..poses {
        let mut x = pose(&hand, &BOTTLE, energy.space(), &mut rng);
        if n % 4 == 0 {
            x[0] += off_m;
        }
        let choice = energy.active_piece(&x);
        assert_eq!(choice.len(), contacts);
        let terms = energy.terms_of(&x, &choice);
        let found: f64 = terms
            .iter()
            .filter(|(name, _)| ["force_closure", "distance", "alignment"].contains(&&**name))
            .map(|(_, value)| value)
            .sum();
        let least = least_contact_energy(&energy, &x, &settings);
        assert!(
            (found - least).abs() < 1e-9,
            "pose {n}: {found}, brute force {least}"
        );
    }
}

#[test]
fn envelope_is_the_minimum_over_all_triples() {
    compare_with_brute_force(19, 3, 200, 0.05);
}

#[test]
fn envelope_is_the_minimum_over_all_quadruples() {
    compare_with_brute_force(19, 4, 200, 0.05);
}

/// Squared distances have no slope at the surface, and the alignment may cost more there than farther out. The band
/// must therefore be widened until no point outside can matter.
#[test]
fn envelope_of_the_released_energy_is_the_minimum() {
    let released = EnergySettings {
        contacts: 3,
        ..EnergySettings::released()
    };
    compare_settings_with_brute_force(19, released, 100, 0.05);
    let aligned = EnergySettings {
        alignment_weight: 3.0,
        ..EnergySettings::four_points()
    };
    compare_settings_with_brute_force(29, aligned, 100, 0.05);
}

#[test]
#[ignore = "minutes: 76 million triples for each of 20 poses at full resolution"]
fn envelope_is_the_minimum_at_full_resolution() {
    compare_with_brute_force(1, 3, 20, 0.05);
}

#[test]
#[ignore = "minutes: 15 million quadruples for each of 20 poses"]
fn envelope_is_the_minimum_over_quadruples_of_many_points() {
    compare_with_brute_force(5, 4, 20, 0.05);
}

/// Number of kinds of questions in [`answer`].
const QUESTIONS: usize = 11;

/// The bits of the answer of `energy` at a pose (or of the `whole` energy, for questions that only it can answer).
fn answer(
    question: usize,
    energy: &dyn Energy,
    whole: &GraspEnergy,
    x: &[f64],
    held: &[u32],
) -> Vec<u64> {
    let mut gradient = vec![0.0; energy.space().tangents()];
    let value = match question {
        0 => energy.evaluate_roughly_above(x, &mut gradient, 0.1).0,
        1 => energy.evaluate_roughly_above(x, &mut gradient, 0.5).0,
        2 => energy.evaluate_roughly_above(x, &mut gradient, 1e3).0,
        3 => energy.evaluate(x, &mut gradient),
        4 => energy.evaluate_piece(x, held, &mut gradient),
        5 => {
            let ramp = Ramp {
                distance: 0.3,
                depth: 0.5,
            };
            whole.evaluate_ramped(x, held, ramp, &mut gradient)
        }
        6 => whole.deepest_m(x),
        7 => {
            gradient = energy.active_piece(x).into_iter().map(f64::from).collect();
            0.0
        }
        8 => {
            gradient = energy
                .terms(x)
                .into_iter()
                .map(|(_, value)| value)
                .collect();
            0.0
        }
        n => {
            let (allowance, factor) = if n == 9 { (0.05, 1.0) } else { (3.0, 0.2) };
            let costs = whole.heat_bath_costs(x, &held[1..], factor, allowance);
            gradient = costs
                .into_iter()
                .flat_map(|(index, cost)| [f64::from(index), cost])
                .collect();
            0.0
        }
    };
    [value]
        .iter()
        .chain(&gradient)
        .map(|v| v.to_bits())
        .collect()
}

/// Earlier evaluations make a result cheaper but never different. A walk of small and large steps compares three
/// energies: one that remembers all evaluations, one with a memory of its own, and a new one for every evaluation.
#[test]
fn the_envelope_has_no_memory() {
    for (object, clearance_m) in [(&*BOTTLE, 0.0), (&*BALL, 0.0), (&*BOTTLE, 0.01)] {
        let settings = EnergySettings::four_points();
        let fresh = || {
            GraspEnergy::new(HAND.clone(), object.clone(), settings)
                .unwrap()
                .with_clearance(clearance_m, settings.penetration_weight)
        };
        let used = fresh();
        let local = used.with_cache().unwrap();
        let mut rng = stream(3, Task::Start, 0);
        let mut x = start_pose(&HAND, object, &mut rng);
        let scales = used.space().step_scales();
        for n in 0..60 {
            let size = [5e-4, 3e-3, 5e-4, 0.0, 1e-4, 0.05][n % 6];
            let tangent: Vec<f64> = scales
                .iter()
                .map(|scale| scale * size * rng.random_range(-1.0..=1.0))
                .collect();
            used.space().exp(&mut x, &tangent);
            let held = random_choice(&HAND, 4, &mut rng);
            for k in 0..QUESTIONS {
                let question = (k + 5 * n) % QUESTIONS;
                let alone = fresh();
                let expected = answer(question, &alone, &alone, &x, &held);
                for energy in [&used as &dyn Energy, &*local] {
                    let answer = answer(question, energy, &used, &x, &held);
                    assert_eq!(answer, expected, "question {question} at step {n}");
                }
            }
            let mut gradient = vec![0.0; scales.len()];
            let value = used.evaluate(&x, &mut gradient);
            let held = used.evaluate_piece(&x, &used.active_piece(&x), &mut gradient);
            assert!((held - value).abs() <= 1e-12 * (1.0 + value.abs()));
        }
    }
}

/// Above the cut-off the result is a lower bound that exceeds the cut-off; below it the result is exact.
#[test]
fn leaving_early_keeps_its_promise() {
    let energy =
        GraspEnergy::new(HAND.clone(), BOTTLE.clone(), EnergySettings::four_points()).unwrap();
    let mut rng = stream(4, Task::Start, 0);
    let mut gradient = vec![0.0; energy.space().tangents()];
    for _ in 0..30 {
        let x = start_pose(&HAND, &BOTTLE, &mut rng);
        let value = energy.evaluate(&x, &mut gradient);
        for factor in [0.5, 0.99, 1.01, 2.0] {
            let cutoff = factor * value;
            let below = energy.evaluate_below(&x, &mut gradient, cutoff);
            if value <= cutoff {
                assert_eq!(below.to_bits(), value.to_bits());
            } else {
                assert!(
                    below > cutoff && below <= value + 1e-12,
                    "{below} {value} {cutoff}"
                );
            }
        }
    }
}

/// Turning the hand about the bottle's axis changes nothing but the error of the baked field, which matters where points of
/// the hand are deep in the object.
#[test]
fn the_axis_of_the_bottle_does_not_matter() {
    let energy =
        GraspEnergy::new(HAND.clone(), BOTTLE.clone(), EnergySettings::four_points()).unwrap();
    let mut rng = stream(5, Task::Start, 0);
    let mut gradient = vec![0.0; energy.space().tangents()];
    let turn = nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), 1.234);
    let mut outside = 0;
    for case in 0..40 {
        let mut x = start_pose(&HAND, &BOTTLE, &mut rng);
        // Half of the hands are moved away from the axis, so that they touch nothing.
        let away_m = if case % 2 == 0 { 0.15 } else { 0.0 };
        let radius_m = libm::hypot(x[0], x[1]);
        for coordinate in &mut x[..2] {
            *coordinate *= 1.0 + away_m / radius_m;
        }
        let turned = landscape::space::pose_coordinates(
            &(nalgebra::Isometry3::from_parts(nalgebra::Vector3::zeros().into(), turn)
                * landscape::space::object_from_hand(&x)),
            &x[7..],
        );
        assert!(energy.space().distance(&x, &turned) < 1e-6);
        let [value, there] = [&x, &turned].map(|x| energy.evaluate(x, &mut gradient));
        let terms = energy.terms_of(&x, &energy.active_piece(&x));
        let deep = |name: &str| ["penetration", "intrusion"].contains(&name);
        let inside: f64 = terms
            .iter()
            .filter(|(name, _)| deep(name))
            .map(|(_, value)| value)
            .sum();
        let bound = if inside > 0.0 { 0.1 * value } else { 1e-9 };
        assert!((value - there).abs() < bound, "{value} {there}");
        outside += usize::from(inside == 0.0);
    }
    assert!(outside > 10, "{outside} poses outside the object");
}
