//! `landscape label`: labels the grasps of a file with grasp types.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;

use super::args::{Common, HandAndObject};
use super::input;
use super::output::check_file;
use super::run::Watch;
use super::{complain, print};
use crate::evaluation::taxonomy::{Label, Rule, explain};
use crate::store::{GraspFile, GraspRow};
use crate::study::{Run, label_all, record_labels};

mod sheet;
mod summary;
mod table;

/// Label grasps.
#[derive(Debug, Args)]
pub(super) struct LabelCommand {
    /// The grasps.
    #[arg(value_name = "FILE")]
    grasps: PathBuf,
    /// Show the reasons for and against the label of the grasp with this id, and write nothing; may be given several times.
    #[arg(long, value_name = "ID", conflicts_with_all = ["sheet", "output"])]
    explain: Vec<u64>,
    /// Labels given by a human (CSV with the columns id and label), which override the rule.
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// Write a page (HTML) for labelling the grasps by hand, instead of labels.
    #[arg(long, value_name = "FILE", conflicts_with = "output")]
    sheet: Option<PathBuf>,
    /// Your own signatures, in the form of data/taxonomy/signatures.toml, instead of the built-in ones.
    #[arg(long, value_name = "FILE")]
    rule: Option<PathBuf>,
    /// The file to write; by default the name of the file with the ending `.labelled.parquet`.
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    of: HandAndObject,
}

pub(super) const EXAMPLES: &str = "\
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

pub(super) fn run(command: &LabelCommand, common: &Common) -> anyhow::Result<()> {
    let output = command
        .output
        .clone()
        .unwrap_or_else(|| command.grasps.with_extension("labelled.parquet"));
    let writes = command.explain.is_empty() && command.sheet.is_none();
    let inputs: Vec<&Path> = [
        Some(&command.grasps),
        command.from.as_ref(),
        command.rule.as_ref(),
    ]
    .into_iter()
    .flatten()
    .map(PathBuf::as_path)
    .collect();
    for path in command.sheet.iter().chain(writes.then_some(&output)) {
        check_file(path, &inputs, common)?;
    }
    let (mut file, mut warnings) = input::read(
        &command.grasps,
        command.of.hand.as_deref(),
        command.of.object.as_deref(),
    )?;
    let inputs = common.provenance.sources()?;
    // Labelling needs no energy.
    warnings.retain(|warning| !warning.contains("energy"));
    if !common.quiet {
        input::warn(&warnings);
    }
    let rule = rule(command)?;
    let name = command.grasps.display();
    for id in &command.explain {
        anyhow::ensure!(
            file.grasps.iter().any(|grasp| grasp.id == *id),
            "--explain {id}: {name} has no grasp with this id"
        );
    }
    if let Some(path) = &command.from {
        let given = table::read(path)?;
        honour(&mut file, &given, path)?;
    }

    let wanted = |row: &GraspRow| command.explain.is_empty() || command.explain.contains(&row.id);
    let watch = Watch::new(common.quiet);
    let run = Run {
        observer: &|news| watch.see(news),
        ..Run::default()
    };
    let labels = label_all(&file, &rule, wanted, &run)?;
    watch.clear();

    if !command.explain.is_empty() {
        print(&explanations(&file, &labels, &rule));
        return Ok(());
    }
    if let Some(path) = &command.sheet {
        sheet::write(path, &command.grasps, &file, &labels)?;
        if !common.quiet {
            complain(&format!("wrote {}", path.display()));
        }
        return Ok(());
    }
    file.metadata.remade_by(&common.provenance.command, inputs);
    record_labels(&mut file, &labels, &rule);
    file.write(&output)?;
    if !common.quiet {
        print(&summary::summary(&file, &labels));
        complain(&format!("wrote {}", output.display()));
    }
    Ok(())
}

fn rule(command: &LabelCommand) -> anyhow::Result<Rule> {
    let Some(path) = &command.rule else {
        return Ok(Rule::standard().clone());
    };
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("--rule: cannot read {}", path.display()))?;
    Rule::parse(&text).with_context(|| path.display().to_string())
}

/// Writes human labels into the rows.
fn honour(file: &mut GraspFile, given: &[table::Given], path: &Path) -> anyhow::Result<()> {
    let rows: BTreeMap<u64, usize> = (file.grasps.iter().enumerate())
        .map(|(row, grasp)| (grasp.id, row))
        .collect();
    for label in given {
        let row = *rows.get(&label.id).with_context(|| {
            format!(
                "{}, line {}: there is no grasp with id {}",
                path.display(),
                label.line,
                label.id
            )
        })?;
        file.grasps[row].label = Some(label.label.to_owned());
    }
    Ok(())
}

fn explanations(file: &GraspFile, labels: &BTreeMap<u64, Label>, rule: &Rule) -> String {
    let mut text = String::new();
    for grasp in &file.grasps {
        let Some(label) = labels.get(&grasp.id) else {
            continue;
        };
        let _ = writeln!(
            text,
            "grasp {}: {} on {}",
            grasp.id, grasp.hand, grasp.object
        );
        if let Some(human) = grasp.label.as_deref().filter(|human| !human.is_empty()) {
            let _ = writeln!(text, "human            {human}");
        }
        text += &explain(label, rule);
        text.push('\n');
    }
    text
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().map(PathBuf::from).unwrap_or_default();
    name.display().to_string()
}
