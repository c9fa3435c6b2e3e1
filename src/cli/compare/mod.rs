//! `landscape compare`: a landscape beside the taxonomy of grasps, with statistics; or two landscapes' types beside each other.

mod basins;
mod experiments;
mod hypotheses;
mod report;
mod statistics;

use std::path::{Path, PathBuf};

use anyhow::Context;
use basins::Basins;
use clap::Args;
use experiments::Experiments;
use hypotheses::Settings;
use serde_json::{Value, json};

use super::args::{Common, GroupBarrier};
use super::output::check_file;
use super::{complain, print};
use crate::evaluation::taxonomy::Rule;
use crate::figure::MAKER;
use crate::figure::chart::Chart;
use crate::store::FileSet;

/// Hold a landscape against the taxonomy.
#[derive(Debug, Args)]
pub(super) struct Compare {
    /// The landscape of some grasps.
    #[arg(value_name = "LANDSCAPE")]
    landscape: PathBuf,
    /// Another one, of any hand and object: which types and cells of the taxonomy each of them holds.
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
  landscape compare human.landscape gripper.landscape      which grasp types each of them holds

Labels minima by the rule of `landscape label` (labels that the landscape was built with win), and tests by permutation
whether heights between them go with their categories and types: dendrogram purity, ANOSIM, PERMANOVA, Mantel, Moran's I,
assortativity, barrier ratios, cuts of the tree. Hypotheses and the thresholds at which they hold were written down before
the first run (data/taxonomy/hypotheses.toml); p-values are corrected over all of them (Holm). Three of them ask the energy:
along the ways between spheres, after fingers have been lifted, and on hands without a thumb.";

pub(super) fn run(command: &Compare, common: &Common) -> anyhow::Result<()> {
    let rule = Rule::standard();
    let settings = Settings::standard()?;
    let output = match &command.output {
        Some(output) => output.clone(),
        None => beside(command)?,
    };
    let inputs = [Some(&command.landscape), command.other.as_ref()];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
    for ending in [".svg", ".png", ".json", ".md"] {
        check_file(&named(&output, ending), &inputs, common)?;
    }
    let group_barrier = command.groups.checked()?;
    let first = Basins::read(&command.landscape, rule, group_barrier)?;
    if let Some(other) = &command.other {
        let other = Basins::read(other, rule, group_barrier)?;
        let (text, value) = report::coverage(&first, &other);
        return finish(&output, &super::shown(&text), &value, None, common);
    }
    let table = statistics::table(&first, &settings, command.seed);
    let experiments = Experiments::new(&command.landscape, rule, settings.least_per_class)?;
    let findings = hypotheses::examine(&first, &experiments, &settings, rule, command.seed)?;
    let text = super::shown(&report::markdown(&first, &table, &findings, rule));
    let value = json!({
        "made_by": MAKER,
        "landscape": first.name,
        "rule": rule.version,
        "settings": settings,
        "seed": command.seed,
        "group_barrier": first.group_barrier,
        "groups": first.groups,
        "statistics": table.rows,
        "cuts": table.cuts,
        "hypotheses": findings,
    });
    finish(&output, &text, &value, Some(report::chart(&table)), common)
}

/// `NAME.comparison` beside the landscape.
fn beside(command: &Compare) -> anyhow::Result<PathBuf> {
    let stem = command.landscape.file_stem();
    let stem = stem.with_context(|| format!("{} names no folder", command.landscape.display()))?;
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
    if !common.quiet {
        print(text);
        complain(&format!("wrote {}", report.display()));
    }
    Ok(())
}

/// The file of a comparison that ends like this.
fn named(output: &Path, ending: &str) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}
