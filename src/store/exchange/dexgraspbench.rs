//! DexGraspBench, `BODex` and Dexonomy: `grasp_qpos` is position, quaternion w x y z, and joints in the hand's order.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::joints::matched;
use super::mapping::Mapping;
use super::{Published, Read, finite};
use crate::formats::array::Numbers;
use crate::formats::pickle::{Heap, Id, Node};
use crate::printable::counted;
use crate::space::Pose;

/// Largest accepted deviation of a quaternion from unit length.
const UNIT_TOLERANCE: f64 = 1e-3;
/// Largest number of grasps in a file. A small file could otherwise give very many, because its entries may share an array.
const MOST: usize = 1 << 20;

pub(super) fn read(
    heap: &Heap,
    items: &[Id],
    hand: &[String],
    mapping: &Mapping,
) -> Result<Read, String> {
    let mut read = Read {
        format: "DexGraspBench",
        ..Read::default()
    };
    for (place, &item) in items.iter().enumerate() {
        grasps(heap, item, hand, mapping, &mut read).map_err(|problem| match items.len() {
            1 => problem,
            _ => format!("entry {place}: {problem}"),
        })?;
    }
    note_order(hand, mapping, &mut read);
    Ok(read)
}

/// Reads a bare table with one grasp per row.
pub(super) fn of_numbers(
    numbers: &Numbers,
    hand: &[String],
    mapping: &Mapping,
) -> Result<Read, String> {
    let mut read = Read {
        format: "table of qpos",
        ..Read::default()
    };
    let rows = numbers.rows().ok_or_else(|| {
        format!(
            "it is an array of shape {:?}; rows of qpos are needed",
            numbers.shape
        )
    })?;
    for (place, row) in rows.iter().enumerate() {
        let grasp =
            of_row(row, hand, mapping).map_err(|problem| format!("row {place}: {problem}"))?;
        read.grasps.push(grasp);
    }
    note_order(hand, mapping, &mut read);
    Ok(read)
}

fn note_order(hand: &[String], mapping: &Mapping, read: &mut Read) {
    if mapping.joint_names.is_none() {
        read.notes.push(format!(
            "the file does not name its joints: they are taken to be in the hand's order, {}",
            hand.join(", ")
        ));
    }
}

fn grasps(
    heap: &Heap,
    item: Id,
    hand: &[String],
    mapping: &Mapping,
    read: &mut Read,
) -> Result<(), String> {
    let qpos = heap
        .entry(item, "grasp_qpos")
        .ok_or("it has no `grasp_qpos`")?;
    let qpos = heap
        .numbers(qpos)
        .ok_or("its `grasp_qpos` is no array of numbers")?;
    let rows = qpos
        .rows()
        .ok_or_else(|| format!("its `grasp_qpos` has the shape {:?}", qpos.shape))?;
    let scale = match heap.entry(item, "obj_scale") {
        Some(scale) => {
            // The scale is one number, or three equal ones.
            let scales = heap
                .few(scale, 3)
                .ok_or("its `obj_scale` is neither one number nor three")?;
            finite(&scales, "`obj_scale`")?;
            let first = *scales.first().ok_or("its `obj_scale` is empty")?;
            if scales.iter().any(|other| (other - first).abs() > 1e-9) {
                return Err(
                    "its `obj_scale` differs between axes, which is not supported".to_owned(),
                );
            }
            Some(first)
        }
        None => None,
    };
    let object_pose = match heap.entry(item, "obj_pose") {
        Some(pose) => {
            let pose = heap
                .few(pose, 7)
                .ok_or("its `obj_pose` is no array of 7 numbers")?;
            Some(isometry(&pose, "`obj_pose`")?)
        }
        None => None,
    };
    let object = heap
        .entry(item, "obj_path")
        .and_then(|path| match heap.node(path) {
            Node::Text(path) => Some(path.clone()),
            _ => None,
        });
    for (place, row) in rows.iter().enumerate() {
        let mut grasp = of_row(row, hand, mapping)
            .map_err(|problem| format!("`grasp_qpos` {place}: {problem}"))?;
        if let Some(object_pose) = &object_pose {
            let hand = isometry(&row[..7], "`grasp_qpos`")?;
            let relative = object_pose.inv_mul(&hand);
            let t = relative.translation.vector;
            let q = relative.rotation;
            grasp.pose = Pose::new(t.into(), [q.w, q.i, q.j, q.k], grasp.pose.joints());
        }
        grasp.scale = scale;
        grasp.object.clone_from(&object);
        read.grasps.push(grasp);
    }
    if read.grasps.len() > MOST {
        return Err(format!("it holds more than {MOST} grasps"));
    }
    Ok(())
}

fn of_row(row: &[f64], hand: &[String], mapping: &Mapping) -> Result<Published, String> {
    if row.len() != 7 + hand.len() {
        return Err(format!(
            "it holds {} numbers; position, quaternion and the {} joints of the hand make {}",
            row.len(),
            hand.len(),
            7 + hand.len()
        ));
    }
    finite(row, "it")?;
    let (pose, joints) = row.split_at(7);
    isometry(pose, "it")?;
    let partners = match &mapping.joint_names {
        Some(names) => matched(&names.iter().map(String::as_str).collect::<Vec<_>>(), hand)?,
        None => (0..hand.len()).collect(),
    };
    let joints = partners.into_iter().map(|place| joints.get(place).copied());
    let joints: Option<Vec<f64>> = joints.collect();
    let joints = joints.ok_or("the mapping names more joints than the row has")?;
    Ok(Published {
        id: None,
        pose: [pose, &joints].concat().into(),
        scale: None,
        object: None,
        label: None,
        contacts: None,
    })
}

/// The motion given by a position and a quaternion w x y z.
fn isometry(pose: &[f64], what: &str) -> Result<Isometry3<f64>, String> {
    finite(pose, what)?;
    let [x, y, z, qw, qx, qy, qz] = *pose else {
        return Err(format!(
            "{what} holds {}, expected 7",
            counted(pose.len(), "number")
        ));
    };
    let quaternion = Quaternion::new(qw, qx, qy, qz);
    if (quaternion.norm() - 1.0).abs() > UNIT_TOLERANCE {
        return Err(format!(
            "{what} has numbers 4 to 7 of length {:.4}, which are no unit quaternion w x y z",
            quaternion.norm()
        ));
    }
    Ok(Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::from_quaternion(quaternion),
    ))
}
