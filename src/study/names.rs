//! Taxonomy names of the minima of a landscape.

use std::sync::Arc;

use rayon::prelude::*;

use super::error::StudyError;
use crate::evaluation::taxonomy::{Category, Label, Labeller, Rule, Taxonomy};
use crate::grasp::{EnergySettings, GraspEnergy};
use crate::hand::Hand;
use crate::object::Object;
use crate::store::{LandscapeFiles, MinimumRow};

/// Hand and object of a landscape of grasps.
#[derive(Debug)]
pub struct GraspSetting {
    /// The hand.
    pub hand: Arc<Hand>,
    /// The object, with its scale.
    pub object: Arc<Object>,
}

/// Taxonomy name of a minimum.
#[derive(Debug)]
pub struct MinimumName {
    /// Number of the type, if the label is a type.
    pub number: Option<u8>,
    /// The category, if the label is a type, a cell or a category.
    pub category: Option<Category>,
    /// The cell of the taxonomy's table, if the label is a type or a cell.
    pub cell: Option<String>,
    /// The label by the rule.
    pub rule: Label,
}

impl GraspSetting {
    /// Builds hand and object of a landscape; `name` is its name in errors.
    ///
    /// # Errors
    /// If it is not a landscape of grasps, if its minima are not poses of its hand, or if hand or object cannot be built.
    pub fn of(files: &LandscapeFiles, name: &str) -> Result<Self, StudyError> {
        let manifest = &files.manifest;
        let (Some(hand), Some(object)) = (&manifest.hand, &manifest.object) else {
            return Err(StudyError::NotOfGrasps(name.to_owned()));
        };
        let hand = hand.build()?;
        let expected = 7 + hand.joints.len();
        let wrong = |row: &&MinimumRow| row.coordinates.len() != expected;
        if let Some(row) = files.minima.iter().find(wrong) {
            return Err(StudyError::Coordinates {
                landscape: name.to_owned(),
                minimum: row.id,
                found: row.coordinates.len(),
                expected,
            });
        }
        let object = object.build(manifest.scale);
        let object = object.map_err(|source| StudyError::Object {
            landscape: name.to_owned(),
            source: Box::new(source),
        })?;
        Ok(Self { hand, object })
    }

    /// The energy of the landscape.
    ///
    /// # Errors
    /// If the settings in the manifest are invalid.
    pub fn energy(&self, files: &LandscapeFiles, name: &str) -> Result<GraspEnergy, StudyError> {
        let settings = serde_json::from_value(files.manifest.energy.clone());
        let settings: EnergySettings = settings.map_err(|source| StudyError::Energy {
            landscape: name.to_owned(),
            source,
        })?;
        Ok(GraspEnergy::new(
            self.hand.clone(),
            self.object.clone(),
            settings,
        )?)
    }

    /// Names of all minima. Labels given when the landscape was built override the rule.
    pub fn names(&self, files: &LandscapeFiles, rule: &Rule) -> Vec<MinimumName> {
        let labeller = Labeller::new(&self.hand, &self.object, rule);
        files
            .minima
            .par_iter()
            .map(|row| MinimumName::new(row.label(), labeller.label(&row.coordinates)))
            .collect()
    }
}

impl MinimumName {
    /// The name of a pose with this label by the rule. A `given` label overrides it.
    pub(super) fn new(given: Option<&str>, label: Label) -> Self {
        let taxonomy = Taxonomy::feix();
        match given {
            Some(text) => {
                let named = taxonomy.named(text);
                // The label of an ambiguous grasp is its cell.
                let like = named.or_else(|| taxonomy.types.iter().find(|entry| entry.cell == text));
                Self {
                    number: named.map(|entry| entry.number),
                    category: like
                        .map(|entry| entry.category)
                        .or_else(|| Category::named(text)),
                    cell: like.map(|entry| entry.cell.clone()),
                    rule: label,
                }
            }
            None => Self {
                number: label.grasp_type().map(|entry| entry.number),
                category: label.listed_category(),
                cell: label.listed_cell().map(str::to_owned),
                rule: label,
            },
        }
    }

    /// The type, or else the cell, or else the category, or else `unlisted`.
    pub fn text(&self) -> &str {
        let entry = self
            .number
            .and_then(|number| Taxonomy::feix().numbered(number));
        entry.map_or_else(
            || match (&self.cell, self.category) {
                (Some(cell), _) => cell,
                (None, Some(category)) => category.name(),
                (None, None) => "unlisted",
            },
            |entry| entry.name.as_str(),
        )
    }
}
