//! `GraspGen` (JSON): poses of a gripper without joints, `{"object": {"file", "scale"}, "grasps": {"transforms",
//! "object_in_gripper"}}`.

use nalgebra::{Quaternion, UnitQuaternion};
use serde_json::{Value, json};

use super::hand_joints::HandJoints;
use super::mapping::{Mapping, RotationForm};
use super::{Published, Read};
use crate::printable::counted;
use crate::space::Pose;
use crate::store::GraspRow;

/// Largest deviation of the last row of a transform from 0 0 0 1.
const TOLERANCE: f64 = 1e-6;

/// Grasps of one hand on one object, as JSON. Poses are those of the hand's root in the frame of the object at its scale.
/// Only a grasp that did not hold in simulation is marked as one without its object.
pub fn graspgen_json(object: &str, scale: f64, grasps: &[&GraspRow]) -> Vec<u8> {
    let transforms = grasps.iter().map(|grasp| transform(&grasp.grasp.pose));
    let transforms: Vec<[[f64; 4]; 4]> = transforms.collect();
    let held = grasps.iter().map(|grasp| grasp.stable != Some(false));
    let held: Vec<bool> = held.collect();
    let whole = json!({
        "made_by": "landscape",
        "object": { "file": object, "scale": scale },
        "grasps": { "transforms": transforms, "object_in_gripper": held },
    });
    format!("{whole}\n").into_bytes()
}

/// The pose of the root as a matrix, row by row.
fn transform(pose: &Pose) -> [[f64; 4]; 4] {
    let [w, x, y, z] = pose.rotation_wxyz();
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let (turn, t) = (turn.to_rotation_matrix(), pose.translation_m());
    std::array::from_fn(|row| match row {
        3 => [0.0, 0.0, 0.0, 1.0],
        _ => [turn[(row, 0)], turn[(row, 1)], turn[(row, 2)], t[row]],
    })
}

/// Whether a file is one of `GraspGen`.
pub(super) fn is(file: &Value) -> bool {
    file["grasps"].get("transforms").is_some()
}

/// Reads the grasps of a file, all in the rest pose of the hand.
pub(super) fn read(file: &Value, hand: &HandJoints, mapping: &Mapping) -> Result<Read, String> {
    if mapping.rotation_form != RotationForm::default() {
        return Err(
            "the rotations of GraspGen are matrices: leave `rotation_form` out of the mapping"
                .to_owned(),
        );
    }
    let scale = match &file["object"]["scale"] {
        Value::Null => None,
        scale => Some(scale.as_f64().ok_or("its `object.scale` is not a number")?),
    };
    let object = file["object"]["file"].as_str().map(str::to_owned);
    let grasps = &file["grasps"];
    let transforms = grasps["transforms"].as_array();
    let transforms = transforms.ok_or("its `grasps.transforms` is not a list of 4 × 4 matrices")?;
    let held = match &grasps["object_in_gripper"] {
        Value::Null => None,
        held => {
            let flags = held.as_array().map(|held| held.iter().map(flag).collect());
            let flags: Option<Vec<bool>> = flags.unwrap_or_default();
            let flags = flags.filter(|flags| flags.len() == transforms.len());
            Some(flags.ok_or_else(|| {
                format!(
                    "its `grasps.object_in_gripper` is not a list of true and false, one for each of {}",
                    counted(transforms.len(), "transform")
                )
            })?)
        }
    };
    let (joints, note) = hand.at_rest()?;
    let mut read = Read {
        format: "GraspGen",
        notes: vec![note],
        ..Read::default()
    };
    for (place, matrix) in transforms.iter().enumerate() {
        let (translation, rotation) = rigid(matrix).map_err(|problem| {
            format!("`grasps.transforms` {place} (the first is 0): {problem}")
        })?;
        let (translation_m, rotation_wxyz) = mapping.directed(translation, rotation);
        read.grasps.push(Published {
            pose: Pose::new(translation_m, rotation_wxyz, &joints),
            scale,
            object: object.clone(),
            ..Published::default()
        });
    }
    let lost = held.iter().flatten().filter(|held| !**held).count();
    if lost > 0 {
        read.notes.push(format!(
            "{lost} of {} did not hold the object where the file was made (`object_in_gripper`); they are kept",
            counted(transforms.len(), "grasp")
        ));
    }
    Ok(read)
}

/// A truth value, also as 0 or 1.
fn flag(value: &Value) -> Option<bool> {
    value.as_bool().or_else(|| match value.as_u64() {
        Some(0) => Some(false),
        Some(1) => Some(true),
        _ => None,
    })
}

/// Position and quaternion of a rigid motion.
fn rigid(matrix: &Value) -> Result<([f64; 3], [f64; 4]), String> {
    let row = |row: &Value| -> Option<[f64; 4]> {
        let numbers = row.as_array()?.iter().map(Value::as_f64);
        <[f64; 4]>::try_from(numbers.collect::<Option<Vec<f64>>>()?).ok()
    };
    let rows = matrix.as_array().map(|rows| rows.iter().map(row).collect());
    let rows: Option<Vec<[f64; 4]>> = rows.unwrap_or_default();
    let Some([x, y, z, last]) = rows.and_then(|rows| <[[f64; 4]; 4]>::try_from(rows).ok()) else {
        return Err("it is not a matrix of 4 × 4 numbers".to_owned());
    };
    let off = last.iter().zip([0.0, 0.0, 0.0, 1.0]);
    if off
        .into_iter()
        .any(|(found, expected)| (found - expected).abs() > TOLERANCE)
    {
        return Err(format!("its last row is {last:?}; 0, 0, 0, 1 is needed"));
    }
    let turn = [x, y, z].map(|row| [row[0], row[1], row[2]]).concat();
    let rotation = RotationForm::Matrix.quaternion(&turn, super::AngleUnit::default())?;
    Ok(([x[3], y[3], z[3]], rotation))
}
