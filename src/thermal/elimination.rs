//! Elimination of states from a network of rates: graph transformation.

use std::collections::{BTreeMap, BTreeSet};

use super::dense::Dense;
use super::{log_add, log_sum};
use crate::topography::{Observer, Phase, Progress};

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
///
/// Elimination fills the network. Once it is nearly full, the rest is a [`Dense`] matrix of the numbers themselves, unless
/// these span too many powers of ten.
pub(super) struct Elimination {
    /// Rates between the states that are left: ln kᵢⱼ.
    pub(super) left: Vec<BTreeMap<usize, f64>>,
    /// ln wᵢ of the states that are left.
    pub(super) log_sources: Vec<f64>,
    /// Eliminated states in order, with what is needed to find their value from those of later ones.
    steps: Vec<Step>,
}

/// The elimination of one state.
pub(super) struct Step {
    pub(super) state: usize,
    /// ln(kₓⱼ/Kₓ) for the states j that were left.
    pub(super) branches: Vec<(usize, f64)>,
    /// ln(wₓ/Kₓ).
    pub(super) log_gain: f64,
}

/// Whether w counts in the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Gains {
    /// As for times.
    Counted,
    /// w = 0, as for committors.
    Left,
}

/// The rest is eliminated as a dense matrix once the state with the fewest neighbours has more than this share of the states
/// that are left. A transition in a map costs about a hundred times as much as one in a matrix.
const FULL: f64 = 0.04;
/// Fewer states are not worth a matrix.
const FEWEST: usize = 64;
/// Number of states between two reports of progress.
const REPORTED: usize = 64;
/// More states need too much memory (8 bytes for each pair).
const MOST: usize = 12_000;

impl Elimination {
    /// Eliminates the states for which `kept` is false; `log_sources` is ln w of every state.
    pub(super) fn new(
        rates: &[BTreeMap<usize, f64>],
        kept: &[bool],
        log_sources: Vec<f64>,
        observer: &Observer<'_>,
    ) -> Self {
        let mut left = rates.to_vec();
        let mut into: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); left.len()];
        for (from, targets) in left.iter().enumerate() {
            for to in targets.keys() {
                into[*to].insert(from);
            }
        }
        let mut source = log_sources;
        // States with few neighbours first, so that few new transitions arise.
        let size = |left: &[BTreeMap<usize, f64>], into: &[BTreeSet<usize>], state: usize| {
            left[state].len().max(into[state].len())
        };
        let mut queue: BTreeSet<(usize, usize)> = (0..left.len())
            .filter(|state| !kept[*state])
            .map(|state| (size(&left, &into, state), state))
            .collect();
        let kept: Vec<usize> = (0..left.len()).filter(|state| kept[*state]).collect();
        let mut steps = Vec::with_capacity(queue.len());
        let mut may_be_dense = true;
        let total = queue.len();
        let tell = |done: usize| {
            if done.is_multiple_of(REPORTED) || done == total {
                observer(Progress {
                    phase: Phase::Eliminate,
                    done,
                    total,
                    round: None,
                });
            }
        };
        while let Some((neighbours, state)) = queue.pop_first() {
            let remaining = kept.len() + queue.len() + 1;
            let is_full = remaining >= FEWEST && neighbours as f64 > FULL * remaining as f64;
            tell(steps.len());
            if may_be_dense && is_full && remaining <= MOST {
                let mut order: Vec<usize> = vec![state];
                order.extend(queue.iter().map(|(_, state)| *state));
                let before = steps.len();
                if let Some(dense) = Dense::new(&left, &source, &kept, &order)
                    && let Some(done) = dense.eliminate(&mut left, &mut source, &|more| {
                        tell(before + more);
                    })
                {
                    steps.extend(done);
                    break;
                }
                may_be_dense = false;
            }
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
        Self {
            left,
            log_sources: source,
            steps,
        }
    }

    /// Logarithms of the values of all states, from those of the states that were kept. A state without transitions has
    /// the value w/0 = ∞, or 0 if w = 0.
    pub(super) fn values(&self, mut values: Vec<f64>, gains: Gains) -> Vec<f64> {
        for step in self.steps.iter().rev() {
            let later = step.branches.iter();
            let gained = match gains {
                Gains::Counted => step.log_gain,
                Gains::Left => f64::NEG_INFINITY,
            };
            values[step.state] =
                later.fold(gained, |sum, (to, share)| log_add(sum, share + values[*to]));
        }
        values
    }
}
