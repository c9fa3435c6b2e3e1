//! Formats of parallel grippers: `isaac_grasp` and `GraspGen`.

use super::{difference, with_table};
use crate::desk::{Desk, assert_says};

const OF: &str = "--hand gripper_parallel --object ball -q";

#[test]
fn isaac_grasp_comes_back() {
    let desk = with_table();
    let before = desk.grasps("t.parquet");
    desk.said("export t.parquet isaac_grasp -o g.yaml");
    // The gripper opens to the upper limit of its joint.
    assert_says(
        &desk.text("g.yaml"),
        &["object_scale: 1.0\nopen_limit: upper\n"],
    );
    desk.said(&format!("import g.yaml {OF} -o g.parquet"));
    let after = desk.grasps("g.parquet");
    for (one, two) in before.grasps.iter().zip(&after.grasps) {
        assert_eq!((one.id, one.scale), (two.id, two.scale));
        assert_eq!(one.grasp.pose, two.grasp.pose);
    }
}

/// As a person writes one: a path as frame, the joint that follows, other order, a grasp that failed.
const STRANGE: &str = r#"
format: isaac_grasp
format_version: "1.0"
object_frame_link: /World/ball
gripper_frame_link: /World/jaw_1
grasps:
  first:
    orientation: {xyz: [0.0, 0.0, 0.0], w: 1}
    position:
    - 0.03
    - 0.0
    - -0.07
    cspace_position: {jaw_2_follows: 0.03, jaw: 0.03}
    confidence: 0.0
"#;

#[test]
fn the_frame_of_isaac_grasp_is_a_link() {
    let desk = Desk::empty();
    desk.write("g.yaml", STRANGE);
    let of = "--hand gripper_parallel --object ball";
    let said = desk.said(&format!("import g.yaml {of} -o a.parquet"));
    assert_says(&said, &["1 of 1 grasp have confidence 0"]);
    // The jaw is 3 cm from the root.
    let pose = &desk.grasps("a.parquet").grasps[0].grasp.pose;
    for (x, expected) in pose.iter().zip([0.0, 0.0, -0.07, 1.0, 0.0, 0.0, 0.0, 0.03]) {
        assert!((x - expected).abs() < 1e-12, "{pose:?}");
    }
    desk.write("h.yaml", STRANGE.replace("jaw_1", "panda_hand"));
    let said = desk.said(&format!("import h.yaml {of} -o b.parquet"));
    assert_says(
        &said,
        &["`/World/panda_hand`, which is not a link", "root `palm`"],
    );
    desk.write("m.toml", "link = \"jaw_1\"");
    desk.said(&format!("import h.yaml {of} --mapping m.toml -o c.parquet"));
    assert!(difference(&desk.grasps("a.parquet"), &desk.grasps("c.parquet")) < 1e-15);
}

#[test]
fn graspgen_goes_out_and_in_without_joints() {
    let desk = with_table();
    desk.said("export t.parquet graspgen -o g.json");
    let said = desk.said("import g.json --hand gripper_parallel --object ball -o g.parquet");
    assert_says(&said, &["the file has no joints", "rest pose (jaw 0.0"]);
    let mut before = desk.grasps("t.parquet");
    let after = desk.grasps("g.parquet");
    for (one, two) in before.grasps.iter_mut().zip(&after.grasps) {
        let joints = two.grasp.pose.joints();
        let pose = &one.grasp.pose;
        let root = std::array::from_fn(|axis| pose[axis]);
        one.grasp.pose = landscape::space::Pose::new(root, pose.rotation_wxyz(), joints);
    }
    assert!(difference(&before, &after) < 1e-12);
}
