//! Reading and writing of grasps in the formats of other programs.
//!
//! | format | content |
//! | --- | --- |
//! | DexGraspNet `.npy` | an array of dictionaries: `scale`, and `qpos` with an angle for each joint by name, `WRJTx…z` (metres) and `WRJRx…z` (Euler angles about fixed axes x, y, z) |
//! | DexGraspBench, Dexonomy `.npy` | a dictionary: `grasp_qpos` (position, quaternion w x y z, joints), and `obj_pose` and `obj_scale` or a scene that holds them |
//! | `BODex` `.npy` | a dictionary: `robot_pose` (the same numbers before, at and after closing), `joint_names`, `world_cfg` |
//! | `GraspGen` `.json` | `grasps.transforms`: poses without joints |
//! | torch `.pt` | those of graspqp (`parameters`), and of `MultiDex` and DRO-Grasp (`metadata`) |
//! | tables | CSV, JSON (a list of objects) or Parquet, with a [`Mapping`] that gives the meaning of the columns |
//! | Isaac `.yaml` | `isaac_grasp` 1.0: of each grasp by name `position`, `orientation`, `cspace_position` |
//!
//! Poses have the convention of this crate: `p_object = R p_hand + t`, metres, quaternion w x y z.

mod dexgraspbench;
mod dexgraspnet;
mod dexonomy;
mod euler;
mod graspgen;
mod hand_joints;
mod isaac;
mod joints;
mod mapping;
mod scene;
mod table;
mod torch;
mod unread;
mod write;

use std::path::{Path, PathBuf};

pub use dexonomy::dexonomy_npy;
pub use graspgen::graspgen_json;
pub use hand_joints::HandJoints;
pub use isaac::{IsaacGrasp, isaac_grasp};
pub use mapping::{
    AngleUnit, Columns, Frame, JointColumns, LengthUnit, Mapping, RotationForm, Scale,
};
pub use write::{
    QposRow, csv_table, dexgraspnet_npy, qpos, qpos_csv, qpos_npy, table_csv, table_json,
};

use super::error::StoreError;
use crate::formats::pickle::Node;
use crate::formats::{ending, npy};
use crate::space::Pose;

/// Largest size of a file, bytes.
const LARGEST: u64 = 1 << 30;

/// A grasp of another program, with its joints in the order of the requested hand.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Published {
    /// Its id, if the file has one.
    pub id: Option<u64>,
    /// Its pose, with the joints in the order of the hand.
    pub pose: Pose,
    /// Joint coordinates to which the hand closes to press, in the order of the hand.
    pub squeeze_joints: Option<Vec<f64>>,
    /// Scale factor of the object's mesh; `None` if the file has none.
    pub scale: Option<f64>,
    /// Name of the object in the file.
    pub object: Option<String>,
    /// A label.
    pub label: Option<String>,
    /// Contacts, as indices of the hand's surface points.
    pub contacts: Option<Vec<u32>>,
}

/// Content of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Read {
    /// The grasps, in file order.
    pub grasps: Vec<Published>,
    /// Assumptions and omissions, one sentence each.
    pub notes: Vec<String>,
    /// Name of the format.
    pub format: &'static str,
    /// Whether poses are those of the hand's outermost body ([`Hand::root_offset`](crate::hand::Hand::root_offset)) and not
    /// of the frame of its description (the world of an MJCF).
    pub of_outermost_body: bool,
    /// Name of the link whose poses they are, as the file has it; it may have a path before it.
    pub link: Option<String>,
}

/// Reads grasps of a hand with these joints from a file of any of the formats. `mapping` describes the columns of
/// tables. Of other files it tells the units, the direction of the pose, the order of quaternions and the names of joints.
///
/// # Errors
/// One sentence that names the file, the grasp if there is one, and the problem.
pub fn read(
    path: &Path,
    joints: impl Into<HandJoints>,
    mapping: &Mapping,
) -> Result<Read, StoreError> {
    let joints: HandJoints = joints.into();
    let joint_names = joints.names.as_slice();
    let foreign = |problem: String| StoreError::Foreign {
        path: path.to_path_buf(),
        problem,
    };
    match ending(path).as_str() {
        "npy" => {
            let content = npy::read(&bytes(path)?).map_err(foreign)?;
            of_npy(&content, joint_names, mapping, path).map_err(foreign)
        }
        "csv" => {
            let table = table::of_csv(&bytes(path)?).map_err(foreign)?;
            mapping::read(&table, joint_names, mapping).map_err(foreign)
        }
        "json" => {
            let file: serde_json::Value = serde_json::from_slice(&bytes(path)?)
                .map_err(|error| foreign(format!("it is not valid JSON: {error}")))?;
            if graspgen::is(&file) {
                return graspgen::read(&file, &joints, mapping).map_err(foreign);
            }
            let table = table::of_json(&file).map_err(foreign)?;
            mapping::read(&table, joint_names, mapping).map_err(foreign)
        }
        "parquet" => {
            let table = table::of_parquet(path)?;
            mapping::read(&table, joint_names, mapping).map_err(foreign)
        }
        "pt" | "pth" => {
            let (heap, whole) = crate::formats::torch::read(&bytes(path)?).map_err(foreign)?;
            torch::read(&heap, whole, &joints, mapping).map_err(foreign)
        }
        "yaml" | "yml" => {
            let bytes = bytes(path)?;
            let text = str::from_utf8(&bytes);
            let text = text.map_err(|error| foreign(format!("it is not a text: {error}")))?;
            isaac::read(text, &joints, mapping).map_err(foreign)
        }
        _ => Err(foreign(unread::sentence(path))),
    }
}

/// Endings of the names of files that [`read`] reads.
const ENDINGS: [&str; 8] = ["npy", "pt", "pth", "csv", "json", "parquet", "yaml", "yml"];

/// Refuses a file of a kind that [`read`] does not read, with what it is and what is read instead.
///
/// # Errors
/// If its name does not end as those of files that are read.
pub fn check_kind(path: &Path) -> Result<(), StoreError> {
    if ENDINGS.contains(&ending(path).as_str()) {
        return Ok(());
    }
    Err(StoreError::Foreign {
        path: path.to_path_buf(),
        problem: unread::sentence(path),
    })
}

/// The files of grasps at `path`: the file itself, or the `.npy` files of a folder by name.
///
/// # Errors
/// If the folder cannot be read.
pub fn files_of(path: &Path) -> Result<Vec<PathBuf>, StoreError> {
    if !path.is_dir() {
        return Ok(vec![path.to_path_buf()]);
    }
    let entries = std::fs::read_dir(path).map_err(StoreError::io("read", path))?;
    let mut files: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| ending(path) == "npy")
        .collect();
    files.sort();
    Ok(files)
}

fn of_npy(
    content: &npy::Content,
    joint_names: &[String],
    mapping: &Mapping,
    path: &Path,
) -> Result<Read, String> {
    match content {
        npy::Content::Numbers(numbers) => dexgraspbench::of_numbers(numbers, joint_names, mapping),
        npy::Content::Objects(heap, whole) => {
            let items = match heap.node(*whole) {
                Node::Objects(items) | Node::List(items) => items.clone(),
                _ => vec![*whole],
            };
            let first = items.first().ok_or("it contains no grasps")?;
            if heap.entry(*first, "qpos").is_some() {
                dexgraspnet::read(heap, &items, joint_names, mapping)
            } else if ["grasp_qpos", "robot_pose"]
                .iter()
                .any(|key| heap.entry(*first, key).is_some())
            {
                dexgraspbench::read(heap, &items, joint_names, mapping, path)
            } else {
                Err("its grasps have neither `qpos` (DexGraspNet) nor `grasp_qpos` (DexGraspBench, Dexonomy) nor `robot_pose` (BODex)".to_owned())
            }
        }
    }
}

fn bytes(path: &Path) -> Result<Vec<u8>, StoreError> {
    let told = std::fs::metadata(path).map_err(StoreError::io("read", path))?;
    if told.len() > LARGEST {
        return Err(StoreError::Foreign {
            path: PathBuf::from(path),
            problem: format!("it is larger than {} MB", LARGEST >> 20),
        });
    }
    std::fs::read(path).map_err(StoreError::io("read", path))
}

/// A list of at most a few names, for a sentence.
fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const MOST: usize = 8;
    let names: Vec<&str> = names.into_iter().collect();
    let shown = names[..names.len().min(MOST)].join(", ");
    if names.len() > MOST {
        format!("{shown} and {} more", names.len() - MOST)
    } else {
        shown
    }
}

/// Refuses numbers that are not finite.
fn finite(values: &[f64], what: &str) -> Result<(), String> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(format!(
            "{what} contains {value}, which is not a finite number"
        )),
        None => Ok(()),
    }
}
