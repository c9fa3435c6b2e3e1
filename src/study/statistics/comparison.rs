//! Comparison of a landscape with the taxonomy: its types, and the statistics of heights against labels.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::{Value, json};

use super::StatisticsSettings;
use super::basins::{Basins, NamedLandscape};
use super::coverage::types;
use super::table::{Table, table};
use crate::evaluation::taxonomy::{Category, Rule};
use crate::figure::MAKER;
use crate::figure::chart::Chart;
use crate::study::error::StudyError;
use crate::study::markdown;

/// Comparison of a landscape of grasps with the taxonomy.
#[derive(Debug)]
pub struct TaxonomyComparison<'a> {
    /// The minima with their labels, and the heights and distances between them.
    pub basins: Basins,
    table: Table,
    settings: &'a StatisticsSettings,
    rule: &'a Rule,
    seed: u64,
}

/// Tests by permutation whether heights between the minima of a landscape correlate with their categories and types.
/// `family_barrier` replaces the landscape's own family barrier; `seed` is for permutations and resamplings.
///
/// # Errors
/// If the landscape has no family barrier.
pub fn compare_with_taxonomy<'a>(
    landscape: &NamedLandscape<'a>,
    settings: &'a StatisticsSettings,
    family_barrier: Option<f64>,
    seed: u64,
) -> Result<TaxonomyComparison<'a>, StudyError> {
    let basins = Basins::of(landscape, family_barrier)?;
    Ok(TaxonomyComparison {
        table: table(&basins, settings, seed),
        basins,
        settings,
        rule: landscape.rule,
        seed,
    })
}

impl TaxonomyComparison<'_> {
    /// Labels and statistics as Markdown.
    ///
    /// Where no minimum has a label, it is one sentence.
    pub fn markdown(&self) -> String {
        if let Some(why) = self.without_labels() {
            return format!("# {} beside the taxonomy\n\n{why}\n", self.basins.name);
        }
        format!(
            "{}\n## Statistics\n\nA case is a minimum; p by permutation of labels among minima.\n\n{}",
            self.types(),
            self.statistics()
        )
    }

    /// Why no minimum has a label, as a sentence: the rule does not apply to the hand, and the file names none either.
    pub fn without_labels(&self) -> Option<String> {
        let basins = &self.basins;
        let why = basins
            .inapplicable
            .filter(|_| basins.labelled_in_file == 0)?;
        Some(format!(
            "Grasp types cannot be compared, because {}.",
            why.words()
        ))
    }

    /// Title, labels and types as Markdown.
    pub fn types(&self) -> String {
        let basins = &self.basins;
        let mut text = format!("# {} beside the taxonomy\n\n", basins.name);
        let minima = basins.minima.len();
        let category = |category: Category| {
            let count = basins
                .minima
                .iter()
                .filter(|basin| basin.category == Some(category as usize))
                .count();
            format!("{count} {}", category.name())
        };
        let unnamed = basins
            .minima
            .iter()
            .filter(|basin| basin.category.is_none())
            .count();
        let categories = [Category::Power, Category::Intermediate, Category::Precision]
            .map(category)
            .join(", ");
        let _ = writeln!(
            text,
            "- {minima} minima: {categories}, {unnamed} without a category\n\
             - labels: {} from the file, the others by rule {} on the minimum itself",
            basins.labelled_in_file, self.rule.version,
        );
        let apart = basins.saddles.unknown();
        if apart > 0 {
            let _ = writeln!(
                text,
                "- {apart} of {} pairs are joined by no path: their heights count as 1.1 times the largest",
                basins.saddles.values().len(),
            );
        }
        if let Some(why) = basins.inapplicable {
            let _ = writeln!(
                text,
                "- {}; only labels from the file are compared",
                why.words()
            );
        }
        text.push_str("\n## Types\n\n");
        let row = |(name, [own, grasps]): (String, [u64; 2])| {
            vec![name, own.to_string(), grasps.to_string()]
        };
        text + &markdown::table(
            &["type", "minima", "grasps"],
            types(basins).into_iter().map(row),
        )
    }

    /// The table of the statistics as Markdown, followed by those that the data do not suffice for.
    pub fn statistics(&self) -> String {
        let mut without: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        let mut rows = Vec::new();
        for row in &self.table.rows {
            let Some(value) = row.statistic.filter(|_| row.missing.is_none()) else {
                let why = row.missing.as_deref().unwrap_or("there are too few minima");
                without.entry(why).or_default().push(&row.name);
                continue;
            };
            let interval = row
                .interval
                .map(|[low, high]| format!("{low:.3} to {high:.3}"));
            rows.push(vec![
                row.name.clone(),
                row.about.to_owned(),
                format!("{value:.3}"),
                row.chance
                    .map_or_else(String::new, |chance| format!("{chance:.3}")),
                interval.unwrap_or_default(),
                row.p.map_or_else(String::new, |p| format!("{p:.4}")),
            ]);
        }
        let mut text = String::new();
        if !rows.is_empty() {
            text = markdown::table(&["statistic", "of", "value", "chance", "95 %", "p"], rows);
        }
        for (why, names) in without {
            let gap = if text.is_empty() { "" } else { "\n" };
            let _ = writeln!(
                text,
                "{gap}Not measured: {why}. This concerns {}.",
                names.join(", ")
            );
        }
        text
    }

    /// The whole comparison as JSON.
    pub fn to_json(&self) -> Value {
        json!({
            "made_by": MAKER,
            "landscape": self.basins.name,
            "rule": self.rule.version,
            "settings": self.settings,
            "seed": self.seed,
            "family_barrier": self.basins.family_barrier,
            "families": self.basins.families,
            "statistics": self.table.rows,
            "cuts": self.table.cuts,
        })
    }

    /// Chart of the agreement of cuts of the tree with the categories.
    pub fn chart(&self) -> Chart {
        self.table.chart()
    }
}
