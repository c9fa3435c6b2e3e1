//! Measures of choices of grasps.

use std::collections::{BTreeMap, BTreeSet};

use rand::RngExt;
use rand::seq::SliceRandom;

use super::catalogue::Measure;
use super::distinct::{Sameness, unique_ordered, unique_published};
use super::facts::{GraspFacts, MeasuredObject, MeasuredSet};
use super::kernel::Kernel;
use super::spread;
use crate::agreement::rarefied_hill_numbers;
use crate::sample::{Rng, Task, stream};

/// Most grasps of an object that the Vendi score compares, a seeded subsample.
pub const MOST_COMPARED: usize = 500;

/// Numbers of the first random streams of resamplings, of subsamples, and of the choice of [`MOST_COMPARED`]; those of Hill
/// numbers are below.
const RESAMPLINGS: u64 = 2 << 32;
const SUBSAMPLES: u64 = 3 << 32;
const COMPARED: u64 = 4 << 32;

/// Grasps of one object, with repetition.
pub(super) struct Chosen {
    object: usize,
    grasps: Vec<usize>,
}

/// A value, and the numbers of grasps and objects that it is of.
#[derive(Clone, Copy)]
pub(super) struct Count {
    pub(super) value: f64,
    pub(super) grasps: usize,
    pub(super) objects: usize,
}

/// A set, with what the measures of any choice of its grasps need.
pub(super) struct Prepared<'a> {
    objects: Vec<PreparedObject<'a>>,
    several_hands: bool,
}

struct PreparedObject<'a> {
    object: &'a MeasuredObject,
    /// All grasps, and those that hold (all, if that is not known).
    pools: [Vec<usize>; 2],
    held: Vec<bool>,
    in_metric: Option<Sameness>,
    in_cells: Option<Sameness>,
    kernel: Option<Kernel>,
}

impl<'a> Prepared<'a> {
    pub(super) fn of(
        set: &'a MeasuredSet,
        held: Option<&BTreeSet<u64>>,
        measures: &[Measure],
        seed: u64,
    ) -> Self {
        let wanted = |measure: Measure| measures.contains(&measure);
        let prepare = |(number, object): (usize, &'a MeasuredObject)| {
            let holds = |facts: &GraspFacts| held.is_none_or(|held| held.contains(&facts.id));
            let held: Vec<bool> = object.grasps.iter().map(holds).collect();
            let all: Vec<usize> = (0..held.len()).collect();
            let holding: Vec<usize> = all.iter().copied().filter(|grasp| held[*grasp]).collect();
            let mut compared = holding.clone();
            if compared.len() > MOST_COMPARED {
                compared.shuffle(&mut stream(seed, Task::Diversity, COMPARED + number as u64));
                compared.truncate(MOST_COMPARED);
                compared.sort_unstable();
            }
            PreparedObject {
                object,
                pools: [all, holding],
                held,
                in_metric: wanted(Measure::Distinct).then(|| Sameness::in_metric(object)),
                in_cells: wanted(Measure::UniqueMended).then(|| Sameness::in_cells(object)),
                kernel: wanted(Measure::Vendi).then(|| Kernel::of(object, &compared)),
            }
        };
        let hands: BTreeSet<&str> = (set.objects.iter())
            .map(|object| object.hand.name.as_str())
            .collect();
        Self {
            objects: set.objects.iter().enumerate().map(prepare).collect(),
            several_hands: hands.len() > 1,
        }
    }

    /// All grasps, or all that hold.
    pub(super) fn all(&self, of_held: bool) -> Vec<Chosen> {
        let chosen = |(object, prepared): (usize, &PreparedObject<'_>)| Chosen {
            object,
            grasps: prepared.pools[usize::from(of_held)].clone(),
        };
        self.objects.iter().enumerate().map(chosen).collect()
    }

    /// The objects with at least so many grasps.
    fn able(&self, of_held: bool, at: Option<usize>) -> Vec<usize> {
        let enough = |object: &usize| {
            let pool = &self.objects[*object].pools[usize::from(of_held)];
            at.is_none_or(|at| pool.len() >= at)
        };
        (0..self.objects.len()).filter(enough).collect()
    }

    /// Subsample `number`: `at` different grasps of each object that has as many.
    pub(super) fn subsample(
        &self,
        of_held: bool,
        at: usize,
        seed: u64,
        number: u64,
    ) -> Vec<Chosen> {
        let mut rng = stream(seed, Task::Diversity, SUBSAMPLES + number);
        let chosen = |object: usize| {
            let mut grasps = self.objects[object].pools[usize::from(of_held)].clone();
            grasps.shuffle(&mut rng);
            grasps.truncate(at);
            Chosen { object, grasps }
        };
        let able = self.able(of_held, Some(at));
        able.into_iter().map(chosen).collect()
    }

    /// Resampling `number`: objects with replacement, then grasps of each with replacement. Of grasps that hold there are as
    /// many as chance draws, unless their number `at` is given.
    pub(super) fn drawn(
        &self,
        of_held: bool,
        at: Option<usize>,
        seed: u64,
        number: u64,
    ) -> Vec<Chosen> {
        let mut rng = stream(seed, Task::Diversity, RESAMPLINGS + number);
        let able = self.able(of_held, at);
        let mut chosen = Vec::with_capacity(able.len());
        for _ in 0..able.len() {
            let object = able[rng.random_range(0..able.len())];
            let prepared = &self.objects[object];
            let pool = &prepared.pools[usize::from(of_held && at.is_some())];
            let mut grasps = drawn_from(pool, at.unwrap_or(pool.len()), &mut rng);
            grasps.retain(|grasp| !of_held || prepared.held[*grasp]);
            chosen.push(Chosen { object, grasps });
        }
        chosen
    }

    /// Why a measure of this set has no value, if that is known before it is measured.
    pub(super) fn obstacle(&self, measure: Measure, at: Option<usize>) -> Option<String> {
        let of_held = measure.of_held();
        let pools = || {
            let able = self.able(of_held, at);
            able.into_iter()
                .map(|object| &self.objects[object].pools[usize::from(of_held)])
        };
        let counts = matches!(
            measure,
            Measure::UniquePublished
                | Measure::UniqueOrdered
                | Measure::UniqueMended
                | Measure::Distinct
        );
        if let Some(at) = at.filter(|_| pools().next().is_none()) {
            let what = if of_held { " that hold" } else { "" };
            return Some(format!("no object has {at} grasps{what}"));
        }
        if self.several_hands
            && matches!(
                measure,
                Measure::JointDeviation | Measure::PooledDeviation | Measure::Pca
            )
        {
            return Some(
                "the grasps are of several hands, whose joints cannot be pooled; measure each hand by itself".to_owned(),
            );
        }
        if matches!(measure, Measure::Types | Measure::Cells) {
            let hands = self
                .objects
                .iter()
                .map(|object| &object.object.inapplicable);
            if let Some(Some(why)) = hands.into_iter().find(|why| why.is_some()) {
                return Some(why.clone());
            }
        }
        if !counts && pools().all(Vec::is_empty) {
            return Some("no grasp holds".to_owned());
        }
        None
    }

    /// Why a measure of grasps without an obstacle has no value.
    pub(super) fn nothing(measure: Measure) -> &'static str {
        match measure {
            Measure::Types => "no grasp has a type",
            Measure::Cells => "no grasp has a cell of the taxonomy",
            Measure::ContactDistance | Measure::ContactConsistency => {
                "the hand has no digits beside the palm"
            }
            _ => "there are fewer than two grasps",
        }
    }

    /// The measure of a choice of grasps; `None` if it has no value.
    pub(super) fn count(&self, measure: Measure, chosen: &[Chosen]) -> Option<Count> {
        use Measure as M;
        match measure {
            M::Epsilon => self.mean(chosen, |facts| Some(facts.epsilon.max(0.0))),
            M::Q1 => self.mean(chosen, |facts| Some(facts.q1)),
            M::ValidQ1 => self.mean(chosen, |facts| Some(facts.valid_q1())),
            M::Penetration => self.mean(chosen, |facts| Some(facts.deepest_m)),
            M::DeepestPenetration => self.pooled(chosen, |all| {
                let depths = all.iter().map(|facts| facts.deepest_m);
                depths.max_by(f64::total_cmp)
            }),
            M::ContactDistance => self.mean(chosen, GraspFacts::contact_distance_m),
            M::ContactConsistency => self.mean(chosen, GraspFacts::contact_consistency_m),
            M::ContactLinks => self.mean(chosen, |facts| Some(facts.links_in_contact as f64)),
            M::Digits => self.mean(chosen, |facts| Some(facts.digits_that_touch() as f64)),
            M::JointDeviation => self.by_object(chosen, |of| spread::joint_deviation(&of.facts())),
            M::PooledDeviation => self.pooled(chosen, spread::pooled_deviation),
            M::Pca => self.pooled(chosen, spread::first_component),
            M::JointEntropy => self.by_object(chosen, |of| {
                spread::joint_entropy(of.prepared.object, &of.facts())
            }),
            M::PositionEntropy => {
                self.by_object(chosen, |of| spread::position_entropy(&of.facts()))
            }
            M::OrientationEntropy => {
                self.by_object(chosen, |of| spread::orientation_entropy(&of.facts()))
            }
            M::UniquePublished => {
                self.by_object(chosen, |of| Some(unique_published(of.each()) as f64))
            }
            M::UniqueOrdered => self.by_object(chosen, |of| Some(unique_ordered(of.each()) as f64)),
            M::UniqueMended => {
                self.by_object(chosen, |of| of.different(of.prepared.in_cells.as_ref()))
            }
            M::Distinct => {
                self.by_object(chosen, |of| of.different(of.prepared.in_metric.as_ref()))
            }
            M::Types => self.pooled(chosen, |all| kinds(all, |facts| facts.type_name.as_deref())),
            M::Cells => self.pooled(chosen, |all| kinds(all, |facts| facts.cell.as_deref())),
            M::Regions => self.pooled(chosen, |all| {
                kinds(all, |facts| Some(facts.regions.as_str()))
            }),
            M::Vendi => self.by_object(chosen, |of| of.prepared.kernel.as_ref()?.vendi(of.grasps)),
        }
    }

    fn of_object<'b>(&'b self, chosen: &'b Chosen) -> OfObject<'b> {
        OfObject {
            prepared: &self.objects[chosen.object],
            grasps: &chosen.grasps,
        }
    }

    /// Mean over all grasps.
    fn mean(&self, chosen: &[Chosen], of: impl Fn(&GraspFacts) -> Option<f64>) -> Option<Count> {
        self.pooled(chosen, |all| {
            let values: Option<Vec<f64>> = all.iter().map(|facts| of(facts)).collect();
            let values = values.filter(|values| !values.is_empty())?;
            Some(values.iter().sum::<f64>() / values.len() as f64)
        })
    }

    /// What is measured of all grasps together.
    fn pooled(
        &self,
        chosen: &[Chosen],
        of: impl Fn(&[&GraspFacts]) -> Option<f64>,
    ) -> Option<Count> {
        let all: Vec<&GraspFacts> = chosen
            .iter()
            .flat_map(|chosen| self.of_object(chosen).facts())
            .collect();
        Some(Count {
            value: of(&all)?,
            grasps: all.len(),
            objects: chosen
                .iter()
                .filter(|chosen| !chosen.grasps.is_empty())
                .count(),
        })
    }

    /// Mean over the objects that have a value.
    fn by_object(
        &self,
        chosen: &[Chosen],
        of: impl Fn(&OfObject<'_>) -> Option<f64>,
    ) -> Option<Count> {
        let known = chosen.iter().filter_map(|chosen| {
            let value = of(&self.of_object(chosen))?;
            Some((value, chosen.grasps.len()))
        });
        let known: Vec<(f64, usize)> = known.collect();
        let sum: f64 = known.iter().map(|(value, _)| value).sum();
        (!known.is_empty()).then(|| Count {
            value: sum / known.len() as f64,
            grasps: known.iter().map(|(_, grasps)| grasps).sum(),
            objects: known.len(),
        })
    }
}

/// Draws `count` of a pool with replacement.
fn drawn_from(pool: &[usize], count: usize, rng: &mut Rng) -> Vec<usize> {
    if pool.is_empty() {
        return Vec::new();
    }
    let draw = |_| pool[rng.random_range(0..pool.len())];
    (0..count).map(draw).collect()
}

/// Grasps of one object.
struct OfObject<'a> {
    prepared: &'a PreparedObject<'a>,
    grasps: &'a [usize],
}

impl<'a> OfObject<'a> {
    fn each(&self) -> impl Iterator<Item = &'a GraspFacts> {
        let all = &self.prepared.object.grasps;
        self.grasps.iter().map(move |grasp| &all[*grasp])
    }

    fn facts(&self) -> Vec<&'a GraspFacts> {
        self.each().collect()
    }

    fn different(&self, sameness: Option<&Sameness>) -> Option<f64> {
        Some(sameness?.count(self.grasps) as f64)
    }
}

/// The Hill number of order 1 of the kinds of grasps; `None` if none is of a kind.
fn kinds(all: &[&GraspFacts], kind: impl Fn(&GraspFacts) -> Option<&str>) -> Option<f64> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for kind in all.iter().filter_map(|facts| kind(facts)) {
        *counts.entry(kind).or_insert(0) += 1;
    }
    let counts: Vec<usize> = counts.into_values().collect();
    let total: usize = counts.iter().sum();
    (total > 0).then(|| rarefied_hill_numbers(&counts, total)[1])
}
