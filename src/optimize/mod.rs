//! Local minimisation on a [`Space`](crate::space::Space): [`quench`] for an energy, [`Fire`] for forces alone.

mod fire;
mod lbfgs;

pub use fire::Fire;
use serde::{Deserialize, Serialize};

use crate::energy::Energy;

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StopReason {
    /// The tolerance was met.
    Converged,
    /// The allowed evaluations were spent.
    Budget,
    /// No step improves the energy any more (rounding, or a start outside the domain).
    Stalled,
}

/// Settings of [`quench`]. Tolerance and step have units. The defaults suit a surface whose energies and lengths are of
/// order 1; for other surfaces they are measured (`topography::Scales`) or chosen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct QuenchSettings {
    /// Largest gradient norm at convergence, energy per length.
    pub gradient_tolerance: f64,
    /// Largest number of evaluations.
    pub max_evaluations: usize,
    /// Longest step, a length of the space (after division by its step scales).
    pub max_step: f64,
}

impl Default for QuenchSettings {
    fn default() -> Self {
        Self {
            gradient_tolerance: 1e-7,
            max_evaluations: 2000,
            max_step: 0.1,
        }
    }
}

impl QuenchSettings {
    /// Settings for a surface with a typical barrier of height `energy` and width `length`.
    pub fn for_scales(energy: f64, length: f64) -> Self {
        Self::default()
            .with_max_step(0.05 * length)
            .with_gradient_tolerance(1e-7 * energy / length)
    }

    /// Replaces the tolerance on the gradient norm, energy per length.
    #[must_use]
    pub fn with_gradient_tolerance(mut self, tolerance: f64) -> Self {
        self.gradient_tolerance = tolerance;
        self
    }

    /// Replaces the largest number of evaluations.
    #[must_use]
    pub fn with_max_evaluations(mut self, evaluations: usize) -> Self {
        self.max_evaluations = evaluations;
        self
    }

    /// Replaces the longest step, a length of the space.
    #[must_use]
    pub fn with_max_step(mut self, length: f64) -> Self {
        self.max_step = length;
        self
    }
}

/// Result of a descent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quench {
    /// Last point.
    pub x: Vec<f64>,
    /// The energy there (+∞ if the start was outside the domain).
    pub energy: f64,
    /// Norm of the gradient there, energy per length.
    pub gradient_norm: f64,
    /// Evaluations spent.
    pub evaluations: usize,
    /// Why it ended.
    pub stop: StopReason,
}

impl Quench {
    /// A descent that began at its end.
    #[cfg(feature = "topography")]
    pub(crate) fn at_rest(x: Vec<f64>, energy: f64) -> Self {
        Self {
            x,
            energy,
            gradient_norm: 0.0,
            evaluations: 0,
            stop: StopReason::Converged,
        }
    }
}

/// Descends from `start` to a local minimum by L-BFGS, preconditioned by the step scales of the space.
///
/// # Panics
/// If `start` has the wrong length.
///
/// # Examples
/// ```
/// use landscape::{energy::model::MullerBrown, optimize::{QuenchSettings, quench}};
///
/// let found = quench(&MullerBrown::new(), &[-1.0, 1.0], &QuenchSettings::default());
/// assert!((found.energy + 146.699517).abs() < 1e-6);
/// ```
pub fn quench(energy: &dyn Energy, start: &[f64], settings: &QuenchSettings) -> Quench {
    quench_traced(energy, start, settings, &mut |_, _| ())
}

/// As [`quench`]; `watch` receives every accepted point with its energy. The energies never rise, except by rounding.
///
/// # Panics
/// If `start` has the wrong length.
pub fn quench_traced(
    energy: &dyn Energy,
    start: &[f64],
    settings: &QuenchSettings,
    watch: &mut dyn FnMut(&[f64], f64),
) -> Quench {
    let space = energy.space();
    let mut function = |x: &[f64], gradient: &mut [f64]| energy.evaluate(x, gradient);
    lbfgs::minimise(space, &mut function, start, settings, watch)
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::energy::model::{LennardJones, MullerBrown};
    use crate::sample::{Task, stream};

    #[test]
    fn reaches_a_minimum_from_everywhere() {
        let mut rng = stream(1, Task::Start, 0);
        for _ in 0..100 {
            let start = [rng.random_range(-1.5..1.0), rng.random_range(-0.5..2.0)];
            let found = quench(&MullerBrown::new(), &start, &QuenchSettings::default());
            assert_eq!(found.stop, StopReason::Converged, "{start:?}: {found:?}");
            let known = [-146.6995172, -108.1667241, -80.7678182];
            assert!(known.iter().any(|e| (e - found.energy).abs() < 1e-6));
            assert!(found.evaluations < 150, "{found:?}");
        }
    }

    #[test]
    fn converges_to_rounding() {
        let mut rng = stream(2, Task::Start, 0);
        let settings = QuenchSettings::default().with_gradient_tolerance(1e-11);
        for _ in 0..20 {
            let start: Vec<f64> = (0..12).map(|_| rng.random_range(-0.8..0.8)).collect();
            let found = quench(&LennardJones::new(4), &start, &settings);
            assert_eq!(found.stop, StopReason::Converged, "{found:?}");
            assert!((found.energy + 6.0).abs() < 1e-12);
        }
    }

    #[test]
    fn outside_the_domain_nothing_is_done() {
        let found = quench(&LennardJones::new(2), &[0.0; 6], &QuenchSettings::default());
        assert_eq!(found.stop, StopReason::Stalled);
        assert!(found.energy.is_infinite());
    }
}
