//! The linear assignment problem.

/// Solves min over permutations P of Σ cost(i, P(i)) exactly, in O(n³), with buffers kept between calls.
///
/// Shortest augmenting paths with potentials: R. Jonker and A. Volgenant, Computing 38, 325 (1987).
#[derive(Debug)]
pub(super) struct Assignment {
    /// P: column of each row, the result of the last [`Assignment::solve`].
    pub(super) column: Vec<usize>,
    row: Vec<usize>,
    row_potential: Vec<f64>,
    column_potential: Vec<f64>,
    slack: Vec<f64>,
    previous: Vec<usize>,
    done: Vec<bool>,
}

const FREE: usize = usize::MAX;

impl Assignment {
    pub(super) fn new(n: usize) -> Self {
        Self {
            column: (0..n).collect(),
            row: vec![FREE; n],
            row_potential: vec![0.0; n],
            column_potential: vec![0.0; n],
            slack: vec![0.0; n],
            previous: vec![FREE; n],
            done: vec![false; n],
        }
    }

    /// `cost`: n × n matrix in row-major order, finite.
    pub(super) fn solve(&mut self, cost: &[f64]) {
        let n = self.column.len();
        assert_eq!(cost.len(), n * n);
        if self.nearest_is_a_permutation(cost) {
            return;
        }
        self.row.fill(FREE);
        self.row_potential.fill(0.0);
        self.column_potential.fill(0.0);
        for start in 0..n {
            self.augment(cost, start);
        }
        for (column, row) in self.row.iter().enumerate() {
            self.column[*row] = column;
        }
    }

    /// Handles the common case of almost aligned clusters: every row has its own cheapest column.
    fn nearest_is_a_permutation(&mut self, cost: &[f64]) -> bool {
        let n = self.column.len();
        self.done.fill(false);
        for (costs, best) in cost.chunks_exact(n).zip(&mut self.column) {
            let mut least = 0;
            for column in 1..n {
                if costs[column] < costs[least] {
                    least = column;
                }
            }
            if std::mem::replace(&mut self.done[least], true) {
                return false;
            }
            *best = least;
        }
        true
    }

    /// Assigns row `start` a column along the cheapest alternating path in reduced costs.
    fn augment(&mut self, cost: &[f64], start: usize) {
        let n = self.column.len();
        self.slack.fill(f64::INFINITY);
        self.done.fill(false);
        let (mut row, mut via) = (start, FREE);
        loop {
            let (mut least, mut next) = (f64::INFINITY, FREE);
            for column in 0..n {
                if self.done[column] {
                    continue;
                }
                let reduced = cost[row * n + column]
                    - self.row_potential[row]
                    - self.column_potential[column];
                if reduced < self.slack[column] {
                    self.slack[column] = reduced;
                    self.previous[column] = via;
                }
                if self.slack[column] < least {
                    (least, next) = (self.slack[column], column);
                }
            }
            self.row_potential[start] += least;
            for column in 0..n {
                if self.done[column] {
                    self.row_potential[self.row[column]] += least;
                    self.column_potential[column] -= least;
                } else {
                    self.slack[column] -= least;
                }
            }
            self.done[next] = true;
            via = next;
            if self.row[next] == FREE {
                break;
            }
            row = self.row[next];
        }
        while via != FREE {
            let before = self.previous[via];
            self.row[via] = if before == FREE {
                start
            } else {
                self.row[before]
            };
            via = before;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::sample::{Task, stream};

    fn least_by_enumeration(cost: &[f64], n: usize, row: usize, used: &mut Vec<usize>) -> f64 {
        if row == n {
            return 0.0;
        }
        let mut best = f64::INFINITY;
        for column in 0..n {
            if !used.contains(&column) {
                used.push(column);
                best =
                    best.min(cost[row * n + column] + least_by_enumeration(cost, n, row + 1, used));
                used.pop();
            }
        }
        best
    }

    #[test]
    fn as_good_as_trying_every_permutation() {
        let mut rng = stream(1, Task::Start, 0);
        for n in 1..=6 {
            let mut assignment = Assignment::new(n);
            for _ in 0..50 {
                let cost: Vec<f64> = (0..n * n).map(|_| rng.random()).collect();
                assignment.solve(&cost);
                let found: f64 = (0..n)
                    .map(|row| cost[row * n + assignment.column[row]])
                    .sum();
                let mut columns = assignment.column.clone();
                columns.sort_unstable();
                assert!(columns.into_iter().eq(0..n));
                let best = least_by_enumeration(&cost, n, 0, &mut Vec::new());
                assert!((found - best).abs() < 1e-12, "{found} instead of {best}");
            }
        }
    }
}
