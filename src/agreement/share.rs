//! Shares of cases.

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
