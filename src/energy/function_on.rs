//! A function on any space.

use std::fmt;

use super::Energy;
use crate::space::Space;

/// A function of a point of any [`Space`] that is made an [`Energy`] without a type of its own.
///
/// ```
/// use landscape::energy::{Energy, FunctionOn};
/// use landscape::space::Torus;
///
/// // Three wells on a circle.
/// let energy = FunctionOn::new(Torus::new(1), |x, gradient| {
///     gradient[0] = -3.0 * (3.0 * x[0]).sin();
///     (3.0 * x[0]).cos()
/// });
/// let mut gradient = [0.0];
/// assert!((energy.evaluate(&[std::f64::consts::PI], &mut gradient) + 1.0).abs() < 1e-15);
/// ```
pub struct FunctionOn<S, F> {
    space: S,
    function: F,
}

impl<S: Space, F: Fn(&[f64], &mut [f64]) -> f64 + Sync> FunctionOn<S, F> {
    /// `function` on `space`. It returns the value at x and writes the derivative along each tangent at x, as
    /// [`Energy::evaluate`] does; [`check_gradient`](super::check_gradient) tells whether it is right. Infinity and NaN mean a
    /// point outside its domain.
    pub const fn new(space: S, function: F) -> Self {
        Self { space, function }
    }
}

impl<S: fmt::Debug, F> fmt::Debug for FunctionOn<S, F> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = formatter.debug_struct("FunctionOn");
        shown.field("space", &self.space).finish_non_exhaustive()
    }
}

impl<S: Space, F: Fn(&[f64], &mut [f64]) -> f64 + Sync> Energy for FunctionOn<S, F> {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        assert_eq!(
            (x.len(), gradient.len()),
            (self.space.coordinates(), self.space.tangents())
        );
        let value = (self.function)(x, gradient);
        if value.is_finite() {
            value
        } else {
            f64::INFINITY
        }
    }
}
