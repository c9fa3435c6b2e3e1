//! Numbers on pairs of cases.

/// A symmetric matrix without its diagonal: one number per pair of cases, NaN if it is not known.
///
/// Saddle heights between basins are *ultrametric* (of any three the two largest are equal) and form a tree. Relative
/// barriers, saddle height − max(Eᵢ, Eⱼ), are not ultrametric.
#[derive(Debug, Clone, PartialEq)]
pub struct PairMatrix {
    size: usize,
    /// Pairs (0, 1), (0, 2), …, (1, 2), …
    values: Vec<f64>,
}

impl PairMatrix {
    /// The matrix of `value(i, j)`, i < j, of `size` cases.
    pub fn from_fn(size: usize, mut value: impl FnMut(usize, usize) -> f64) -> Self {
        let pairs = (0..size).flat_map(|i| (i + 1..size).map(move |j| (i, j)));
        Self {
            size,
            values: pairs.map(|(i, j)| value(i, j)).collect(),
        }
    }

    /// Number of cases.
    pub fn size(&self) -> usize {
        self.size
    }

    /// All pairs: (0, 1), (0, 2), …, (1, 2), …
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// All pairs i < j with their numbers, in the order of [`PairMatrix::values`].
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let all = (0..self.size).flat_map(|i| (i + 1..self.size).map(move |j| (i, j)));
        all.zip(&self.values).map(|((i, j), &value)| (i, j, value))
    }

    /// The number of a pair, in either order.
    ///
    /// # Panics
    /// If a case does not exist, or both are the same.
    #[inline]
    pub fn get(&self, i: usize, j: usize) -> f64 {
        assert!(i != j, "a pair is two cases");
        let (low, high) = (i.min(j), i.max(j));
        self.values[low * self.size - low * (low + 1) / 2 + high - low - 1]
    }

    /// Number of pairs that are not known.
    pub fn unknown(&self) -> usize {
        self.values.iter().filter(|value| value.is_nan()).count()
    }

    /// Replaces unknown numbers by one above all others: m + (`factor` − 1)·|m| with m the largest (`factor`·m if m is
    /// positive).
    ///
    /// A saddle height without a path is censored: it is at least as high as the energies searched. With a factor of 1.1
    /// such pairs are the last to be joined. Repeat the analysis with them left out (NaN).
    #[must_use]
    pub fn raised(&self, factor: f64) -> Self {
        let known = self.values.iter().filter(|value| !value.is_nan());
        let largest = known.copied().fold(f64::NEG_INFINITY, f64::max);
        let high = largest + (factor - 1.0) * largest.abs();
        let fill = |&value: &f64| if value.is_nan() { high } else { value };
        Self {
            size: self.size,
            values: self.values.iter().map(fill).collect(),
        }
    }

    /// The matrix of chosen cases, which may be in another order or repeated (a bootstrap sample). Pairs of a case with
    /// itself get `same`: 0 for distances, NaN to leave them out.
    ///
    /// # Panics
    /// If a case does not exist.
    #[must_use]
    pub fn chosen(&self, cases: &[usize], same: f64) -> Self {
        Self::from_fn(cases.len(), |a, b| {
            if cases[a] == cases[b] {
                same
            } else {
                self.get(cases[a], cases[b])
            }
        })
    }

    /// Replaces each number by its rank among the known ones, from 1; ties share their mean rank.
    #[must_use]
    pub fn ranks(&self) -> Self {
        Self {
            size: self.size,
            values: ranks(&self.values),
        }
    }
}

/// Ranks from 1; ties share their mean rank, and NaN stays NaN.
pub(super) fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).filter(|&i| !values[i].is_nan()).collect();
    // Positive and negative zero are equal.
    order.sort_by(|&a, &b| (values[a] + 0.0).total_cmp(&(values[b] + 0.0)));
    let mut ranks = vec![f64::NAN; values.len()];
    let mut before = 0;
    for tied in order.chunk_by(|&a, &b| (values[a] + 0.0).total_cmp(&(values[b] + 0.0)).is_eq()) {
        for &i in tied {
            ranks[i] = before as f64 + 0.5 * (tied.len() as f64 + 1.0);
        }
        before += tied.len();
    }
    ranks
}

/// The median of the numbers that are not NaN; NaN if there are none.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.retain(|value| !value.is_nan());
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 {
        f64::NAN
    } else {
        f64::midpoint(values[(n - 1) / 2], values[n / 2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_in_either_order_and_chosen_again() {
        let matrix = PairMatrix::from_fn(4, |i, j| (10 * i + j) as f64);
        assert_eq!(matrix.values(), [1.0, 2.0, 3.0, 12.0, 13.0, 23.0]);
        for (i, j, value) in matrix.pairs() {
            assert_eq!(matrix.get(j, i).to_bits(), value.to_bits());
        }
        let again = matrix.chosen(&[2, 0, 2], 0.0);
        assert_eq!(again.values(), [2.0, 0.0, 2.0]);
        assert_eq!(PairMatrix::from_fn(1, |_, _| 0.0).values().len(), 0);
    }

    #[test]
    fn unknown_pairs_are_raised_above_all_others() {
        let matrix = PairMatrix::from_fn(3, |i, j| if i + j == 2 { f64::NAN } else { 2.0 });
        assert_eq!(matrix.unknown(), 1);
        assert_eq!(matrix.raised(1.5).values(), [2.0, 3.0, 2.0]);
        let negative = PairMatrix::from_fn(3, |i, j| if i + j == 2 { f64::NAN } else { -2.0 });
        assert_eq!(negative.raised(1.5).values(), [-2.0, -1.0, -2.0]);
    }

    #[test]
    fn ties_share_ranks() {
        assert_eq!(ranks(&[0.0, 5.0, -0.0, 1.0]), [1.5, 4.0, 1.5, 3.0]);
        assert!(ranks(&[1.0, f64::NAN])[1].is_nan());
        assert_eq!(
            median(vec![4.0, f64::NAN, 1.0, 2.0]).to_bits(),
            2.0_f64.to_bits()
        );
        assert!(median(Vec::new()).is_nan());
    }
}
