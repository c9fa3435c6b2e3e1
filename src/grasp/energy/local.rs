//! A grasp energy with its own memory.

use std::sync::{Mutex, PoisonError};

use super::evaluation::{Evaluation, Memory};
use super::{GraspEnergy, Ramp};
use crate::energy::{Energy, Explain, Piecewise, Wrapper};
use crate::space::Space;

/// The energy for one image of a path. Its memory stays near that image, so little must be measured again when it moves.
#[derive(Debug)]
pub(super) struct Local<'a> {
    energy: &'a GraspEnergy,
    memory: Mutex<Memory>,
}

impl GraspEnergy {
    pub(super) fn with_own_memory(&self) -> Local<'_> {
        Local {
            energy: self,
            memory: Mutex::new(self.copy_of_memory()),
        }
    }
}

impl Local<'_> {
    fn at<R>(&self, x: &[f64], work: impl FnOnce(&mut Evaluation<'_>) -> R) -> R {
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        work(&mut Evaluation::new(self.energy, x, &mut memory))
    }
}

impl Wrapper for Local<'_> {
    fn space(&self) -> &dyn Space {
        self.energy.space()
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.evaluate_below(x, gradient, f64::INFINITY)
    }

    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool {
        self.energy.hessian(x, hessian)
    }

    fn piecewise(&self) -> Option<&dyn Piecewise> {
        Some(self)
    }

    fn explain(&self) -> Option<&dyn Explain> {
        Some(self.energy)
    }
}

impl Piecewise for Local<'_> {
    fn active_piece(&self, x: &[f64]) -> Vec<u32> {
        #[expect(
            clippy::redundant_closure_for_method_calls,
            reason = "the method alone is not general in its lifetimes"
        )]
        self.at(x, |evaluation| evaluation.best_choice())
    }

    fn evaluate_piece(&self, x: &[f64], piece: &[u32], gradient: &mut [f64]) -> f64 {
        self.at(x, |evaluation| {
            evaluation.held(piece, Ramp::default(), gradient)
        })
    }

    fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], cutoff: f64) -> f64 {
        self.at(x, |evaluation| evaluation.envelope(gradient, cutoff))
    }

    fn evaluate_roughly_above(
        &self,
        x: &[f64],
        gradient: &mut [f64],
        ceiling: f64,
    ) -> (f64, Vec<u32>) {
        self.at(x, |evaluation| evaluation.roughly(gradient, ceiling))
    }

    fn with_cache(&self) -> Option<Box<dyn Energy + '_>> {
        self.energy.with_cache()
    }
}
