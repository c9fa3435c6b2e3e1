//! Measures of sets of grasps as publications define them, with intervals.
//!
//! [`MeasuredSet::of`] measures each grasp of a file once ([`GraspFacts`]). Every [`Measure`] is then a function of a choice
//! of grasps, with repetition, so that resampling costs little. Where a publication and its code differ, both are measures.
//! Families need a landscape: `study::compare_diversity` counts them. `docs/measures.md` explains the measures.

mod catalogue;
mod distinct;
mod facts;
mod kernel;
mod prepared;
mod spread;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use rayon::prelude::*;
use serde::Serialize;

pub use catalogue::{Better, Measure};
pub use distinct::DISTINCT_M;
pub use facts::{GraspFacts, MeasuredObject, MeasuredSet};
pub use kernel::KERNEL_LENGTH_M;
pub use prepared::MOST_COMPARED;

use prepared::{Count, Prepared};

/// Standard deviations of a 95 % interval.
const QUANTILE: f64 = 1.959_963_984_540_054;

/// Number of seeded subsamples over which a measure at a smaller size is averaged.
const SUBSAMPLES: u64 = 20;

/// How intervals are found, and the size to which objects are reduced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Resampling {
    /// Number of resamplings; no intervals below two.
    pub count: usize,
    /// Seed of every random draw.
    pub seed: u64,
    /// Measures each object by so many of its grasps: the mean over twenty seeded subsamples. Objects with fewer are left
    /// out. `None` measures all.
    pub at: Option<usize>,
}

impl Default for Resampling {
    fn default() -> Self {
        Self {
            count: 200,
            seed: 0,
            at: None,
        }
    }
}

/// A measure of a set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measured {
    /// The measure.
    pub measure: Measure,
    /// Its value, in [`Measure::unit`]; `None` if it is not known.
    pub value: Option<f64>,
    /// Its 95 % interval: ±1.96 standard deviations over the resamplings, cut to the values that the measure may have.
    pub interval: Option<[f64; 2]>,
    /// Whether only the grasps that hold count: [`Measure::of_held`], if it is known which do.
    pub of_held: bool,
    /// Number of grasps that count.
    pub grasps: usize,
    /// Number of objects that count.
    pub objects: usize,
    /// Why there is no value: a clause.
    pub reason: Option<String>,
}

/// Measures a set of grasps; `held` are the ids of the grasps that hold, if that is known.
///
/// Measures of single grasps, standard deviations over all objects, the principal component and the effective numbers of
/// kinds take all grasps together. All others are means over the objects; an object without grasps that hold has 0 unique and
/// distinct grasps, and is left out otherwise.
///
/// A resampling draws as many objects as there are, with replacement, and as many grasps of each as it has. Resamplings
/// repeat grasps, so that counts of different grasps are smaller in them: only their scatter is used, about the value. With
/// a single object, the interval is for grasps of this object.
///
/// The result does not depend on the number of threads.
pub fn measure(
    set: &MeasuredSet,
    held: Option<&BTreeSet<u64>>,
    measures: &[Measure],
    resampling: &Resampling,
) -> Vec<Measured> {
    let prepared = Prepared::of(set, held, measures, resampling.seed);
    let at = resampling.at;
    let draw = |number: u64| -> Vec<Option<f64>> {
        let drawn =
            [false, true].map(|of_held| prepared.drawn(of_held, at, resampling.seed, number));
        let of = |measure: &Measure| {
            let counted = prepared.count(*measure, &drawn[usize::from(measure.of_held())]);
            counted.map(|count| count.value)
        };
        measures.iter().map(of).collect()
    };
    let draws: Vec<Vec<Option<f64>>> = (0..resampling.count as u64)
        .into_par_iter()
        .map(draw)
        .collect();
    let of = |(place, measure): (usize, &Measure)| {
        let known = prepared.obstacle(*measure, at).map_or_else(
            || {
                let none = || Prepared::nothing(*measure).to_owned();
                whole(&prepared, *measure, resampling).ok_or_else(none)
            },
            Err,
        );
        let of_held = measure.of_held() && held.is_some();
        match known {
            Ok(count) => {
                let drawn: Vec<f64> = draws.iter().filter_map(|draw| draw[place]).collect();
                Measured {
                    measure: *measure,
                    value: Some(count.value),
                    interval: (count.grasps > 1)
                        .then(|| interval(*measure, count.value, &drawn))
                        .flatten(),
                    of_held,
                    grasps: count.grasps,
                    objects: count.objects,
                    reason: None,
                }
            }
            Err(reason) => Measured {
                measure: *measure,
                value: None,
                interval: None,
                of_held,
                grasps: 0,
                objects: 0,
                reason: Some(reason),
            },
        }
    };
    measures.iter().enumerate().map(of).collect()
}

/// The measure of all grasps, or the mean over subsamples.
fn whole(prepared: &Prepared<'_>, measure: Measure, resampling: &Resampling) -> Option<Count> {
    let of_held = measure.of_held();
    let Some(at) = resampling.at else {
        return prepared.count(measure, &prepared.all(of_held));
    };
    let sample = |number: u64| {
        let chosen = prepared.subsample(of_held, at, resampling.seed, number);
        prepared.count(measure, &chosen)
    };
    let samples: Vec<Option<Count>> = (0..SUBSAMPLES).into_par_iter().map(sample).collect();
    let known: Vec<Count> = samples.into_iter().flatten().collect();
    let first = *known.first()?;
    let sum: f64 = known.iter().map(|count| count.value).sum();
    Some(Count {
        value: sum / known.len() as f64,
        ..first
    })
}

/// The interval about a value; `None` with fewer than two resamplings.
fn interval(measure: Measure, value: f64, drawn: &[f64]) -> Option<[f64; 2]> {
    if drawn.len() < 2 {
        return None;
    }
    let mean = drawn.iter().sum::<f64>() / drawn.len() as f64;
    let squares: f64 = drawn.iter().map(|drawn| (drawn - mean).powi(2)).sum();
    let half = QUANTILE * (squares / (drawn.len() - 1) as f64).sqrt();
    let [least, most] = measure.range();
    Some([(value - half).max(least), (value + half).min(most)])
}
