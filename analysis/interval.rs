//! Confidence intervals of shares.

/// Wilson's 95 % interval of the share `count` / `of`.
pub(crate) fn interval(count: f64, of: f64) -> [f64; 2] {
    const Z: f64 = 1.959_964;
    let share = count / of;
    let scale = 1.0 + Z * Z / of;
    let middle = (share + Z * Z / (2.0 * of)) / scale;
    let half = Z / scale * (share * (1.0 - share) / of + Z * Z / (4.0 * of * of)).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}
