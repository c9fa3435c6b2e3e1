//! Fisher's exact test for two proportions.

/// Probability that the first of two samples has at least this many successes if both are drawn from one population.
///
/// ```text
/// p = Σ C(K, k) C(N − K, n − k) / C(N, n)   over k ≥ successes[0]
/// ```
///
/// `successes`, `sizes`: of both samples; N, K: of both together; n: size of the first. 1 if a sample is empty.
/// R. A. Fisher: The Design of Experiments (1935), chapter 2.
///
/// # Panics
/// If a sample has more successes than members.
pub(super) fn fisher_exact(successes: [usize; 2], sizes: [usize; 2]) -> f64 {
    assert!(
        successes[0] <= sizes[0] && successes[1] <= sizes[1],
        "more successes than members"
    );
    let (all, hits) = (sizes[0] + sizes[1], successes[0] + successes[1]);
    let logarithms: Vec<f64> = (0..=all)
        .scan(0.0, |sum, k| {
            *sum += libm::log(k.max(1) as f64);
            Some(*sum)
        })
        .collect();
    let ways = |n: usize, k: usize| logarithms[n] - logarithms[k] - logarithms[n - k];
    let least = successes[0].max((hits + sizes[0]).saturating_sub(all));
    let tail = least..=hits.min(sizes[0]);
    tail.map(|k| libm::exp(ways(hits, k) + ways(all - hits, sizes[0] - k) - ways(all, sizes[0])))
        .sum::<f64>()
        .min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_counted_by_hand() {
        // The lady who names three of four cups correctly, then all four: one way of seventy.
        assert!((fisher_exact([3, 1], [4, 4]) - 17.0 / 70.0).abs() < 1e-12);
        assert!((fisher_exact([4, 0], [4, 4]) - 1.0 / 70.0).abs() < 1e-12);
        // R: fisher.test(matrix(c(8, 2, 1, 5), 2), alternative = "greater")$p.value
        assert!((fisher_exact([8, 1], [10, 6]) - 0.024475524475524476).abs() < 1e-9);
        assert!((fisher_exact([0, 3], [5, 9]) - 1.0).abs() < 1e-12);
        assert!((fisher_exact([0, 0], [0, 3]) - 1.0).abs() < 1e-12);
    }
}
