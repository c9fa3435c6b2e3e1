//! Elimination of states from a network in which nearly all states are neighbours.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::elimination::Step;
use super::log_add;

/// Numbers below this lose digits, and then all is done in logarithms.
const SMALLEST: f64 = 1e-290;
/// Greatest ln(kₘₐₓ/kₘᵢₙ) at the start, which leaves room for smaller numbers that arise.
const WIDEST: f64 = 300.0;
/// Number of states that are eliminated from all rows at once.
const BLOCK: usize = 32;
/// Numbers of rows and columns that are changed together, so that the parts of the matrix they need stay in a cache.
const ROWS: usize = 16;
const TILE: usize = 512;

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
    ///
    /// Rows of states that stay are changed by [`BLOCK`] eliminations at once, since reading the matrix takes longer than
    /// computing with it. Each number is the same as by one elimination after the other.
    pub(super) fn eliminate(
        mut self,
        left: &mut [BTreeMap<usize, f64>],
        log_sources: &mut [f64],
        done: &dyn Fn(usize),
    ) -> Option<Vec<Step>> {
        let count = self.states.len();
        let mut steps = Vec::with_capacity(count - self.kept.len());
        let mut end = count;
        while end > self.kept.len() {
            let first = self.kept.len().max(end.saturating_sub(BLOCK));
            let (above, block) = self.rates.split_at_mut(first * count);
            let (sources, own_sources) = self.log_sources.split_at_mut(first);
            let mut pivots = Vec::with_capacity(end - first);
            for last in (first..end).rev() {
                let (before, own) = block.split_at_mut((last - first) * count);
                let branches = &own[..last];
                let pivot = Pivot::new(last, branches, self.log_unit, own_sources[last - first]);
                let rows = before.chunks_exact_mut(count).zip(&mut own_sources[..]);
                for (own, (row, source)) in rows.enumerate() {
                    let factor = pivot.factor(row, source)?;
                    add(&mut row[..last], &[(factor, branches)]);
                    row[first + own] = 0.0;
                }
                let log_exit = libm::log(pivot.exit);
                let branches = branches.iter().zip(&self.states);
                let branches = branches.filter(|(rate, _)| **rate > 0.0);
                steps.push(Step {
                    state: self.states[last],
                    branches: branches
                        .map(|(rate, state)| (*state, libm::log(*rate) - log_exit))
                        .collect(),
                    log_gain: pivot.log_gain,
                });
                pivots.push(pivot);
            }
            let block = &*block;
            let branches = |pivot: &Pivot| &block[(pivot.last - first) * count..][..pivot.last];
            let eliminate = |(group, (rows, sources)): (usize, (&mut [f64], &mut [f64]))| {
                let mut factors = Vec::with_capacity(ROWS * pivots.len());
                for (row, source) in rows.chunks_exact_mut(count).zip(sources) {
                    for pivot in &pivots {
                        let factor = pivot.factor(row, source)?;
                        let between = &branches(pivot)[first..];
                        add(&mut row[first..pivot.last], &[(factor, between)]);
                        factors.push(factor);
                    }
                }
                for tile in (0..first).step_by(TILE) {
                    let tile = tile..first.min(tile + TILE);
                    let rows = rows.chunks_exact_mut(count);
                    for (row, factors) in rows.zip(factors.chunks_exact(pivots.len())) {
                        let parts = factors.iter().zip(&pivots);
                        let parts = parts.map(|(f, pivot)| (*f, &branches(pivot)[tile.clone()]));
                        add(&mut row[tile.clone()], &parts.collect::<Vec<_>>());
                    }
                }
                for (own, row) in rows.chunks_exact_mut(count).enumerate() {
                    row[group * ROWS + own] = 0.0;
                }
                Some(())
            };
            let groups = above
                .par_chunks_mut(ROWS * count)
                .zip(sources.par_chunks_mut(ROWS));
            groups.enumerate().map(eliminate).collect::<Option<()>>()?;
            done(count - first);
            end = first;
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

/// A state that is eliminated.
struct Pivot {
    last: usize,
    exit: f64,
    smallest: f64,
    log_unit: f64,
    log_gain: f64,
}

impl Pivot {
    fn new(last: usize, branches: &[f64], log_unit: f64, log_source: f64) -> Self {
        let exit: f64 = branches.iter().sum();
        let positive = branches.iter().copied().filter(|rate| *rate > 0.0);
        Self {
            last,
            exit,
            smallest: positive.fold(f64::INFINITY, f64::min),
            log_unit,
            // A state without transitions holds what reaches it for ever.
            log_gain: log_source - (libm::log(exit) + log_unit),
        }
    }

    /// Adds to the source of a row and returns by what the branches are multiplied that its rates gain; `None` if a number
    /// became too small.
    fn factor(&self, row: &[f64], source: &mut f64) -> Option<f64> {
        let inflow = row[self.last];
        if inflow == 0.0 {
            return Some(0.0);
        }
        let log_inflow = libm::log(inflow) + self.log_unit;
        *source = log_add(*source, log_inflow + self.log_gain);
        if self.exit == 0.0 {
            return Some(0.0);
        }
        let factor = inflow / self.exit;
        (factor * self.smallest >= SMALLEST).then_some(factor)
    }
}

/// Adds multiples to a row, one after the other.
fn add(row: &mut [f64], parts: &[(f64, &[f64])]) {
    let mut fours = parts.chunks_exact(4);
    for four in &mut fours {
        let [a, b, c, d] = [four[0], four[1], four[2], four[3]];
        let branches = a.1.iter().zip(b.1).zip(c.1).zip(d.1);
        for (rate, (((one, two), three), last)) in row.iter_mut().zip(branches) {
            *rate = *rate + a.0 * one + b.0 * two + c.0 * three + d.0 * last;
        }
    }
    for (factor, branches) in fours.remainder() {
        for (rate, branch) in row.iter_mut().zip(*branches) {
            *rate += factor * branch;
        }
    }
}
