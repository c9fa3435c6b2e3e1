//! Elimination of states from a network in which nearly all states are neighbours.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::elimination::Step;
use super::log_add;

/// Numbers below this lose digits, and then all is done in logarithms.
const SMALLEST: f64 = 1e-290;
/// Greatest ln(kₘₐₓ/kₘᵢₙ) at the start, which leaves room for smaller numbers that arise.
const WIDEST: f64 = 300.0;
/// Number of rows that one task changes.
const ROWS: usize = 16;

/// Rates kᵢⱼ of a network, divided by e^`log_unit`. The states that are eliminated come last, the first one at the end.
pub(super) struct Dense<'a> {
    kept: &'a [usize],
    states: Vec<usize>,
    rates: Vec<f64>,
    log_unit: f64,
    log_sources: Vec<f64>,
}

impl<'a> Dense<'a> {
    /// The matrix of the rates between states that are `kept` and those to be eliminated, in this `order`. `None` if the
    /// rates span too many powers of ten.
    pub(super) fn new(
        log_rates: &[BTreeMap<usize, f64>],
        log_sources: &[f64],
        kept: &'a [usize],
        order: &[usize],
    ) -> Option<Self> {
        let states: Vec<usize> = kept.iter().chain(order.iter().rev()).copied().collect();
        let mut place = vec![usize::MAX; log_rates.len()];
        for (row, state) in states.iter().enumerate() {
            place[*state] = row;
        }
        let finite = || {
            let all = states.iter().flat_map(|state| log_rates[*state].values());
            all.copied().filter(|rate| rate.is_finite())
        };
        let log_unit = finite().fold(f64::NEG_INFINITY, f64::max);
        if !log_unit.is_finite() || log_unit - finite().fold(f64::INFINITY, f64::min) > WIDEST {
            return None;
        }
        let count = states.len();
        let mut rates = vec![0.0; count * count];
        for (row, state) in rates.chunks_exact_mut(count).zip(&states) {
            for (to, rate) in &log_rates[*state] {
                row[place[*to]] = libm::exp(rate - log_unit);
            }
        }
        Some(Self {
            kept,
            log_sources: states.iter().map(|state| log_sources[*state]).collect(),
            states,
            rates,
            log_unit,
        })
    }

    /// Eliminates the states and writes what is left of rates and sources into those of the network. `None`, with nothing
    /// written, if a number became too small. `done` hears how many states are eliminated.
    pub(super) fn eliminate(
        mut self,
        left: &mut [BTreeMap<usize, f64>],
        log_sources: &mut [f64],
        done: &dyn Fn(usize),
    ) -> Option<Vec<Step>> {
        let (count, log_unit) = (self.states.len(), self.log_unit);
        let mut steps = Vec::with_capacity(count - self.kept.len());
        for last in (self.kept.len()..count).rev() {
            let (rows, own) = self.rates.split_at_mut(last * count);
            let branches = &own[..last];
            let exit: f64 = branches.iter().sum();
            let positive = branches.iter().copied().filter(|rate| *rate > 0.0);
            let smallest = positive.fold(f64::INFINITY, f64::min);
            // A state without transitions holds what reaches it for ever.
            let log_gain = self.log_sources[last] - (libm::log(exit) + log_unit);
            let eliminate = |(place, (row, source)): (usize, (&mut [f64], &mut f64))| {
                let inflow = row[last];
                if inflow == 0.0 {
                    return Some(());
                }
                *source = log_add(*source, libm::log(inflow) + log_unit + log_gain);
                if exit > 0.0 {
                    let factor = inflow / exit;
                    if factor * smallest < SMALLEST {
                        return None;
                    }
                    for (rate, branch) in row.iter_mut().zip(branches) {
                        *rate += factor * branch;
                    }
                }
                row[place] = 0.0;
                Some(())
            };
            let rows = rows
                .par_chunks_exact_mut(count)
                .zip(&mut self.log_sources[..last]);
            (rows.enumerate().with_min_len(ROWS))
                .map(eliminate)
                .collect::<Option<()>>()?;
            let log_exit = libm::log(exit);
            let branches = branches.iter().zip(&self.states);
            let branches = branches.filter(|(rate, _)| **rate > 0.0);
            steps.push(Step {
                state: self.states[last],
                branches: branches
                    .map(|(rate, state)| (*state, libm::log(*rate) - log_exit))
                    .collect(),
                log_gain,
            });
            done(count - last);
        }
        for state in &self.states {
            left[*state].clear();
        }
        for (row, state) in self.kept.iter().enumerate() {
            log_sources[*state] = self.log_sources[row];
            let rates = &self.rates[row * count..][..self.kept.len()];
            let rates = rates.iter().zip(self.kept).filter(|(rate, _)| **rate > 0.0);
            left[*state] = rates
                .map(|(rate, to)| (*to, libm::log(*rate) + self.log_unit))
                .collect();
        }
        Some(steps)
    }
}
