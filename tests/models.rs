//! The reference surfaces at all stationary points of `tests/reference/landscapes.json`.

use landscape::energy::Energy;
use landscape::energy::model::{LennardJones, MullerBrown, ThreeHole};
use landscape::space::{Cluster, Space};
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::Value;

fn reference() -> Value {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/reference/landscapes.json"
    );
    let text = std::fs::read_to_string(path).expect("the reference file is part of the repository");
    serde_json::from_str(&text).expect("it is JSON")
}

fn numbers(values: &Value) -> Vec<f64> {
    serde_json::from_value(values.clone()).expect("coordinates are a flat list of numbers")
}

/// The points were solved to |∇V| < 1e-9 with exact Hessians and printed to full precision. Rounding of the coordinates
/// times the largest curvature (4000), and rounding of energies of 150, give a tolerance of 1e-8.
fn assert_stationary(name: &str, energy: &dyn Energy, x: &[f64], value: f64) {
    let mut gradient = vec![f64::NAN; x.len()];
    let found = energy.evaluate(x, &mut gradient);
    assert!(
        (found - value).abs() < 1e-8,
        "{name}: {found} instead of {value}"
    );
    assert!(
        gradient.iter().all(|g| g.abs() < 1e-8),
        "{name}: {gradient:?}"
    );
}

#[test]
fn plane_surfaces_are_stationary_where_they_should_be() {
    let reference = reference();
    let surfaces: [(&str, &dyn Energy); 2] = [
        ("muller_brown", &MullerBrown::new()),
        ("three_hole", &ThreeHole::new()),
    ];
    for (name, energy) in surfaces {
        let mut points = 0;
        for kind in ["minima", "saddles", "maxima"] {
            for point in reference[name][kind].as_array().unwrap() {
                assert_stationary(
                    name,
                    energy,
                    &numbers(&point["x"]),
                    point["energy"].as_f64().unwrap(),
                );
                points += 1;
            }
        }
        assert!(points >= 5, "{name}: {points} points");
    }
}

/// Lennard-Jones minima and saddles are stationary. Equivalent copies of a point are recognised as equal, and different
/// points are not.
#[test]
fn clusters_are_stationary_and_distinct() {
    let reference = reference();
    for (atoms, saddles) in [(4, 1), (5, 2), (6, 3), (7, 12)] {
        let (name, energy, space) = (
            format!("LJ{atoms}"),
            LennardJones::new(atoms),
            Cluster::new(atoms),
        );
        let cluster = &reference[&name];
        let mut points: Vec<Vec<f64>> = Vec::new();
        for (coordinates, list) in [("minima_coords", "minima"), ("ts_coords", "ts")] {
            let values = cluster[list].as_array().unwrap();
            for (x, entry) in cluster[coordinates].as_array().unwrap().iter().zip(values) {
                let value = entry
                    .as_f64()
                    .unwrap_or_else(|| entry["energy"].as_f64().unwrap());
                points.push(numbers(x));
                assert_stationary(&name, &energy, &points[points.len() - 1], value);
            }
        }
        assert_eq!(cluster["ts_coords"].as_array().unwrap().len(), saddles);
        for (i, a) in points.iter().enumerate() {
            // The search stops at 1e-8 of the size: these clusters are symmetric only to 1e-12.
            let distance = space.distance(a, &disguised(a));
            assert!(distance < 1e-7, "{name}: {i} is {distance} from itself");
            for (j, b) in points[..i].iter().enumerate() {
                let distance = space.distance(a, &disguised(b));
                assert!(distance > 0.1, "{name}: {i} and {j} are {distance} apart");
            }
        }
    }
}

/// The cluster rotated, moved, mirrored, and with its atoms in reverse order.
fn disguised(x: &[f64]) -> Vec<f64> {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.7, -1.9, 1.1));
    let atoms = x.chunks_exact(3).rev().map(Vector3::from_column_slice);
    atoms
        .flat_map(|atom| (turn * -atom + Vector3::new(3.0, -1.0, 2.0)).data.0[0])
        .collect()
}
