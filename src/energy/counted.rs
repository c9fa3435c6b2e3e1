//! An energy that counts its evaluations.

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::Energy;
use crate::space::Space;

/// Another energy plus a count of how often it was evaluated, whole or with a cut-off or a fixed choice, on all threads
/// together. A Hessian in closed form counts as one evaluation.
pub struct Counted<'a> {
    energy: Wrapped<'a>,
    evaluations: Arc<AtomicU64>,
}

enum Wrapped<'a> {
    Borrowed(&'a dyn Energy),
    Local(Box<dyn Energy + 'a>),
}

impl<'a> Deref for Wrapped<'a> {
    type Target = dyn Energy + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Borrowed(energy) => *energy,
            Self::Local(energy) => &**energy,
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

impl Energy for Counted<'_> {
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

    fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], cutoff: f64) -> f64 {
        self.count().evaluate_below(x, gradient, cutoff)
    }

    fn evaluate_roughly_above(&self, x: &[f64], gradient: &mut [f64], ceiling: f64) -> f64 {
        self.count().evaluate_roughly_above(x, gradient, ceiling)
    }

    fn choose_roughly_above(
        &self,
        x: &[f64],
        gradient: &mut [f64],
        ceiling: f64,
    ) -> (f64, Vec<u32>) {
        self.count().choose_roughly_above(x, gradient, ceiling)
    }

    fn choice(&self, x: &[f64]) -> Vec<u32> {
        self.energy.choice(x)
    }

    fn evaluate_choice(&self, x: &[f64], choice: &[u32], gradient: &mut [f64]) -> f64 {
        self.count().evaluate_choice(x, choice, gradient)
    }

    /// Counts together with this one.
    fn local(&self) -> Option<Box<dyn Energy + '_>> {
        Some(Box::new(Counted {
            energy: Wrapped::Local(self.energy.local()?),
            evaluations: Arc::clone(&self.evaluations),
        }))
    }

    fn terms(&self, x: &[f64]) -> Vec<(String, f64)> {
        self.energy.terms(x)
    }

    fn invalid_reason(&self, x: &[f64]) -> Option<String> {
        self.energy.invalid_reason(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
        counted.evaluate_choice(&[0.0], &[], &mut gradient);
        counted.terms(&[0.0]);
        assert!(!counted.hessian(&[0.0], &mut [0.0]));
        assert_eq!(counted.evaluations(), 3);
        let valley = MullerBrown::new();
        let counted = Counted::new(&valley);
        assert!(counted.hessian(&[0.0; 2], &mut [0.0; 4]));
        assert_eq!(counted.evaluations(), 1);
    }
}
