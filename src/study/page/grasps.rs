//! The grasps of a file on a page.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::Scenes;
use super::pack::{Pack, Texts};
use super::touch::{Touch, packed, touches};
use crate::evaluation::taxonomy::{Category, Label, Taxonomy};
use crate::printable::counted;
use crate::store::{GraspFile, GraspRow};
use crate::study::error::StudyError;
use crate::study::names::MinimumName;

/// Greatest number of touched places of a grasp, and if there are more than [`MANY`] grasps.
const TOUCHES: [usize; 2] = [24, 8];
const MANY: usize = 1000;

/// The grasps of a file, to be shown on a page.
#[derive(Debug, Clone, Copy)]
pub struct PageGrasps<'a> {
    /// Name of the file.
    pub name: &'a str,
    /// Its content.
    pub file: &'a GraspFile,
    /// Labels by the rule, by id.
    pub labels: &'a BTreeMap<u64, Label>,
}

/// A grasp of a population with what is shown of it.
struct Shown<'a> {
    row: &'a GraspRow,
    scene: usize,
    touches: Vec<Touch>,
}

impl PageGrasps<'_> {
    /// The grasps as an entry of the header.
    pub(super) fn side(&self, scenes: &mut Scenes, pack: &mut Pack) -> Result<Value, StudyError> {
        let mut shown = Vec::new();
        for population in self.file.landscapes() {
            let energy = population.energy()?;
            let (hand, object) = (energy.hand(), energy.object());
            let named = (population.object.name.as_str(), population.scale, &**object);
            let scene = scenes.add(pack, (&population.hand.name, hand), named);
            let most = TOUCHES[usize::from(self.file.grasps.len() > MANY)];
            let of_population = population.grasps.par_iter().map(|row| Shown {
                row,
                scene,
                touches: touches(&energy, &row.grasp, most),
            });
            shown.extend(of_population.collect::<Vec<_>>());
        }
        let mut side = self.rows(&shown, pack);
        let labels = self.labels(&shown, pack);
        if let (Value::Object(side), Value::Object(labels)) = (&mut side, labels) {
            side.extend(labels);
        }
        Ok(side)
    }

    fn rows(&self, shown: &[Shown<'_>], pack: &mut Pack) -> Value {
        let rows = || shown.iter().map(|shown| shown.row);
        // Hands of several kinds have different numbers of joints.
        let dimensions = rows().map(|row| row.grasp.pose.len()).max().unwrap_or(0);
        let coordinates: Vec<f64> = rows()
            .flat_map(|row| {
                let rest = dimensions - row.grasp.pose.len();
                row.grasp
                    .pose
                    .iter()
                    .copied()
                    .chain(std::iter::repeat_n(0.0, rest))
            })
            .collect();
        let energies: Vec<f64> = rows().map(|row| row.energy).collect();
        let terms: Vec<f64> = rows().flat_map(|row| row.terms.iter().copied()).collect();
        let metadata = &self.file.metadata;
        let whole = terms.len() == metadata.terms.len() * shown.len();
        let stability = |row: &GraspRow| row.stable.map_or(2, u8::from);
        let objects: Texts = rows().map(|row| row.object.as_str()).collect();
        let places: Vec<Vec<Touch>> = shown.iter().map(|shown| shown.touches.clone()).collect();
        json!({
            "name": self.name,
            "title": format!("{} of {}", counted(shown.len(), "grasp"), self.name),
            "item": "grasp",
            "command": metadata.command,
            "program": metadata.program_version,
            "energy_label": "energy E(H, O)",
            "members_label": "grasps",
            "count": shown.len(),
            "space": { "kind": "pose", "dimensions": dimensions },
            "scenes": pack.wholes(shown.iter().map(|shown| shown.scene)),
            "object": objects.packed(pack),
            "coordinates": pack.floats(&coordinates),
            "energy": pack.doubles(&energies),
            // Texts, because numbers in scripts are exact only up to 2⁵³.
            "members": rows().map(|row| row.id.to_string()).collect::<Vec<_>>(),
            "term_names": if whole { metadata.terms.clone() } else { Vec::new() },
            "terms": pack.floats(if whole { &terms } else { &[] }),
            "epsilon": pack.known_floats(rows().map(|row| row.epsilon)),
            "stable": pack.bytes(rows().map(stability)),
            "touches": packed(&places, pack),
        })
    }

    fn labels(&self, shown: &[Shown<'_>], pack: &mut Pack) -> Value {
        let given = |row: &GraspRow| row.label.clone().filter(|label| !label.is_empty());
        let named: Vec<(Option<String>, MinimumName)> = (shown.iter())
            .filter_map(|Shown { row, .. }| {
                let label = self.labels.get(&row.id)?.clone();
                let given = given(row);
                let name = MinimumName::new(given.as_deref(), label);
                Some((given, name))
            })
            .collect();
        if named.len() < shown.len() {
            return json!({});
        }
        let category = |name: &MinimumName| name.category.map_or("", Category::name);
        let names = || named.iter().map(|(_, name)| name);
        let texts: Texts = named
            .iter()
            .map(|(given, name)| shown_text(given.as_deref(), name))
            .collect();
        let categories: Texts = names().map(category).collect();
        let cells: Texts = names()
            .map(|name| name.cell.as_deref().unwrap_or(""))
            .collect();
        let given: Texts = named
            .iter()
            .map(|(given, _)| given.as_deref().unwrap_or(""))
            .collect();
        json!({
            "label": texts.packed(pack),
            "category": categories.packed(pack),
            "cell": cells.packed(pack),
            "type": pack.bytes(names().map(|name| name.number.unwrap_or(0))),
            "given": given.packed(pack),
            "rule": names().map(|name| name.rule.best_text()).collect::<Vec<_>>(),
        })
    }
}

/// The type; for a label of the user that the taxonomy does not know, the label itself.
fn shown_text<'a>(given: Option<&'a str>, name: &'a MinimumName) -> &'a str {
    match given {
        Some(text) if name.number.is_none() && name.cell.is_none() => text,
        _ => name.text(),
    }
}

/// The 33 types, for the matrix and the chooser.
pub(super) fn taxonomy() -> Value {
    let types = Taxonomy::feix().types.iter();
    let entry = types.map(|entry| {
        json!({
            "number": entry.number,
            "name": entry.name,
            "aliases": entry.aliases,
            "category": entry.category.name(),
            "cell": entry.cell,
            "cue": entry.cue,
        })
    });
    entry.collect()
}
