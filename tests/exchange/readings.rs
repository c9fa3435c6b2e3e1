//! Grasps that lie beside their object because their file is read wrongly, and grasps that are meant so.

use std::fs;

use crate::desk::{Desk, assert_says};
use landscape::space::Pose;
use landscape::store::exchange::table_csv;
use landscape::store::{GraspFile, GraspRow, Overrides};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

const OF: &str = "--hand human --object bottle_round";

/// Grasps that hold.
fn published() -> Vec<GraspRow> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/grasps.parquet");
    let file = GraspFile::read(&path, Overrides::default()).unwrap().0;
    file.grasps.into_iter().take(8).collect()
}

/// Writes the grasps as a table, each changed.
fn write(desk: &Desk, name: &str, change: impl Fn(&Pose) -> Pose) {
    let mut rows = published();
    for row in &mut rows {
        row.grasp.pose = change(&row.grasp.pose);
    }
    let rows: Vec<&GraspRow> = rows.iter().collect();
    let joints: Vec<String> = (landscape::hand::Hand::human().joints.iter())
        .map(|joint| joint.name.clone())
        .collect();
    desk.write(name, table_csv(&rows, &joints));
}

fn scaled(pose: &Pose, factor: f64) -> Pose {
    let t: Vec<f64> = pose.translation_m().iter().map(|x| factor * x).collect();
    Pose::new([t[0], t[1], t[2]], pose.rotation_wxyz(), pose.joints())
}

/// The quaternion x y z w in the columns w x y z.
fn reordered(pose: &Pose) -> Pose {
    let [w, x, y, z] = pose.rotation_wxyz();
    let t = pose.translation_m();
    Pose::new([t[0], t[1], t[2]], [x, y, z, w], pose.joints())
}

fn inverted(pose: &Pose) -> Pose {
    let [w, x, y, z] = pose.rotation_wxyz();
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).inverse();
    let t = turn * -Vector3::from_column_slice(pose.translation_m());
    Pose::new(t.into(), [turn.w, turn.i, turn.j, turn.k], pose.joints())
}

fn moved(pose: &Pose, by: [f64; 3]) -> Pose {
    let t = pose.translation_m();
    let t = std::array::from_fn(|axis| t[axis] + by[axis]);
    Pose::new(t, pose.rotation_wxyz(), pose.joints())
}

#[test]
fn another_unit_is_refused_and_named() {
    let desk = Desk::empty();
    for (factor, unit, word) in [(1e3, "mm", "millimetres"), (1e2, "cm", "centimetres")] {
        write(&desk, "t.csv", |pose| scaled(pose, factor));
        let said = desk.mistake(&format!("import t.csv {OF} -o t.parquet"));
        assert_says(
            &said,
            &[
                "t.csv: the median of 8 grasps is",
                "m from bottle_round",
                word,
                &format!("`translation_unit = \"{unit}\"`"),
            ],
        );
        assert!(!desk.path("t.parquet").exists());
        desk.write("m.toml", format!("translation_unit = \"{unit}\""));
        let said = desk.said(&format!(
            "import t.csv {OF} --mapping m.toml -o t.parquet --force"
        ));
        assert!(!said.contains("probably"), "{said}");
        fs::remove_file(desk.path("t.parquet")).unwrap();
    }
    // A stated unit is believed, and the doubt is kept in the file.
    desk.write("m.toml", "translation_unit = \"m\"");
    let said = desk.said(&format!("import t.csv {OF} --mapping m.toml -o t.parquet"));
    assert_says(&said, &["warning: t.csv: the median", "centimetres"]);
    let settings = desk.grasps("t.parquet").metadata.settings;
    for key in ["doubt", "notes"] {
        assert_says(&settings[key].to_string(), &["centimetres"]);
    }
}

#[test]
fn another_order_direction_or_origin_is_named() {
    type Change = fn(&Pose) -> Pose;
    let desk = Desk::empty();
    let changes: [(Change, &[&str]); 5] = [
        (reordered, &["order x y z w", "`rotation_form = \"xyzw\"`"]),
        (
            inverted,
            &[
                "object in the hand's frame",
                "`frame = \"hand_from_object\"`",
            ],
        ),
        (
            |pose| scaled(&reordered(pose), 1e3),
            &[
                "millimetres and its quaternions",
                "`translation_unit = \"mm\"` and `rotation_form",
            ],
        ),
        (
            |pose| moved(pose, [0.0, 0.03, 0.0]),
            &[
                "the origin of bottle_round is another one",
                "move the vertices of the mesh by about (0, 30, ",
                "mm",
            ],
        ),
        (
            |pose| {
                let joints: Vec<f64> = pose.joints().iter().map(|q| q.to_degrees()).collect();
                let t = pose.translation_m();
                Pose::new([t[0], t[1], t[2]], pose.rotation_wxyz(), &joints)
            },
            &["joint `", "degrees", "`joint_unit = \"deg\"`"],
        ),
    ];
    for (place, (change, words)) in changes.into_iter().enumerate() {
        write(&desk, "t.csv", change);
        let output = desk.run(&format!("import t.csv {OF} -o t{place}.parquet"));
        let said = String::from_utf8(output.stderr).unwrap();
        assert_says(&said, words);
        assert_says(&said, &["t.csv: ", "; probably "]);
        // Units and joints beyond all limits are refused; the other readings are only doubted.
        assert_eq!(output.status.success(), ![2, 4].contains(&place), "{said}");
    }
}

/// Neither grasps that hold, nor hands that have not closed yet, nor those that someone posed roughly.
#[test]
fn plausible_grasps_are_not_doubted() {
    let desk = Desk::empty();
    let away = |pose: &Pose, by: f64| {
        // Away from the axis of the bottle.
        let t = pose.translation_m();
        let radius = libm::hypot(t[0], t[1]);
        moved(pose, [by * t[0] / radius, by * t[1] / radius, 0.0])
    };
    let open = |pose: &Pose| {
        let t = pose.translation_m();
        let joints = vec![0.0; pose.joints().len()];
        let open = Pose::new([t[0], t[1], t[2]], pose.rotation_wxyz(), &joints);
        away(&open, 0.02)
    };
    let changes: [&dyn Fn(&Pose) -> Pose; 4] = [
        &Pose::clone,
        &|pose| away(pose, 0.004),
        &|pose| away(pose, -0.004),
        &open,
    ];
    for (place, change) in changes.into_iter().enumerate() {
        write(&desk, "t.csv", change);
        let said = desk.said(&format!("import t.csv {OF} -o t{place}.parquet"));
        assert!(!said.contains("probably"), "{place}: {said}");
    }
}
