//! DexGraspNet (Wang et al. 2023): dictionaries `{"qpos": {joint: angle, …}, "scale": …}`.

use super::euler::of_euler;
use super::joints::matched;
use super::mapping::{Mapping, RotationForm};
use super::{Published, Read, finite};
use crate::formats::pickle::{Heap, Id, Node};
use crate::space::Pose;

/// Entries for the pose of the wrist: metres, and angles about the fixed axes x, y, z, in this order.
pub(super) const TRANSLATION: [&str; 3] = ["WRJTx", "WRJTy", "WRJTz"];
pub(super) const ROTATION: [&str; 3] = ["WRJRx", "WRJRy", "WRJRz"];

pub(super) fn read(
    heap: &Heap,
    items: &[Id],
    hand: &[String],
    mapping: &Mapping,
) -> Result<Read, String> {
    if mapping.rotation_form != RotationForm::default() {
        return Err(
            "the rotations of DexGraspNet are angles about fixed axes: leave `rotation_form` out of the mapping"
                .to_owned(),
        );
    }
    let mut grasps = Vec::with_capacity(items.len());
    for (place, &item) in items.iter().enumerate() {
        let grasp = grasp(heap, item, hand, mapping)
            .map_err(|problem| format!("grasp {place}: {problem}"))?;
        grasps.push(grasp);
    }
    Ok(Read {
        grasps,
        format: "DexGraspNet",
        ..Read::default()
    })
}

/// The entries of a `qpos`.
struct Qpos<'a> {
    /// Position and angles of the wrist.
    wrist: [[Option<f64>; 3]; 2],
    names: Vec<&'a str>,
    angles: Vec<f64>,
}

impl<'a> Qpos<'a> {
    fn read(heap: &'a Heap, item: Id) -> Result<Self, String> {
        let qpos = heap.entry(item, "qpos").ok_or("it has no `qpos`")?;
        let Node::Dictionary(entries) = heap.node(qpos) else {
            return Err("its `qpos` is not a dictionary of joints".to_owned());
        };
        let mut read = Self {
            wrist: [[None; 3]; 2],
            names: Vec::new(),
            angles: Vec::new(),
        };
        for (key, value) in entries {
            let Node::Text(name) = heap.node(*key) else {
                return Err("its `qpos` has a key that is not text".to_owned());
            };
            let number = heap
                .number(*value)
                .ok_or_else(|| format!("`{name}` is not a number"))?;
            finite(&[number], &format!("`{name}`"))?;
            let entry = [TRANSLATION, ROTATION]
                .iter()
                .enumerate()
                .find_map(|(kind, axes)| Some((kind, axes.iter().position(|axis| axis == name)?)));
            if let Some((kind, axis)) = entry {
                read.wrist[kind][axis] = Some(number);
            } else {
                read.names.push(name.as_str());
                read.angles.push(number);
            }
        }
        Ok(read)
    }

    /// For each joint of the hand, the index of its entry.
    fn partners(&self, hand: &[String], mapping: &Mapping) -> Result<Vec<usize>, String> {
        match &mapping.joint_names {
            Some(renamed) if renamed.len() == self.names.len() => matched(
                &renamed.iter().map(String::as_str).collect::<Vec<_>>(),
                hand,
            ),
            Some(renamed) => Err(format!(
                "it has {} joints, but the mapping names {}",
                self.names.len(),
                renamed.len()
            )),
            None => matched(&self.names, hand),
        }
    }
}

fn grasp(heap: &Heap, item: Id, hand: &[String], mapping: &Mapping) -> Result<Published, String> {
    let qpos = Qpos::read(heap, item)?;
    let complete = |kind: usize, axes: [&str; 3]| match qpos.wrist[kind] {
        [Some(x), Some(y), Some(z)] => Ok([x, y, z]),
        _ => Err(format!("its `qpos` lacks one of {}", axes.join(", "))),
    };
    let partners = qpos.partners(hand, mapping)?.into_iter();
    let scale = match heap.entry(item, "scale") {
        Some(scale) => Some(heap.number(scale).ok_or("its `scale` is not a number")?),
        None => None,
    };
    if let Some(scale) = scale {
        finite(&[scale], "`scale`")?;
    }
    let (translation_m, rotation_wxyz) =
        mapping.directed(complete(0, TRANSLATION)?, of_euler(complete(1, ROTATION)?));
    let unit = mapping.joint_unit.radians();
    let joints: Vec<f64> = partners.map(|place| unit * qpos.angles[place]).collect();
    Ok(Published {
        pose: Pose::new(translation_m, rotation_wxyz, &joints),
        scale,
        ..Published::default()
    })
}
