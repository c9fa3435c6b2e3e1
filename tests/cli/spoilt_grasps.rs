//! The messages of mistakes in a file of grasps that need the whole program; `tests/store/refusals.rs` has those of the reader.

use crate::desk::{Desk, assert_says};
use crate::landscape;
use crate::parts::Parts;
use crate::table::rows;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt32Type};
use arrow_array::{
    ArrayRef, BooleanArray, FixedSizeListArray, Float64Array, ListArray, StringArray,
};
use landscape::store::GraspRow;
use serde_json::{Value, json};

#[test]
fn joint_beyond_its_limit_as_published() {
    let (name, [_, upper]) = first_joint();
    let desk = Desk::with_grasps();
    let parts = Parts::of(&desk.path("g.parquet"));
    let lists = change(&parts, "joints", |row, values| {
        if row == 1 {
            values[0] = upper + 0.58;
        }
    });
    parts.set("joints", lists).write(&desk.path("g.parquet"));
    let said = desk.succeed("build g.parquet --first 2 --no-report");
    let warning = format!(
        "farthest is `{name}` in row 1, by 0.5800 rad, or m if it slides; they are kept as they are"
    );
    assert_says(&said, &["warning: ", &warning]);
    let files = desk.landscape("g.landscape");
    assert!(
        files
            .manifest
            .warnings
            .iter()
            .any(|told| told.ends_with(&warning)),
        "{:?}",
        files.manifest.warnings
    );
    assert_eq!(files.manifest.counts.grasps, 2, "kept");
}

#[test]
fn what_is_described_must_be_what_is_there() {
    type Spoil = fn(&mut Value);
    let cases: [(Spoil, &str); 6] = [
        (
            |file| file["hands"][0]["joint_names"][0] = json!("elbow"),
            "spoilt.parquet: hand `human` does not match | `elbow`",
        ),
        (
            |file| file["hands"][0]["surface_points"] = json!(5000),
            "spoilt.parquet: hand `human` does not match | 5000 surface points",
        ),
        (
            |file| file["hands"][0]["surface_hash"] = json!("0"),
            "spoilt.parquet: hand `human` does not match | placed the surface points | --hand",
        ),
        (
            |file| file["hands"][0]["description"] = json!([]),
            "spoilt.parquet: the file does not describe hand `human` | --hand",
        ),
        (
            |file| file["objects"][0]["mesh_obj"] = json!(null),
            "spoilt.parquet | mesh of object `ball` | --object",
        ),
        (
            |file| file["objects"] = json!([]),
            "spoilt.parquet | `ball` | described",
        ),
    ];
    for (spoil, words) in cases {
        let sentence = Desk::refusal(|parts| metadata(parts, spoil));
        assert_says(&sentence, &rows(words).next().unwrap());
    }
}

/// Contacts are numbers of surface points, so a program with other points chooses them anew if it is told to.
#[test]
fn contacts_are_chosen_anew_for_other_surface_points() {
    let desk = Desk::with_grasps();
    let grasps = Parts::of(&desk.path("g.parquet"));
    let mut grasps = metadata(grasps, |value| {
        value["hands"][0]["surface_hash"] = json!("0");
    });
    // Contacts of other points mean nothing here.
    let lists = (0..6).map(|_| Some([0, 1, 2, 3].map(Some)));
    let lists = ListArray::from_iter_primitive::<UInt32Type, _, _>(lists);
    grasps = grasps.set("contacts", lists);
    grasps.write(&desk.path("other.parquet"));
    let sentence = desk.early_mistake("label other.parquet -o t.parquet");
    assert_says(&sentence, &["placed the surface points", "--hand"]);
    desk.succeed("label other.parquet --hand human -q -o anew.parquet");
    let [old, new] = ["g.parquet", "anew.parquet"].map(|name| desk.grasps(name));
    assert_eq!((old.grasps.len(), new.grasps.len()), (6, 6));
    for (old, new) in old.grasps.iter().zip(&new.grasps) {
        assert_eq!(old.grasp.pose, new.grasp.pose);
        assert_ne!(new.grasp.contacts, [0, 1, 2, 3]);
    }
    desk.succeed("inspect anew.parquet -q");
}

#[test]
fn one_grasp_only() {
    let sentence = Desk::refusal(|mut parts| {
        for (_, array) in &mut parts.columns {
            *array = array.slice(0, 1);
        }
        parts
    });
    assert_says(
        &sentence,
        &["spoilt.parquet: there is only one grasp", "at least two"],
    );
    let desk = Desk::with_grasps();
    let cases = "
        build absent/g.parquet | no such file: absent/g.parquet
        build g.parquet --first 1 | --first 1 | at least two
        build g.parquet --first 0 | --first 0 | at least two
        build g.parquet --object teapot | --object teapot | ball
        build g.parquet --hand claw | --hand claw | human
    ";
    for case in rows(cases) {
        assert_says(&desk.early_mistake(case[0]), &case[1..]);
    }
}

#[test]
fn identical_grasps() {
    let desk = Desk::with_grasps();
    let mut file = desk.grasps("g.parquet");
    let first = file.grasps[0].clone();
    file.grasps = (0..4)
        .map(|id| GraspRow {
            id,
            ..first.clone()
        })
        .collect();
    file.write(&desk.path("same.parquet")).unwrap();
    assert_says(
        &desk.mistake("build same.parquet"),
        &["same.parquet: all 4 grasps lie in one minimum"],
    );
    assert!(!desk.path("same.landscape").exists());
    assert!(!desk.path("same.landscape.partial").exists());
}

/// Another program moved a hand, wrote down what it liked, and left no checksum.
#[test]
fn measures_that_are_not_those_of_the_poses_are_computed_anew() {
    let desk = Desk::with_grasps();
    let parts = Parts::of(&desk.path("g.parquet"));
    let moved = change(&parts, "translation_m", |row, values| {
        if row == 1 {
            for value in values.iter_mut() {
                *value += 0.05;
            }
        }
    });
    let with = |name: &str, row: usize, value: f64| {
        let mut values = parts.floats(name);
        values[row] = value;
        Float64Array::from(values)
    };
    let (energy, epsilon, term) = (
        with("energy", 1, 0.001),
        with("epsilon", 1, 0.9),
        with("term_prior", 3, 1e308),
    );
    parts
        .set("translation_m", moved)
        .set("energy", energy)
        .set("epsilon", epsilon)
        .set("term_prior", term)
        .set("stable", BooleanArray::from(vec![true; 6]))
        .set("label_auto", StringArray::from(vec!["Tripod"; 6]))
        .write(&desk.path("lie.parquet"));
    let output = desk.run("inspect lie.parquet --json");
    let said = String::from_utf8(output.stderr).unwrap();
    assert_says(
        &said,
        &[
            "warning: the measures of 2 of 6 grasps in the file are not those of their poses (row 1: `energy` is 0.0010, computed ",
            "computed ones are used; 2 outcomes of simulations and 2 labels by the rule are left out",
            "warning: the outcomes of simulations (4 of 6 grasps) are not verified",
        ],
    );
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    for row in [1, 3] {
        let grasp = &told["grasps"][row];
        let terms = grasp["terms"].as_object().unwrap().values();
        let sum: f64 = terms.map(|value| value.as_f64().unwrap()).sum();
        let energy = grasp["energy"].as_f64().unwrap();
        assert!(energy > 0.01 && (energy - sum).abs() < 1e-9, "{grasp}");
    }
    desk.succeed("label lie.parquet -q -o labelled.parquet");
    let read = |name: &str| desk.grasps(name).grasps;
    let (whole, labelled) = (read("g.parquet"), read("labelled.parquet"));
    let stable = |row: &GraspRow| row.stable;
    let outcomes: Vec<_> = labelled.iter().map(stable).collect();
    let held = Some(true);
    assert_eq!(outcomes, [held, None, held, None, held, held]);
    assert!(labelled[1].epsilon < Some(0.1));
    for row in [0, 2, 4, 5] {
        assert_eq!(labelled[row].energy.to_bits(), whole[row].energy.to_bits());
    }
    // Outcomes alone are not read from such a file.
    let line = format!(
        "report {} --stability lie.parquet",
        landscape().path("g.landscape").display()
    );
    assert_says(
        &desk.early_mistake(&line),
        &[
            "lie.parquet was written by another program",
            "landscape stability",
        ],
    );
}

/// The file with its metadata changed.
fn metadata(mut parts: Parts, change: impl FnOnce(&mut Value)) -> Parts {
    let mut value = serde_json::from_str(parts.metadata.as_ref().unwrap()).unwrap();
    change(&mut value);
    parts.metadata = Some(value.to_string());
    parts
}

/// A column of vectors with its rows changed.
fn change(
    parts: &Parts,
    name: &str,
    mut change: impl FnMut(usize, &mut [f64]),
) -> FixedSizeListArray {
    let (_, array): &(String, ArrayRef) = parts
        .columns
        .iter()
        .find(|(column, _)| column == name)
        .unwrap();
    let lists = array.as_fixed_size_list();
    let width = usize::try_from(lists.value_length()).unwrap();
    let mut values = lists
        .values()
        .as_primitive::<Float64Type>()
        .values()
        .to_vec();
    for (row, vector) in values.chunks_mut(width).enumerate() {
        change(row, vector);
    }
    let rows = values
        .chunks(width)
        .map(|row| Some(row.iter().copied().map(Some).collect::<Vec<_>>()));
    let length = lists.value_length();
    FixedSizeListArray::from_iter_primitive::<Float64Type, _, _>(rows, length)
}

fn first_joint() -> (String, [f64; 2]) {
    let desk = Desk::with_grasps();
    let file = desk.grasps("g.parquet");
    let hand = &file.metadata.hands[0];
    (hand.joint_names[0].clone(), hand.limits[0])
}
