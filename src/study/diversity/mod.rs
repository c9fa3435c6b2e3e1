//! Which of several sets of grasps is more diverse: effective numbers of families, types, cells and sets of contact
//! regions, at equal sample size.

mod chart;
mod counting;
mod report;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::error::{FewGrasps, StudyError};
use super::level::FamilyLevel;
use crate::agreement::{Estimated, HillNumbers, Ratio};
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
    /// Grasps of a landscape between which the hand passes over low barriers.
    Families,
    /// Types of the GRASP taxonomy.
    Types,
    /// Cells of the table of the taxonomy.
    Cells,
    /// Different sets of digits (and the palm) within 2 mm of the object: [`contact_regions`](crate::evaluation::contact_regions).
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
            Self::Contacts => "sets of contact regions",
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
    /// Names of the hands; empty if there are none, or if they are not known.
    pub hands: Vec<String>,
    /// The counts, in the order of [`Counted::ALL`]. Grasps that are of no kind are left out.
    pub counts: [Counts; 4],
    /// The level of the families, if there are any.
    pub level: Option<FamilyLevel>,
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
    /// The ratios of each two sets that have this measure.
    pub ratios: Vec<RatioOfSets>,
    /// For each order the set whose ratio to each other set has an interval above 1; `None` if there is no such set.
    pub most: [Option<usize>; 3],
}

/// How many times as many effective kinds one set has as another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RatioOfSets {
    /// The sets: that of the numerator, that of the denominator.
    pub sets: [usize; 2],
    /// Ratios at order 0, 1 and 2.
    pub orders: [Ratio; 3],
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

/// Refuses sets that are too small to be compared, given by name and number of grasps.
///
/// # Errors
/// [`StudyError::FewGrasps`] if a set has fewer than [`LEAST_MEMBERS`] grasps: nothing is extrapolated.
pub fn check_set_sizes<'a>(
    sets: impl IntoIterator<Item = (&'a str, usize)>,
) -> Result<(), StudyError> {
    let few = (sets.into_iter()).filter(|(_, grasps)| *grasps < LEAST_MEMBERS);
    let few: Vec<(String, usize)> = few
        .map(|(name, grasps)| (name.to_owned(), grasps))
        .collect();
    if few.is_empty() {
        return Ok(());
    }
    let needed = LEAST_MEMBERS;
    Err(StudyError::FewGrasps(FewGrasps { few, needed }))
}

/// Compares how diverse sets of grasps are.
///
/// The diversity of a set is the effective number of kinds in it ([`HillNumbers`]) of order 0 (all kinds alike), 1 (by
/// frequency) and 2 (frequent kinds). Every set is rarefied to the number of grasps of the smallest that is measured, so
/// that no set looks diverse because it is large. Intervals (95 %) come from seeded resamplings. A set is called the most
/// diverse where the interval of its ratio to each other set lies above 1. Families are compared at [`OTHER_LEVELS`] times
/// their level as well, and all intervals of families span those of the three levels, so that the height of a single pass
/// decides nothing. Grasps must be independent draws: a set that was chosen to be spread looks more diverse than its source.
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
/// let sets = [set("narrow", &[50; 2]), set("wide", &[10; 10])];
/// let found = compare_diversity(&sets, &DiversitySettings::default())?;
/// assert_eq!(found.measures[0].grasps, 100);
/// assert!(found.answer().starts_with(
///     "wide is the more diverse by families: it has 5.0 times as many effective families as narrow (order 1, 95 % interval"
/// ));
/// # Ok::<(), landscape::study::StudyError>(())
/// ```
pub fn compare_diversity(
    sets: &[DiversitySet],
    settings: &DiversitySettings,
) -> Result<DiversityComparison, StudyError> {
    check_set_sizes(sets.iter().map(|set| (set.name.as_str(), set.grasps)))?;
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
        notes.extend(single_kinds(sets, &counts, of));
    }
    for measure in &mut measures {
        measure.most = std::array::from_fn(|order| measure.above_all(order));
    }
    let mut comparison = DiversityComparison {
        names: sets.iter().map(|set| set.name.clone()).collect(),
        grasps: sets.iter().map(|set| set.grasps).collect(),
        measures,
        notes,
        settings: *settings,
    };
    comparison.tell_limits(sets);
    comparison.refuse_other_levels(sets);
    let mut told = BTreeSet::new();
    comparison.notes.retain(|note| told.insert(note.clone()));
    Ok(comparison)
}

/// Notes on sets that show one kind only, whose intervals have no width.
fn single_kinds(
    sets: &[DiversitySet],
    counts: &[Option<Vec<usize>>],
    of: Counted,
) -> Option<String> {
    let single = sets.iter().zip(counts).find_map(|(set, counts)| {
        let [grasps] = counts.as_deref()? else {
            return None;
        };
        Some((set, *grasps))
    });
    // With 95 % confidence, a share that n draws miss is at most 3/n.
    let (set, grasps) = single?;
    Some(format!(
        "all {grasps} grasps of {} are of one kind by {}, so its interval has no width; up to {:.0} % of its \
         source may be of other kinds",
        set.name,
        of.name(),
        300.0 / grasps as f64
    ))
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
    let counts: Vec<Option<&[usize]>> = counts.iter().map(Option::as_deref).collect();
    let (sets, ratios) = numbers(&counts, grasps, settings);
    Some(Measure {
        of,
        grasps,
        sets,
        ratios,
        most: [None; 3],
    })
}

/// The effective numbers of sets in samples of `grasps` grasps, and the ratios of each two of them.
fn numbers(
    counts: &[Option<&[usize]>],
    grasps: usize,
    settings: &DiversitySettings,
) -> (Vec<Option<[Estimated; 3]>>, Vec<RatioOfSets>) {
    let of =
        |counts: &[usize]| HillNumbers::of(counts, grasps, settings.resamplings, settings.seed);
    let all: Vec<Option<HillNumbers>> = counts.iter().map(|counts| counts.map(of)).collect();
    let known =
        || (all.iter().enumerate()).filter_map(|(set, numbers)| Some((set, numbers.as_ref()?)));
    let ratios = known().flat_map(|(set, numbers)| {
        let later = known().filter(move |(other, _)| *other > set);
        later.map(move |(other, beside)| RatioOfSets {
            sets: [set, other],
            orders: numbers.ratios_to(beside),
        })
    });
    let ratios = ratios.collect();
    let estimates = |numbers: &Option<HillNumbers>| numbers.as_ref().map(HillNumbers::estimates);
    (all.iter().map(estimates).collect(), ratios)
}

/// Compares the families at other levels as well: intervals then span those of all levels.
fn span_other_levels(measure: &mut Measure, sets: &[DiversitySet], settings: &DiversitySettings) {
    let own = sets.iter().zip(&measure.sets);
    let own: Vec<Option<Vec<usize>>> = own
        .map(|(set, known)| {
            let families = set.counts[Counted::Families as usize].as_ref().ok();
            let families = families.filter(|_| known.is_some())?;
            Some(families.values().copied().collect())
        })
        .collect();
    for level in 0..OTHER_LEVELS.len() {
        let at_level = |(set, own): (&DiversitySet, &Option<Vec<usize>>)| {
            let other = set.families_at_other_levels.get(level);
            own.as_ref().map(|own| other.unwrap_or(own).clone())
        };
        let counts: Vec<Option<Vec<usize>>> = sets.iter().zip(&own).map(at_level).collect();
        let counts: Vec<Option<&[usize]>> = counts.iter().map(Option::as_deref).collect();
        let (here, ratios) = numbers(&counts, measure.grasps, settings);
        let shown = measure.sets.iter_mut().flatten();
        for (spanned, here) in shown.zip(here.iter().flatten()) {
            for (number, other) in spanned.iter_mut().zip(here) {
                span(&mut number.interval, other.interval);
            }
        }
        for (spanned, here) in measure.ratios.iter_mut().zip(&ratios) {
            for (ratio, other) in spanned.orders.iter_mut().zip(&here.orders) {
                ratio.span(other);
            }
        }
    }
}

/// Widens an interval so that it holds another one.
fn span(interval: &mut [f64; 2], other: [f64; 2]) {
    *interval = [interval[0].min(other[0]), interval[1].max(other[1])];
}

impl Measure {
    /// The ratios of two sets at order 0, 1 and 2; `None` if one of them does not have this measure.
    pub fn ratio(&self, sets: [usize; 2]) -> Option<[Ratio; 3]> {
        let [one, other] = sets;
        let of = |sets: [usize; 2]| self.ratios.iter().find(|ratio| ratio.sets == sets);
        let turned = || Some(of([other, one])?.orders.map(|ratio| ratio.inverse()));
        of(sets).map(|ratio| ratio.orders).or_else(turned)
    }

    /// The sets that have this measure.
    fn known(&self) -> impl Iterator<Item = usize> {
        let sets = self.sets.iter().enumerate();
        sets.filter_map(|(set, numbers)| numbers.map(|_| set))
    }

    /// The set whose ratio to each other set has an interval above 1.
    fn above_all(&self, order: usize) -> Option<usize> {
        let above = |set: usize, other: usize| {
            let ratio = self.ratio([set, other]);
            ratio.is_some_and(|orders| orders[order].interval[0] > 1.0)
        };
        let mut sets = self.known().filter(|_| !self.ratios.is_empty());
        sets.find(|set| {
            self.known()
                .all(|other| other == *set || above(*set, other))
        })
    }
}

impl DiversitySet {
    /// A set with known numbers of one thing, by name, and without any other.
    pub fn counted(name: &str, of: Counted, counts: BTreeMap<String, usize>) -> Self {
        let grasps = counts.values().sum();
        let mut set = Self {
            name: name.to_owned(),
            grasps,
            hands: Vec::new(),
            counts: Counted::ALL.map(|of| Err(format!("the {} of {name} are unknown", of.name()))),
            level: None,
            families_at_other_levels: Vec::new(),
        };
        set.counts[of as usize] = Ok(counts);
        set
    }
}

/// The hand for which the rule of types was made.
const HUMAN: &str = "human";

impl DiversityComparison {
    /// Adds what the numbers of all sets leave open.
    fn tell_limits(&mut self, sets: &[DiversitySet]) {
        let measured =
            |of: &[Counted]| self.measures.iter().any(|measure| of.contains(&measure.of));
        let spanned = sets
            .iter()
            .any(|set| !set.families_at_other_levels.is_empty());
        let robots = sets.iter().flat_map(|set| &set.hands);
        let robots: BTreeSet<&str> = robots
            .map(String::as_str)
            .filter(|name| *name != HUMAN)
            .collect();
        let mut notes = Vec::new();
        if measured(&[Counted::Families]) && spanned {
            notes.push(
                "families are compared at half and at twice their level, too, so that the height of a single pass decides \
                 nothing; their intervals span those of the three levels"
                    .to_owned(),
            );
        }
        if measured(&[Counted::Types, Counted::Cells]) && !robots.is_empty() {
            notes.push(format!(
                "types and cells of {} are by a rule that was made for the human hand: they say which human grasp the pose is \
                 most like",
                Vec::from_iter(robots).join(", ")
            ));
        }
        if sets.len() > 1 && sets.iter().any(|set| !set.hands.is_empty()) {
            notes.push(
                "each set also depends on how its grasps were drawn (sampler, settings, filter) and on one seed, not on hand and \
                 object alone; repeat the comparison with sets of other seeds"
                    .to_owned(),
            );
        }
        self.notes.append(&mut notes);
    }

    /// Families at different levels are shown, but none of them is called more diverse.
    fn refuse_other_levels(&mut self, sets: &[DiversitySet]) {
        let levels: Vec<(&str, &FamilyLevel)> = (sets.iter())
            .filter_map(|set| Some((set.name.as_str(), set.level.as_ref()?)))
            .collect();
        let Some((first, others)) = levels.split_first() else {
            return;
        };
        let mut differences = others
            .iter()
            .filter_map(|other| FamilyLevel::difference(*first, *other));
        let Some(note) = differences.next() else {
            return;
        };
        self.notes.insert(0, note);
        for measure in &mut self.measures {
            if measure.of == Counted::Families {
                measure.most = [None; 3];
                measure.ratios.clear();
            }
        }
    }
}

#[cfg(test)]
mod tests;
