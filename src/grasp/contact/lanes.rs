//! Groups of candidates, laid out for vectorised sums and for lookups of those that oppose a force.

use super::{Candidate, SLACK, reach_squared, wrench_cost};

pub(super) const LANES: usize = 8;

/// A group of neighbouring candidates, laid out for vectorised sums. Missing ones have infinite cost.
#[derive(Debug, Clone)]
pub(super) struct Lanes {
    pub(super) cost: [f64; LANES],
    wrench: [[f64; LANES]; 6],
}

impl Lanes {
    #[inline]
    pub(super) fn of(candidates: &[Candidate]) -> Self {
        let mut lanes = Self {
            cost: [f64::INFINITY; LANES],
            wrench: [[0.0; LANES]; 6],
        };
        for (lane, candidate) in candidates.iter().enumerate() {
            lanes.cost[lane] = candidate.cost;
            for (row, component) in lanes.wrench.iter_mut().zip(candidate.wrench) {
                row[lane] = component;
            }
        }
        lanes
    }

    /// Totals of the sets that each candidate completes, where the other members cost `own` and have the net `wrench`.
    #[inline]
    pub(super) fn totals(&self, own: f64, wrench: &[f64; 6]) -> [f64; LANES] {
        let mut squares = [0.0; LANES];
        for (row, component) in self.wrench.iter().zip(wrench) {
            for (square, w) in squares.iter_mut().zip(row) {
                *square += (component + w) * (component + w);
            }
        }
        std::array::from_fn(|lane| own + self.cost[lane] + wrench_cost(squares[lane]))
    }

    /// Tests, for each candidate and a last one that costs as much, whether a unit force can cancel their remaining force
    /// closely enough at a budget of `left`; negative if not.
    ///
    /// The remaining force F may have a length from 1 − r to 1 + r for a reach r: F² + 1 − r² ≤ 2 F, squared.
    #[inline]
    pub(super) fn spare(&self, wrench: &[f64; 6], left: f64) -> [f64; LANES] {
        let [x, y, z, ..] = &self.wrench;
        std::array::from_fn(|lane| {
            let sum = [
                wrench[0] + x[lane],
                wrench[1] + y[lane],
                wrench[2] + z[lane],
            ];
            let squared = sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2];
            let excess = (squared + 1.0 - reach_squared(left - 2.0 * self.cost[lane])).max(0.0);
            4.0 * squared + SLACK - excess * excess
        })
    }
}

/// Bit sets of the candidates that push in given directions. Three lookups give all that oppose a force.
#[derive(Debug, Clone, Default)]
pub(super) struct Directions {
    pub(super) blocks: Vec<Block>,
}

/// Number of candidates in a block, one for each bit of a word.
pub(super) const BLOCK: usize = 64;

/// Cells per axis of the grid over force directions.
const CELLS: usize = 16;

/// For each axis, the candidates whose force lies in a given range of cells.
#[derive(Debug, Clone)]
pub(super) struct Block {
    ranges: [[[u64; CELLS]; CELLS]; 3],
}

impl Directions {
    #[inline]
    pub(super) fn list(&mut self, candidates: &[Candidate]) {
        self.blocks.clear();
        for chunk in candidates.chunks(BLOCK) {
            let mut ranges = [[[0; CELLS]; CELLS]; 3];
            for (bit, candidate) in chunk.iter().enumerate() {
                for (range, component) in ranges.iter_mut().zip(&candidate.wrench) {
                    let cell = cell_of(*component);
                    range[cell][cell] |= 1 << bit;
                }
            }
            for range in &mut ranges {
                for low in 0..CELLS {
                    for high in low + 1..CELLS {
                        range[low][high] = range[low][high - 1] | range[high][high];
                    }
                }
            }
            self.blocks.push(Block { ranges });
        }
    }
}

impl Block {
    /// Candidates whose force is within `reach` of the opposite force along every axis (and some others).
    #[inline]
    pub(super) fn opposed(&self, wrench: &[f64; 6], reach: f64) -> u64 {
        let axes = self.ranges.iter().zip(wrench);
        axes.fold(u64::MAX, |set, (range, component)| {
            set & range[cell_of(-component - reach)][cell_of(-component + reach)]
        })
    }
}

/// Cell of a component of a unit vector. Components beyond ±1 are in the outermost cells.
fn cell_of(component: f64) -> usize {
    let scaled = ((component + 1.0) * 0.5 * CELLS as f64).clamp(0.0, (CELLS - 1) as f64);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to 0..CELLS just above; the cut-off fraction is meant"
    )]
    let cell = scaled as usize;
    cell
}
