//! Exact force closure, contact forces and ε, compared with published and independently computed contact sets.
#![cfg(feature = "grasp")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::f64::consts::TAU;

use landscape::grasp::closure::{
    PointContact, contact_forces, epsilon_of_wrenches, grasp_matrix_rank_margin, is_force_closure,
    least_friction, net_wrench,
};
use nalgebra::{Vector3, Vector6};
use serde_json::Value;

struct Case {
    id: String,
    contacts: Vec<PointContact>,
    told: Value,
}

impl Case {
    fn number(&self, key: &str) -> Option<f64> {
        self.told[key].as_f64()
    }
}

fn cases(text: &str) -> Vec<Case> {
    let file: Value = serde_json::from_str(text).unwrap();
    let vectors = |values: &Value| -> Vec<Vector3<f64>> {
        let numbers = |value: &Value| {
            let components = value
                .as_array()
                .unwrap()
                .iter()
                .map(|v| v.as_f64().unwrap());
            Vector3::from_iterator(components)
        };
        values.as_array().unwrap().iter().map(numbers).collect()
    };
    file["cases"]
        .as_array()
        .unwrap()
        .iter()
        .map(|case| Case {
            id: case["id"].as_str().unwrap().to_owned(),
            contacts: vectors(&case["points"])
                .into_iter()
                .zip(vectors(&case["axes"]))
                .map(|(arm, inward_normal)| PointContact { arm, inward_normal })
                .collect(),
            told: case.clone(),
        })
        .collect()
}

fn computed() -> Vec<Case> {
    cases(include_str!("reference/force_closure.json"))
}

fn analytic() -> Vec<Case> {
    cases(include_str!("reference/force_closure_analytic.json"))
}

fn all() -> impl Iterator<Item = Case> {
    computed().into_iter().chain(analytic())
}

fn check_friction(cases: &[Case]) {
    for case in cases {
        let (id, contacts) = (&case.id, &case.contacts);
        let expected = case.number("gc_norm").unwrap();
        assert!(
            (net_wrench(contacts) - expected).abs() < 1e-10,
            "{id}: net wrench"
        );
        if let Some(margin) = case.number("lambda_min_GGt") {
            let found = grasp_matrix_rank_margin(contacts);
            assert!((found - margin).abs() < 1e-9, "{id}: rank margin");
        }
        let friction = least_friction(contacts);
        match case.number("mu0") {
            Some(expected) => assert!(
                (friction - expected).abs() < 1e-6 * expected.max(1.0),
                "{id}: μ₀ = {friction}, expected {expected}"
            ),
            None => assert!(friction.is_infinite(), "{id}: μ₀ = {friction}, expected ∞"),
        }
    }
}

#[test]
fn computed_reference_sets() {
    let cases = computed();
    assert_eq!(cases.len(), 110);
    assert_eq!(
        cases
            .iter()
            .filter(|case| case.number("mu0").is_none())
            .count(),
        10
    );
    check_friction(&cases);
}

#[test]
fn analytic_reference_sets() {
    let cases = analytic();
    assert_eq!(cases.len(), 22);
    check_friction(&cases);
}

#[test]
fn forces_balance_from_the_least_friction_on() {
    for Case { id, contacts, .. } in all() {
        let least = least_friction(&contacts);
        if least.is_infinite() {
            assert!(contact_forces(&contacts, 100.0).is_none(), "{id}");
            continue;
        }
        for friction in [least, 1.001 * least + 1e-5, 1.1 * least + 0.1, least + 2.0] {
            let found = contact_forces(&contacts, friction).expect(&id);
            assert!(found.residual <= 1e-9, "{id}: ‖Gf‖ = {:e}", found.residual);
            assert!(
                found.violation <= 1e-7,
                "{id}: {:e} outside the cones",
                found.violation
            );
            let mut wrench = Vector6::zeros();
            let mut sum = 0.0;
            let mut outside = f64::NEG_INFINITY;
            for (contact, force) in contacts.iter().zip(&found.forces) {
                wrench += contact.wrench_of(force);
                let normal = contact.inward_normal.dot(force);
                let tangential = (force - contact.inward_normal * normal).norm();
                outside = outside.max(-normal).max(tangential - friction * normal);
                sum += normal;
            }
            assert!((wrench.norm() - found.residual).abs() < 1e-15);
            assert!((outside - found.violation).abs() < 1e-12, "{id}");
            assert!((sum - 1.0).abs() < 1e-9, "{id}: Σ f_n = {sum}");
            if friction > least {
                assert!(outside <= 1e-9, "{id}: {outside:e} outside at {friction}");
            }
        }
        if least > 0.01 {
            assert!(contact_forces(&contacts, 0.99 * least).is_none(), "{id}");
        }
    }
}

#[test]
fn closure_is_balance_and_rank() {
    for Case { id, contacts, .. } in computed() {
        let least = least_friction(&contacts);
        let spans = grasp_matrix_rank_margin(&contacts) > 1e-4;
        for friction in [0.1, 0.5, 1.0, 3.0] {
            // Nobody knows on the edge.
            if (friction - least).abs() > 1e-4 {
                let closes = is_force_closure(&contacts, friction);
                assert_eq!(closes, spans && least < friction, "{id} at {friction}");
            }
        }
    }
}

/// The reference hulls take the edges of their pyramids from the axes of the frame.
fn reference_wrenches(
    contacts: &[PointContact],
    centre: Vector3<f64>,
    scale: f64,
) -> Vec<Vector6<f64>> {
    contacts
        .iter()
        .flat_map(|contact| {
            let normal = contact.inward_normal;
            let mut axis = Vector3::zeros();
            axis[normal.iamin()] = 1.0;
            let first = normal.cross(&axis).normalize();
            let second = normal.cross(&first);
            let moved = PointContact {
                arm: (contact.arm - centre) * scale,
                ..*contact
            };
            (0..8).map(move |edge| {
                let (sine, cosine) = libm::sincos(TAU * f64::from(edge) / 8.0);
                moved.wrench_of(&(normal + (first * cosine + second * sine) * 0.5))
            })
        })
        .collect()
}

#[test]
fn epsilon_of_reference_sets() {
    let mut positive = 0;
    for case in computed() {
        let centroid =
            case.contacts.iter().map(|c| c.arm).sum::<Vector3<f64>>() / case.contacts.len() as f64;
        let scale = case.number("torque_scale_centroid").unwrap();
        for (name, centre, scale) in [
            ("epsilon_L1_origin", Vector3::zeros(), 1.0),
            ("epsilon_L1_centroid_scaled", centroid, scale),
        ] {
            let expected = case.number(name).unwrap();
            let wrenches = reference_wrenches(&case.contacts, centre, scale);
            let found = epsilon_of_wrenches(&wrenches);
            let id = &case.id;
            if expected > 0.0 {
                positive += 1;
                assert!(
                    (found.value - expected).abs() < 1e-9,
                    "{id}: {} for {expected}",
                    found.value
                );
            } else {
                assert!(found.value <= 0.0, "{id}: {} for {expected}", found.value);
            }
            // What is reached in the weakest direction proves that ε is not larger.
            let reached = wrenches
                .iter()
                .map(|wrench| wrench.dot(&found.weakest))
                .fold(f64::NEG_INFINITY, f64::max);
            // Outside the hull its nearest point comes from a cone programme.
            let tolerance = if expected > 0.0 { 1e-12 } else { 1e-5 };
            assert!((found.weakest.norm() - 1.0).abs() < 1e-9, "{id}");
            assert!(
                (reached - found.value).abs() < tolerance,
                "{id}: {reached} for {}",
                found.value
            );
        }
    }
    assert!(positive > 60, "{positive} sets with a positive ε");
}
