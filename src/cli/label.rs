//! `landscape label`: labels the grasps of a file with grasp types.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use serde_json::{Map, Value, json};

use super::args::{Common, HandAndObject};
use super::input;
use super::output::check_file;
use super::run::Watch;
use crate::cli::printing::{complain, print, print_json};
use crate::evaluation::taxonomy::{Category, Label, Rule, Taxonomy, Verdict, explain};
use crate::printable::counted;
use crate::store::{GraspFile, GraspRow};
use crate::study::{HumanLabel, Run, given_labels, human_label, label_all, record_labels, tally};

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
    let watch = Watch::new(common.quiet);
    let run = Run {
        observer: &|news| watch.see(news),
        ..Run::default()
    };
    let labels = label_all(&file, &rule, wanted, &run)?;
    watch.clear();

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
    if common.json {
        print_json(&value(&file, &labels, &output))?;
    }
    if !common.quiet {
        print(&summary(&file, &labels));
        complain(&format!("wrote {}", output.display()));
    }
    Ok(())
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

/// The JSON document.
fn value(file: &GraspFile, labels: &BTreeMap<u64, Label>, output: &Path) -> Value {
    let counted = Counted(labels);
    let labelled: Map<String, Value> = tally(labels.values().map(Label::text))
        .into_iter()
        .map(|(label, count)| (label, count.into()))
        .collect();
    let grasps: Vec<Value> = (file.grasps.iter())
        .filter_map(|grasp| {
            let label = labels.get(&grasp.id)?;
            Some(json!({
                "id": grasp.id,
                "human": grasp.label,
                "rule": label.text(),
                "best": label.best_text(),
            }))
        })
        .collect();
    json!({
        "verdicts": {
            "one_type": counted.count(|verdict| matches!(verdict, Verdict::Listed(_))),
            "cell": counted.count(|verdict| matches!(verdict, Verdict::Ambiguous(_))),
            "category": counted.count(|verdict| matches!(verdict, Verdict::Broad(_))),
            "unlisted": counted.count(|verdict| *verdict == Verdict::Unlisted),
            "not_applicable": counted.count(|verdict| matches!(verdict, Verdict::NotApplicable(_))),
        },
        "labels": labelled,
        "grasps": grasps,
        "wrote": [output],
    })
}

/// Number of disagreements that are listed individually.
const LISTED: usize = 20;

/// Counts of types, cells and categories, and disagreements between human and rule.
fn summary(file: &GraspFile, labels: &BTreeMap<u64, Label>) -> String {
    let counts = Counted(labels);
    let parts = [
        ("by the rule", counts.verdicts()),
        (
            "categories (of types, cells and categories)",
            counts.categories(),
        ),
        (
            "cells (category/opposition/virtual finger 2/thumb)",
            counts.cells(),
        ),
        ("types", counts.types()),
    ];
    let mut text = counted(labels.len(), "grasp") + "\n";
    for (title, lines) in parts.iter().filter(|(_, lines)| !lines.is_empty()) {
        let _ = write!(text, "{title}\n{lines}");
    }
    text + &humans(file, labels)
}

/// Labels, to be counted.
struct Counted<'a>(&'a BTreeMap<u64, Label>);

impl Counted<'_> {
    fn count(&self, test: impl Fn(&Verdict) -> bool) -> usize {
        let labels = self.0.values();
        labels.filter(|label| test(&label.verdict)).count()
    }

    /// A line with a count and its share of all labels.
    fn line(&self, name: &str, count: usize) -> String {
        let share = 100.0 * count as f64 / self.0.len().max(1) as f64;
        format!("  {name:<34} {count:>6}  {share:>5.1} %\n")
    }

    fn verdicts(&self) -> String {
        let listed = self.count(|verdict| matches!(verdict, Verdict::Listed(_)));
        let ambiguous = self.count(|verdict| matches!(verdict, Verdict::Ambiguous(_)));
        let broad = self.count(|verdict| matches!(verdict, Verdict::Broad(_)));
        let unlisted = self.count(|verdict| *verdict == Verdict::Unlisted);
        let inapplicable = self.count(|verdict| matches!(verdict, Verdict::NotApplicable(_)));
        let mut text = [
            self.line("of one type", listed),
            self.line("known by cell only", ambiguous),
            self.line("known by category only", broad),
            self.line("unlisted", unlisted),
            self.line("not applicable", inapplicable),
        ]
        .concat();
        let reasons = self.0.values().filter_map(|label| match label.verdict {
            Verdict::NotApplicable(why) => Some(why.words()),
            _ => None,
        });
        let reasons: Vec<String> = reasons.collect();
        for (why, count) in tally(reasons.iter().map(String::as_str)) {
            let _ = writeln!(text, "    {count}: {why}");
        }
        text
    }

    fn categories(&self) -> String {
        let categories = self.0.values().filter_map(Label::listed_category);
        tally(categories.map(Category::name))
            .iter()
            .map(|(category, count)| self.line(category, *count))
            .collect()
    }

    fn cells(&self) -> String {
        let feix = Taxonomy::feix();
        let is_of = |verdict: &Verdict, cell: &str| match verdict {
            Verdict::Listed(number) | Verdict::Ambiguous(number) => feix
                .numbered(*number)
                .is_some_and(|entry| entry.cell == cell),
            Verdict::Broad(_) | Verdict::Unlisted | Verdict::NotApplicable(_) => false,
        };
        let cells = feix.cells().into_iter();
        let counts = cells.map(|cell| (cell, self.count(|verdict| is_of(verdict, cell))));
        counts
            .filter(|(_, count)| *count > 0)
            .map(|(cell, count)| self.line(cell, count))
            .collect()
    }

    fn types(&self) -> String {
        let types = Taxonomy::feix().types.iter();
        let counts = types.map(|entry| {
            let name = format!("{:>2} {}", entry.number, entry.name);
            let of_type = |verdict: &Verdict| *verdict == Verdict::Listed(entry.number);
            (name, self.count(of_type))
        });
        counts
            .filter(|(_, count)| *count > 0)
            .map(|(name, count)| self.line(&name, count))
            .collect()
    }
}

/// Human labels, and disagreements with the rule.
fn humans(file: &GraspFile, labels: &BTreeMap<u64, Label>) -> String {
    let human = |grasp: &GraspRow| {
        let told = grasp.label.clone().filter(|label| !label.is_empty())?;
        let label = labels.get(&grasp.id)?;
        let agrees = match human_label(&told) {
            Some(HumanLabel::Type(entry)) => match label.verdict {
                Verdict::Listed(number) => number == entry.number,
                Verdict::Ambiguous(_) => label.text() == entry.cell,
                Verdict::Broad(_) => label.text() == entry.category.name(),
                Verdict::Unlisted | Verdict::NotApplicable(_) => false,
            },
            Some(HumanLabel::Unlisted) => label.verdict == Verdict::Unlisted,
            None => false,
        };
        Some((grasp.id, told, label, agrees))
    };
    let told: Vec<_> = file.grasps.iter().filter_map(human).collect();
    if told.is_empty() {
        return String::new();
    }
    let disagree: Vec<_> = told.iter().filter(|(.., agrees)| !agrees).collect();
    let mut text = format!(
        "labelled by a human: {}, with which the rule agrees in {}\n",
        told.len(),
        told.len() - disagree.len()
    );
    for (id, told, label, _) in disagree.iter().take(LISTED) {
        let _ = writeln!(
            text,
            "  grasp {id}: human {told}; rule {} ({})",
            label.text(),
            label.best_text()
        );
    }
    if disagree.len() > LISTED {
        let _ = writeln!(text, "  … and {} more", disagree.len() - LISTED);
    }
    text
}
