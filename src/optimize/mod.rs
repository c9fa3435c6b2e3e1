//! Local minimisation on a [`Space`](crate::space::Space): [`quench`] for an energy, [`Fire`] for forces alone.

mod fire;
mod lbfgs;

pub use fire::Fire;
use serde::{Deserialize, Serialize};

use crate::energy::Energy;
use crate::space::vector::norm;

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
#[serde(deny_unknown_fields, default)]
pub struct QuenchSettings {
    /// Largest gradient norm at convergence, energy per length.
    pub gradient_tolerance: f64,
    /// Largest number of evaluations.
    pub max_evaluations: usize,
    /// Longest step, a length of the space (after division by its step scales).
    pub max_step: f64,
    /// Number of steps remembered by L-BFGS.
    pub history: usize,
    /// Number of times that the discrete choice is made again, for energies that have one.
    pub choice_rounds: usize,
}

impl Default for QuenchSettings {
    fn default() -> Self {
        Self {
            gradient_tolerance: 1e-7,
            max_evaluations: 2000,
            max_step: 0.1,
            history: 10,
            choice_rounds: 20,
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

/// Descends from `start` to a local minimum by L-BFGS, preconditioned by the step scales of the space.
///
/// An energy with a discrete choice (a minimum over smooth pieces) is minimised with the choice held. Then the choice is
/// made anew, until it no longer changes; the energy falls in every round. Kinks of such an energy are concave, so every
/// local minimum lies inside one piece and none is missed.
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
    let mut choice = energy.active_piece(start);
    if choice.is_empty() {
        let mut function = |x: &[f64], gradient: &mut [f64]| energy.evaluate(x, gradient);
        return lbfgs::minimise(space, &mut function, start, settings, watch);
    }
    let mut budget = settings.clone();
    let mut best: Option<Quench> = None;
    for _ in 0..settings.choice_rounds.max(1) {
        let from = best.as_ref().map_or(start, |found| &found.x).to_vec();
        let mut piece =
            |x: &[f64], gradient: &mut [f64]| energy.evaluate_piece(x, &choice, gradient);
        let mut round = lbfgs::minimise(space, &mut piece, &from, &budget, watch);
        budget.max_evaluations = budget.max_evaluations.saturating_sub(round.evaluations);
        let spent = best.as_ref().map_or(0, |found| found.evaluations);
        round.evaluations += spent;
        if let Some(known) = &mut best
            && round.energy >= known.energy
        {
            // The new piece has no lower minimum, so the minimum of the old piece is kept.
            known.evaluations = round.evaluations;
            break;
        }
        let next = energy.active_piece(&round.x);
        let settled = next == choice || !round.energy.is_finite();
        best = Some(round);
        if settled || budget.max_evaluations == 0 {
            break;
        }
        choice = next;
    }
    let mut found = best.expect("at least one round is made");
    let mut gradient = vec![0.0; space.tangents()];
    found.energy = energy.evaluate(&found.x, &mut gradient);
    found.gradient_norm = norm(&gradient);
    found.evaluations += 1;
    if found.stop == StopReason::Converged && found.gradient_norm > settings.gradient_tolerance {
        found.stop = StopReason::Stalled;
    }
    found
}

/// As [`quench`] within one piece, with the discrete choice held.
///
/// # Panics
/// If `start` has the wrong length.
pub fn quench_piece(
    energy: &dyn Energy,
    choice: &[u32],
    start: &[f64],
    settings: &QuenchSettings,
) -> Quench {
    let mut piece = |x: &[f64], gradient: &mut [f64]| energy.evaluate_piece(x, choice, gradient);
    lbfgs::minimise(energy.space(), &mut piece, start, settings, &mut |_, _| ())
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::energy::Piecewise;
    use crate::energy::model::{LennardJones, MullerBrown};
    use crate::sample::{Task, stream};
    use crate::space::{Euclidean, Space};

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

    /// Minimum of (x − k)² + 1.5 k over k = 0, 1, 2.
    struct Steps(Euclidean);

    impl Energy for Steps {
        fn space(&self) -> &dyn Space {
            &self.0
        }

        fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
            let choice = self.active_piece(x);
            self.evaluate_piece(x, &choice, gradient)
        }

        fn piecewise(&self) -> Option<&dyn Piecewise> {
            Some(self)
        }
    }

    impl Piecewise for Steps {
        fn active_piece(&self, x: &[f64]) -> Vec<u32> {
            let piece = |k: u32| (x[0] - f64::from(k)).powi(2) + 1.5 * f64::from(k);
            let best = (0..3).min_by(|a, b| piece(*a).total_cmp(&piece(*b)));
            vec![best.unwrap()]
        }

        fn evaluate_piece(&self, x: &[f64], choice: &[u32], gradient: &mut [f64]) -> f64 {
            let offset = x[0] - f64::from(choice[0]);
            gradient[0] = 2.0 * offset;
            offset * offset + 1.5 * f64::from(choice[0])
        }

        fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], _cutoff: f64) -> f64 {
            self.evaluate(x, gradient)
        }

        fn evaluate_roughly_above(
            &self,
            x: &[f64],
            gradient: &mut [f64],
            _ceiling: f64,
        ) -> (f64, Vec<u32>) {
            (self.evaluate(x, gradient), self.active_piece(x))
        }

        fn with_cache(&self) -> Option<Box<dyn Energy + '_>> {
            None
        }
    }

    #[test]
    fn follows_the_choice_downhill() {
        let energy = Steps(Euclidean::new(1));
        let found = quench(&energy, &[7.0], &QuenchSettings::default());
        // The minimum of the last piece (3 at x = 2) lies above the piece before (1 + 1.5), and so on down to 0.
        assert_eq!(found.stop, StopReason::Converged);
        assert!(found.x[0].abs() < 1e-6 && found.energy < 1e-9, "{found:?}");
        let held = quench_piece(&energy, &[2], &[7.0], &QuenchSettings::default());
        assert!((held.x[0] - 2.0).abs() < 1e-6 && (held.energy - 3.0).abs() < 1e-9);
    }

    #[test]
    fn outside_the_domain_nothing_is_done() {
        let found = quench(&LennardJones::new(2), &[0.0; 6], &QuenchSettings::default());
        assert_eq!(found.stop, StopReason::Stalled);
        assert!(found.energy.is_infinite());
    }
}
