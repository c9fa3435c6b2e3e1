//! Elimination of states from a network of rates: graph transformation.

use std::collections::{BTreeMap, BTreeSet};

use super::{log_add, log_sum};

/// No sequence of transitions leads from a state to the targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("no sequence of transitions leads from state {0} (counted from 0) to the targets")]
pub struct Unreachable(pub usize);

/// A linear system on a network with some states eliminated.
///
/// The mean of a quantity that is gathered until absorption obeys, for each state i that is not absorbing,
///
/// ```text
/// Kᵢ yᵢ = wᵢ + Σⱼ kᵢⱼ yⱼ,   Kᵢ = Σⱼ kᵢⱼ
/// ```
///
/// kᵢⱼ: rate from i to j; y: the mean first-passage time for wᵢ = 1, a committor for wᵢ = 0. Eliminating state x gives
///
/// ```text
/// kᵢⱼ ← kᵢⱼ + kᵢₓ kₓⱼ/Kₓ  (i ≠ j),   wᵢ ← wᵢ + kᵢₓ wₓ/Kₓ
/// ```
///
/// This is the graph transformation of S. A. Trygubenko and D. J. Wales, J. Chem. Phys. 124, 234110 (2006), for rates in
/// place of branching probabilities and waiting times. Kₓ is summed anew from the other rates, so nothing is ever
/// subtracted (as in W. K. Grassmann, M. I. Taksar and D. P. Heyman, Oper. Res. 33, 1107 (1985)): every result keeps its
/// relative accuracy, however small it is. All numbers are logarithms.
pub(super) struct Elimination {
    /// Rates between the states that are left: ln kᵢⱼ.
    pub(super) left: Vec<BTreeMap<usize, f64>>,
    /// Eliminated states in order, with what is needed to find their value from those of later ones.
    steps: Vec<Step>,
}

struct Step {
    state: usize,
    /// ln(kₓⱼ/Kₓ) for the states j that were left.
    branches: Vec<(usize, f64)>,
    /// ln(wₓ/Kₓ).
    log_gain: f64,
}

impl Elimination {
    /// Eliminates the states for which `kept` is false; `log_source` is ln w of every state.
    pub(super) fn new(rates: &[BTreeMap<usize, f64>], kept: &[bool], log_source: f64) -> Self {
        let mut left = rates.to_vec();
        let mut into: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); left.len()];
        for (from, targets) in left.iter().enumerate() {
            for to in targets.keys() {
                into[*to].insert(from);
            }
        }
        let mut source = vec![log_source; left.len()];
        // States with few neighbours first, so that few new transitions arise.
        let size = |left: &[BTreeMap<usize, f64>], into: &[BTreeSet<usize>], state: usize| {
            left[state].len().max(into[state].len())
        };
        let mut queue: BTreeSet<(usize, usize)> = (0..left.len())
            .filter(|state| !kept[*state])
            .map(|state| (size(&left, &into, state), state))
            .collect();
        let mut steps = Vec::with_capacity(queue.len());
        while let Some((_, state)) = queue.pop_first() {
            let targets = std::mem::take(&mut left[state]);
            let sources = std::mem::take(&mut into[state]);
            let exit = log_sum(targets.values().copied());
            let branches: Vec<(usize, f64)> = targets
                .into_iter()
                .map(|(to, rate)| (to, rate - exit))
                .collect();
            let mut touched = BTreeSet::new();
            for (to, _) in &branches {
                touched.insert((size(&left, &into, *to), *to));
            }
            for from in &sources {
                touched.insert((size(&left, &into, *from), *from));
            }
            let log_gain = source[state] - exit;
            for from in &sources {
                let Some(inflow) = left[*from].remove(&state) else {
                    continue;
                };
                source[*from] = log_add(source[*from], inflow + log_gain);
                for (to, share) in &branches {
                    if to != from {
                        let rate = left[*from].entry(*to).or_insert(f64::NEG_INFINITY);
                        *rate = log_add(*rate, inflow + share);
                        into[*to].insert(*from);
                    }
                }
            }
            for (to, _) in &branches {
                into[*to].remove(&state);
            }
            for (before, neighbour) in touched {
                if queue.remove(&(before, neighbour)) {
                    queue.insert((size(&left, &into, neighbour), neighbour));
                }
            }
            steps.push(Step {
                state,
                branches,
                log_gain,
            });
        }
        Self { left, steps }
    }

    /// Logarithms of the values of all states, from those of the states that were kept. A state without transitions has
    /// the value w/0 = ∞, or 0 if w = 0.
    pub(super) fn values(&self, mut values: Vec<f64>) -> Vec<f64> {
        for step in self.steps.iter().rev() {
            let later = step.branches.iter();
            let gained = if step.log_gain.is_nan() {
                f64::NEG_INFINITY
            } else {
                step.log_gain
            };
            values[step.state] =
                later.fold(gained, |sum, (to, share)| log_add(sum, share + values[*to]));
        }
        values
    }
}
