//! The verbs, and the arguments that several of them share. Those of one verb are in its own file.

use anyhow::Context;
use clap::{Args, Parser, Subcommand, ValueHint};

use super::input::within;
use super::provenance::Provenance;
use super::{
    build, compare, diff, draw, export, hands, import, inspect, label, objects, stability, surface,
    synth,
};
use crate::limits::THREADS;
use crate::topography::{GroupSettings, PathMethod};

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

/// Handling of an interrupted run, which is continued by default.
#[derive(Debug, Args)]
pub(super) struct Again {
    /// Continue an interrupted run, and refuse to begin a new one. (Without this flag, a run also continues where it
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
    #[command(after_help = synth::EXAMPLES)]
    Synth(synth::Synth),
    /// Map the energy landscape between the grasps of a file
    #[command(after_help = build::EXAMPLES)]
    Build(build::Build),
    /// Judge the grasps of a file, or contacts without a hand
    #[command(after_help = inspect::EXAMPLES)]
    Inspect(inspect::Inspect),
    /// List the built-in hands, or show the derived properties of your own hand
    Hands(hands::Hands),
    /// Simulate the grasps of a file: would the object stay in the hand?
    #[command(after_help = stability::EXAMPLES)]
    Stability(stability::Stability),
    /// Label the grasps of a file with types of the GRASP taxonomy, by a rule or by hand
    #[command(after_help = label::EXAMPLES)]
    Label(label::LabelCommand),
    /// List the built-in objects, show the derived properties of your own object, or make an object from a neural network
    Objects(objects::Objects),
    /// Map a surface: a named model, or your own energy
    #[command(after_help = surface::examples())]
    Surface(surface::Surface),
    /// Draw a finished landscape again, with some of its minima or at a few levels
    #[command(after_help = draw::EXAMPLES)]
    Draw(draw::Draw),
    /// Compare a landscape with the taxonomy of grasps, with statistics
    #[command(after_help = compare::EXAMPLES)]
    Compare(compare::Compare),
    /// Show the differences between two landscapes
    #[command(after_help = diff::EXAMPLES)]
    Diff(diff::Diff),
    /// Read grasps of other programs, or min.data and ts.data of PATHSAMPLE or topsearch
    #[command(after_help = import::EXAMPLES)]
    Import(import::Import),
    /// Write grasps for other programs: tables, DexGraspNet, MuJoCo, glTF scenes
    #[command(after_help = export::EXAMPLES)]
    Export(export::Export),
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

/// The greatest barrier within a group.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct GroupBarrier {
    /// Minima joined by a relative barrier of at most E, in units of the energy, are one group. The groups of two
    /// landscapes are comparable only at the same E.
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    pub(super) group_barrier: Option<f64>,
}

impl GroupBarrier {
    /// Returns the given barrier if it is valid.
    pub(super) fn checked(self) -> anyhow::Result<Option<f64>> {
        if let Some(barrier) = self.group_barrier {
            anyhow::ensure!(
                barrier.is_finite() && barrier >= 0.0,
                "--group-barrier {barrier}: a number in units of the energy is needed, 0 or more"
            );
        }
        Ok(self.group_barrier)
    }

    pub(super) fn settings(self) -> GroupSettings {
        GroupSettings {
            barrier: self.group_barrier,
            ..GroupSettings::default()
        }
    }
}

/// Hand and object of grasps whose file does not describe them, or others for judging the poses.
#[derive(Debug, Args)]
pub(super) struct HandAndObject {
    /// The hand, for a file that does not describe it, or another one with the same joints for judging the poses. Contacts
    /// are then chosen anew.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) hand: Option<String>,
    /// The object, for a file that does not describe it, or another one (in its own size) for judging the poses. All
    /// measures are then computed anew; labels and outcomes of simulations are dropped.
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    pub(super) object: Option<String>,
}

/// Relaxation method of paths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub(super) enum Paths {
    /// A string, whose images are redistributed at even distances.
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
