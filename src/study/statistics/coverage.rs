//! Compares the grasp types and taxonomy cells of two landscapes.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use serde_json::{Value, json};

use super::basins::{Basins, NamedLandscape};
use crate::evaluation::taxonomy::Taxonomy;
use crate::printable::counted;
use crate::study::FamilyLevel;
use crate::study::error::StudyError;
use crate::study::markdown::table;

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
/// If a landscape has no family barrier and `family_barrier` is `None`.
pub fn compare_types(
    one: &NamedLandscape<'_>,
    other: &NamedLandscape<'_>,
    family_barrier: Option<f64>,
) -> Result<TypeComparison, StudyError> {
    let [one, other] = [one, other].map(|side| Side::of(side, family_barrier));
    let sides = [one?, other?];
    let names = sides.each_ref().map(|side| side.basins.name.as_str());
    let barriers = sides.each_ref().map(|side| side.basins.family_barrier);
    let taxonomy = Taxonomy::feix();
    let types = taxonomy.types.iter().map(|entry| entry.name.as_str());
    let grasps: Vec<(&str, [u64; 2])> = types
        .chain(["none"])
        .map(|name| (name, sides.each_ref().map(|side| side.grasps(name))))
        .filter(|(_, grasps)| *grasps != [0, 0])
        .collect();
    let missing: Vec<&str> = (taxonomy.cells().into_iter())
        .filter(|cell| sides.iter().all(|side| !side.cells.contains(*cell)))
        .collect();

    let mut text = format!("# {} and {}\n\n", names[0], names[1]);
    text += &sides.each_ref().map(Side::line).concat();
    let levels = sides.each_ref().map(|side| side.level);
    let note = FamilyLevel::difference((names[0], &levels[0]), (names[1], &levels[1]));
    if let Some(note) = &note {
        let _ = writeln!(text, "\nNote: {note}.");
    }
    let head = names.map(|name| format!("grasps in {name}"));
    let row = |(name, [one, other]): &(&str, [u64; 2])| {
        vec![(*name).to_owned(), one.to_string(), other.to_string()]
    };
    text.push('\n');
    text += &table(&["type", &head[0], &head[1]], grasps.iter().map(row));
    let _ = writeln!(text, "\nIn neither: the cells {}.", missing.join(", "));
    let rows = grasps.iter();
    let rows = rows.map(|(name, grasps)| json!({ "type": name, "grasps": grasps }));
    let value = json!({
        "landscapes": names,
        "family_barriers": barriers,
        "family_levels": levels,
        "family_note": note,
        "families": sides.each_ref().map(|side| side.basins.families),
        "types": rows.collect::<Vec<_>>(),
        "cells": sides.each_ref().map(|side| &side.cells),
        "missing_cells": missing,
    });
    Ok(TypeComparison { text, value })
}

/// One of two landscapes.
struct Side {
    basins: Basins,
    /// Numbers of minima and grasps by type.
    types: BTreeMap<String, [u64; 2]>,
    cells: BTreeSet<String>,
    /// The level of its families.
    level: FamilyLevel,
}

impl Side {
    fn of(landscape: &NamedLandscape<'_>, family_barrier: Option<f64>) -> Result<Self, StudyError> {
        let basins = Basins::of(landscape, family_barrier)?;
        let cells = basins.minima.iter().filter_map(|basin| basin.cell.clone());
        Ok(Self {
            types: types(&basins).into_iter().collect(),
            cells: cells.collect(),
            level: FamilyLevel {
                barrier: basins.family_barrier,
                letting_go: landscape.files.manifest.letting_go,
            },
            basins,
        })
    }

    /// Number of grasps of the type.
    fn grasps(&self, name: &str) -> u64 {
        self.types.get(name).map_or(0, |counts| counts[1])
    }

    fn line(&self) -> String {
        let taxonomy = Taxonomy::feix();
        let types = taxonomy.types.iter();
        let listed = types.filter(|entry| self.types.contains_key(&entry.name));
        format!(
            "- {}: {} of 33 types, {} of {} cells, {} in {} (relative barrier up to {})\n",
            self.basins.name,
            listed.count(),
            self.cells.len(),
            taxonomy.cells().len(),
            counted(self.basins.minima.len(), "minimum"),
            counted(self.basins.families, "family"),
            self.level
        )
    }
}
