//! The arguments.

use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, Parser, Subcommand, ValueHint};

use super::draw_types::Colouring;
use super::input::within;
use super::provenance::Provenance;
use crate::energy::External;
use crate::energy::model::MODELS;
use crate::limits::THREADS;
use crate::topography::PathMethod;

/// Shows how diverse a population of grasps really is: synthesizes grasps by differentiable force closure and maps the
/// energy landscape between them.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, arg_required_else_help = true, after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub(super) command: Command,
    #[command(flatten)]
    pub(super) common: Common,
}

/// Flags of every subcommand.
#[derive(Debug, Args)]
pub(super) struct Common {
    /// Number of threads; all cores by default. The result does not depend on it.
    #[arg(long, global = true, value_name = "N")]
    threads: Option<usize>,
    /// No progress bars and no summary.
    #[arg(long, short, global = true)]
    pub(super) quiet: bool,
    /// Overwrite files that exist and were not made by this program, that may have been edited, or that are read.
    #[arg(long, global = true)]
    pub(super) force: bool,
    /// This command line, for the files that it writes.
    #[arg(skip)]
    pub(super) provenance: Provenance,
}

impl Common {
    /// Sets up the thread pool.
    pub(super) fn threads(&self) -> anyhow::Result<()> {
        let Some(threads) = self.threads else {
            return Ok(());
        };
        within("--threads", THREADS, threads as f64)?;
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()
            .context("cannot start the threads")
    }
}

/// What becomes of an interrupted run. Without these flags it is continued if there is one.
#[derive(Debug, Args)]
pub(super) struct Again {
    /// Continue an interrupted run, and refuse to begin a new one. (Without this flag, too, a run continues where it
    /// stopped, if there is one.)
    #[arg(long, conflicts_with = "fresh")]
    pub(super) resume: bool,
    /// Begin again instead of continuing an interrupted run.
    #[arg(long)]
    pub(super) fresh: bool,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Synthesize grasps of a hand on an object
    #[command(after_help = SYNTH_EXAMPLES)]
    Synth(Synth),
    /// Map the energy landscape between the grasps of a file
    #[command(after_help = BUILD_EXAMPLES)]
    Build(Build),
    /// Judge the grasps of a file, or bare contacts
    #[command(after_help = INSPECT_EXAMPLES)]
    Inspect(Inspect),
    /// List the hands that come with the program, or show what is derived of one of your own
    Hands(Hands),
    /// Simulate the grasps of a file: would the object stay in the hand?
    #[command(after_help = STABILITY_EXAMPLES)]
    Stability(Stability),
    /// Name the grasps of a file: their types in the GRASP taxonomy, by a rule or by you
    #[command(after_help = LABEL_EXAMPLES)]
    Label(LabelCommand),
    /// List the objects that come with the program, show what is derived of one of your own, or make one of a neural network
    Objects(Objects),
    /// Map a surface: a named model, or an energy of your own
    #[command(after_help = surface_examples())]
    Surface(Surface),
    /// Draw a finished landscape again, with some of its minima or at few levels
    #[command(after_help = DRAW_EXAMPLES)]
    Draw(Draw),
    /// Hold a landscape against the taxonomy of grasps, with statistics
    #[command(after_help = COMPARE_EXAMPLES)]
    Compare(Compare),
    /// Tell what moved between two landscapes
    #[command(after_help = DIFF_EXAMPLES)]
    Diff(Diff),
    /// Read grasps of other programs, or min.data and ts.data of PATHSAMPLE or topsearch
    #[command(after_help = IMPORT_EXAMPLES)]
    Import(Import),
    /// Write grasps for other programs: tables, DexGraspNet, MuJoCo, glTF scenes
    #[command(after_help = EXPORT_EXAMPLES)]
    Export(Export),
}

const EXAMPLES: &str = "\
Examples:
  landscape synth --object bottle_round -n 64              grasps.parquet: grasps of the human hand on a bottle
  landscape build grasps.parquet                           grasps.landscape/: the landscape between them
  landscape inspect grasps.parquet                         how good these grasps are
  landscape stability grasps.parquet                       would the object stay in the hand?
  landscape label grasps.parquet                           which types of grasps these are
  landscape surface lj 7                                   lj-7.landscape/: all minima and saddles of a model
  landscape draw grasps.landscape --lowest 50              grasps.view/: the same pictures of its 50 lowest minima
  landscape diff warm.landscape cold.landscape             which minima and merges moved

`landscape help synth`, `landscape help build` and so on tell more.";

const SYNTH_EXAMPLES: &str = "\
Examples:
  landscape synth --object bottle_round -n 64              64 chains on a bottle that comes with the program
  landscape synth --object mug.obj -n 256 -o mug.parquet   your own mesh (metres, closed)
  landscape synth --object ball --preset paper --keep all  the published energy and sampler
  landscape synth --from mug.parquet -o better.parquet     refine given grasps
  landscape synth --from mug.parquet --perturb 10 -n 500 -o more.parquet
                                                           look around given grasps

An interrupted run continues where it stopped when the same command is given again; with --resume it must, with --fresh
it begins anew. The result is the same to the last byte.";

const HANDS_EXAMPLES: &str = "\
Examples:
  landscape hands inspect human                            human.json and human.png
  landscape hands inspect my_hand.xml                      my_hand.json: edit it beside my_hand.xml
  landscape synth --hand my_hand.xml --object mug          grasps of that hand
  landscape synth --hand my_hand.xml --mirror --object mug and of its mirror image";

const BUILD_EXAMPLES: &str = "\
Examples:
  landscape build data/grasps.parquet                      writes data/grasps.landscape/
  landscape build mug.parquet --neighbours 12 -o mug.landscape
  landscape build mug.parquet --sequential                 the published method, for comparison
  landscape build mug.parquet --group-barrier 0.1          groups as another landscape has them at 0.1

Writes minima.parquet, edges.parquet, paths.parquet, landscape.json, the tree (tree.nwk, tree.dot, tree.json), the network
(barriers.graphml), min.data and ts.data as PATHSAMPLE reads them (without curvatures: placeholders), the disconnectivity
graph, the barrier graph and a rarefaction curve (SVG and PNG), and summary.md. An interrupted run continues where it
stopped when the same command is given again; with --resume it must, with --fresh it begins anew. The result is the same to
the last byte.

Groups are made at the relative barrier at which they depend least on single connections, but never above what hovering 2 mm
off the object costs: a hand that far off touches nothing, so that a higher barrier is crossed by letting go, whatever the
grasps are. Each landscape so has a barrier of its own; --group-barrier gives them one.";

const INSPECT_EXAMPLES: &str = "\
Examples:
  landscape inspect grasps.parquet                         the file in numbers: who passes, and quantiles
  landscape inspect grasps.parquet --each                  one line for each grasp
  landscape inspect grasps.parquet --grasp 17 --grasp 40   all about two of them
  landscape inspect contacts.json                          bare contacts: balance, forces, ε
  landscape inspect grasps.landscape --path m3 m17         why the barrier between two minima is high
  landscape inspect grasps.parquet --json | jq '.grasps[] | select(.epsilon < 0.05) | .id'

What is measured:
  |Gc|       wrench left over when all contacts push equally along their normals; below 0.5 passes the relaxed test
  friction   least friction coefficient at which forces balance (exact); inf where none does
  epsilon    Ferrari-Canny: the least wrench that can be resisted, per unit sum of normal forces, at friction 0.5 with
             eight edges a cone; not positive where some wrench cannot be resisted
  gap        distance of the farthest contact from the surface, on the exact mesh
  depth      deepest point of the hand in the object or of the object in the hand, on the exact mesh and the hand as
             `export glb` writes it
Arms of torques are divided by the object's radius, so all but gap and depth are dimensionless.

Bare contacts (JSON; at most 400, lengths in any one unit, normals of any length):
  {
    \"contacts\": [
      {\"position\": [0.03, 0.00, 0.09], \"inward_normal\": [-1, 0, 0]},
      {\"position\": [-0.03, 0.01, 0.09], \"inward_normal\": [1, 0, 0]}
    ],
    \"centre\": [0, 0, 0.09],     torques are taken about it; default: the mean of the positions
    \"length\": 0.1,              arms are divided by it; default: the longest arm
    \"friction\": 0.5             for force closure, forces and epsilon; default: 0.5
  }";

const STABILITY_EXAMPLES: &str = "\
Examples:
  landscape stability grasps.parquet                       grasps.stability.parquet: the same with a column `stable`
  landscape stability grasps.parquet --protocol six-directions -o held.parquet
  landscape stability grasps.parquet --print-protocol > mine.toml
  landscape stability grasps.parquet --settings mine.toml  a protocol of your own

Protocols (rigid bodies, Coulomb friction, the Rapier engine in its deterministic mode):
  drop                  The test of Liu et al. (2021): a rigid hand that does not move, gravity of 10 m/s² down the object's
                        z axis, 1000 steps of 1/60 s; stable if the object falls less than 0.3 m. Friction 0.25 in contact:
                        0.5 for each body, multiplied. The object first settles for a second without gravity; what presses
                        is what overlaps. An object at rest (10 µm in a quarter of a second) holds: the test ends.
  six-directions        The test in use today (DexGraspBench): no gravity, the object is given 0.1 kg and pushed with 1 N
                        along ±x, ±y and ±z, 2 s each; stable if it moves less than 5 cm and turns less than 15° in all six.
                        Friction 0.6. The joints squeeze: springs pull them toward the object.
  six-directions-rigid  The same with rigid joints.
In all of them more than 1 cm of overlap at the start fails.

Adds the columns stable, stable_reason (held, overlap, fell, moved, turned, lost), stable_displacement_m and
stable_turn_rad; the protocol with all its numbers goes into the file's metadata. Objects are cut into convex pieces; how
well these fit is told. An interrupted run continues where it stopped when the same command is given again.";

const LABEL_EXAMPLES: &str = "\
Examples:
  landscape label grasps.parquet                           grasps.labelled.parquet: the same with grasp types
  landscape label grasps.parquet --explain 17              why grasp 17 is what it is
  landscape label grasps.parquet --sheet sheet.html        a page on which you label by clicking; it saves labels.csv
  landscape label grasps.parquet --from labels.csv         the same with your labels, which win
  landscape label mine.parquet -o mine.parquet --force     in place

The types are the 33 of the GRASP taxonomy (Feix et al. 2016). The rule looks at all of the hand within 5 mm of the object,
at the pose of the fingers and at the object where it is held. Where two types fit as well it tells the cell of the
taxonomy's table (category/opposition/virtual finger 2/thumb); where none fits, `unlisted`; for a hand without a thumb
and fingers of a human one, `not_applicable`.

Adds the columns label (yours), label_auto, label_score, label_best, label_category and label_source. labels.csv has the
columns id and label: a name or number of a type, or `unlisted`.";

const BAKE_EXAMPLES: &str = "\
Examples:
  landscape objects bake model.safetensors --scale 0.1 -o bottle.obj
                                                           shape 0 of a trained decoder, 0.1 m per unit
  landscape objects bake model.safetensors --specs s.json --codes codes.safetensors --code 7 --scale 0.1 -o jar.obj
  landscape synth --object bottle.obj -n 64                then as any other object

The network is the decoder of DeepSDF: negative inside, shapes scaled into a ball of radius 1. Its zero level becomes a
closed mesh, and that a smooth field, which has the curvature that a network of rectifiers lacks. The field is kept in the
cache folder of the system. Checkpoints of torch (.pth) are converted by the script in docs/neural_objects.md.";

fn surface_examples() -> String {
    let models = MODELS.iter().map(|model| {
        let call = format!("{} {}", model.name, model.arguments);
        format!("  {call:<40}{}\n", model.about)
    });
    format!(
        "{SURFACE_EXAMPLES}\n\nModels:\n{}",
        models.collect::<String>().trim_end()
    )
}

const SURFACE_EXAMPLES: &str = r#"Finds every minimum and every saddle between them that it can, from random points and the energy alone: it climbs from
minima along their modes and from random places, descends on both sides of each saddle, and stops when it has found
nothing new for long. How complete that is is estimated and told.

Examples:
  landscape surface muller-brown                           writes muller-brown.landscape/
  landscape surface lj 7 -o seven.landscape                7 Lennard-Jones atoms: 4 minima, 12 saddles
  landscape surface --command "python3 my_energy.py" --region=-1.5:1,-0.3:1.8
                                                           your own energy, starts drawn from this box

Your program answers a line for a line (docs/external_energy.md has a whole example):
  asked on standard input       {"x": [0.5, -1.25]}
  answered on standard output   {"energy": 3.5, "gradient": [0.25, -1.0]}   or {"energy": null} outside the domain
Without "gradient" it is taken by differences. One program runs on each thread.

Writes what `landscape build` writes, and stationary.parquet: all minima and saddles with their curvatures, which are in
min.data and ts.data, too. An interrupted run continues where it stopped when the same command is given again; with --resume
it must, with --fresh it begins anew."#;

const DRAW_EXAMPLES: &str = "\
Examples:
  landscape draw grasps.landscape --lowest 50              grasps.view/: the 50 lowest minima (and groups)
  landscape draw grasps.landscape --min-members 2 --levels 20
  landscape draw grasps.landscape --pick m0,m4,m31 -o three
  landscape draw grasps.landscape --stability grasps.stability.parquet
  landscape draw grasps.landscape --colour category --examples 8

A hidden minimum still joins those that are shown: no choice of minima moves a merge. --levels raises every merge to the
next of so many even levels. Pictures of groups (disconnectivity, barriers) and of minima (…_minima) take the same
choices, each of its own leaves; picking a minimum picks its group. Writes the pictures (SVG and PNG), and tree.nwk,
tree.dot, tree.json and barriers.graphml of what is shown of the minima.";

const COMPARE_EXAMPLES: &str = "\
Examples:
  landscape compare grasps.landscape                       grasps.comparison.md, .json, .png, .svg
  landscape compare human.landscape gripper.landscape      which grasp types each of them holds

Labels minima by the rule of `landscape label` (labels that the landscape was built with win), and tests by permutation
whether heights between them go with their categories and types: dendrogram purity, ANOSIM, PERMANOVA, Mantel, Moran's I,
assortativity, barrier ratios, cuts of the tree. Hypotheses and the thresholds at which they hold were written down before
the first run (data/taxonomy/hypotheses.toml); p-values are corrected over all of them (Holm). Three of them ask the energy:
along the ways between spheres, after fingers have been lifted, and on hands without a thumb.";

const DIFF_EXAMPLES: &str = "\
Examples:
  landscape diff warm.landscape cold.landscape             tables on standard output
  landscape diff a.landscape b.landscape --within 0.01 --json

For landscapes of one hand, or of one surface, made at another temperature, with other weights or another object: which
minima correspond (the nearest, within the distance at which two minima were one, or --within), whose energies moved, which
merges of the first moved and by how much, and what vanished and appeared. Heights are compared for all pairs at once by
the cophenetic distance and correlation of the two trees.";

const OBJECT_EXAMPLES: &str = "\
Examples:
  landscape objects inspect bottle.obj                     a table, and bottle.png
  landscape objects inspect scan.ply --scale 0.001         a mesh in millimetres
  landscape objects inspect bottle.obj --side-file bottle.json
                                                           declares the symmetry that was found

Meshes may consist of several closed pieces; where these overlap or touch, the solid is their union. Small holes, triangles
that face the wrong way and pieces that are inside out are repaired, and that is told; a surface without an inside is
refused.

Shapes (TOML; metres; a union of all parts):
  name = \"dumbbell\"
  mass_kg = 0.4
  [[parts]]
  cylinder = { centre = [0, 0, 0], axis = [0, 0, 1], radius_m = 0.012, half_height_m = 0.06 }
  [[parts]]
  sphere = { centre = [0, 0, 0.06], radius_m = 0.025 }
  [[parts]]
  cuboid = { centre = [0, 0, -0.06], half_extents = [0.02, 0.02, 0.015], edge_radius_m = 0.003 }
There is also capsule = { a = […], b = […], radius_m = … }.";

const EXPORT_EXAMPLES: &str = "\
Examples:
  landscape export grasps.parquet csv                      grasps.csv: a row a grasp, a column a joint
  landscape export grasps.parquet qpos -o grasps.npy       rows of MuJoCo's qpos: position, quaternion w x y z, joints
  landscape export grasps.parquet dexgraspnet              grasps.npy, as DexGraspNet's own files
  landscape export grasps.parquet glb                      grasps.scenes/: hand (as it is judged), object and contacts
  landscape export grasps.parquet glb --grasp 17 -o 17.glb

Poses are those of the hand's root in the object's frame: p_object = R p_hand + t, in metres; angles are in radians. In qpos
the hand's outermost body has a free joint; the columns of the CSV form name its joints. csv and json come back with
`landscape import`, to the last bit.";

const IMPORT_EXAMPLES: &str = "\
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

/// Synthesize grasps.
#[derive(Debug, Args)]
pub(super) struct Synth {
    /// The hand: a name of one that comes with the program (`human` unless told otherwise), or a URDF,
    /// MJCF or MANO (.npz) file.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) hand: Option<String>,
    /// The folder in which everything lies that the hand's description refers to (meshes, included files); its own
    /// folder unless told otherwise. Files elsewhere are refused.
    #[arg(long, value_name = "FOLDER", conflicts_with = "from")]
    pub(super) hand_folder: Option<PathBuf>,
    /// The hand's mirror image instead: a left hand of a right one.
    #[arg(long, conflicts_with = "from")]
    pub(super) mirror: bool,
    /// The object: a name of one that comes with the program, a mesh (OBJ, STL, PLY, glTF; metres unless --scale says
    /// otherwise), or a TOML file of shapes (see `landscape help objects inspect`).
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath, required_unless_present = "from")]
    pub(super) object: Option<String>,
    /// What files and pictures call the object, instead of the name of its file.
    #[arg(
        long,
        value_name = "NAME",
        requires = "object",
        conflicts_with = "from"
    )]
    pub(super) name: Option<String>,
    /// Metres per unit of the object's mesh (from a millionth to a million): 0.001 for millimetres, 0.1 for a mesh of unit size that is to be 10 cm in radius.
    #[arg(
        long,
        value_name = "FACTOR",
        conflicts_with = "from",
        allow_negative_numbers = true
    )]
    pub(super) scale: Option<f64>,
    /// Start from the grasps of a file instead of random poses: chain i from row i, and again from the first after the
    /// last. Hand and object are those of the file, unless others are named.
    #[arg(long, value_name = "FILE")]
    pub(super) from: Option<PathBuf>,
    /// Move each given grasp by so many millimetres in a random direction first (as poses are measured: the root mean
    /// square way of the hand's surface).
    #[arg(
        long,
        value_name = "MM",
        requires = "from",
        allow_negative_numbers = true
    )]
    pub(super) perturb: Option<f64>,
    /// Number of chains, a million at most; each gives one grasp, if its end passes the filter. By default 64, or one for
    /// each given grasp.
    #[arg(short = 'n', long, value_name = "N")]
    pub(super) chains: Option<u64>,
    /// Steps of each chain.
    #[arg(long, value_name = "N")]
    pub(super) steps: Option<u32>,
    /// Number of contacts of a grasp.
    #[arg(long, value_name = "N")]
    pub(super) contacts: Option<usize>,
    /// Seed of every random draw.
    #[arg(long, default_value_t = 0)]
    pub(super) seed: u64,
    /// Energy and sampler: `default` (smooth, physical), `paper` (as printed) or `released` (as the authors' code has it).
    #[arg(
        long,
        default_value = "default",
        value_name = "NAME",
        conflicts_with = "config"
    )]
    pub(super) preset: String,
    /// Experiment file (TOML) with the sections [energy] and [synthesis]; see data/experiments.
    #[arg(long, value_name = "FILE")]
    pub(super) config: Option<PathBuf>,
    /// Which grasps to keep: those that pass the strict filter, those that also press firmly, those that pass the
    /// published filter (Eq. 11), or all.
    #[arg(long, value_enum, default_value_t = Keep::Strict)]
    pub(super) keep: Keep,
    /// Keep at most N of them, chosen so that they are spread evenly over the object.
    #[arg(long, value_name = "N")]
    pub(super) spread: Option<usize>,
    /// The file to write.
    #[arg(long, short, default_value = "grasps.parquet", value_name = "FILE")]
    pub(super) output: PathBuf,
    #[command(flatten)]
    pub(super) again: Again,
}

/// Which grasps to keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Keep {
    /// Those a person could hold: contacts within 2 mm, nothing deeper than 2 mm, exact force closure, …
    Strict,
    /// Those whose hand, closed at the end until it presses, passes the strict filter and holds with all that touches:
    /// made to stay in the hand in simulation. No minima of the energy, from which they lie a millimetre or two.
    Firm,
    /// Those that pass Eq. 11 of the paper.
    Published,
    /// Every chain's end.
    All,
}

/// Map a landscape.
#[derive(Debug, Args)]
pub(super) struct Build {
    /// The grasps: a file of `landscape synth`, or of your own with the same columns.
    #[arg(value_name = "FILE")]
    pub(super) grasps: PathBuf,
    /// The folder to write; by default the name of the file with the ending `.landscape`.
    #[arg(long, short, value_name = "FOLDER")]
    pub(super) output: Option<PathBuf>,
    /// Each minimum is connected to this many nearest ones, and along a minimum spanning tree of distances; 6 by default, more
    /// lower some barriers.
    #[arg(long, value_name = "K")]
    pub(super) neighbours: Option<usize>,
    /// Temperature T of attraction–diffusion; by default the best of a few that are tried on a dozen pairs first.
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(super) temperature: Option<f64>,
    /// Pull F = αT of attraction–diffusion, energy per metre; chosen likewise.
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    pub(super) pull: Option<f64>,
    /// Measure the magnetisation diagram first (diagram.json and a picture): at which T and F chains get through. It
    /// then chooses T and F where they are not given. It costs as much as the map of thirty grasps.
    #[arg(long)]
    pub(super) diagram: bool,
    /// How paths relax.
    #[arg(long, value_enum, default_value_t)]
    pub(super) paths: Paths,
    /// Map by sequential ADELM as published: minima are assigned one by one, in the order of the file, to the group they
    /// reach over the lowest raw barrier. Every barrier is an upper bound, and the result depends on the order; for
    /// comparison.
    #[arg(long, conflicts_with = "group_barrier")]
    pub(super) sequential: bool,
    #[command(flatten)]
    pub(super) groups: GroupBarrier,
    /// Map only the grasps that held in simulation: the column `stable` of `landscape stability`.
    #[arg(long)]
    pub(super) only_stable: bool,
    /// Map only the first N grasps: a quick look.
    #[arg(long, value_name = "N")]
    pub(super) first: Option<usize>,
    /// Seed of every random draw.
    #[arg(long, default_value_t = 0)]
    pub(super) seed: u64,
    #[command(flatten)]
    pub(super) of: HandAndObject,
    #[command(flatten)]
    pub(super) again: Again,
}

/// The barrier up to which minima are one group.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct GroupBarrier {
    /// Minima joined by a relative barrier of at most E, in units of the energy, are one group. Only at one E do two
    /// landscapes have comparable groups.
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    pub(super) group_barrier: Option<f64>,
}

impl GroupBarrier {
    /// What was given, as far as it makes sense.
    pub(super) fn checked(self) -> anyhow::Result<Option<f64>> {
        if let Some(barrier) = self.group_barrier {
            anyhow::ensure!(
                barrier.is_finite() && barrier >= 0.0,
                "--group-barrier {barrier}: a number in units of the energy is needed, 0 or more"
            );
        }
        Ok(self.group_barrier)
    }
}

/// Judge grasps.
#[derive(Debug, Args)]
pub(super) struct Inspect {
    /// Grasps (Parquet, as of `landscape synth`), bare contacts (JSON, see below), or with --path a landscape.
    #[arg(value_name = "FILE")]
    pub(super) file: PathBuf,
    /// All about the grasp with this id, instead of the summary; may be given several times.
    #[arg(long, value_name = "ID")]
    pub(super) grasp: Vec<u64>,
    /// One line for each grasp, instead of the summary.
    #[arg(long, conflicts_with = "grasp")]
    pub(super) each: bool,
    /// Write everything as JSON.
    #[arg(long)]
    pub(super) json: bool,
    /// Of a landscape: the lowest way between two minima (m3, m17) or groups (g0, g4: their lowest minima), as pictures with
    /// the energy by term along it (PNG, SVG) and as an animation (glTF).
    #[arg(long, num_args = 2, value_names = ["FROM", "TO"], conflicts_with_all = ["grasp", "each", "hand", "object"])]
    pub(super) path: Option<Vec<String>>,
    /// Pictures along the way.
    #[arg(long, value_name = "N", requires = "path", default_value_t = 8)]
    pub(super) pictures: usize,
    /// Name of the files of a way, without .png, .svg, .glb; by default that of the landscape with `.FROM-TO`.
    #[arg(short, long, value_name = "NAME", requires = "path")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) of: HandAndObject,
}

/// Hand and object of grasps whose file does not describe them, or others to judge the poses with.
#[derive(Debug, Args)]
pub(super) struct HandAndObject {
    /// The hand: for a file that does not describe it, or to judge the poses with another one of the same joints. Contacts
    /// are then chosen anew.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) hand: Option<String>,
    /// The object: for a file that does not describe it, or to judge the poses with another one. It is taken at its own
    /// size. What was measured is then measured anew; labels and outcomes of simulations are dropped.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) object: Option<String>,
}

/// Name grasps.
#[derive(Debug, Args)]
pub(super) struct LabelCommand {
    /// The grasps.
    #[arg(value_name = "FILE")]
    pub(super) grasps: PathBuf,
    /// Tell what spoke for and against the label of the grasp with this id, and write nothing; may be given several times.
    #[arg(long, value_name = "ID", conflicts_with_all = ["sheet", "output"])]
    pub(super) explain: Vec<u64>,
    /// Labels given by a human (CSV with the columns id and label): they win over the rule's.
    #[arg(long, value_name = "FILE")]
    pub(super) from: Option<PathBuf>,
    /// Write a page (HTML) on which the grasps can be labelled, instead of labels.
    #[arg(long, value_name = "FILE", conflicts_with = "output")]
    pub(super) sheet: Option<PathBuf>,
    /// Signatures of your own, in the form of data/taxonomy/signatures.toml, instead of those that come with the program.
    #[arg(long, value_name = "FILE")]
    pub(super) rule: Option<PathBuf>,
    /// The file to write; by default the name of the file with the ending `.labelled.parquet`.
    #[arg(long, short, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) of: HandAndObject,
}

/// Hands.
#[derive(Debug, Args)]
pub(super) struct Hands {
    #[command(subcommand)]
    pub(super) command: HandsCommand,
}

#[derive(Debug, Subcommand)]
pub(super) enum HandsCommand {
    /// List the hands that come with the program
    List,
    /// Show what is derived of a hand (table, picture), and write a side file in which any of it can be changed
    #[command(after_help = HANDS_EXAMPLES)]
    Inspect(HandsInspect),
}

/// What is derived of a hand.
#[derive(Debug, Args)]
pub(super) struct HandsInspect {
    /// The hand: a name of one that comes with the program, or a URDF, MJCF or MANO (.npz) file.
    #[arg(value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) hand: String,
    /// The folder in which everything lies that the hand's description refers to (meshes, included files); its own
    /// folder unless told otherwise. Files elsewhere are refused.
    #[arg(long, value_name = "FOLDER")]
    pub(super) hand_folder: Option<PathBuf>,
    /// Its mirror image instead.
    #[arg(long)]
    pub(super) mirror: bool,
    /// Name of the side file and the picture, without .json and .png; by default in the current folder, that of the hand.
    #[arg(long, short, value_name = "NAME")]
    pub(super) output: Option<PathBuf>,
    /// The side file to write (.json), where it is to have a name of its own. One beside the description, of the same
    /// name, is read with it.
    #[arg(long, value_name = "FILE")]
    pub(super) side_file: Option<PathBuf>,
    /// The picture to write (.png), where it is to have a name of its own.
    #[arg(long, value_name = "FILE")]
    pub(super) picture: Option<PathBuf>,
}

/// Simulate grasps.
#[derive(Debug, Args)]
pub(super) struct Stability {
    /// The grasps: a file of `landscape synth`, or of your own with the same columns.
    #[arg(value_name = "FILE")]
    pub(super) grasps: PathBuf,
    /// What is tested, see below.
    #[arg(long, value_enum, default_value_t = ProtocolName::Drop, conflicts_with = "settings")]
    pub(super) protocol: ProtocolName,
    /// A protocol of your own (TOML): `protocol = "drop"` or `"six-directions"` and any of its numbers.
    #[arg(long, value_name = "FILE")]
    pub(super) settings: Option<PathBuf>,
    /// Write the protocol with all its numbers to standard output, and do nothing else.
    #[arg(long)]
    pub(super) print_protocol: bool,
    /// The file to write; by default the name of the grasps with the ending `.stability.parquet`.
    #[arg(long, short, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) of: HandAndObject,
    #[command(flatten)]
    pub(super) again: Again,
}

/// Tests of stability.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum ProtocolName {
    /// Gravity on an object in a rigid hand.
    Drop,
    /// Pushes along six directions in a hand that squeezes.
    SixDirections,
    /// Pushes along six directions in a rigid hand.
    SixDirectionsRigid,
}

/// Objects.
#[derive(Debug, Args)]
pub(super) struct Objects {
    #[command(subcommand)]
    pub(super) command: ObjectsCommand,
}

#[derive(Debug, Subcommand)]
pub(super) enum ObjectsCommand {
    /// List the objects that come with the program
    List,
    /// Show what is derived of an object (table, picture): size, pieces, volume, accuracy of its smooth field, symmetry
    #[command(after_help = OBJECT_EXAMPLES)]
    Inspect(ObjectsInspect),
    /// Make an object of a neural signed-distance function: a mesh, with its smooth field in the cache
    #[command(after_help = BAKE_EXAMPLES)]
    Bake(Bake),
}

/// What is derived of an object.
#[derive(Debug, Args)]
pub(super) struct ObjectsInspect {
    /// The object: a name of one that comes with the program, a mesh (OBJ, STL, PLY, glTF), or a TOML file of shapes.
    #[arg(value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) object: String,
    /// Metres per unit of the mesh.
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    pub(super) scale: Option<f64>,
    /// The picture to write (.png); by default in the current folder, named after the object.
    #[arg(long, value_name = "FILE")]
    pub(super) picture: Option<PathBuf>,
    /// Write a description (.json) with the symmetry that was found. One beside the mesh, of the same name, is read with it.
    #[arg(long, value_name = "FILE")]
    pub(super) side_file: Option<PathBuf>,
}

/// Make an object of a network.
#[derive(Debug, Args)]
pub(super) struct Bake {
    /// Weights of the decoder (.safetensors).
    #[arg(value_name = "MODEL")]
    pub(super) model: PathBuf,
    /// What the network looks like: the specs.json of its experiment; by default the one beside the model.
    #[arg(long, value_name = "FILE")]
    pub(super) specs: Option<PathBuf>,
    /// The latent codes (.safetensors): by default the tensor `latent_codes` of the model.
    #[arg(long, value_name = "FILE")]
    pub(super) codes: Option<PathBuf>,
    /// Which latent code, from 0.
    #[arg(long, value_name = "I", default_value_t = 0)]
    pub(super) code: usize,
    /// Metres per unit of the network: about half the longest side of the object.
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    pub(super) scale: f64,
    /// How finely the surface is taken: cells along the diameter of the network's ball.
    #[arg(long, value_name = "N", default_value_t = 128)]
    pub(super) cells: u32,
    /// The mesh to write (.obj).
    #[arg(long, short, value_name = "FILE")]
    pub(super) output: PathBuf,
}

/// Map a surface.
#[derive(Debug, Args)]
pub(super) struct Surface {
    /// The model and its arguments, as listed below.
    #[arg(
        value_name = "MODEL",
        required_unless_present = "command",
        conflicts_with = "command",
        allow_negative_numbers = true
    )]
    pub(super) model: Vec<String>,
    /// A program that computes the energy, as the shell would run it.
    #[arg(long, value_name = "COMMAND", requires = "region")]
    pub(super) command: Option<String>,
    /// Where random starts are drawn: low:high for each coordinate; `-1:1x21` stands for 21 alike.
    #[arg(long, value_name = "LOW:HIGH,...", allow_hyphen_values = true)]
    pub(super) region: Option<String>,
    /// What the coordinates of the program's energy are.
    #[arg(long, value_enum, default_value_t = Coordinates::Flat, requires = "command")]
    pub(super) coordinates: Coordinates,
    /// How long the program may take over one answer.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = External::ANSWER_LIMIT.as_secs_f64(),
        requires = "command",
        allow_negative_numbers = true
    )]
    pub(super) answer_seconds: f64,
    /// The folder to write; by default the name of the model with the ending `.landscape`.
    #[arg(long, short, value_name = "FOLDER")]
    pub(super) output: Option<PathBuf>,
    /// Stop after this many searches without anything new for every minimum and saddle found.
    #[arg(long, value_name = "N")]
    pub(super) patience: Option<usize>,
    /// Stop after about this many searches in any case.
    #[arg(long, value_name = "N")]
    pub(super) searches: Option<usize>,
    /// How the paths relax that join minima which no search joined.
    #[arg(long, value_enum, default_value_t)]
    pub(super) paths: Paths,
    #[command(flatten)]
    pub(super) groups: GroupBarrier,
    /// Seed of every random draw.
    #[arg(long, default_value_t = 0)]
    pub(super) seed: u64,
    #[command(flatten)]
    pub(super) again: Again,
}

/// How paths relax.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub(super) enum Paths {
    /// A string: its images are put back at even distances.
    #[default]
    String,
    /// A nudged elastic band whose highest image climbs.
    Band,
}

impl From<Paths> for PathMethod {
    fn from(paths: Paths) -> Self {
        match paths {
            Paths::String => Self::String,
            Paths::Band => Self::Band,
        }
    }
}

/// What coordinates are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Coordinates {
    /// Numbers of a flat space.
    Flat,
    /// Angles in radians, which wrap.
    Angles,
    /// Positions x, y, z of equal atoms: moved, turned, mirrored and renumbered copies are one.
    Atoms,
    /// A unit quaternion w, x, y, z; the gradient has three numbers, by rotation about the body's own axes.
    Rotation,
}

/// Draw a landscape again.
#[derive(Debug, Args)]
pub(super) struct Draw {
    /// The landscape: a folder of `landscape build`, `surface` or `import`.
    #[arg(value_name = "FOLDER")]
    pub(super) landscape: PathBuf,
    /// The folder to write; by default the name of the landscape with the ending `.view`.
    #[arg(long, short, value_name = "FOLDER")]
    pub(super) output: Option<PathBuf>,
    /// Only the N lowest.
    #[arg(long, value_name = "N")]
    pub(super) lowest: Option<usize>,
    /// Only those with at least N members.
    #[arg(long, value_name = "N")]
    pub(super) min_members: Option<usize>,
    /// Only the bottoms of monotonic sequences: those that no connection joins to a lower one.
    #[arg(long)]
    pub(super) monotonic: bool,
    /// Only these minima, named as in the tree: m0,m4,m31.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub(super) pick: Vec<String>,
    /// Colour minima by whether their grasps held in simulation: the file that `landscape stability` wrote of the same
    /// grasps.
    #[arg(long, value_name = "FILE")]
    pub(super) stability: Option<PathBuf>,
    /// Colour minima by their grasp type, as `landscape label` names it (labels that the landscape was built with win).
    #[arg(long, value_name = "DIFFERENCES", conflicts_with = "stability")]
    pub(super) colour: Option<Colouring>,
    /// Put N rendered grasps with the names of their types below the disconnectivity graph of the groups.
    #[arg(long, value_name = "N")]
    pub(super) examples: Option<usize>,
    /// Raise every merge to the next of N even levels between the lowest merge and the highest.
    #[arg(long, value_name = "N")]
    pub(super) levels: Option<usize>,
    #[command(flatten)]
    pub(super) groups: GroupBarrier,
    /// Seed of the layout; by default that of the landscape.
    #[arg(long)]
    pub(super) seed: Option<u64>,
}

/// Hold a landscape against the taxonomy.
#[derive(Debug, Args)]
pub(super) struct Compare {
    /// The landscape of some grasps.
    #[arg(value_name = "LANDSCAPE")]
    pub(super) landscape: PathBuf,
    /// Another one, of any hand and object: which types and cells of the taxonomy each of them holds.
    #[arg(value_name = "OTHER")]
    pub(super) other: Option<PathBuf>,
    /// Name of the files to write, without .md, .json, .png and .svg; by default that of the landscape with `.comparison`.
    #[arg(short, long, value_name = "NAME")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) groups: GroupBarrier,
    /// Seed of permutations and resamplings.
    #[arg(long, default_value_t = 0)]
    pub(super) seed: u64,
}

/// Compare two landscapes.
#[derive(Debug, Args)]
pub(super) struct Diff {
    /// The first landscape.
    #[arg(value_name = "BEFORE")]
    pub(super) before: PathBuf,
    /// The second.
    #[arg(value_name = "AFTER")]
    pub(super) after: PathBuf,
    /// Minima correspond up to this distance (metres for grasps); by default what made two minima one.
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(super) within: Option<f64>,
    /// Write everything as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

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
    pub(super) groups: GroupBarrier,
    /// What to write: by default, where you are, the name of the file with the ending `.parquet`, or of the folder with
    /// the ending `.landscape`.
    #[arg(long, short, value_name = "PATH")]
    pub(super) output: Option<PathBuf>,
}

/// Write grasps for other programs.
#[derive(Debug, Args)]
pub(super) struct Export {
    /// The grasps: a file of `landscape synth` or `import`.
    #[arg(value_name = "FILE")]
    pub(super) grasps: PathBuf,
    /// What to write.
    #[arg(value_enum, value_name = "FORMAT")]
    pub(super) format: ExportFormat,
    /// Only the grasp with this number; may be given several times.
    #[arg(long, value_name = "ID")]
    pub(super) grasp: Vec<u64>,
    /// The file to write (a folder of scenes for glb); by default, where you are, named after the grasps.
    #[arg(long, short, value_name = "PATH")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) of: HandAndObject,
}

/// Formats of exports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum ExportFormat {
    /// A table, one row a grasp.
    Csv,
    /// A list of objects with named entries.
    Json,
    /// DexGraspNet's array of dictionaries (.npy).
    Dexgraspnet,
    /// `MuJoCo`'s qpos (.csv or .npy).
    Qpos,
    /// A binary glTF scene for each grasp.
    Glb,
}
