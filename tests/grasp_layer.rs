//! The energy of an elastic layer as a function of the pose; its derivatives are tested in `grasp_energy.rs`.

use std::sync::Arc;

use landscape::energy::Energy;
use landscape::grasp::closure::{PointContact, net_wrench};
use landscape::grasp::layer::LayerSettings;
use landscape::grasp::term::JointLimits;
use landscape::grasp::{EnergySettings, GraspEnergy};
use landscape::hand::{Joint, PosedHand};
use landscape::object::Object;
use landscape::optimize::{QuenchSettings, quench};
use landscape::sample::{Rng, Task, stream};
use landscape::store::{GraspFile, Overrides};
use nalgebra::DVector;
use rand::RngExt;

use super::grasp_energy::{BALL, BOTTLE, GRIPPER, HAND, pose};

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

/// The contacts of a hand are points that touch, if four do; otherwise the best of all points. They are the best set of all, by
/// brute force over a hand with few points.
#[test]
fn contacts_touch_and_are_the_best() {
    let (mut touched, mut hovered) = (0, 0);
    let hand = Arc::new(HAND.thinned(7));
    let energy = GraspEnergy::new(hand.clone(), BOTTLE.clone(), EnergySettings::default()).unwrap();
    let rough = QuenchSettings::default().with_max_evaluations(200);
    let mut rng = stream(5, Task::Start, 0);
    for _ in 0..12 {
        let start = pose(&hand, &BOTTLE, energy.space(), &mut rng);
        let x = quench(&energy, &start, &rough).x;
        let mut posed = PosedHand::default();
        hand.pose(&x, &mut posed);
        let radius_m = BOTTLE.radius_m;
        let of_point = |index: usize| {
            let point = posed.points[index];
            let (distance_m, gradient) = BOTTLE.shape.gradient(&point);
            let contact = PointContact {
                arm: (point - BOTTLE.centroid) / radius_m,
                inward_normal: -gradient.normalize(),
            };
            let cost = 40.0 * (libm::hypot(distance_m, 0.002) - 0.002) / radius_m;
            (distance_m, cost, contact)
        };
        let may_touch = (0..hand.surface.len()).filter(|i| hand.may_touch(&hand.surface[*i]));
        let all: Vec<_> = may_touch.map(of_point).collect();
        let touching: Vec<_> = (all.iter().copied())
            .filter(|(distance_m, ..)| distance_m.abs() <= 0.002)
            .collect();
        let among = if touching.len() < 4 { &all } else { &touching };
        *(if touching.len() < 4 {
            &mut hovered
        } else {
            &mut touched
        }) += 1;
        let total = |set: [usize; 4], of: &dyn Fn(usize) -> (f64, f64, PointContact)| {
            let chosen = set.map(of);
            let own: f64 = chosen.iter().map(|(_, cost, _)| cost).sum();
            let net = net_wrench(&chosen.map(|(.., contact)| contact));
            own + libm::hypot(net, 0.05) - 0.05
        };
        let mut least = f64::INFINITY;
        for a in 0..among.len() {
            for b in a + 1..among.len() {
                for c in b + 1..among.len() {
                    for d in c + 1..among.len() {
                        least = least.min(total([a, b, c, d], &|i| among[i]));
                    }
                }
            }
        }
        let found: Vec<usize> = (energy.contacts(&x).into_iter())
            .map(|index| index as usize)
            .collect();
        let found = total(found.try_into().unwrap(), &of_point);
        assert!((found - least).abs() < 1e-9, "{found}, brute force {least}");
    }
    assert!(touched > 0 && hovered > 0, "{touched} {hovered}");
}

/// Numbers of a layer that cannot be computed with are refused by name.
#[test]
fn absurd_layers_are_refused() {
    let usual = LayerSettings::default();
    let layers = [
        (
            "layer.torque_share",
            LayerSettings {
                torque_share: 0.0,
                ..usual
            },
        ),
        (
            "layer.skin_m[0] - skin_m[1]",
            LayerSettings {
                skin_m: [0.001, 0.001],
                ..usual
            },
        ),
        (
            "layer.far_share",
            LayerSettings {
                far_share: 2.0,
                ..usual
            },
        ),
        (
            "layer.reach_m",
            LayerSettings {
                reach_m: f64::NAN,
                ..usual
            },
        ),
    ];
    for (name, layer) in layers {
        let settings = EnergySettings {
            layer,
            ..EnergySettings::default()
        };
        let error = GraspEnergy::new(HAND.clone(), BALL.clone(), settings).unwrap_err();
        assert!(error.to_string().starts_with(name), "{error}");
    }
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

/// At minima, differences of the energy and of the gradient converge with their step, and the matrix of second derivatives is
/// symmetric. Second derivatives jump where the rounded hinge of a joint limit begins, so minima beside such a place do not count, and where a
/// sphere begins to press, so differences of the gradient must converge at more than half of the minima only.
#[test]
fn derivatives_at_minima_converge() {
    let committed = "data/grasps.parquet".as_ref();
    let (file, _) = GraspFile::read(committed, Overrides::default()).unwrap();
    let energy = GraspEnergy::new(HAND.clone(), BOTTLE.clone(), EnergySettings::default()).unwrap();
    let space = energy.space();
    let mut rng = stream(5, Task::Start, 0);
    let (mut tested, mut converging) = (0, 0);
    for row in file.grasps.iter().step_by(50) {
        let name = row.id;
        let minimum = landscape::optimize::quench(
            &energy,
            row.grasp.pose.as_ref(),
            &QuenchSettings::default(),
        )
        .x;
        let rounding_rad = JointLimits::ROUNDING_RAD;
        let begins = |joint: &Joint, angle: f64| {
            let [low, high] = [
                joint.limits_rad[0] + rounding_rad,
                joint.limits_rad[1] - rounding_rad,
            ];
            (angle - low).abs().min((angle - high).abs()) < 2e-3
        };
        let angles = HAND.joints.iter().zip(&minimum[7..]);
        if angles
            .into_iter()
            .any(|(joint, angle)| begins(joint, *angle))
        {
            continue;
        }
        tested += 1;
        let slope = |x: &[f64]| {
            let mut gradient = vec![0.0; space.tangents()];
            let value = energy.evaluate(x, &mut gradient);
            (value, DVector::from_vec(gradient))
        };
        let moved = |x: &[f64], along: &DVector<f64>, length: f64| {
            let mut x = x.to_vec();
            space.exp(&mut x, (along * length).as_slice());
            x
        };
        let direction = |rng: &mut Rng| {
            let scales = space.step_scales();
            let numbers = scales.iter().map(|s| s * rng.random_range(-1.0..1.0));
            DVector::from_vec(numbers.collect::<Vec<f64>>())
        };
        // Beside the minimum, where the slope is not 0.
        let beside = moved(&minimum, &direction(&mut rng), 1e-3);
        let along = direction(&mut rng);
        let exact = slope(&beside).1.dot(&along);
        let error = |step: f64| {
            let [up, down] = [step, -step].map(|s| slope(&moved(&beside, &along, s)).0);
            ((up - down) / (2.0 * step) - exact).abs()
        };
        // These steps are far below the thickness of the skin, a millimetre.
        let [coarse, fine] = [1e-5, 1e-6].map(error);
        assert!(
            fine < 0.1 * coarse && fine < 1e-3 * exact.abs(),
            "grasp {name}: {coarse} {fine} of {exact}"
        );
        let (u, v) = (direction(&mut rng), direction(&mut rng));
        let product = |along: &DVector<f64>, step: f64| {
            let [up, down] = [step, -step].map(|s| slope(&moved(&minimum, along, s)).1);
            (up - down) / (2.0 * step)
        };
        let steps = [1e-4, 5e-5, 2.5e-5].map(|step| product(&u, step));
        let [coarse, fine] = [0, 1].map(|k| (&steps[k + 1] - &steps[k]).norm());
        if fine >= 0.7 * coarse {
            continue;
        }
        converging += 1;
        let [one, other] = [v.dot(&product(&u, 1e-5)), u.dot(&product(&v, 1e-5))];
        let size = u.dot(&product(&u, 1e-5)).abs() + v.dot(&product(&v, 1e-5)).abs();
        // Beside what is left of the error of the differences.
        let left = fine * (u.norm() + v.norm());
        assert!(
            (one - other).abs() < 1e-3 * size + left,
            "grasp {name}: {one} {other} of {size}, {left}"
        );
    }
    assert!(
        tested >= 3 && 2 * converging > tested,
        "{converging} of {tested}"
    );
}
