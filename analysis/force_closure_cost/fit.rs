//! Straight lines fitted to costs.

use crate::line::Line;

/// t = a log₁₀ n + b, as in the paper.
pub(crate) fn logarithm(contacts: &[usize], costs: &[f64]) -> Line {
    line(contacts, costs, libm::log10)
}

/// t = a n + b.
pub(crate) fn proportion(contacts: &[usize], costs: &[f64]) -> Line {
    line(contacts, costs, |n| n)
}

fn line(contacts: &[usize], costs: &[f64], x: impl Fn(f64) -> f64) -> Line {
    let points: Vec<[f64; 2]> = contacts
        .iter()
        .zip(costs)
        .map(|(&n, &t)| [x(n as f64), t])
        .collect();
    Line::through(&points)
}
