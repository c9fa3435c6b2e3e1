//! Surfaces whose minima and saddles are counted by other means than the tested search.

use crate::waves::Waves;
use landscape::energy::Energy;
use landscape::energy::model::named;
use landscape::optimize::{QuenchSettings, quench};
use landscape::sample::{Task, stream};
use landscape::space::Space;
use landscape::topography::{
    self, Exploration, MatchTolerance, SearchSettings, distinct, explore, in_box,
};

/// A surface, the box of start points, and its numbers of minima and saddles.
pub(crate) struct Counted {
    energy: Box<dyn Energy + Send>,
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
