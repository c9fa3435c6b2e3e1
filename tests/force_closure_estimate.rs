//! Figure 2, compared with an independent computation with another random generator: μ₀ and ‖Gc‖ of each set, and
//! statistics of half a million sets.
#![cfg(feature = "grasp")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use landscape::grasp::closure::{least_friction, net_wrench};
use nalgebra::Vector3;
use serde_json::Value;
use sets::Fit;

#[path = "../analysis/force_closure_estimate/sets.rs"]
mod sets;

fn reference() -> Value {
    serde_json::from_str(include_str!("reference/three_contacts_sphere.json")).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn set_by_set() {
    let reference = reference();
    let samples = reference["samples"].as_array().unwrap();
    assert_eq!(samples.len(), 300);
    for sample in samples {
        let point = |point: &Value| Vector3::from_fn(|k, _| number(&point[k]));
        let points: Vec<_> = sample["points"]
            .as_array()
            .unwrap()
            .iter()
            .map(point)
            .collect();
        let contacts = sets::contacts(&points);
        let (friction, expected) = (least_friction(&contacts), number(&sample["mu0"]));
        assert!(
            (friction - expected).abs() < 1e-9 * expected.max(1.0),
            "{friction}, expected {expected}"
        );
        assert!((net_wrench(&contacts) - number(&sample["gc_norm"])).abs() < 1e-12);
    }
}

/// Tolerances are about four standard errors of the difference of two samples of this size.
#[test]
fn half_a_million_sets() {
    let reference = reference();
    let sets = sets::threes(500_000);
    for told in reference["fits_by_mu0_max"].as_array().unwrap() {
        let limit = told["mu0_max"].as_f64().unwrap_or(f64::INFINITY);
        let fit = Fit::up_to(&sets, limit);
        let near = |found: f64, key: &str, tolerance: f64| {
            let expected = number(&told[key]);
            assert!(
                (found - expected).abs() < tolerance,
                "μ₀ ≤ {limit}: {key} = {found}, expected {expected}"
            );
        };
        near(fit.sets as f64, "n", 2500.0);
        // μ₀ of all sets has no variance: single sets with a large one decide.
        if limit <= 3.0 {
            near(
                fit.through_origin,
                "slope_through_origin",
                0.006 * fit.through_origin,
            );
            near(
                fit.slope,
                "affine_slope",
                if limit > 0.25 { 0.015 } else { 0.08 },
            );
            near(fit.offset, "affine_intercept", 0.01);
            near(fit.correlation, "pearson", 0.01);
        }
    }
    // The paper's slope, where the reference has it.
    let limit = sets::limit_with_slope(&sets, 4.035, [0.1, 3.0]);
    assert!((limit - 0.47846).abs() < 0.002, "{limit}");
    for bin in reference["bins"].as_array().unwrap() {
        let [low, high] = ["lo", "hi"].map(|key| number(&bin[key]));
        let mut found: Vec<f64> = sets
            .iter()
            .filter(|set| (low..high).contains(&set.least_friction))
            .map(|set| set.net_wrench)
            .collect();
        found.sort_by(f64::total_cmp);
        for (percent, at) in [(5, 1), (50, 2), (95, 3)] {
            let value = found[found.len() * percent / 100];
            let expected = number(&bin["gc_percentiles_0_5_50_95_100"][at]);
            assert!(
                (value - expected).abs() < 0.015,
                "{percent} % for μ₀ in [{low}, {high}): {value}, expected {expected}"
            );
        }
        // No set lies below the equilateral triangle of its μ₀.
        let least = 3.0 * low / libm::hypot(1.0_f64, low);
        assert!(found[0] >= least - 1e-9, "{} below {least}", found[0]);
    }
    // What passes the relaxed test needs little friction; of what friction 0.5 holds it keeps one in twenty-five.
    let closed = || sets.iter().filter(|set| set.closed[0]);
    let kept = closed().filter(|set| set.net_wrench < 0.5).count();
    let share = kept as f64 / closed().count() as f64;
    assert!((share - 0.040).abs() < 0.002, "{share}");
    let wider = closed().filter(|set| set.net_wrench < 0.5_f64.sqrt());
    let share = wider.count() as f64 / closed().count() as f64;
    assert!((share - 0.112).abs() < 0.004, "{share}");
}
