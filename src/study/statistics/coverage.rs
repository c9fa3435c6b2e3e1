//! Compares the grasp types and taxonomy cells of two landscapes.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::{Value, json};

use super::basins::{Basins, NamedLandscape};
use crate::evaluation::taxonomy::Taxonomy;
use crate::study::error::StudyError;

/// Comparison of the grasp types of two landscapes.
#[derive(Debug, Clone)]
pub struct TypeComparison {
    /// Text in Markdown.
    pub text: String,
    /// Data in JSON.
    pub value: Value,
}

/// Numbers of minima and grasps of each type, in taxonomy order, followed by cells without type and by unlisted ones.
pub(super) fn types(basins: &Basins) -> Vec<(String, [u64; 2])> {
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

/// Compares the types and cells of two landscapes.
///
/// # Errors
/// If a landscape has no group barrier and `group_barrier` is `None`.
pub fn compare_types(
    one: &NamedLandscape<'_>,
    other: &NamedLandscape<'_>,
    group_barrier: Option<f64>,
) -> Result<TypeComparison, StudyError> {
    let [one, other] = [one, other].map(|side| Basins::of(side, group_barrier));
    let (one, other) = (&one?, &other?);
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
    Ok(TypeComparison { text, value })
}
