//! Planted data sets.

use super::*;
use serde_json::json;

use crate::figure::testing::{assert_legible, gallery};

fn counts(kinds: &[(&str, usize)]) -> KindCounts {
    let kinds = kinds.iter();
    kinds
        .map(|(name, count)| ((*name).to_owned(), *count))
        .collect()
}

/// A population whose types are also its families, which touch with the digits of `contacts`.
fn population(
    hand: &str,
    object: &str,
    types: &[(&str, usize)],
    contacts: &[(&str, usize)],
) -> SurveyedPopulation {
    let grasps = types.iter().map(|(_, count)| count).sum();
    let families = contacts.iter().map(|(contacts, grasps)| SurveyedFamily {
        grasps: *grasps,
        contacts: (*contacts).to_owned(),
    });
    SurveyedPopulation {
        name: format!("{hand}/{object}"),
        file: format!("{hand}/{object}.parquet"),
        hand: hand.to_owned(),
        object: object.to_owned(),
        scale: 1.0,
        grasps,
        simulated: 0,
        held: 0,
        types: Some(counts(types)),
        cells: Some(counts(&[("power/palm/2-5/abducted", grasps)])),
        contacts: contacts
            .iter()
            .fold(KindCounts::new(), |mut sum, (name, count)| {
                *sum.entry((*name).to_owned()).or_insert(0) += count;
                sum
            }),
        map: Some(SurveyedMap {
            minima: contacts.len(),
            families: families.collect(),
            level: FamilyLevel {
                barrier: 0.05,
                letting_go: Some(1.0),
            },
            evaluations: 1,
        }),
        notes: Vec::new(),
    }
}

fn planted() -> Survey {
    let all = "index, little, middle, palm, ring, thumb";
    Survey::new(
        vec![
            population(
                "left",
                "ball",
                &[("Power Sphere", 30), ("Tripod", 10)],
                &[(all, 30), ("index, middle, thumb", 10)],
            ),
            population(
                "left",
                "can",
                &[("Power Sphere", 20), ("Tripod", 5), ("Large Diameter", 15)],
                &[(all, 20), (all, 15), ("index, thumb", 5)],
            ),
            population(
                "left",
                "pen",
                &[("Writing Tripod", 60)],
                &[("index, middle, thumb", 60)],
            ),
            population("right", "ball", &[("Tripod", 35)], &[("index, thumb", 35)]),
        ],
        Vec::new(),
    )
}

#[test]
fn hands_are_pooled_and_objects_compared() {
    let survey = planted();
    let [left, right] = survey.hands.as_slice() else {
        panic!("two hands");
    };
    assert_eq!((left.grasps, right.grasps), (140, 35));
    let pooled = counts(&[
        ("Large Diameter", 15),
        ("Power Sphere", 50),
        ("Tripod", 15),
        ("Writing Tripod", 60),
    ]);
    assert_eq!(left.types.as_ref(), Some(&pooled));
    // Of the two other objects one has it, so a Large Diameter is usual for ball and pen.
    let missing: Vec<(&str, Vec<&str>)> = (left.missing_types.iter())
        .map(|(name, types)| (name.as_str(), types.iter().map(String::as_str).collect()))
        .collect();
    assert_eq!(
        missing,
        [
            ("left/ball", vec!["Large Diameter", "Writing Tripod"]),
            ("left/can", vec!["Writing Tripod"]),
            ("left/pen", vec!["Large Diameter", "Power Sphere", "Tripod"]),
        ]
    );
    assert!(right.missing_types.is_empty(), "nothing to compare with");
    // Of the six families only the pinch of the can is alone with its digits; the two wraps of the can share theirs with
    // the ball.
    assert_eq!(left.shared_families(), [5, 6]);
    assert_eq!(left.shared[0].populations, ["left/ball", "left/can"]);
    assert_eq!((left.shared[0].families, left.shared[0].grasps), (3, 65));
    assert_eq!(right.shared_families(), [0, 1]);
}

#[test]
fn effective_numbers_are_of_equal_samples() {
    let number = |counts: &[usize]| effective(counts.iter().copied());
    for order in number(&[35]).unwrap() {
        assert!((order - 1.0).abs() < 1e-9, "{order}");
    }
    // Two equal kinds are two, a little less in a sample of 30, whatever their number.
    let [two, four] = [[100, 100], [400, 400]].map(|counts| number(&counts).unwrap());
    assert!((1.94..2.0).contains(&two[1]), "{two:?}");
    assert!((two[1] - four[1]).abs() < 0.01, "{two:?} {four:?}");
    assert_eq!(number(&[29]), None, "nothing is extrapolated");
}

#[test]
fn different_levels_are_told() {
    assert!(planted().notes.is_empty());
    let mut populations = planted().populations;
    populations[3].map.as_mut().unwrap().level.barrier = 0.1;
    let survey = Survey::new(populations, Vec::new());
    assert_eq!(survey.notes.len(), 1, "{:?}", survey.notes);
}

#[test]
fn texts_and_tables_have_every_population() {
    let failure = SurveyFailure {
        file: "torn.parquet".to_owned(),
        reason: "it ends too early".to_owned(),
    };
    let named = SurveyFailure {
        file: "torn.parquet".to_owned(),
        reason: "set/torn.parquet ends too early".to_owned(),
    };
    assert_eq!(named.to_string(), named.reason);
    let survey = Survey::new(planted().populations, vec![failure]);
    let text = survey.markdown();
    for words in [
        "# Survey of 175 grasps: 2 hands on 3 objects",
        "sets of contact regions: 3 observed; about 0 more unseen",
        "| left | 3 | 140 | 4 of 33 | 1 of 17 | 3 | 6 | 5 |",
        "types of the taxonomy: 4 of 33",
        "families: 6 on all objects; 5 of them (83 %)",
        "torn.parquet: it ends too early",
        "Writing Tripod",
    ] {
        assert!(text.contains(words), "{words} is missing in {text}");
    }
    let lines = |csv: Vec<u8>| String::from_utf8(csv).unwrap().lines().count();
    assert_eq!(lines(survey.populations_csv()), 1 + 4);
    // Types, cells, sets of digits and families of each population.
    assert_eq!(
        lines(survey.kinds_csv()),
        1 + (2 + 1 + 2 + 2) + (3 + 1 + 2 + 3) + 4 + 4
    );
}

/// The document tells what the summary tells.
#[test]
fn the_document_has_the_numbers_of_the_summary() {
    let survey = planted();
    let told = survey.to_json();
    assert_eq!(told["objects"], 3);
    assert_eq!(told["hands"][0]["objects"], 3);
    assert_eq!(told["hands"][0]["shared_families"], json!([5, 6]));
    assert_eq!(
        told["hands"][0]["completeness"]["contacts"]["coverage"],
        1.0
    );
    let one = &told["populations"][0];
    // Simpson's closed form of 30 and 10 grasps at 30.
    let pairs = (30.0 * 29.0 + 10.0 * 9.0) / (40.0 * 39.0);
    let expected = 1.0 / (1.0 / 30.0 + 29.0 / 30.0 * pairs);
    for of in ["types", "contacts", "families"] {
        let found = one["effective"][of][2].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-9, "{of}: {found}");
    }
    assert_eq!(one["completeness"]["unseen"], 0.0);
    let table = String::from_utf8(survey.populations_csv()).unwrap();
    let head = table.lines().next().unwrap();
    assert!(head.ends_with(",contact_region_sets,effective_types_0,effective_types_1,effective_types_2,effective_families_0,\
        effective_families_1,effective_families_2,effective_contact_region_sets_0,effective_contact_region_sets_1,\
        effective_contact_region_sets_2"), "{head}");
    // Two sizes of one object are two.
    let mut populations = planted().populations;
    populations[3].scale = 2.0;
    let text = Survey::new(populations, Vec::new()).markdown();
    assert!(text.contains("2 hands on 4 objects"), "{text}");
}

#[test]
fn pictures_are_legible() {
    let survey = planted();
    for (name, chart) in [
        ("survey_types", survey.type_chart().unwrap()),
        ("survey_contacts", survey.contact_chart().unwrap()),
        ("survey_rarefaction", survey.rarefaction_chart()),
    ] {
        let canvas = chart.draw().unwrap();
        assert_legible(&canvas);
        gallery(&canvas, name);
    }
}
