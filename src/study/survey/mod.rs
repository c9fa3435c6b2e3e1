//! A data set of many hands and objects: how diverse the grasps of each object are, what all of them cover together, what
//! they share and what is missing.
//!
//! [`SurveyedPopulation`] counts the grasps of one hand on one object. It is small, so a data set of any size is surveyed one
//! population after the other. [`Survey`] compares and pools them by hand.

mod charts;
mod pooled;
mod report;

use std::collections::BTreeMap;
use std::fmt;

use petgraph::graph::NodeIndex;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Run;
use super::build::GraspLandscape;
use super::diversity::Counter;
use super::error::StudyError;
use super::level::{FamilyLevel, letting_go};
use crate::agreement::rarefied_hill_numbers;
use crate::evaluation::taxonomy::Rule;
use crate::grasp::GraspEnergy;
use crate::store::Population;
use crate::topography::{Completeness, LEAST_MEMBERS, MinimumId, Phase, Rarefaction};

pub use pooled::{HandSurvey, SharedContacts};

/// Numbers of grasps by name of the kind.
pub type KindCounts = BTreeMap<String, usize>;

/// The grasps of one hand on one object, counted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SurveyedPopulation {
    /// Name of the population, unique in the survey: the path of its file without ending, and what distinguishes it within.
    pub name: String,
    /// The file, as it was named.
    pub file: String,
    /// Name of the hand.
    pub hand: String,
    /// Name of the object.
    pub object: String,
    /// Factor on the size of the object.
    pub scale: f64,
    /// Number of grasps.
    pub grasps: usize,
    /// Number of grasps that were simulated.
    pub simulated: usize,
    /// Number of these that held.
    pub held: usize,
    /// Types of the GRASP taxonomy; `None` if the taxonomy does not apply to the hand. Grasps of no type are not counted.
    pub types: Option<KindCounts>,
    /// Cells of the table of the taxonomy, likewise.
    pub cells: Option<KindCounts>,
    /// Sets of [`contact_regions`](crate::evaluation::contact_regions).
    pub contacts: KindCounts,
    /// What the landscape of the population tells; `None` if it was not mapped.
    pub map: Option<SurveyedMap>,
    /// What is not known, and why; sentences without full stops.
    pub notes: Vec<String>,
}

/// The landscape of a population.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SurveyedMap {
    /// Number of minima.
    pub minima: usize,
    /// Its families: sets of minima joined by low barriers.
    pub families: Vec<SurveyedFamily>,
    /// The level of the families.
    pub level: FamilyLevel,
    /// Energy evaluations of the map.
    pub evaluations: usize,
}

/// A family of grasps.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SurveyedFamily {
    /// Number of grasps that descended into it.
    pub grasps: usize,
    /// The set of digits (and the palm) with which most of its grasps touch.
    pub contacts: String,
}

impl SurveyedPopulation {
    /// Counts the grasps of a population, without its landscape. Labels given by a human override the rule.
    ///
    /// # Errors
    /// If the hand or the object cannot be built.
    pub fn count(
        name: &str,
        file: &str,
        population: &Population<'_>,
        rule: &Rule,
        run: &Run<'_>,
    ) -> Result<Self, StudyError> {
        let (hand, object) = (population.hand()?, population.object()?);
        let counter = Counter::new(&hand, &object, rule);
        let tally = run.tally(Phase::Label, population.grasps.len());
        let [types, cells, contacts] = counter.count_grasps(&population.grasps, &tally);
        let why = types.as_ref().err().map(|why| why.words());
        let outcomes = || population.grasps.iter().filter_map(|grasp| grasp.stable);
        Ok(Self {
            name: name.to_owned(),
            file: file.to_owned(),
            hand: population.hand.name.clone(),
            object: population.object.name.clone(),
            scale: population.scale,
            grasps: population.grasps.len(),
            simulated: outcomes().count(),
            held: outcomes().filter(|held| *held).count(),
            types: types.ok(),
            cells: cells.ok(),
            contacts: contacts.unwrap_or_default(),
            map: None,
            notes: Vec::from_iter(why),
        })
    }

    /// Adds what the landscape tells that was mapped on this energy.
    pub fn add_map(&mut self, energy: &GraspEnergy, found: &GraspLandscape, rule: &Rule) {
        let counter = Counter::new(energy.hand(), energy.object(), rule);
        let (network, found_families) = (&found.landscape.network, &found.landscape.families);
        let family = |members: &Vec<MinimumId>| {
            let mut contacts = KindCounts::new();
            for id in members {
                let minimum = &network[NodeIndex::new(id.0)];
                let regions = counter.touching(&minimum.coordinates);
                *contacts.entry(regions).or_insert(0) += minimum.members.len();
            }
            SurveyedFamily {
                grasps: contacts.values().sum(),
                contacts: commonest(&contacts),
            }
        };
        let families = found_families.members.par_iter().map(family);
        self.map = Some(SurveyedMap {
            minima: network.node_count(),
            families: families.filter(|family| family.grasps > 0).collect(),
            level: FamilyLevel {
                barrier: found_families.barrier,
                letting_go: letting_go(energy.settings()),
            },
            evaluations: found.evaluations,
        });
    }

    /// What distinguishes the object in tables and pictures of one hand.
    pub fn object_label(&self) -> String {
        if (self.scale - 1.0).abs() < 1e-12 {
            self.object.clone()
        } else {
            format!("{} × {}", self.object, self.scale)
        }
    }

    /// How complete the families are; `None` without a map or with fewer than [`LEAST_MEMBERS`] grasps.
    pub fn completeness(&self) -> Option<Completeness> {
        Rarefaction::new(&self.map.as_ref()?.sizes(), 2).estimate
    }
}

impl SurveyedMap {
    /// Numbers of grasps of the families.
    pub fn sizes(&self) -> Vec<usize> {
        self.families.iter().map(|family| family.grasps).collect()
    }
}

/// The name with the largest count; the first of several.
fn commonest(counts: &KindCounts) -> String {
    let largest = counts.values().max();
    let first = counts.iter().find(|(_, count)| Some(*count) == largest);
    first.map_or_else(String::new, |(name, _)| name.clone())
}

/// A data set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Survey {
    /// Its populations, in the order of the files.
    pub populations: Vec<SurveyedPopulation>,
    /// What each hand does on all its objects, by name of the hand.
    pub hands: Vec<HandSurvey>,
    /// Files and populations that could not be surveyed, and why.
    pub failures: Vec<SurveyFailure>,
    /// What cannot be compared, and why; sentences without full stops.
    pub notes: Vec<String>,
}

/// A file or population that could not be surveyed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SurveyFailure {
    /// The file.
    pub file: String,
    /// The reason, one sentence.
    pub reason: String,
}

impl fmt::Display for SurveyFailure {
    /// The file and the reason, or the reason alone if it names the file.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.reason.contains(&self.file) {
            write!(formatter, "{}: ", self.file)?;
        }
        formatter.write_str(&self.reason)
    }
}

impl Survey {
    /// Pools populations by hand.
    pub fn new(populations: Vec<SurveyedPopulation>, failures: Vec<SurveyFailure>) -> Self {
        let mut by_hand: BTreeMap<&str, Vec<&SurveyedPopulation>> = BTreeMap::new();
        for population in &populations {
            by_hand
                .entry(&population.hand)
                .or_default()
                .push(population);
        }
        let hands = by_hand.values().map(|of_hand| HandSurvey::of(of_hand));
        Self {
            hands: hands.collect(),
            notes: different_levels(&populations),
            populations,
            failures,
        }
    }
}

/// Effective numbers of order 0, 1 and 2 of these kinds in a sample of [`LEAST_MEMBERS`] grasps, so that populations of any
/// size compare; `None` if fewer were counted.
fn effective(counts: impl IntoIterator<Item = usize>) -> Option<[f64; 3]> {
    let counts: Vec<usize> = counts.into_iter().collect();
    let enough = counts.iter().sum::<usize>() >= LEAST_MEMBERS;
    enough.then(|| rarefied_hill_numbers(&counts, LEAST_MEMBERS))
}

/// One note if families were made at different levels.
fn different_levels(populations: &[SurveyedPopulation]) -> Vec<String> {
    let levels = populations
        .iter()
        .filter_map(|population| Some((population.name.as_str(), &population.map.as_ref()?.level)));
    let levels: Vec<(&str, &FamilyLevel)> = levels.collect();
    let Some((first, others)) = levels.split_first() else {
        return Vec::new();
    };
    let note = others
        .iter()
        .find_map(|other| FamilyLevel::difference(*first, *other));
    note.into_iter().collect()
}

#[cfg(test)]
mod tests;
