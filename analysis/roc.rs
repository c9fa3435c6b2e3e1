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
    /// The curve from (0, 0) to (1, 1), by descending threshold: the shares of the negative and of the positive cases with
    /// this score or a higher one.
    pub(crate) points: Vec<[f64; 2]>,
    /// Area below the curve, 0 to 1; ½ for an uninformative score.
    pub(crate) area: f64,
    /// Standard error of the area, from the variances of the mean of ψ over each case's partners. E. R. `DeLong`, D. M.
    /// `DeLong` and D. L. Clarke-Pearson, Biometrics 44, 837 (1988). NaN if a class has a single case.
    pub(crate) standard_error: f64,
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Variance of the mean.
fn variance(values: &[f64]) -> f64 {
    let squares = values.iter().map(|value| (value - mean(values)).powi(2));
    squares.sum::<f64>() / (values.len() as f64 - 1.0) / values.len() as f64
}

impl Roc {
    /// The curve of scores that should be high in positive cases; `None` if a class is empty.
    pub(crate) fn new(positive: &[f64], negative: &[f64]) -> Option<Self> {
        if positive.is_empty() || negative.is_empty() {
            return None;
        }
        let psi = |x: f64, y: f64| 0.5 * f64::from(u8::from(x > y) + u8::from(x >= y));
        let rows = positive.iter().map(|&x| {
            let partners: Vec<f64> = negative.iter().map(|&y| psi(x, y)).collect();
            mean(&partners)
        });
        let columns = negative.iter().map(|&y| {
            let partners: Vec<f64> = positive.iter().map(|&x| psi(x, y)).collect();
            mean(&partners)
        });
        let (rows, columns): (Vec<f64>, Vec<f64>) = (rows.collect(), columns.collect());
        let mut thresholds = [positive, negative].concat();
        thresholds.sort_by(|a, b| b.total_cmp(a));
        thresholds.dedup();
        let share = |scores: &[f64], least: f64| {
            let above = scores.iter().filter(|score| **score >= least);
            above.count() as f64 / scores.len() as f64
        };
        let points = thresholds
            .iter()
            .map(|&t| [share(negative, t), share(positive, t)]);
        Some(Self {
            points: std::iter::once([0.0; 2]).chain(points).collect(),
            area: mean(&rows),
            standard_error: (variance(&rows) + variance(&columns)).sqrt(),
        })
    }

    /// The area with its 95 % interval, symmetric on the logit scale so that it stays within 0 and 1. There is none where the
    /// classes do not overlap or one of them has a single case.
    ///
    /// ```text
    /// logit A ± 1.96 SE/(A (1 − A))
    /// ```
    pub(crate) fn text(&self) -> String {
        let area = self.area;
        let logit = libm::log(area / (1.0 - area));
        let half = 1.96 * self.standard_error / (area * (1.0 - area));
        let [low, high] = [logit - half, logit + half].map(|l| 1.0 / (1.0 + libm::exp(-l)));
        if low.is_nan() || high.is_nan() {
            return format!("{area:.2}");
        }
        format!("{area:.2} ({low:.2}–{high:.2})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand 8/9, with variances 1/108 and 1/27 of the means over partners. logit 8/9 = ln 8; half-width 1.96 · 0.12423
    /// (8/81).
    #[test]
    fn six_cases_with_ties() {
        let roc = Roc::new(&[3.0, 2.0, 2.0], &[2.0, 1.0, 0.0]).unwrap();
        assert!((roc.area - 8.0 / 9.0).abs() < 1e-14);
        assert!((roc.standard_error - (5.0_f64 / 324.0).sqrt()).abs() < 1e-14);
        let third = 1.0 / 3.0;
        let expected = [
            [0.0, 0.0],
            [0.0, third],
            [third, 1.0],
            [2.0 * third, 1.0],
            [1.0, 1.0],
        ];
        assert_eq!(roc.points.len(), expected.len());
        for (point, expected) in roc.points.iter().zip(expected) {
            assert!((0..2).all(|k| (point[k] - expected[k]).abs() < 1e-14));
        }
        assert_eq!(roc.text(), "0.89 (0.40–0.99)");
    }

    #[test]
    fn perfect_reversed_and_missing_classes() {
        let perfect = Roc::new(&[f64::INFINITY, 2.0], &[1.0, f64::NEG_INFINITY]).unwrap();
        assert_eq!(perfect.text(), "1.00");
        assert_eq!(Roc::new(&[0.0, 1.0], &[2.0, 3.0]).unwrap().text(), "0.00");
        assert_eq!(Roc::new(&[1.0], &[0.0, 2.0]).unwrap().text(), "0.50");
        assert_eq!(Roc::new(&[], &[1.0]), None);
    }
}
