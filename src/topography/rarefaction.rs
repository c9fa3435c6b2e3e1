//! Rarefaction: how many kinds a smaller sample would have shown, and how many are still unseen.
//!
//! K. L. Heck, G. van Belle and D. Simberloff, Ecology 56, 1459 (1975); A. Chao, Scand. J. Stat. 11, 265 (1984);
//! R. K. Colwell et al., J. Plant Ecol. 5, 3 (2012), below "C12"; A. Chao and L. Jost, Ecology 93, 2533 (2012).

use serde::{Deserialize, Serialize};

/// Least number of members for an estimate of unseen kinds. With fewer members the numbers of kinds met once and twice
/// depend on chance; a partition into two kinds, for example, may have no singletons whatever the truth.
pub const LEAST_MEMBERS: usize = 30;

/// Standard deviations of a 95 % interval.
const QUANTILE: f64 = 1.959_963_984_540_054;

/// Expected content of a sample of a given size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rarefied {
    /// Size of the sample.
    pub members: usize,
    /// Expected number of kinds in it.
    pub kinds: f64,
    /// Standard deviation of that number; `None` beyond the sample at hand.
    pub deviation: Option<f64>,
}

/// How complete a list of kinds is, estimated from the number of members of each.
///
/// The estimate holds for members drawn independently from one distribution. Members that were chosen to be different
/// contain too many singletons, and the number of unseen kinds is then overestimated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rarefaction {
    /// Total number of members, N.
    pub members: usize,
    /// Number of kinds found, S.
    pub kinds: usize,
    /// Number of kinds with one member, f₁.
    pub once: usize,
    /// Number of kinds with two members, f₂.
    pub twice: usize,
    /// Estimate of what is unseen; `None` for fewer members than [`LEAST_MEMBERS`].
    #[serde(flatten)]
    pub estimate: Option<Completeness>,
    /// Expected number of kinds at sample sizes up to N, and beyond N if there is an estimate.
    pub curve: Vec<Rarefied>,
}

/// An estimate of what a sample has not shown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Completeness {
    /// Chao's bias-corrected lower bound of the number of unseen kinds: (N − 1)/N · f₁ (f₁ − 1)/(2 (f₂ + 1)).
    pub unseen: f64,
    /// Its 95 % interval.
    pub unseen_interval: [f64; 2],
    /// Estimated probability that one more member falls into a kind already found (sample coverage, Chao and Jost's Eq.
    /// 4a): 1 − f₁/N · (N − 1) f₁/((N − 1) f₁ + 2 f₂).
    pub coverage: f64,
}

/// Bias-corrected "Chao1" estimate of the number of unseen kinds: (N − 1)/N · f₁ (f₁ − 1)/(2 (f₂ + 1)).
pub(super) fn unseen(members: usize, once: usize, twice: usize) -> f64 {
    let share = members.saturating_sub(1) as f64 / members.max(1) as f64;
    share * (once * once.saturating_sub(1)) as f64 / (2 * (twice + 1)) as f64
}

impl Rarefaction {
    /// Rarefaction of kinds of the given sizes. The curve has about `points` points up to N, and half as many up to 2 N.
    ///
    /// ```text
    /// E[S_n] = Σ_i (1 − α_i),  α_i = C(N − N_i, n)/C(N, n)                    (Heck et al., Eq. 2)
    /// Var S_n = Σ_i (1 − α_i)² − E[S_n]²/(S + f̂₀)                            (C12, Eq. 5)
    /// S_{N+m} = S + f̂₀ (1 − (1 − f₁/(N f̂₀))^m)                               (C12, Eq. 9)
    /// ```
    ///
    /// f̂₀ is the estimated number of unseen kinds. Empty kinds are not counted.
    pub fn new(sizes: &[usize], points: usize) -> Self {
        Self::with_least(LEAST_MEMBERS, sizes, points)
    }

    fn with_least(least_members: usize, sizes: &[usize], points: usize) -> Self {
        let sizes: Vec<usize> = sizes.iter().copied().filter(|size| *size > 0).collect();
        let members: usize = sizes.iter().sum();
        let count = |size: usize| sizes.iter().filter(|other| **other == size).count();
        let (once, twice) = (count(1), count(2));
        let unseen = unseen(members, once, twice);
        let (f1, f2, n) = (once as f64, twice as f64, members as f64);
        let missing = if once == 0 {
            0.0
        } else {
            // For a lone member f₂ is 0 and the coverage is 0.
            let weight = (n - 1.0) * f1;
            let share = if weight + 2.0 * f2 > 0.0 {
                weight / (weight + 2.0 * f2)
            } else {
                1.0
            };
            f1 / n * share
        };
        let mut found = Self {
            members,
            kinds: sizes.len(),
            once,
            twice,
            estimate: None,
            curve: Vec::new(),
        };
        found.curve = found.curve(&sizes, unseen, points.max(2));
        if members >= least_members {
            found.estimate = Some(Completeness {
                unseen,
                unseen_interval: found.interval(&sizes, unseen),
                coverage: 1.0 - missing,
            });
            found.extend_beyond(unseen, points.max(2));
        }
        found
    }

    /// The 95 % interval of the number of unseen kinds, for a log-normal distribution of f̂₀ with the variance of the
    /// estimate (A. Chao, Biometrics 43, 783 (1987), Eq. 13; variances: R. K. Colwell, `EstimateS` 9.1 User's Guide,
    /// Appendix B, Eqs. 6 and 7). If the estimate is 0: the interval of S/(1 − P) with P = `Σ exp(−N_i)/S` (ibid., Eqs. 8
    /// and 14).
    fn interval(&self, sizes: &[usize], unseen: f64) -> [f64; 2] {
        let (f1, f2) = (self.once as f64, self.twice as f64);
        let (n, found) = (self.members as f64, self.kinds as f64);
        if self.kinds == 0 {
            return [0.0; 2];
        }
        let share = (n - 1.0) / n;
        if unseen > 0.0 {
            let variance = if self.twice > 0 {
                let more = f2 + 1.0;
                unseen
                    + share * share * f1 * (2.0 * f1 - 1.0).powi(2) / (4.0 * more * more)
                    + share * share * f1 * f1 * f2 * (f1 - 1.0).powi(2) / (4.0 * more.powi(4))
            } else {
                unseen + share * share * f1 * (2.0 * f1 - 1.0).powi(2) / 4.0
                    - share * share * f1.powi(4) / (4.0 * (found + unseen))
            };
            let spread = libm::log1p(variance.max(0.0) / (unseen * unseen));
            let factor = libm::exp(QUANTILE * spread.sqrt());
            return [unseen / factor, unseen * factor];
        }
        let missed = |size: &usize| libm::exp(-(*size as f64));
        let (mut once, mut twice, mut mean) = (0.0, 0.0, 0.0);
        for size in sizes {
            once += missed(size);
            twice += missed(size).powi(2);
            mean += *size as f64 * missed(size);
        }
        let kept = 1.0 - once / found;
        let deviation = (once - twice - mean * mean / n).max(0.0).sqrt();
        let (middle, half) = (found / kept - found, QUANTILE * deviation / kept);
        [(middle - half).max(0.0), middle + half]
    }

    fn curve(&self, sizes: &[usize], unseen: f64, points: usize) -> Vec<Rarefied> {
        let total = self.members;
        // Kinds of equal size share their α.
        let mut kinds: Vec<(usize, f64, f64)> = Vec::new();
        let mut sorted = sizes.to_vec();
        sorted.sort_unstable();
        for chunk in sorted.chunk_by(|a, b| a == b) {
            kinds.push((chunk[0], chunk.len() as f64, 1.0));
        }
        let step = total.div_ceil(points).max(1);
        let mut curve = Vec::new();
        for drawn in 0..=total {
            if drawn % step == 0 || drawn == total {
                let share = |power| {
                    let kinds = kinds.iter();
                    kinds
                        .map(|(_, count, missed)| count * (1.0 - missed).powi(power))
                        .sum::<f64>()
                };
                let kinds = share(1);
                let spread = if self.kinds == 0 {
                    0.0
                } else {
                    share(2) - kinds * kinds / (self.kinds as f64 + unseen)
                };
                curve.push(Rarefied {
                    members: drawn,
                    kinds,
                    deviation: Some(spread.max(0.0).sqrt()),
                });
            }
            // α(n + 1) = α(n) (N − N_i − n)/(N − n).
            for (size, _, missed) in &mut kinds {
                let left = total.saturating_sub(*size + drawn);
                *missed *= left as f64 / (total - drawn).max(1) as f64;
            }
        }
        curve
    }

    fn extend_beyond(&mut self, unseen: f64, points: usize) {
        let total = self.members;
        let step = total.div_ceil(points).max(1);
        let chance = if unseen > 0.0 {
            (self.once as f64 / (total as f64 * unseen)).min(1.0)
        } else {
            0.0
        };
        for more in (1..=total).filter(|more| more % (2 * step) == 0 || *more == total) {
            let news = unseen * (1.0 - libm::pow(1.0 - chance, more as f64));
            self.curve.push(Rarefied {
                members: total + more,
                kinds: self.kinds as f64 + news,
                deviation: None,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(found: &Rarefaction, members: usize) -> Rarefied {
        let point = found.curve.iter().find(|point| point.members == members);
        *point.unwrap()
    }

    fn told(found: &Rarefaction) -> Completeness {
        found.estimate.unwrap()
    }

    /// Two kinds of four grasps allow no estimate: Chao's formula would give zero unseen kinds with certainty.
    #[test]
    fn too_few_for_an_estimate() {
        let few = Rarefaction::new(&[4, 4], 8);
        assert_eq!(few.estimate, None);
        assert_eq!(few.curve.last().unwrap().members, 8, "nothing beyond");
        assert!(Rarefaction::new(&[15, 14], 8).estimate.is_none());
        assert!(Rarefaction::new(&[15, 15], 8).estimate.is_some());
        let json = serde_json::to_value(&few).unwrap();
        assert!(json.get("unseen").is_none() && json.get("coverage").is_none());
    }

    #[test]
    fn small_sample_by_hand() {
        // Kinds of 3, 2, 1, 1, 1: N = 8, S = 5, f₁ = 3, f₂ = 1.
        let found = Rarefaction::with_least(0, &[3, 1, 2, 1, 0, 1], 8);
        assert_eq!(
            (found.members, found.kinds, found.once, found.twice),
            (8, 5, 3, 1)
        );
        // 7/8 · 3 · 2/(2 · 2).
        assert!((told(&found).unseen - 1.3125).abs() < 1e-12);
        // 1 − 3/8 · 21/23.
        assert!((told(&found).coverage - (1.0 - 63.0 / 184.0)).abs() < 1e-12);
        // A sample of two misses the kinds of three, two and one with probabilities 10/28, 15/28, 21/28.
        let two = at(&found, 2);
        assert!((two.kinds - (18.0 + 13.0 + 3.0 * 7.0) / 28.0).abs() < 1e-12);
        let squares = (18.0 * 18.0 + 13.0 * 13.0 + 3.0 * 49.0) / 784.0;
        let variance: f64 = squares - two.kinds * two.kinds / 6.3125;
        assert!((two.deviation.unwrap() - variance.sqrt()).abs() < 1e-12);
        assert!((at(&found, 1).kinds - 1.0).abs() < 1e-12);
        assert!(at(&found, 0).kinds.abs() < 1e-12);
        assert!((at(&found, 8).kinds - 5.0).abs() < 1e-12);
        // Two more: 1.3125 (1 − (1 − 3/10.5)²).
        let beyond = 5.0 + 1.3125 * (1.0 - (7.5_f64 / 10.5).powi(2));
        assert!((at(&found, 10).kinds - beyond).abs() < 1e-12);
        // Variance 1.3125 + 49/64 · (3 · 25/16 + 9 · 1 · 4/64) = 5.332031…, then the log-normal interval.
        let variance = 1.3125 + 49.0 / 64.0 * (75.0 / 16.0 + 36.0 / 64.0);
        let factor =
            libm::exp(1.959963985 * libm::log(1.0_f64 + variance / 1.3125_f64.powi(2)).sqrt());
        assert!((told(&found).unseen_interval[0] - 1.3125 / factor).abs() < 1e-6);
        assert!((told(&found).unseen_interval[1] - 1.3125 * factor).abs() < 1e-6);
    }

    #[test]
    fn no_twins() {
        // Four singletons: 3/4 · 4 · 3/2 = 4.5 unseen; variance 4.5 + 9/16 · (4 · 49/4 − 256/(4 · 8.5)).
        let found = Rarefaction::with_least(0, &[1; 4], 4);
        assert!((told(&found).unseen - 4.5).abs() < 1e-12);
        assert!(told(&found).coverage.abs() < 1e-12);
        let variance = 4.5 + 9.0 / 16.0 * (49.0 - 64.0 / 8.5);
        let factor = libm::exp(1.959963985 * libm::log(1.0_f64 + variance / 20.25).sqrt());
        assert!((told(&found).unseen_interval[1] - 4.5 * factor).abs() < 1e-5);
        // Every draw is a new kind.
        assert!((at(&found, 3).kinds - 3.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_unseen_where_all_were_met_often() {
        let found = Rarefaction::with_least(0, &[20, 31, 12], 16);
        assert!(told(&found).unseen.abs() < 1e-12);
        assert!((told(&found).coverage - 1.0).abs() < 1e-12);
        assert!(told(&found).unseen_interval[1] < 0.01);
        let last = found.curve.last().unwrap();
        assert_eq!(last.members, 126);
        assert!((last.kinds - 3.0).abs() < 1e-12);
    }

    #[test]
    fn curves_rise_and_bend_down() {
        let sizes: Vec<usize> = (1..40).map(|k| 60 / (k * k) + 1).collect();
        let found = Rarefaction::with_least(0, &sizes, 1000);
        for three in found.curve.windows(3) {
            let [a, b, c] = [three[0].kinds, three[1].kinds, three[2].kinds];
            assert!(b >= a - 1e-9);
            // The step doubles beyond the sample.
            let even = three[1].members - three[0].members == three[2].members - three[1].members;
            assert!(!even || c - b <= b - a + 1e-9);
        }
    }

    #[test]
    fn empty_and_single() {
        let empty = Rarefaction::with_least(0, &[], 10);
        assert_eq!((empty.members, empty.kinds), (0, 0));
        assert!(told(&empty).unseen.abs() < 1e-12);
        let lone = Rarefaction::with_least(0, &[1], 10);
        assert!(told(&lone).unseen.abs() < 1e-12 && told(&lone).coverage.abs() < 1e-12);
        assert!(
            told(&lone)
                .unseen_interval
                .iter()
                .all(|value| value.is_finite())
        );
    }
}
