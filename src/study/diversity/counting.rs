//! Counts the grasps of files and landscapes by family, type, cell and set of contact regions.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;

use super::{Counted, Counts, DiversitySet, OTHER_LEVELS};
use crate::evaluation::contact_regions;
use crate::evaluation::taxonomy::{Inapplicable, Labeller, Rule};
use crate::hand::Hand;
use crate::object::Object;
use crate::store::{GraspFile, GraspRow, LandscapeFiles};
use crate::study::error::StudyError;
use crate::study::level::FamilyLevel;
use crate::study::tables::family_of;
use crate::study::{GraspSetting, MinimumName, Run};
use crate::topography::{Phase, Tally};

/// What one pose counts as.
struct Place {
    name: Result<MinimumName, Inapplicable>,
    regions: String,
}

impl DiversitySet {
    /// Counts the grasps of a file, of all its hands and objects together. Labels given by a human override the rule.
    /// Families are not known without a landscape.
    ///
    /// # Errors
    /// If a hand or an object cannot be built.
    pub fn of_grasps(
        name: &str,
        file: &GraspFile,
        rule: &Rule,
        run: &Run<'_>,
    ) -> Result<Self, StudyError> {
        let tally = run.tally(Phase::Label, file.grasps.len());
        let mut places = Vec::new();
        for population in file.landscapes() {
            let (hand, object) = (population.hand()?, population.object()?);
            let counter = Counter::new(&hand, &object, rule);
            places.extend(counter.places(&population.grasps, &tally));
        }
        let families = Err(format!(
            "{name} has no map, so families are left out; `landscape build {name}` makes one"
        ));
        let hands = file.metadata.hands.iter().map(|hand| hand.name.clone());
        Ok(Self {
            hands: hands.collect(),
            ..Self::of_places(name, families, &places)
        })
    }

    /// Counts the grasps of the landscape in `folder`: each by the family and the pose of the minimum that it descended to.
    /// `family_barrier` replaces the landscape's own level of families, in units of its energy. Labels given when the
    /// landscape was built override the rule.
    ///
    /// # Errors
    /// If its rows do not fit each other, its hand or its object.
    pub fn of_landscape(
        name: &str,
        files: &LandscapeFiles,
        folder: &Path,
        family_barrier: Option<f64>,
        rule: &Rule,
        run: &Run<'_>,
    ) -> Result<Self, StudyError> {
        let network = files.network(folder)?;
        let families_at = |barrier: Option<f64>| -> BTreeMap<String, usize> {
            let mut families = BTreeMap::new();
            for (row, family) in (files.minima.iter()).zip(family_of(files, &network, barrier)) {
                *families.entry(format!("g{family}")).or_insert(0) += row.members.len();
            }
            families.retain(|_, count| *count > 0);
            families
        };
        let families = families_at(family_barrier);
        let level = FamilyLevel::of(&files.manifest, family_barrier);
        let at_other_levels = level
            .iter()
            .flat_map(|level| OTHER_LEVELS.map(|factor| families_at(Some(factor * level.barrier))));
        let families_at_other_levels = at_other_levels
            .map(|families| families.into_values().collect())
            .collect();
        let places = if files.manifest.hand.is_some() {
            let setting = GraspSetting::of(files, name)?;
            let counter = Counter::new(&setting.hand, &setting.object, rule);
            let rows = files
                .minima
                .par_iter()
                .filter(|row| !row.members.is_empty());
            let tally = run.tally(Phase::Label, rows.clone().count());
            rows.map(|row| {
                let place = counter.place(&row.coordinates, row.label());
                tally.tick();
                (place, row.members.len())
            })
            .collect()
        } else {
            Vec::new()
        };
        let grasps = families.values().sum();
        let mut set = Self::of_places(name, Ok(families), &places);
        if files.manifest.hand.is_none() {
            let reason = format!(
                "{name} is not a landscape of grasps, so its families are counted by the searches that ended in them"
            );
            set.counts[1..].fill(Err(reason));
        }
        let hands = files.manifest.hand.iter().map(|hand| hand.name.clone());
        Ok(Self {
            grasps,
            hands: hands.collect(),
            level,
            families_at_other_levels,
            ..set
        })
    }

    /// The counts of poses, each with its number of grasps.
    fn of_places(name: &str, families: Counts, places: &[(Place, usize)]) -> Self {
        let [types, cells, contacts] =
            count(places).map(|counts| counts.map_err(|why| format!("{name}: {}", why.words())));
        let mut set = Self::counted(name, Counted::Contacts, BTreeMap::new());
        set.grasps = places.iter().map(|(_, grasps)| grasps).sum();
        set.counts = [families, types, cells, contacts];
        set
    }
}

/// The types, cells and sets of contact regions of poses, each with its number of grasps.
fn count(places: &[(Place, usize)]) -> [Result<BTreeMap<String, usize>, Inapplicable>; 3] {
    let count = |kind: &dyn Fn(&Place) -> Option<String>| {
        let mut counts = BTreeMap::new();
        for (place, grasps) in places {
            if let Some(kind) = kind(place) {
                *counts.entry(kind).or_insert(0) += grasps;
            }
        }
        counts
    };
    let inapplicable = places
        .iter()
        .find_map(|(place, _)| place.name.as_ref().err());
    let named = |kind: &dyn Fn(&MinimumName) -> Option<String>| match inapplicable {
        Some(why) => Err(*why),
        None => Ok(count(&|place: &Place| kind(place.name.as_ref().ok()?))),
    };
    [
        named(&|name| name.number.map(|_| name.text().to_owned())),
        named(&|name| name.cell.clone()),
        Ok(count(&|place: &Place| Some(place.regions.clone()))),
    ]
}

/// Names poses of one hand on one object, and finds the parts of the hand that touch.
pub(in crate::study) struct Counter<'a> {
    hand: &'a Hand,
    object: &'a Object,
    labeller: Labeller<'a>,
}

impl<'a> Counter<'a> {
    pub(in crate::study) fn new(hand: &'a Hand, object: &'a Object, rule: &'a Rule) -> Self {
        Self {
            hand,
            object,
            labeller: Labeller::new(hand, object, rule),
        }
    }

    /// The types, cells and sets of contact regions of grasps. Labels given by a human override the rule.
    pub(in crate::study) fn count_grasps(
        &self,
        grasps: &[&GraspRow],
        tally: &Tally<'_>,
    ) -> [Result<BTreeMap<String, usize>, Inapplicable>; 3] {
        count(&self.places(grasps, tally))
    }

    /// What each grasp counts as. A label given by a human overrides the rule.
    fn places(&self, grasps: &[&GraspRow], tally: &Tally<'_>) -> Vec<(Place, usize)> {
        let place = |row: &&GraspRow| {
            let given = row.label.as_deref().filter(|label| !label.is_empty());
            let place = self.place(&row.grasp.pose, given);
            tally.tick();
            (place, 1)
        };
        grasps.par_iter().map(place).collect()
    }

    /// What the pose `x` counts as; a label that was given overrides the rule.
    fn place(&self, x: &[f64], given: Option<&str>) -> Place {
        let name = match self.labeller.inapplicable() {
            Some(why) => Err(why),
            None => Ok(MinimumName::new(given, self.labeller.label(x))),
        };
        Place {
            name,
            regions: self.touching(x),
        }
    }

    /// The [`contact_regions`] of the pose `x`, as one word of a table.
    pub(in crate::study) fn touching(&self, x: &[f64]) -> String {
        Vec::from_iter(contact_regions(self.hand, self.object, x)).join(", ")
    }
}
