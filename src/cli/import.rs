//! `landscape import`: `min.data` and `ts.data` of PATHSAMPLE or topsearch as a landscape. Grasps are imported elsewhere.

use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use clap::{Args, ValueHint};

use super::args::{Common, GroupBarrier};
use super::import_grasps;
use super::output::{check_inputs, check_place};
use super::provenance::name_of;
use crate::cli::printing::{complain, print};
use crate::store::{AtomicFolder, Source, content_hash};
use crate::study::ImportedLandscape;
use crate::topography::exchange::Database;

/// Read the files of other programs.
#[derive(Debug, Args)]
pub(super) struct Import {
    /// Grasps (.npy, .csv, .json, .parquet, or a folder of .npy files), or the folder that contains min.data and ts.data.
    #[arg(value_name = "PATH")]
    pub(super) path: PathBuf,
    /// The hand of the grasps: the name of a built-in hand, or a URDF or MJCF file.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) hand: Option<String>,
    /// The folder with the files that the hand's description names; by default its own folder.
    #[arg(long, value_name = "FOLDER", requires = "hand")]
    pub(super) hand_folder: Option<PathBuf>,
    /// Use the hand's mirror image instead.
    #[arg(long, requires = "hand")]
    pub(super) mirror: bool,
    /// The object of the grasps: the name of a built-in object, or a mesh as published.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) object: Option<String>,
    /// Name of the object in files and pictures, instead of the name of its file. From a table with several objects, only
    /// those with this name are read.
    #[arg(long, value_name = "NAME", requires = "object")]
    pub(super) name: Option<String>,
    /// Only the grasps at this scale of the object; if the file has no scales, metres per unit of the mesh.
    #[arg(
        long,
        value_name = "FACTOR",
        requires = "object",
        allow_negative_numbers = true
    )]
    pub(super) scale: Option<f64>,
    /// Meaning of the columns of a table (TOML, see below).
    #[arg(long, value_name = "FILE", requires = "hand")]
    pub(super) mapping: Option<PathBuf>,
    #[command(flatten)]
    groups: GroupBarrier,
    /// The output; by default in the current folder, with the name of the file and the ending `.parquet`, or of the folder
    /// and the ending `.landscape`.
    #[arg(long, short, value_name = "PATH")]
    pub(super) output: Option<PathBuf>,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape import bottle.npy --hand shadow.xml --object bottle.obj --scale 0.1
                                                           bottle.parquet: DexGraspNet's grasps at one scale
  landscape import grasps/ --hand shadow.xml --object mug.obj
                                                           all .npy files of a folder (DexGraspBench, BODex, Dexonomy)
  landscape import mine.csv --hand human --object mug --mapping mine.toml
  landscape import lj7                                     lj7.landscape/ from lj7/min.data and lj7/ts.data

Grasps become a grasps.parquet for `landscape build`, `inspect` and so on. The format is told by the file: DexGraspNet's
.npy (joints by name, Euler angles about fixed axes), DexGraspBench's (position, quaternion w x y z, joints in the hand's
order), or a table (.csv, .json, .parquet). Nothing in a pickle is ever executed. Contacts that the file does not tell are
chosen: the best by the default energy. Without --scale all scales are kept. docs/import_export.md says more.

A mapping tells what the columns of a table are (TOML; everything may be left out):
  translation = [\"x\", \"y\", \"z\"]        or one column of lists; translation_unit = \"m\", \"cm\", \"mm\"
  rotation = \"quat\"                      or several columns
  rotation_form = \"wxyz\"                 or xyzw, fixed_xyz, rotation_vector, matrix; rotation_unit = \"rad\", \"deg\"
  frame = \"object_from_hand\"             or hand_from_object
  joints = \"qpos\"                        a column of lists, with joint_names = [\"FFJ3\", …]; or { FFJ3 = \"column\", … }
  joint_unit = \"rad\"                     or deg
  scale = \"size\"                         a column, or a number; also id, object, label, contacts

Landscapes: the files are PATHSAMPLE's (6 and 8 columns) or topsearch's (2 and 3 columns): the number of columns tells. Writes
minima.parquet, edges.parquet, landscape.json, the tree, the network and the pictures as `landscape build` does, and
min.data and ts.data in PATHSAMPLE's columns.";

pub(super) fn run(command: &Import, common: &Common) -> anyhow::Result<()> {
    let group_barrier = command.groups.checked()?;
    if import_grasps::holds_grasps(&command.path) {
        ensure!(
            group_barrier.is_none(),
            "--group-barrier is for min.data and ts.data: grasps have groups only once `landscape build` mapped them"
        );
        return import_grasps::run(command, common);
    }
    ensure!(
        command.hand.is_none() && command.object.is_none(),
        "{}: --hand and --object are for grasps, but these files hold a landscape",
        command.path.display()
    );
    let texts = ["min.data", "ts.data"].map(|name| read(&command.path, name));
    let [minima, states] = texts;
    let (minima, states) = (minima?, states?);
    let (database, layout) =
        Database::parse(&minima, &states).with_context(|| command.path.display().to_string())?;
    let output = match &command.output {
        Some(output) => output.clone(),
        None => named_after(&command.path)?,
    };
    check_place(&output)?;
    check_inputs(&output, &[&command.path])?;
    let groups = command.groups.settings();
    let source = Source {
        name: name_of(&command.path),
        content_hash: content_hash(&[minima.as_bytes(), states.as_bytes()]),
    };
    let made_by = &common.provenance.command;
    let imported = ImportedLandscape::new(&database, layout, &groups, source, made_by);
    let folder = AtomicFolder::open(&output, true)?;
    let text = imported.write(&folder)?;
    let finished = folder.finish()?;
    if !common.quiet {
        print(&text);
        complain(&format!("wrote {}", finished.display()));
    }
    Ok(())
}

fn read(folder: &Path, name: &str) -> anyhow::Result<String> {
    ensure!(
        folder.is_dir(),
        "{} is no folder: min.data and ts.data are read from one",
        folder.display()
    );
    let path = folder.join(name);
    let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
    String::from_utf8(bytes).with_context(|| format!("{} is not text", path.display()))
}

/// The output `folder.landscape` in the current directory.
fn named_after(folder: &Path) -> anyhow::Result<PathBuf> {
    let name = name_of(folder);
    ensure!(
        !name.is_empty(),
        "{}: name the folder to write with --output",
        folder.display()
    );
    Ok(PathBuf::from(format!("{name}.landscape")))
}
