//! Scalar fields on a [`Space`]: the only thing the topography half asks of a landscape.

use crate::space::Space;

mod counted;
mod external;
mod gradient_check;
mod in_box;
pub mod model;

pub use counted::Counted;
pub use external::{External, ExternalError};
pub use gradient_check::{GradientFault, check_gradient};
pub use in_box::InBox;

/// A scalar field on a [`Space`], continuously differentiable wherever it is finite (or piecewise so, where documented).
///
/// A function of `x` alone: the same `x` gives the same bits, whatever was asked before and on whichever thread.
pub trait Energy: Sync {
    /// The space `x` lives in: `coordinates()` numbers for a point, `tangents()` for a direction.
    fn space(&self) -> &dyn Space;

    /// Energy at `x`; writes the derivative along each tangent at `x` (the vector that [`Space::exp`] takes) into
    /// `gradient`.
    ///
    /// Outside its domain an energy returns `f64::INFINITY`, never NaN; searches read that as "step refused".
    ///
    /// # Panics
    /// If `x` or `gradient` has the wrong length.
    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64;

    /// Second derivatives at `x`, for an energy that knows them in closed form: writes what [`Energy::evaluate`]'s gradient
    /// changes by along each tangent, one after the other, into the n² numbers of `hessian`, and returns true. Not finite
    /// outside the domain.
    ///
    /// Searches take it for symmetric. By default energies do not know it, and searches difference their gradients; one
    /// that does saves them two evaluations for each tangent and Hessian.
    ///
    /// # Panics
    /// If `x` or `hessian` has the wrong length.
    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool {
        let _ = (x, hessian);
        false
    }

    /// The energy up to a cut-off: exact where it is at most `cutoff`, otherwise any lower bound of it above `cutoff`.
    ///
    /// Energies whose evaluation is costly far above the region of interest may leave early. The gradient is written
    /// only where the returned value is at most `cutoff`. The default evaluates in full.
    ///
    /// # Panics
    /// If `x` or `gradient` has the wrong length.
    fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], cutoff: f64) -> f64 {
        let _ = cutoff;
        self.evaluate(x, gradient)
    }

    /// The energy for a search that only needs to know it well where it is low: exact where it is at most `ceiling`,
    /// otherwise possibly an upper bound (a good discrete choice instead of the best). The gradient belongs to the value.
    ///
    /// Like [`Energy::evaluate`] a function of its arguments alone. The default evaluates exactly.
    ///
    /// # Panics
    /// If `x` or `gradient` has the wrong length.
    fn evaluate_roughly_above(&self, x: &[f64], gradient: &mut [f64], ceiling: f64) -> f64 {
        let _ = ceiling;
        self.evaluate(x, gradient)
    }

    /// [`Energy::evaluate_roughly_above`] together with the choice its value belongs to: [`Energy::choice`] where the value
    /// is at most `ceiling`.
    ///
    /// # Panics
    /// If `x` or `gradient` has the wrong length.
    fn choose_roughly_above(
        &self,
        x: &[f64],
        gradient: &mut [f64],
        ceiling: f64,
    ) -> (f64, Vec<u32>) {
        let energy = self.evaluate_roughly_above(x, gradient, ceiling);
        (energy, self.choice(x))
    }

    /// The discrete choice that realises the minimum at `x`, for an energy that is a minimum over discrete choices (the
    /// contact set of a grasp). Two neighbouring points with different choices lie on two sides of a seam. Empty for
    /// smooth energies.
    fn choice(&self, x: &[f64]) -> Vec<u32> {
        let _ = x;
        Vec::new()
    }

    /// The energy with its discrete choice held at `choice`: smooth in `x`, never below [`Energy::evaluate`].
    ///
    /// # Panics
    /// If `x` or `gradient` has the wrong length.
    fn evaluate_choice(&self, x: &[f64], choice: &[u32], gradient: &mut [f64]) -> f64 {
        let _ = choice;
        self.evaluate(x, gradient)
    }

    /// The same energy with a memory of its own, for a caller that keeps asking about one neighbourhood: the same bits,
    /// cheaper. `None` for energies that remember nothing.
    fn local(&self) -> Option<Box<dyn Energy + '_>> {
        None
    }

    /// The named, weighted terms whose sum is the energy at `x`, in a fixed order; empty where an energy has no parts.
    /// The top of a path is named after the term that rises most.
    fn terms(&self, x: &[f64]) -> Vec<(String, f64)> {
        let _ = x;
        Vec::new()
    }

    /// Why a path through `x` should not count as relaxed although its energy is finite (the hand passes through the
    /// object); `None` where nothing speaks against it.
    fn invalid_reason(&self, x: &[f64]) -> Option<String> {
        let _ = x;
        None
    }
}
