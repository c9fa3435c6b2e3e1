//! Limited-memory BFGS on a [`Space`].

use std::collections::VecDeque;

use super::{Quench, QuenchSettings, StopReason};
use crate::space::Space;
use crate::space::vector::{add, dot, norm, scale, times};

/// Constants of sufficient decrease and of curvature in the weak Wolfe conditions.
const DECREASE: f64 = 1e-4;
const CURVATURE: f64 = 0.9;
/// Energies closer than this, relative to their size, differ by rounding only; then slopes decide.
const ROUNDING: f64 = 1e-14;
/// Largest number of trials of one line search.
const TRIALS: usize = 25;
/// Number of iterations without a lower energy or a smaller gradient after which the search has stalled.
const IDLE: usize = 20;
/// Number of steps remembered.
const HISTORY: usize = 10;

/// A function value with its derivative along each tangent.
pub(super) type Function<'f> = dyn FnMut(&[f64], &mut [f64]) -> f64 + 'f;

/// An accepted step and the resulting change of the gradient, both in preconditioned tangents.
struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    curvature: f64,
}

/// A point: coordinates, value, derivative (plain tangents).
#[derive(Clone)]
struct Point {
    x: Vec<f64>,
    energy: f64,
    gradient: Vec<f64>,
}

/// Minimises `function` from `start`; `watch` receives every accepted point.
///
/// The search uses tangents divided by the step scales of the space. The history is carried along unchanged, because
/// tangents are expressed in the moving body's frame. Steps satisfy the weak Wolfe conditions (A. S. Lewis and M. L.
/// Overton, Math. Program. 141, 135 (2013)), near convergence in the slope form of W. W. Hager and H. Zhang, SIAM J. Optim.
/// 16, 170 (2005), eq. 4. A value of +∞ refuses a step.
pub(super) fn minimise(
    space: &dyn Space,
    function: &mut Function<'_>,
    start: &[f64],
    settings: &QuenchSettings,
    watch: &mut dyn FnMut(&[f64], f64),
) -> Quench {
    let scales = space.step_scales();
    let mut here = Point {
        x: start.to_vec(),
        energy: f64::INFINITY,
        gradient: vec![0.0; space.tangents()],
    };
    here.energy = function(&here.x, &mut here.gradient);
    let mut evaluations = 1;
    let mut history: VecDeque<Pair> = VecDeque::with_capacity(HISTORY);
    let mut stiffness_inverse = None;
    let mut idle = 0;
    let mut smallest = f64::INFINITY;

    let stop = loop {
        if !here.energy.is_finite() {
            break StopReason::Stalled;
        }
        let size = norm(&here.gradient);
        if size <= settings.gradient_tolerance {
            break StopReason::Converged;
        }
        if evaluations >= settings.max_evaluations {
            break StopReason::Budget;
        }
        if idle >= IDLE {
            break StopReason::Stalled;
        }
        let gradient = times(&here.gradient, &scales);
        let softness = stiffness_inverse.unwrap_or(1.0);
        let mut direction = quasi_newton(&history, &gradient, softness);
        if dot(&direction, &gradient) > -1e-12 * norm(&direction) * norm(&gradient) {
            history.clear();
            direction = quasi_newton(&history, &gradient, softness);
        }
        let longest = settings.max_step / norm(&direction);
        let first = match stiffness_inverse {
            // The curvature is not known yet, so the first step is short.
            None => 0.1 * longest,
            Some(_) => longest.min(1.0),
        };
        let found = search(
            space,
            function,
            &here,
            &times(&direction, &scales),
            (first, longest),
            &mut evaluations,
        );
        let Some((t, next)) = found else {
            if history.is_empty() {
                break StopReason::Stalled;
            }
            history.clear();
            continue;
        };
        scale(&mut direction, t);
        let mut change = times(&next.gradient, &scales);
        add(&mut change, -1.0, &gradient);
        let curvature = dot(&direction, &change);
        if curvature > 1e-12 * norm(&direction) * norm(&change) {
            stiffness_inverse = Some(curvature / dot(&change, &change));
            if history.len() == HISTORY {
                history.pop_front();
            }
            history.push_back(Pair {
                step: direction,
                change,
                curvature,
            });
        }
        let fell = next.energy < here.energy - 1e-15 * here.energy.abs();
        let size = norm(&next.gradient);
        idle = if fell || size < smallest { 0 } else { idle + 1 };
        smallest = smallest.min(size);
        here = next;
        watch(&here.x, here.energy);
    };
    Quench {
        gradient_norm: norm(&here.gradient),
        x: here.x,
        energy: here.energy,
        evaluations,
        stop,
    }
}

/// −H⁻¹g by the two-loop recursion (Nocedal, Math. Comput. 35, 773 (1980)).
fn quasi_newton(history: &VecDeque<Pair>, gradient: &[f64], stiffness_inverse: f64) -> Vec<f64> {
    let mut q: Vec<f64> = gradient.iter().map(|g| -g).collect();
    let mut shares = Vec::with_capacity(history.len());
    for pair in history.iter().rev() {
        let share = dot(&pair.step, &q) / pair.curvature;
        add(&mut q, -share, &pair.change);
        shares.push(share);
    }
    scale(&mut q, stiffness_inverse);
    for (pair, share) in history.iter().zip(shares.iter().rev()) {
        let back = dot(&pair.change, &q) / pair.curvature;
        add(&mut q, share - back, &pair.step);
    }
    q
}

/// A point on `direction` (plain tangents) that satisfies the weak Wolfe conditions, with its fraction of `direction`;
/// `None` if the trials find no such point.
fn search(
    space: &dyn Space,
    function: &mut Function<'_>,
    here: &Point,
    direction: &[f64],
    (first, longest): (f64, f64),
    evaluations: &mut usize,
) -> Option<(f64, Point)> {
    let slope = dot(direction, &here.gradient);
    let (mut low, mut high) = (0.0, f64::INFINITY);
    let mut t = first;
    let mut best: Option<(f64, Point)> = None;
    for _ in 0..TRIALS {
        let mut next = here.clone();
        let mut step = direction.to_vec();
        scale(&mut step, t);
        space.exp(&mut next.x, &step);
        next.energy = function(&next.x, &mut next.gradient);
        *evaluations += 1;
        let slope_there = dot(direction, &next.gradient);
        let lower = next.energy <= here.energy + DECREASE * t * slope;
        let level = next.energy <= here.energy + ROUNDING * here.energy.abs()
            && slope_there <= (2.0 * DECREASE - 1.0) * slope;
        if !(lower || level) {
            high = t;
            let secant = 2.0 * (next.energy - here.energy - t * slope);
            let parabola = -slope * t * t / secant;
            t = if parabola.is_finite() {
                parabola.clamp(low + 0.1 * (high - low), low + 0.5 * (high - low))
            } else {
                low + 0.1 * (high - low)
            };
        } else if slope_there < CURVATURE * slope && t < longest {
            low = t;
            best = Some((t, next));
            t = if high.is_finite() {
                f64::midpoint(low, high)
            } else {
                (2.5 * t).min(longest)
            };
        } else {
            return Some((t, next));
        }
    }
    best
}
