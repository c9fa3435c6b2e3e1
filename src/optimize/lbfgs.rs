//! Limited-memory BFGS on a manifold.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::{Quench, StopReason};
use crate::space::Space;

/// When a descent stops and how far it may step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DescentSettings {
    /// Converged when the gradient, preconditioned by [`Space::step_scales`], is shorter than this (energy per length).
    pub gradient_tolerance: f64,
    /// Evaluations allowed.
    pub evaluations: u64,
    /// Longest step, length of the space.
    pub longest_step: f64,
}

impl Default for DescentSettings {
    fn default() -> Self {
        Self {
            gradient_tolerance: 1e-8,
            evaluations: 5_000,
            longest_step: 0.1,
        }
    }
}

/// Pairs of step and gradient change that are remembered.
const MEMORY: usize = 10;
/// A step must lower the energy by this share of what the slope promises (Armijo).
const SUFFICIENT: f64 = 1e-4;

struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    inverse_curvature: f64,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Minimises `evaluate` from `start` by L-BFGS with a backtracking line search.
///
/// Directions are taken in tangents divided by [`Space::step_scales`]; remembered pairs are carried along unchanged,
/// since tangents live in the moving frame. A non-finite energy refuses the step. D. C. Liu and J. Nocedal, Math.
/// Programming 45, 503 (1989).
///
/// # Panics
/// If `start` has the wrong length.
pub fn lbfgs(
    space: &dyn Space,
    start: &[f64],
    settings: &DescentSettings,
    mut evaluate: impl FnMut(&[f64], &mut [f64]) -> f64,
) -> Quench {
    let scales = space.step_scales();
    let tangents = space.tangents();
    let mut x = start.to_vec();
    let mut raw = vec![0.0; tangents];
    let mut energy = evaluate(&x, &mut raw);
    let mut evaluations = 1;
    let precondition = |raw: &[f64]| -> Vec<f64> {
        raw.iter().zip(&scales).map(|(g, s)| g * s).collect()
    };
    let mut gradient = precondition(&raw);
    let mut history: VecDeque<Pair> = VecDeque::with_capacity(MEMORY);
    let stop = loop {
        if !energy.is_finite() {
            break StopReason::Stalled;
        }
        if norm(&gradient) < settings.gradient_tolerance {
            break StopReason::Converged;
        }
        if evaluations >= settings.evaluations {
            break StopReason::Budget;
        }
        let mut direction = descent_direction(&gradient, &history);
        let mut slope = dot(&direction, &gradient);
        if slope >= 0.0 {
            history.clear();
            direction = gradient.iter().map(|g| -g).collect();
            slope = -dot(&gradient, &gradient);
        }
        let length = norm(&direction.iter().zip(&scales).map(|(d, s)| d * s).collect::<Vec<_>>());
        let mut fraction = (settings.longest_step / length).min(1.0);
        if history.is_empty() {
            // Without curvature the gradient has no length scale: begin small.
            fraction = fraction.min(0.1 * settings.longest_step / length);
        }
        let mut accepted = false;
        while evaluations < settings.evaluations {
            let step: Vec<f64> = direction.iter().map(|d| fraction * d).collect();
            let tangent: Vec<f64> = step.iter().zip(&scales).map(|(d, s)| d * s).collect();
            let mut trial = x.clone();
            space.shift(&mut trial, &tangent);
            let trial_energy = evaluate(&trial, &mut raw);
            evaluations += 1;
            if trial_energy <= energy + SUFFICIENT * fraction * slope {
                let next = precondition(&raw);
                let change: Vec<f64> = next.iter().zip(&gradient).map(|(a, b)| a - b).collect();
                let curvature = dot(&step, &change);
                if curvature > 1e-12 * norm(&step) * norm(&change) {
                    if history.len() == MEMORY {
                        history.pop_front();
                    }
                    history.push_back(Pair {
                        step,
                        change,
                        inverse_curvature: 1.0 / curvature,
                    });
                }
                (x, energy, gradient) = (trial, trial_energy, next);
                accepted = true;
                break;
            }
            // Minimum of the parabola through both values and the slope, kept between a tenth and a half.
            let parabola = -0.5 * slope * fraction * fraction
                / (trial_energy - energy - slope * fraction);
            fraction = if parabola.is_finite() {
                parabola.clamp(0.1 * fraction, 0.5 * fraction)
            } else {
                0.1 * fraction
            };
            if fraction * length < 1e-14 {
                break;
            }
        }
        if !accepted {
            if history.is_empty() {
                break if evaluations >= settings.evaluations {
                    StopReason::Budget
                } else {
                    StopReason::Stalled
                };
            }
            history.clear();
        }
    };
    Quench {
        gradient_norm: norm(&gradient),
        x,
        energy,
        evaluations,
        stop,
    }
}

/// −H⁻¹ g by the two-loop recursion.
fn descent_direction(gradient: &[f64], history: &VecDeque<Pair>) -> Vec<f64> {
    let mut q = gradient.to_vec();
    let mut weights = Vec::with_capacity(history.len());
    for pair in history.iter().rev() {
        let weight = pair.inverse_curvature * dot(&pair.step, &q);
        for (q, change) in q.iter_mut().zip(&pair.change) {
            *q -= weight * change;
        }
        weights.push(weight);
    }
    if let Some(last) = history.back() {
        let scale = 1.0 / (last.inverse_curvature * dot(&last.change, &last.change));
        q.iter_mut().for_each(|q| *q *= scale);
    }
    for (pair, weight) in history.iter().zip(weights.iter().rev()) {
        let back = pair.inverse_curvature * dot(&pair.change, &q);
        for (q, step) in q.iter_mut().zip(&pair.step) {
            *q += (weight - back) * step;
        }
    }
    q.iter_mut().for_each(|q| *q = -*q);
    q
}
