//! Paths between two minima: strings and bands, both ways around a ring, modulo the symmetry of an object, between close
//! ridges, and with objections.
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod surfaces;

use std::f64::consts::PI;

use landscape::energy::Energy;
use landscape::energy::model::{LennardJones, MullerBrown, Orientation, ThreeHole};
use landscape::optimize::{QuenchSettings, quench};
use landscape::space::{
    Euclidean, PoseMetric, PoseSpace, Rotation, Space, Symmetry, object_from_hand, pose_coordinates,
};
use landscape::topography::{
    AuditSettings, Connection, Connector, Evidence, MapSettings, Minimum, MinimumId, Pair,
    PathMethod, Run, Start, Verdict, audit, build_landscape,
};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use serde_json::Value;
use surfaces::{Guide, Ridge, Ring, Turn, Wells};

fn reference(name: &str) -> Value {
    let all: Value = serde_json::from_str(include_str!("../reference/landscapes.json")).unwrap();
    all[name].clone()
}

/// The minima reached from these points, lowest first.
fn minima_below(energy: &dyn Energy, starts: &[Vec<f64>]) -> Vec<Minimum> {
    let settings = QuenchSettings::default().with_gradient_tolerance(1e-9);
    let mut minima: Vec<Minimum> = starts
        .iter()
        .map(|start| {
            let found = quench(energy, start, &settings);
            Minimum {
                coordinates: found.x,
                energy: found.energy,
                members: Vec::new(),
            }
        })
        .collect();
    minima.sort_by(|a, b| a.energy.total_cmp(&b.energy));
    minima
}

/// Settings for paths that start as straight lines only.
fn straight_only(energy: f64, length: f64, method: PathMethod) -> MapSettings {
    let mut settings = MapSettings::for_scales(energy, length);
    settings.searches = 0;
    settings.path.method = method;
    settings
}

/// The path from the straight line between two minima.
fn straight(energy: &dyn Energy, ends: (&Minimum, &Minimum), settings: &MapSettings) -> Connection {
    let connector = Connector {
        path: &settings.path,
        quench: &settings.quench,
        sameness: &settings.sameness,
    };
    let pair = Pair {
        ids: (MinimumId(0), MinimumId(1)),
        minima: ends,
        attempt: 0,
        known: f64::INFINITY,
    };
    connector.connect(energy, pair)
}

const METHODS: [PathMethod; 2] = [PathMethod::String, PathMethod::Band];

/// A surface, its minima, and the scales of its paths.
struct Case {
    name: &'static str,
    energy: Box<dyn Energy>,
    minima: Vec<Minimum>,
    scales: (f64, f64),
    /// Energies of all its saddles.
    saddles: Vec<f64>,
}

fn cases() -> Vec<Case> {
    let plane = |name: &'static str, energy: Box<dyn Energy>, scales| {
        let reference = reference(name);
        let list = |kind: &str| reference[kind].as_array().unwrap().clone();
        let place =
            |point: &Value| -> Vec<f64> { serde_json::from_value(point["x"].clone()).unwrap() };
        let starts: Vec<Vec<f64>> = list("minima").iter().map(place).collect();
        let minima = minima_below(&*energy, &starts);
        let saddles = list("saddles")
            .iter()
            .map(|p| p["energy"].as_f64().unwrap())
            .collect();
        Case {
            name,
            energy,
            minima,
            scales,
            saddles,
        }
    };
    let cluster = reference("LJ7");
    let places: Vec<Vec<f64>> = serde_json::from_value(cluster["minima_coords"].clone()).unwrap();
    let energy = LennardJones::new(7);
    let seven = Case {
        name: "LJ7",
        minima: minima_below(&energy, &places),
        energy: Box::new(energy),
        scales: (1.0, 1.0),
        saddles: (cluster["ts"].as_array().unwrap().iter())
            .map(|ts| ts["energy"].as_f64().unwrap())
            .collect(),
    };
    let weights = [3.0, 2.0, 1.5, 1.0];
    let energy = Orientation::new(weights);
    let axes: Vec<Vec<f64>> = (0..4)
        .map(|k| (0..4).map(|j| f64::from(u8::from(j == k))).collect())
        .collect();
    let rotations = Case {
        name: "rotations",
        minima: minima_below(&energy, &axes),
        energy: Box::new(energy),
        scales: (0.5, 1.5),
        saddles: (0..4)
            .flat_map(|j| (0..j).map(move |i| -1.0 / (1.0 / weights[i] + 1.0 / weights[j])))
            .collect(),
    };
    vec![
        plane("muller_brown", Box::new(MullerBrown::new()), (50.0, 1.0)),
        plane("three_hole", Box::new(ThreeHole::new()), (1.0, 1.0)),
        seven,
        rotations,
    ]
}

/// Strings and bands reach the same saddles: heights agree to a millionth of the barriers, every one is a known saddle of
/// index 1 on measuring again, and both descents end in the minima asked for.
#[test]
fn strings_and_bands_end_at_the_same_verified_saddles() {
    let mut saddles = 0;
    for case in cases() {
        let (energy, scales) = (&*case.energy, case.scales);
        for j in 1..case.minima.len() {
            for i in 0..j {
                let ends = (&case.minima[i], &case.minima[j]);
                let found = METHODS.map(|method| {
                    straight(energy, ends, &straight_only(scales.0, scales.1, method))
                });
                let [string, band] = found.each_ref().map(|c| (c.edge.height, c.edge.evidence));
                assert!(
                    (string.0 - band.0).abs() < 1e-6 * scales.0,
                    "{} {i}-{j}: {string:?} {band:?}",
                    case.name
                );
                for connection in &found {
                    if connection.edge.evidence == Evidence::Saddle {
                        saddles += 1;
                        check_saddle(&case, ends, connection);
                    }
                }
            }
        }
    }
    assert!(saddles >= 2 * 12, "{saddles}");
}

fn check_saddle(case: &Case, ends: (&Minimum, &Minimum), connection: &Connection) {
    let height = connection.edge.height;
    let known = case.saddles.iter().any(|e| (e - height).abs() < 1e-5);
    assert!(known, "{}: no saddle at {height}", case.name);
    let path = &connection.path;
    let top = path.top();
    let audits = audit(
        &*case.energy,
        &[path.images[top].clone()],
        1,
        &AuditSettings {
            gradient_tolerance: 1e-3,
            ..AuditSettings::default()
        },
    );
    assert_eq!(
        audits[0].verdict,
        Verdict::Sound,
        "{}: {audits:?}",
        case.name
    );
    // Descents of our own, from both sides of the top.
    let space = case.energy.space();
    for (side, end) in [(top - 1, ends.0), (top + 1, ends.1)] {
        let below = quench(
            &*case.energy,
            &path.images[side],
            &QuenchSettings::default(),
        );
        let apart = space.distance(&below.x, &end.coordinates);
        assert!(apart < 1e-3, "{}: {apart}", case.name);
    }
}

#[test]
fn half_turns_go_the_lower_way_round() {
    for twist in [-0.8, 0.8] {
        let energy = Turn {
            even: Orientation::new([2.0, 2.0, 1.0, 1.0]),
            twist,
        };
        let mut gradient = [0.0; 3];
        let x = [0.6, 0.5, 0.4, -0.48];
        energy.evaluate(&x, &mut gradient);
        for (n, g) in gradient.iter().enumerate() {
            let at = |h: f64| {
                let (mut x, mut step) = (x, [0.0; 3]);
                step[n] = h;
                energy.space().exp(&mut x, &step);
                energy.evaluate(&x, &mut [0.0; 3])
            };
            assert!(((at(1e-5) - at(-1e-5)) / 2e-5 - g).abs() < 1e-8);
        }
        let corners = [vec![1.0, 0.0, 0.0, 0.0], vec![0.0, 1.0, 0.0, 0.0]];
        let minima = minima_below(&energy, &corners);
        for method in METHODS {
            let mut settings = straight_only(1.0, 1.5, method);
            let ends = (&minima[0], &minima[1]);
            let found = straight(&energy, ends, &settings);
            assert_eq!(found.edge.evidence, Evidence::Saddle);
            assert!(
                (found.edge.height + 1.1).abs() < 1e-6,
                "{}",
                found.edge.height
            );
            // One way alone is the higher one for one of the two twists.
            settings.path.detour = 0.0;
            let alone = straight(&energy, ends, &settings);
            let lower = found.start == Some(Start::Straight);
            let expected = if lower { -1.1 } else { -0.9 };
            assert!(
                (alone.edge.height - expected).abs() < 1e-6,
                "{}",
                alone.edge.height
            );
        }
    }
}

/// Two wells at distance `step`, the second given as an equivalent copy. The path must have the length and height of the
/// path between the nearest copies.
fn check_symmetry(symmetry: Symmetry, motion: &Isometry3<f64>) {
    let metric = PoseMetric {
        centroid: Vector3::new(0.01, -0.02, 0.07),
        radius_of_gyration_m: 0.05,
        joint_levers_m: vec![0.02],
        joint_reaches_m: vec![0.05],
        rotation_reach_m: 0.08,
        wraps: vec![false],
    };
    let space = PoseSpace::new(metric.clone(), symmetry);
    let hand = Isometry3::new(
        Vector3::new(0.08, 0.01, -0.03),
        Vector3::new(0.4, -0.2, 0.9),
    );
    let a = pose_coordinates(&hand, &[0.3]);
    let mut near = a.clone();
    space.exp(&mut near, &[0.002, 0.011, 0.016, 0.015, -0.01, 0.006, 0.01]);
    let far = pose_coordinates(&(motion * object_from_hand(&near)), &near[7..]);
    let distance = space.distance(&a, &near);
    assert!((space.distance(&a, &far) - distance).abs() < 1e-12);
    let plain = PoseSpace::new(metric, Symmetry::None);
    assert!(plain.distance(&a, &far) > 2.0 * distance);
    let energy = Wells {
        space,
        centres: vec![a.clone(), far.clone()],
        width: distance / 3.0,
    };
    let minima = minima_below(&energy, &[a, far]);
    let height = -2.0 * libm::exp(-9.0_f64 / 8.0);
    for method in METHODS {
        let found = straight(
            &energy,
            (&minima[0], &minima[1]),
            &straight_only(0.3, distance, method),
        );
        assert_eq!(found.edge.evidence, Evidence::Saddle);
        assert!(
            (found.edge.height - height).abs() < 1e-3,
            "{}",
            found.edge.height
        );
        let stretch = found.edge.length / distance;
        // Descents do not go quite straight.
        assert!((0.95..1.05).contains(&stretch), "{stretch}");
    }
}

#[test]
fn copies_by_a_symmetry_are_aligned() {
    let point = Vector3::new(0.02, -0.01, 0.05);
    let about = |turn: Vector3<f64>| {
        let turn = UnitQuaternion::from_scaled_axis(turn);
        Isometry3::from_parts((point - turn * point).into(), turn)
    };
    let direction = Vector3::new(0.1, -0.3, 1.0);
    let turn = about(direction.normalize() * 2.0);
    check_symmetry(Symmetry::Axis { point, direction }, &turn);
    let turn = about(Vector3::new(1.0, -2.0, 0.7));
    check_symmetry(Symmetry::Sphere { centre: point }, &turn);
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let half_turns = axes.map(|axis| Isometry3::rotation(axis * PI)).to_vec();
    let motion = half_turns[1];
    check_symmetry(Symmetry::Finite(half_turns), &motion);
}

#[test]
fn a_ridge_between_two_images_is_seen() {
    let energy = Ridge(Euclidean::new(2));
    let minima = minima_below(&energy, &[vec![-1.0, 0.0], vec![1.0, 0.0]]);
    // The top of the ridge, by bisection of the slope.
    let (mut low, mut high) = (0.36, 0.39);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        let mut gradient = [0.0; 2];
        energy.evaluate(&[middle, 0.0], &mut gradient);
        *(if gradient[0] > 0.0 {
            &mut low
        } else {
            &mut high
        }) = middle;
    }
    let height = energy.evaluate(&[low, 0.0], &mut [0.0; 2]);
    for method in METHODS {
        let mut settings = straight_only(1.0, 2.0, method);
        let ends = (&minima[0], &minima[1]);
        let found = straight(&energy, ends, &settings);
        assert!(
            (found.edge.height - height).abs() < 1e-6,
            "{}",
            found.edge.height
        );
        assert!(found.edge.evidence <= Evidence::Path);
        // Or the test would say nothing.
        settings.path.insertions = 0;
        let blind = straight(&energy, ends, &settings).edge.height;
        assert!(blind < height - 0.3, "{blind}");
    }
}

#[test]
fn what_passes_through_the_object_is_marked_and_a_search_leads_around_it() {
    let energy = Ring(Euclidean::new(2));
    let minima = minima_below(&energy, &[vec![-0.9, -0.3], vec![0.9, -0.3]]);
    let ends = (&minima[0], &minima[1]);
    for method in METHODS {
        let mut settings = straight_only(1.0, 2.0, method);
        let threaded = straight(&energy, ends, &settings);
        assert_eq!(threaded.edge.evidence, Evidence::Chain);
        assert_eq!(
            threaded.invalid_reason.as_deref(),
            Some("through the object")
        );
        assert!(threaded.edge.height < 0.6);
        settings.searches = 2;
        let run = Run::default();
        let map = build_landscape(&energy, &Guide(&energy), minima.clone(), &settings, &run);
        let mut map = map.unwrap();
        assert!(map.attempts.of_merges(&map.tree)[2].is_some());
        let around = map.connections.remove(0);
        assert_eq!(around.invalid_reason, None);
        assert_eq!(around.edge.evidence, Evidence::Saddle);
        assert!(around.edge.height > 1.5 && around.edge.height < 1.7);
        assert_eq!(around.edge.term.as_deref(), Some("height"));
    }
}

#[test]
fn rotations_are_met_by_their_nearest_way_alone_where_it_is_much_shorter() {
    // A quarter turn: the other way is three times as long.
    let energy = Wells {
        space: Rotation::new(1.0),
        centres: vec![
            vec![1.0, 0.0, 0.0, 0.0],
            vec![0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0, 0.0],
        ],
        width: PI / 6.0,
    };
    let minima = minima_below(&energy, &energy.centres);
    let settings = straight_only(0.3, PI / 2.0, PathMethod::String);
    let found = straight(&energy, (&minima[0], &minima[1]), &settings);
    assert_eq!(found.start, Some(Start::Straight));
    assert_eq!(found.edge.evidence, Evidence::Saddle);
    assert!((found.edge.length - PI / 2.0).abs() < 0.05);
}
