//! `isaac_grasp` 1.0, the YAML files of Isaac Sim's grasp editor.

use std::fmt::Write as _;

use crate::store::GraspRow;

/// A grasp with what the format has besides its pose.
#[derive(Debug, Clone, PartialEq)]
pub struct IsaacGrasp<'a> {
    /// The grasp.
    pub grasp: &'a GraspRow,
    /// Between 0 and 1.
    pub confidence: f64,
    /// Joint coordinates before the hand closes, radians or metres.
    pub before: Vec<f64>,
}

/// The grasps of one hand with joints `joint_names` on one object, as YAML. Positions and orientations are those of the
/// link `gripper` in the frame of the object.
///
/// The frames are named twice: `object_frame_link` is the key of Isaac Sim, `object_frame` that of Isaac ROS, and each has
/// readers that ask for it.
pub fn isaac_grasp(
    object: &str,
    gripper: &str,
    joint_names: &[String],
    grasps: &[IsaacGrasp<'_>],
) -> Vec<u8> {
    let mut text = format!(
        "# Made by landscape. Poses of the gripper in the frame of the object: metres, radians.\n\
         format: isaac_grasp\nformat_version: 1.0\n\n\
         object_frame_link: {object}\ngripper_frame_link: {gripper}\n\
         object_frame: {object}\ngripper_frame: {gripper}\n\ngrasps:\n",
        object = quoted(object),
        gripper = quoted(gripper),
    );
    if grasps.is_empty() {
        text.truncate(text.len() - 1);
        text.push_str(" {}\n");
    }
    for IsaacGrasp {
        grasp,
        confidence,
        before,
    } in grasps
    {
        let pose = &grasp.grasp.pose;
        let [w, x, y, z] = pose.rotation_wxyz().map(number);
        let _ = writeln!(text, "  \"grasp_{}\":", grasp.id);
        let _ = writeln!(text, "    confidence: {}", number(*confidence));
        let position: Vec<String> = pose.translation_m().iter().map(|x| number(*x)).collect();
        let _ = writeln!(text, "    position: [{}]", position.join(", "));
        let _ = writeln!(text, "    orientation: {{w: {w}, xyz: [{x}, {y}, {z}]}}");
        joints(&mut text, "cspace_position", joint_names, pose.joints());
        joints(&mut text, "pregrasp_cspace_position", joint_names, before);
    }
    text.into_bytes()
}

fn joints(text: &mut String, key: &str, names: &[String], values: &[f64]) {
    let _ = writeln!(text, "    {key}:");
    for (name, value) in names.iter().zip(values) {
        let _ = writeln!(text, "      {}: {}", quoted(name), number(*value));
    }
}

/// A number that every reader of YAML takes for one: always with a point, never with an exponent.
fn number(value: f64) -> String {
    let text = (value + 0.0).to_string();
    if text.contains('.') {
        text
    } else {
        format!("{text}.0")
    }
}

/// Text in double quotes: JSON's strings are YAML's.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
