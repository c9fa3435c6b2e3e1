//! Grasps of other programs: reading, writing, and the messages of all mistakes.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod frames;
mod grippers;
mod mistakes;
mod models;
mod readings;
mod tensors;

use std::fs;

use crate::desk::{Desk, assert_says};
use crate::pickled::bench;
use landscape::store::exchange::{Columns, JointColumns, Mapping, read, table_csv, table_json};
use landscape::store::{GraspFile, GraspRow};
use proptest::prelude::*;

/// Grasps of the parallel gripper on the ball.
const TABLE: &str = "\
id,scale,translation_m_x,translation_m_y,translation_m_z,rotation_w,rotation_x,rotation_y,rotation_z,label,jaw
7,1,0.1,0.02,0.0333333333333333,0.5,0.5,-0.5,0.5,\"pinch, wide\",0.025
9,1,-0.08,0.011,0.05,0.6,0.0,0.8,0.0,,0.0301234567890123
11,1,0,0,-0.07,0.0,1.0,0.0,0.0,,0.0401
";

impl Desk {
    /// Runs a command that must succeed and returns all its output.
    pub(crate) fn said(&self, line: &str) -> String {
        let (told, said) = self.both(line);
        said + &told
    }
}

fn with_table() -> Desk {
    let desk = Desk::empty();
    desk.write("t.csv", TABLE);
    desk.said("import t.csv --hand gripper_parallel --object ball -o t.parquet");
    desk
}

/// Largest difference of poses and joints between two files; quaternions are compared up to sign.
fn difference(a: &GraspFile, b: &GraspFile) -> f64 {
    assert_eq!(a.grasps.len(), b.grasps.len());
    let mut worst: f64 = 0.0;
    for (one, two) in a.grasps.iter().zip(&b.grasps) {
        let (one, two) = (&one.grasp.pose[..], &two.grasp.pose[..]);
        assert_eq!(one.len(), two.len());
        let dot: f64 = (3..7).map(|k| one[k] * two[k]).sum();
        for (k, (p, q)) in one.iter().zip(two).enumerate() {
            let sign = if (3..7).contains(&k) {
                dot.signum()
            } else {
                1.0
            };
            worst = worst.max((p - sign * q).abs());
        }
    }
    worst
}

#[test]
fn tables_become_grasps_with_contacts_and_energies() {
    let desk = with_table();
    let file = desk.grasps("t.parquet");
    let ids: Vec<u64> = file.grasps.iter().map(|grasp| grasp.id).collect();
    assert_eq!(ids, [7, 9, 11]);
    assert_eq!(file.grasps[0].label.as_deref(), Some("pinch, wide"));
    assert_eq!(file.grasps[1].source, "t.csv 1");
    for grasp in &file.grasps {
        assert_eq!(grasp.grasp.contacts.len(), 4);
        assert!(
            grasp.energy > 0.0 && (grasp.terms.iter().sum::<f64>() - grasp.energy).abs() < 1e-12
        );
    }
    let said = desk.said("import t.csv --hand gripper_parallel --object ball -o u.parquet");
    assert_says(
        &said,
        &[
            "1 of 3 grasps have joints beyond their limits; farthest is `jaw` in row 2",
            "kept",
            "found",
        ],
    );
    assert_eq!(desk.bytes("t.parquet").len(), desk.bytes("u.parquet").len());
    // What comes out is a file as any other.
    desk.succeed("inspect t.parquet");
}

/// Published objects are often all called `decomposed.obj`.
#[test]
fn an_object_is_called_as_asked() {
    let desk = with_table();
    let line = "import t.csv --hand gripper_parallel --object ball -q";
    desk.said(&format!("{line} --name mug -o mug.parquet"));
    let file = desk.grasps("mug.parquet");
    assert_eq!(file.metadata.objects[0].name, "mug");
    assert!(file.grasps.iter().all(|grasp| grasp.object == "mug"));
    let mistake = desk.mistake(&format!("{line} --name a/b -o x.parquet"));
    assert_says(&mistake, &["--name", "without slashes"]);
    // Of a table of several objects it says which one the file is.
    let two = TABLE
        .replace("id,", "object,id,")
        .replace("\n7,", "\ndecomposed,7,");
    let two = two
        .replace("\n9,", "\nmug,9,")
        .replace("\n11,", "\nmug,11,");
    desk.write("two.csv", two);
    let line = "import two.csv --hand gripper_parallel --object ball -q";
    assert_says(&desk.mistake(line), &["2 objects", "--name"]);
    desk.said(&format!("{line} --name mug -o two.parquet"));
    let ids: Vec<u64> = (desk.grasps("two.parquet").grasps.iter())
        .map(|grasp| grasp.id)
        .collect();
    assert_eq!(ids, [9, 11]);
}

/// Names with quotes, line breaks and digits, and numbers of 64 bits.
#[test]
fn names_and_numbers_come_back_from_tables() {
    let desk = with_table();
    let known = desk.grasps("t.parquet").grasps[0].clone();
    let joints = ["jaw".to_owned()];
    let hostile = concat!(
        "a,b|\"|'|a\nb|a\r\nb|#|\u{1b}[2J|\0|1e3|007|",
        "-0|NaN|[1 2]|1;2|=1+1|שלום|👩🏽\u{200d}🚀|<!--|\u{202e}|9007199254740993",
    );
    let hostile: Vec<&str> = hostile.split('|').collect();
    let name = prop_oneof![
        proptest::sample::select(hostile).prop_map(str::to_owned),
        any::<String>(),
    ];
    let id = prop_oneof![any::<u64>(), Just(u64::MAX), Just((1 << 53) + 1), 0..9_u64];
    let strategy = (id, name.clone(), name);
    let mut runner = proptest::test_runner::TestRunner::default();
    let held = runner.run(&strategy, |(id, object, label)| {
        // What surrounds a name is no part of it.
        let [object, label] = [object, label].map(|name| name.trim().to_owned());
        let grasp = GraspRow {
            id,
            object: object.clone(),
            label: Some(label.clone()),
            ..known.clone()
        };
        let filled = |name: String| Some(name).filter(|name| !name.is_empty());
        for (ending, bytes) in [
            ("csv", table_csv(&[&grasp], &joints)),
            ("json", table_json(&[&grasp], &joints)),
        ] {
            let path = desk.path(&format!("h.{ending}"));
            fs::write(&path, bytes).unwrap();
            let found = read(&path, &joints, &Mapping::default()).unwrap();
            let found = &found.grasps[0];
            prop_assert_eq!(found.id, Some(id));
            prop_assert_eq!(
                filled(found.object.clone().unwrap_or_default()),
                filled(object.clone())
            );
            prop_assert_eq!(
                filled(found.label.clone().unwrap_or_default()),
                filled(label.clone())
            );
            prop_assert_eq!(found.pose.joints(), known.grasp.pose.joints());
        }
        Ok(())
    });
    held.unwrap();
}

#[test]
fn mappings_rename_and_convert() {
    let desk = with_table();
    let before = desk.grasps("t.parquet");
    // Millimetres, the object in the hand, x y z w.
    let entry = |grasp: &GraspRow| {
        let pose = &grasp.grasp.pose;
        let [w, x, y, z] = pose.rotation_wxyz();
        let q = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z))
            .inverse();
        let t = q * -nalgebra::Vector3::from_column_slice(pose.translation_m()) * 1e3;
        format!(
            "{{\"p\": [{}, {}, {}], \"quat\": [{}, {}, {}, {}], \"q\": [{}]}},",
            t.x,
            t.y,
            t.z,
            q.i,
            q.j,
            q.k,
            q.w,
            pose.joints()[0]
        )
    };
    let text: String = before.grasps.iter().map(entry).collect();
    desk.write(
        "m.json",
        format!("{{\"grasps\": [{}]}}", text.trim_end_matches(',')),
    );
    let mapping = "translation = \"p\"\ntranslation_unit = \"mm\"\nrotation = \"quat\"\nrotation_form = \"xyzw\"\n\
        frame = \"hand_from_object\"\njoints = \"q\"\nscale = 1.0\n";
    desk.write("m.toml", mapping);
    let said = desk
        .said("import m.json --hand gripper_parallel --object ball --mapping m.toml -o m.parquet");
    assert_says(&said, &["column `q` does not name its joints"]);
    let off = difference(&before, &desk.grasps("m.parquet"));
    assert!(off < 1e-12, "{off}");
    // Other forms of one rotation, through the library.
    let joints = vec!["jaw".to_owned()];
    let columns = |names: &[&str]| {
        Some(Columns::Each(
            names.iter().map(ToString::to_string).collect(),
        ))
    };
    let path = desk.path("forms.csv");
    let half = std::f64::consts::FRAC_PI_2;
    fs::write(&path, format!("x,y,z,a,b,c,r1,r2,r3,m,finger\n1,2,3,0,0,90,0,0,{half},0 -1 0 1 0 0 0 0 1,57.29577951308232\n")).unwrap();
    for (rotation, form, unit) in [
        (columns(&["a", "b", "c"]), "fixed_xyz", "deg"),
        (columns(&["r1", "r2", "r3"]), "rotation_vector", "rad"),
        (Some(Columns::List("m".to_owned())), "matrix", "rad"),
    ] {
        let mapping = Mapping {
            translation: columns(&["x", "y", "z"]),
            rotation,
            rotation_form: serde_json::from_value(form.into()).unwrap(),
            rotation_unit: serde_json::from_value(unit.into()).unwrap(),
            joints: Some(JointColumns::Each(
                [("jaw".to_owned(), "finger".to_owned())].into(),
            )),
            joint_unit: serde_json::from_value("deg".into()).unwrap(),
            ..Mapping::default()
        };
        let grasp = &read(&path, &joints, &mapping).unwrap().grasps[0];
        let expected = [
            libm::cos(half).mul_add(0.0, 0.5f64.sqrt()),
            0.0,
            0.0,
            0.5f64.sqrt(),
        ];
        for (q, e) in grasp.pose.rotation_wxyz().iter().zip(expected) {
            assert!((q - e).abs() < 1e-12, "{form}: {:?}", grasp.pose);
        }
        assert!((grasp.pose.joints()[0] - 1.0).abs() < 1e-12);
    }
}

#[test]
fn dictionaries_of_dexgraspbench_are_read() {
    let desk = Desk::empty();
    for (name, bytes) in ["a.npy", "b.npy", "c.npy"].iter().zip(bench()) {
        desk.write(name, bytes);
        let read = read(&desk.path(name), &["jaw".to_owned()], &Mapping::default()).unwrap();
        assert_eq!((read.format, read.grasps.len()), ("DexGraspBench", 2));
        assert_says(&read.notes[0], &["hand's order, jaw"]);
        // The object stands at (0.1, 0.2, 0.3), turned by a right angle about z.
        let [first, second] = &read.grasps[..] else {
            panic!("two grasps")
        };
        for (x, e) in first.pose.translation_m().iter().zip([-0.19, 0.05, -0.3]) {
            assert!((x - e).abs() < 1e-7, "{:?}", first.pose);
        }
        let half = 0.5f64.sqrt();
        for (q, e) in first
            .pose
            .rotation_wxyz()
            .iter()
            .zip([half, half, 0.0, 0.0])
        {
            assert!((q.abs() - e).abs() < 1e-7, "{:?}", first.pose);
        }
        assert!((second.pose.joints()[0] - 0.015).abs() < 1e-8 && second.scale == Some(1.0));
    }
    let said = desk.said("import . --hand gripper_parallel --object ball -o all.parquet");
    assert_says(&said, &["DexGraspBench", "found"]);
}

/// A hand whose palm is moved and rotated from the origin. MuJoCo Menagerie's Shadow hand is moved by 34 mm.
const OFFSET_HAND: &str = r#"<mujoco><compiler angle="radian"/><worldbody>
<body name="palm" pos="0.01 0 0.034" quat="0.8 0 0.6 0"><geom type="box" size="0.03 0.01 0.03"/>
<body name="thumb" pos="-0.02 0 0.03"><geom type="capsule" fromto="0 0 0 0 0 0.05" size="0.008"/></body>
<body name="finger" pos="0.02 0 0.03"><joint name="jaw" axis="0 1 0" range="-1 1"/>
<geom type="capsule" fromto="0 0 0 0 0 0.05" size="0.008"/></body></body></worldbody></mujoco>"#;

/// The rows of a model whose joints move the whole hand hold the coordinates of these joints.
#[test]
fn a_qpos_holds_the_joints_of_a_virtual_wrist() {
    let desk = Desk::empty();
    let slide = |(name, axis)| format!("<joint name=\"{name}\" type=\"slide\" axis=\"{axis}\"/>");
    let slides = [("x", "1 0 0"), ("y", "0 1 0"), ("z", "0 0 -1")].map(slide);
    let wrist = slides.concat() + "<joint name=\"turn\" axis=\"0 0 1\"/>";
    let hand = OFFSET_HAND.replace(
        " pos=\"0.01 0 0.034\" quat=\"0.8 0 0.6 0\">",
        &format!(">{wrist}"),
    );
    desk.write("wrist.xml", hand);
    desk.write(
        "t.csv",
        TABLE
            .replace("0.5,0.5,-0.5,0.5", "0.8,0,0,0.6")
            .lines()
            .take(2)
            .collect::<Vec<_>>()
            .join("\n"),
    );
    desk.said("import t.csv --hand wrist.xml --object ball -o t.parquet");
    desk.said("export t.parquet qpos");
    let text = desk.text("t.qpos.csv");
    let (head, row) = text.trim_end().split_once('\n').unwrap();
    assert_eq!(head, "id,x,y,z,turn,jaw");
    let numbers: Vec<f64> = row.split(',').map(|q| q.parse().unwrap()).collect();
    let expected = [
        7.0,
        0.1,
        0.02,
        -0.033_333_333_333_333_3,
        2.0 * libm::atan2(0.6, 0.8),
        0.025,
    ];
    for (q, expected) in numbers.iter().zip(expected) {
        assert!((q - expected).abs() < 1e-9, "{row}");
    }
}
