//! Scalar fields on a [`Space`], which are all that the topography modules need of a landscape.

use crate::space::Space;

mod counted;
mod differences;
mod external;
mod function_on;
mod gradient_check;
mod in_box;
pub mod model;

pub use counted::Counted;
pub use differences::hessian_from_gradients;
pub use external::{External, ExternalError, Protocol};
pub use function_on::FunctionOn;
pub use gradient_check::{GradientFault, check_gradient};
pub use in_box::InBox;

/// A scalar field on a [`Space`], continuously differentiable where it is finite.
///
/// A function of `x` alone: the same `x` gives the same bits, on any thread and after any other call.
pub trait Energy: Sync {
    /// The space of `x`: `coordinates()` numbers for a point, `tangents()` for a direction.
    fn space(&self) -> &dyn Space;

    /// Energy at `x`; writes the derivative along each tangent at `x` (the vector that [`Space::exp`] takes) into
    /// `gradient`.
    ///
    /// Outside its domain an energy returns `f64::INFINITY`, never NaN; searches refuse such a step.
    ///
    /// # Panics
    /// If `x` or `gradient` has the wrong length.
    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64;

    /// Second derivatives at `x`, for an energy that knows them in closed form. Writes the derivative of
    /// [`Energy::evaluate`]'s gradient along each tangent, one after the other, into the n² numbers of `hessian`, and
    /// returns true. Not finite outside the domain.
    ///
    /// Searches assume that it is symmetric. By default an energy has no closed form, and searches difference its
    /// gradients. A closed form saves two evaluations per tangent and Hessian.
    ///
    /// # Panics
    /// If `x` or `hessian` has the wrong length.
    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool {
        let _ = (x, hessian);
        false
    }

    /// The explanations that this energy gives of a point, if any.
    fn explain(&self) -> Option<&dyn Explain> {
        None
    }
}

/// Explanations of a point beside its energy.
pub trait Explain: Sync {
    /// The named, weighted terms whose sum is the energy at `x`, in a fixed order. The term that rises most names the top
    /// of a path.
    fn terms(&self, x: &[f64]) -> Vec<(String, f64)>;

    /// Why a path through `x` should not count as relaxed although its energy is finite (for example, the hand passes
    /// through the object); `None` if there is no reason.
    fn invalid_reason(&self, x: &[f64]) -> Option<String>;
}

/// The methods of [`Explain`] for any energy. One without explanations has no terms and no invalid points.
impl dyn Energy + '_ {
    /// See [`Explain::terms`].
    pub fn terms(&self, x: &[f64]) -> Vec<(String, f64)> {
        let explains = self.explain();
        explains.map_or_else(Vec::new, |explains| explains.terms(x))
    }

    /// See [`Explain::invalid_reason`].
    pub fn invalid_reason(&self, x: &[f64]) -> Option<String> {
        self.explain()?.invalid_reason(x)
    }
}
