//! What `landscape compare` says.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::{Value, json};

use super::basins::Basins;
use super::hypotheses::Finding;
use super::statistics::Table;
use crate::evaluation::taxonomy::{Category, Inapplicable, Rule, Taxonomy};
use crate::figure::chart::{Axis, Chart, Corner, Panel, Series};
use crate::figure::theme;

/// Labels, statistics and hypotheses as Markdown.
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

/// Minima and grasps of each type, in the order of the taxonomy; then those that have only a cell, and those of none.
fn types(basins: &Basins) -> Vec<(String, [u64; 2])> {
    let mut counts: BTreeMap<(u8, String), [u64; 2]> = BTreeMap::new();
    for basin in &basins.minima {
        let named = basin
            .grasp_type
            .and_then(|number| Taxonomy::feix().numbered(number));
        let key = match (named, &basin.cell) {
            (Some(entry), _) => (entry.number, entry.name.clone()),
            (None, Some(cell)) => (100, cell.clone()),
            (None, None) => (101, "none".to_owned()),
        };
        let own = counts.entry(key).or_default();
        own[0] += 1;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count"
        )]
        let grasps = basin.grasps as u64;
        own[1] += grasps;
    }
    counts
        .into_iter()
        .map(|((_, name), counts)| (name, counts))
        .collect()
}

/// Which types and cells each of two landscapes holds.
pub(super) fn coverage(one: &Basins, other: &Basins) -> (String, Value) {
    let sides = [one, other].map(|side| {
        types(side)
            .into_iter()
            .collect::<BTreeMap<String, [u64; 2]>>()
    });
    let taxonomy = Taxonomy::feix();
    let cells = [one, other].map(|side| {
        let mut cells: Vec<&str> = side
            .minima
            .iter()
            .filter_map(|basin| basin.cell.as_deref())
            .collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    });
    let listed = |side: &BTreeMap<String, [u64; 2]>| {
        taxonomy
            .types
            .iter()
            .filter(|entry| side.contains_key(&entry.name))
            .count()
    };
    let mut text = format!("# {} and {}\n\n", one.name, other.name);
    let all = taxonomy.cells().len();
    for (side, (types, cells)) in [one, other].iter().zip(sides.iter().zip(&cells)) {
        let _ = writeln!(
            text,
            "- {}: {} of 33 types, {} of {all} cells, {} minima in {} groups (relative barrier up to {:.3})",
            side.name,
            listed(types),
            cells.len(),
            side.minima.len(),
            side.groups,
            side.group_barrier
        );
    }
    let barriers = [one, other].map(|side| side.group_barrier);
    if barriers[0].to_bits() != barriers[1].to_bits() {
        let _ = writeln!(
            text,
            "\nNote: the groups of the two are made at different barriers, so their numbers cannot be compared: give both one \
             with --group-barrier."
        );
    }
    let _ = writeln!(
        text,
        "\n| type | grasps in {} | grasps in {} |\n|---|---|---|",
        one.name, other.name
    );
    let mut rows = Vec::new();
    let named = taxonomy.types.iter().map(|entry| entry.name.as_str());
    let held = |side: &BTreeMap<String, [u64; 2]>, name: &str| {
        side.get(name).map_or(0, |counts| counts[1])
    };
    for name in named.chain(["none"]) {
        let grasps = [held(&sides[0], name), held(&sides[1], name)];
        if grasps != [0, 0] {
            let _ = writeln!(text, "| {name} | {} | {} |", grasps[0], grasps[1]);
            rows.push(json!({ "type": name, "grasps": grasps }));
        }
    }
    let missing: Vec<&str> = (taxonomy.cells().into_iter())
        .filter(|cell| cells.iter().all(|own| !own.contains(cell)))
        .collect();
    let _ = writeln!(text, "\nIn neither: the cells {}.", missing.join(", "));
    let value = json!({
        "landscapes": [one.name, other.name],
        "group_barriers": barriers,
        "groups": [one.groups, other.groups],
        "types": rows,
        "cells": cells,
        "missing_cells": missing,
    });
    (text, value)
}

/// Agreement of cuts of the tree with the categories.
pub(super) fn chart(table: &Table) -> Chart {
    let series = table.cuts.iter().enumerate().map(|(index, (name, curve))| {
        let points = curve
            .iter()
            .map(|(clusters, value)| [*clusters as f64, *value])
            .collect();
        Series::line(points)
            .named(name)
            .coloured(theme::series(index))
    });
    let values = table.cuts.iter().flat_map(|(_, curve)| curve);
    let lowest = values.map(|(_, value)| *value).fold(-0.1, f64::min);
    let panel = Panel {
        legend: Some(Corner::UpperLeft),
        ..Panel::new(
            "",
            Axis::linear("clusters of the tree"),
            // All of it: 0 is chance, 1 is agreement.
            Axis::linear("adjusted agreement (0 chance, 1 full)").with_range(lowest, 1.0),
            series.collect(),
        )
    };
    Chart {
        panel_size: [900, 560],
        ..Chart::new("", vec![panel])
    }
}
