//! `landscape label`: labels the grasps of a file with grasp types.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use serde_json::{Value, json};

use super::args::{Common, HandAndObject};
use super::input;
use super::output::check_file;
use super::run::Watch;
use crate::cli::printing::{print, print_json, tell_written};
use crate::evaluation::taxonomy::{Category, Label, Rule, Verdict, explain};
use crate::store::{GraspFile, GraspRow};
use crate::study::{HumanLabel, given_labels, human_label, label_all, record_labels, tally};

/// Label grasps.
#[derive(Debug, Args)]
pub(super) struct LabelCommand {
    /// The grasps.
    #[arg(value_name = "FILE")]
    grasps: PathBuf,
    /// Show the reasons for and against the label of the grasp with this id, and write nothing; may be given several times.
    #[arg(long, value_name = "ID", conflicts_with = "output")]
    explain: Vec<u64>,
    /// Labels given by a human (CSV with the columns id and label), which override the rule.
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// Your own rule, in the form of data/taxonomy/rule.toml, instead of the built-in one.
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
  landscape label grasps.parquet                           the same with grasp types, in grasps.labelled.parquet
  landscape label grasps.parquet --explain 17              the reasons for the label of grasp 17
  landscape report grasps.parquet --open                   a page for labelling by hand, which saves labels.csv
  landscape label grasps.parquet --from labels.csv         the same with your labels, which override the rule
  landscape label mine.parquet -o mine.parquet --force     replace the file

The types are the 33 of the GRASP taxonomy (Feix et al. 2016). The rule uses all parts of the hand within 5 mm of the
object, the pose of the fingers, and the form of the part that is held. It decides in the order of the taxonomy: which
parts press against each other, which digits take part, then the type. If types are close, the label is their cell in the
table of the taxonomy (category/opposition/virtual finger 2/thumb); if cells are close, it is the category. If contact
contradicts every type, it is `unlisted`. If the hand does not have the thumb and the fingers of a human hand, it is
`not_applicable`.

Adds the columns label (yours), label_auto, label_score, label_best, label_category and label_source. The rule chooses the
category first: label_best has types of this category only, and label_category is there for unlisted grasps, too. labels.csv
has the columns id and label: a name or number of a type, or `unlisted`. An empty label takes that of the file away.";

pub(super) fn run(command: &LabelCommand, common: &Common) -> anyhow::Result<()> {
    let output = command
        .output
        .clone()
        .unwrap_or_else(|| command.grasps.with_extension("labelled.parquet"));
    check_outputs(command, &output, common)?;
    let (mut file, mut warnings) = input::read(
        &command.grasps,
        command.of.hand.as_deref(),
        command.of.object.as_deref(),
    )?;
    let inputs = common.provenance.sources()?;
    // Labelling needs no energy.
    warnings.retain(|warning| !warning.starts_with("the energy of the grasps is not recorded"));
    if !common.quiet {
        input::warn(&warnings);
    }
    let rule = rule(command)?;
    input::all_known("--explain", &command.explain, &file, &command.grasps)?;
    if let Some(path) = &command.from {
        honour(&mut file, path)?;
    }

    let wanted = |row: &GraspRow| command.explain.is_empty() || command.explain.contains(&row.id);
    let labels = Watch::over(common.quiet, |run| label_all(&file, &rule, wanted, run))?;

    if !command.explain.is_empty() {
        if common.json {
            return print_json(&json!({ "grasps": explained(&file, &labels, &rule) }));
        }
        print(&explanations(&file, &labels, &rule));
        return Ok(());
    }
    file.metadata.remade_by(&common.provenance.command, inputs);
    record_labels(&mut file, &labels, &rule);
    file.write(&output)?;
    let report = value(&file, &labels, &output);
    tell_written(common, &report, &output.display().to_string())
}

fn check_outputs(command: &LabelCommand, output: &Path, common: &Common) -> anyhow::Result<()> {
    if command.explain.is_empty() {
        let mut inputs = vec![command.grasps.as_path()];
        inputs.extend(command.from.as_deref());
        inputs.extend(command.rule.as_deref());
        check_file(output, &inputs, common.force)?;
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

/// Writes the human labels of a file into the rows, and takes away those that it has empty.
fn honour(file: &mut GraspFile, path: &Path) -> anyhow::Result<()> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("--from: cannot read {}", path.display()))?;
    let given = given_labels(&text).with_context(|| path.display().to_string())?;
    let rows: BTreeMap<u64, usize> = (file.grasps.iter().enumerate())
        .map(|(row, grasp)| (grasp.id, row))
        .collect();
    for label in given {
        let row = *rows.get(&label.id).with_context(|| {
            format!(
                "{}, line {}: no grasp has the id {}",
                path.display(),
                label.line,
                label.id
            )
        })?;
        file.grasps[row].label = label.label.map(str::to_owned);
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

/// The explanations for the JSON document.
fn explained(file: &GraspFile, labels: &BTreeMap<u64, Label>, rule: &Rule) -> Vec<Value> {
    let told = |grasp: &GraspRow| {
        let label = labels.get(&grasp.id)?;
        Some(json!({
            "id": grasp.id,
            "hand": grasp.hand,
            "object": grasp.object,
            "human": grasp.label,
            "rule": label.text(),
            "best": label.best_text(),
            "explanation": explain(label, rule),
        }))
    };
    file.grasps.iter().filter_map(told).collect()
}

/// The report.
fn value(file: &GraspFile, labels: &BTreeMap<u64, Label>, output: &Path) -> Value {
    let verdicts = labels.values().map(|label| match label.verdict {
        Verdict::Listed(_) => "one_type",
        Verdict::Ambiguous(_) => "cell",
        Verdict::Broad(_) => "category",
        Verdict::Unlisted => "unlisted",
        Verdict::NotApplicable(_) => "not_applicable",
    });
    let kinds = ["one_type", "cell", "category", "unlisted", "not_applicable"];
    let mut counted: BTreeMap<String, usize> = kinds.map(|kind| (kind.to_owned(), 0)).into();
    counted.extend(tally(verdicts));
    let why = labels.values().filter_map(|label| match label.verdict {
        Verdict::NotApplicable(why) => Some(why.words()),
        _ => None,
    });
    let why: Vec<String> = why.collect();
    let categories = labels.values().filter_map(Label::listed_category);
    let grasps: Vec<Value> = (file.grasps.iter())
        .filter_map(|grasp| {
            let label = labels.get(&grasp.id)?;
            Some(json!({
                "id": grasp.id,
                "human": grasp.label,
                "agrees": agrees(grasp, label),
                "rule": label.text(),
                "best": label.best_text(),
            }))
        })
        .collect();
    json!({
        "verdicts": counted,
        "not_applicable_because": BTreeMap::from_iter(tally(why.iter().map(String::as_str))),
        "categories": BTreeMap::from_iter(tally(categories.map(Category::name))),
        "labels": BTreeMap::from_iter(tally(labels.values().map(Label::text))),
        "agreeing": grasps.iter().filter(|grasp| grasp["agrees"] == true).count(),
        "disagreeing": grasps.iter().filter(|grasp| grasp["agrees"] == false).count(),
        "grasps": grasps,
        "wrote": [output],
    })
}

/// Whether the rule agrees with a human; `None` where no human has labelled the grasp.
fn agrees(grasp: &GraspRow, label: &Label) -> Option<bool> {
    let human = grasp.label.as_deref().filter(|label| !label.is_empty())?;
    Some(match human_label(human) {
        Some(HumanLabel::Type(entry)) => match label.verdict {
            Verdict::Listed(number) => number == entry.number,
            Verdict::Ambiguous(_) => label.text() == entry.cell,
            Verdict::Broad(_) => label.text() == entry.category.name(),
            Verdict::Unlisted | Verdict::NotApplicable(_) => false,
        },
        Some(HumanLabel::Unlisted) => label.verdict == Verdict::Unlisted,
        None => false,
    })
}
