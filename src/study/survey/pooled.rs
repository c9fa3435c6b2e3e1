//! What one hand does on all its objects.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::{KindCounts, SurveyedPopulation};
use crate::topography::Rarefaction;

/// Points of a rarefaction curve up to the actual sample size.
const POINTS: usize = 50;

/// A kind that this share of the other objects have, and one object does not, is missing there.
const USUAL: f64 = 0.5;

/// The grasps of one hand on all objects together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HandSurvey {
    /// Name of the hand.
    pub hand: String,
    /// Names of its populations.
    pub populations: Vec<String>,
    /// Number of grasps.
    pub grasps: usize,
    /// Types of the taxonomy; `None` if it does not apply.
    pub types: Option<KindCounts>,
    /// Cells of the taxonomy; `None` if it does not apply.
    pub cells: Option<KindCounts>,
    /// Sets of touching digits (and the palm).
    pub contacts: KindCounts,
    /// Types that at least half of the other objects have and this object does not, by name of the population.
    pub missing_types: BTreeMap<String, Vec<String>>,
    /// Families by the digits with which they touch; the sets on most objects come first.
    pub shared: Vec<SharedContacts>,
    /// Sizes of all families of all populations.
    pub family_sizes: Vec<usize>,
}

/// Families of several objects that touch with the same digits.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SharedContacts {
    /// The digits (and the palm).
    pub contacts: String,
    /// Names of the populations with such a family.
    pub populations: Vec<String>,
    /// Number of such families.
    pub families: usize,
    /// Number of grasps in them.
    pub grasps: usize,
}

impl HandSurvey {
    pub(super) fn of(populations: &[&SurveyedPopulation]) -> Self {
        let known = |counts: &dyn Fn(&SurveyedPopulation) -> Option<KindCounts>| {
            let all: Vec<KindCounts> = populations.iter().filter_map(|one| counts(one)).collect();
            (!all.is_empty()).then(|| sum(&all))
        };
        let maps = || {
            populations
                .iter()
                .filter_map(|one| Some((*one, one.map.as_ref()?)))
        };
        Self {
            hand: populations[0].hand.clone(),
            populations: populations.iter().map(|one| one.name.clone()).collect(),
            grasps: populations.iter().map(|one| one.grasps).sum(),
            types: known(&|one| one.types.clone()),
            cells: known(&|one| one.cells.clone()),
            contacts: known(&|one| Some(one.contacts.clone())).unwrap_or_default(),
            missing_types: missing(populations),
            family_sizes: maps().flat_map(|(_, map)| map.sizes()).collect(),
            shared: shared(populations),
        }
    }

    /// `[families whose contact set occurs on another object, all families]`.
    pub fn shared_families(&self) -> [usize; 2] {
        let families = |sets: &mut dyn Iterator<Item = &SharedContacts>| {
            sets.map(|set| set.families).sum::<usize>()
        };
        [
            families(&mut self.shared.iter().filter(|set| set.populations.len() > 1)),
            families(&mut self.shared.iter()),
        ]
    }

    /// How the number of kinds grows with the number of grasps, all objects pooled.
    pub fn rarefaction(counts: impl IntoIterator<Item = usize>) -> Rarefaction {
        Rarefaction::new(&counts.into_iter().collect::<Vec<_>>(), POINTS)
    }
}

fn sum(all: &[KindCounts]) -> KindCounts {
    let mut pooled = KindCounts::new();
    for (name, count) in all.iter().flatten() {
        *pooled.entry(name.clone()).or_insert(0) += count;
    }
    pooled
}

/// The usual types that each population lacks.
fn missing(populations: &[&SurveyedPopulation]) -> BTreeMap<String, Vec<String>> {
    let known = populations
        .iter()
        .filter_map(|one| Some((*one, one.types.as_ref()?)));
    let known: Vec<(&SurveyedPopulation, &KindCounts)> = known.collect();
    let names: BTreeSet<&String> = known.iter().flat_map(|(_, types)| types.keys()).collect();
    let lacks = |types: &KindCounts| {
        let usual = names.iter().filter(|name| {
            let with = known.iter().filter(|(_, other)| other.contains_key(**name));
            // The population itself lacks the type, so all that have it are others.
            with.count() as f64 >= USUAL * (known.len() - 1) as f64 && !types.contains_key(**name)
        });
        usual.map(|name| (*name).clone()).collect::<Vec<_>>()
    };
    let rows = known.iter().filter(|_| known.len() > 1);
    rows.map(|(one, types)| (one.name.clone(), lacks(types)))
        .filter(|(_, missing)| !missing.is_empty())
        .collect()
}

fn shared(populations: &[&SurveyedPopulation]) -> Vec<SharedContacts> {
    let mut sets: BTreeMap<&str, SharedContacts> = BTreeMap::new();
    for one in populations {
        for family in one.map.iter().flat_map(|map| &map.families) {
            let set = sets
                .entry(&family.contacts)
                .or_insert_with(|| SharedContacts {
                    contacts: family.contacts.clone(),
                    populations: Vec::new(),
                    families: 0,
                    grasps: 0,
                });
            if set.populations.last() != Some(&one.name) {
                set.populations.push(one.name.clone());
            }
            set.families += 1;
            set.grasps += family.grasps;
        }
    }
    let mut sets: Vec<SharedContacts> = sets.into_values().collect();
    sets.sort_by_key(|set| std::cmp::Reverse((set.populations.len(), set.families, set.grasps)));
    sets
}
