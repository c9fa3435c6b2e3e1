//! Agreement of two partitions of the same cases, and of classes with the cuts of a tree.

use super::Dendrogram;
use super::test::sizes;

/// Number of cases in class a of one partition and class b of the other.
fn table(first: &[usize], second: &[usize]) -> Vec<Vec<usize>> {
    assert_eq!(
        first.len(),
        second.len(),
        "both partitions are of the same cases"
    );
    let columns = second.iter().max().map_or(0, |most| most + 1);
    let mut table = vec![vec![0; columns]; first.iter().max().map_or(0, |most| most + 1)];
    for (&a, &b) in first.iter().zip(second) {
        table[a][b] += 1;
    }
    table
}

fn pairs(count: usize) -> f64 {
    count as f64 * (count as f64 - 1.0) / 2.0
}

/// Adjusted Rand index of two partitions.
///
/// ```text
/// ARI = (S − E)/(½ (A + B) − E),   S = Σ C(nₐᵦ, 2),  A = Σ C(nₐ, 2),  B = Σ C(nᵦ, 2),  E = A B / C(n, 2)
/// ```
///
/// 1 if they are the same, 0 on average over random partitions of the same sizes. L. Hubert and P. Arabie, J. Classif. 2,
/// 193 (1985). 1 if both are one cluster or both consist of singletons.
///
/// # Panics
/// If the lists differ in length.
///
/// # Examples
/// ```
/// use landscape::agreement::adjusted_rand;
///
/// assert!((adjusted_rand(&[0, 0, 1, 1], &[0, 0, 1, 2]) - 4.0 / 7.0).abs() < 1e-15);
/// ```
pub fn adjusted_rand(first: &[usize], second: &[usize]) -> f64 {
    let both: f64 = table(first, second)
        .iter()
        .flatten()
        .map(|&n| pairs(n))
        .sum();
    let of = |labels: &[usize]| sizes(labels).into_iter().map(pairs).sum::<f64>();
    let (a, b) = (of(first), of(second));
    adjusted_rand_of_pairs(both, [a, b], pairs(first.len()))
}

/// [`adjusted_rand`] from the numbers of pairs of cases that are together in both partitions, in each, and at all.
pub(crate) fn adjusted_rand_of_pairs(both: f64, [a, b]: [f64; 2], all: f64) -> f64 {
    let expected = a * b / all.max(1.0);
    let most = f64::midpoint(a, b);
    if (most - expected).abs() < 1e-12 * most.max(1.0) {
        1.0
    } else {
        (both - expected) / (most - expected)
    }
}

/// Adjusted mutual information of two partitions, natural logarithms.
///
/// ```text
/// AMI = (I − E I)/(½ (H₁ + H₂) − E I)
/// E I = Σₐᵦ Σₙ n/N ln(N n / (nₐ nᵦ)) · hypergeometric(n; nₐ, nᵦ, N)
/// ```
///
/// N. X. Vinh, J. Epps and J. Bailey, J. Mach. Learn. Res. 11, 2837 (2010), normalised by the mean of the entropies. Unlike
/// raw or normalised mutual information it does not rise with the number of clusters.
///
/// # Panics
/// If the lists differ in length.
pub fn adjusted_mutual_information(first: &[usize], second: &[usize]) -> f64 {
    let total = first.len() as f64;
    let (rows, columns) = (sizes(first), sizes(second));
    let occurring = |sizes: &[usize]| sizes.iter().filter(|n| **n > 0).count();
    if occurring(&rows) == occurring(&columns)
        && (occurring(&rows) <= 1 || occurring(&rows) == first.len())
    {
        return 1.0;
    }
    let entropy = |sizes: &[usize]| -> f64 {
        let shares = sizes.iter().filter(|n| **n > 0).map(|&n| n as f64 / total);
        -shares.map(|p| p * libm::log(p)).sum::<f64>()
    };
    let mut information = 0.0;
    for (row, &a) in table(first, second).iter().zip(&rows) {
        for (&n, &b) in row.iter().zip(&columns) {
            if n > 0 {
                let n = n as f64;
                information += n / total * libm::log(total * n / (a as f64 * b as f64));
            }
        }
    }
    let expected = expected_information(&rows, &columns, first.len());
    let most = 0.5 * (entropy(&rows) + entropy(&columns));
    // If chance alone reaches the maximum, nothing is left to explain.
    let rest = most - expected;
    let rest = if rest < 0.0 {
        rest.min(-f64::EPSILON)
    } else {
        rest.max(f64::EPSILON)
    };
    (information - expected) / rest
}

fn expected_information(rows: &[usize], columns: &[usize], count: usize) -> f64 {
    let mut factorials = vec![0.0; count + 1];
    for n in 1..=count {
        factorials[n] = factorials[n - 1] + libm::log(n as f64);
    }
    let log_factorial = |n: usize| factorials[n];
    let total = count as f64;
    let mut expected = 0.0;
    for &a in rows {
        for &b in columns {
            for n in (a + b).saturating_sub(count).max(1)..=a.min(b) {
                let ways = log_factorial(a)
                    + log_factorial(b)
                    + log_factorial(count - a)
                    + log_factorial(count - b)
                    - log_factorial(count)
                    - log_factorial(n)
                    - log_factorial(a - n)
                    - log_factorial(b - n)
                    - log_factorial(count + n - a - b);
                let information = libm::log(total * n as f64 / (a as f64 * b as f64));
                expected += n as f64 / total * information * libm::exp(ways);
            }
        }
    }
    expected
}

/// A comparison of two partitions: [`adjusted_rand`] or [`adjusted_mutual_information`].
pub type Comparison = fn(&[usize], &[usize]) -> f64;

/// Number of clusters and agreement with `labels` for every cut of a tree into `from` to `to` clusters.
///
/// A cut is at a height, so numbers of clusters that no height gives are missing. The highest of many values is high by
/// chance: to test it, permute the labels and take the highest value again ([`highest`] inside
/// [`test_labels`](super::test_labels)).
///
/// # Panics
/// If there is not one label per case.
pub fn agreement_of_cuts(
    tree: &Dendrogram,
    labels: &[usize],
    [from, to]: [usize; 2],
    compare: Comparison,
) -> Vec<(usize, f64)> {
    curve(&cuts_between(tree, [from, to]), labels, compare)
}

/// The cuts of a tree into `from` to `to` clusters, with their numbers of clusters; can be used for many labels.
pub fn cuts_between(tree: &Dendrogram, [from, to]: [usize; 2]) -> Vec<(usize, Vec<usize>)> {
    let counted = tree.cuts().into_iter().map(|cut| (sizes(&cut).len(), cut));
    counted
        .filter(|(clusters, _)| (from..=to).contains(clusters))
        .collect()
}

fn curve(cuts: &[(usize, Vec<usize>)], labels: &[usize], compare: Comparison) -> Vec<(usize, f64)> {
    let values = cuts
        .iter()
        .map(|(clusters, cut)| (*clusters, compare(labels, cut)));
    values.collect()
}

/// The highest agreement of any of the cuts with `labels`; NaN without cuts.
///
/// # Panics
/// If there is not one label per case.
pub fn highest(cuts: &[(usize, Vec<usize>)], labels: &[usize], compare: Comparison) -> f64 {
    let values = curve(cuts, labels, compare)
        .into_iter()
        .map(|(_, value)| value);
    values.fold(f64::NAN, f64::max)
}
