//! `landscape import`: `min.data` and `ts.data` of PATHSAMPLE or topsearch as a landscape; grasps elsewhere.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use clap::{Args, ValueHint};
use petgraph::visit::EdgeRef;
use serde_json::{Value, json};

use super::args::{Common, GroupBarrier};
use super::digits::Digits;
use super::drawing::{Drawing, Views, not_drawn};
use super::landscape::{Titles, write_database};
use super::output::{check_inputs, check_place};
use super::provenance::name_of;
use super::{complain, import_grasps, print};
use crate::figure::leaves_of;
use crate::store::{
    AtomicFolder, Counts, EdgeRow, LandscapeFiles, Manifest, MinimumRow, Source, content_hash,
};
use crate::topography::exchange::{Database, Layout};
use crate::topography::{Evidence, GroupSettings, Groups, Network, Tree};

/// Read the files of other programs.
#[derive(Debug, Args)]
pub(super) struct Import {
    /// Grasps (.npy, .csv, .json, .parquet, or a folder of .npy files), or the folder that holds min.data and ts.data.
    #[arg(value_name = "PATH")]
    pub(super) path: PathBuf,
    /// The hand of the grasps: a name of one that comes with the program, or a URDF or MJCF file.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) hand: Option<String>,
    /// Where the files that the hand's description names may lie; by default its own folder.
    #[arg(long, value_name = "FOLDER", requires = "hand")]
    pub(super) hand_folder: Option<PathBuf>,
    /// The hand's mirror image instead.
    #[arg(long, requires = "hand")]
    pub(super) mirror: bool,
    /// The object of the grasps: a name of one that comes with the program, or a mesh as published.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) object: Option<String>,
    /// What files and pictures call the object, instead of the name of its file. Of a table
    /// with several objects those of this name are read.
    #[arg(long, value_name = "NAME", requires = "object")]
    pub(super) name: Option<String>,
    /// Only the grasps at this scale of the object; where the file tells none, metres per unit of the mesh.
    #[arg(
        long,
        value_name = "FACTOR",
        requires = "object",
        allow_negative_numbers = true
    )]
    pub(super) scale: Option<f64>,
    /// What the columns of a table mean (TOML, see below).
    #[arg(long, value_name = "FILE", requires = "hand")]
    pub(super) mapping: Option<PathBuf>,
    #[command(flatten)]
    groups: GroupBarrier,
    /// What to write: by default, where you are, the name of the file with the ending `.parquet`, or of the folder with
    /// the ending `.landscape`.
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
        "{}: --hand and --object are for grasps, of which there are none",
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
    let network = database.network();
    let groups = GroupSettings {
        barrier: group_barrier,
        ..GroupSettings::default()
    };
    let imported = Imported {
        tree: Tree::from_network(&network, Evidence::Chain),
        groups: Groups::new(&network, &groups),
        network,
        layout,
        database: &database,
        source: Source {
            name: name_of(&command.path),
            content_hash: content_hash(&[minima.as_bytes(), states.as_bytes()]),
        },
        command: &common.provenance.command,
    };
    let folder = AtomicFolder::open(&output, true)?;
    imported.files()?.write(&folder)?;
    write_database(&database, &folder)?;
    imported.draw(&folder)?;
    let text = super::shown(&imported.summary());
    folder.write("summary.md", text.as_bytes())?;
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

/// `folder` becomes `folder.landscape` in the place where the command runs.
fn named_after(folder: &Path) -> anyhow::Result<PathBuf> {
    let name = name_of(folder);
    ensure!(
        !name.is_empty(),
        "{}: name the folder to write with --output",
        folder.display()
    );
    Ok(PathBuf::from(format!("{name}.landscape")))
}

/// What was read and what it comes to.
struct Imported<'a> {
    database: &'a Database,
    layout: Layout,
    network: Network,
    tree: Tree,
    groups: Groups,
    source: Source,
    command: &'a str,
}

impl Imported<'_> {
    fn loops(&self) -> usize {
        let states = self.database.transition_states.iter();
        states
            .filter(|state| state.ends[0] == state.ends[1])
            .count()
    }

    fn files(&self) -> anyhow::Result<LandscapeFiles> {
        let rows = self
            .network
            .node_weights()
            .zip(self.groups.group_of())
            .enumerate();
        let minima: Vec<MinimumRow> = rows
            .map(|(id, (minimum, group))| MinimumRow {
                id: id as u64,
                energy: minimum.energy,
                coordinates: Vec::new(),
                choice: Vec::new(),
                members: minimum.members.iter().map(|row| *row as u64).collect(),
                group: group as u64,
                labels: BTreeMap::new(),
            })
            .collect();
        let edges: Vec<EdgeRow> = (self.network.edge_references())
            .map(|edge| {
                let ends = [edge.source(), edge.target()];
                let [one, other] = ends.map(|end| self.network[end].energy);
                let height = edge.weight().height;
                EdgeRow {
                    a: ends[0].index() as u64,
                    b: ends[1].index() as u64,
                    height: Some(height),
                    relative_barrier: Some(height - one.max(other)),
                    evidence: edge.weight().evidence.name().to_owned(),
                    ..EdgeRow::default()
                }
            })
            .collect();
        let findings = [
            (
                "transition_states",
                json!(self.database.transition_states.len()),
            ),
            ("degenerate_rearrangements", json!(self.loops())),
            ("group_scan", serde_json::to_value(&self.groups.scan)?),
        ];
        let manifest = Manifest {
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            command: self.command.to_owned(),
            seed: 0,
            source: self.source.clone(),
            hand: None,
            object: None,
            scale: 1.0,
            energy: json!({ "imported": self.layout.name() }),
            settings: Value::Null,
            terms: Vec::new(),
            group_barrier: Some(self.groups.barrier),
            counts: Counts {
                grasps: 0,
                minima: minima.len() as u64,
                groups: self.groups.members.len() as u64,
                pairs: edges.len() as u64,
                components: self.tree.roots.len() as u64,
                evaluations: 0,
            },
            evidence: BTreeMap::from([("saddle".to_owned(), edges.len() as u64)]),
            findings: findings
                .map(|(name, value)| (name.to_owned(), value))
                .into(),
            warnings: vec![
                "transition states are taken at the word of the files: nothing was verified"
                    .to_owned(),
            ],
        };
        Ok(LandscapeFiles {
            manifest,
            minima,
            edges,
            paths: Vec::new(),
        })
    }

    fn draw(&self, folder: &AtomicFolder) -> anyhow::Result<()> {
        let drawing = Drawing {
            network: &self.network,
            tree: &self.tree,
            resampled: &[],
            leaves: leaves_of(&self.network),
            group_of: self.groups.group_of(),
            titles: &Titles {
                title: self.source.name.clone(),
                energy: "energy",
                members: "members",
                seed: 0,
            },
            views: Views::default(),
            examples: Vec::new(),
        };
        drawing.write(&mut |name, bytes| folder.write(name, bytes))
    }

    fn summary(&self) -> String {
        let mut text = format!(
            "# {}\n\n- **{} minima** and **{} transition states** in the layout of {}, {} of which join two copies of \
             one minimum; {} component(s)\n- {} pairs of minima are joined directly\n- {} groups (relative barrier up to \
             {})\n- transition states are taken at the word of the files: nothing was verified\n",
            self.source.name,
            self.database.minima.len(),
            self.database.transition_states.len(),
            self.layout.name(),
            self.loops(),
            self.tree.roots.len(),
            self.network.edge_count(),
            self.groups.members.len(),
            Digits::of([self.groups.barrier]).show(self.groups.barrier)
        );
        if let Some(sentence) = not_drawn(self.database.minima.len()) {
            text.extend(["- ", &sentence, "\n"]);
        }
        text
    }
}
