//! Summary of the labels of a file.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::evaluation::taxonomy::{Inapplicable, Label, Taxonomy, Verdict};
use crate::store::{GraspFile, GraspRow};
use crate::study::{HumanLabel, human_label, tally};

/// Number of disagreements that are listed individually.
const LISTED: usize = 20;

/// Counts of types, cells and categories, and disagreements between human and rule.
pub(super) fn summary(file: &GraspFile, labels: &BTreeMap<u64, Label>) -> String {
    let feix = Taxonomy::feix();
    let total = labels.len();
    let mut text = format!("{total} grasps\n");
    let count = |test: &dyn Fn(&Verdict) -> bool| {
        labels.values().filter(|label| test(&label.verdict)).count()
    };
    let line = |text: &mut String, name: &str, count: usize| {
        let share = 100.0 * count as f64 / total.max(1) as f64;
        let _ = writeln!(text, "  {name:<34} {count:>6}  {share:>5.1} %");
    };
    text += "by the rule\n";
    line(
        &mut text,
        "of one type",
        count(&|v| matches!(v, Verdict::Listed(_))),
    );
    line(
        &mut text,
        "ambiguous: known by cell only",
        count(&|v| matches!(v, Verdict::Ambiguous(_))),
    );
    line(&mut text, "unlisted", count(&|v| *v == Verdict::Unlisted));
    line(
        &mut text,
        "not applicable",
        count(&|v| matches!(v, Verdict::NotApplicable(_))),
    );
    for why in [Inapplicable::Hand, Inapplicable::Touch] {
        let of_this = count(&|v| *v == Verdict::NotApplicable(why));
        if of_this > 0 {
            let _ = writeln!(text, "    {of_this}: {}", why.words());
        }
    }
    text += "categories (of types and cells)\n";
    let categories = labels.values().filter_map(Label::listed_category);
    for (category, count) in tally(categories.map(crate::evaluation::taxonomy::Category::name)) {
        line(&mut text, &category, count);
    }
    text += "cells (category/opposition/virtual finger 2/thumb)\n";
    for cell in feix.cells() {
        let of_cell = count(&|verdict| match verdict {
            Verdict::Listed(number) | Verdict::Ambiguous(number) => feix
                .numbered(*number)
                .is_some_and(|entry| entry.cell == cell),
            _ => false,
        });
        if of_cell > 0 {
            line(&mut text, cell, of_cell);
        }
    }
    text += "types\n";
    for entry in &feix.types {
        let of_type = count(&|verdict| *verdict == Verdict::Listed(entry.number));
        if of_type > 0 {
            line(
                &mut text,
                &format!("{:>2} {}", entry.number, entry.name),
                of_type,
            );
        }
    }
    text += &humans(file, labels);
    text
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
