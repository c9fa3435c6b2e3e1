//! The arguments of `landscape import`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use crate::cli::args::{FamilyBarrier, WithPage};

/// Read the files of other programs.
#[derive(Debug, Args)]
pub(in crate::cli) struct Import {
    /// Grasps (.npy, .pt, .yaml, .json, .csv, .parquet, or a folder of .npy files), or the folder that contains min.data and ts.data.
    #[arg(value_name = "PATH")]
    pub(super) path: PathBuf,
    /// The hand of the grasps: the name of a built-in hand, or a URDF or MJCF file.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) hand: Option<String>,
    /// The folder with the files that the hand's description names; by default its own folder.
    #[arg(long, value_name = "FOLDER", requires = "hand")]
    pub(super) hand_folder: Option<PathBuf>,
    /// Use the mirror image of the hand.
    #[arg(long, requires = "hand")]
    pub(super) mirror: bool,
    /// The object of the grasps: the name of a built-in object, or the mesh published with the grasps.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) object: Option<String>,
    /// Name of the object in files and pictures, instead of the name of its file. From a table with several objects, only
    /// those with this name are read.
    #[arg(long, value_name = "NAME", requires = "object")]
    pub(super) name: Option<String>,
    /// Import only the grasps at this scale of the object. If the file has no scales: metres per unit of the mesh.
    #[arg(
        long,
        value_name = "FACTOR",
        requires = "object",
        allow_negative_numbers = true
    )]
    pub(super) scale: Option<f64>,
    /// Make open surfaces of the object's mesh walls of this many millimetres (0.1 to 100) at the scale given.
    #[arg(
        long,
        value_name = "MM",
        requires = "scale",
        allow_negative_numbers = true
    )]
    pub(super) thickness: Option<f64>,
    /// Meaning of the columns of a table, and units and frames of any file (TOML, see below).
    #[arg(long, value_name = "FILE", requires = "hand")]
    pub(super) mapping: Option<PathBuf>,
    #[command(flatten)]
    pub(super) families: FamilyBarrier,
    #[command(flatten)]
    pub(super) page: WithPage,
    /// The output; by default in the current folder, with the name of the file and the ending `.parquet`, or of the folder
    /// and the ending `.landscape`.
    #[arg(long, short, value_name = "PATH")]
    pub(super) output: Option<PathBuf>,
}

pub(in crate::cli) const EXAMPLES: &str = "\
Examples:
  landscape import bottle.npy --hand shadow.xml --object bottle.obj --scale 0.1
                                                           bottle.parquet: DexGraspNet's grasps at one scale
  landscape import grasps/ --hand shadow.xml --object mug.obj
                                                           all .npy files of a folder (DexGraspBench, BODex, Dexonomy)
  landscape import mine.csv --hand human --object mug --mapping mine.toml
  landscape import lj7                                     lj7.landscape/ from lj7/min.data and lj7/ts.data

Grasps are written to a Parquet file for `landscape build`, `inspect` and so on. The program recognises the format: .npy
of DexGraspNet (joints by name, Euler angles about fixed axes), .npy of DexGraspBench, BODex or Dexonomy (position,
quaternion w x y z, joints in the hand's order), .pt of graspqp, MultiDex or DRO-Grasp, .yaml of isaac_grasp, .json of
GraspGen, or a table (.csv, .json, .parquet). Nothing in a pickle is ever executed.
If the file has no contacts, the best ones by the default energy are chosen. Without --scale all scales are kept. Grasps
that lie beside their object give a warning with the unit, order or frame that fits, or are refused.
docs/import_export.md says more.

A mapping gives the meaning of the columns of a table (TOML; all entries are optional; units, frame, link and rotation_form
hold for other files, too):
  translation = [\"x\", \"y\", \"z\"]        or one column of lists; translation_unit = \"m\", \"cm\", \"mm\", \"mesh\"
  rotation = \"quat\"                      or several columns
  rotation_form = \"wxyz\"                 or xyzw, fixed_xyz, rotation_vector, matrix; rotation_unit = \"rad\", \"deg\"
  frame = \"object_from_hand\"             or hand_from_object
  link = \"palm\"                         the link of the hand whose pose it is; default: the root
  joints = \"qpos\"                        a column of lists, with joint_names = [\"FFJ3\", …]; or { FFJ3 = \"column\", … }
  joint_unit = \"rad\"                     or deg
  scale = \"size\"                         a column, or a number; also id, object, label, contacts

A landscape is read from min.data and ts.data of PATHSAMPLE (6 and 8 columns) or topsearch (2 and 3 columns), with the
coordinates in points.min and points.ts (PATHSAMPLE) or min.coords and ts.coords (topsearch) if these are there. Writes
minima.parquet, edges.parquet, landscape.json, the tree, the network, the pictures and report.html (--no-report leaves it
out) as `landscape build` does, and min.data and ts.data in PATHSAMPLE's columns.";
