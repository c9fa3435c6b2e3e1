//! From a point to the minimum below it.

use serde::{Deserialize, Serialize};

use super::{DescentSettings, StopReason, lbfgs};
use crate::energy::Energy;

/// How a quench descends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct QuenchSettings {
    /// The descent of each smooth piece.
    pub descent: DescentSettings,
    /// For an energy that is a minimum over discrete choices: how often the choice may be made anew.
    pub rounds: u32,
}

impl Default for QuenchSettings {
    fn default() -> Self {
        Self {
            descent: DescentSettings::default(),
            rounds: 30,
        }
    }
}

/// Where a descent ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quench {
    /// The end point.
    pub x: Vec<f64>,
    /// Its energy.
    pub energy: f64,
    /// Length of the preconditioned gradient there.
    pub gradient_norm: f64,
    /// Evaluations spent.
    pub evaluations: u64,
    /// Why it ended.
    pub stop: StopReason,
}

/// Minimises `energy` from `start`.
///
/// An energy that is a minimum over discrete choices has kinks where the choice changes, which stop a gradient descent
/// early. There, the choice is held while the smooth piece is minimised, then made anew, until it no longer changes: the
/// energy falls in every round.
///
/// # Panics
/// If `start` has the wrong length.
pub fn quench(energy: &dyn Energy, start: &[f64], settings: &QuenchSettings) -> Quench {
    let space = energy.space();
    let mut choice = energy.choice(start);
    if choice.is_empty() {
        return lbfgs(space, start, &settings.descent, |x, g| energy.evaluate(x, g));
    }
    let mut best: Option<Quench> = None;
    let mut evaluations = 1;
    for _ in 0..settings.rounds {
        let from = best.as_ref().map_or(start, |quench| &quench.x);
        let end = lbfgs(space, from, &settings.descent, |x, g| {
            energy.evaluate_choice(x, &choice, g)
        });
        let next = energy.choice(&end.x);
        evaluations += end.evaluations + 1;
        let settled = next == choice;
        choice = next;
        best = Some(end);
        if settled {
            break;
        }
    }
    let mut quench = best.unwrap_or_else(|| Quench {
        x: start.to_vec(),
        energy: f64::INFINITY,
        gradient_norm: f64::INFINITY,
        evaluations: 0,
        stop: StopReason::Budget,
    });
    let mut gradient = vec![0.0; space.tangents()];
    quench.energy = energy.evaluate(&quench.x, &mut gradient);
    quench.evaluations = evaluations;
    quench
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::model::MullerBrown;

    #[test]
    fn falls_into_the_published_minimum() {
        let energy = MullerBrown::new();
        let quench = quench(&energy, &[-0.7, 1.2], &QuenchSettings::default());
        assert_eq!(quench.stop, StopReason::Converged);
        assert!((quench.energy + 146.699_517_2).abs() < 1e-6, "{quench:?}");
        assert!(quench.evaluations < 60, "{quench:?}");
    }
}
