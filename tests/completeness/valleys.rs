//! Bent valleys whose walls are up to a million times as stiff as their bottom, with wells that are counted beforehand.

use landscape::energy::Energy;
use landscape::sample::{Rng, Task, standard_normal, stream};
use landscape::space::{Euclidean, Space};
use landscape::topography::{self, Exploration, SearchSettings, explore};
use rand::RngExt;

/// Points of the grid on which wells are counted, and the half of its length.
const GRID: (u32, f64) = (20_000, 40.0);

/// U(a) + ½ Σᵢ kᵢ (bᵢ − fᵢ(a))² in turned coordinates (a, b), with U(a) = ½ c a² − h cos 3a and fᵢ(a) = Aᵢ sin(ωᵢ a + φᵢ).
/// Its stationary points are those of U, at the bottom of the valley.
pub(crate) struct Valley {
    space: Euclidean,
    /// Orthonormal rows.
    turn: Vec<Vec<f64>>,
    /// c and h.
    bottom: [f64; 2],
    /// kᵢ, Aᵢ, ωᵢ and φᵢ.
    walls: Vec<[f64; 4]>,
    /// Units of energy and length.
    units: [f64; 2],
}

impl Valley {
    /// A random valley of 2 to 12 dimensions and a condition number of 10² to 10⁶.
    pub(crate) fn random(id: u64) -> Self {
        let mut rng = stream(7, Task::Surface, id);
        let dimensions = rng.random_range(2..=12);
        let condition = libm::pow(10.0, rng.random_range(2.0..6.0));
        let spring = libm::pow(10.0, rng.random_range(-1.0..0.3));
        let mut valley = Self::new(dimensions, condition, [spring, 1.0], &mut rng);
        valley.units = [-3.0..3.0, -3.0..3.0].map(|range| libm::pow(10.0, rng.random_range(range)));
        valley
    }

    pub(crate) fn new(dimensions: usize, condition: f64, bottom: [f64; 2], rng: &mut Rng) -> Self {
        // The curvature of −cos 3a is 9 at most. One wall has the whole condition number.
        let wall = |k: usize| {
            let part = if k == 0 {
                1.0
            } else {
                rng.random_range(0.0..1.0)
            };
            let stiffness = 9.0 * libm::pow(condition, part);
            let [bend, waves, phase] = [0.2..1.0, 0.5..2.0, 0.0..6.0].map(|r| rng.random_range(r));
            [stiffness, bend, waves, phase]
        };
        let walls = (0..dimensions - 1).map(wall).collect();
        Self {
            space: Euclidean::new(dimensions),
            turn: turn(dimensions, rng),
            bottom,
            walls,
            units: [1.0; 2],
        }
    }

    fn slope(&self, a: f64) -> f64 {
        self.bottom[0] * a + 3.0 * self.bottom[1] * libm::sin(3.0 * a)
    }

    /// Numbers of minima and saddles.
    pub(crate) fn known(&self) -> [usize; 2] {
        let at = |k: u32| GRID.1 * (2.0 * (f64::from(k) + 0.5) / f64::from(GRID.0) - 1.0);
        let rises = |k: u32| self.slope(at(k)) > 0.0;
        let turns = |up: bool| {
            (1..GRID.0)
                .filter(|k| rises(*k) == up && rises(k - 1) != up)
                .count()
        };
        [turns(true), turns(false)]
    }

    pub(crate) fn draw(&self, rng: &mut Rng) -> Vec<f64> {
        let range = -2.0..2.0;
        (0..self.turn.len())
            .map(|_| self.units[1] * rng.random_range(range.clone()))
            .collect()
    }

    pub(crate) fn settings(&self, seed: u64) -> SearchSettings {
        SearchSettings::measured(self, &|rng: &mut Rng| self.draw(rng), seed)
    }

    /// The same valley in these units of energy and length.
    pub(crate) fn with_units(mut self, units: [f64; 2]) -> Self {
        self.units = units;
        self
    }

    pub(crate) fn search(&self, seed: u64) -> Exploration {
        self.search_with(&self.settings(seed))
    }

    pub(crate) fn search_with(&self, settings: &SearchSettings) -> Exploration {
        let draw = |rng: &mut Rng| self.draw(rng);
        explore(self, &draw, settings, &topography::Run::default()).unwrap()
    }
}

/// A random rotation.
fn turn(dimensions: usize, rng: &mut Rng) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = Vec::new();
    while rows.len() < dimensions {
        let mut row: Vec<f64> = (0..dimensions).map(|_| standard_normal(rng)).collect();
        for known in &rows {
            let share: f64 = row.iter().zip(known).map(|(a, b)| a * b).sum();
            row.iter_mut().zip(known).for_each(|(a, b)| *a -= share * b);
        }
        let length = row.iter().map(|a| a * a).sum::<f64>().sqrt();
        for part in &mut row {
            *part /= length;
        }
        rows.push(row);
    }
    rows
}

impl Energy for Valley {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let [unit, length] = self.units;
        let along = |row: &Vec<f64>| row.iter().zip(x).map(|(t, x)| t * x / length).sum::<f64>();
        let turned: Vec<f64> = self.turn.iter().map(along).collect();
        let a = turned[0];
        let [spring, ripple] = self.bottom;
        let mut energy = 0.5 * spring * a * a - ripple * libm::cos(3.0 * a);
        let mut slopes = vec![0.0; turned.len()];
        slopes[0] = self.slope(a);
        for (k, [stiffness, bend, waves, phase]) in self.walls.iter().enumerate() {
            let off = turned[k + 1] - bend * libm::sin(waves * a + phase);
            energy += 0.5 * stiffness * off * off;
            slopes[k + 1] = stiffness * off;
            slopes[0] -= stiffness * off * bend * waves * libm::cos(waves * a + phase);
        }
        gradient.fill(0.0);
        for (slope, row) in slopes.iter().zip(&self.turn) {
            gradient
                .iter_mut()
                .zip(row)
                .for_each(|(g, t)| *g += unit / length * slope * t);
        }
        unit * energy
    }
}
