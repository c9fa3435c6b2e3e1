//! A second learner, with other facts and of another kind: extremely randomised trees on how near each bone is and on the
//! angles of the joints.
//!
//! P. Geurts, D. Ernst, L. Wehenkel, Machine Learning 63, 3 (2006). Each grasp is named by trees that have seen no grasp of
//! the same object. Categories, cells and types have trees of their own.

use std::collections::{BTreeMap, BTreeSet};

use landscape::sample::{Rng, Task, stream};
use rand::RngExt;
use rayon::prelude::*;

use crate::case::{Case, Measure};
use crate::contact::NEAR_MM;

const TREES: u64 = 400;
const SEED: u64 = 25;
/// Distances beyond these say nothing more, mm.
const NEAREST_MM: f64 = -10.0;
const FARTHEST_MM: f64 = 20.0;

/// Grasps with their classes.
struct Sample {
    rows: Vec<Vec<f64>>,
    classes: Vec<usize>,
    /// Number of classes.
    count: usize,
}

enum Tree {
    /// The share of each class.
    Leaf(Vec<f64>),
    Split {
        feature: usize,
        threshold: f64,
        below: Box<Self>,
        above: Box<Self>,
    },
}

fn features(case: &Case) -> Vec<f64> {
    let gaps = &case.contact.bones_mm;
    let clamped = gaps.iter().map(|gap| gap.clamp(NEAREST_MM, FARTHEST_MM));
    let near = gaps.iter().map(|gap| f64::from(u8::from(*gap < NEAR_MM)));
    clamped
        .chain(near)
        .chain(case.x[7..].iter().copied())
        .collect()
}

/// Sum over the classes of the squares of their numbers, divided by the number of grasps: the larger, the purer.
fn purity(sample: &Sample, own: &[usize]) -> f64 {
    let squares: f64 = counts(sample, own).iter().map(|n| n * n).sum();
    squares / own.len().max(1) as f64
}

fn counts(sample: &Sample, own: &[usize]) -> Vec<f64> {
    let mut counts = vec![0.0; sample.count];
    for &row in own {
        counts[sample.classes[row]] += 1.0;
    }
    counts
}

impl Tree {
    /// Splits at random thresholds of random features until the classes are pure.
    fn grow(sample: &Sample, own: &[usize], rng: &mut Rng) -> Self {
        let counts = counts(sample, own);
        let leaf = || Self::Leaf(counts.iter().map(|n| n / own.len() as f64).collect());
        if counts.iter().filter(|n| **n > 0.0).count() < 2 {
            return leaf();
        }
        let mut features: Vec<usize> = (0..sample.rows[0].len()).collect();
        let mut left = features.len().isqrt();
        let mut best: Option<(f64, usize, f64)> = None;
        while left > 0 && !features.is_empty() {
            let feature = features.swap_remove(rng.random_range(0..features.len()));
            let values = || own.iter().map(|row| sample.rows[*row][feature]);
            let low = values().fold(f64::INFINITY, f64::min);
            let high = values().fold(f64::NEG_INFINITY, f64::max);
            if high - low < 1e-7 {
                continue;
            }
            left -= 1;
            let threshold = rng.random_range(low..high);
            let [below, above] = parted(sample, own, feature, threshold);
            let pure = purity(sample, &below) + purity(sample, &above);
            if best.is_none_or(|(most, ..)| pure > most) {
                best = Some((pure, feature, threshold));
            }
        }
        let Some((_, feature, threshold)) = best else {
            return leaf();
        };
        let [below, above] = parted(sample, own, feature, threshold)
            .map(|part| Box::new(Self::grow(sample, &part, rng)));
        Self::Split {
            feature,
            threshold,
            below,
            above,
        }
    }

    fn told(&self, row: &[f64]) -> &[f64] {
        match self {
            Self::Leaf(shares) => shares,
            Self::Split {
                feature,
                threshold,
                below,
                above,
            } => {
                let side = if row[*feature] <= *threshold {
                    below
                } else {
                    above
                };
                side.told(row)
            }
        }
    }
}

fn parted(sample: &Sample, own: &[usize], feature: usize, threshold: f64) -> [Vec<usize>; 2] {
    let (below, above) = own
        .iter()
        .partition(|row| sample.rows[**row][feature] <= threshold);
    [below, above]
}

/// Whether each case is named right in this respect by trees of all other objects; `None` for a measure without classes.
pub(crate) fn leave_one_object_out(cases: &[&Case], measure: Measure) -> Option<Vec<bool>> {
    let names: Option<Vec<String>> = cases.iter().map(|case| measure.class(case.truth)).collect();
    let names = names?;
    let places: BTreeMap<&String, usize> = names
        .iter()
        .collect::<BTreeSet<_>>()
        .into_iter()
        .zip(0..)
        .collect();
    let sample = Sample {
        rows: cases.iter().map(|case| features(case)).collect(),
        classes: names.iter().map(|name| places[name]).collect(),
        count: places.len(),
    };
    let objects: BTreeSet<&str> = cases.iter().map(|case| case.object.as_str()).collect();
    let objects: Vec<&str> = objects.into_iter().collect();
    let of_object = |(place, object): (usize, &&str)| {
        let (own, others): (Vec<usize>, Vec<usize>) =
            (0..cases.len()).partition(|&i| cases[i].object == **object);
        let mut sums = vec![vec![0.0; sample.count]; own.len()];
        for tree in 0..TREES {
            let id = tree + TREES * (place as u64 + 1000 * measure as u64);
            let grown = Tree::grow(&sample, &others, &mut stream(SEED, Task::Permutation, id));
            for (sum, &row) in sums.iter_mut().zip(&own) {
                let told = grown.told(&sample.rows[row]);
                sum.iter_mut().zip(told).for_each(|(sum, p)| *sum += p);
            }
        }
        let right = own.iter().zip(&sums).map(|(&row, sum)| {
            // The first of equal classes.
            let most = sum.iter().copied().fold(0.0, f64::max);
            let best = sum.iter().position(|p| *p >= most);
            (row, best == Some(sample.classes[row]))
        });
        right.collect::<Vec<_>>()
    };
    let mut right = vec![false; cases.len()];
    let told: Vec<Vec<(usize, bool)>> = objects.par_iter().enumerate().map(of_object).collect();
    for (row, own) in told.into_iter().flatten() {
        right[row] = own;
    }
    Some(right)
}
