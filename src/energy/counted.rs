//! An energy that counts its evaluations.

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{Energy, Explain, Piecewise, Wrapper};
use crate::space::Space;

/// Another energy with a count of its evaluations on all threads together. Evaluations with a cut-off or of one piece
/// count, and a Hessian in closed form counts as one evaluation.
pub struct Counted<'a> {
    energy: Wrapped<'a>,
    evaluations: Arc<AtomicU64>,
}

enum Wrapped<'a> {
    Borrowed(&'a dyn Energy),
    Cached(Box<dyn Energy + 'a>),
}

impl<'a> Deref for Wrapped<'a> {
    type Target = dyn Energy + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Borrowed(energy) => *energy,
            Self::Cached(energy) => &**energy,
        }
    }
}

impl<'a> Counted<'a> {
    /// Counts the evaluations of `energy`, from zero.
    pub fn new(energy: &'a dyn Energy) -> Self {
        Self {
            energy: Wrapped::Borrowed(energy),
            evaluations: Arc::default(),
        }
    }

    /// Evaluations so far.
    pub fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    fn count(&self) -> &(dyn Energy + 'a) {
        // Only the total is read, and it is read after the threads have joined: no ordering is needed.
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        &*self.energy
    }
}

impl fmt::Debug for Counted<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Counted")
            .field("evaluations", &self.evaluations)
            .finish_non_exhaustive()
    }
}

impl Wrapper for Counted<'_> {
    fn space(&self) -> &dyn Space {
        self.energy.space()
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.count().evaluate(x, gradient)
    }

    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool {
        let known = self.energy.hessian(x, hessian);
        if known {
            self.count();
        }
        known
    }

    fn piecewise(&self) -> Option<&dyn Piecewise> {
        self.energy.piecewise().map(|_| self as &dyn Piecewise)
    }

    fn explain(&self) -> Option<&dyn Explain> {
        self.energy.explain()
    }
}

impl Piecewise for Counted<'_> {
    fn active_piece(&self, x: &[f64]) -> Vec<u32> {
        self.energy.active_piece(x)
    }

    fn evaluate_piece(&self, x: &[f64], piece: &[u32], gradient: &mut [f64]) -> f64 {
        self.count().evaluate_piece(x, piece, gradient)
    }

    fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], cutoff: f64) -> f64 {
        self.count().evaluate_below(x, gradient, cutoff)
    }

    fn evaluate_roughly_above(
        &self,
        x: &[f64],
        gradient: &mut [f64],
        ceiling: f64,
    ) -> (f64, Vec<u32>) {
        self.count().evaluate_roughly_above(x, gradient, ceiling)
    }

    /// A cached energy that shares this count.
    fn with_cache(&self) -> Option<Box<dyn Energy + '_>> {
        Some(Box::new(Counted {
            energy: Wrapped::Cached(self.energy.with_cache()?),
            evaluations: Arc::clone(&self.evaluations),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::{Counted, Energy, Piecewise};
    use crate::energy::model::{DoubleWell, MullerBrown};

    #[test]
    fn counts_every_evaluation_and_changes_nothing() {
        let well = DoubleWell::new(1);
        let counted = Counted::new(&well);
        let mut gradient = [0.0];
        assert_eq!(
            counted.evaluate(&[0.25], &mut gradient).to_bits(),
            well.evaluate(&[0.25], &mut gradient).to_bits()
        );
        counted.evaluate_below(&[0.0], &mut gradient, 0.5);
        counted.evaluate_piece(&[0.0], &[], &mut gradient);
        assert!(!counted.hessian(&[0.0], &mut [0.0]));
        assert_eq!(counted.evaluations(), 3);
        let valley = MullerBrown::new();
        let counted = Counted::new(&valley);
        assert!(counted.hessian(&[0.0; 2], &mut [0.0; 4]));
        assert_eq!(counted.evaluations(), 1);
    }
}
