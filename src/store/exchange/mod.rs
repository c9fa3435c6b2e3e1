//! Reading and writing of grasps in the formats of other programs.
//!
//! | format | content |
//! | --- | --- |
//! | DexGraspNet `.npy` | an array of dictionaries: `scale`, and `qpos` with an angle for each joint by name, `WRJTx…z` (metres) and `WRJRx…z` (Euler angles about fixed axes x, y, z) |
//! | DexGraspBench, Dexonomy, `BODex` `.npy` | a dictionary: `grasp_qpos` (position, quaternion w x y z, joints), `obj_pose`, `obj_scale` |
//! | tables | CSV, JSON (a list of objects) or Parquet, with a [`Mapping`] that gives the meaning of the columns |
//! | Isaac `.yaml` | written only: `isaac_grasp` 1.0 |
//!
//! Poses have the convention of this crate: `p_object = R p_hand + t`, metres, quaternion w x y z.

mod dexgraspbench;
mod dexgraspnet;
mod dexonomy;
mod euler;
mod isaac;
mod joints;
mod mapping;
mod table;
mod write;

use std::path::{Path, PathBuf};

pub use dexonomy::dexonomy_npy;
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
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Its id, if the file has one.
    pub id: Option<u64>,
    /// Its pose, with the joints in the order of the hand.
    pub pose: Pose,
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
}

/// Reads grasps of a hand with joints `joint_names` from a file of any of the formats. `mapping` describes the columns of
/// tables. For other files only its names of joints and its unit of angles are used.
///
/// # Errors
/// One sentence that names the file, the grasp if there is one, and the problem.
pub fn read(path: &Path, joint_names: &[String], mapping: &Mapping) -> Result<Read, StoreError> {
    let foreign = |problem: String| StoreError::Foreign {
        path: path.to_path_buf(),
        problem,
    };
    match ending(path).as_str() {
        "npy" => {
            let content = npy::read(&bytes(path)?).map_err(foreign)?;
            of_npy(&content, joint_names, mapping).map_err(foreign)
        }
        "csv" => {
            let table = table::of_csv(&bytes(path)?).map_err(foreign)?;
            mapping::read(&table, joint_names, mapping).map_err(foreign)
        }
        "json" => {
            let table = table::of_json(&bytes(path)?).map_err(foreign)?;
            mapping::read(&table, joint_names, mapping).map_err(foreign)
        }
        "parquet" => {
            let table = table::of_parquet(path)?;
            mapping::read(&table, joint_names, mapping).map_err(foreign)
        }
        _ => Err(foreign(
            "grasps are read from files that end in .npy, .csv, .json or .parquet".to_owned(),
        )),
    }
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
) -> Result<Read, String> {
    match content {
        npy::Content::Numbers(numbers) => dexgraspbench::of_numbers(numbers, joint_names, mapping),
        npy::Content::Objects(heap, whole) => {
            let items = match heap.node(*whole) {
                Node::Objects(items) | Node::List(items) => items.clone(),
                _ => vec![*whole],
            };
            let first = items.first().ok_or("it holds no grasps")?;
            if heap.entry(*first, "qpos").is_some() {
                dexgraspnet::read(heap, &items, joint_names, mapping)
            } else if heap.entry(*first, "grasp_qpos").is_some() {
                dexgraspbench::read(heap, &items, joint_names, mapping)
            } else {
                Err("its grasps have neither `qpos` (DexGraspNet) nor `grasp_qpos` (DexGraspBench, Dexonomy)".to_owned())
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
            "{what} holds {value}, which is not a finite number"
        )),
        None => Ok(()),
    }
}
