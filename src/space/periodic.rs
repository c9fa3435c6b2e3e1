//! Coordinates that wrap, each with a period of its own: a periodic box.

use std::ops::Range;

use super::Space;
use super::vector::norm;

/// Coordinates in a cell with periodic images; distances are measured to the nearest image. A period of ∞ leaves a
/// coordinate unwrapped. Points that are moved as a whole differ: of atoms that all move, keep one fixed.
///
/// `exp` keeps a coordinate within half a period of the middle of the cell.
///
/// ```
/// use landscape::space::{Periodic, Space};
///
/// // x in a cell of length 3, y free.
/// let cell = Periodic::new(&[0.0, 0.0], &[3.0, f64::INFINITY]);
/// assert!((cell.distance(&[0.1, 0.0], &[2.9, 0.0]) - 0.2).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Periodic {
    low: Vec<f64>,
    periods: Vec<f64>,
}

impl Periodic {
    /// Cells from `low`, with these periods.
    ///
    /// # Panics
    /// If the two differ in length, or a period is not positive.
    pub fn new(low: &[f64], periods: &[f64]) -> Self {
        assert_eq!(low.len(), periods.len(), "a coordinate has a period");
        assert!(
            periods.iter().all(|period| *period > 0.0),
            "a period is positive"
        );
        Self {
            low: low.to_vec(),
            periods: periods.to_vec(),
        }
    }

    pub(super) fn period(&self, k: usize) -> f64 {
        self.periods[k]
    }

    /// A difference of coordinate `k`, to the nearest image.
    pub(super) fn wrapped(&self, difference: f64, k: usize) -> f64 {
        wrapped(difference, self.periods[k])
    }

    /// The points on circles of these periods, and unwrapped coordinates, for some of the coordinates.
    pub(super) fn landmarks_of(&self, x: &[f64], wanted: Range<usize>) -> Vec<f64> {
        let coordinates = x.iter().zip(&self.periods);
        coordinates
            .take(wanted.end)
            .skip(wanted.start)
            .flat_map(|(value, period)| {
                if period.is_finite() {
                    let radius = period / std::f64::consts::TAU;
                    let angle = value / radius;
                    vec![radius * libm::cos(angle), radius * libm::sin(angle)]
                } else {
                    vec![*value]
                }
            })
            .collect()
    }
}

/// The equivalent number in [−period/2, period/2]; odd.
fn wrapped(value: f64, period: f64) -> f64 {
    if period.is_finite() {
        value - period * (value / period).round()
    } else {
        value
    }
}

impl Space for Periodic {
    fn coordinates(&self) -> usize {
        self.periods.len()
    }

    fn tangents(&self) -> usize {
        self.periods.len()
    }

    fn exp(&self, x: &mut [f64], tangent: &[f64]) {
        let count = self.periods.len();
        assert_eq!((x.len(), tangent.len()), (count, count));
        for (k, (coordinate, step)) in x.iter_mut().zip(tangent).enumerate() {
            let (low, period) = (self.low[k], self.periods[k]);
            let moved = *coordinate + step;
            let middle = if period.is_finite() {
                low + 0.5 * period
            } else {
                0.0
            };
            *coordinate = middle + wrapped(moved - middle, period);
        }
    }

    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        let count = self.periods.len();
        assert_eq!((a.len(), b.len(), tangent.len()), (count, count, count));
        for (k, step) in tangent.iter_mut().enumerate() {
            *step = wrapped(b[k] - a[k], self.periods[k]);
        }
        norm(tangent)
    }

    fn log_other_way(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> Option<f64> {
        self.log(a, b, tangent);
        // The coordinate that is nearest to half of its period.
        let shares = tangent.iter().zip(&self.periods);
        let widest = shares
            .map(|(step, period)| step.abs() / period)
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let (k, share) = widest?;
        if share == 0.0 {
            return None;
        }
        tangent[k] -= self.periods[k].copysign(tangent[k]);
        Some(norm(tangent))
    }

    fn landmarks(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), self.periods.len());
        self.landmarks_of(x, 0..x.len())
    }
}
