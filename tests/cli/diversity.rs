//! Which of several planted populations is more diverse, from their files.

use std::fs;

use crate::desk::{Desk, assert_says};
use crate::{names, thirty_grasps};
use landscape::evaluation::Diversity;
use landscape::store::{AtomicFolder, GraspFile, Overrides};
use serde_json::Value;

/// Writes `grasps` real grasps with these labels of a human in turn. If they are `alike`, all are the same grasp.
pub(super) fn plant(desk: &Desk, name: &str, grasps: usize, labels: &[&str], alike: bool) {
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/data/grasps.parquet");
    let (mut file, _) = GraspFile::read(data.as_ref(), Overrides::default()).unwrap();
    file.grasps.truncate(grasps);
    let first = file.grasps[0].grasp.clone();
    for (row, grasp) in file.grasps.iter_mut().enumerate() {
        grasp.label = Some(labels[row % labels.len()].to_owned());
        if alike {
            grasp.grasp = first.clone();
        }
    }
    file.write(&desk.path(name)).unwrap();
}

/// The value of order `order` of a set, in the measure of this name.
fn value(found: &Value, of: &str, set: usize, order: usize) -> f64 {
    let measures = found["measures"].as_array().unwrap().iter();
    let mut measures = measures.filter(|measure| measure["of"] == of);
    let measure = measures.next().unwrap();
    measure["sets"][set][order]["value"].as_f64().unwrap()
}

#[test]
fn planted_grasps_have_the_types_and_contacts_that_were_planted() {
    let desk = Desk::empty();
    let six = [
        "Medium Wrap",
        "Tripod",
        "Palmar Pinch",
        "Lateral",
        "Ring",
        "Quadpod",
    ];
    plant(&desk, "wide.parquet", 60, &six, false);
    plant(&desk, "narrow.parquet", 48, &["Tripod"], true);
    let line = "diversity narrow.parquet wide.parquet --resamplings 50";
    let text = desk.print(line);
    let answer = "wide.parquet is the more diverse by types, cells and sets of contact regions: it has 5.9 times as many \
                  effective types as narrow.parquet (order 1, 95 % interval 4.5 to 7.8";
    assert_says(
        &text,
        &[
            answer,
            "wide.parquet has no map, so families are left out; `landscape build wide.parquet` makes one",
            "narrow.parquet (48 grasps)",
            "| wide.parquet to narrow.parquet |",
            "all 48 grasps of narrow.parquet are of one kind by types",
            "each set also depends on how its grasps were drawn",
            "For a paper: By Hill numbers of order 1",
        ],
    );
    assert!(text.lines().nth(2).unwrap().starts_with(answer), "{text}");

    let found = desk.json("narrow.diversity.json");
    assert!(
        found["measures"]
            .as_array()
            .unwrap()
            .iter()
            .all(|m| m["grasps"] == 48)
    );
    for order in 0..3 {
        for of in ["types", "cells", "contacts"] {
            assert!((value(&found, of, 0, order) - 1.0).abs() < 1e-9);
        }
    }
    let endings = ["json", "md", "png", "svg"];
    let files = endings.map(|ending| format!("narrow.diversity.{ending}"));
    let first = files.each_ref().map(|name| desk.bytes(name));
    desk.succeed(&format!("{line} --threads 1 -q"));
    let again = files.each_ref().map(|name| desk.bytes(name));
    assert!(first == again, "the same bytes on every run");
    let printed = desk.document(&format!("{line} --json -q"));
    assert_eq!(printed, found);
}

#[test]
fn too_few_grasps_are_refused() {
    let desk = Desk::empty();
    plant(&desk, "few.parquet", 29, &["Tripod"], false);
    plant(&desk, "many.parquet", 30, &["Tripod"], false);
    let sentence = desk.early_mistake("diversity many.parquet few.parquet");
    assert_says(
        &sentence,
        &[
            "few.parquet has 29 grasps (1 too few); at least 30",
            "landscape join",
        ],
    );
    plant(&desk, "fewer.parquet", 7, &["Tripod"], false);
    let sentence = desk.early_mistake("diversity few.parquet many.parquet fewer.parquet");
    let expected =
        "few.parquet has 29 grasps (1 too few) and fewer.parquet has 7 grasps (23 too few)";
    assert_says(&sentence, &[expected]);
    fs::remove_file(desk.path("fewer.parquet")).unwrap();
    let sentence = desk.early_mistake("diversity many.parquet --resamplings 3");
    assert_says(&sentence, &["--resamplings 3", "from 20"]);
    let line = "diversity many.parquet -q --resamplings 20";
    desk.write("many.diversity.md", "a thesis");
    let sentence = desk.early_mistake(line);
    assert_says(&sentence, &["many.diversity.md", "--force"]);
    desk.succeed(&format!("{line} --force"));
    desk.succeed(line);
    let expected = ["json", "md", "png", "svg"].map(|ending| format!("many.diversity.{ending}"));
    let made = names(desk.folder.path());
    assert!(expected.iter().all(|name| made.contains(name)), "{made:?}");
    assert_eq!(made.len(), 2 + 4);
}

/// Families at different levels are shown, but not compared, and `diff` warns, too. A given level holds for all.
#[test]
fn families_at_different_levels_are_not_compared() {
    let desk = Desk::empty();
    desk.succeed("surface double-well 3 --family-barrier 0 --no-report -q -o wells.landscape");
    for (name, barrier) in [("even", 0.05), ("other", 0.1)] {
        let mut files = desk.landscape("wells.landscape");
        for (row, first) in files.minima.iter_mut().zip((0..).step_by(10)) {
            row.members = (first..first + 10).collect();
        }
        files.manifest.family_barrier = Some(barrier);
        files.manifest.letting_go = Some(1.0);
        let folder = AtomicFolder::open(&desk.path(&format!("{name}.landscape")), true).unwrap();
        files.write(&folder).unwrap();
        folder.finish().unwrap();
    }
    let both = "even.landscape other.landscape";
    desk.succeed(&format!("diversity {both} -q -o found"));
    let found = desk.json("found.json");
    assert!((value(&found, "families", 0, 1) - 8.0).abs() < 1e-9);
    let notes = found["notes"].to_string();
    let expected = [
        "5.0 % of the cost of letting go",
        "10.0 %",
        "cannot be compared",
    ];
    assert_says(&notes, &expected);
    assert_says(&notes, &["even.landscape is not a landscape of grasps"]);
    let note = "the families of even.landscape";
    assert_says(
        &desk.print(&format!("diff {both}")),
        &[note, "--family-barrier"],
    );
    desk.succeed(&format!("diversity {both} --family-barrier 0 -q -o found"));
    let notes = desk.json("found.json")["notes"].to_string();
    assert!(!notes.contains("cannot be compared"), "{notes}");
}

/// What a survey counts, `diversity` counts as well, and `synth` said before.
#[test]
fn sets_of_contact_regions_have_one_definition() {
    let desk = Desk::empty();
    desk.write("many.parquet", thirty_grasps());
    desk.succeed("diversity many.parquet --resamplings 20 -q -o found");
    let observed = value(&desk.json("found.json"), "contacts", 0, 0);
    desk.succeed("survey many.parquet --no-map -q -o found.survey");
    let survey = desk.json("found.survey/survey.json");
    let sets = survey["populations"][0]["contacts"].as_object().unwrap();
    assert!(sets.len() > 1);
    assert!(
        (observed - sets.len() as f64).abs() < 1e-9,
        "{observed} {sets:?}"
    );
    let file = desk.grasps("many.parquet");
    let population = &file.landscapes()[0];
    let (hand, object) = (population.hand().unwrap(), population.object().unwrap());
    let grasps = file.grasps.iter().map(|row| &row.grasp);
    let told = Diversity::of(&hand, &object, grasps).unwrap();
    assert_eq!(told.contact_region_sets, sets.len(), "what `synth` tells");
    let text = desk.text("found.survey/summary.md");
    assert_says(
        &text,
        &[
            "| sets of contact regions |",
            &format!("sets of contact regions: {} observed", sets.len()),
        ],
    );
}
