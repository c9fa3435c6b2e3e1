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

    /// This energy as a minimum over smooth pieces, if it is one.
    fn piecewise(&self) -> Option<&dyn Piecewise> {
        None
    }

    /// What this energy can say about a point beside its value, if anything.
    fn explain(&self) -> Option<&dyn Explain> {
        None
    }
}

/// An energy that is the minimum of smooth pieces, such as a grasp's over its contact sets: continuous, with concave kinks
/// (seams) where the lowest piece changes.
///
/// Every method panics if a slice has the wrong length, and returns the same bits for the same arguments.
pub trait Piecewise: Energy {
    /// The piece that is lowest at `x`: the discrete choice that it stands for, never empty. Two neighbouring points with
    /// different pieces lie on two sides of a seam.
    fn active_piece(&self, x: &[f64]) -> Vec<u32>;

    /// Value and gradient of one piece: smooth in `x`, never below [`Energy::evaluate`].
    fn evaluate_piece(&self, x: &[f64], piece: &[u32], gradient: &mut [f64]) -> f64;

    /// The energy up to a cut-off: exact where it is at most `cutoff`, otherwise any lower bound of it above `cutoff`. The
    /// gradient is written only where the returned value is at most `cutoff`.
    fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], cutoff: f64) -> f64;

    /// The energy for a search that needs to know it well only where it is low, and the piece it belongs to: exact where the
    /// energy is at most `ceiling`, otherwise possibly an upper bound (a good piece instead of the lowest). The gradient
    /// belongs to the value.
    fn evaluate_roughly_above(
        &self,
        x: &[f64],
        gradient: &mut [f64],
        ceiling: f64,
    ) -> (f64, Vec<u32>);

    /// The same energy with a memory of its own, for a caller that keeps asking about one neighbourhood: the same bits,
    /// cheaper. `None` for energies that remember nothing.
    fn with_cache(&self) -> Option<Box<dyn Energy + '_>>;
}

/// What an energy can say about a point beside its value.
pub trait Explain: Sync {
    /// The named, weighted terms whose sum is the energy at `x`, in a fixed order. The top of a path is named after the
    /// term that rises most.
    fn terms(&self, x: &[f64]) -> Vec<(String, f64)>;

    /// Why a path through `x` should not count as relaxed although its energy is finite (the hand passes through the
    /// object); `None` where nothing speaks against it.
    fn invalid_reason(&self, x: &[f64]) -> Option<String>;
}

/// An energy around another one: [`Energy`] without defaults, so that a wrapper must forward everything to compile.
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

/// The methods of [`Piecewise`] and [`Explain`] for any energy: a smooth one has a single piece, whose name is empty, and
/// one that explains nothing has no terms and raises no objection.
impl<'e> dyn Energy + 'e {
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
