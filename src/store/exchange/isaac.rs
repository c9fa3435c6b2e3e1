//! `isaac_grasp` 1.0, the YAML files of Isaac Sim's grasp editor, of `GraspGen` and of `GraspDataGen`.

use std::fmt::Write as _;

use super::hand_joints::HandJoints;
use super::joints::{follows, matched};
use super::mapping::{Mapping, RotationForm};
use super::{Published, Read, finite};
use crate::formats::yaml_text::{self, Yaml};
use crate::printable::counted;
use crate::space::Pose;
use crate::store::GraspRow;

const FORMAT: &str = "isaac_grasp";
/// Joint coordinates at the grasp, and before the hand closes.
const JOINTS: [&str; 2] = ["cspace_position", "pregrasp_cspace_position"];
/// Beginning of the names of grasps that hold their id.
const NAME: &str = "grasp_";

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
/// readers that ask for it. `object_scale` and `open_limit` are keys of `GraspDataGen`: the latter is the limit towards which
/// all joints open, and is left out if there is none. Its other keys (`object_file`, `gripper_file`, `finger_colliders`, …) are
/// names of files and parts that are not known here.
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
         object_frame: {object}\ngripper_frame: {gripper}\n\n\
         created_with: landscape\n",
        object = quoted(object),
        gripper = quoted(gripper),
    );
    if let Some(first) = grasps.first() {
        let _ = writeln!(text, "object_scale: {}", number(first.grasp.scale));
    }
    if let Some(limit) = open_limit(grasps) {
        let _ = writeln!(text, "open_limit: {limit}");
    }
    text.push_str("\ngrasps:\n");
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
        let _ = writeln!(text, "  \"{NAME}{}\":", grasp.id);
        let _ = writeln!(text, "    confidence: {}", number(*confidence));
        let position: Vec<String> = pose.translation_m().iter().map(|x| number(*x)).collect();
        let _ = writeln!(text, "    position: [{}]", position.join(", "));
        let _ = writeln!(text, "    orientation: {{w: {w}, xyz: [{x}, {y}, {z}]}}");
        for (key, values) in JOINTS.into_iter().zip([pose.joints(), before]) {
            write_joints(&mut text, key, joint_names, values);
        }
    }
    text.into_bytes()
}

/// The limit towards which the joints of all grasps open.
fn open_limit(grasps: &[IsaacGrasp<'_>]) -> Option<&'static str> {
    let ways = grasps.iter().flat_map(|grasp| {
        let joints = grasp.grasp.grasp.pose.joints().iter();
        joints.zip(&grasp.before).map(|(at, before)| before - at)
    });
    let ways: Vec<f64> = ways.filter(|way| *way != 0.0).collect();
    match (
        ways.iter().all(|way| *way > 0.0),
        ways.iter().all(|way| *way < 0.0),
    ) {
        (true, false) => Some("upper"),
        (false, true) => Some("lower"),
        _ => None,
    }
}

fn write_joints(text: &mut String, key: &str, names: &[String], values: &[f64]) {
    if names.is_empty() {
        let _ = writeln!(text, "    {key}: {{}}");
        return;
    }
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

/// Reads the grasps of a file. Joints that follow others may be in it and are left out; all others of the hand must be there.
/// If no grasp has joints, as in files of `GraspGen`, the hand is in its rest pose.
pub(super) fn read(text: &str, hand: &HandJoints, mapping: &Mapping) -> Result<Read, String> {
    let file = yaml_text::parse(text)?;
    let top = |key: &str| file.get(key).and_then(Yaml::text);
    if top("format") != Some(FORMAT) {
        return Err(format!(
            "it is YAML, but its entry `format` is not {FORMAT}: {}",
            super::unread::INSTEAD
        ));
    }
    if let Some(version) = top("format_version").filter(|version| !version.starts_with('1')) {
        return Err(format!(
            "its `format_version` is {version}, but 1.0 is read"
        ));
    }
    if mapping.rotation_form != RotationForm::default() {
        return Err(
            "the numbers of its quaternions are named: leave `rotation_form` out of the mapping"
                .to_owned(),
        );
    }
    let named = |keys: [&str; 2]| keys.into_iter().find_map(top);
    let object = named(["object_frame_link", "object_frame"]);
    let scale = match file.get("object_scale") {
        Some(scale) => Some(scale.number().ok_or("its `object_scale` is not a number")?),
        None => None,
    };
    let grasps = file.get("grasps").and_then(Yaml::entries);
    let grasps = grasps.ok_or("its entry `grasps` is not a map of grasps by name")?;
    let mut read = Read {
        format: FORMAT,
        link: named(["gripper_frame_link", "gripper_frame"]).map(str::to_owned),
        ..Read::default()
    };
    let mut without_confidence = 0;
    for (name, grasp) in grasps {
        let reader = Reader {
            hand,
            mapping,
            grasp,
        };
        let (pose, confidence) = reader
            .pose(&mut read.notes)
            .map_err(|problem| format!("grasp `{name}`: {problem}"))?;
        without_confidence += usize::from(confidence == Some(0.0));
        read.grasps.push(Published {
            id: name.strip_prefix(NAME).and_then(|id| id.parse().ok()),
            pose,
            scale,
            object: object.map(|path| last(path).to_owned()),
            ..Published::default()
        });
    }
    if without_confidence > 0 {
        read.notes.push(format!(
            "{without_confidence} of {} have confidence 0, which other programs leave out; they are kept",
            counted(grasps.len(), "grasp")
        ));
    }
    Ok(read)
}

/// The last part of a path of USD.
fn last(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

/// A grasp that is read.
struct Reader<'a> {
    hand: &'a HandJoints,
    mapping: &'a Mapping,
    grasp: &'a Yaml,
}

impl Reader<'_> {
    /// The pose, and the confidence if there is one.
    fn pose(&self, notes: &mut Vec<String>) -> Result<(Pose, Option<f64>), String> {
        let place = self.grasp.get("position").and_then(Yaml::numbers);
        let place = place.and_then(|place| <[f64; 3]>::try_from(place).ok());
        let place = place.ok_or("its `position` is not a list of three numbers")?;
        let turn = self.grasp.get("orientation");
        let real = turn.and_then(|turn| turn.get("w")?.number());
        let rest = turn.and_then(|turn| <[f64; 3]>::try_from(turn.get("xyz")?.numbers()?).ok());
        let (Some(w), Some([x, y, z])) = (real, rest) else {
            return Err(
                "its `orientation` is not a number `w` and a list `xyz` of three".to_owned(),
            );
        };
        let root = [&place[..], &[w, x, y, z]].concat();
        super::dexgraspbench::isometry(&root, "its position and orientation")?;
        let joints = self.joints(notes)?;
        let (translation_m, rotation_wxyz) = self.mapping.directed(place, [w, x, y, z]);
        let confidence = match self.grasp.get("confidence") {
            Some(given) => Some(given.number().ok_or("its `confidence` is not a number")?),
            None => None,
        };
        Ok((Pose::new(translation_m, rotation_wxyz, &joints), confidence))
    }

    /// The joint coordinates in the order of the hand.
    fn joints(&self, notes: &mut Vec<String>) -> Result<Vec<f64>, String> {
        let given = JOINTS
            .into_iter()
            .find_map(|key| Some((key, self.grasp.get(key)?)));
        let mut note = |note: String| {
            if !notes.contains(&note) {
                notes.push(note);
            }
        };
        let Some((key, given)) = given else {
            let (rest, text) = self.hand.at_rest()?;
            note(text);
            return Ok(rest);
        };
        if key != JOINTS[0] {
            note(format!(
                "grasps without `{}` have the joints of `{key}`",
                JOINTS[0]
            ));
        }
        let given = given.entries();
        let given = given.ok_or_else(|| format!("its `{key}` is not a map of joints"))?;
        let own = given
            .iter()
            .filter(|(name, _)| !follows(name, &self.hand.names, &self.hand.following));
        let own: Vec<&(String, Yaml)> = own.collect();
        let names: Vec<&str> = match &self.mapping.joint_names {
            Some(names) if names.len() == own.len() => names.iter().map(String::as_str).collect(),
            Some(names) => {
                return Err(format!(
                    "it has {}, but the mapping names {}",
                    counted(own.len(), "joint"),
                    names.len()
                ));
            }
            None => own.iter().map(|(name, _)| name.as_str()).collect(),
        };
        let unit = self.mapping.joint_unit.radians();
        let value = |place: usize| {
            let (name, value) = own[place];
            let value = value
                .number()
                .ok_or_else(|| format!("joint `{name}` is not a number"))?;
            finite(&[value], &format!("joint `{name}`"))?;
            Ok(unit * value)
        };
        matched(&names, &self.hand.names)?
            .into_iter()
            .map(value)
            .collect()
    }
}
