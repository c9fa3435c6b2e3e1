//! `landscape inspect`: the quality of grasps or contacts.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;

use super::args::{Common, HandAndObject};

mod contacts;
mod grasps;
mod path;

/// Judge grasps.
#[derive(Debug, Args)]
pub(super) struct Inspect {
    /// Grasps (Parquet, as of `landscape synth`), contacts without a hand (JSON, see below), or with --path a landscape.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Show all details of the grasp with this id, instead of the summary; may be given several times.
    #[arg(long, value_name = "ID")]
    grasp: Vec<u64>,
    /// One line for each grasp, instead of the summary.
    #[arg(long, conflicts_with = "grasp")]
    each: bool,
    /// For a landscape: the lowest path found between two minima (m3, m17) or families (g0, g4: their lowest minima), as pictures
    /// with the energy by term along it (PNG, SVG) and as an animation (glTF).
    #[arg(long, num_args = 2, value_names = ["FROM", "TO"], conflicts_with_all = ["grasp", "each", "hand", "object"])]
    path: Option<Vec<String>>,
    /// Number of pictures along the path.
    #[arg(long, value_name = "N", requires = "path", default_value_t = 8)]
    pictures: usize,
    /// Name of the files of a path, without .png, .svg, .glb; by default that of the landscape with `.FROM-TO`.
    #[arg(short, long, value_name = "NAME", requires = "path")]
    output: Option<PathBuf>,
    #[command(flatten)]
    of: HandAndObject,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape inspect grasps.parquet                         how many grasps pass the strict filter, and why others do not
  landscape inspect grasps.parquet --verbose               the other filters too, and quantiles of all measures
  landscape inspect grasps.parquet --each                  one line for each grasp
  landscape inspect grasps.parquet --grasp 17 --grasp 40   all measures of two of them
  landscape inspect contacts.json                          bare contacts: balance, forces, ε
  landscape inspect grasps.landscape --path m3 m17         the lowest path found between two minima
  landscape inspect grasps.parquet --json | jq '.grasps[] | select(.epsilon < 0.05) | .id'

What is measured:
  net wrench      wrench left over when all contacts push equally along their normals (‖Gc‖); below 0.5 passes the relaxed
                  test
  least friction  least friction coefficient at which forces balance (exact); empty if they balance at none
  epsilon         Ferrari-Canny: the greatest wrench that can be resisted in every direction, per unit sum of normal
                  forces, at friction 0.5 with eight edges per cone; not positive if some wrench cannot be resisted
  gap             distance of the farthest contact from the surface, on the exact mesh
  depth           deepest point of the hand in the object or of the object in the hand, on the exact mesh and the hand as
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

pub(super) fn run(command: &Inspect, common: &Common) -> anyhow::Result<()> {
    if let Some(ends) = &command.path {
        return path::run(command, ends, common);
    }
    let name = command.file.display();
    anyhow::ensure!(
        !command.file.is_dir(),
        "{name} is a folder: name two minima of a landscape with --path m0 m1, or a file of grasps"
    );
    let bytes = std::fs::read(&command.file).with_context(|| format!("cannot read {name}"))?;
    let first = bytes.trim_ascii_start().first();
    anyhow::ensure!(
        first != Some(&b'['),
        "{name} contains a list, but bare contacts are given as {{\"contacts\": [...]}} (see `landscape inspect --help`)"
    );
    if first != Some(&b'{') {
        return grasps::run(command, common);
    }
    contacts::run(command, &bytes, common)
}
