//! A function with box constraints.

use std::fmt;

use super::Energy;
use crate::space::{Mirrored, Space};

/// A function of x in a box; its minima may lie inside, or on a face, an edge or a corner.
///
/// The box is unrolled ([`Mirrored`]), so that searches need no constraints: a constrained stationary point on a face is an
/// ordinary stationary point. The function is never evaluated outside the box. If the energy falls from a saddle on a face
/// inward, its two descents are mirror images and end in one minimum. Such a saddle joins nothing, like a rearrangement of
/// equal atoms.
///
/// ```
/// use landscape::energy::{Energy, InBox};
///
/// // Falls to the right: the minimum is on the face.
/// let energy = InBox::new(&[0.0], &[2.0], |x, gradient| {
///     gradient[0] = -1.0;
///     -x[0]
/// });
/// let mut gradient = [0.0];
/// assert!((energy.evaluate(&[std::f64::consts::PI], &mut gradient) + 2.0).abs() < 1e-12);
/// assert!(gradient[0].abs() < 1e-12);
/// ```
pub struct InBox<F> {
    space: Mirrored,
    function: F,
}

impl<F: Fn(&[f64], &mut [f64]) -> f64 + Sync> InBox<F> {
    /// `function` on the box from `low` to `high`. It returns the value at x and writes the derivative along each
    /// coordinate of x. Infinity and NaN mean a point outside its domain.
    ///
    /// # Panics
    /// If the ends differ in length, or a side is not positive and finite.
    pub fn new(low: &[f64], high: &[f64], function: F) -> Self {
        Self {
            space: Mirrored::new(low, high),
            function,
        }
    }

    /// The point of the box at the coordinates of a minimum or of an image of a path.
    ///
    /// # Panics
    /// If `coordinates` have the wrong length.
    pub fn point(&self, coordinates: &[f64]) -> Vec<f64> {
        self.space.point(coordinates)
    }

    /// Coordinates of a point of the box, the reverse of [`InBox::point`]. A point outside is first moved to the nearest face.
    ///
    /// # Panics
    /// If `point` has the wrong length.
    pub fn coordinates(&self, point: &[f64]) -> Vec<f64> {
        self.space.unrolled(point)
    }

    /// Least and greatest coordinates of the box, between which random starts are drawn.
    pub fn region(&self) -> (Vec<f64>, Vec<f64>) {
        self.space.copy()
    }
}

impl<F> fmt::Debug for InBox<F> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = formatter.debug_struct("InBox");
        shown.field("space", &self.space).finish_non_exhaustive()
    }
}

impl<F: Fn(&[f64], &mut [f64]) -> f64 + Sync> Energy for InBox<F> {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let value = (self.function)(&self.space.point(x), gradient);
        for (slope, stretch) in gradient.iter_mut().zip(self.space.slopes(x)) {
            *slope *= stretch;
        }
        if value.is_finite() {
            value
        } else {
            f64::INFINITY
        }
    }
}
