//! `landscape label`: labels the grasps of a file with grasp types.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use clap::Args;
use serde_json::{Value, json};

use super::args::{Common, HandAndObject};
use super::input;
use super::output::check_file;
use super::run::Watch;
use crate::cli::printing::{complain, print, print_json, tell_written};
use crate::evaluation::taxonomy::{
    By, Category, Certainty, Judged, Label, Rule, Taught, Verdict, explain,
};
use crate::store::{GraspFile, GraspRow, content_hash, write_atomic};
use crate::study::{
    HumanLabel, examples, given_labels, human_label, label_all, name_of, record_labels, tally,
};

/// Label grasps.
#[derive(Debug, Args)]
pub(super) struct LabelCommand {
    /// The grasps; several files with `--learn` only.
    #[arg(value_name = "FILE", required = true)]
    grasps: Vec<PathBuf>,
    /// Teach a labeller by the grasps that a person labelled, and write it in place of grasps.
    #[arg(long, conflicts_with_all = ["explain", "by"])]
    learn: bool,
    /// A labeller that `--learn` wrote, which names the grasps in place of the rule.
    #[arg(long, value_name = "FILE")]
    by: Option<PathBuf>,
    /// Show the reasons for and against the label of the grasp with this id, and write nothing; may be given several times.
    #[arg(long, value_name = "ID", conflicts_with = "output")]
    explain: Vec<u64>,
    /// Labels given by a human (CSV with the columns id and label), which override the rule.
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// Your own rule, in the form of data/taxonomy/rule.toml, instead of the built-in one.
    #[arg(long, value_name = "FILE")]
    rule: Option<PathBuf>,
    /// The file to write; by default the name of the file with the ending `.labelled.parquet`, or `.labeller` with `--learn`.
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
  landscape label --learn a.parquet b.parquet -o my.labeller     learn from the labels that people gave in these files
  landscape label --learn grasps.parquet --from labels.csv       learn from labels.csv of the page
  landscape label grasps.parquet --by my.labeller          name grasps as these people would

The types are the 33 of the GRASP taxonomy (Feix et al. 2016). The rule uses all parts of the hand within 5 mm of the
object, the pose of the fingers, and the form of the part that is held. It decides in the order of the taxonomy: which
parts press against each other, which digits take part, then the type. If types are close, the label is their cell in the
table of the taxonomy (category/opposition/virtual finger 2/thumb); if cells are close, it is the category. If contact
contradicts every type, it is `unlisted`. If the hand does not have the thumb and the fingers of a human hand, it is
`not_applicable`.

Adds the columns label (yours), label_auto, label_score, label_best, label_category and label_source. The rule chooses the
category first: label_best has types of this category only, and label_category is there for unlisted grasps, too. labels.csv
has the columns id and label: a name or number of a type, or `unlisted`. An empty label takes that of the file away.

Words say how far an answer can be trusted, measured on grasps that people posed and named: of answers that are `likely` at
least two thirds are right, of `open` ones at least a third, of `a guess` fewer.

`--learn` prints how often the labeller, the rule and the commonest answer are right about objects that were left out. It
needs thirty labels; a hundred of ten objects teach much more. A grasp that is unlike all that the labeller has seen is named
by the rule.";

pub(super) fn run(command: &LabelCommand, common: &Common) -> anyhow::Result<()> {
    if command.learn {
        return learn(command, common);
    }
    let [grasps] = &command.grasps[..] else {
        bail!("several files of grasps: label one at a time, or teach a labeller with `--learn`");
    };
    let output = output_of(command, "labelled.parquet");
    check_outputs(command, &output, common)?;
    let mut file = read(command, grasps, common)?;
    if let Some(path) = &command.from {
        honour(std::slice::from_mut(&mut file), path)?;
    }
    let inputs = common.provenance.sources()?;
    let rule = with_labeller(rule(command)?, command.by.as_deref())?;
    input::all_known("--explain", &command.explain, &file, grasps)?;

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

fn output_of(command: &LabelCommand, ending: &str) -> PathBuf {
    let given = command.output.clone();
    given.unwrap_or_else(|| command.grasps[0].with_extension(ending))
}

/// The grasps of a file.
fn read(command: &LabelCommand, grasps: &Path, common: &Common) -> anyhow::Result<GraspFile> {
    let of = [&command.of.hand, &command.of.object].map(Option::as_deref);
    let (file, mut warnings) = input::read(grasps, of[0], of[1])?;
    // Labelling needs no energy.
    warnings.retain(|warning| !warning.starts_with("the energy of the grasps is not recorded"));
    if !common.quiet {
        input::warn(&warnings);
    }
    Ok(file)
}

/// Teaches a labeller.
fn learn(command: &LabelCommand, common: &Common) -> anyhow::Result<()> {
    let output = output_of(command, "labeller");
    check_outputs(command, &output, common)?;
    let rule = rule(command)?;
    let mut files = Vec::new();
    for path in &command.grasps {
        files.push(read(command, path, common)?);
    }
    if let Some(path) = &command.from {
        honour(&mut files, path)?;
    }
    let (mut all, mut taught_with) = (Vec::new(), Vec::new());
    for (path, file) in command.grasps.iter().zip(&files) {
        let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
        let source = (&*name_of(path), &*content_hash(&[&bytes]));
        let (own, with) = Watch::over(common.quiet, |run| examples(file, &rule, source, run))?;
        all.extend(own);
        taught_with.push(with);
    }
    let taught = Taught::of(&all, taught_with, &rule.version)?;
    write_atomic(&output, taught.text().as_bytes())
        .with_context(|| format!("cannot write {}", output.display()))?;
    let better = |judged: &&Judged| judged.gain_interval_share[0] > 0.0;
    let no_better: Vec<&str> = (taught.judged.iter())
        .filter(|judged| !better(judged))
        .map(|judged| judged.name.as_str())
        .collect();
    let report = json!({
        "labels": taught.labels,
        "tested_on_left_out": taught.tested_on_left_out,
        "judged": taught.judged,
        "certainties": taught.certainties,
        "wrote": [output],
    });
    tell_written(common, &report, &output.display().to_string())?;
    if !common.quiet && !no_better.is_empty() {
        complain(&format!(
            "warning: it is not shown that the labeller names the {} better than the rule does",
            no_better.join(" or the ")
        ));
    }
    Ok(())
}

/// The rule with the labeller of a file.
pub(super) fn with_labeller(rule: Rule, by: Option<&Path>) -> anyhow::Result<Rule> {
    let Some(path) = by else {
        return Ok(rule);
    };
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("--by: cannot read {}", path.display()))?;
    let taught = Taught::parse(&text).with_context(|| path.display().to_string())?;
    ensure!(
        taught.rule == rule.version,
        "{}: this labeller was taught beside another version of the rule ({}, now {}); teach it again: `landscape label --learn`",
        path.display(),
        taught.rule,
        rule.version
    );
    Ok(rule.with(taught))
}

fn check_outputs(command: &LabelCommand, output: &Path, common: &Common) -> anyhow::Result<()> {
    if command.explain.is_empty() {
        let mut inputs: Vec<&Path> = command.grasps.iter().map(PathBuf::as_path).collect();
        let others = [&command.from, &command.rule, &command.by];
        inputs.extend(others.into_iter().filter_map(Option::as_deref));
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

/// Writes the human labels of a table into the rows of files, and takes away those that it has empty. An id must be that of
/// one grasp.
fn honour(files: &mut [GraspFile], path: &Path) -> anyhow::Result<()> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("--from: cannot read {}", path.display()))?;
    let given = given_labels(&text).with_context(|| path.display().to_string())?;
    let mut rows: BTreeMap<u64, Vec<&mut GraspRow>> = BTreeMap::new();
    for grasp in files.iter_mut().flat_map(|file| &mut file.grasps) {
        rows.entry(grasp.id).or_default().push(grasp);
    }
    for label in given {
        let place = format!("{}, line {}", path.display(), label.line);
        match rows.get_mut(&label.id).map(Vec::as_mut_slice) {
            Some([grasp]) => grasp.label = label.label.map(str::to_owned),
            Some(_) => bail!(
                "{place}: several grasps have the id {}; label each file by itself: `landscape label FILE --from`",
                label.id
            ),
            None => bail!("{place}: no grasp has the id {}", label.id),
        }
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
            "label": label.text(),
            "best": label.best_text(),
            "certainty": certainty(label),
            "explanation": explain(label, rule),
        }))
    };
    file.grasps.iter().filter_map(told).collect()
}

/// How far category, cell and type can be trusted; null where there is none.
fn certainty(label: &Label) -> Value {
    if label.best.is_empty() {
        return Value::Null;
    }
    let [category, cell, kind] = label.certainty.map(Certainty::name);
    json!({ "category": category, "cell": cell, "type": kind })
}

/// The report.
fn value(file: &GraspFile, labels: &BTreeMap<u64, Label>, output: &Path) -> Value {
    let verdicts = labels.values().map(|label| match label.verdict {
        Verdict::Listed(_) => "one_type",
        Verdict::Ambiguous(_) => "one_cell",
        Verdict::Broad(_) => "one_category",
        Verdict::Unlisted => "unlisted",
        Verdict::NotApplicable(_) => "not_applicable",
    });
    let kinds = [
        "one_type",
        "one_cell",
        "one_category",
        "unlisted",
        "not_applicable",
    ];
    let mut counted: BTreeMap<String, usize> = kinds.map(|kind| (kind.to_owned(), 0)).into();
    counted.extend(tally(verdicts));
    let why = labels.values().filter_map(|label| match label.verdict {
        Verdict::NotApplicable(why) => Some(why.words()),
        _ => None,
    });
    let why: Vec<String> = why.collect();
    let left = labels
        .values()
        .filter(|label| matches!(label.by, By::Instead(_)))
        .count();
    let categories = labels.values().filter_map(Label::listed_category);
    let grasps: Vec<Value> = (file.grasps.iter())
        .filter_map(|grasp| {
            let label = labels.get(&grasp.id)?;
            Some(json!({
                "id": grasp.id,
                "human": grasp.label,
                "agrees": agrees(grasp, label),
                "label": label.text(),
                "best": label.best_text(),
                "certainty": certainty(label),
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
        "left_to_the_rule": (left > 0).then_some(left),
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
