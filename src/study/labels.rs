//! The grasp types of the grasps of a file.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde_json::json;

use super::Run;
use crate::evaluation::taxonomy::{
    By, Category, GraspType, Label, Labeller, Rule, Taxonomy, UNLISTED, UNLISTED_CLASS,
};
use crate::store::{GraspFile, GraspRow, RebuildError, content_hash};
use crate::topography::Phase;

/// Labels the grasps of a file that `wanted` chooses; returns the labels by id.
///
/// # Errors
/// If a hand or an object cannot be built.
pub fn label_all(
    file: &GraspFile,
    rule: &Rule,
    wanted: impl Fn(&GraspRow) -> bool,
    run: &Run<'_>,
) -> Result<BTreeMap<u64, Label>, RebuildError> {
    let count = file.grasps.iter().filter(|row| wanted(row)).count();
    let tally = run.tally(Phase::Label, count);
    let mut labels = BTreeMap::new();
    for population in file.landscapes() {
        let (hand, object) = (population.hand()?, population.object()?);
        let labeller = Labeller::new(&hand, &object, rule);
        let rows = population.grasps.iter().filter(|row| wanted(row));
        let label = |row: &&&GraspRow| {
            let label = labeller.label(&row.grasp.pose);
            tally.tick();
            (row.id, label)
        };
        let rows: Vec<_> = rows.collect();
        labels.extend(rows.par_iter().map(label).collect::<Vec<_>>());
    }
    Ok(labels)
}

/// Writes labels into the rows of a file, and the rule and the labeller into its metadata. The word of a human stays, and decides the category.
pub fn record_labels(file: &mut GraspFile, labels: &BTreeMap<u64, Label>, rule: &Rule) {
    for row in &mut file.grasps {
        if let Some(label) = labels.get(&row.id) {
            record(row, label);
        }
    }
    let labeller = rule.taught.as_ref().map(|taught| {
        json!({ "content_hash": content_hash(&[taught.text().as_bytes()]), "labels": taught.count() })
    });
    file.metadata.labels = json!({
        "labeller": labeller,
        "rule": rule.version,
        "unlisted_below": rule.unlisted_below,
        "type_share": rule.type_share,
        "cell_share": rule.cell_share,
        "program_version": env!("CARGO_PKG_VERSION"),
    });
}

fn record(row: &mut GraspRow, label: &Label) {
    row.label_auto = Some(label.text().to_owned());
    row.label_score = label.best.first().map(|best| best.score);
    row.label_best = (!label.best.is_empty()).then(|| label.best_text());
    let human = row.label.as_deref().filter(|text| !text.is_empty());
    let (source, category) = match human {
        Some(text) => ("human", human_label(text).and_then(HumanLabel::category)),
        // An unlisted grasp has a most probable category, too.
        None if matches!(label.by, By::Taught(_)) => ("labeller", label.category),
        None => ("rule", label.category),
    };
    row.label_source = Some(source.to_owned());
    row.label_category = category.map(|category| category.name().to_owned());
}

/// What a human may say of a grasp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HumanLabel {
    /// It is of this type.
    Type(&'static GraspType),
    /// It is of no type.
    Unlisted,
}

/// What a human says by the name, alias or number of a type, or by `unlisted`; `None` where the text is neither.
pub fn human_label(text: &str) -> Option<HumanLabel> {
    if text.trim().eq_ignore_ascii_case(UNLISTED) {
        return Some(HumanLabel::Unlisted);
    }
    Taxonomy::feix().named(text).map(HumanLabel::Type)
}

impl HumanLabel {
    /// The label as files have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Type(entry) => &entry.name,
            Self::Unlisted => UNLISTED,
        }
    }

    /// The class as which a labeller learns it.
    pub(super) fn class(self) -> usize {
        match self {
            Self::Type(entry) => usize::from(entry.number) - 1,
            Self::Unlisted => UNLISTED_CLASS,
        }
    }

    fn category(self) -> Option<Category> {
        match self {
            Self::Type(entry) => Some(entry.category),
            Self::Unlisted => None,
        }
    }
}
