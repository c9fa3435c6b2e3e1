//! Files of grasps are restored exactly and written with the same bytes. Versions changed by other tools are read.

use std::fs;
use std::sync::Arc;

use crate::store::{besides_the_seal, file, grasp, hand, of, overrides, place, read, with_joints};
use arrow_array::types::{Float64Type, Int32Type};
use arrow_array::{
    DictionaryArray, Float32Array, Int32Array, Int64Array, LargeListArray, ListArray, NullArray,
};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use landscape::store::{GraspRow, HandMetadata, Overrides, Warning};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

#[test]
fn grasps_come_back_equal() {
    let (_folder, path) = place("grasps.parquet");
    let mut written = file(5);
    let last = &mut written.grasps[4];
    last.grasp.contacts.clear();
    (last.friction, last.epsilon, last.stable, last.label_score) = (None, None, None, None);
    (last.label, last.label_auto, last.source) = (None, Some(String::new()), "ß ∂ 手".into());
    written.write(&path).unwrap();
    let (found, warnings) = read(&path).unwrap();
    assert_eq!(found, written);
    assert_eq!(warnings, []);
}

/// If a file contains Arrow's own copy of the schema, pyarrow keeps only the metadata in this copy.
#[test]
fn metadata_stand_in_the_arrow_schema_too() {
    let (_folder, path) = place("grasps.parquet");
    file(2).write(&path).unwrap();
    let bytes = bytes::Bytes::from(fs::read(&path).unwrap());
    let builder = ParquetRecordBatchReaderBuilder::try_new(bytes).unwrap();
    let pairs = builder.metadata().file_metadata().key_value_metadata();
    let value = |key: &str| {
        let pair = pairs.unwrap().iter().find(|pair| pair.key == key);
        pair.unwrap().value.clone().unwrap()
    };
    let schema = STANDARD.decode(value("ARROW:schema")).unwrap();
    let metadata = value("landscape");
    let mut parts = schema.windows(metadata.len());
    assert!(parts.any(|part| part == metadata.as_bytes()));
}

#[test]
fn hands_without_joints_and_energies_without_terms() {
    let (_folder, path) = place("grasps.parquet");
    let mut written = file(2);
    written.metadata.hands[0].joint_names.clear();
    written.metadata.hands[0].limits.clear();
    written.metadata.terms.clear();
    for grasp in &mut written.grasps {
        grasp.grasp.pose = with_joints(&grasp.grasp.pose, &[]);
        grasp.squeeze_joints = None;
        grasp.terms.clear();
    }
    written.write(&path).unwrap();
    assert_eq!(read(&path).unwrap().0, written);
}

#[test]
fn a_mixed_file_holds_several_landscapes() {
    let (_folder, path) = place("grasps.parquet");
    let mut mixed = file(5);
    mixed.metadata.hands.push(HandMetadata {
        name: "a stick".into(),
        surface_points: 40,
        surface_hash: String::new(),
        ..HandMetadata::default()
    });
    mixed.grasps[0].object = "bowl".into();
    mixed.grasps[1].scale = 0.5;
    mixed.grasps[3].scale = 0.5;
    mixed.grasps[4].hand = "a stick".into();
    mixed.grasps[4].squeeze_joints = None;
    let last = &mut mixed.grasps[4].grasp.pose;
    *last = with_joints(last, &[]);
    mixed.write(&path).unwrap();
    let (found, _) = read(&path).unwrap();
    assert_eq!(found, mixed);
    let summary: Vec<_> = found
        .landscapes()
        .into_iter()
        .map(|part| {
            let ids: Vec<_> = part.grasps.iter().map(|grasp| grasp.id).collect();
            (
                part.hand.name.clone(),
                part.object.name.clone(),
                part.scale,
                ids,
            )
        })
        .collect();
    let expected = [
        ("a stick", "cup", 1.0, vec![4]),
        ("two fingers", "bowl", 1.0, vec![0]),
        ("two fingers", "cup", 0.5, vec![1, 3]),
        ("two fingers", "cup", 1.0, vec![2]),
    ];
    assert_eq!(
        summary,
        expected.map(|(hand, object, scale, ids)| (hand.into(), object.into(), scale, ids))
    );
}

#[test]
fn absent_columns_have_defaults() {
    let mut parts = of(&file(2));
    let names =
        "id hand scale label stable label_auto label_score epsilon friction source squeeze_joints";
    for name in names.split(' ') {
        parts = parts.without(name);
    }
    let (found, _) = parts
        .without("chain_seed")
        .without("chain_step")
        .read(Overrides::default())
        .unwrap();
    let expected = GraspRow {
        squeeze_joints: None,
        friction: None,
        epsilon: None,
        stable: None,
        label: None,
        label_auto: None,
        label_score: None,
        source: String::new(),
        chain_seed: 0,
        chain_step: 0,
        ..grasp(1)
    };
    assert_eq!(found.grasps[1], expected);
    // Two objects are described, so a row must say which it means.
    let refused = of(&file(2)).without("object").refusal();
    assert_eq!(refused, "grasps.parquet has no column `object` (text)");
}

/// Only grasps whose makers stored them have squeezed joints.
#[test]
fn squeezed_joints_may_be_missing() {
    let (_folder, path) = place("grasps.parquet");
    let mut written = file(3);
    written.grasps[1].squeeze_joints = None;
    written.write(&path).unwrap();
    assert_eq!(read(&path).unwrap().0.grasps, written.grasps);
    written.grasps[0].squeeze_joints = Some(vec![0.5]);
    let refused = written.write(&path).unwrap_err().to_string();
    assert!(
        refused.contains("`squeeze_joints` contains 1 number, expected 2"),
        "{refused}"
    );
}

#[test]
fn columns_may_have_passed_through_other_tools() {
    let contacts = vec![Some(vec![Some(39), Some(0), Some(7)]); 2];
    let joints = vec![Some(vec![Some(0.2), Some(-7.0)]); 2];
    let cup: DictionaryArray<Int32Type> = ["cup", "cup"].into_iter().collect();
    let (found, _) = of(&file(2))
        .set("id", Int64Array::from(vec![0, 1]))
        .set("scale", Int32Array::from(vec![1, 1]))
        .set(
            "contacts",
            LargeListArray::from_iter_primitive::<Int32Type, _, _>(contacts),
        )
        .set(
            "joints",
            ListArray::from_iter_primitive::<Float64Type, _, _>(joints),
        )
        .set("object", cup)
        .set("distance_squared", Float32Array::from(vec![0.25, 0.25]))
        .set("label", NullArray::new(2))
        .read(Overrides::default())
        .unwrap();
    assert_eq!(
        found.grasps[1],
        GraspRow {
            label: None,
            ..grasp(1)
        }
    );
}

#[test]
fn quaternions_are_made_unit_and_canonical() {
    let (_folder, path) = place("grasps.parquet");
    let mut written = file(2);
    written.grasps[0]
        .grasp
        .pose
        .set_rotation_wxyz([-0.6, 0.0, 0.8004, 0.0]);
    written.grasps[1]
        .grasp
        .pose
        .set_rotation_wxyz([0.0, -1.0, 0.0, 0.0]);
    written.write(&path).unwrap();
    let (found, _) = read(&path).unwrap();
    let norm = (0.6_f64.powi(2) + 0.8004_f64.powi(2)).sqrt();
    assert_eq!(
        found.grasps[0].grasp.pose.rotation_wxyz(),
        [0.6 / norm, 0.0, -0.8004 / norm, 0.0]
    );
    assert_eq!(
        found.grasps[1].grasp.pose.rotation_wxyz(),
        [0.0, 1.0, 0.0, 0.0]
    );
}

#[test]
fn a_joint_slightly_beyond_its_limit_is_kept_with_a_warning() {
    let (_folder, path) = place("grasps.parquet");
    let mut written = file(3);
    written.grasps[1].grasp.pose[7] = -0.35;
    written.grasps[2].grasp.pose[7] = -0.3 - 1e-8;
    written.write(&path).unwrap();
    let (found, warnings) = read(&path).unwrap();
    assert_eq!(found, written);
    let texts: Vec<_> = warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        texts,
        [
            "1 of 3 grasps have joints beyond their limits; farthest is `left` in row 1, by 0.0500 rad, or m if it \
             slides; they are kept as they are"
        ]
    );
}

#[test]
fn a_file_of_others_needs_hand_and_object() {
    let foreign = || {
        let mut parts = of(&file(2)).without("hand").without("object");
        parts.metadata = None;
        parts
    };
    assert_eq!(
        foreign().refusal(),
        "grasps.parquet does not describe its hand and object: another program wrote it, or rewrote it without the \
         landscape metadata, as polars and DuckDB do. Pass --hand and --object (the documentation of grasps.parquet lists \
         columns and units)"
    );
    let only_hand = foreign()
        .read(Overrides {
            hand: Some(hand()),
            object: None,
        })
        .unwrap_err()
        .to_string();
    assert!(
        only_hand.contains("does not describe its object: another program wrote it"),
        "{only_hand}"
    );
    let (found, _) = foreign().read(overrides()).unwrap();
    assert_eq!(found.grasps, file(2).grasps);
    assert_eq!(found.metadata.terms, ["force_closure", "distance"]);
}

#[test]
fn overrides_replace_what_the_file_describes() {
    let mut given = overrides();
    let (found, warnings) = of(&file(1)).read(given.clone()).unwrap();
    assert_eq!((found.metadata, warnings), (file(1).metadata, vec![]));

    given.hand.as_mut().unwrap().content_hash = "other".into();
    given.object.as_mut().unwrap().content_hash = "other".into();
    let (found, warnings) = of(&file(1)).read(given.clone()).unwrap();
    assert_eq!(found.metadata.hands[0].content_hash, "other");
    let expected = [
        Warning::OtherHand {
            told: "two fingers".into(),
            given: "two fingers".into(),
        },
        Warning::OtherObject {
            told: "cup".into(),
            given: "cup".into(),
        },
    ];
    assert_eq!(warnings, expected);

    let row = &found.grasps[0];
    assert!(row.grasp.contacts.is_empty(), "they are of the other hand");
    assert_eq!(
        (row.stable, &row.label, &row.label_auto),
        (None, &None, &None)
    );
    let metadata = &found.metadata;
    assert!(metadata.stability.is_null() && metadata.labels.is_null());

    given.hand.as_mut().unwrap().joint_names.swap(0, 1);
    let refused = of(&file(1)).read(given).unwrap_err().to_string();
    let reason =
        "hand `two fingers` has joints `left`, `right`, but the one given has `right`, `left`";
    assert!(refused.ends_with(reason), "{refused}");
}

/// Columns and entries of another program, or of the user.
#[test]
fn what_is_not_known_is_ignored() {
    let mut parts = of(&file(2));
    parts.columns.push((
        "quality".into(),
        Arc::new(Float32Array::from(vec![0.5, 0.25])),
    ));
    parts.columns.push((
        "__index_level_0__".into(),
        Arc::new(Int64Array::from(vec![4, 5])),
    ));
    let mut metadata: serde_json::Value =
        serde_json::from_str(parts.metadata.as_ref().unwrap()).unwrap();
    metadata["robot"] = "of next year".into();
    metadata["hands"][0]["skin"] = serde_json::json!({ "colour": "blue" });
    parts.metadata = Some(metadata.to_string());
    let (_folder, path) = place("grasps.parquet");
    parts.write(&path);
    let (found, warnings) = read(&path).unwrap();
    let warnings = besides_the_seal(warnings, &path);
    assert_eq!(found, file(2));
    assert_eq!(warnings, []);
}
