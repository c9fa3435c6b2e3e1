//! Surfaces whose minima and saddles are counted by other means than the tested search.

use crate::waves::Waves;
use landscape::energy::model::named;
use landscape::energy::{Energy, FunctionOn};
use landscape::optimize::{QuenchSettings, quench};
use landscape::sample::{Task, stream};
use landscape::space::{Euclidean, Space};
use landscape::topography::{
    self, Exploration, MatchTolerance, SearchSettings, distinct, explore, in_box,
};

/// The deepest minimum of [`Counted::needle`], nearly.
pub(crate) const NEEDLE: [f64; 2] = [-0.9, -0.2];

/// A surface, the box of start points, and its numbers of minima and saddles.
pub(crate) struct Counted {
    pub(crate) energy: Box<dyn Energy + Send>,
    low: Vec<f64>,
    high: Vec<f64>,
    known: [usize; 2],
}

/// Result of a search.
pub(crate) struct Run {
    pub(crate) found: Exploration,
    pub(crate) complete: bool,
    /// Number of missed saddles.
    pub(crate) missed: usize,
}

impl Counted {
    /// A named model with known numbers of minima and saddles.
    pub(crate) fn named(words: &str, known: [usize; 2]) -> Self {
        let surface = named(&words.split(' ').collect::<Vec<_>>()).expect("it is a model");
        Self {
            energy: surface.energy,
            low: surface.low,
            high: surface.high,
            known,
        }
    }

    /// Random waves of two angles. On a torus there are as many saddles as minima and maxima together (Morse). Minima and
    /// maxima are counted by descents from a grid on the surface and on the inverted surface.
    pub(crate) fn random(id: u64) -> Self {
        let modes = if id.is_multiple_of(2) { 2 } else { 3 };
        let waves = Waves::random(2, modes, 16, &mut stream(2, Task::Surface, id));
        let [minima, maxima] = [1.0, -1.0].map(|sign| bottoms(&Signed(&waves, sign)));
        let half = std::f64::consts::PI;
        Self {
            energy: Box::new(waves),
            low: vec![-half; 2],
            high: vec![half; 2],
            known: [minima, minima + maxima],
        }
    }

    /// The six-hump camel with a seventh minimum, the deepest, which is a narrow well on one of its slopes.
    pub(crate) fn needle() -> Self {
        let camel = FunctionOn::new(Euclidean::new(2), |p: &[f64], slopes: &mut [f64]| {
            let (x, y) = (p[0], p[1]);
            let (dx, dy) = (x - NEEDLE[0], y - NEEDLE[1]);
            let square = 0.03 * 0.03;
            let well = 3.0 * libm::exp(-0.5 * (dx * dx + dy * dy) / square);
            slopes[0] = 8.0 * x - 8.4 * x.powi(3) + 2.0 * x.powi(5) + y + well * dx / square;
            slopes[1] = x - 8.0 * y + 16.0 * y.powi(3) + well * dy / square;
            let hump = (4.0 - 2.1 * x * x + x.powi(4) / 3.0) * x * x;
            hump + x * y + (4.0 * y * y - 4.0) * y * y - well
        });
        Self {
            energy: Box::new(camel),
            low: vec![-2.0; 2],
            high: vec![2.0; 2],
            known: [7, 8],
        }
    }

    /// Searches it as `landscape surface` does.
    pub(crate) fn search(&self, seed: u64) -> Run {
        let draw = in_box(&self.low, &self.high);
        let settings = SearchSettings::measured(&*self.energy, &draw, seed);
        let found = explore(&*self.energy, &draw, &settings, &topography::Run::default())
            .expect("nothing is kept, so nothing can fail");
        let complete = [found.minima.len(), found.saddles.len()] == self.known;
        let missed = self.known[1].saturating_sub(found.saddles.len());
        Run {
            found,
            complete,
            missed,
        }
    }
}

/// A surface or its inverse.
struct Signed<'a>(&'a Waves, f64);

impl Energy for Signed<'_> {
    fn space(&self) -> &dyn Space {
        self.0.space()
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let energy = self.0.evaluate(x, gradient);
        for slope in gradient.iter_mut() {
            *slope *= self.1;
        }
        self.1 * energy
    }
}

/// Points of the grid along each angle.
const GRID: u32 = 40;

/// Number of minima below a grid.
fn bottoms(energy: &dyn Energy) -> usize {
    let settings = QuenchSettings::default().with_gradient_tolerance(1e-9);
    let place = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(GRID);
    let ends: Vec<_> = (0..GRID * GRID)
        .map(|k| quench(energy, &[place(k / GRID), place(k % GRID)], &settings))
        .collect();
    distinct(energy, &ends, &MatchTolerance::default(), 1e-6)
        .0
        .len()
}
