//! Significance tests: permutation within blocks, correction for many hypotheses, uncertain labels, and bootstrap.

use rand::RngExt;
use rand::seq::SliceRandom;
use rayon::prelude::*;

use crate::sample::{Rng, Task, stream};

/// Settings of permutation tests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Permutations {
    /// Number of permutations n; p is at least 1/(n + 1).
    pub count: usize,
    /// Seed; permutation i draws from stream i.
    pub seed: u64,
    /// Smallest number of cases per class for a test.
    pub least_per_class: usize,
}

impl Default for Permutations {
    fn default() -> Self {
        Self {
            count: 9999,
            seed: 0,
            least_per_class: 5,
        }
    }
}

/// A statistic and its significance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tested {
    /// The statistic of the original labels.
    pub statistic: f64,
    /// p = (1 + #{permuted ≥ observed})/(1 + n), one-sided; Phipson and Smyth, Stat. Appl. Genet. Mol. Biol. 9, 39 (2010).
    pub p: f64,
    /// Mean under permutation, which is the chance level.
    pub chance: f64,
    /// Standard deviation under permutation.
    pub deviation: f64,
}

/// Outcome of a test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome<T> {
    /// A result.
    Known(T),
    /// A class is too small for a test.
    Insufficient {
        /// The smallest class.
        class: usize,
        /// Its number of cases.
        cases: usize,
        /// Number of cases needed.
        needed: usize,
    },
}

impl<T> Outcome<T> {
    /// The result, if there is one.
    pub fn known(self) -> Option<T> {
        match self {
            Self::Known(answer) => Some(answer),
            Self::Insufficient { .. } => None,
        }
    }
}

/// Number of cases in each class 0 … of `labels`.
pub(super) fn sizes(labels: &[usize]) -> Vec<usize> {
    let mut sizes = vec![0; labels.iter().max().map_or(0, |most| most + 1)];
    for &label in labels {
        sizes[label] += 1;
    }
    sizes
}

/// Tests a statistic that is large if labels agree with something, by permuting labels among the cases of a block.
///
/// `statistic` must contain every step that led to its value, including a choice of the best of several cuts. Permuted
/// values count as reaching the observed one if they equal it up to rounding (10⁻¹²) or are NaN. Classes without cases are
/// ignored; a single class is insufficient.
///
/// # Panics
/// If there is not one block per label.
///
/// # Examples
/// Whether labels go with heights: ANOSIM's R with its p-value by permutation.
///
/// ```
/// use landscape::agreement::{PairMatrix, Permutations, anosim_of_ranks, test_labels};
///
/// let ranks = PairMatrix::from_fn(12, |i, j| if i / 6 == j / 6 { 1.0 } else { 2.0 }).ranks();
/// let labels: Vec<usize> = (0..12).map(|case| case / 6).collect();
/// let settings = Permutations { count: 999, ..Permutations::default() };
/// let tested = test_labels(&labels, &[0; 12], &settings, |labels| {
///     anosim_of_ranks(&ranks, labels)
/// });
/// let tested = tested.known().ok_or("a class is too small")?;
/// assert!(tested.statistic > 0.99 && tested.p < 0.01);
/// # Ok::<(), &str>(())
/// ```
pub fn test_labels(
    labels: &[usize],
    blocks: &[usize],
    settings: &Permutations,
    statistic: impl Fn(&[usize]) -> f64 + Sync,
) -> Outcome<Tested> {
    let sizes = sizes(labels);
    let occurring = || sizes.iter().enumerate().filter(|(_, cases)| **cases > 0);
    let smallest = occurring().min_by_key(|(_, cases)| **cases);
    let (class, cases) = smallest.map_or((0, 0), |(class, &cases)| (class, cases));
    if cases < settings.least_per_class || occurring().count() < 2 {
        return Outcome::Insufficient {
            class,
            cases,
            needed: settings.least_per_class,
        };
    }
    Outcome::Known(test_order(labels.len(), blocks, settings, |order| {
        let permuted: Vec<usize> = order.iter().map(|&i| labels[i]).collect();
        statistic(&permuted)
    }))
}

/// As [`test_labels`], for a statistic of the order of the cases. The original order is 0, 1, 2, …
///
/// # Panics
/// If there is not one block per case.
pub fn test_order(
    cases: usize,
    blocks: &[usize],
    settings: &Permutations,
    statistic: impl Fn(&[usize]) -> f64 + Sync,
) -> Tested {
    assert_eq!(blocks.len(), cases, "one block a case");
    let plain: Vec<usize> = (0..cases).collect();
    let observed = statistic(&plain);
    let members = members(blocks);
    let permuted: Vec<f64> = (0..settings.count as u64)
        .into_par_iter()
        .map(|i| {
            let mut rng = stream(settings.seed, Task::Permutation, i);
            statistic(&permuted_within(&members, cases, &mut rng))
        })
        .collect();
    let reach = observed - 1e-12 * (1.0 + observed.abs());
    let reached = permuted
        .iter()
        .filter(|value| value.is_nan() || **value >= reach);
    let reached = reached.count();
    let n = permuted.len() as f64;
    let chance = permuted.iter().sum::<f64>() / n;
    let squares = permuted.iter().map(|value| (value - chance).powi(2));
    Tested {
        statistic: observed,
        p: if observed.is_nan() {
            f64::NAN
        } else {
            (1.0 + reached as f64) / (1.0 + n)
        },
        chance,
        deviation: (squares.sum::<f64>() / (n - 1.0)).sqrt(),
    }
}

/// The cases of each block, by the number of the block.
fn members(blocks: &[usize]) -> Vec<Vec<usize>> {
    let mut members = vec![Vec::new(); blocks.iter().max().map_or(0, |most| most + 1)];
    for (case, &block) in blocks.iter().enumerate() {
        members[block].push(case);
    }
    members
}

fn permuted_within(members: &[Vec<usize>], cases: usize, rng: &mut Rng) -> Vec<usize> {
    let mut order: Vec<usize> = (0..cases).collect();
    for own in members {
        let mut shuffled = own.clone();
        shuffled.shuffle(rng);
        for (&place, &case) in own.iter().zip(&shuffled) {
            order[place] = case;
        }
    }
    order
}

/// Corrects p-values of several hypotheses, so that the probability of any false rejection stays at the level: S. Holm,
/// Scand. J. Stat. 6, 65 (1979).
///
/// ```text
/// p̃₍ᵢ₎ = maxⱼ≤ᵢ min(1, (m − j + 1) p₍ⱼ₎)
/// ```
///
/// NaN (not tested) stays NaN and is not counted in m.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).filter(|&i| !p[i].is_nan()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut adjusted = vec![f64::NAN; p.len()];
    let mut highest = 0.0_f64;
    for (place, &i) in order.iter().enumerate() {
        highest = highest.max(((order.len() - place) as f64 * p[i]).min(1.0));
        adjusted[i] = highest;
    }
    adjusted
}

/// A statistic under resampling.
#[derive(Debug, Clone, PartialEq)]
pub struct Resampled {
    /// Its values in ascending order, without NaN.
    pub values: Vec<f64>,
    /// Number of NaN values.
    pub undefined: usize,
}

impl Resampled {
    pub(crate) fn new(all: Vec<f64>) -> Self {
        let count = all.len();
        let mut values = all;
        values.retain(|value| !value.is_nan());
        values.sort_by(f64::total_cmp);
        Self {
            undefined: count - values.len(),
            values,
        }
    }

    /// The value below which `share` of the values lie, linear between neighbours; NaN without values.
    pub fn quantile(&self, share: f64) -> f64 {
        let Some(last) = self.values.len().checked_sub(1) else {
            return f64::NAN;
        };
        let place = share.clamp(0.0, 1.0) * last as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the number of values"
        )]
        let low = place.floor() as usize;
        let high = (low + 1).min(last);
        self.values[low] + (place - low as f64) * (self.values[high] - self.values[low])
    }

    /// The interval that contains the middle `share` of the values, usually 0.95.
    pub fn interval(&self, share: f64) -> [f64; 2] {
        [0.5 - 0.5 * share, 0.5 + 0.5 * share].map(|at| self.quantile(at))
    }
}

/// Bootstrap over cases: `statistic` of `draws` lists of cases drawn with replacement, where each block keeps its size.
///
/// B. Efron, Ann. Stat. 7, 1 (1979), percentiles. Pairs of a case with itself carry no information: see
/// [`PairMatrix::chosen`](super::PairMatrix::chosen).
pub fn bootstrap(
    blocks: &[usize],
    draws: usize,
    seed: u64,
    statistic: impl Fn(&[usize]) -> f64 + Sync,
) -> Resampled {
    let members = members(blocks);
    let values = (0..draws as u64).into_par_iter().map(|i| {
        // Numbers of tasks that differ from those of permutations under the same seed.
        let mut rng = stream(seed, Task::Permutation, (1 << 62) + i);
        let mut cases = Vec::with_capacity(blocks.len());
        for own in members.iter().filter(|own| !own.is_empty()) {
            cases.extend(own.iter().map(|_| own[rng.random_range(0..own.len())]));
        }
        statistic(&cases)
    });
    Resampled::new(values.collect())
}

/// Statistics and p-values over labels drawn from their probabilities.
#[derive(Debug, Clone, PartialEq)]
pub struct UnderUncertainty {
    /// The statistic.
    pub statistic: Resampled,
    /// Its p-value.
    pub p: Resampled,
    /// Number of draws in which a class was too small.
    pub insufficient: usize,
}

/// Draws labels `draws` times and tests each draw. The label of a case comes from `probabilities[case]` (weight of each
/// class, scaled to sum 1).
///
/// # Panics
/// If a case has no positive weight, or there is not one block per case.
pub fn test_uncertain_labels(
    probabilities: &[Vec<f64>],
    blocks: &[usize],
    draws: usize,
    settings: &Permutations,
    statistic: impl Fn(&[usize]) -> f64 + Sync,
) -> UnderUncertainty {
    let (mut statistics, mut p_values) = (Vec::new(), Vec::new());
    for draw in 0..draws as u64 {
        let mut rng = stream(settings.seed, Task::Permutation, (1 << 63) + draw);
        let labels: Vec<usize> = probabilities
            .iter()
            .map(|own| drawn(own, &mut rng))
            .collect();
        if let Outcome::Known(tested) = test_labels(&labels, blocks, settings, &statistic) {
            statistics.push(tested.statistic);
            p_values.push(tested.p);
        }
    }
    UnderUncertainty {
        insufficient: draws - statistics.len(),
        statistic: Resampled::new(statistics),
        p: Resampled::new(p_values),
    }
}

fn drawn(weights: &[f64], rng: &mut Rng) -> usize {
    let total: f64 = weights.iter().sum();
    assert!(total > 0.0, "a case has some class");
    let mut left = total * rng.random::<f64>();
    for (class, weight) in weights.iter().enumerate() {
        left -= weight;
        if left < 0.0 {
            return class;
        }
    }
    // Rounding may leave no class; then the last possible class is taken.
    weights
        .iter()
        .rposition(|weight| *weight > 0.0)
        .unwrap_or(0)
}
