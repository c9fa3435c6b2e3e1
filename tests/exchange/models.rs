//! Hands and grasps as models of other simulators.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::{difference, with_table};
use crate::described::described;
use crate::desk::{Desk, assert_says};
use landscape::hand::{HAND_NAMES, Hand, HandFiles, PosedHand};
use landscape::space::Pose;
use landscape::study::{ExportedFile, hand_urdf};

/// Coordinates that do not begin at zero, a joint that follows another, one without end, a slide, a body fixed to another,
/// and names that XML has to escape.
const ODD: &str = r#"<mujoco model="odd &amp; &lt;small&gt;"><compiler angle="radian" autolimits="true"/><worldbody>
<body name="palm"><geom type="box" size="0.03 0.02 0.01"/>
  <body name="first" pos="0.03 0 0.01" euler="0.3 1.5707963 -0.4">
    <joint name="a&quot;b" axis="0 1 0" range="-0.3 1.2" ref="0.4"/><geom type="capsule" fromto="0 0 0 0 0 0.04" size="0.008"/>
    <body name="second" pos="0 0 0.04">
      <joint name="follower" axis="0 1 0" range="-2 2"/><geom type="sphere" size="0.009" pos="0 0 0.02"/>
    </body>
  </body>
  <body name="other" pos="-0.03 0 0.01">
    <joint name="endless" axis="1 0 1"/><geom type="cylinder" size="0.007 0.02" pos="0 0 0.02"/>
    <body name="nail" pos="0 0 0.05" quat="0.8 0 0.6 0"><geom type="capsule" fromto="0 0 0 0 0 -0.02" size="0.004"/></body>
  </body>
  <body name="jaw" pos="0 0.03 0.02"><joint name="slide" type="slide" axis="0 -1 0" range="0 0.02"/>
    <geom type="box" size="0.01 0.004 0.01"/></body>
</body></worldbody>
<equality><joint joint1="follower" joint2="a&quot;b" polycoef="0.1 0.7 0 0 0"/></equality></mujoco>"#;

fn hands() -> Vec<Hand> {
    let named = HAND_NAMES
        .iter()
        .map(|name| HandFiles::named(name).unwrap());
    let named = named.map(|files| Hand::from_files(&files).unwrap());
    named.chain([described(ODD, None).unwrap()]).collect()
}

fn write(folder: &Path, files: &[ExportedFile]) {
    for file in files {
        fs::write(folder.join(&file.name), &file.bytes).unwrap();
    }
}

/// Places of links by name at these coordinates.
fn frames(hand: &Hand, joints: &[f64]) -> BTreeMap<String, landscape::hand::Frame> {
    let mut posed = PosedHand::default();
    hand.pose(&Pose::at_origin(joints), &mut posed);
    let names = hand.links.iter().map(|link| link.name.clone());
    names.zip(posed.object_from_link).collect()
}

#[test]
fn a_hand_comes_back_from_urdf() {
    for hand in hands() {
        let desk = Desk::empty();
        let files = hand_urdf(&hand).unwrap();
        write(&desk.path(""), &files);
        let again =
            Hand::from_files(&HandFiles::load(&desk.path(&files[0].name)).unwrap()).unwrap();
        let told = |hand: &Hand| -> Vec<(String, bool)> {
            let joints = hand.joints.iter();
            joints
                .map(|joint| (joint.name.clone(), joint.wraps))
                .collect()
        };
        assert_eq!(told(&hand), told(&again), "{}", hand.name);
        for (one, two) in hand.joints.iter().zip(&again.joints) {
            for (limit, other) in one.limits.iter().zip(two.limits) {
                assert!((limit - other).abs() < 1e-12, "{}: {}", hand.name, one.name);
            }
        }
        for share in [0.0, 0.3, 0.5, 0.9, 1.0] {
            let limits = hand.joints.iter().map(|joint| joint.limits);
            let joints: Vec<f64> = limits.map(|[a, b]| a + share * (b - a)).collect();
            let (one, two) = (frames(&hand, &joints), frames(&again, &joints));
            assert_eq!(one.len(), two.len());
            for (name, frame) in one {
                let other = &two[&name];
                let off = (frame.translation - other.translation).norm()
                    + (frame.rotation - other.rotation).norm();
                assert!(off < 1e-13, "{} {name}: {off}", hand.name);
            }
        }
    }
}

#[test]
fn dictionaries_of_dexonomy_come_back() {
    let desk = with_table();
    let before = desk.grasps("t.parquet");
    desk.said("export t.parquet dexonomy");
    let names: Vec<String> = ["07", "09", "11"].map(|id| format!("{id}.npy")).into();
    for name in &names {
        assert!(desk.path("t.dexonomy").join(name).is_file());
    }
    let line = "--hand gripper_parallel --object ball -q";
    desk.said(&format!("import t.dexonomy {line} -o again.parquet"));
    assert!(difference(&before, &desk.grasps("again.parquet")) <= 0.0);
    desk.said("export t.parquet dexonomy --grasp 9 -o nine.npy");
    let one = desk.path("t.dexonomy").join("09.npy");
    assert_eq!(fs::read(one).unwrap(), desk.bytes("nine.npy"));
    assert_says(
        &desk.mistake("export t.parquet dexonomy -o many.npy -q"),
        &["many.npy", "--grasp", "folder"],
    );
}

/// A scene and a file of Isaac hold one hand and one object.
#[test]
fn several_objects_need_a_choice() {
    let desk = with_table();
    let two = super::TABLE.replace("\n9,1,", "\n9,1.25,");
    desk.write("two.csv", two);
    desk.said("import two.csv --hand gripper_parallel --object ball -o two.parquet");
    for format in ["mujoco", "isaac_grasp"] {
        let sentence = desk.mistake(&format!("export two.parquet {format} -q"));
        assert_says(&sentence, &["one object", "of scale 1.25", "--grasp"]);
        desk.said(&format!("export two.parquet {format} --grasp 9"));
    }
    assert_says(
        &desk.mistake("export two.parquet isaac_grasp -o grasps.txt"),
        &["grasps.txt", ".yaml"],
    );
    for format in ["usd", "dexonomy", "urdf"] {
        desk.said(&format!("export two.parquet {format}"));
    }
    let text = desk.text("two.isaac_grasp.yaml");
    for line in [
        "format: isaac_grasp\n",
        "format_version: 1.0\n",
        // The keys of Isaac Sim and those of Isaac ROS.
        "object_frame_link: \"ball\"\ngripper_frame_link: \"palm\"\n",
        "object_frame: \"ball\"\ngripper_frame: \"palm\"\n",
        "  \"grasp_9\":\n    confidence: 1.0\n    position: [-0.08, 0.011, 0.05]\n    orientation: {w: 0.6, xyz: [0.0, 0.8, 0.0]}\n",
        "    cspace_position:\n      \"jaw\": 0.0301234567890123\n    pregrasp_cspace_position:\n",
    ] {
        assert!(text.contains(line), "{text}");
    }
}
