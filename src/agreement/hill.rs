//! Hill numbers: effective numbers of kinds in a sample, rarefied to a smaller size, with bootstrap intervals.
//!
//! A. Chao, N. J. Gotelli, T. C. Hsieh, E. L. Sander, K. H. Ma, R. K. Colwell and A. M. Ellison, Ecol. Monogr. 84, 45
//! (2014), below "C14". A. Chao and L. Jost, Ecology 93, 2533 (2012).

use rand::RngExt;
use rand::distr::Distribution;
use rand::distr::weighted::WeightedIndex;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::sample::{Rng, Task, stream};

/// Standard deviations of a 95 % interval.
const QUANTILE: f64 = 1.959_963_984_540_054;

/// Standard deviations above zero of a difference that is found in four of five samples (with [`QUANTILE`]: a power of 80 %).
const POWER: f64 = 0.841_621_233_572_914;

/// Most times the members at hand that [`Ratio::members_needed`] tells: beyond, the difference is too small to plan for.
const MOST_TIMES: f64 = 100.0;

/// Number of the first random stream of pairs of samples from one community; those before are of single samples.
const PAIRS: u64 = 1 << 32;

/// An estimate with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimated {
    /// The estimate.
    pub value: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
}

/// The ratio of two Hill numbers of one order and one sample size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ratio {
    /// The estimate.
    pub value: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
    /// Number of members in each of the two samples with which four of five intervals would leave out 1, if the ratio is as
    /// estimated. `None` if this interval leaves out 1, or if more than a hundred times as many members were needed.
    pub members_needed: Option<usize>,
}

impl Ratio {
    /// Whether the interval leaves out 1.
    pub fn differs(&self) -> bool {
        self.interval[0] > 1.0 || self.interval[1] < 1.0
    }

    /// Widens the interval so that it holds that of another estimate of this ratio. Nothing is planned if they lie on
    /// different sides of 1; otherwise the larger number of members is needed.
    pub fn span(&mut self, other: &Self) {
        let [low, high] = self.interval;
        let before = *self;
        self.interval = [low.min(other.interval[0]), high.max(other.interval[1])];
        let needed = |one: &Self| match one.members_needed {
            None if one.differs() => Some(0),
            needed => needed,
        };
        let same_side = (before.value > 1.0) == (other.value > 1.0);
        let both = needed(&before)
            .zip(needed(other))
            .filter(|_| same_side && !self.differs());
        self.members_needed = both.map(|(one, other)| one.max(other));
    }

    /// The ratio of the second number to the first.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let [low, high] = self.interval;
        Self {
            value: 1.0 / self.value,
            interval: [1.0 / high, 1.0 / low],
            ..*self
        }
    }
}

/// Expected Hill numbers of order 0, 1 and 2 of `size` members drawn without replacement from kinds with these `counts`.
///
/// ```text
/// ^qD(m) = (Σₖ (k/m)^q fₖ(m))^(1/(1−q)),   ¹D(m) = exp(−Σₖ (k/m) ln(k/m) fₖ(m))         (C14, Eqs. 6 and 7)
/// fₖ(m)  = Σᵢ C(nᵢ, k) C(n − nᵢ, m − k)/C(n, m)                                          (C14, Eq. 4)
/// ```
///
/// fₖ(m): expected number of kinds with k of the m members. Order 0 counts all kinds alike, order 1 counts each by its
/// frequency (exponential of Shannon's entropy), order 2 emphasises frequent kinds (inverse of Simpson's concentration). k
/// equally frequent kinds have the number k in every order if all members are drawn. Dimensionless; zero for a size of 0.
///
/// # Panics
/// If `size` exceeds the sum of the counts: nothing is extrapolated.
///
/// # Examples
/// ```
/// use landscape::agreement::rarefied_hill_numbers;
///
/// assert_eq!(rarefied_hill_numbers(&[2, 1], 1).map(f64::round), [1.0, 1.0, 1.0]);
/// // Two of {a, a, b}: both kinds unless {a, a}, one of three pairs.
/// assert!((rarefied_hill_numbers(&[2, 1], 2)[0] - 5.0 / 3.0).abs() < 1e-12);
/// ```
pub fn rarefied_hill_numbers(counts: &[usize], size: usize) -> [f64; 3] {
    let all: usize = counts.iter().sum();
    assert!(size <= all, "{all} members are fewer than {size}");
    if size == 0 {
        return [0.0; 3];
    }
    let logs = log_factorials(all);
    let choose = |n: usize, k: usize| logs[n] - logs[k] - logs[n - k];
    let whole = choose(all, size);
    let mut counts = counts.to_vec();
    counts.sort_unstable();
    let (mut kinds, mut entropy, mut concentration) = (0.0, 0.0, 0.0);
    // Kinds of equal count contribute alike.
    for equal in counts.chunk_by(|a, b| a == b) {
        let (count, others, times) = (equal[0], all - equal[0], equal.len() as f64);
        for k in size.saturating_sub(others).max(1)..=count.min(size) {
            let expected = times * libm::exp(choose(count, k) + choose(others, size - k) - whole);
            let share = k as f64 / size as f64;
            kinds += expected;
            entropy -= expected * share * libm::log(share);
            concentration += expected * share * share;
        }
    }
    [kinds, libm::exp(entropy), 1.0 / concentration]
}

/// [`rarefied_hill_numbers`] of a sample and of its resamplings.
///
/// A resampling draws as many members as the sample has from the kinds found and the kinds that the sample is estimated to
/// have missed (C14, Appendix G, as in the R package iNEXT), and is rarefied likewise. With n members and fₖ kinds of k
/// members:
///
/// ```text
/// f₀ = (n − 1)/n · f₁²/(2 f₂), or (n − 1)/n · f₁ (f₁ − 1)/2 if f₂ = 0    (kinds missed)
/// 1 − C = f₁/n · n f₀/(n f₀ + f₁)                                        (their share; Chao and Jost 2012, Eq. 4a)
/// pᵢ = nᵢ/n (1 − λ (1 − nᵢ/n)ⁿ),   Σ pᵢ = C                              (kinds found)
/// p = (1 − C)/⌈f₀⌉                                                       (each kind missed)
/// ```
///
/// Members must be independent draws. A sample of a single kind resamples to itself, so its own intervals have no width.
#[derive(Debug, Clone, PartialEq)]
pub struct HillNumbers {
    values: [f64; 3],
    drawn: Vec<[f64; 3]>,
    /// The sample, the most frequent kind first.
    counts: Vec<usize>,
    members: usize,
    size: usize,
    seed: u64,
}

impl HillNumbers {
    /// Rarefies the sample with these `counts`, and `draws` resamplings of it, to `size` members. Draw i uses random stream i
    /// of `seed`.
    ///
    /// # Panics
    /// If `size` is 0 or exceeds the sum of the counts.
    pub fn of(counts: &[usize], size: usize, draws: usize, seed: u64) -> Self {
        assert!(size > 0, "a sample has members");
        let members: usize = counts.iter().sum();
        let values = rarefied_hill_numbers(counts, size);
        let community = Community::estimated(counts);
        let draw = |draw| {
            let mut rng = stream(seed, Task::Diversity, draw);
            rarefied_hill_numbers(&community.sample(members, &mut rng), size)
        };
        let mut ordered = counts.to_vec();
        ordered.sort_unstable_by(|a, b| b.cmp(a));
        Self {
            values,
            drawn: (0..draws as u64).into_par_iter().map(draw).collect(),
            counts: ordered,
            members,
            size,
            seed,
        }
    }

    /// The numbers of order 0, 1 and 2 with 95 % intervals: ± 1.96 standard deviations over the resamplings, cut to 1 and the
    /// size.
    ///
    /// An interval is for the expected Hill number of a sample of this size, not for that of the whole population. It covers
    /// this number in 91 to 95 % of simulated samples of 120 from 25 unequal kinds.
    pub fn estimates(&self) -> [Estimated; 3] {
        std::array::from_fn(|order| {
            let half = QUANTILE * deviation(self.drawn.iter().map(|numbers| numbers[order]));
            let value = self.values[order];
            Estimated {
                value,
                interval: [
                    (value - half).max(1.0),
                    (value + half).min(self.size as f64),
                ],
            }
        })
    }

    /// The ratios of these numbers to those of an independent sample at the same size.
    ///
    /// ```text
    /// ln r ± max(1.96 √(s² + s′²), c),   n* = max((1.96 + 0.84)² (n s² + n′ s′²), (1 + 0.84/1.96)² c² max(n, n′))/(ln r)²
    /// ```
    ///
    /// r: ratio; s, s′: standard deviations of the logarithms over the resamplings of the samples of n and n′ members; n*:
    /// [`Ratio::members_needed`], because a variance falls as one over the number of members. c: the size that |ln r| exceeds
    /// in one of twenty pairs of samples from one community, that of both samples together with their kinds matched by rank.
    /// It matters where a sample has few kinds or kinds met once: a sample of a single kind resamples to itself, and s says
    /// nothing of the kinds that chance left out.
    ///
    /// The interval covers the ratio of the expected numbers in at least 90 % of 400 simulated pairs of samples of 80 and 120
    /// members; four of five samples of n* members show a planted ratio; of pairs of samples of 40 from one community, also
    /// one in which a kind has nearly all, at most one of ten is told to differ in each order (tests).
    ///
    /// # Panics
    /// If the two have different sizes.
    ///
    /// # Examples
    /// ```
    /// use landscape::agreement::HillNumbers;
    ///
    /// let [wide, narrow] = [[12; 10], [30, 30, 30, 30, 0, 0, 0, 0, 0, 0]].map(|counts| HillNumbers::of(&counts, 120, 100, 0));
    /// let ratio = wide.ratios_to(&narrow)[1];
    /// assert!((ratio.value - 2.5).abs() < 1e-9 && ratio.interval[0] > 2.0);
    /// ```
    pub fn ratios_to(&self, other: &Self) -> [Ratio; 3] {
        assert_eq!(self.size, other.size, "numbers are compared at one size");
        let by_chance = self.ratios_by_chance(other);
        std::array::from_fn(|order| {
            let logarithm = libm::log(self.values[order] / other.values[order]);
            let [own, others] = [self, other].map(|one| {
                deviation(one.drawn.iter().map(|numbers| libm::log(numbers[order]))).powi(2)
            });
            let chance = by_chance[order];
            let half = chance.max(QUANTILE * (own + others).sqrt());
            let members = [self.members as f64, other.members as f64];
            let of_samples = (QUANTILE + POWER).powi(2) * (members[0] * own + members[1] * others);
            let of_chance =
                ((1.0 + POWER / QUANTILE) * chance).powi(2) * members[0].max(members[1]);
            let needed = of_samples.max(of_chance) / logarithm.powi(2);
            let told = logarithm.abs() <= half && needed <= MOST_TIMES * members[0].max(members[1]);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "positive and bounded"
            )]
            let members_needed = told.then(|| needed.ceil() as usize);
            Ratio {
                value: libm::exp(logarithm),
                interval: [logarithm - half, logarithm + half].map(libm::exp),
                members_needed,
            }
        })
    }
}

impl HillNumbers {
    /// For each order the size of a logarithm of a ratio that one of twenty pairs of samples from one community exceeds.
    fn ratios_by_chance(&self, other: &Self) -> [f64; 3] {
        let kinds = self.counts.len().max(other.counts.len());
        let of = |one: &Self, rank: usize| one.counts.get(rank).copied().unwrap_or(0);
        let together: Vec<usize> = (0..kinds)
            .map(|rank| of(self, rank) + of(other, rank))
            .collect();
        let community = Community::estimated(&together);
        let draws = self.drawn.len().max(other.drawn.len()) as u64;
        let seed = self.seed.min(other.seed);
        // The larger sample is drawn first, so that the two may be exchanged.
        let (most, least) = (
            self.members.max(other.members),
            self.members.min(other.members),
        );
        let pair = |draw: u64| {
            let mut rng = stream(seed, Task::Diversity, PAIRS + draw);
            let [one, other] = [most, least].map(|members| {
                rarefied_hill_numbers(&community.sample(members, &mut rng), self.size)
            });
            std::array::from_fn::<f64, 3, _>(|order| libm::log(one[order] / other[order]).abs())
        };
        let pairs: Vec<[f64; 3]> = (0..draws).into_par_iter().map(pair).collect();
        std::array::from_fn(|order| {
            let mut sizes: Vec<f64> = pairs.iter().map(|pair| pair[order]).collect();
            sizes.sort_unstable_by(f64::total_cmp);
            sizes.get(sizes.len() * 19 / 20).copied().unwrap_or(0.0)
        })
    }
}

/// The kinds from which a sample is estimated to be drawn.
struct Community {
    /// Shares of the kinds found, and of all kinds missed together.
    shares: Vec<f64>,
    /// Number of kinds missed.
    missed: u64,
}

impl Community {
    fn estimated(counts: &[usize]) -> Self {
        let members: usize = counts.iter().sum();
        let n = members as f64;
        let of_size = |size| counts.iter().filter(|count| **count == size).count() as f64;
        let (f1, f2) = (of_size(1), of_size(2));
        let pairs = if f2 > 0.0 {
            f1 * f1 / (2.0 * f2)
        } else {
            f1 * (f1 - 1.0) / 2.0
        };
        let f0 = (n - 1.0) / n * pairs;
        let share_missed = if f0 > 0.0 {
            f1 * f0 / (n * f0 + f1)
        } else {
            0.0
        };
        let found = || counts.iter().filter(|count| **count > 0);
        // Probability that a kind of this share is missed.
        let overlooked = |count: usize| libm::exp(n * libm::log1p(-(count as f64) / n));
        let total: f64 = found()
            .map(|&count| count as f64 / n * overlooked(count))
            .sum();
        let lambda = if total > 0.0 {
            share_missed / total
        } else {
            0.0
        };
        let mut shares: Vec<f64> = found()
            .map(|&count| count as f64 / n * (1.0 - lambda * overlooked(count)).max(0.0))
            .collect();
        shares.push(share_missed);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number, at most half the square of the number of kinds"
        )]
        let missed = f0.max(0.0).ceil() as u64;
        Self { shares, missed }
    }

    /// Numbers of members of each kind in a random sample.
    fn sample(&self, members: usize, rng: &mut Rng) -> Vec<usize> {
        let kinds = WeightedIndex::new(&self.shares).expect("some kind has members");
        let found = self.shares.len() - 1;
        let mut drawn: Vec<u64> = (0..members)
            .map(|_| match kinds.sample(rng) {
                kind if kind < found => kind as u64,
                _ => found as u64 + rng.random_range(0..self.missed.max(1)),
            })
            .collect();
        drawn.sort_unstable();
        drawn.chunk_by(|a, b| a == b).map(<[u64]>::len).collect()
    }
}

fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count.max(1.0);
    let squares: f64 = values.map(|value| (value - mean).powi(2)).sum();
    (squares / (count - 1.0).max(1.0)).sqrt()
}

fn log_factorials(most: usize) -> Vec<f64> {
    let mut logs = Vec::with_capacity(most + 1);
    logs.push(0.0);
    for n in 1..=most {
        logs.push(logs[n - 1] + libm::log(n as f64));
    }
    logs
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Every way to draw `size` of the members, one after another.
    fn by_brute_force(counts: &[usize], size: usize) -> [f64; 3] {
        let members: Vec<usize> = (counts.iter().enumerate())
            .flat_map(|(kind, &count)| vec![kind; count])
            .collect();
        let (mut ways, mut kinds, mut entropy, mut concentration) = (0.0, 0.0, 0.0, 0.0);
        for set in 0_u32..1 << members.len() {
            if set.count_ones() as usize != size {
                continue;
            }
            ways += 1.0;
            let mut drawn = vec![0_usize; counts.len()];
            for (place, kind) in members.iter().enumerate() {
                drawn[*kind] += usize::from(set >> place & 1 == 1);
            }
            for count in drawn.into_iter().filter(|count| *count > 0) {
                let share = count as f64 / size as f64;
                kinds += 1.0;
                entropy -= share * libm::log(share);
                concentration += share * share;
            }
        }
        [
            kinds / ways,
            libm::exp(entropy / ways),
            ways / concentration,
        ]
    }

    proptest! {
        #[test]
        fn rarefied_numbers_are_means_over_all_samples(
            counts in prop::collection::vec(0_usize..5, 1..4),
            part in 0.0..1.0_f64,
        ) {
            let all: usize = counts.iter().sum();
            prop_assume!(all > 0);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and all")]
            let size = (part * all as f64).ceil().max(1.0) as usize;
            let (found, expected) = (rarefied_hill_numbers(&counts, size), by_brute_force(&counts, size));
            for (found, expected) in found.iter().zip(expected) {
                prop_assert!((found - expected).abs() < 1e-9, "{counts:?} {size}: {found} {expected}");
            }
        }
    }

    #[test]
    fn equal_kinds_are_counted_and_unequal_ones_weighted() {
        for found in rarefied_hill_numbers(&[12; 7], 84) {
            assert!((found - 7.0).abs() < 1e-9, "{found}");
        }
        // Shares 1/2, 1/4, 1/8, 1/8: entropy 7/4 ln 2, concentration 11/32.
        let found = rarefied_hill_numbers(&[40, 20, 10, 10, 0], 80);
        for (found, expected) in found.iter().zip([4.0, libm::exp2(1.75_f64), 32.0 / 11.0]) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        // Simpson's closed form of a smaller sample (C14, Table 1).
        let pairs: f64 = [40.0, 20.0, 10.0, 10.0].map(|n| n * (n - 1.0)).iter().sum();
        let expected = 1.0 / (1.0 / 30.0 + 29.0 / 30.0 * pairs / (80.0 * 79.0));
        assert!((rarefied_hill_numbers(&[40, 20, 10, 10], 30)[2] - expected).abs() < 1e-9);
    }

    /// The example of iNEXT's documentation for the R package, spider data, girdled trees: 26 kinds of 168 spiders.
    #[test]
    fn spiders_of_inext() {
        let girdled = [
            46, 22, 17, 15, 15, 9, 8, 6, 6, 4, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
        ];
        let found = HillNumbers::of(&girdled, 168, 200, 0).estimates();
        for (found, expected) in found.iter().zip([26.0, 12.060, 7.840]) {
            assert!((found.value - expected).abs() < 5e-4, "{found:?}");
        }
    }

    /// Shares of kinds that fall with a power of their rank.
    fn ranked(kinds: u32, power: f64) -> Vec<f64> {
        let shares: Vec<f64> = (1..=kinds)
            .map(|rank| libm::pow(f64::from(rank), -power))
            .collect();
        let total: f64 = shares.iter().sum();
        shares.iter().map(|share| share / total).collect()
    }

    /// Counts of `members` draws from kinds with these shares; sample `id`.
    fn sample(shares: &[f64], members: usize, id: u64) -> Vec<usize> {
        let kinds = WeightedIndex::new(shares).unwrap();
        let mut rng = stream(5, Task::Start, id);
        let mut counts = vec![0_usize; shares.len()];
        (0..members).for_each(|_| counts[kinds.sample(&mut rng)] += 1);
        counts
    }

    /// The numbers of the mean frequencies of samples of `size` from kinds with these shares.
    fn truth(shares: &[f64], size: usize) -> [f64; 3] {
        let logs = log_factorials(size);
        let (mut richness, mut entropy, mut concentration) = (0.0, 0.0, 0.0);
        for share in shares {
            for k in 1..=size {
                let ways = logs[size] - logs[k] - logs[size - k];
                let (k, n) = (k as f64, size as f64);
                let chance =
                    libm::exp(ways + k * libm::log(*share) + (n - k) * libm::log1p(-share));
                richness += chance;
                entropy -= chance * k / n * libm::log(k / n);
                concentration += chance * (k / n).powi(2);
            }
        }
        [richness, libm::exp(entropy), 1.0 / concentration]
    }

    /// The interval covers the expected number of a sample in about 95 % of the samples.
    #[test]
    fn intervals_cover_the_truth() {
        let shares = ranked(25, 1.0);
        let (members, size) = (120, 80);
        let truth = truth(&shares, size);
        let mut covered = [0_usize; 3];
        let samples = 400;
        for id in 0..samples {
            let found = HillNumbers::of(&sample(&shares, members, id), size, 100, id).estimates();
            for order in 0..3 {
                let [low, high] = found[order].interval;
                covered[order] += usize::from((low..=high).contains(&truth[order]));
            }
        }
        for count in covered {
            let share = count as f64 / samples as f64;
            assert!((0.9..0.99).contains(&share), "{covered:?} of {samples}");
        }
    }

    /// The interval of a ratio covers the true one in about 95 % of pairs of samples of unequal size.
    #[test]
    fn intervals_of_ratios_cover_the_truth() {
        for (one, other) in [
            (ranked(25, 1.0), ranked(12, 1.0)),
            (ranked(20, 0.5), ranked(20, 1.5)),
            (ranked(15, 1.0), ranked(15, 1.0)),
        ] {
            let (members, size) = ([80, 120], 80);
            let [truth, to] = [&one, &other].map(|shares| truth(shares, size));
            let mut covered = [0_usize; 3];
            let pairs = 400;
            for id in 0..pairs {
                let [a, b] = [(&one, members[0], 2 * id), (&other, members[1], 2 * id + 1)].map(
                    |(shares, members, id)| {
                        HillNumbers::of(&sample(shares, members, id), size, 100, id)
                    },
                );
                for (order, ratio) in a.ratios_to(&b).iter().enumerate() {
                    let [low, high] = ratio.interval;
                    covered[order] +=
                        usize::from((low..=high).contains(&(truth[order] / to[order])));
                }
            }
            for count in covered {
                let share = count as f64 / pairs as f64;
                assert!(share >= 0.9, "{covered:?} of {pairs}");
            }
        }
    }

    /// Of pairs of samples from one community, at most one of ten is told to differ, also if one kind has nearly all members.
    #[test]
    fn chance_alone_seldom_shows_a_difference() {
        for shares in [
            vec![0.97, 0.03],
            vec![0.95, 0.02, 0.015, 0.015],
            vec![0.9, 0.06, 0.04],
            vec![0.4, 0.3, 0.2, 0.05, 0.05],
        ] {
            let pairs = 200;
            let mut differ = [0_usize; 3];
            for id in 0..pairs {
                let [a, b] = [2 * id, 2 * id + 1]
                    .map(|id| HillNumbers::of(&sample(&shares, 40, id), 40, 100, id));
                for (order, ratio) in a.ratios_to(&b).iter().enumerate() {
                    differ[order] += usize::from(ratio.differs());
                }
            }
            assert!(
                differ.iter().all(|count| *count <= 20),
                "{shares:?}: {differ:?} of {pairs}"
            );
        }
        let [lone, other] =
            [vec![40], vec![39, 1]].map(|counts| HillNumbers::of(&counts, 40, 200, 0));
        assert!(other.ratios_to(&lone).iter().all(|ratio| !ratio.differs()));
    }

    #[test]
    fn ratios_are_turned_around() {
        let [a, b] =
            [vec![20, 10, 5, 1], vec![9; 4]].map(|counts| HillNumbers::of(&counts, 36, 50, 0));
        for (one, other) in a.ratios_to(&b).iter().zip(b.ratios_to(&a)) {
            let turned = other.inverse();
            assert!((one.value - turned.value).abs() < 1e-12);
            assert!((one.interval[0] - turned.interval[0]).abs() < 1e-12);
            assert_eq!(one.members_needed, other.members_needed);
            assert_eq!(one.differs(), other.differs());
        }
        // Nothing to plan for: the same numbers, or a difference that is shown already.
        assert_eq!(a.ratios_to(&a)[1].members_needed, None);
        assert!(a.ratios_to(&b)[2].differs());
        assert_eq!(a.ratios_to(&b)[2].members_needed, None);
    }

    #[test]
    fn estimated_shares_sum_to_one() {
        for counts in [
            &[5, 3, 2, 1, 1, 1][..],
            &[1; 40],
            &[30],
            &[20, 10, 1],
            &[2, 2, 1, 0],
        ] {
            let total: f64 = Community::estimated(counts).shares.iter().sum();
            assert!((total - 1.0).abs() < 1e-9, "{counts:?}: {total}");
        }
        // A sample without repetitions hides so many kinds that they cannot be listed.
        let lone = HillNumbers::of(&vec![1; 20_000], 100, 2, 0).estimates();
        assert!((lone[0].value - 100.0).abs() < 1e-6, "{lone:?}");
        let one = HillNumbers::of(&[30], 30, 20, 0).estimates();
        let width = |number: &Estimated| number.interval[1] - number.interval[0];
        assert!(one.iter().all(|number| width(number).abs() < 1e-12));
        let of_seed = |seed| HillNumbers::of(&[9, 4, 4, 2, 1, 1], 15, 50, seed).estimates();
        assert_eq!(of_seed(3), of_seed(3));
        assert_ne!(of_seed(3), of_seed(4));
    }
}
