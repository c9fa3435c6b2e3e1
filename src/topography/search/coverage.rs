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
    /// One minimum was met, and no saddle. Numbers of hits then say nothing of others, and descents exclude only large basins
    /// ([`Coverage::undrawn_share_below`]).
    Alone,
    /// Searches ended at points that are stationary within the tolerances, with one curvature too small to have a sign: minima
    /// and saddles that are close together cannot be distinguished there.
    Undecided,
    /// Descents ended at kinks, which are not smooth minima.
    Kinks,
    /// Few searches ended at a saddle, as on stiff surfaces: saddles may be missing that are hardly ever met.
    Few,
    /// Descents from random points ended where the gradient does not vanish: the energy jumps there, its domain ends
    /// there, it has no lower bound, or its gradient is wrong.
    Unfinished,
}

impl Doubt {
    /// Whether the numbers of hits still bound the number of unseen saddles. Where minima are apart, a saddle is surely
    /// missing, however often the others were met.
    const fn leaves_bounds(self) -> bool {
        matches!(self, Self::Stopped | Self::Sampled)
    }
}

/// Completeness of the minima and saddles of a search, estimated from how often each saddle was met.
///
/// Every minimum joined to a known one lies behind a saddle, so statements about saddles cover minima too.
///
/// `sure` and `unseen_below` assume a distribution of the rates at which saddles are met. Its lower tail is a power law,
/// fitted to the half of the saddles met least often:
///
/// ```text
/// N(λ) = c λᵃ,   number met j times: Poisson of mean c a Γ(a + j)/j!,   unseen (j = 0): Poisson of mean c Γ(1 + a)
/// p(a | n) ∝ a² exp(−2 a) Π_i  a Γ(a + nᵢ)/nᵢ! / s(a),   s(a) = Γ(a + m + 1)/m! − Γ(1 + a),   c = k/s(a)
/// ```
///
/// N(λ) is the number of saddles that are met less than λ times on average, nᵢ the number of times a saddle was met, and m
/// about the median of these, at least 2. The product is over the k saddles that were met at most m times, but for the one
/// that gives the median; the likelihood is that of counts at most m. Where many saddles have the median, m may be the
/// number below it. A saddle that only a path found counts as met half a time. c is taken as known. For large counts the
/// estimate becomes that of B. M. Hill, Ann. Statist. 3, 1163 (1975). The prior of a is a Γ distribution of mean 3/2; in
/// Lennard-Jones clusters, a is about 1 to 1½. `analysis/completeness` measures how often such claims hold on surfaces with
/// known saddles. In simulations with rates of such a law, the bound holds in 83 % (a = ¼, where the prior has little weight)
/// to 95 %. A saddle that is much rarer than this model expects stays unseen, and no count of hits can reveal it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// Number of searches.
    pub searches: usize,
    /// Searches that ended at a saddle without having begun beside it.
    pub arrived: usize,
    /// Number of the search that found the last new stationary point.
    pub last_new: usize,
    /// Planned searches, most of them along modes of known minima, that had not been made when the search was stopped. While
    /// there are any, the others say nothing about how many saddles are missing.
    #[serde(default)]
    pub planned: usize,
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
    /// Upper 95 % limit of the share of the region whose descents end in minima in which none has ended yet (Good and Turing,
    /// with a Poisson distribution of the number of minima in which one descent ended; 3 / draws if that is 0).
    #[serde(default = "whole")]
    pub undrawn_share_below: f64,
    /// Good and Turing's estimate of the probability that the next saddle found is new: once / arrived.
    pub chance_of_news: f64,
    /// Its upper 95 % limit, at most 1, with a Poisson distribution of the number met once (3 / arrived if that is 0); 1 while
    /// searches are planned.
    pub chance_of_news_below: f64,
    /// Chao's lower bound of the number of unseen saddles ([`Rarefaction`](crate::topography::Rarefaction)). `None` if numbers
    /// of hits tell nothing of it: if some minima are joined by no saddle, if points or ends of descents are not isolated
    /// minima, or if saddles were found only by paths.
    pub unseen: Option<f64>,
    /// Upper 95 % limit of the number of unseen saddles; `None` as well if it is above 1000 and above 20 times the number met,
    /// or if searches are planned.
    pub unseen_below: Option<usize>,
    /// Probability that no saddle, and so no minimum, is unseen; 0 if there is a doubt.
    pub sure: f64,
    /// Reason why completeness cannot be claimed, if any.
    pub doubt: Option<Doubt>,
}

pub(super) struct Counts<'a> {
    pub(super) searches: usize,
    pub(super) last_new: usize,
    pub(super) planned: usize,
    pub(super) unfinished: usize,
    pub(super) hits: &'a [usize],
    /// Number of descents from random points that ended in each minimum.
    pub(super) draws: &'a [usize],
    pub(super) doubt: Option<Doubt>,
}

/// What is known of the region before any descent.
const fn whole() -> f64 {
    1.0
}

/// Confidence level of bounds.
const LEVEL: f64 = 0.95;
/// Prior of the exponent: shape and rate of a Γ distribution.
const PRIOR: [f64; 2] = [3.0, 2.0];
/// Grid of the exponents: number of points, and the greatest exponent, at which hardly anything is left unseen.
const EXPONENTS: (usize, f64) = (2000, 40.0);
/// A bound above the first number for each kind met, or above the second if that is more, is not reported.
const MOST_UNSEEN: [usize; 2] = [20, 1000];
/// Poisson distributions with a greater mean are replaced by their mean; the spread of the means is much larger.
const NARROW: f64 = 500.0;
/// Number of hits assumed for a saddle that was never met.
const NEVER: f64 = 0.5;

impl Coverage {
    /// The same search, if these are the hits of its saddles and the draws of its minima.
    #[cfg(feature = "cli")]
    pub(crate) fn of(&self, hits: &[usize], draws: &[usize]) -> Self {
        Self::new(&Counts {
            searches: self.searches,
            last_new: self.last_new,
            planned: self.planned,
            unfinished: self.unfinished,
            hits,
            draws,
            doubt: self.doubt,
        })
    }

    pub(super) fn new(counts: &Counts<'_>) -> Self {
        let count = |hits: usize| counts.hits.iter().filter(|h| **h == hits).count();
        let (joined, once, twice) = (count(0), count(1), count(2));
        let arrived: usize = counts.hits.iter().sum();
        let law = Law::new(counts.hits);
        let sure = law.none();
        let most = MOST_UNSEEN[1].max(MOST_UNSEEN[0] * counts.hits.len());
        // Each climb along a mode is made carefully and boldly, which meets the same saddle twice.
        let finished = counts.planned == 0;
        let news = (poisson_limit(once) / arrived.max(1) as f64).min(1.0);
        let counts_tell = counts.doubt.is_none_or(Doubt::leaves_bounds) && arrived > 0;
        let draws: usize = counts.draws.iter().sum();
        let drawn_once = counts.draws.iter().filter(|draws| **draws == 1).count();
        Self {
            searches: counts.searches,
            arrived,
            last_new: counts.last_new,
            planned: counts.planned,
            once,
            twice,
            joined,
            draws,
            unfinished: counts.unfinished,
            undrawn: counts.draws.iter().filter(|draws| **draws == 0).count(),
            undrawn_share_below: (poisson_limit(drawn_once) / draws.max(1) as f64).min(1.0),
            chance_of_news: once as f64 / arrived.max(1) as f64,
            chance_of_news_below: if finished { news } else { 1.0 },
            unseen: counts_tell.then(|| unseen(arrived, once, twice)),
            unseen_below: (finished && counts_tell).then(|| law.bound(most)).flatten(),
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

/// The number of kinds with at most m hits that the law is fitted to, and m.
fn rarer_half(hits: &[f64], median: f64) -> (usize, f64) {
    // Kinds met once and twice are the least from which an exponent follows.
    if median < 2.0 {
        return (hits.partition_point(|h| *h <= 2.0), 2.0);
    }
    // One that gives the limit says nothing about the others.
    let to_median = hits.partition_point(|h| *h <= median) - 1;
    let before = hits.partition_point(|h| *h < median);
    // Where many have the median, the half ends with them or before them.
    let half = hits.len() / 2;
    if before > 0 && median >= 3.0 && before.abs_diff(half) <= to_median.abs_diff(half) {
        (before, median - 1.0)
    } else {
        (to_median, median)
    }
}

/// Distribution of the number unseen: a mixture of Poisson distributions, as (weight, mean) for each exponent.
struct Law(Vec<(f64, f64)>);

impl Law {
    /// The mixture for the given numbers of hits.
    fn new(hits: &[usize]) -> Self {
        let mut hits: Vec<f64> = hits.iter().map(|h| (*h as f64).max(NEVER)).collect();
        hits.sort_by(f64::total_cmp);
        let rarest = hits.len().div_ceil(2).min(hits.len().saturating_sub(1));
        let Some(median) = hits.get(rarest).copied() else {
            // Nothing was met, so nothing is known.
            return Self(vec![(1.0, f64::INFINITY)]);
        };
        let (below, most) = rarer_half(&hits, median);
        // Each number of hits with the count of saddles that were met so often.
        let counts: Vec<(f64, f64)> = hits[..below]
            .chunk_by(|a, b| a.total_cmp(b).is_eq())
            .map(|alike| (alike[0], alike.len() as f64))
            .collect();
        // ln Γ(1 + a), and the logarithm of s(a) in units of it.
        let sums = |a: f64| {
            let unseen = libm::lgamma(1.0 + a);
            let all = libm::lgamma(a + most + 1.0) - libm::lgamma(most + 1.0);
            (unseen, libm::log(libm::expm1(all - unseen)))
        };
        let logarithm = |a: f64| {
            let (unseen, seen) = sums(a);
            let hits = counts.iter().map(|(h, count)| {
                let of = libm::log(a) + libm::lgamma(a + h) - libm::lgamma(h + 1.0);
                count * (of - unseen - seen)
            });
            (PRIOR[0] - 1.0) * libm::log(a) - PRIOR[1] * a + hits.sum::<f64>()
        };
        // A single kind counts as the rarest.
        let kinds = below.max(1) as f64;
        let (count, greatest) = EXPONENTS;
        // Closer together near 0, where most is unseen.
        let exponents = (0..count).map(|k| {
            let part = (k as f64 + 0.5) / count as f64;
            (greatest * part * part, part)
        });
        let laws: Vec<(f64, f64)> = exponents
            .map(|(a, width)| {
                (
                    logarithm(a) + libm::log(width),
                    kinds * libm::exp(-sums(a).1),
                )
            })
            .collect();
        let top = laws.iter().map(|(weight, _)| *weight);
        let top = top.fold(f64::NEG_INFINITY, f64::max);
        let share = |weight: f64| libm::exp(weight - top);
        let sum: f64 = laws.iter().map(|(weight, _)| share(*weight)).sum();
        Self(
            laws.into_iter()
                .map(|(w, mean)| (share(w) / sum, mean))
                .collect(),
        )
    }

    fn none(&self) -> f64 {
        self.0
            .iter()
            .map(|(weight, mean)| weight * libm::exp(-mean))
            .sum()
    }

    /// Upper bound of the number unseen at the confidence level, if it is not greater than `most`.
    fn bound(&self, most: usize) -> Option<usize> {
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
            if high >= most {
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
        (high <= most).then_some(high)
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
    use crate::sample::{Task, stream};
    use rand::RngExt;

    fn coverage(hits: &[usize]) -> Coverage {
        Coverage::new(&Counts {
            searches: 1000,
            last_new: 10,
            planned: 0,
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
        // With one kind met n times, the exponent has its prior.
        let law = Law::new(&[1_000_000]);
        let mean: f64 = law.0.iter().map(|(weight, mean)| weight * mean).sum();
        let expected: f64 = (0..200_000)
            .map(|k| {
                let a = (f64::from(k) + 0.5) * 1e-4;
                let seen = libm::exp(a * libm::log(1e6_f64) - libm::lgamma(1.0 + a)) - 1.0;
                4.0 * a * a * libm::exp(-2.0 * a) / seen * 1e-4
            })
            .sum();
        assert!((mean / expected - 1.0).abs() < 1e-3, "{mean} {expected}");
    }

    /// Of kinds whose rates follow the assumed law up to 30, with up to two fifths of them unseen, the bound holds nearly as
    /// often as it says, and it is of the right size. The prior has little weight at an exponent of ¼, so bounds are a
    /// little low there.
    #[test]
    fn bounds_hold_for_rates_of_the_law() {
        let mut rng = stream(1, Task::Start, 0);
        for (exponent, least) in [(0.25, 80), (0.5, 90), (1.0, 90), (1.5, 90)] {
            let (mut holds, mut close) = (0, 0);
            for _ in 0..100 {
                let (mut hits, mut unseen) = (Vec::new(), 0);
                for _ in 0..1000 {
                    let rate = 30.0 * libm::pow(rng.random::<f64>(), 1.0 / exponent);
                    // A Poisson number: events until the time is over.
                    let (mut time, mut count) = (0.0, 0);
                    loop {
                        time -= libm::log(1.0 - rng.random::<f64>());
                        if time > rate {
                            break;
                        }
                        count += 1;
                    }
                    match count {
                        0 => unseen += 1,
                        count => hits.push(count),
                    }
                }
                let bound = coverage(&hits).unseen_below.unwrap();
                holds += usize::from(bound >= unseen);
                close += usize::from(bound <= 4 * unseen + 10);
            }
            assert!(holds >= least && close >= 90, "{exponent}: {holds} {close}");
        }
    }

    #[test]
    fn saddles_that_no_search_met_bound_nothing() {
        let found = coverage(&[0, 0]);
        assert_eq!((found.arrived, found.joined), (0, 2));
        assert_eq!((found.unseen, found.unseen_below), (None, None));
    }
}
