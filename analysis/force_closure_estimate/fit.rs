//! Fits of ‖Gc‖ as a function of μ₀.

use super::line::Line;
use super::sets::Set;

/// Fits to the sets with μ₀ up to a limit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fit {
    pub(crate) sets: usize,
    /// Least squares of ‖Gc‖ = a μ₀.
    pub(crate) through_origin: f64,
    /// Least squares of ‖Gc‖ = a μ₀ + b.
    pub(crate) line: Line,
    /// Pearson's r.
    pub(crate) correlation: f64,
}

/// The sets with μ₀ ≤ `limit`. `sets` must be in ascending order of μ₀.
fn up_to(sets: &[Set], limit: f64) -> &[Set] {
    &sets[..sets.partition_point(|set| set.least_friction <= limit)]
}

impl Fit {
    /// Fits to the sets with μ₀ ≤ `limit`. `sets` must be in ascending order of μ₀.
    pub(crate) fn up_to(sets: &[Set], limit: f64) -> Self {
        let points: Vec<[f64; 2]> = up_to(sets, limit)
            .iter()
            .map(|set| [set.least_friction, set.verdict.net_wrench])
            .collect();
        let line = Line::through(&points);
        Self {
            sets: points.len(),
            through_origin: slope_through_origin(&points),
            line,
            correlation: line.r_squared.sqrt().copysign(line.slope),
        }
    }
}

fn slope_through_origin(points: &[[f64; 2]]) -> f64 {
    let sum = |product: fn(&[f64; 2]) -> f64| points.iter().map(product).sum::<f64>();
    sum(|[x, y]| x * y) / sum(|[x, _]| x * x)
}

/// The limit of μ₀ between the given two at which the slope through the origin is `slope`. The slope falls with the limit.
pub(crate) fn limit_with_slope(sets: &[Set], slope: f64, between: [f64; 2]) -> f64 {
    let [mut low, mut high] = between;
    while high - low > 1e-6 {
        let middle = 0.5 * (low + high);
        if Fit::up_to(sets, middle).through_origin > slope {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
