//! Grasps that are asked for, and those that a set lacks.

use std::collections::BTreeSet;

use crate::desk::{Desk, assert_says};
use landscape::evaluation::contact_regions;
use landscape::evaluation::taxonomy::{Labeller, Rule};
use landscape::hand::Hand;
use landscape::object::Object;
use landscape::space::{PoseSpace, Space};
use landscape::store::GraspFile;

fn poses(file: &GraspFile) -> Vec<Vec<f64>> {
    let rows = file.grasps.iter();
    rows.map(|row| row.grasp.pose.to_vec()).collect()
}

#[test]
fn grasps_are_what_was_asked_for() {
    let desk = Desk::empty();
    let line = "synth --object pen --types `palmar pinch` --grips thumb+index -n 4 --drop 0";
    let (answer, _) = desk.both(&format!("{line} -o one.parquet --threads 1"));
    desk.succeed(&format!("{line} -o two.parquet --threads 2 -q"));
    assert_eq!(desk.bytes("one.parquet"), desk.bytes("two.parquet"));
    assert_says(
        &answer,
        &["Palmar Pinch: ", "index+thumb: ", " of 2 chains"],
    );
    let file = desk.grasps("one.parquet");
    assert_says(
        &file.metadata.command,
        &["--types 'palmar pinch' --grips thumb+index"],
    );
    assert_eq!(file.metadata.settings["asked"][0]["type"], 9);
    let (hand, pen) = (Hand::human(), Object::named("pen").unwrap());
    let labeller = Labeller::new(&hand, &pen, Rule::standard());
    assert!(!file.grasps.is_empty());
    for row in &file.grasps {
        // Chains serve the wishes in turn.
        if row.id % 2 == 0 {
            assert_eq!(labeller.label(&row.grasp.pose).text(), "Palmar Pinch");
        } else {
            let touching = contact_regions(&hand, &pen, &row.grasp.pose);
            assert_eq!(touching, BTreeSet::from(["index", "thumb"]));
        }
    }
}

#[test]
fn what_cannot_be_found_is_said() {
    let desk = Desk::empty();
    let sentence = desk.mistake("synth --object ball --types Distal -n 1 --steps 1");
    assert_says(&sentence, &["Distal", "1 chain", "-n"]);
}

#[test]
fn a_set_gets_only_what_it_lacks() {
    let desk = Desk::with_grasps();
    let line = "synth --beyond g.parquet -n 12 --steps 2 --keep all --drop 0";
    let (answer, _) = desk.both(&format!("{line} -o one.parquet --threads 1"));
    desk.succeed(&format!("{line} -o two.parquet --threads 2 -q"));
    assert_eq!(desk.bytes("one.parquet"), desk.bytes("two.parquet"));
    assert_says(
        &answer,
        &["of 12 ends of 12 chains are new", "new touching: "],
    );
    let (known, new) = (
        poses(&desk.grasps("g.parquet")),
        poses(&desk.grasps("one.parquet")),
    );
    let ball = Object::named("ball").unwrap();
    let space = PoseSpace::new(Hand::human().pose_metric(), ball.symmetry.clone());
    for (place, x) in new.iter().enumerate() {
        for other in known.iter().chain(&new[..place]) {
            assert!(space.distance(x, other) > 0.005);
        }
    }
    // Within a metre of what is there nothing is new.
    let line = "synth --beyond g.parquet -n 8 --drop 0 --apart 1000 -o three.parquet";
    assert_says(&desk.mistake(line), &["--beyond", "none of ", "--apart"]);
}

#[test]
fn a_set_is_repaired_and_filled() {
    let desk = Desk::with_grasps();
    let line = "synth --from g.parquet --beyond g.parquet -n 4 --steps 2 --keep all --drop 0";
    let (answer, _) = desk.both(&format!("{line} -o more.parquet"));
    let (given, more) = (desk.grasps("g.parquet"), desk.grasps("more.parquet"));
    let count = given.grasps.len();
    assert_says(
        &answer,
        &[&format!("{count} of {count} given grasps pass the filter")],
    );
    assert!(more.grasps.len() > count);
    for (row, from) in more.grasps.iter().zip(&given.grasps) {
        assert!(
            row.source.ends_with(&format!("from {}", from.id)),
            "{}",
            row.source
        );
    }
    assert!(more.grasps[count].source.ends_with("--beyond"));
}
