//! What the minima of a landscape are called.

use anyhow::Context;
use rayon::prelude::*;

use crate::evaluation::taxonomy::{Category, Label, Labeller, Rule, Taxonomy};
use crate::grasp::{EnergySettings, GraspEnergy};
use crate::hand::Hand;
use crate::object::Object;
use crate::store::{LandscapeFiles, MinimumRow};

/// Hand and object of a landscape of grasps.
pub(super) struct Setting {
    pub(super) hand: std::sync::Arc<Hand>,
    pub(super) object: std::sync::Arc<Object>,
}

/// The name of a minimum.
pub(super) struct Named {
    /// Number of the type, where the label is one.
    pub(super) number: Option<u8>,
    /// Where the label is a type or a cell.
    pub(super) category: Option<Category>,
    pub(super) cell: Option<String>,
    /// What the rule says.
    pub(super) rule: Label,
}

impl Setting {
    pub(super) fn of(files: &LandscapeFiles, name: &str) -> anyhow::Result<Self> {
        let manifest = &files.manifest;
        let (Some(hand), Some(object)) = (&manifest.hand, &manifest.object) else {
            anyhow::bail!(
                "{name} is not a landscape of grasps: there is nothing the taxonomy could name"
            );
        };
        let hand = hand.build()?;
        let wanted = 7 + hand.joints.len();
        for row in &files.minima {
            anyhow::ensure!(
                row.coordinates.len() == wanted,
                "{name}: minimum {} has {} coordinates, the hand {wanted}",
                row.id,
                row.coordinates.len()
            );
        }
        let object = object
            .build(manifest.scale)
            .with_context(|| format!("the object of {name}"))?;
        Ok(Self { hand, object })
    }

    /// The energy whose landscape it is.
    pub(super) fn energy(&self, files: &LandscapeFiles, name: &str) -> anyhow::Result<GraspEnergy> {
        let settings: EnergySettings = serde_json::from_value(files.manifest.energy.clone())
            .with_context(|| format!("the energy of {name} is not one this program knows"))?;
        let energy = GraspEnergy::new(self.hand.clone(), self.object.clone(), settings)?;
        Ok(energy)
    }

    /// Names of all minima: labels that the landscape was built with win over the rule's.
    pub(super) fn names(&self, files: &LandscapeFiles, rule: &Rule) -> Vec<Named> {
        let labeller = Labeller::new(&self.hand, &self.object, rule);
        files
            .minima
            .par_iter()
            .map(|row| Named::new(row, labeller.label(&row.coordinates)))
            .collect()
    }
}

impl Named {
    fn new(row: &MinimumRow, label: Label) -> Self {
        let taxonomy = Taxonomy::feix();
        let given = row
            .labels
            .iter()
            .rev()
            .max_by_key(|(_, count)| **count)
            .map(|(text, _)| text.as_str());
        match given {
            Some(text) => {
                let named = taxonomy.named(text);
                // An ambiguous grasp's label is its cell.
                let like = named.or_else(|| taxonomy.types.iter().find(|entry| entry.cell == text));
                Self {
                    number: named.map(|entry| entry.number),
                    category: like.map(|entry| entry.category),
                    cell: like.map(|entry| entry.cell.clone()),
                    rule: label,
                }
            }
            None => Self {
                number: label.grasp_type().map(|entry| entry.number),
                category: label.listed_category(),
                cell: label
                    .listed_category()
                    .and_then(|_| taxonomy.numbered(label.best.first()?.number))
                    .map(|entry| entry.cell.clone()),
                rule: label,
            },
        }
    }

    /// The type, else the cell, else `unlisted`.
    pub(super) fn text(&self) -> &str {
        let entry = self
            .number
            .and_then(|number| Taxonomy::feix().numbered(number));
        entry.map_or_else(
            || self.cell.as_deref().unwrap_or("unlisted"),
            |entry| entry.name.as_str(),
        )
    }
}
