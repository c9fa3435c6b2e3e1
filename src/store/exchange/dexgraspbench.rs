//! DexGraspBench, `BODex` and Dexonomy: `grasp_qpos` is position, quaternion w x y z, and joints, in the order of `joint_names`
//! if there is such a list, and otherwise in the hand's order. `BODex` itself writes `robot_pose` instead, which also holds the
//! poses before and after.

use std::path::Path;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::joints::matched;
use super::mapping::{Frame, Mapping};
use super::scene::{Stand, stand};
use super::{Published, Read, finite};
use crate::formats::array::Numbers;
use crate::formats::pickle::{Heap, Id};
use crate::printable::counted;
use crate::space::Pose;

/// Largest accepted deviation of a quaternion from unit length.
const UNIT_TOLERANCE: f64 = 1e-3;
/// Entry with the poses that press.
const SQUEEZED: &str = "squeeze_qpos";
/// Largest number of grasps in a file. A small file could otherwise give very many, because its entries may share an array.
const MOST: usize = 1 << 20;

pub(super) fn read(
    heap: &Heap,
    items: &[Id],
    hand: &[String],
    mapping: &Mapping,
    path: &Path,
) -> Result<Read, String> {
    // BODex describes the hand by a URDF whose root is the outermost body of the MJCF.
    let of_outermost_body =
        (items.first()).is_some_and(|first| heap.entry(*first, "grasp_qpos").is_none());
    let mut read = Read {
        format: if of_outermost_body {
            "BODex"
        } else {
            "DexGraspBench"
        },
        of_outermost_body,
        ..Read::default()
    };
    let mut names_all = true;
    for (place, &item) in items.iter().enumerate() {
        let given = mapping.joint_names.as_ref().map(|names| texts(names));
        let own = || {
            heap.entry(item, "joint_names")
                .and_then(|names| heap.texts(names))
        };
        let names = given.or_else(own);
        names_all &= names.is_some();
        let found = order(names.as_deref(), hand).and_then(|order| {
            let rows = Rows {
                order: &order,
                mapping,
            };
            grasps(heap, item, &rows, path, &mut read)
        });
        found.map_err(|problem| match items.len() {
            1 => problem,
            _ => format!("entry {place}: {problem}"),
        })?;
    }
    if !names_all {
        note_order(hand, &mut read);
    }
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
    let names = mapping.joint_names.as_ref().map(|names| texts(names));
    let order = order(names.as_deref(), hand)?;
    for (place, row) in rows.iter().enumerate() {
        let rows = Rows {
            order: &order,
            mapping,
        };
        let grasp = (rows.grasp(row)).map_err(|problem| format!("row {place}: {problem}"))?;
        read.grasps.push(grasp);
    }
    if names.is_none() {
        note_order(hand, &mut read);
    }
    Ok(read)
}

fn texts(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}

/// For each joint of the hand, its place among the joints of a row.
fn order(names: Option<&[&str]>, hand: &[String]) -> Result<Vec<usize>, String> {
    names.map_or_else(
        || Ok((0..hand.len()).collect()),
        |names| matched(names, hand),
    )
}

fn note_order(hand: &[String], read: &mut Read) {
    read.notes.push(format!(
        "the file does not name its joints: they are taken to be in the hand's order, {}",
        hand.join(", ")
    ));
}

/// How the numbers of a row are read.
struct Rows<'a> {
    /// For each joint of the hand, its place among the joints of a row.
    order: &'a [usize],
    mapping: &'a Mapping,
}

fn grasps(
    heap: &Heap,
    item: Id,
    rows: &Rows<'_>,
    path: &Path,
    read: &mut Read,
) -> Result<(), String> {
    let (key, qpos, squeezed) = if read.of_outermost_body {
        let [qpos, squeezed] = at_grasp_and_after(heap, item)?;
        ("robot_pose", qpos, Some(squeezed))
    } else {
        let key = "grasp_qpos";
        let qpos = table(heap, item, key)?.ok_or("it has no `grasp_qpos`")?;
        let squeezed = table(heap, item, SQUEEZED)?;
        if let Some(squeezed) = squeezed.as_ref().filter(|rows| rows.len() != qpos.len()) {
            return Err(format!(
                "it has {} in `{SQUEEZED}` and {} in `{key}`: each grasp needs one of both, or leave `{SQUEEZED}` out",
                counted(squeezed.len(), "pose"),
                counted(qpos.len(), "pose"),
            ));
        }
        (key, qpos, squeezed)
    };
    let Stand {
        pose_of_object,
        scales,
        object,
        notes,
    } = stand(heap, item, qpos.len(), path)?;
    // The object's place is in the unit of the hand's.
    let metres = rows.mapping.translation_unit.unwrap_or_default().metres();
    let pose_of_object = pose_of_object.map(|mut pose| {
        pose.translation.vector *= metres;
        pose
    });
    for note in notes {
        if !read.notes.contains(&note) {
            read.notes.push(note);
        }
    }
    let mut moves = false;
    for (place, row) in qpos.iter().enumerate() {
        let mut grasp = rows
            .grasp(row)
            .map_err(|problem| format!("`{key}` {place}: {problem}"))?;
        if let Some(squeezed) = &squeezed {
            let at_end = (rows.grasp(&squeezed[place]))
                .map_err(|problem| format!("`{key}` {place}, squeezed: {problem}"))?;
            moves |= moved(&grasp.pose, &at_end.pose);
            grasp.squeeze_joints = Some(at_end.pose.joints().to_vec());
        }
        if let Some(object_pose) = &pose_of_object {
            if rows.mapping.frame != Frame::ObjectFromHand {
                return Err("its poses cannot be those of the object in the hand's frame (`frame` of the mapping), because it \
                            contains the poses of the object"
                    .to_owned());
            }
            let hand = isometry(&grasp.pose[..7], key)?;
            let relative = object_pose.inv_mul(&hand);
            let t = relative.translation.vector;
            let q = relative.rotation;
            grasp.pose = Pose::new(t.into(), [q.w, q.i, q.j, q.k], grasp.pose.joints());
        }
        grasp.scale = scales.as_ref().map(|scales| scales[place % scales.len()]);
        grasp.object.clone_from(&object);
        read.grasps.push(grasp);
    }
    if read.grasps.len() > MOST {
        return Err(format!("it contains more than {MOST} grasps"));
    }
    let note = "the squeezed poses displace the wrist, too; only their joints are kept".to_owned();
    if moves && !read.notes.contains(&note) {
        read.notes.push(note);
    }
    Ok(())
}

/// The rows of an array, if there is one of this name.
fn table(heap: &Heap, item: Id, key: &str) -> Result<Option<Vec<Vec<f64>>>, String> {
    let Some(found) = heap.entry(item, key) else {
        return Ok(None);
    };
    let numbers = heap
        .numbers(found)
        .ok_or_else(|| format!("its `{key}` is not an array of numbers"))?;
    let rows = numbers.rows();
    rows.map(Some)
        .ok_or_else(|| format!("its `{key}` has the shape {:?}", numbers.shape))
}

/// Whether the hand as a whole is elsewhere, by more than the rounding of 32-bit numbers.
fn moved(grasp: &Pose, squeezed: &Pose) -> bool {
    const ROUNDING: f64 = 1e-5;
    let differences = grasp[..7].iter().zip(&squeezed[..7]);
    differences
        .into_iter()
        .any(|(a, b)| (a - b).abs() > ROUNDING)
}

/// The rows of `BODex` at the grasp and those after closing: its array holds scenes, grasps, and of each grasp the pose before,
/// at and after closing.
fn at_grasp_and_after(heap: &Heap, item: Id) -> Result<[Vec<Vec<f64>>; 2], String> {
    let poses = heap
        .entry(item, "robot_pose")
        .and_then(|poses| heap.numbers(poses))
        .ok_or("it has neither `grasp_qpos` nor numbers in `robot_pose`")?;
    if let Some(scenes @ 2..) = poses.shape.first().copied() {
        return Err(format!(
            "its `robot_pose` contains {scenes} scenes, each with an object of its own: save each scene in its own file"
        ));
    }
    let [_, _, 3, columns] = poses.shape[..] else {
        return Err(format!(
            "its `robot_pose` has the shape {:?}; scenes × grasps × 3 poses (before, at and after closing) × numbers are needed",
            poses.shape
        ));
    };
    if columns == 0 {
        return Err("its `robot_pose` is empty".to_owned());
    }
    let rows = || poses.values.chunks_exact(columns).map(<[f64]>::to_vec);
    Ok([1, 2].map(|first| rows().skip(first).step_by(3).collect()))
}

impl Rows<'_> {
    fn grasp(&self, row: &[f64]) -> Result<Published, String> {
        let Self { order, mapping } = self;
        if row.len() != 7 + order.len() {
            return Err(format!(
                "it contains {} numbers; position, quaternion and the {} joints of the hand make {}",
                row.len(),
                order.len(),
                7 + order.len()
            ));
        }
        finite(row, "it")?;
        let (pose, joints) = row.split_at(7);
        isometry(pose, "it")?;
        let rotation = mapping.ordered(std::array::from_fn(|k| pose[3 + k]))?;
        let (translation_m, rotation_wxyz) =
            mapping.directed(std::array::from_fn(|k| pose[k]), rotation);
        let unit = mapping.joint_unit.radians();
        let joints: Vec<f64> = order.iter().map(|place| unit * joints[*place]).collect();
        Ok(Published {
            pose: Pose::new(translation_m, rotation_wxyz, &joints),
            ..Published::default()
        })
    }
}

/// The motion given by a position and a quaternion w x y z.
pub(super) fn isometry(pose: &[f64], what: &str) -> Result<Isometry3<f64>, String> {
    finite(pose, what)?;
    let [x, y, z, qw, qx, qy, qz] = *pose else {
        return Err(format!(
            "{what} has {}, expected 7",
            counted(pose.len(), "number")
        ));
    };
    let quaternion = Quaternion::new(qw, qx, qy, qz);
    if (quaternion.norm() - 1.0).abs() > UNIT_TOLERANCE {
        return Err(format!(
            "numbers 4 to 7 of {what} have length {:.4}, so they are not a unit quaternion",
            quaternion.norm()
        ));
    }
    Ok(Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::from_quaternion(quaternion),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::pickle;
    use crate::formats::pickle_writer::Writer;

    /// A dictionary with a grasp of two joints, read for a hand with the joints `hand`.
    fn read_with(names: &[&str], hand: [&str; 2], mapping: &Mapping) -> Result<Read, String> {
        let mut writer = Writer::of_object();
        writer.open_dictionary();
        writer.text("grasp_qpos");
        writer.numbers(&[0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0, 0.25, 0.5]);
        if !names.is_empty() {
            writer.text("joint_names");
            writer.texts(names.iter().copied());
        }
        writer.close_dictionary();
        let (heap, whole) = pickle::load(&writer.finish()).unwrap();
        let crate::formats::pickle::Node::Objects(items) = heap.node(whole) else {
            panic!("no array of objects");
        };
        let path = Path::new("grasps.npy");
        read(&heap, items, &hand.map(str::to_owned), mapping, path)
    }

    #[test]
    fn joints_follow_the_names_of_the_file() {
        let none = Mapping::default();
        let joints = |read: &Read| read.grasps[0].pose.joints().to_vec();
        let named = read_with(&["b", "a"], ["a", "b"], &none).unwrap();
        assert_eq!(joints(&named), [0.5, 0.25]);
        assert!(named.notes.is_empty());
        let unnamed = read_with(&[], ["a", "b"], &none).unwrap();
        assert_eq!(joints(&unnamed), [0.25, 0.5]);
        assert!(unnamed.notes[0].contains("does not name its joints"));
        // A mapping knows better.
        let mapping = Mapping {
            joint_names: Some(vec!["a".to_owned(), "b".to_owned()]),
            ..Mapping::default()
        };
        let mapped = read_with(&["b", "a"], ["a", "b"], &mapping).unwrap();
        assert_eq!(joints(&mapped), [0.25, 0.5]);
        let other = read_with(&["b", "c"], ["a", "b"], &none).unwrap_err();
        assert!(other.contains('a') && other.contains('c'), "{other}");
    }
}
