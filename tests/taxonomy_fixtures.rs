//! The fixtures of the taxonomy match their descriptions: contacts touch and nothing penetrates.
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

#[path = "taxonomy/fixture.rs"]
mod fixture;
#[path = "taxonomy/judge.rs"]
mod judge;
#[path = "taxonomy/shape.rs"]
mod shape;
#[expect(
    dead_code,
    reason = "what only `pose_fixtures` calls makes widened fixtures"
)]
#[path = "taxonomy/widened.rs"]
mod widened;

use std::collections::BTreeMap;
use std::sync::LazyLock;

use fixture::Fixture;
use judge::{Case, Error, Noise, Outcome, cases, halves, judge, share};
use landscape::evaluation::taxonomy::Rule;
use landscape::hand::{Hand, PosedHand};
use landscape::object::Shape;
use widened::{HandName, Widened};

/// Largest distance of a contact, metres; a finger pad yields by as much.
const TOUCHING_M: f64 = 2e-3;
/// Largest depth of penetration, metres.
const DEEPEST_M: f64 = 3e-3;

fn read(half: &str) -> Vec<Fixture> {
    let path = format!(
        "{}/tests/taxonomy/fixtures/{half}.json",
        env!("CARGO_MANIFEST_DIR")
    );
    judge::read(path.as_ref()).unwrap()
}

/// Standard deviation of joint angles, radians. `COPIES` is the number of noisy poses of each fixture.
const NOISE_RAD: f64 = 0.1;
const COPIES: u64 = 10;

/// Shares that the rule must reach at least, as posed or with known contacts, and with moved hands: the category, the cell and
/// the type of the answer are right. Moved hands have other contacts, which the rule believes.
const RIGHT: [f64; 3] = [0.93, 0.88, 0.82];
const RIGHT_MOVED: [f64; 3] = [0.83, 0.69, 0.63];
/// Largest share of poses outside the taxonomy that are given a type.
const OTHERS: f64 = 0.12;

/// Compares the rule on these fixtures with its targets.
fn reaches_targets(fixtures: &[Case], noise: Noise) {
    let outcomes = judge(fixtures, Rule::standard(), noise).unwrap();
    let [known, others] = halves(&outcomes);
    let right = [3, 1, 0].map(|within| share(&known, |outcome| outcome.right(within)).unwrap());
    let accepted = share(&others, Outcome::accepted).unwrap();
    let wrong = known.iter().filter(|outcome| !outcome.right(0));
    let mut wrong: Vec<&str> = wrong.map(|outcome| outcome.id.as_str()).collect();
    wrong.dedup();
    let moved = noise.joints_rad > 0.0 && noise.error == Error::Moved;
    let least = if moved { RIGHT_MOVED } else { RIGHT };
    assert!(
        right
            .iter()
            .zip(least)
            .all(|(found, least)| *found >= least)
            && accepted <= OTHERS,
        "category, cell, type right {right:.3?}, others accepted {accepted:.3}; another type: {wrong:?}"
    );
}

/// The files of fixtures.
const FILES: [&str; 3] = ["development", "held_out", "second_held_out"];

/// The fixtures on which the rule was checked while it was written.
static DEVELOPMENT: LazyLock<Vec<Case>> = LazyLock::new(|| {
    let fixtures = ["development", "held_out"].into_iter().flat_map(read);
    cases(fixtures.collect()).unwrap()
});
/// Fixtures that were opened once, when the rule was final. They must not be used to choose a rule.
static HELD_OUT: LazyLock<Vec<Case>> = LazyLock::new(|| cases(read("second_held_out")).unwrap());

#[test]
fn what_touches_touches_and_nothing_is_inside() {
    let hand = Hand::human();
    let mut ids = Vec::new();
    for fixture in FILES.into_iter().flat_map(read) {
        let id = &fixture.id;
        let x = fixture.coordinates(&hand).unwrap();
        let shape = fixture.shape();
        let mut posed = PosedHand::default();
        hand.pose(&x, &mut posed);
        let distances: Vec<f64> = posed.points.iter().map(|p| shape.distance(p)).collect();
        for region in &fixture.touching {
            let own = shape::points(&hand, region);
            let gap = own.iter().map(|&i| distances[i].abs());
            let gap = gap.fold(f64::INFINITY, f64::min);
            assert!(gap < TOUCHING_M, "{id}: {region} is {gap} m away");
        }
        let deepest = distances.iter().copied().fold(0.0, f64::min);
        assert!(deepest > -DEEPEST_M, "{id} is {deepest} m deep");
        for (joint, q) in hand.joints.iter().zip(&x[7..]) {
            let [low, high] = joint.limits_rad;
            assert!(
                (low - 0.03..=high + 0.03).contains(q),
                "{id}: {}",
                joint.name
            );
        }
        ids.push(fixture.id);
    }
    let count = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), count);
}

/// A sample that is quick to prepare: objects that are one shape have no field to be baked.
#[test]
fn the_rule_names_a_sample_that_it_was_not_made_with() {
    let simple = read("second_held_out").into_iter();
    let simple: Vec<Fixture> = simple.filter(|fixture| fixture.object.len() == 1).collect();
    assert!(simple.len() > 60, "{} fixtures", simple.len());
    reaches_targets(&cases(simple).unwrap(), Noise::NONE);
}

/// Tests the fixtures without noise.
#[test]
#[ignore = "minutes where the fields of unions are not cached yet"]
fn the_rule_names_what_it_was_made_with() {
    reaches_targets(&DEVELOPMENT, Noise::NONE);
}

#[test]
#[ignore = "minutes where the fields of unions are not cached yet"]
fn the_rule_names_what_it_was_not_made_with() {
    reaches_targets(&HELD_OUT, Noise::NONE);
    reaches_targets(&HELD_OUT, noisy(Error::Misread));
}
