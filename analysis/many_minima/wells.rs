//! A surface of many wells whose tree is known.
//!
//! E(x, y) = f(x) + f(y + 7) with f(x) = −cos 2πx + 0.3 sin(1.3 x) + 0.2 sin(0.9 x + 1). The surface is a sum of two functions
//! of one variable, so its wells and passes, and with them the tree, are known.

use landscape::energy::Energy;
use landscape::space::{Euclidean, Space};

const SHIFT: f64 = 7.0;

fn f(x: f64) -> [f64; 2] {
    let turn = std::f64::consts::TAU;
    [
        -libm::cos(turn * x) + 0.3 * libm::sin(1.3 * x) + 0.2 * libm::sin(0.9 * x + 1.0),
        turn * libm::sin(turn * x) + 0.39 * libm::cos(1.3 * x) + 0.18 * libm::cos(0.9 * x + 1.0),
    ]
}

/// The stationary point of f near `x`, by bisection of its derivative.
fn stationary(x: f64) -> f64 {
    let (mut low, mut high) = (x - 0.2, x + 0.2);
    let rising = f(high)[1] > 0.0;
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if (f(middle)[1] > 0.0) == rising {
            high = middle;
        } else {
            low = middle;
        }
    }
    f64::midpoint(low, high)
}

/// The surface E(x, y) = f(x) + f(y + 7).
pub(crate) struct Wells {
    space: Euclidean,
}

impl Wells {
    pub(crate) fn new() -> Self {
        Self {
            space: Euclidean::new(2),
        }
    }
}

impl Energy for Wells {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let [a, b] = [f(x[0]), f(x[1] + SHIFT)];
        gradient.copy_from_slice(&[a[1], b[1]]);
        a[0] + b[0]
    }
}

/// Wells around those that are mapped, through which the lowest way between two of them may lead.
pub(crate) const MARGIN: usize = 12;

/// The exact tree of the wells and of those around them: for each well the well under which it lies, and the height at
/// which the two join. Heights grow upwards.
pub(crate) struct Exact {
    side: usize,
    margin: usize,
    above: Vec<(usize, f64)>,
}

impl Exact {
    /// Floods the passes between neighbouring wells from below, with `margin` wells around those that are mapped.
    pub(crate) fn new(side: usize, margin: usize) -> Self {
        let side = side + 2 * margin;
        let [low, high] = stationary_values(side, margin);
        let mut passes = passes(&low, &high);
        passes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut exact = Self {
            side,
            margin,
            above: (0..side * side).map(|k| (k, f64::INFINITY)).collect(),
        };
        let mut size = vec![1; side * side];
        for (height, [a, b]) in passes {
            let (a, b) = (exact.root(a), exact.root(b));
            if a != b {
                let (small, large) = if size[a] < size[b] { (a, b) } else { (b, a) };
                exact.above[small] = (large, height);
                size[large] += size[small];
            }
        }
        exact
    }

    fn root(&self, mut well: usize) -> usize {
        while self.above[well].0 != well {
            well = self.above[well].0;
        }
        well
    }

    /// Lowest height at which two of the mapped wells are connected.
    pub(crate) fn minimax(&self, a: usize, b: usize) -> f64 {
        let inside = self.side - 2 * self.margin;
        let place = |k: usize| (k / inside + self.margin) * self.side + k % inside + self.margin;
        let (mut a, mut b) = (place(a), place(b));
        let mut height = f64::NEG_INFINITY;
        // The one that joins lower goes up, until both are one.
        while a != b {
            if self.above[a].1 > self.above[b].1 {
                (a, b) = (b, a);
            }
            height = self.above[a].1;
            a = self.above[a].0;
        }
        height
    }
}

/// The values of f at the minima and maxima of either coordinate, from `margin` wells before the first on.
fn stationary_values(side: usize, margin: usize) -> [[Vec<f64>; 2]; 2] {
    [0.0, 0.5].map(|half| {
        [0.0, SHIFT].map(|shift| {
            let place = |k: usize| k as f64 - margin as f64 + shift + half;
            let values = (0..side).map(|k| f(stationary(place(k)))[0]);
            values.collect()
        })
    })
}

/// Energies and ends of the passes between neighbouring wells.
fn passes(low: &[Vec<f64>; 2], high: &[Vec<f64>; 2]) -> Vec<(f64, [usize; 2])> {
    let side = low[0].len();
    let mut passes = Vec::new();
    for i in 0..side {
        for j in 0..side {
            if i + 1 < side {
                let ends = [i * side + j, (i + 1) * side + j];
                passes.push((high[0][i] + low[1][j], ends));
            }
            if j + 1 < side {
                passes.push((low[0][i] + high[1][j], [i * side + j, i * side + j + 1]));
            }
        }
    }
    passes
}

/// Energies of the wells of a square, and energies and ends of the passes between neighbours.
pub(crate) fn network(side: usize) -> (Vec<f64>, Vec<(f64, [usize; 2])>) {
    let [low, high] = stationary_values(side, 0);
    let wells = (0..side * side).map(|k| low[0][k / side] + low[1][k % side]);
    (wells.collect(), passes(&low, &high))
}
