//! The energy of an elastic layer as a function of the pose; its derivatives are tested in `grasp_energy.rs`.

use std::sync::Arc;

use landscape::energy::Energy;
use landscape::grasp::{EnergySettings, GraspEnergy};
use landscape::object::Object;
use landscape::sample::{Task, stream};
use nalgebra::DVector;
use rand::RngExt;

use super::grasp_energy::{BOTTLE, GRIPPER, HAND, pose};

/// The energy of an elastic layer is a function of the pose alone: after other poses, in any order, it has
/// the same bits.
#[test]
fn a_layer_has_no_memory() {
    for hand in [&*HAND, &*GRIPPER] {
        let settings = EnergySettings::default();
        let energy = GraspEnergy::new(hand.clone(), BOTTLE.clone(), settings).unwrap();
        let space = energy.space();
        let mut rng = stream(3, Task::Start, 0);
        let poses: Vec<Vec<f64>> = (0..20)
            .map(|_| pose(hand, &BOTTLE, space, &mut rng))
            .collect();
        let bits = |x: &Vec<f64>| {
            let fresh = GraspEnergy::new(hand.clone(), BOTTLE.clone(), settings).unwrap();
            let mut gradient = vec![0.0; space.tangents()];
            let value = fresh.evaluate(x, &mut gradient);
            (
                value.to_bits(),
                gradient.iter().map(|g| g.to_bits()).collect::<Vec<_>>(),
            )
        };
        for x in poses.iter().chain(poses.iter().rev()) {
            let mut gradient = vec![0.0; space.tangents()];
            let value = energy.evaluate(x, &mut gradient);
            let found: Vec<u64> = gradient.iter().map(|g| g.to_bits()).collect();
            assert_eq!((value.to_bits(), found), bits(x));
        }
    }
}

/// Turning hand and object together changes nothing, because the loads turn with the hand: symmetric objects have symmetric
/// energies.
#[test]
fn a_layer_has_the_symmetry_of_the_object() {
    for hand in [&*HAND, &*GRIPPER] {
        let energy =
            GraspEnergy::new(hand.clone(), BOTTLE.clone(), EnergySettings::default()).unwrap();
        let space = energy.space();
        let mut rng = stream(4, Task::Start, 0);
        for _ in 0..10 {
            let x = pose(hand, &BOTTLE, space, &mut rng);
            let turn =
                nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), 1.234);
            let mut turned = x.clone();
            let moved = turn * nalgebra::Vector3::new(x[0], x[1], x[2]);
            turned[..3].copy_from_slice(moved.as_slice());
            let q = turn
                * nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(
                    x[3], x[4], x[5], x[6],
                ));
            turned[3..7].copy_from_slice(&[q.w, q.i, q.j, q.k]);
            let mut gradient = vec![0.0; space.tangents()];
            let [before, after] = [&x, &turned].map(|x| energy.evaluate(x, &mut gradient));
            assert!(
                (before - after).abs() < 1e-9 * (1.0 + before),
                "{before} {after}"
            );
        }
    }
}

/// A hand far from everything has let go: its compliance is 1.
#[test]
fn a_hand_that_has_let_go() {
    let energy = GraspEnergy::new(HAND.clone(), BOTTLE.clone(), EnergySettings::default()).unwrap();
    let mut x = HAND.rest_coordinates();
    x[0] = 1.0;
    assert!((energy.compliance(&x) - 1.0).abs() < 1e-12);
}

/// The gradient does not jump: along random lines through walls, with joints far beyond their limits, the largest step of the
/// gradient between neighbouring points vanishes when it is halved again and again. If the lengths of normals did not count,
/// a jump of a hundredth of the gradient would remain on one of the lines through the disk.
#[test]
fn the_gradient_of_a_layer_is_continuous() {
    const POINTS: usize = 300;
    const HALVINGS: i32 = 26;
    let mut rng = stream(6, Task::Start, 0);
    for name in ["mug", "disk", "bowl"] {
        let object = Arc::new(Object::named(name).unwrap());
        let energy =
            GraspEnergy::new(HAND.clone(), object.clone(), EnergySettings::default()).unwrap();
        let space = energy.space();
        for line in 0..30 {
            let start = pose(&HAND, &object, space, &mut rng);
            let scales = space.step_scales();
            let along: Vec<f64> = (scales.iter())
                .map(|s| 0.1 * s * rng.random_range(-1.0..1.0))
                .collect();
            let gradient = |at: f64| {
                let mut x = start.clone();
                let tangent: Vec<f64> = along.iter().map(|a| at * a).collect();
                space.exp(&mut x, &tangent);
                let mut gradient = vec![0.0; space.tangents()];
                energy.evaluate(&x, &mut gradient);
                DVector::from_vec(gradient)
            };
            let difference = |low: f64, high: f64| (gradient(high) - gradient(low)).norm();
            let edge = |i: usize| i as f64 / POINTS as f64;
            let steps = (0..POINTS).map(|i| (edge(i), edge(i + 1)));
            let (mut low, mut high) = steps
                .max_by(|a, b| difference(a.0, a.1).total_cmp(&difference(b.0, b.1)))
                .unwrap();
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if difference(low, middle) > difference(middle, high) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            let (jump, size) = (difference(low, high), gradient(low).norm());
            assert!(
                jump < 1e-3 * size,
                "{name}, line {line} at {low}: {jump} of {size}"
            );
        }
    }
}
