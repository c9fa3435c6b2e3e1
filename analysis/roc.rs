//! Receiver operating characteristics: how well a score separates two classes.

/// True positive rate against false positive rate, for every threshold of a score.
///
/// ```text
/// AUC = 1/(m n) Σᵢⱼ ψ(xᵢ, yⱼ),   ψ = 1 if x > y, ½ if x = y, 0 if x < y
/// ```
///
/// xᵢ: scores of the m positive cases; yⱼ: scores of the n negative cases. The AUC is the probability that a positive case
/// has the higher score, which is the Mann–Whitney statistic, and the area below the curve. Ties are its sloping pieces.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Roc {
    /// The curve from (0, 0) to (1, 1), by descending threshold.
    pub(crate) points: Vec<RocPoint>,
    /// Area below the curve, 0 to 1; ½ for an uninformative score.
    pub(crate) area: f64,
    /// Standard error of the area.
    ///
    /// E. R. `DeLong`, D. M. `DeLong` and D. L. Clarke-Pearson, Biometrics 44, 837 (1988): the variances of the mean of ψ
    /// over each case's partners, computed by ranks as in X. Sun and W. Xu, IEEE Signal Process. Lett. 21, 1389 (2014).
    /// Zero if the classes do not overlap, and NaN if one of them has a single case.
    pub(crate) standard_error: f64,
    /// Number of positive cases m.
    pub(crate) positives: usize,
    /// Number of negative cases n.
    pub(crate) negatives: usize,
}

/// A point on the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RocPoint {
    /// Cases with this score or a higher one are called positive; +∞ at the first point.
    pub(crate) threshold: f64,
    /// Share of the negative cases called positive.
    pub(crate) false_positive_rate: f64,
    /// Share of the positive cases called positive.
    pub(crate) true_positive_rate: f64,
}

/// Why a curve cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum RocError {
    /// The numbers of scores and classes differ.
    #[error("there are {scores} scores, but {classes} classes: every case needs one of each")]
    Lengths {
        /// Number of scores.
        scores: usize,
        /// Number of classes.
        classes: usize,
    },
    /// A class without cases.
    #[error(
        "there are {positives} positive and {negatives} negative cases, but some of both are needed"
    )]
    OneClass {
        /// Number of positive cases.
        positives: usize,
        /// Number of negative cases.
        negatives: usize,
    },
    /// A score that cannot be ordered.
    #[error("the score of case {case} is not a number")]
    NotANumber {
        /// The case, from zero.
        case: usize,
    },
}

impl Roc {
    /// The curve of `scores`, where high scores indicate a positive case. Infinite scores are allowed.
    ///
    /// # Errors
    /// If the lists differ in length, a class is empty or a score is NaN.
    pub(crate) fn new(scores: &[f64], positive: &[bool]) -> Result<Self, RocError> {
        let mut cases = sorted(scores, positive)?;
        let positives = positive.iter().filter(|&&is| is).count();
        let negatives = positive.len() - positives;
        let (m, n) = (positives as f64, negatives as f64);
        let mut points = vec![RocPoint {
            threshold: f64::INFINITY,
            false_positive_rate: 0.0,
            true_positive_rate: 0.0,
        }];
        // Number of cases above the tied ones, for each class.
        let (mut above, mut false_above) = (0.0, 0.0);
        let (mut over_positives, mut over_negatives) = (Spread::default(), Spread::default());
        cases.reverse();
        for tied in cases.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()) {
            let hits = tied.iter().filter(|(_, is)| *is).count() as f64;
            let misses = tied.len() as f64 - hits;
            // Mean of ψ over the partners of each tied case.
            over_positives.add(hits, (n - false_above - 0.5 * misses) / n);
            over_negatives.add(misses, (above + 0.5 * hits) / m);
            above += hits;
            false_above += misses;
            points.push(RocPoint {
                threshold: tied[0].0,
                false_positive_rate: false_above / n,
                true_positive_rate: above / m,
            });
        }
        Ok(Self {
            points,
            area: over_positives.mean(),
            standard_error: (over_positives.variance() / m + over_negatives.variance() / n).sqrt(),
            positives,
            negatives,
        })
    }

    /// Interval of the area for `deviates` standard normal deviates (1.96: 95 %), symmetric on the logit scale so that it
    /// stays within 0 and 1.
    ///
    /// ```text
    /// logit A ± z SE/(A (1 − A))
    /// ```
    ///
    /// If the classes do not overlap the variance is unknown, and the uncertain side is [`f64::NAN`].
    pub(crate) fn interval(&self, deviates: f64) -> [f64; 2] {
        let area = self.area;
        if area >= 1.0 {
            return [f64::NAN, 1.0];
        }
        if area <= 0.0 {
            return [0.0, f64::NAN];
        }
        let logit = libm::log(area / (1.0 - area));
        let half = deviates * self.standard_error / (area * (1.0 - area));
        [logit - half, logit + half].map(|l| 1.0 / (1.0 + libm::exp(-l)))
    }
}

/// Scores in ascending order, with their classes.
fn sorted(scores: &[f64], positive: &[bool]) -> Result<Vec<(f64, bool)>, RocError> {
    if scores.len() != positive.len() {
        return Err(RocError::Lengths {
            scores: scores.len(),
            classes: positive.len(),
        });
    }
    let positives = positive.iter().filter(|&&is| is).count();
    if positives == 0 || positives == positive.len() {
        return Err(RocError::OneClass {
            positives,
            negatives: positive.len() - positives,
        });
    }
    if let Some(case) = scores.iter().position(|score| score.is_nan()) {
        return Err(RocError::NotANumber { case });
    }
    let mut cases: Vec<(f64, bool)> = scores
        .iter()
        // Positive and negative zero are equal.
        .map(|score| score + 0.0)
        .zip(positive.iter().copied())
        .collect();
    cases.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(cases)
}

/// Mean and variance of values with frequency weights.
#[derive(Debug, Clone, Copy, Default)]
struct Spread {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Spread {
    /// Adds the same value `count` times (West's update).
    fn add(&mut self, count: f64, value: f64) {
        if count == 0.0 {
            return;
        }
        let total = self.count + count;
        let off = value - self.mean;
        self.mean += off * count / total;
        self.squares += off * off * count * self.count / total;
        self.count = total;
    }

    fn mean(&self) -> f64 {
        self.mean
    }

    /// Unbiased variance; NaN for one value.
    fn variance(&self) -> f64 {
        self.squares / (self.count - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use landscape::sample::{Task, stream};

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-14
    }

    /// Positives 3, 2, 2 against negatives 2, 1, 0: by hand 8/9, with variances 1/108 and 1/27 of the means over partners.
    #[test]
    fn six_cases_with_ties() {
        let scores = [3.0, 1.0, 2.0, 2.0, 0.0, 2.0];
        let positive = [true, false, true, false, false, true];
        let roc = Roc::new(&scores, &positive).unwrap();
        assert_eq!((roc.positives, roc.negatives), (3, 3));
        assert!(close(roc.area, 8.0 / 9.0));
        assert!(close(roc.standard_error, (5.0_f64 / 324.0).sqrt()));
        let third = 1.0 / 3.0;
        let expected = [
            (f64::INFINITY, 0.0, 0.0),
            (3.0, 0.0, third),
            (2.0, third, 1.0),
            (1.0, 2.0 * third, 1.0),
            (0.0, 1.0, 1.0),
        ];
        assert_eq!(roc.points.len(), expected.len());
        for (point, (threshold, false_rate, true_rate)) in roc.points.iter().zip(expected) {
            assert_eq!(point.threshold.to_bits(), f64::to_bits(threshold));
            assert!(close(point.false_positive_rate, false_rate));
            assert!(close(point.true_positive_rate, true_rate));
        }
        let [low, high] = roc.interval(1.96);
        // logit 8/9 = ln 8; half-width 1.96 · 0.12423 / (8/81).
        let half = 1.96 * (5.0_f64 / 324.0).sqrt() * 81.0 / 8.0;
        assert!(
            close(low, 8.0 / (8.0 + libm::exp(half)))
                && close(high, 8.0 / (8.0 + libm::exp(-half)))
        );
    }

    #[test]
    fn perfect_reversed_and_ignorant_scores() {
        let positive = [true, true, false, false];
        let area = |scores: [f64; 4]| Roc::new(&scores, &positive).unwrap();
        let perfect = area([f64::INFINITY, 2.0, 1.0, f64::NEG_INFINITY]);
        assert!(close(perfect.area, 1.0) && perfect.standard_error == 0.0);
        assert!(perfect.interval(1.96)[0].is_nan() && close(perfect.interval(1.96)[1], 1.0));
        let reversed = area([0.0, 1.0, 2.0, 3.0]);
        assert!(close(reversed.area, 0.0) && reversed.interval(1.96)[1].is_nan());
        let same = area([0.0, -0.0, 0.0, -0.0]);
        assert!(close(same.area, 0.5));
        assert_eq!(same.points.len(), 2);
    }

    #[test]
    fn cases_that_make_no_curve() {
        assert_eq!(
            Roc::new(&[1.0], &[true, false]),
            Err(RocError::Lengths {
                scores: 1,
                classes: 2
            })
        );
        assert!(matches!(
            Roc::new(&[1.0, 2.0], &[true, true]),
            Err(RocError::OneClass { .. })
        ));
        assert_eq!(
            Roc::new(&[1.0, f64::NAN], &[true, false]),
            Err(RocError::NotANumber { case: 1 })
        );
        let one = Roc::new(&[1.0, 0.0, 2.0], &[true, false, false]).unwrap();
        assert!(close(one.area, 0.5) && one.standard_error.is_nan());
    }

    /// Area and standard error against their definitions, pair by pair, and the trapezia below the curve; and the standard
    /// error against the scatter of many samples.
    #[test]
    fn ranks_agree_with_pairs_and_with_repetition() {
        let mut rng = stream(1, Task::Resampling, 0);
        let (mut areas, mut errors) = (Vec::new(), Vec::new());
        for _ in 0..300 {
            let positive: Vec<bool> = (0..60).map(|i| i % 3 == 0).collect();
            // Whole numbers, so that many are tied.
            let scores: Vec<f64> = positive
                .iter()
                .map(|&is| f64::from(rng.random_range(0..9u8) + 3 * u8::from(is)))
                .collect();
            let roc = Roc::new(&scores, &positive).unwrap();
            let of = |class: bool| -> Vec<f64> {
                let both = scores.iter().zip(&positive);
                both.filter(|(_, is)| **is == class)
                    .map(|(score, _)| *score)
                    .collect()
            };
            let (x, y) = (of(true), of(false));
            let psi =
                |x: f64, y: f64| 0.5 * (f64::from(u8::from(x > y)) + f64::from(u8::from(x >= y)));
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let rows: Vec<f64> = x
                .iter()
                .map(|&x| mean(&y.iter().map(|&y| psi(x, y)).collect::<Vec<_>>()))
                .collect();
            let columns: Vec<f64> = y
                .iter()
                .map(|&y| mean(&x.iter().map(|&x| psi(x, y)).collect::<Vec<_>>()))
                .collect();
            let variance = |values: &[f64]| {
                let squares = values
                    .iter()
                    .map(|v| (v - mean(values)).powi(2))
                    .sum::<f64>();
                squares / (values.len() - 1) as f64 / values.len() as f64
            };
            assert!((roc.area - mean(&rows)).abs() < 1e-12);
            let error = (variance(&rows) + variance(&columns)).sqrt();
            assert!((roc.standard_error - error).abs() < 1e-12);
            let trapezia: f64 = roc
                .points
                .windows(2)
                .map(|p| {
                    let width = p[1].false_positive_rate - p[0].false_positive_rate;
                    0.5 * width * (p[0].true_positive_rate + p[1].true_positive_rate)
                })
                .sum();
            assert!((roc.area - trapezia).abs() < 1e-12);
            areas.push(roc.area);
            errors.push(error);
        }
        let mean = areas.iter().sum::<f64>() / 300.0;
        let scatter = (areas.iter().map(|a| (a - mean).powi(2)).sum::<f64>() / 299.0).sqrt();
        let error = errors.iter().sum::<f64>() / 300.0;
        // The scatter of 300 samples is known to 4 %.
        assert!((scatter / error - 1.0).abs() < 0.15, "{scatter} {error}");
    }

    #[test]
    fn a_tied_pair_counts_half() {
        // Of the six pairs of a positive and a negative case five are in order and one is tied.
        let scores = [0.9, 0.4, 0.4, 0.1, 0.2];
        let roc = Roc::new(&scores, &[true, true, false, false, false]).unwrap();
        assert!((roc.area - 5.5 / 6.0).abs() < 1e-15);
    }
}
