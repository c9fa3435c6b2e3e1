//! Which of several sets of grasps is more diverse: effective numbers of families, types, cells and sets of contact
//! regions, at equal sample size.

mod chart;
mod counting;
mod report;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::error::StudyError;
use super::level::GroupLevel;
use crate::agreement::{Estimated, hill_numbers};
use crate::topography::LEAST_MEMBERS;

pub(super) use counting::Counter;

/// Settings of [`compare_diversity`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DiversitySettings {
    /// Number of resamplings for each interval.
    pub resamplings: usize,
    /// Seed of the resamplings.
    pub seed: u64,
}

impl Default for DiversitySettings {
    fn default() -> Self {
        Self {
            resamplings: 500,
            seed: 0,
        }
    }
}

/// What is counted in a set of grasps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Counted {
    /// Groups of a landscape: grasps between which the hand passes over low barriers.
    Families,
    /// Types of the GRASP taxonomy.
    Types,
    /// Cells of the table of the taxonomy.
    Cells,
    /// Sets of digits (and the palm) that are within 2 mm of the object.
    Contacts,
}

impl Counted {
    /// All, in the order of tables and pictures.
    pub const ALL: [Self; 4] = [Self::Families, Self::Types, Self::Cells, Self::Contacts];

    /// Plural noun.
    pub fn name(self) -> &'static str {
        match self {
            Self::Families => "families",
            Self::Types => "types",
            Self::Cells => "cells",
            Self::Contacts => "contact regions",
        }
    }
}

/// Factors on the level of families at which they are counted as well.
///
/// The barrier between the two large families of a bottle is 0.7 to 2 times the default level in samples that differ only in
/// their seed. A family that splits at one of these levels and not at another tells nothing about the sample.
pub const OTHER_LEVELS: [f64; 2] = [0.5, 2.0];

/// Numbers of grasps by name of the kind, or one sentence (without a full stop) that says why they are not known.
pub type Counts = Result<BTreeMap<String, usize>, String>;

/// A set of grasps, counted in several ways. [`DiversitySet::of_grasps`] and [`DiversitySet::of_landscape`] count.
#[derive(Debug, Clone, PartialEq)]
pub struct DiversitySet {
    /// Name in texts and pictures.
    pub name: String,
    /// Number of grasps.
    pub grasps: usize,
    /// The counts, in the order of [`Counted::ALL`]. Grasps that are of no kind are left out.
    pub counts: [Counts; 4],
    /// The level of the families, if there are any.
    pub level: Option<GroupLevel>,
    /// Numbers of grasps in each family at [`OTHER_LEVELS`] times the level; empty if the level is not known.
    pub families_at_other_levels: Vec<Vec<usize>>,
}

/// The effective numbers of one thing in all sets.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measure {
    /// What is counted.
    pub of: Counted,
    /// The number of grasps to which all sets are rarefied.
    pub grasps: usize,
    /// Effective numbers of order 0, 1 and 2 in each set; `None` if they are not known.
    pub sets: Vec<Option<[Estimated; 3]>>,
    /// For each order the set whose interval lies above those of all others; `None` if there is no such set.
    pub most: [Option<usize>; 3],
}

/// Sets of grasps side by side.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DiversityComparison {
    /// Names of the sets.
    pub names: Vec<String>,
    /// Number of grasps of each set.
    pub grasps: Vec<usize>,
    /// What could be measured in at least one set.
    pub measures: Vec<Measure>,
    /// What could not be measured or compared, and why; sentences without full stops.
    pub notes: Vec<String>,
    /// The settings.
    pub settings: DiversitySettings,
}

/// Compares how diverse sets of grasps are.
///
/// The diversity of a set is the effective number of kinds in it ([`hill_numbers`]) of order 0 (all kinds alike), 1 (by
/// frequency) and 2 (frequent kinds). Every set is rarefied to the number of grasps of the smallest that is measured, so
/// that no set looks diverse because it is large. Intervals (95 %) come from seeded resamplings. Families are compared at
/// [`OTHER_LEVELS`] times their level as well, and no set is called the most diverse that is not so at each level, so that the
/// height of a single pass decides nothing. Their intervals span those of all levels. Grasps must be independent draws: a set
/// that was chosen to be spread looks more diverse than its source.
///
/// # Errors
/// [`StudyError::FewGrasps`] if a set has fewer than [`LEAST_MEMBERS`] grasps: nothing is extrapolated.
///
/// # Examples
/// ```
/// use landscape::study::{Counted, DiversitySet, DiversitySettings, compare_diversity};
///
/// let set = |name: &str, families: &[usize]| {
///     let named = families.iter().enumerate().map(|(i, n)| (format!("g{i}"), *n));
///     DiversitySet::counted(name, Counted::Families, named.collect())
/// };
/// let sets = [set("narrow", &[90, 5, 5]), set("wide", &[10; 20])];
/// let found = compare_diversity(&sets, &DiversitySettings::default())?;
/// assert_eq!(found.measures[0].grasps, 100);
/// assert_eq!(found.answer(), "wide is the more diverse by families: its intervals lie above those of the other.");
/// # Ok::<(), landscape::study::StudyError>(())
/// ```
pub fn compare_diversity(
    sets: &[DiversitySet],
    settings: &DiversitySettings,
) -> Result<DiversityComparison, StudyError> {
    if let Some(few) = sets.iter().find(|set| set.grasps < LEAST_MEMBERS) {
        return Err(StudyError::FewGrasps {
            name: few.name.clone(),
            grasps: few.grasps,
            needed: LEAST_MEMBERS,
        });
    }
    let mut notes = Vec::new();
    let mut measures = Vec::new();
    for (place, of) in Counted::ALL.into_iter().enumerate() {
        let counts: Vec<Option<Vec<usize>>> = sets
            .iter()
            .map(|set| {
                let known = enough(set, place, of).map_err(|reason| notes.push(reason));
                known.ok()
            })
            .collect();
        let mut measured = measure(of, &counts, settings);
        if let (Counted::Families, Some(measured)) = (of, &mut measured) {
            span_other_levels(measured, sets, settings);
        }
        measures.extend(measured);
    }
    let spanned = |set: &DiversitySet| !set.families_at_other_levels.is_empty();
    if measures
        .iter()
        .any(|measure: &Measure| measure.of == Counted::Families)
        && sets.iter().any(spanned)
    {
        notes.push(
            "families are compared at half and at twice their level, too, so that the height of a single pass decides nothing; \
             their intervals span those of the three levels"
                .to_owned(),
        );
    }
    let mut comparison = DiversityComparison {
        names: sets.iter().map(|set| set.name.clone()).collect(),
        grasps: sets.iter().map(|set| set.grasps).collect(),
        measures,
        notes,
        settings: *settings,
    };
    comparison.refuse_other_levels(sets);
    let mut told = BTreeSet::new();
    comparison.notes.retain(|note| told.insert(note.clone()));
    Ok(comparison)
}

/// The counts of a set, if there are enough for an estimate.
fn enough(set: &DiversitySet, place: usize, of: Counted) -> Result<Vec<usize>, String> {
    let counts = set.counts[place].as_ref().map_err(Clone::clone)?;
    let counts: Vec<usize> = counts
        .values()
        .copied()
        .filter(|count| *count > 0)
        .collect();
    let total: usize = counts.iter().sum();
    if total < LEAST_MEMBERS {
        let what = of.name();
        return Err(format!(
            "{} of the {} grasps of {} have {what}, but at least {LEAST_MEMBERS} are needed",
            total, set.grasps, set.name
        ));
    }
    Ok(counts)
}

/// The effective numbers of the sets with counts at equal sample size; `None` if no set has any.
fn measure(
    of: Counted,
    counts: &[Option<Vec<usize>>],
    settings: &DiversitySettings,
) -> Option<Measure> {
    let known = counts.iter().flatten();
    let grasps = known.map(|counts| counts.iter().sum()).min()?;
    let numbers =
        |counts: &Vec<usize>| hill_numbers(counts, grasps, settings.resamplings, settings.seed);
    let sets: Vec<Option<[Estimated; 3]>> = counts
        .iter()
        .map(|counts| counts.as_ref().map(numbers))
        .collect();
    Some(Measure {
        of,
        grasps,
        most: std::array::from_fn(|order| most(&sets, order)),
        sets,
    })
}

/// Compares the families at other levels as well: no set is the most diverse that is not so at each of them. Intervals span
/// those of all levels.
fn span_other_levels(measure: &mut Measure, sets: &[DiversitySet], settings: &DiversitySettings) {
    let own = measure.sets.clone();
    for level in 0..OTHER_LEVELS.len() {
        let at_level = |(set, own): (&DiversitySet, &Option<[Estimated; 3]>)| {
            let counts = set.families_at_other_levels.get(level);
            own.map(|own| {
                counts.map_or(own, |counts| {
                    hill_numbers(counts, measure.grasps, settings.resamplings, settings.seed)
                })
            })
        };
        let numbers: Vec<Option<[Estimated; 3]>> = sets.iter().zip(&own).map(at_level).collect();
        for order in 0..3 {
            if most(&numbers, order) != measure.most[order] {
                measure.most[order] = None;
            }
        }
        for (spanned, here) in measure
            .sets
            .iter_mut()
            .flatten()
            .zip(numbers.iter().flatten())
        {
            for (number, other) in spanned.iter_mut().zip(here) {
                let [low, high] = &mut number.interval;
                *low = low.min(other.interval[0]);
                *high = high.max(other.interval[1]);
            }
        }
    }
}

/// The set whose interval lies above those of all others.
fn most(sets: &[Option<[Estimated; 3]>], order: usize) -> Option<usize> {
    let known = || {
        sets.iter()
            .enumerate()
            .filter_map(|(set, numbers)| Some((set, numbers.as_ref()?[order])))
    };
    if known().count() < 2 {
        return None;
    }
    known()
        .find(|(set, number)| {
            known().all(|(other, beside)| other == *set || number.exceeds(&beside))
        })
        .map(|(set, _)| set)
}

impl DiversitySet {
    /// A set with known numbers of one thing, by name, and without any other.
    pub fn counted(name: &str, of: Counted, counts: BTreeMap<String, usize>) -> Self {
        let grasps = counts.values().sum();
        let mut set = Self {
            name: name.to_owned(),
            grasps,
            counts: Counted::ALL
                .map(|of| Err(format!("the {} of {name} are not known", of.name()))),
            level: None,
            families_at_other_levels: Vec::new(),
        };
        set.counts[of as usize] = Ok(counts);
        set
    }
}

impl DiversityComparison {
    /// Families at different levels are shown, but none of them is called more diverse.
    fn refuse_other_levels(&mut self, sets: &[DiversitySet]) {
        let levels: Vec<(&str, &GroupLevel)> = (sets.iter())
            .filter_map(|set| Some((set.name.as_str(), set.level.as_ref()?)))
            .collect();
        let Some((first, others)) = levels.split_first() else {
            return;
        };
        let mut differences = others
            .iter()
            .filter_map(|other| GroupLevel::difference(*first, *other));
        let Some(note) = differences.next() else {
            return;
        };
        self.notes.insert(0, note);
        for measure in &mut self.measures {
            if measure.of == Counted::Families {
                measure.most = [None; 3];
            }
        }
    }
}

#[cfg(test)]
mod tests;
