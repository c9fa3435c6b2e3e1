//! The fixtures of the taxonomy match their descriptions: contacts touch and nothing penetrates.
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

#[path = "taxonomy/fixture.rs"]
mod fixture;
#[path = "taxonomy/shape.rs"]
mod shape;

use fixture::Fixture;
use landscape::evaluation::taxonomy::{Labeller, Rule, Taxonomy, Verdict};
use landscape::hand::{Hand, PosedHand};
use landscape::object::{Assembly, Object, Shape};
use rayon::prelude::*;

/// Largest distance of a contact, metres; a finger pad yields by as much.
const TOUCHING_M: f64 = 2e-3;
/// Largest depth of penetration, metres.
const DEEPEST_M: f64 = 3e-3;

/// Shares that the rule must reach at least: the category, the cell and the type of the answer are right.
const RIGHT: [f64; 3] = [0.93, 0.88, 0.82];
/// Largest share of poses outside the taxonomy that are given a type.
const OTHERS: f64 = 0.12;

fn read(half: &str) -> Vec<Fixture> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/taxonomy/fixtures");
    serde_json::from_str(&std::fs::read_to_string(format!("{folder}/{half}.json")).unwrap())
        .unwrap()
}

/// The distance of the best type from the true one (see `GraspType::distance`), and whether a type or a cell is assigned.
fn judge(hand: &Hand, fixture: &Fixture) -> (Option<u8>, bool) {
    let assembly = Assembly {
        parts: fixture.object.clone(),
        ..Assembly::default()
    };
    let (mesh, description) = assembly.object(&fixture.id).unwrap();
    let object = Object::from_mesh(&fixture.id, mesh, &description).unwrap();
    let x = fixture.coordinates(hand).unwrap();
    let label = Labeller::new(hand, &object, Rule::standard()).label(&x);
    let entry = |number: u8| Taxonomy::feix().numbered(number);
    let found = label.best.first().and_then(|best| entry(best.number));
    let truth = fixture.kind.and_then(entry);
    let apart = truth.zip(found).map(|(truth, found)| truth.distance(found));
    let assigned = matches!(
        label.verdict,
        Verdict::Listed(_) | Verdict::Ambiguous(_) | Verdict::Broad(_)
    );
    (apart, assigned)
}

/// Compares the rule on these fixtures with its targets.
fn reaches_targets(fixtures: Vec<Fixture>) {
    let hand = Hand::human();
    let judged = |fixture: Fixture| (judge(&hand, &fixture), fixture);
    let judged: Vec<((Option<u8>, bool), Fixture)> = fixtures.into_par_iter().map(judged).collect();
    let share = |known: bool, passes: &dyn Fn(Option<u8>, bool) -> bool| {
        let of = judged.iter().filter(|(_, f)| f.kind.is_some() == known);
        let passing = of.clone().filter(|((a, b), _)| passes(*a, *b)).count();
        passing as f64 / of.count() as f64
    };
    let within = |most: u8| share(true, &|apart, _| apart.is_some_and(|apart| apart <= most));
    let right = [3, 1, 0].map(within);
    let others = share(false, &|_, assigned| assigned);
    let wrong = judged
        .iter()
        .filter(|((apart, _), f)| f.kind.is_some() && *apart != Some(0));
    let wrong: Vec<&str> = wrong.map(|(_, fixture)| fixture.id.as_str()).collect();
    assert!(
        right
            .iter()
            .zip(RIGHT)
            .all(|(found, least)| *found >= least)
            && others <= OTHERS,
        "category, cell, type right {right:.3?}, others accepted {others:.3}; another type: {wrong:?}"
    );
}

/// The files of fixtures.
const FILES: [&str; 3] = ["development", "held_out", "second_held_out"];

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
            let [low, high] = joint.limits;
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
    reaches_targets(simple);
}

/// The fixtures on which the rule was checked while it was written, and those that were opened once, when it was final. They
/// must not be used to choose a rule.
#[test]
#[ignore = "minutes where the fields of unions are not cached yet"]
fn the_rule_names_every_fixture() {
    reaches_targets(
        ["development", "held_out"]
            .into_iter()
            .flat_map(read)
            .collect(),
    );
    reaches_targets(read("second_held_out"));
}
