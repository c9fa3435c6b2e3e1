//! Files: round trips, equal bytes, every refusal with its sentence, and being killed at any moment.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]
#![expect(
    clippy::float_cmp,
    reason = "what is stored must come back bit for bit"
)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::types::{Float64Type, Int32Type};
use arrow_array::{
    ArrayRef, DictionaryArray, Float32Array, Float64Array, Int32Array, Int64Array, LargeListArray,
    ListArray, NullArray, StringArray,
};
use base64::Engine;
use landscape::store::{
    AtomicFolder, Counts, EdgeRow, Fault, Grasp, GraspFile, HandMetadata, Journal, LandscapeFiles,
    Manifest, Metadata, MinimumRow, ObjectMetadata, Overrides, PathRow, Phase, SCHEMA_VERSION,
    Source, StoreError, TextFile, Timings, Warning, remove_leftovers, write_atomic,
};
use parts::Parts;
use serde_json::json;
use tempfile::TempDir;

mod parts;

fn hand() -> HandMetadata {
    HandMetadata {
        name: "two fingers".into(),
        joint_names: vec!["left".into(), "right".into()],
        limits_rad: vec![[-0.3, 1.0 / 3.0], [f64::NEG_INFINITY, f64::INFINITY]],
        surface_points: 40,
        description: vec![TextFile {
            name: "hand.urdf".into(),
            text: "<robot name=\"ü\"/>\n".into(),
        }],
        content_hash: "0123".into(),
    }
}

fn object(name: &str) -> ObjectMetadata {
    ObjectMetadata {
        name: name.into(),
        description: json!({ "axis": [0.1 + 0.2, 0.0, 1.0] }),
        mass_kg: 0.1 + 0.7,
        mesh_obj: Some("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into()),
        content_hash: "4567".into(),
    }
}

fn grasp(id: u64) -> Grasp {
    let half = 0.1 * id as f64;
    Grasp {
        id,
        object: "cup".into(),
        scale: 1.0,
        hand: "two fingers".into(),
        translation_m: [0.1 * half, -1.0 / 3.0, f64::MIN_POSITIVE],
        rotation_wxyz: [half.cos(), half.sin(), 0.0, 0.0],
        joints_rad: vec![0.2, -7.0],
        contacts: vec![39, 0, 7],
        energy: 0.7,
        terms: vec![0.3, 0.4],
        net_wrench: 1e-300,
        distance_squared: 0.25,
        penetration: 0.0,
        friction: Some(0.5),
        epsilon: Some(0.05),
        stable: Some(true),
        stable_reason: Some("held".into()),
        stable_displacement_m: Some(0.001),
        stable_turn_rad: Some(0.02),
        label: Some("medium wrap".into()),
        label_auto: Some("precision disk".into()),
        label_score: Some(0.9),
        label_best: Some("Precision Disk 0.900, Precision Sphere 0.850".into()),
        label_category: Some("power".into()),
        label_source: Some("human".into()),
        source: "synthesis".into(),
        chain_seed: u64::MAX,
        chain_step: 9999,
    }
}

fn file(count: u64) -> GraspFile {
    let metadata = Metadata {
        schema_version: SCHEMA_VERSION,
        program_version: "0.1.0".into(),
        command: "landscape synth --hand two".into(),
        seed: u64::MAX,
        hands: vec![hand()],
        objects: vec![object("cup"), object("bowl")],
        energy: json!({ "weights": [0.1, 1e-7, 3.3333333333333335] }),
        settings: json!({ "steps": 10000 }),
        stability: json!({ "protocol": "drop" }),
        labels: json!({ "rule": "0" }),
        terms: vec!["force_closure".into(), "distance".into()],
    };
    GraspFile {
        metadata,
        grasps: (0..count).map(grasp).collect(),
    }
}

/// A folder for one test and a path in it.
fn place(name: &str) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

fn read(path: &Path) -> Result<(GraspFile, Vec<Warning>), StoreError> {
    GraspFile::read(path, Overrides::default())
}

fn overrides() -> Overrides {
    Overrides {
        hand: Some(hand()),
        object: Some(object("cup")),
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// The columns of a valid file, to be spoilt.
fn of(file: &GraspFile) -> Parts {
    let (_folder, path) = place("grasps.parquet");
    file.write(&path).unwrap();
    Parts::of(&path)
}

impl Parts {
    fn read(self, overrides: Overrides) -> Result<(GraspFile, Vec<Warning>), StoreError> {
        let (_folder, path) = place("grasps.parquet");
        self.write(&path);
        GraspFile::read(&path, overrides)
    }

    /// The sentence with which the file is refused, its folder left out.
    fn refusal(self) -> String {
        let (folder, path) = place("grasps.parquet");
        self.write(&path);
        sentence(&read(&path).unwrap_err(), folder.path())
    }
}

fn sentence(error: &StoreError, folder: &Path) -> String {
    error
        .to_string()
        .replace(&format!("{}/", folder.display()), "")
}

/// The sentence with which a grasp is refused, by the writer.
fn fault(spoil: impl FnOnce(&mut Grasp)) -> String {
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
fn grasps_come_back_equal() {
    let (_folder, path) = place("grasps.parquet");
    let mut written = file(5);
    let last = &mut written.grasps[4];
    last.contacts.clear();
    (last.friction, last.epsilon, last.stable, last.label_score) = (None, None, None, None);
    (last.label, last.label_auto, last.source) = (None, Some(String::new()), "ß ∂ 手".into());
    written.write(&path).unwrap();
    let (found, warnings) = read(&path).unwrap();
    assert_eq!(found, written);
    assert_eq!(warnings, []);
}

#[test]
fn same_content_same_bytes() {
    let (_folder, path) = place("grasps.parquet");
    file(200).write(&path).unwrap();
    let first = fs::read(&path).unwrap();
    file(200).write(&path).unwrap();
    assert_eq!(fs::read(&path).unwrap(), first);
    let (again, _) = read(&path).unwrap();
    again.write(&path).unwrap();
    assert_eq!(
        fs::read(&path).unwrap(),
        first,
        "reading and writing changes nothing"
    );
}

#[test]
fn hands_without_joints_and_energies_without_terms() {
    let (_folder, path) = place("grasps.parquet");
    let mut written = file(2);
    written.metadata.hands[0].joint_names.clear();
    written.metadata.hands[0].limits_rad.clear();
    written.metadata.terms.clear();
    for grasp in &mut written.grasps {
        grasp.joints_rad.clear();
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
        ..HandMetadata::default()
    });
    mixed.grasps[0].object = "bowl".into();
    mixed.grasps[1].scale = 0.5;
    mixed.grasps[3].scale = 0.5;
    mixed.grasps[4].hand = "a stick".into();
    mixed.grasps[4].joints_rad.clear();
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
    for name in [
        "id",
        "hand",
        "scale",
        "label",
        "stable",
        "label_auto",
        "label_score",
        "epsilon",
        "friction",
        "source",
    ] {
        parts = parts.without(name);
    }
    let (found, _) = parts
        .without("chain_seed")
        .without("chain_step")
        .read(Overrides::default())
        .unwrap();
    let expected = Grasp {
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
            "joints_rad",
            ListArray::from_iter_primitive::<Float64Type, _, _>(joints),
        )
        .set("object", cup)
        .set("distance_squared", Float32Array::from(vec![0.25, 0.25]))
        .set("label", NullArray::new(2))
        .read(Overrides::default())
        .unwrap();
    assert_eq!(
        found.grasps[1],
        Grasp {
            label: None,
            ..grasp(1)
        }
    );
}

#[test]
fn quaternions_are_made_unit_and_canonical() {
    let (_folder, path) = place("grasps.parquet");
    let mut written = file(2);
    written.grasps[0].rotation_wxyz = [-0.6, 0.0, 0.8004, 0.0];
    written.grasps[1].rotation_wxyz = [0.0, -1.0, 0.0, 0.0];
    written.write(&path).unwrap();
    let (found, _) = read(&path).unwrap();
    let norm = (0.6_f64.powi(2) + 0.8004_f64.powi(2)).sqrt();
    assert_eq!(
        found.grasps[0].rotation_wxyz,
        [0.6 / norm, 0.0, -0.8004 / norm, 0.0]
    );
    assert_eq!(found.grasps[1].rotation_wxyz, [0.0, 1.0, 0.0, 0.0]);
}

#[test]
fn a_joint_slightly_beyond_its_limit_is_kept_with_a_warning() {
    let (_folder, path) = place("grasps.parquet");
    let mut written = file(3);
    written.grasps[1].joints_rad[0] = -0.35;
    written.grasps[2].joints_rad[0] = -0.3 - 1e-8;
    written.write(&path).unwrap();
    let (found, warnings) = read(&path).unwrap();
    assert_eq!(found, written);
    let texts: Vec<_> = warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        texts,
        [
            "1 of 3 grasps have joints beyond their limits; farthest is `left` in row 1, by 0.0500 rad; they are kept as \
             they are"
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
        "grasps.parquet was not written by landscape and does not describe its hand and object: give --hand and \
         --object (columns and units are listed in the documentation of grasps.parquet)"
    );
    let only_hand = foreign()
        .read(Overrides {
            hand: Some(hand()),
            object: None,
        })
        .unwrap_err()
        .to_string();
    assert!(
        only_hand.contains("does not describe its object: give --object ("),
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
            hand: "two fingers".into(),
        },
        Warning::OtherObject {
            object: "cup".into(),
        },
    ];
    assert_eq!(warnings, expected);

    given.hand.as_mut().unwrap().joint_names.swap(0, 1);
    let refused = of(&file(1)).read(given).unwrap_err().to_string();
    let reason =
        "hand `two fingers` has joints `left`, `right`, but the one given has `right`, `left`";
    assert!(refused.ends_with(reason), "{refused}");
}

#[test]
fn rows_that_cannot_be_used_are_refused() {
    type Spoil = fn(&mut Grasp);
    let cases: [(Spoil, &str); 16] = [
        (
            |grasp| grasp.energy = f64::NAN,
            "column `energy` holds NaN, which is not a finite number",
        ),
        (
            |grasp| grasp.terms[1] = f64::INFINITY,
            "column `term_distance` holds inf, which is not a finite number",
        ),
        (
            |grasp| grasp.friction = Some(f64::NEG_INFINITY),
            "column `friction` holds -inf, which is not a finite number",
        ),
        (
            |grasp| grasp.translation_m[2] = f64::NAN,
            "column `translation_m` holds NaN, which is not a finite number",
        ),
        (
            |grasp| grasp.rotation_wxyz[0] = f64::NAN,
            "column `rotation_wxyz` holds NaN, which is not a finite number",
        ),
        (
            |grasp| grasp.joints_rad[1] = f64::INFINITY,
            "column `joints_rad` holds inf, which is not a finite number",
        ),
        (|grasp| grasp.scale = 0.0, "scale 0 is not positive"),
        (
            |grasp| grasp.rotation_wxyz = [0.5; 4].map(|half| half * 1.25),
            "the quaternion `rotation_wxyz` has length 1.25, expected 1",
        ),
        (
            |grasp| grasp.joints_rad[0] = -1.5,
            "joint `left` at -1.5 rad lies more than 1 rad beyond its limits -0.3 to 0.3333333333333333: are these degrees, \
             or angles of other joints?",
        ),
        (
            |grasp| grasp.joints_rad.push(0.0),
            "column `joints_rad` holds 3 numbers, expected 2",
        ),
        (
            |grasp| grasp.terms.clear(),
            "column `term_…` holds 0 numbers, expected 2",
        ),
        (
            |grasp| grasp.contacts = vec![3, 40],
            "contact 40 does not exist: hand `two fingers` has 40 surface points, counted from 0",
        ),
        (
            |grasp| grasp.contacts = vec![3, 8, 3],
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
    let spoilt = |name: &str, row: usize, value: f64| {
        let parts = of(&file(4));
        let mut values = parts.floats(name);
        values[row] = value;
        parts.set(name, Float64Array::from(values)).refusal()
    };
    let row =
        |row: usize, text: &str| format!("grasps.parquet, row {row} (the first is 0): {text}");
    assert_eq!(
        spoilt("epsilon", 3, f64::NAN),
        row(
            3,
            "column `epsilon` holds NaN, which is not a finite number"
        )
    );
    assert_eq!(spoilt("scale", 1, -1.0), row(1, "scale -1 is not positive"));

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
            set("rotation_wxyz", lists([unit, &[2.0, 0.0, 0.0, 0.0]])),
            "the quaternion `rotation_wxyz` has length 2, expected 1",
        ),
        (
            set("rotation_wxyz", lists([unit, &[1.0, 0.0, 0.0]])),
            "column `rotation_wxyz` holds 3 numbers, expected 4",
        ),
        (
            set("joints_rad", lists([&[0.0, 0.0], &[0.0, f64::NAN]])),
            "column `joints_rad` holds NaN, which is not a finite number",
        ),
        (
            set("joints_rad", lists([&[0.0, 0.0], &[1.6, 0.0]])),
            "joint `left` at 1.6 rad lies more than 1 rad beyond its limits -0.3 to 0.3333333333333333: are these degrees, \
             or angles of other joints?",
        ),
        (
            set("contacts", whole([vec![Some(1)], vec![Some(2), Some(-1)]])),
            "column `contacts` holds -1, expected a whole number from 0 to 4294967295",
        ),
        (
            set("contacts", whole([vec![Some(1)], vec![Some(2), None]])),
            "column `contacts` is empty",
        ),
        (
            set("contacts", whole([vec![Some(1)], vec![Some(41)]])),
            "contact 41 does not exist: hand `two fingers` has 40 surface points, counted from 0",
        ),
        (
            set("contacts", whole([vec![Some(1)], vec![Some(5), Some(5)]])),
            "contact 5 occurs twice",
        ),
        (
            set("id", Arc::new(Int64Array::from(vec![3, -3]))),
            "column `id` holds -3, expected a whole number from 0 to 18446744073709551615",
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
        "grasps.parquet holds no grasps"
    );

    let mut parts = of(&file(2));
    for (_, array) in &mut parts.columns {
        *array = array.slice(0, 0);
    }
    assert_eq!(parts.refusal(), "grasps.parquet holds no grasps");
    for column in [
        "translation_m",
        "rotation_wxyz",
        "joints_rad",
        "contacts",
        "energy",
        "term_distance",
        "net_wrench",
    ] {
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
        "column `energy` of grasps.parquet holds Utf8, expected numbers"
    );
    let refused = of(&file(2))
        .set("contacts", Int64Array::from(vec![1, 2]))
        .refusal();
    assert_eq!(
        refused,
        "column `contacts` of grasps.parquet holds Int64, expected lists of whole numbers"
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
        "grasps.parquet has schema version 7, but this program knows version 1 only"
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
            |value| value["hands"][0]["limits_rad"] = json!([]),
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

/// Written by pyarrow: polars compresses with zstd unless told otherwise, and that needs a C compiler.
#[test]
fn an_unknown_compression_is_named() {
    let zstd = "UEFSMRUAFRQVJiwVAhUAFQYVBhwAAAAotS/9IApRAAACAAAAAgEBAAAAFQQZLDUAGAZzY2hlbWEVAgAV\
        AiUCGAJpZAAWAhkcGRwmABwVAhklBgAZGAJpZBUMFgIWOhZMJghJHBUAFQAVAgA8KQYZJgACAAAAFjoW\
        AiYIFkwAKCBwYXJxdWV0LWNwcC1hcnJvdyB2ZXJzaW9uIDI2LjAuMRkcHAAAAHwAAABQQVIx";
    let (folder, path) = place("grasps.parquet");
    fs::write(
        &path,
        base64::engine::general_purpose::STANDARD
            .decode(zstd)
            .unwrap(),
    )
    .unwrap();
    assert_eq!(
        sentence(&read(&path).unwrap_err(), folder.path()),
        "grasps.parquet is compressed with ZSTD, which is not supported: write it with snappy or without compression"
    );
}

/// Damage is an error or goes unnoticed, but never a panic.
#[test]
fn a_damaged_file_never_panics() {
    let (_folder, path) = place("grasps.parquet");
    file(3).write(&path).unwrap();
    let good = fs::read(&path).unwrap();
    let mut refused = 0;
    for position in (0..good.len()).step_by(5) {
        for damaged in [
            good[..position].to_vec(),
            flipped(&good, position, 1 << (position % 8)),
        ] {
            fs::write(&path, damaged).unwrap();
            refused += usize::from(read(&path).is_err());
        }
    }
    assert!(
        refused > good.len() / 5,
        "every shortened file is refused, and some of the rest"
    );
}

fn flipped(bytes: &[u8], position: usize, mask: u8) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[position] ^= mask;
    bytes
}

fn landscape() -> LandscapeFiles {
    let minimum = |id: u64| MinimumRow {
        id,
        energy: 0.1 * id as f64,
        coordinates: vec![0.1, 1.0 / 3.0, id as f64],
        choice: vec![5, 3, 8],
        members: vec![id, id + 10, u64::MAX],
        group: 0,
        labels: BTreeMap::from([("medium wrap".into(), 2), ("lateral".into(), 1)]),
    };
    let edge = EdgeRow {
        a: 0,
        b: 1,
        height: Some(0.5),
        relative_barrier: Some(0.4),
        length: Some(0.07),
        evidence: "seam".into(),
        term: Some("distance".into()),
        chain_forward: Some(0.9),
        chain_backward: None,
        chains_forward: vec![0.95, 0.9],
        chains_backward: Vec::new(),
        chain_runs: 4,
        evaluations: 12345,
    };
    let untried = EdgeRow {
        a: 1,
        b: 2,
        evidence: "none".into(),
        evaluations: 99,
        ..EdgeRow::default()
    };
    let image = |image: u64| PathRow {
        a: 0,
        b: 1,
        image,
        coordinates: vec![0.0, 0.5, image as f64],
        energy: 0.2,
        choice: if image == 2 { vec![] } else { vec![1, 2, 3] },
        terms: (image == 1).then(|| vec![0.125, 0.075]),
    };
    let manifest = Manifest {
        program_version: "0.1.0".into(),
        command: "landscape build grasps.parquet".into(),
        seed: 7,
        source: Source {
            name: "grasps.parquet".into(),
            content_hash: "89ab".into(),
        },
        hand: Some(hand()),
        object: Some(object("cup")),
        scale: 0.06,
        energy: json!({ "w": 0.1 }),
        settings: json!({ "images": 20 }),
        terms: vec!["force_closure".into(), "distance".into()],
        group_barrier: Some(0.1 + 0.2),
        counts: Counts {
            grasps: 9,
            minima: 3,
            groups: 1,
            pairs: 2,
            components: 2,
            evaluations: 12444,
        },
        evidence: BTreeMap::from([("seam".into(), 1), ("none".into(), 1)]),
        findings: BTreeMap::from([("hover_cost".into(), json!([0.1, 0.2, 0.3]))]),
        warnings: vec!["the hover cost lies below the median merge depth".into()],
    };
    LandscapeFiles {
        manifest,
        minima: (0..3).map(minimum).collect(),
        edges: vec![edge, untried],
        paths: (0..3).map(image).collect(),
    }
}

#[test]
fn landscapes_come_back_equal_and_with_the_same_bytes() {
    let (_folder, path) = place("cup.landscape");
    let mut bytes = Vec::new();
    for _ in 0..2 {
        let folder = AtomicFolder::open(&path, false).unwrap();
        landscape().write(&folder).unwrap();
        let phases = vec![Phase {
            name: "quench".into(),
            seconds: 1.5,
            evaluations: 10,
        }];
        Timings { threads: 2, phases }.write(&folder).unwrap();
        assert_eq!(folder.finish().unwrap(), path);
        assert_eq!(LandscapeFiles::read(&path).unwrap(), landscape());
        let files = names(&path);
        assert_eq!(
            files,
            [
                "edges.parquet",
                "landscape.json",
                "minima.parquet",
                "paths.parquet",
                "timings.json"
            ]
        );
        bytes.push(
            files
                .iter()
                .map(|name| fs::read(path.join(name)).unwrap())
                .collect::<Vec<_>>(),
        );
    }
    assert_eq!(bytes[0], bytes[1]);
}

#[test]
fn a_landscape_may_be_almost_empty_and_must_be_finite() {
    let (_folder, path) = place("cup.landscape");
    let folder = AtomicFolder::open(&path, false).unwrap();
    let empty = LandscapeFiles::default();
    empty.write(&folder).unwrap();
    assert_eq!(
        LandscapeFiles::read(&folder.finish().unwrap()).unwrap(),
        empty
    );

    let folder = AtomicFolder::open(&path, false).unwrap();
    let mut spoilt = landscape();
    spoilt.edges[1].height = Some(f64::INFINITY);
    let refused = spoilt.write(&folder).unwrap_err();
    assert_eq!(
        sentence(&refused, folder.path()),
        "edges.parquet, row 1 (the first is 0): column `height` holds inf, which is not a finite number"
    );
}

#[test]
fn folders_that_are_no_landscapes_are_not_read() {
    let (folder, path) = place("cup.landscape");
    let refusal = || sentence(&LandscapeFiles::read(&path).unwrap_err(), folder.path());
    assert_eq!(refusal(), "no such file: cup.landscape/landscape.json");
    fs::create_dir(&path).unwrap();
    assert_eq!(
        refusal(),
        "cup.landscape holds no finished landscape: landscape.json is missing or not ours"
    );
    fs::write(path.join("landscape.json"), "{}").unwrap();
    assert_eq!(
        refusal(),
        "cup.landscape holds no finished landscape: landscape.json is missing or not ours"
    );
    fs::write(
        path.join("landscape.json"),
        r#"{"format": "landscape", "schema_version": 2}"#,
    )
    .unwrap();
    assert_eq!(
        refusal(),
        "cup.landscape/landscape.json has schema version 2, but this program knows version 1 only"
    );
}

#[test]
fn a_file_is_written_whole_or_not_at_all() {
    let (folder, path) = place("report.md");
    write_atomic(&path, b"first").unwrap();
    write_atomic(&path, b"second").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"second");
    assert_eq!(names(folder.path()), ["report.md"]);

    let in_file = path.join("below.md");
    let refused = write_atomic(&in_file, b"x").unwrap_err();
    assert_eq!(
        sentence(&refused, folder.path()),
        "cannot write report.md/below.md"
    );
    assert!(
        std::error::Error::source(&refused)
            .unwrap()
            .to_string()
            .contains("Not a directory")
    );
    assert!(write_atomic(&folder.path().join("absent/x.md"), b"x").is_err());
    fs::create_dir(folder.path().join("taken")).unwrap();
    fs::write(folder.path().join("taken/child"), b"x").unwrap();
    assert!(write_atomic(&folder.path().join("taken"), b"x").is_err());
    assert!(matches!(
        write_atomic(Path::new("/"), b"x"),
        Err(StoreError::NoName { .. })
    ));
    assert_eq!(
        names(folder.path()),
        ["report.md", "taken"],
        "failures leave no temporary files"
    );
    assert_eq!(fs::read(&path).unwrap(), b"second");
}

#[test]
fn a_folder_takes_its_name_when_it_is_complete() {
    let (folder, path) = place("cup.landscape");
    let partial = folder.path().join("cup.landscape.partial");
    let unfinished = AtomicFolder::open(&path, false).unwrap();
    assert_eq!(unfinished.path(), partial);
    unfinished.write("tree.nwk", b"();").unwrap();
    let refused = unfinished.finish().unwrap_err();
    assert!(
        matches!(refused, StoreError::Unfinished { .. }),
        "no manifest, no landscape"
    );
    assert_eq!(names(folder.path()), ["cup.landscape.partial"]);

    // Resumed: what was half made is made again, the journal is kept.
    fs::write(partial.join("journal"), "kept").unwrap();
    let resumed = AtomicFolder::open(&path, false).unwrap();
    assert_eq!(names(&partial), [".unfinished", "journal"]);
    landscape().write(&resumed).unwrap();
    resumed.finish().unwrap();
    assert_eq!(names(folder.path()), ["cup.landscape"]);

    // While the next one grows, the old one stays.
    let next = AtomicFolder::open(&path, false).unwrap();
    next.write("extra", b"1").unwrap();
    assert_eq!(LandscapeFiles::read(&path).unwrap(), landscape());
    let mut changed = landscape();
    changed.manifest.seed = 8;
    changed.write(&next).unwrap();
    next.finish().unwrap();
    assert_eq!(LandscapeFiles::read(&path).unwrap(), changed);
    assert_eq!(names(folder.path()), ["cup.landscape"]);

    fs::create_dir(&partial).unwrap();
    fs::write(partial.join(".unfinished"), "").unwrap();
    fs::write(partial.join("journal"), "not kept").unwrap();
    AtomicFolder::open(&path, true).unwrap();
    assert_eq!(
        names(&partial),
        [".unfinished"],
        "a fresh start keeps nothing"
    );
}

/// The state of the disk after each step of `finish`, as a killed run leaves it.
#[test]
fn a_folder_survives_being_killed_between_renames() {
    let complete = |path: &Path, seed: u64| {
        fs::create_dir(path).unwrap();
        let json = json!({ "format": "landscape", "seed": seed });
        fs::write(path.join("landscape.json"), json.to_string()).unwrap();
        fs::write(path.join(".unfinished"), "").unwrap();
        fs::write(path.join("journal"), "tasks").unwrap();
    };
    let seed = |path: &Path| {
        let text = fs::read_to_string(path.join("landscape.json")).unwrap();
        serde_json::from_str::<serde_json::Value>(&text).unwrap()["seed"].clone()
    };
    let (folder, path) = place("cup.landscape");
    let [partial, old] =
        [".partial", ".old.partial"].map(|end| folder.path().join(format!("cup.landscape{end}")));

    complete(&old, 1);
    complete(&partial, 2);
    AtomicFolder::open(&path, false).unwrap();
    assert_eq!(seed(&path), 1, "the previous landscape is back");
    assert_eq!(
        names(&partial),
        [".unfinished", "journal"],
        "and the work of the next is kept"
    );
    assert!(!old.exists());

    fs::remove_dir_all(&partial).unwrap();
    complete(&old, 0);
    AtomicFolder::open(&path, false).unwrap();
    assert_eq!(seed(&path), 1, "the new landscape stays");
    assert!(!old.exists());

    // After the last renaming, before the journal was removed.
    fs::remove_dir_all(&partial).unwrap();
    fs::write(path.join("journal"), "all tasks").unwrap();
    assert_eq!(
        AtomicFolder::left_journal(&path),
        Some(path.join("journal"))
    );
    AtomicFolder::open(&path, false).unwrap();
    assert_eq!(
        fs::read_to_string(partial.join("journal")).unwrap(),
        "all tasks"
    );
    assert!(!path.join("journal").exists());

    // While the previous folder was removed: what shows that it is ours goes last.
    fs::create_dir(&old).unwrap();
    fs::write(old.join("landscape.json"), r#"{"format": "landscape"}"#).unwrap();
    AtomicFolder::open(&path, false).unwrap();
    assert!(!old.exists());

    // While the first file of all was written.
    fs::remove_dir_all(&partial).unwrap();
    assert_eq!(AtomicFolder::left_journal(&path), None);
    fs::create_dir(&partial).unwrap();
    fs::write(partial.join(".unfinished.123.partial"), "land").unwrap();
    AtomicFolder::open(&path, false).unwrap();
    assert_eq!(names(&partial), [".unfinished"]);
}

/// Neither continuing nor beginning again takes the ground from under a running process.
#[test]
fn a_folder_in_use_is_left_alone() {
    let (folder, path) = place("cup.landscape");
    let unfinished = AtomicFolder::open(&path, false).unwrap();
    let journal = Journal::open(&unfinished.journal(), "input", false).unwrap();
    journal.put("task", b"done").unwrap();
    unfinished.write("tree.nwk", b"();").unwrap();
    for fresh in [false, true] {
        let refused = AtomicFolder::open(&path, fresh).unwrap_err();
        assert_eq!(
            sentence(&refused, folder.path()),
            "cup.landscape.partial/journal is in use by another run"
        );
        assert_eq!(
            names(unfinished.path()),
            [".unfinished", "journal", "tree.nwk"]
        );
    }
    landscape().write(&unfinished).unwrap();
    unfinished.finish().unwrap();
    assert_eq!(names(folder.path()), ["cup.landscape"]);
    assert!(!path.join("journal").exists());
}

#[test]
fn leftovers_of_killed_writes_are_removed_and_nothing_else() {
    let (folder, path) = place("grasps.parquet");
    let others = [
        "grasps.parquet",
        "grasps.parquet.old.partial",
        "grasps.parquet.partial",
        "mygrasps.parquet.12.partial",
    ];
    for name in others.iter().chain(&["grasps.parquet.4711.partial"]) {
        fs::write(folder.path().join(name), "x").unwrap();
    }
    remove_leftovers(&path).unwrap();
    assert_eq!(names(folder.path()), others);
}

#[test]
fn what_others_made_is_never_removed() {
    for name in [
        "cup.landscape",
        "cup.landscape.partial",
        "cup.landscape.old.partial",
    ] {
        let (folder, path) = place("cup.landscape");
        let foreign = folder.path().join(name);
        fs::create_dir(&foreign).unwrap();
        fs::write(foreign.join("thesis.tex"), "years").unwrap();
        fs::write(foreign.join("landscape.json"), r#"{"format": "painting"}"#).unwrap();
        for fresh in [false, true] {
            let refused = AtomicFolder::open(&path, fresh).unwrap_err();
            let expected = format!(
                "{name} exists and was not made by landscape: move it away or choose another name"
            );
            assert_eq!(sentence(&refused, folder.path()), expected);
        }
        assert_eq!(names(&foreign), ["landscape.json", "thesis.tex"]);
        assert_eq!(names(folder.path()), [name]);
    }
    let (folder, path) = place("cup.landscape");
    let folder_in_time = AtomicFolder::open(&path, false).unwrap();
    landscape().write(&folder_in_time).unwrap();
    fs::write(&path, "a file that came while we worked").unwrap();
    assert!(matches!(
        folder_in_time.finish(),
        Err(StoreError::NotOurs { .. })
    ));
    assert_eq!(
        names(folder.path()),
        ["cup.landscape", "cup.landscape.partial"]
    );
    let refused =
        AtomicFolder::open(&folder.path().join("absent/cup.landscape"), false).unwrap_err();
    assert_eq!(
        sentence(&refused, folder.path()),
        "cannot create absent/cup.landscape.partial"
    );
}

#[test]
fn a_journal_remembers() {
    let (_folder, path) = place("journal");
    let journal = Journal::open(&path, "input 1", false).unwrap();
    assert!(journal.is_empty());
    journal.put("quench 0", b"one").unwrap();
    journal.put("", &[]).unwrap();
    journal.put("quench 0", b"two").unwrap();
    std::thread::scope(|scope| {
        for thread in 0..4_u32 {
            let journal = &journal;
            scope.spawn(move || {
                for task in 0..50_u32 {
                    journal
                        .put(&format!("{thread} {task}"), &(thread * task).to_le_bytes())
                        .unwrap();
                }
            });
        }
    });
    journal.sync().unwrap();
    assert!(matches!(
        Journal::open(&path, "input 1", false),
        Err(StoreError::InUse { .. })
    ));
    drop(journal);

    let journal = Journal::open(&path, "input 1", false).unwrap();
    assert_eq!((journal.len(), journal.dropped_bytes()), (202, 0));
    assert_eq!(journal.get("quench 0").unwrap(), b"two");
    assert_eq!(journal.get("").unwrap(), b"");
    assert_eq!(journal.get("3 49").unwrap(), 147_u32.to_le_bytes());
    assert_eq!(journal.get("quench 1"), None);
    journal.remove().unwrap();
    assert!(!path.exists());
}

#[test]
fn a_journal_of_other_input_is_refused() {
    let (folder, path) = place("journal");
    Journal::open(&path, "input 1", false)
        .unwrap()
        .put("a", b"1")
        .unwrap();
    for other in ["input 2", "", "input 11"] {
        let refused = Journal::open(&path, other, false).unwrap_err();
        assert_eq!(
            sentence(&refused, folder.path()),
            "journal belongs to a run with other input or settings, or of another version of the program: repeat those \
             to resume it, or start over with --fresh"
        );
    }
    assert_eq!(
        Journal::open(&path, "input 1", false)
            .unwrap()
            .get("a")
            .unwrap(),
        b"1"
    );
    assert_eq!(
        Journal::open(&path, "input 2", true).unwrap().get("a"),
        None
    );
    assert!(Journal::open(&path, "input 2", false).unwrap().is_empty());

    fs::write(&path, "something else entirely").unwrap();
    let refused = Journal::open(&path, "input 1", false).unwrap_err();
    assert_eq!(
        sentence(&refused, folder.path()),
        "journal is not a journal of this program or its head is damaged: start over with --fresh"
    );
    assert_eq!(
        fs::read_to_string(&path).unwrap(),
        "something else entirely"
    );
    assert!(Journal::open(&path.join("x"), "input 1", false).is_err());
}

/// A journal with three records, and where each part of it ends: head, first, second, third.
fn three_records(path: &Path) -> (Vec<u8>, [usize; 4]) {
    let journal = Journal::open(path, "input", true).unwrap();
    let mut ends = [length(path); 4];
    for (task, payload) in [b"first payload".as_slice(), &[0; 20], b"third"]
        .into_iter()
        .enumerate()
    {
        journal.put(&format!("task {task}"), payload).unwrap();
        ends[task + 1] = length(path);
    }
    (fs::read(path).unwrap(), ends)
}

fn length(path: &Path) -> usize {
    usize::try_from(fs::metadata(path).unwrap().len()).unwrap()
}

#[test]
fn a_journal_cut_anywhere_keeps_every_whole_record_and_goes_on() {
    let (_folder, path) = place("journal");
    let (whole, ends) = three_records(&path);
    for cut in 0..=whole.len() {
        fs::write(&path, &whole[..cut]).unwrap();
        let journal = Journal::open(&path, "input", false).unwrap();
        let kept = ends[1..].iter().filter(|end| **end <= cut).count();
        assert_eq!(journal.len(), kept, "cut at {cut}");
        let kept_end = if cut < ends[0] { 0 } else { ends[kept] };
        assert_eq!(
            journal.dropped_bytes(),
            (cut - kept_end) as u64,
            "cut at {cut}"
        );
        // The tasks that were lost are done again.
        for (task, payload) in [b"first payload".as_slice(), &[0; 20], b"third"]
            .into_iter()
            .enumerate()
            .skip(kept)
        {
            journal.put(&format!("task {task}"), payload).unwrap();
        }
        drop(journal);
        assert_eq!(fs::read(&path).unwrap(), whole, "cut at {cut}");
    }
}

/// A power cut may leave blocks of zeros, or a tail with wrong bytes in it.
#[test]
fn a_journal_with_a_spoilt_last_record_drops_it() {
    let (_folder, path) = place("journal");
    let (whole, ends) = three_records(&path);
    for position in ends[2]..ends[3] {
        for mask in [0x01, 0x80, 0xff] {
            fs::write(&path, flipped(&whole, position, mask)).unwrap();
            let journal = Journal::open(&path, "input", false).unwrap();
            assert_eq!(
                (journal.len(), length(&path)),
                (2, ends[2]),
                "byte {position}"
            );
        }
        let mut zeros = whole[..position].to_vec();
        zeros.resize(whole.len() + 100, 0);
        fs::write(&path, zeros).unwrap();
        assert_eq!(
            Journal::open(&path, "input", false).unwrap().len(),
            2,
            "zeros from byte {position}"
        );
    }
    for position in 0..ends[0] {
        // A damaged length of the head must not pass for a head cut off, which would cost the records.
        let spoilt = flipped(&whole, position, 0xff);
        fs::write(&path, &spoilt).unwrap();
        let opened = Journal::open(&path, "input", false);
        assert!(
            matches!(opened, Err(StoreError::NotAJournal { .. })),
            "head byte {position}: {opened:?}"
        );
        assert_eq!(fs::read(&path).unwrap(), spoilt, "nothing is destroyed");
    }
}

#[test]
fn faults_can_be_sorted_out_before_writing() {
    let (_folder, path) = place("grasps.parquet");
    let mut file = file(4);
    file.grasps[1].joints_rad[0] = 3.0;
    file.grasps[3].id = 0;
    let faults = file.faults();
    assert!(matches!(
        faults[..],
        [
            (1, Fault::BeyondLimit { .. }),
            (3, Fault::RepeatedId { id: 0, first: 0 })
        ]
    ));
    let mut row = 0;
    file.grasps.retain(|_| {
        row += 1;
        faults.iter().all(|(fault, _)| fault + 1 != row)
    });
    file.write(&path).unwrap();
    assert_eq!(read(&path).unwrap().0, file);
}
