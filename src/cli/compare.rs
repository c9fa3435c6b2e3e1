//! `landscape compare`: a landscape against the taxonomy of grasps, with statistics; or the types of two landscapes.

use std::iter;
use std::path::{Path, PathBuf};

use clap::Args;

use super::args::{Common, FamilyBarrier};
use super::input::open_landscape;
use super::output::{Report, check_report, given_or_beside, write_report};
use crate::evaluation::taxonomy::Rule;
use crate::study::{NamedLandscape, StatisticsSettings, compare_types, compare_with_taxonomy};

/// Compare a landscape with the taxonomy.
#[derive(Debug, Args)]
pub(super) struct Compare {
    /// The landscape of grasps.
    #[arg(value_name = "LANDSCAPE")]
    landscape: PathBuf,
    /// Another landscape, of any hand and object, for comparing the types and cells of the taxonomy in the two.
    #[arg(value_name = "OTHER")]
    other: Option<PathBuf>,
    /// Name of the files to write, without .md, .json, .png and .svg; by default that of the landscape with `.comparison`.
    #[arg(short, long, value_name = "NAME")]
    output: Option<PathBuf>,
    #[command(flatten)]
    families: FamilyBarrier,
    /// Seed of permutations and resamplings.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape compare grasps.landscape                       grasps.comparison.md, .json, .png, .svg
  landscape compare human.landscape gripper.landscape      the grasp types in each of them

Labels minima by the rule of `landscape label` (labels in the landscape override the rule), and tests by permutation
whether the heights between minima depend on their categories and types: dendrogram purity, ANOSIM, PERMANOVA, Mantel,
Moran's I, assortativity, barrier ratios, cuts of the tree.";

pub(super) fn run(command: &Compare, common: &Common) -> anyhow::Result<()> {
    let rule = Rule::standard();
    let folder = &command.landscape;
    let output = given_or_beside(command.output.as_ref(), folder, "comparison")?;
    let inputs: Vec<&Path> = (iter::once(folder).chain(&command.other))
        .map(PathBuf::as_path)
        .collect();
    check_report(&output, &[], &inputs, common.force)?;
    let family_barrier = command.families.checked()?;
    let files = open_landscape(folder)?;
    let landscape = NamedLandscape::of(&files, folder, rule)?;
    if let Some(folder) = &command.other {
        let files = open_landscape(folder)?;
        let other = NamedLandscape::of(&files, folder, rule)?;
        let found = compare_types(&landscape, &other, family_barrier)?;
        let report = Report {
            text: found.text,
            value: found.value,
            chart: None,
            tables: Vec::new(),
        };
        return write_report(Some(&output), report, common);
    }
    let settings = StatisticsSettings::default();
    let found = compare_with_taxonomy(&landscape, &settings, family_barrier, command.seed)?;
    let report = Report {
        text: found.markdown(),
        value: found.to_json(),
        chart: found.without_labels().is_none().then(|| found.chart()),
        tables: Vec::new(),
    };
    write_report(Some(&output), report, common)
}
