//! Every space: Log inverts Exp, moves are reversible, and lengths obey the axioms of a distance.

use std::f64::consts::{PI, TAU};

use landscape::space::{
    Cluster, Euclidean, Mirrored, Periodic, PoseMetric, PoseSpace, Rotation, Space, Symmetry,
    Torus, interpolate, object_from_hand, pose_coordinates,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

/// Rounding of coordinates and lengths of size one, after a few operations.
const ROUNDING: f64 = 1e-13;

const AXIS_POINT: [f64; 3] = [0.02, -0.01, 0.05];
const AXIS: [f64; 3] = [0.1, -0.3, 1.0];

/// A space, its map from numbers in (−1, 1) to a point, and the length up to which Log inverts Exp.
struct Case {
    name: &'static str,
    space: Box<dyn Space>,
    point: fn(&[f64]) -> Vec<f64>,
    injectivity: f64,
}

/// The list of all tested spaces except clusters, whose distance is exact only for close ones (see below).
fn cases() -> Vec<Case> {
    let pose = |name, symmetry, injectivity| Case {
        name,
        space: Box::new(PoseSpace::new(metric(), symmetry)),
        point: pose_point,
        injectivity,
    };
    vec![
        Case {
            name: "euclidean",
            space: Box::new(Euclidean::new(3)),
            point: |u| u[..3].to_vec(),
            injectivity: f64::INFINITY,
        },
        Case {
            name: "mirrored box",
            space: Box::new(Mirrored::new(&[-1.0, 0.0, 2.0], &[1.0, 3.0, 5.0])),
            point: |u| u[..3].to_vec(),
            // A mirror may be anywhere near.
            injectivity: 0.0,
        },
        Case {
            name: "torus",
            space: Box::new(Torus::new(3)),
            point: |u| u[..3].iter().map(|k| PI * k).collect(),
            injectivity: PI,
        },
        Case {
            name: "periodic cell",
            space: Box::new(Periodic::new(&[-1.0, 0.0, 2.0], &[2.0, f64::INFINITY, 5.0])),
            point: |u| vec![0.9 * u[0], u[1], 4.5 + 2.4 * u[2]],
            injectivity: 1.0,
        },
        Case {
            name: "rotation",
            space: Box::new(Rotation::new(0.7)),
            point: |u| pose_point(u)[3..7].to_vec(),
            injectivity: 0.7 * PI,
        },
        pose("pose", Symmetry::None, 0.05 * PI),
        pose(
            "pose about an axis",
            Symmetry::Axis {
                point: AXIS_POINT.into(),
                direction: AXIS.into(),
            },
            0.0,
        ),
        pose(
            "pose about a point",
            Symmetry::Sphere {
                centre: AXIS_POINT.into(),
            },
            0.0,
        ),
        pose("pose on a box", Symmetry::Finite(half_turns()), 0.0),
    ]
}

fn metric() -> PoseMetric {
    PoseMetric {
        centroid: Vector3::new(0.01, -0.02, 0.07),
        radius_of_gyration_m: 0.05,
        joint_levers_m: vec![0.02, 0.051],
        joint_reaches_m: vec![0.05, 0.07],
        rotation_reach_m: 0.08,
        wraps: vec![false, true],
    }
}

fn pose_point(u: &[f64]) -> Vec<f64> {
    let position = Translation3::new(0.2 * u[0], 0.2 * u[1], 0.2 * u[2]);
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(u[3], u[4], u[5]) * PI);
    pose_coordinates(
        &Isometry3::from_parts(position, rotation),
        &[u[6], PI * u[7]],
    )
}

fn half_turns() -> Vec<Isometry3<f64>> {
    [Vector3::x(), Vector3::y(), Vector3::z()]
        .map(|axis| Isometry3::rotation(axis * PI))
        .to_vec()
}

fn turn_about(point: [f64; 3], turn: Vector3<f64>) -> Isometry3<f64> {
    let point = Vector3::from(point);
    let rotation = UnitQuaternion::from_scaled_axis(turn);
    Isometry3::from_parts((point - rotation * point).into(), rotation)
}

fn moved(x: &[f64], by: &Isometry3<f64>) -> Vec<f64> {
    pose_coordinates(&(by * object_from_hand(x)), &x[7..])
}

fn norm(tangent: &[f64]) -> f64 {
    tangent.iter().map(|k| k * k).sum::<f64>().sqrt()
}

fn log(space: &dyn Space, a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut tangent = vec![f64::NAN; space.tangents()];
    let length = space.log(a, b, &mut tangent);
    assert!((length - norm(&tangent)).abs() < ROUNDING);
    assert!((length - space.distance(a, b)).abs() < ROUNDING);
    tangent
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(p, q)| (p - q).abs())
        .fold(0.0, f64::max)
}

fn numbers() -> impl Strategy<Value = [f64; 8]> {
    prop::array::uniform8(-0.999..0.999_f64)
}

proptest! {
    #[test]
    fn exp_of_log_arrives(a in numbers(), b in numbers()) {
        for Case { name, space, point, .. } in cases() {
            let (mut a, b) = (point(&a), point(&b));
            let step = log(&*space, &a, &b);
            space.exp(&mut a, &step);
            prop_assert!(space.distance(&a, &b) < ROUNDING, "{name}: {}", space.distance(&a, &b));
        }
    }

    #[test]
    fn log_of_exp_is_the_step(a in numbers(), step in numbers()) {
        for Case { name, space, point, injectivity } in cases() {
            let a = point(&a);
            let step: Vec<f64> = step[..space.tangents()].to_vec();
            let length = norm(&step);
            let step: Vec<f64> = step.iter().map(|k| k * (0.9 * injectivity / length).min(1.0)).collect();
            let mut b = a.clone();
            space.exp(&mut b, &step);
            prop_assert!(largest_difference(&log(&*space, &a, &b), &step) < ROUNDING, "{name}");
        }
    }

    #[test]
    fn moves_can_be_taken_back(a in numbers(), step in numbers()) {
        for Case { name, space, point, .. } in cases() {
            let start = point(&a);
            let step = &step[..space.tangents()];
            let mut x = start.clone();
            space.exp(&mut x, step);
            space.exp(&mut x, &step.iter().map(|k| -k).collect::<Vec<_>>());
            // Angles on the seam may come back as ±π, so compare as the space does, and the rest as numbers.
            let seam = largest_difference(&start, &x) > 6.0;
            prop_assert!(seam || largest_difference(&start, &x) < 10.0 * ROUNDING, "{name}: {start:?} {x:?}");
            prop_assert!(norm(&log(&*space, &start, &x)) < ROUNDING, "{name}");
        }
    }

    #[test]
    fn lengths_are_distances(a in numbers(), b in numbers(), c in numbers()) {
        for Case { name, space, point, .. } in cases() {
            let (a, b, c) = (point(&a), point(&b), point(&c));
            let (ab, bc, ac) = (space.distance(&a, &b), space.distance(&b, &c), space.distance(&a, &c));
            prop_assert!(space.distance(&a, &a) < ROUNDING, "{name}");
            prop_assert!((ab - space.distance(&b, &a)).abs() < ROUNDING, "{name}");
            prop_assert!(ac <= ab + bc + ROUNDING, "{name}: {ac} > {ab} + {bc}");
        }
    }

    #[test]
    fn landmarks_are_no_farther_apart_than_points(a in numbers(), b in numbers(), near in any::<bool>()) {
        let cluster = Case { name: "cluster", space: Box::new(Cluster::new(2)), point: |u| u[..6].to_vec(), injectivity: 0.0 };
        for Case { name, space, point, .. } in cases().into_iter().chain([cluster]) {
            let b: Vec<f64> = if near { a.iter().zip(&b).map(|(a, b)| a + 1e-3 * b).collect() } else { b.to_vec() };
            let (a, b) = (point(&a), point(&b));
            let marks = [space.landmarks(&a), space.landmarks(&b)];
            prop_assert!(!marks[0].is_empty(), "{name}");
            let apart = norm(&marks[0].iter().zip(&marks[1]).map(|(a, b)| a - b).collect::<Vec<_>>());
            let distance = space.distance(&a, &b);
            prop_assert!(apart <= distance + ROUNDING, "{name}: {apart} {distance}");
        }
    }

    /// A geodesic is shortest between any two of its points.
    #[test]
    fn half_way_is_half_as_far(a in numbers(), b in numbers()) {
        for Case { name, space, point, .. } in cases() {
            let (a, b) = (point(&a), point(&b));
            let middle = interpolate(&*space, &a, &b, 0.5);
            let whole = space.distance(&a, &b);
            prop_assert!((space.distance(&a, &middle) - 0.5 * whole).abs() < ROUNDING, "{name}");
            prop_assert!((space.distance(&middle, &b) - 0.5 * whole).abs() < ROUNDING, "{name}");
        }
    }

    /// A move straight toward b reduces the distance by its length; a sideways move does not change it to first order:
    /// |∇d| = 1.
    #[test]
    fn distance_has_unit_slope(a in numbers(), b in numbers(), side in numbers()) {
        for Case { name, space, point, .. } in cases() {
            let (a, b) = (point(&a), point(&b));
            let step = log(&*space, &a, &b);
            let length = norm(&step);
            let direction: Vec<f64> = step.iter().map(|k| k / length).collect();
            let side = &side[..space.tangents()];
            let expected = -direction.iter().zip(side).map(|(p, q)| p * q).sum::<f64>();
            let h = 1e-5;
            let at = |size: f64| {
                let mut x = a.clone();
                space.exp(&mut x, &side.iter().map(|k| k * size).collect::<Vec<_>>());
                space.distance(&x, &b)
            };
            let (ahead, here, behind) = (at(h), at(0.0), at(-h));
            // Where two ways are equally short the distance has a kink; a kink beside `here` spoils the central
            // difference by half of what the second difference shows.
            let bend = (ahead - 2.0 * here + behind).abs() / h;
            if length > 0.02 {
                let error = ((ahead - behind) / (2.0 * h) - expected).abs();
                prop_assert!(error < 1e-5 + bend, "{name}: {error}");
            }
        }
    }

    #[test]
    fn turning_the_object_changes_nothing(a in numbers(), b in numbers(), turn in numbers()) {
        let angle = Vector3::from(AXIS).normalize() * (TAU * turn[0]);
        let free = Vector3::new(turn[1], turn[2], turn[3]) * PI;
        let motions = [
            ("pose about an axis", turn_about(AXIS_POINT, angle)),
            ("pose about a point", turn_about(AXIS_POINT, free)),
            ("pose on a box", half_turns()[1]),
        ];
        for (name, motion) in motions {
            let space = cases().into_iter().find(|case| case.name == name).unwrap().space;
            let (a, b) = (pose_point(&a), pose_point(&b));
            let copy = moved(&b, &motion);
            prop_assert!(space.distance(&b, &copy) < ROUNDING, "{name}");
            prop_assert!((space.distance(&a, &b) - space.distance(&a, &copy)).abs() < ROUNDING, "{name}");
        }
    }

    /// More symmetry never makes a distance longer, and moving hand and object together never changes it.
    #[test]
    fn symmetry_shortens(a in numbers(), b in numbers(), by in numbers()) {
        let (a, b) = (pose_point(&a), pose_point(&b));
        let plain = PoseSpace::new(metric(), Symmetry::None);
        for Case { name, space, .. } in cases().into_iter().skip(5) {
            prop_assert!(space.distance(&a, &b) <= plain.distance(&a, &b) + ROUNDING, "{name}");
        }
        let motion = turn_about([by[0], by[1], by[2]], Vector3::new(by[3], by[4], by[5]) * PI);
        let together = plain.distance(&moved(&a, &motion), &moved(&b, &motion));
        prop_assert!((together - plain.distance(&a, &b)).abs() < ROUNDING);
    }

    #[test]
    fn the_other_way_arrives_too_and_is_no_shorter(a in numbers(), b in numbers()) {
        for Case { name, space, point, .. } in cases().into_iter().skip(2) {
            let (a, b) = (point(&a), point(&b));
            let mut step = vec![f64::NAN; space.tangents()];
            let length = space.log_other_way(&a, &b, &mut step).unwrap();
            prop_assert!(length >= space.distance(&a, &b) - ROUNDING, "{name}");
            let mut x = a.clone();
            space.exp(&mut x, &step);
            prop_assert!(space.distance(&x, &b) < ROUNDING, "{name}");
        }
    }

    #[test]
    fn near_clusters_go_there_and_back(shape in prop::collection::vec(-1.0..1.0_f64, 18), step in prop::collection::vec(-0.02..0.02_f64, 18)) {
        // Six atoms around the corners of an octahedron, so that neighbours keep their distance.
        let corner = |k: usize| if k % 3 == k / 6 { 1.0 - 2.0 * f64::from(u8::from(k / 3 % 2 == 1)) } else { 0.0 };
        let a: Vec<f64> = shape.iter().enumerate().map(|(k, u)| corner(k) + 0.2 * u).collect();
        let b: Vec<f64> = a.iter().zip(&step).map(|(x, u)| x + u).collect();
        let space = Cluster::new(6);
        let log_step = log(&space, &a, &b);
        prop_assert!(norm(&log_step) <= norm(&step) + ROUNDING);
        prop_assert!((space.distance(&b, &a) - norm(&log_step)).abs() < ROUNDING);
        let mut arrived = a.clone();
        space.exp(&mut arrived, &log_step);
        prop_assert!(space.distance(&arrived, &b) < ROUNDING);
        // The shortest way moves along no zero mode.
        for mode in space.zero_modes(&a).chunks_exact(18) {
            let along: f64 = mode.iter().zip(&log_step).map(|(p, q)| p * q).sum();
            prop_assert!(along.abs() < ROUNDING, "{along}");
        }
    }
}
