//! The message of every refusal of a file of grasps.

use std::fs;
use std::sync::Arc;

use crate::store::{file, names, of, place, read, sentence, with_joints};
use arrow_array::types::{Float64Type, Int32Type};
use arrow_array::{ArrayRef, Float64Array, Int64Array, ListArray, StringArray};
use landscape::store::{GraspFile, GraspRow};
use serde_json::json;

/// The message with which the writer refuses a grasp.
fn fault(spoil: impl FnOnce(&mut GraspRow)) -> String {
    let (folder, path) = place("grasps.parquet");
    let mut file = file(3);
    spoil(&mut file.grasps[2]);
    assert_eq!(file.faults().first().map(|(row, _)| *row), Some(2));
    let refused = file.write(&path).unwrap_err();
    assert!(
        names(folder.path()).is_empty(),
        "a refused file must leave nothing behind"
    );
    let text = sentence(&refused, folder.path());
    text.strip_prefix("grasps.parquet, row 2 (the first is 0): ")
        .expect(&text)
        .to_owned()
}

#[test]
fn rows_that_cannot_be_used_are_refused() {
    type Spoil = fn(&mut GraspRow);
    let cases: [(Spoil, &str); 17] = [
        (
            |grasp| grasp.energy = f64::NAN,
            "column `energy` contains NaN, which is not a finite number",
        ),
        (
            |grasp| grasp.terms[1] = f64::INFINITY,
            "column `term_distance` contains inf, which is not a finite number",
        ),
        (
            |grasp| grasp.friction = Some(f64::NEG_INFINITY),
            "column `friction` contains -inf, which is not a finite number",
        ),
        (
            |grasp| grasp.grasp.pose[2] = f64::NAN,
            "column `translation_m` contains NaN, which is not a finite number",
        ),
        (
            |grasp| grasp.grasp.pose[3] = f64::NAN,
            "column `rotation_wxyz` contains NaN, which is not a finite number",
        ),
        (
            |grasp| grasp.grasp.pose[8] = f64::INFINITY,
            "column `joints` contains inf, which is not a finite number",
        ),
        (
            |grasp| grasp.scale = 0.0,
            "scale 0 is not from 1e-6 to 1000000: meshes are made in units from the micrometre to the kilometre",
        ),
        (
            |grasp| grasp.grasp.pose[1] = -2000.0,
            "translation_m has -2000: more than a kilometre from the object; lengths are in metres",
        ),
        (
            |grasp| (grasp.grasp.pose).set_rotation_wxyz([0.5; 4].map(|half| half * 1.25)),
            "the quaternion `rotation_wxyz` has length 1.25, expected 1",
        ),
        (
            |grasp| grasp.grasp.pose[7] = -1.5,
            "joint `left` at -1.5 rad lies more than 1 rad beyond its limits -0.3 to 0.3333333333333333: are these degrees, \
             or angles of other joints?",
        ),
        (
            |grasp| grasp.grasp.pose = with_joints(&grasp.grasp.pose, &[0.2, -7.0, 0.0]),
            "column `joints` contains 3 numbers, expected 2",
        ),
        (
            |grasp| grasp.terms.clear(),
            "column `term_…` contains 0 numbers, expected 2",
        ),
        (
            |grasp| grasp.grasp.contacts = vec![3, 40],
            "contact 40 does not exist: hand `two fingers` has 40 surface points, counted from 0",
        ),
        (
            |grasp| grasp.grasp.contacts = vec![3, 8, 3],
            "contact 3 occurs twice",
        ),
        (
            |grasp| grasp.hand = "claw".into(),
            "hand `claw` is not the one described: `two fingers`",
        ),
        (
            |grasp| grasp.object = "jar".into(),
            "object `jar` is not the one described: `cup`, `bowl`",
        ),
        (|grasp| grasp.id = 1, "id 1 is taken by row 1 already"),
    ];
    for (spoil, expected) in cases {
        assert_eq!(fault(spoil), expected);
    }
}

#[test]
fn the_reader_names_row_and_column() {
    let row =
        |row: usize, text: &str| format!("grasps.parquet, row {row} (the first is 0): {text}");
    let parts = of(&file(4));
    let mut values = parts.floats("epsilon");
    values[3] = f64::NAN;
    let refused = parts.set("epsilon", Float64Array::from(values)).refusal();
    let expected = "column `epsilon` contains NaN, which is not a finite number";
    assert_eq!(refused, row(3, expected));

    let set = |name: &str, array: ArrayRef| of(&file(2)).set(name, array).refusal();
    let lists = |rows: [&[f64]; 2]| -> ArrayRef {
        let rows = rows.map(|row| Some(row.iter().copied().map(Some).collect::<Vec<_>>()));
        Arc::new(ListArray::from_iter_primitive::<Float64Type, _, _>(rows))
    };
    let whole = |rows: [Vec<Option<i32>>; 2]| -> ArrayRef {
        Arc::new(ListArray::from_iter_primitive::<Int32Type, _, _>(
            rows.map(Some),
        ))
    };
    let unit: &[f64] = &[1.0, 0.0, 0.0, 0.0];
    let cases = [
        (
            set("rotation_wxyz", lists([unit, &[1.0, 0.0, 0.0]])),
            "column `rotation_wxyz` contains 3 numbers, expected 4",
        ),
        (
            set("contacts", whole([vec![Some(1)], vec![Some(2), Some(-1)]])),
            "column `contacts` contains -1, expected a whole number from 0 to 4294967295",
        ),
        (
            set("contacts", whole([vec![Some(1)], vec![Some(2), None]])),
            "column `contacts` is empty",
        ),
        (
            set("id", Arc::new(Int64Array::from(vec![3, -3]))),
            "column `id` contains -3, expected a whole number from 0 to 18446744073709551615",
        ),
        (
            set("id", Arc::new(Int64Array::from(vec![3, 3]))),
            "id 3 is taken by row 0 already",
        ),
        (
            set(
                "energy",
                Arc::new(Float64Array::from(vec![Some(1.0), None])),
            ),
            "column `energy` is empty",
        ),
        (
            set(
                "hand",
                Arc::new(StringArray::from(vec!["two fingers", "claw"])),
            ),
            "hand `claw` is not the one described: `two fingers`",
        ),
    ];
    for (found, expected) in cases {
        assert_eq!(found, row(1, expected));
    }
}

#[test]
fn files_that_are_no_grasp_files_are_refused() {
    let (folder, path) = place("grasps.parquet");
    let refusal = || sentence(&read(&path).unwrap_err(), folder.path());
    assert_eq!(refusal(), "no such file: grasps.parquet");
    fs::write(&path, "id,object\n").unwrap();
    assert!(
        refusal().starts_with("grasps.parquet is not a Parquet file or is damaged: "),
        "{}",
        refusal()
    );
    fs::write(&path, "").unwrap();
    assert!(
        refusal().starts_with("grasps.parquet is not a Parquet file or is damaged: "),
        "{}",
        refusal()
    );
    let refused = GraspFile {
        grasps: vec![],
        ..file(0)
    }
    .write(&path)
    .unwrap_err();
    assert_eq!(
        sentence(&refused, folder.path()),
        "grasps.parquet contains no grasps"
    );

    let mut parts = of(&file(2));
    for (_, array) in &mut parts.columns {
        *array = array.slice(0, 0);
    }
    assert_eq!(parts.refusal(), "grasps.parquet contains no grasps");
    let columns = "translation_m rotation_wxyz joints contacts energy term_distance net_wrench";
    for column in columns.split(' ') {
        let refused = of(&file(2)).without(column).refusal();
        assert!(
            refused.starts_with(&format!("grasps.parquet has no column `{column}` (")),
            "{refused}"
        );
    }
    let refused = of(&file(2))
        .set("energy", StringArray::from(vec!["a", "b"]))
        .refusal();
    assert_eq!(
        refused,
        "column `energy` of grasps.parquet contains text; numbers are needed"
    );
    let refused = of(&file(2))
        .set("contacts", Int64Array::from(vec![1, 2]))
        .refusal();
    assert_eq!(
        refused,
        "column `contacts` of grasps.parquet contains whole numbers; lists of whole numbers are needed"
    );
}

#[test]
fn metadata_are_checked() {
    type Spoil = fn(&mut serde_json::Value);
    let spoilt = |spoil: fn(&mut serde_json::Value)| {
        let mut parts = of(&file(2));
        let mut value = serde_json::from_str(parts.metadata.as_ref().unwrap()).unwrap();
        spoil(&mut value);
        parts.metadata = Some(value.to_string());
        parts.refusal()
    };
    assert_eq!(
        spoilt(|value| value["schema_version"] = json!(7)),
        "grasps.parquet has schema version 7, but only version 1 is supported"
    );
    let begin = "the `landscape` metadata of grasps.parquet cannot be used: ";
    let cases: [(Spoil, &str); 5] = [
        (
            |value| value["schema_version"] = json!(null),
            "`schema_version` is missing",
        ),
        (
            |value| value["hands"] = json!(3),
            "invalid type: integer `3`, expected a sequence",
        ),
        (
            |value| value["hands"][0]["limits"] = json!([]),
            "hand `two fingers` has 2 joints but 0 limits",
        ),
        (
            |value| value["terms"] = json!(["distance", "distance"]),
            "`distance` is named twice",
        ),
        (
            |value| value["objects"][1]["name"] = json!("cup"),
            "`cup` is named twice",
        ),
    ];
    for (spoil, expected) in cases {
        assert_eq!(spoilt(spoil), format!("{begin}{expected}"));
    }
    let mut parts = of(&file(2));
    parts.metadata = Some("{".into());
    assert!(parts.refusal().starts_with(begin));
}
