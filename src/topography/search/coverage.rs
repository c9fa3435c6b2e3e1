//! Completeness of a search, estimated from how often each saddle was met.

use serde::{Deserialize, Serialize};

use crate::topography::rarefaction::unseen;

/// Reason why completeness cannot be claimed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Doubt {
    /// The search was stopped early.
    Stopped,
    /// No saddle joins some minima to the others. Saddles are missing, unless the region is disconnected.
    Apart,
    /// Some points are not isolated (rings, troughs or plateaus), so they cannot be counted.
    Degenerate,
    /// Only the lowest part of the landscape was searched.
    Sampled,
    /// Descents ended at kinks, which are not smooth minima.
    Kinks,
    /// Descents from random points ended where the gradient does not vanish: the energy jumps there, its domain ends
    /// there, it has no lower bound, or its gradient is wrong.
    Unfinished,
}

/// Completeness of the minima and saddles of a search, estimated from how often each saddle was met.
///
/// Every minimum joined to a known one lies behind a saddle, so statements about saddles cover minima too.
///
/// `sure` and `unseen_below` assume a distribution of the rates at which saddles are met. Its lower tail is a power law,
/// fitted to the half of the saddles met least often:
///
/// ```text
/// N(λ) = k (λ/n₍ₖ₊₁₎)ᵃ,   E[unseen | a] = ∫ exp(−λ) dN = k Γ(1 + a) n₍ₖ₊₁₎⁻ᵃ
/// p(a | n) ∝ a^(k + 2) exp(−a (2 + Σ_{i ≤ k} ln(n₍ₖ₊₁₎/n₍ᵢ₎)))
/// ```
///
/// N(λ) is the number of saddles that are met less than λ times on average, n₍ᵢ₎ the number of times the i-th rarest was
/// met, and k half the number of saddles. The likelihood is that of B. M. Hill, Ann. Statist. 3, 1163 (1975). The prior of
/// a is a Γ distribution of mean 3/2; in Lennard-Jones clusters, a is about 1 to 1½. Given a, the number unseen has a
/// Poisson distribution. `analysis/completeness` measures how often such claims hold on surfaces with known saddles. A
/// saddle that is much rarer than this model expects stays unseen, and no count of hits can reveal it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// Number of searches.
    pub searches: usize,
    /// Searches that ended at a saddle without having begun beside it.
    pub arrived: usize,
    /// Number of the search that found the last new stationary point.
    pub last_new: usize,
    /// Saddles met once.
    pub once: usize,
    /// Saddles met twice.
    pub twice: usize,
    /// Saddles found only on a path between two minima.
    pub joined: usize,
    /// Descents from random points that ended in a minimum.
    pub draws: usize,
    /// Descents from random points that ended where the gradient does not vanish, other than at kinks.
    #[serde(default)]
    pub unfinished: usize,
    /// Minima in which no such descent ended; they were found by descents from saddles.
    pub undrawn: usize,
    /// Good and Turing's estimate of the probability that the next saddle found is new: once / arrived.
    pub chance_of_news: f64,
    /// Its upper 95 % limit, at most 1, with a Poisson distribution of the number met once (3 / arrived if that is 0).
    pub chance_of_news_below: f64,
    /// Chao's lower bound of the number of unseen saddles ([`Rarefaction`](crate::topography::Rarefaction)).
    pub unseen: f64,
    /// Upper 95 % limit of the number of unseen saddles; `None` if the data are too few.
    pub unseen_below: Option<usize>,
    /// Probability that no saddle, and so no minimum, is unseen; 0 if there is a doubt.
    pub sure: f64,
    /// Reason why completeness cannot be claimed, if any.
    pub doubt: Option<Doubt>,
}

pub(super) struct Counts<'a> {
    pub(super) searches: usize,
    pub(super) last_new: usize,
    pub(super) unfinished: usize,
    pub(super) hits: &'a [usize],
    /// Number of descents from random points that ended in each minimum.
    pub(super) draws: &'a [usize],
    pub(super) doubt: Option<Doubt>,
}

/// Confidence level of bounds.
const LEVEL: f64 = 0.95;
/// Prior of the exponent: shape and rate of a Γ distribution.
const PRIOR: [f64; 2] = [3.0, 2.0];
/// Grid of the exponents: number of points, and the greatest exponent, at which nothing is left unseen.
const EXPONENTS: (usize, f64) = (2000, 40.0);
/// Greatest bound of the number unseen that is reported.
const MOST_UNSEEN: usize = 1 << 20;
/// Poisson distributions with a greater mean are replaced by their mean; the spread of the means is much larger.
const NARROW: f64 = 500.0;
/// Number of hits assumed for a saddle that was never met.
const NEVER: f64 = 0.5;

impl Coverage {
    pub(super) fn new(counts: &Counts<'_>) -> Self {
        let count = |hits: usize| counts.hits.iter().filter(|h| **h == hits).count();
        let (joined, once, twice) = (count(0), count(1), count(2));
        let arrived: usize = counts.hits.iter().sum();
        // For a single minimum without saddles, the draws that ended in it are used instead.
        let law = if counts.hits.is_empty() {
            Law::new(counts.draws)
        } else {
            Law::new(counts.hits)
        };
        let sure = law.none();
        Self {
            searches: counts.searches,
            arrived,
            last_new: counts.last_new,
            once,
            twice,
            joined,
            draws: counts.draws.iter().sum(),
            unfinished: counts.unfinished,
            undrawn: counts.draws.iter().filter(|draws| **draws == 0).count(),
            chance_of_news: once as f64 / arrived.max(1) as f64,
            chance_of_news_below: (poisson_limit(once) / arrived.max(1) as f64).min(1.0),
            unseen: unseen(arrived, once, twice),
            unseen_below: law.bound(),
            sure: if counts.doubt.is_none() { sure } else { 0.0 },
            doubt: counts.doubt,
        }
    }
}

/// The greatest mean of a Poisson distribution for which at most `count` events have a probability of 5 %.
fn poisson_limit(count: usize) -> f64 {
    let (mut low, mut high) = (count as f64, 2.0 * count as f64 + 10.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if at_most(count, middle) > 1.0 - LEVEL {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Distribution of the number unseen: a mixture of Poisson distributions, as (weight, mean) for each exponent.
struct Law(Vec<(f64, f64)>);

impl Law {
    /// The mixture for the given numbers of hits.
    fn new(hits: &[usize]) -> Self {
        let mut hits: Vec<f64> = hits.iter().map(|h| (*h as f64).max(NEVER)).collect();
        hits.sort_by(f64::total_cmp);
        let rarest = hits.len().div_ceil(2).min(hits.len().saturating_sub(1));
        let Some(least) = hits.get(rarest).copied() else {
            // Nothing was met, so nothing is known.
            return Self(vec![(1.0, f64::INFINITY)]);
        };
        let spread: f64 = hits[..rarest].iter().map(|h| libm::log(least / h)).sum();
        let (shape, rate) = (PRIOR[0] + rarest as f64, PRIOR[1] + spread);
        // A single kind counts as the rarest.
        let kinds = rarest.max(1) as f64;
        let (count, greatest) = EXPONENTS;
        let step = greatest / count as f64;
        let exponents = (0..count).map(|k| (k as f64 + 0.5) * step);
        // The weights are scaled so that the greatest is about 1.
        let top = (shape - 1.0) / rate;
        let highest = (shape - 1.0) * libm::log(top) - rate * top;
        let laws = exponents.map(|a| {
            let weight = libm::exp((shape - 1.0) * libm::log(a) - rate * a - highest);
            (
                weight,
                kinds * libm::exp(libm::lgamma(1.0 + a) - a * libm::log(least)),
            )
        });
        let laws: Vec<(f64, f64)> = laws.collect();
        let sum: f64 = laws.iter().map(|(weight, _)| weight).sum();
        Self(laws.into_iter().map(|(w, mean)| (w / sum, mean)).collect())
    }

    fn none(&self) -> f64 {
        self.0
            .iter()
            .map(|(weight, mean)| weight * libm::exp(-mean))
            .sum()
    }

    /// Upper bound of the number unseen at the confidence level.
    fn bound(&self) -> Option<usize> {
        let enough = |unseen: usize| {
            let laws = self.0.iter();
            laws.map(|(weight, mean)| weight * at_most(unseen, *mean))
                .sum::<f64>()
                >= LEVEL
        };
        if enough(0) {
            return Some(0);
        }
        let (mut low, mut high) = (0, 1);
        while !enough(high) {
            if high >= MOST_UNSEEN {
                return None;
            }
            (low, high) = (high, 2 * high);
        }
        while high - low > 1 {
            let middle = low.midpoint(high);
            if enough(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        Some(high)
    }
}

/// Probability of at most `count` events under a Poisson distribution.
fn at_most(count: usize, mean: f64) -> f64 {
    if mean > NARROW {
        return f64::from(u8::from(count as f64 >= mean));
    }
    let (mut term, mut sum) = (libm::exp(-mean), 0.0);
    for k in 0..=count {
        sum += term;
        term *= mean / (k + 1) as f64;
        if term < f64::MIN_POSITIVE {
            break;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coverage(hits: &[usize]) -> Coverage {
        Coverage::new(&Counts {
            searches: 1000,
            last_new: 10,
            unfinished: 0,
            hits,
            draws: &[100, 20, 0],
            doubt: None,
        })
    }

    #[test]
    fn limits_of_small_counts() {
        // Tables of the upper 95 % limit of a Poisson mean.
        for (count, limit) in [(0, 2.9957), (1, 4.7439), (2, 6.2958), (10, 16.9622)] {
            assert!((poisson_limit(count) - limit).abs() < 1e-4, "{count}");
        }
    }

    #[test]
    fn the_sum_is_the_integral() {
        // With one kind met n times, the exponent has its prior, and the mean of n^−a is (2/(2 + ln n))³.
        let law = Law::new(&[1_000_000]);
        let mean: f64 = law.0.iter().map(|(weight, mean)| weight * mean).sum();
        let logarithm = libm::log(1e6_f64);
        let expected: f64 = (0..200_000)
            .map(|k| {
                let a = (f64::from(k) + 0.5) * 1e-4;
                let gamma = libm::lgamma(1.0 + a);
                4.0 * a * a * libm::exp(gamma - (2.0 + logarithm) * a) * 1e-4
            })
            .sum();
        assert!((mean / expected - 1.0).abs() < 1e-3, "{mean} {expected}");
    }

    #[test]
    fn what_was_met_often_and_alike_is_all() {
        let even = coverage(&[40; 12]);
        assert!(even.sure > 0.99 && even.unseen_below == Some(0), "{even:?}");
        assert_eq!((even.arrived, even.draws, even.undrawn), (480, 120, 1));
        assert!(even.chance_of_news.abs() < 1e-15);
        assert!((even.chance_of_news_below - 2.9957 / 480.0).abs() < 1e-5);
        // One much rarer saddle suggests that there are more like it.
        let mut uneven = [40; 12];
        uneven[3] = 2;
        let uneven = coverage(&uneven);
        assert!(uneven.sure < even.sure - 0.02, "{uneven:?}");
        // More hits give more certainty, whatever their spread.
        let sure =
            |factor: usize| coverage(&[4 * factor, 16 * factor, 20 * factor, 30 * factor]).sure;
        assert!((1..50).all(|factor| sure(factor + 1) > sure(factor)));
    }

    #[test]
    fn singletons_are_no_ground_for_a_claim() {
        let found = coverage(&[1, 1, 1, 2, 1, 3, 1, 8]);
        assert!(found.sure < 0.3, "{found:?}");
        assert!(found.unseen > 2.0 && found.unseen_below.is_none_or(|bound| bound > 4));
        let many = coverage(&[1, 2, 3, 1, 1, 4].repeat(500));
        assert!(
            (500..2000).contains(&many.unseen_below.unwrap()),
            "{many:?}"
        );
        // If every saddle was met once, no bound can be given.
        assert_eq!(coverage(&[1; 2000]).unseen_below, None);
        // A saddle that no search met lowers the certainty.
        let joined = coverage(&[40, 40, 40, 0]);
        assert_eq!(joined.joined, 1);
        assert!(joined.sure < 0.95, "{joined:?}");
        let nothing = Coverage::new(&Counts {
            searches: 5,
            last_new: 0,
            unfinished: 0,
            hits: &[],
            draws: &[],
            doubt: None,
        });
        assert!(
            nothing.sure.abs() < 1e-15 && nothing.unseen_below.is_none(),
            "{nothing:?}"
        );
        assert!((nothing.chance_of_news_below - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_doubt_is_no_claim() {
        let found = Coverage::new(&Counts {
            searches: 1000,
            last_new: 10,
            unfinished: 0,
            hits: &[40; 12],
            draws: &[100],
            doubt: Some(Doubt::Apart),
        });
        assert!(found.sure.abs() < 1e-15);
    }
}
