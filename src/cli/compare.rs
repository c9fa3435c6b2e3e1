//! `landscape compare`: a landscape against the taxonomy of grasps, with statistics; or the types of two landscapes.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use serde_json::Value;

use super::args::{Common, GroupBarrier};
use super::input::open_landscape;
use super::output::check_file;
use crate::cli::printing::{complain, print, print_json, shown};
use crate::evaluation::taxonomy::Rule;
use crate::figure::MAKER;
use crate::figure::chart::Chart;
use crate::store::FileSet;
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
    groups: GroupBarrier,
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
    let output = match &command.output {
        Some(output) => output.clone(),
        None => beside(command)?,
    };
    let inputs = [Some(&command.landscape), command.other.as_ref()];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
    for ending in [".svg", ".png", ".json", ".md"] {
        check_file(&named(&output, ending), &inputs, common.force)?;
    }
    let group_barrier = command.groups.checked()?;
    let files = open_landscape(&command.landscape)?;
    let landscape = NamedLandscape::of(&files, &command.landscape, rule)?;
    if let Some(folder) = &command.other {
        let files = open_landscape(folder)?;
        let other = NamedLandscape::of(&files, folder, rule)?;
        let found = compare_types(&landscape, &other, group_barrier)?;
        return finish(&output, &shown(&found.text), &found.value, None, common);
    }
    let settings = StatisticsSettings::default();
    let found = compare_with_taxonomy(&landscape, &settings, group_barrier, command.seed)?;
    let text = shown(&found.markdown());
    let chart = found.without_labels().is_none().then(|| found.chart());
    finish(&output, &text, &found.to_json(), chart, common)
}

/// `NAME.comparison` beside the landscape.
fn beside(command: &Compare) -> anyhow::Result<PathBuf> {
    let stem = command.landscape.file_stem();
    let stem =
        stem.with_context(|| format!("{} does not name a folder", command.landscape.display()))?;
    let name = format!("{}.comparison", stem.to_string_lossy());
    Ok(command.landscape.with_file_name(name))
}

fn finish(
    output: &Path,
    text: &str,
    value: &Value,
    chart: Option<Chart>,
    common: &Common,
) -> anyhow::Result<()> {
    let mut files = FileSet::default();
    if let Some(chart) = chart {
        let sheet = chart.draw()?;
        for ending in [".svg", ".png"] {
            let path = named(output, ending);
            files.add(&path, &sheet.encode(&path)?)?;
        }
    }
    files.add(&named(output, ".json"), format!("{value:#}\n").as_bytes())?;
    let signed = format!("{text}\n<!-- Made by {MAKER}. -->\n");
    let report = named(output, ".md");
    files.add(&report, signed.as_bytes())?;
    files.finish()?;
    if common.json {
        print_json(value)?;
    }
    if !common.quiet {
        print(text);
        complain(&format!("wrote {}", report.display()));
    }
    Ok(())
}

fn named(output: &Path, ending: &str) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}
