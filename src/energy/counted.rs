//! An energy that counts its evaluations.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{Energy, Explain};
use crate::space::Space;

/// Another energy with a count of its evaluations on all threads together. A Hessian in closed form counts as one
/// evaluation.
pub struct Counted<'a> {
    energy: &'a dyn Energy,
    evaluations: AtomicU64,
}

impl<'a> Counted<'a> {
    /// Counts the evaluations of `energy`, from zero.
    pub fn new(energy: &'a dyn Energy) -> Self {
        Self {
            energy,
            evaluations: AtomicU64::default(),
        }
    }

    /// Evaluations so far.
    pub fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    fn count(&self) {
        // Only the total is read, and it is read after the threads have joined: no ordering is needed.
        self.evaluations.fetch_add(1, Ordering::Relaxed);
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

impl Energy for Counted<'_> {
    fn space(&self) -> &dyn Space {
        self.energy.space()
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.count();
        self.energy.evaluate(x, gradient)
    }

    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool {
        let known = self.energy.hessian(x, hessian);
        if known {
            self.count();
        }
        known
    }

    fn explain(&self) -> Option<&dyn Explain> {
        self.energy.explain()
    }
}

#[cfg(test)]
mod tests {
    use super::{Counted, Energy};
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
        assert!(!counted.hessian(&[0.0], &mut [0.0]));
        assert_eq!(counted.evaluations(), 1);
        let valley = MullerBrown::new();
        let counted = Counted::new(&valley);
        assert!(counted.hessian(&[0.0; 2], &mut [0.0; 4]));
        assert_eq!(counted.evaluations(), 1);
    }
}
