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

/// A scalar field on a [`Space`], continuously differentiable where it is finite (or piecewise so, if documented).
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

    /// This energy as a minimum over smooth pieces, if it is one.
    fn piecewise(&self) -> Option<&dyn Piecewise> {
        None
    }

    /// The explanations that this energy gives of a point, if any.
    fn explain(&self) -> Option<&dyn Explain> {
        None
    }
}

/// An energy that is the minimum of smooth pieces, such as a grasp's over its contact sets: continuous, with concave kinks
/// (seams) where the lowest piece changes.
///
/// Every method panics if a slice has the wrong length, and returns the same bits for the same arguments.
pub trait Piecewise: Energy {
    /// The lowest piece at `x`, as its discrete choice, never empty. Two neighbouring points with different pieces lie on
    /// two sides of a seam.
    fn active_piece(&self, x: &[f64]) -> Vec<u32>;

    /// Value and gradient of one piece: smooth in `x`, never below [`Energy::evaluate`].
    fn evaluate_piece(&self, x: &[f64], piece: &[u32], gradient: &mut [f64]) -> f64;

    /// The energy up to a cut-off: exact where it is at most `cutoff`, otherwise any lower bound of it above `cutoff`. The
    /// gradient is written only where the returned value is at most `cutoff`.
    fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], cutoff: f64) -> f64;

    /// The energy for a search that needs accuracy only where it is low, and the piece it belongs to. It is exact where the
    /// energy is at most `ceiling`, otherwise possibly an upper bound (a good piece instead of the lowest). The gradient
    /// belongs to the returned value.
    fn evaluate_roughly_above(
        &self,
        x: &[f64],
        gradient: &mut [f64],
        ceiling: f64,
    ) -> (f64, Vec<u32>);

    /// The same energy with its own cache, for a caller that keeps evaluating one neighbourhood: the same bits, cheaper.
    /// `None` for energies without a cache.
    fn with_cache(&self) -> Option<Box<dyn Energy + '_>>;
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

/// An energy around another one. Like [`Energy`] but without defaults, so that a wrapper must forward every method.
pub trait Wrapper: Sync {
    /// See [`Energy::space`].
    fn space(&self) -> &dyn Space;
    /// See [`Energy::evaluate`].
    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64;
    /// See [`Energy::hessian`].
    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool;
    /// See [`Energy::piecewise`].
    fn piecewise(&self) -> Option<&dyn Piecewise>;
    /// See [`Energy::explain`].
    fn explain(&self) -> Option<&dyn Explain>;
}

impl<W: Wrapper> Energy for W {
    fn space(&self) -> &dyn Space {
        Wrapper::space(self)
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        Wrapper::evaluate(self, x, gradient)
    }

    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool {
        Wrapper::hessian(self, x, hessian)
    }

    fn piecewise(&self) -> Option<&dyn Piecewise> {
        Wrapper::piecewise(self)
    }

    fn explain(&self) -> Option<&dyn Explain> {
        Wrapper::explain(self)
    }
}

/// The methods of [`Piecewise`] and [`Explain`] for any energy. A smooth energy has a single piece, whose choice is empty,
/// and an energy without explanations has no terms and no invalid points.
impl dyn Energy + '_ {
    /// See [`Piecewise::active_piece`]; empty for smooth energies.
    pub fn active_piece(&self, x: &[f64]) -> Vec<u32> {
        let pieces = self.piecewise();
        pieces.map_or_else(Vec::new, |pieces| pieces.active_piece(x))
    }

    /// See [`Piecewise::evaluate_piece`].
    pub fn evaluate_piece(&self, x: &[f64], piece: &[u32], gradient: &mut [f64]) -> f64 {
        match self.piecewise() {
            Some(pieces) => pieces.evaluate_piece(x, piece, gradient),
            None => self.evaluate(x, gradient),
        }
    }

    /// See [`Piecewise::evaluate_below`].
    pub fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], cutoff: f64) -> f64 {
        match self.piecewise() {
            Some(pieces) => pieces.evaluate_below(x, gradient, cutoff),
            None => self.evaluate(x, gradient),
        }
    }

    /// See [`Piecewise::evaluate_roughly_above`].
    pub fn evaluate_roughly_above(
        &self,
        x: &[f64],
        gradient: &mut [f64],
        ceiling: f64,
    ) -> (f64, Vec<u32>) {
        match self.piecewise() {
            Some(pieces) => pieces.evaluate_roughly_above(x, gradient, ceiling),
            None => (self.evaluate(x, gradient), Vec::new()),
        }
    }

    /// See [`Piecewise::with_cache`].
    pub fn with_cache(&self) -> Option<Box<dyn Energy + '_>> {
        self.piecewise()?.with_cache()
    }

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
