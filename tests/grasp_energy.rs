//! The grasp energy: the gradient of every term.
#![cfg(feature = "grasp")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::sync::{Arc, LazyLock};

use landscape::energy::{Energy, Explain};
use landscape::grasp::layer::LayerSettings;
use landscape::grasp::start::start_pose;
use landscape::grasp::{EnergySettings, GraspEnergy};
use landscape::hand::Hand;
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

/// The layer without weight.
fn no_layer() -> LayerSettings {
    LayerSettings {
        compliance_weight: 0.0,
        reach_weight: 0.0,
        pressing_weight_per_m: 0.0,
        ..LayerSettings::default()
    }
}

fn none() -> EnergySettings {
    EnergySettings {
        layer: no_layer(),
        self_penetration_weight: 0.0,
        joint_limits_weight: 0.0,
        prior_weight: 0.0,
        ..EnergySettings::default()
    }
}

/// The terms of the hand alone. A new term needs one line here.
fn hand_cases() -> Vec<(&'static str, EnergySettings)> {
    vec![
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
    let nothing = no_layer();
    let alone = |layer| EnergySettings { layer, ..none() };
    vec![
        ("closed", EnergySettings::default()),
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

#[test]
fn every_term_is_differentiated_correctly() {
    let all = || {
        hand_cases()
            .into_iter()
            .chain(layer_cases())
            .collect::<Vec<_>>()
    };
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
                let mut gradient = vec![f64::NAN; space.tangents()];
                let mut unused = gradient.clone();
                let value = energy.evaluate(&x, &mut gradient);
                assert!(value.is_finite(), "{name}");
                let sum: f64 = energy.terms(&x).iter().map(|(_, v)| v).sum();
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
                        energy.evaluate(&moved, &mut unused)
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
