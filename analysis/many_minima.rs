//! A map of many minima beside the exact answer: time, memory and heights.
//!
//! `cargo run --release --example many_minima -- SIDE` maps a surface of SIDE × SIDE wells of different depths,
//! E(x, y) = f(x) + f(y + 7) with f(x) = −cos 2πx + 0.3 sin(1.3 x) + 0.2 sin(0.9 x + 1), by the same engine that maps grasps.
//! The surface is a sum of two functions of one variable, so its wells and passes, and with them the tree, are known.

use std::time::Instant;

use landscape::energy::Energy;
use landscape::optimize::QuenchSettings;
use landscape::sample::Mala;
use landscape::space::{Euclidean, Space};
use landscape::topography::{
    Evidence, MapSettings, MatchTolerance, Minimum, MinimumId, Run, build_landscape, distinct,
    quench_all,
};

const SHIFT: f64 = 7.0;

fn f(x: f64) -> [f64; 2] {
    let turn = std::f64::consts::TAU;
    [
        -(turn * x).cos() + 0.3 * (1.3 * x).sin() + 0.2 * (0.9 * x + 1.0).sin(),
        turn * (turn * x).sin() + 0.39 * (1.3 * x).cos() + 0.18 * (0.9 * x + 1.0).cos(),
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

struct Wells {
    space: Euclidean,
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
const MARGIN: usize = 12;

/// The exact tree of the wells and of those around them: for each well the well under which it lies, and the height at
/// which the two join. Heights grow upwards.
struct Exact {
    side: usize,
    margin: usize,
    above: Vec<(usize, f64)>,
}

impl Exact {
    /// Floods the passes between neighbouring wells from below, with `margin` wells around those that are mapped.
    fn new(side: usize, margin: usize) -> Self {
        let side = side + 2 * margin;
        let [low, high] = [0.0, 0.5].map(|half| {
            [0.0, SHIFT].map(|shift| {
                let place = |k: usize| k as f64 - margin as f64 + shift + half;
                let values = (0..side).map(|k| f(stationary(place(k)))[0]);
                values.collect::<Vec<f64>>()
            })
        });
        let mut passes = Vec::new();
        for i in 0..side {
            for j in 0..side {
                if i + 1 < side {
                    passes.push((high[0][i] + low[1][j], i * side + j, (i + 1) * side + j));
                }
                if j + 1 < side {
                    passes.push((low[0][i] + high[1][j], i * side + j, i * side + j + 1));
                }
            }
        }
        passes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut exact = Self {
            side,
            margin,
            above: (0..side * side).map(|k| (k, f64::INFINITY)).collect(),
        };
        let mut size = vec![1; side * side];
        for (height, a, b) in passes {
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
    fn minimax(&self, a: usize, b: usize) -> f64 {
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

/// The greatest memory of this process so far, MB.
fn peak_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    number.unwrap_or(f64::NAN) / 1024.0
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let side: usize = std::env::args()
        .nth(1)
        .map_or(Ok(50), |word| word.parse())?;
    let energy = Wells {
        space: Euclidean::new(2),
    };
    let starts: Vec<Vec<f64>> = (0..side * side)
        .map(|k| vec![(k / side) as f64, (k % side) as f64])
        .collect();
    let (started, run) = (Instant::now(), Run::default());
    let sameness = MatchTolerance {
        energy: 1e-7,
        distance: 1e-4,
    };
    let descent = QuenchSettings::default().with_gradient_tolerance(1e-9);
    let found = quench_all(&energy, &starts, &descent, &run)?;
    let (minima, _) = distinct(&energy, &found, &sameness, 1e-6);
    let quenched = started.elapsed().as_secs_f64();
    let settings = MapSettings {
        sameness,
        resamplings: 0,
        neighbours: 4,
        ..MapSettings::for_scales(1.0, 1.0)
    };
    let landscape = build_landscape(&energy, &Mala::new(&energy), minima, &settings, &run)?;
    let mapped = started.elapsed().as_secs_f64();
    let minima: Vec<Minimum> = landscape.network.node_weights().cloned().collect();
    let mut numbers = vec![0; side * side];
    for (number, minimum) in minima.iter().enumerate() {
        for member in &minimum.members {
            numbers[*member] = number;
        }
    }
    let ancestors = landscape::topography::Ancestors::of(&landscape.tree);
    let (mut high, mut low, mut greatest) = (0, 0, 0.0_f64);
    // Ways may lead through wells that are not mapped; ways that do not are known to lead over the passes inside.
    let (inside, around) = (Exact::new(side, 0), Exact::new(side, MARGIN));
    // Neighbours in the grid, whose heights determine all others.
    let right = (0..side * side)
        .filter(|k| k % side + 1 < side)
        .map(|k| (k, k + 1));
    let below = (0..side * (side - 1)).map(|k| (k, k + side));
    let pairs: Vec<(usize, usize)> = right.chain(below).collect();
    for (a, b) in &pairs {
        let ids = [*a, *b].map(|k| MinimumId(numbers[k]));
        let found = ancestors
            .joint(ids[0], ids[1])
            .map_or(f64::INFINITY, |node| landscape.tree.nodes[node.0].energy);
        let [excess, short] = [
            found - inside.minimax(*a, *b),
            around.minimax(*a, *b) - found,
        ];
        greatest = greatest.max(excess).max(short);
        high += usize::from(excess > 1e-6);
        low += usize::from(short > 1e-6);
        if short > 1e-6 {
            eprintln!("{a} {b}: found {found}, exact {}", around.minimax(*a, *b));
        }
    }
    let sure = landscape.network.edge_weights();
    let sure = sure
        .filter(|edge| edge.evidence <= Evidence::Saddle)
        .count();
    println!(
        "| {} | {} | {} | {sure} | {} | {high} | {low} | {greatest:.1e} | {} | {quenched:.1} | {:.1} | {:.0} |",
        side * side,
        minima.len(),
        landscape.connections.len(),
        pairs.len(),
        landscape.evaluations,
        mapped - quenched,
        peak_memory()
    );
    Ok(())
}
