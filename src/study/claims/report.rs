//! Text of `landscape compare`.

use std::fmt::Write;

use super::Finding;
use crate::evaluation::taxonomy::{Category, Inapplicable, Rule};
use crate::study::statistics::{Basins, Table, types};

pub(super) fn markdown(
    basins: &Basins,
    table: &Table,
    findings: &[Finding],
    rule: &Rule,
) -> String {
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
         - labels: {} from the file, the others by rule {} on the minimum itself\n\
         - {} of {} pairs are joined by no path: their heights count as 1.1 times the largest",
        basins.labelled_in_file,
        rule.version,
        basins.saddles.unknown(),
        basins.saddles.values().len(),
    );
    if !basins.applicable {
        let why = Inapplicable::Hand.words();
        let _ = writeln!(text, "- {why}; nothing below is about grasp types");
    }
    text.push_str("\n## Types\n\n| type | minima | grasps |\n|---|---|---|\n");
    for (name, [own, grasps]) in types(basins) {
        let _ = writeln!(text, "| {name} | {own} | {grasps} |");
    }
    text.push_str("\n## Hypotheses\n\n| | claim | verdict | p | p (Holm) | measured |\n|---|---|---|---|---|---|\n");
    let number = |p: Option<f64>| p.map_or(String::new(), |p| format!("{p:.4}"));
    for finding in findings {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} |",
            finding.id,
            finding.claim,
            finding.verdict.words(),
            number(finding.p),
            number(finding.p_holm),
            finding.measured
        );
    }
    text.push_str(
        "\nThresholds stand in data/taxonomy/hypotheses.toml and were fixed before the first run. A case is a minimum; p by \
         permutation of labels among minima.\n\n## Statistics\n\n| statistic | of | value | chance | 95 % | p |\n|---|---|---|---|---|---|\n",
    );
    for row in &table.rows {
        let value = match (&row.missing, row.statistic) {
            (Some(missing), _) => format!("insufficient data: {missing}"),
            (None, Some(value)) => format!("{value:.3}"),
            (None, None) => "insufficient data".to_owned(),
        };
        let chance = row
            .chance
            .map_or(String::new(), |chance| format!("{chance:.3}"));
        let interval = row.interval.map_or(String::new(), |[low, high]| {
            format!("{low:.3} to {high:.3}")
        });
        let _ = writeln!(
            text,
            "| {} | {} | {value} | {chance} | {interval} | {} |",
            row.name,
            row.about,
            number(row.p)
        );
    }
    text
}
