//! Shares of cases, and how two of them differ.

/// 95 % quantile of the normal distribution, two-sided.
const QUANTILE: f64 = 1.959_964;

/// The 95 % interval of the share `count`/`of`: E. B. Wilson, J. Am. Stat. Assoc. 22, 209 (1927).
///
/// It is never empty, also where no case or every case counts.
///
/// ```
/// let [low, high] = landscape::agreement::wilson(20.0, 20.0);
/// assert!((low - 0.839).abs() < 0.001 && high == 1.0);
/// ```
pub fn wilson(count: f64, of: f64) -> [f64; 2] {
    const Z: f64 = QUANTILE;
    let share = count / of;
    let scale = 1.0 + Z * Z / of;
    let middle = (share + Z * Z / (2.0 * of)) / scale;
    let half = Z / scale * (share * (1.0 - share) / of + Z * Z / (4.0 * of * of)).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

/// The probability that chance alone splits cases at least as unevenly as into `wins` and `losses`: the exact two-sided
/// sign test, which for two outcomes of the same cases is the exact form of the test of `McNemar`.
///
/// ```text
/// p = min(1, 2 Σ_{k ≤ min(w, l)} C(n, k)/2ⁿ),   n = w + l
/// ```
///
/// Q. `McNemar`, Psychometrika 12, 153 (1947), without cases that do not differ.
///
/// ```
/// assert!((landscape::agreement::sign_test(1, 9) - 22.0 / 1024.0).abs() < 1e-12);
/// ```
pub fn sign_test(wins: usize, losses: usize) -> f64 {
    let n = (wins + losses) as f64;
    // Logarithms, because 2ⁿ may be beyond all numbers.
    let mut term = -n * std::f64::consts::LN_2;
    let mut tail = 0.0;
    for k in 0..=wins.min(losses) {
        tail += libm::exp(term);
        term += libm::log((n - k as f64) / (k as f64 + 1.0));
    }
    (2.0 * tail).min(1.0)
}
