//! Exact force closure against published and independently computed contact sets.
#![cfg(feature = "grasp")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use landscape::grasp::closure::{
    PointContact, grasp_matrix_rank_margin, least_friction, net_wrench,
};
use nalgebra::Vector3;

fn cases(text: &str) -> Vec<(String, Vec<PointContact>, serde_json::Value)> {
    let file: serde_json::Value = serde_json::from_str(text).unwrap();
    let vector = |value: &serde_json::Value| {
        Vector3::from_iterator(
            value
                .as_array()
                .unwrap()
                .iter()
                .map(|v| v.as_f64().unwrap()),
        )
    };
    file["cases"]
        .as_array()
        .unwrap()
        .iter()
        .map(|case| {
            let points = case["points"].as_array().unwrap().iter().map(vector);
            let axes = case["axes"].as_array().unwrap().iter().map(vector);
            let contacts = points
                .zip(axes)
                .map(|(arm, inward_normal)| PointContact { arm, inward_normal })
                .collect();
            (
                case["id"].as_str().unwrap().to_owned(),
                contacts,
                case.clone(),
            )
        })
        .collect()
}

fn check(text: &str, expected_cases: usize) {
    let cases = cases(text);
    assert_eq!(cases.len(), expected_cases);
    for (id, contacts, case) in cases {
        assert!(
            (net_wrench(&contacts) - case["gc_norm"].as_f64().unwrap()).abs() < 1e-10,
            "{id}: net wrench"
        );
        let margin = case["lambda_min_GGt"].as_f64();
        if let Some(margin) = margin {
            assert!(
                (grasp_matrix_rank_margin(&contacts) - margin).abs() < 1e-9,
                "{id}: rank margin"
            );
        }
        let friction = least_friction(&contacts);
        match case["mu0"].as_f64() {
            Some(expected) => assert!(
                (friction - expected).abs() < 1e-5,
                "{id}: μ₀ = {friction}, expected {expected}"
            ),
            None => assert!(friction.is_infinite(), "{id}: μ₀ = {friction}, expected ∞"),
        }
    }
}

#[test]
fn computed_reference_sets() {
    check(include_str!("reference/force_closure.json"), 110);
}

#[test]
fn analytic_reference_sets() {
    check(include_str!("reference/force_closure_analytic.json"), 22);
}
