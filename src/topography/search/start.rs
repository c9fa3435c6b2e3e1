//! Where a search starts.

use rand::RngExt;

use super::census::Census;
use super::settings::random_tangent;
use super::task::Searcher;
use crate::optimize::{Quench, quench_traced};
use crate::sample::{Rng, Task, stream};
use crate::space::interpolate;
use crate::space::vector::times;

/// What a search is to start from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Start {
    /// A step from minimum `minimum` along its mode `mode`.
    Mode {
        minimum: usize,
        mode: usize,
        forward: bool,
    },
    /// Somewhere, drawn by the search itself.
    Random,
}

/// Where a search starts, and which way is up.
pub(super) struct Place {
    pub(super) x: Vec<f64>,
    /// Plain tangent of the mode to follow; none for the lowest.
    pub(super) hint: Option<Vec<f64>>,
    /// The descent that led there, where it began at a random point.
    pub(super) drawn: Option<Quench>,
}

impl Searcher<'_> {
    /// Carries out `start` for search number `id`.
    pub(super) fn place(&self, id: u64, start: Start, census: &Census) -> Place {
        let mut rng = stream(self.settings.seed, Task::Saddle, id);
        match start {
            Start::Mode {
                minimum,
                mode,
                forward,
            } => {
                let known = &census.minima[minimum];
                let sign = if forward { 1.0 } else { -1.0 };
                let step: Vec<f64> = known.modes[mode]
                    .iter()
                    .map(|m| sign * self.settings.length * m)
                    .collect();
                Place {
                    x: self.moved(&known.x, &step),
                    hint: Some(step),
                    drawn: None,
                }
            }
            Start::Random if census.minima.is_empty() => self.anywhere(id, &mut rng),
            Start::Random => match rng.random_range(0..8) {
                0 | 1 => self.around_a_minimum(census, &mut rng),
                2 | 3 | 4 => self.around_a_saddle(census, &mut rng),
                5 | 6 => self.between_minima(census, &mut rng),
                _ => self.anywhere(id, &mut rng),
            },
        }
    }

    /// A random step away from a minimum, to follow the mode most like it or the lowest.
    fn around_a_minimum(&self, census: &Census, rng: &mut Rng) -> Place {
        let minimum = &census.minima[rng.random_range(0..census.minima.len())];
        let step = self.kick(census, rng);
        Place {
            x: self.moved(&minimum.x, &step),
            hint: rng.random_bool(0.5).then_some(step),
            drawn: None,
        }
    }

    /// A random step away from a saddle.
    fn around_a_saddle(&self, census: &Census, rng: &mut Rng) -> Place {
        if census.saddles.is_empty() {
            return self.around_a_minimum(census, rng);
        }
        let saddle = &census.saddles[rng.random_range(0..census.saddles.len())];
        let step = self.kick(census, rng);
        Place {
            x: self.moved(&saddle.x, &step),
            hint: None,
            drawn: None,
        }
    }

    /// Part of the way from one minimum to another, off the line by a little.
    fn between_minima(&self, census: &Census, rng: &mut Rng) -> Place {
        let count = census.minima.len();
        let (from, to) = (rng.random_range(0..count), rng.random_range(0..count));
        if from == to {
            return self.around_a_minimum(census, rng);
        }
        let (from, to) = (&census.minima[from].x, &census.minima[to].x);
        let space = self.energy.space();
        let x = interpolate(space, from, to, rng.random_range(0.2..0.8));
        let step = random_tangent(space.tangents(), self.settings.length, rng);
        let mut hint = vec![0.0; space.tangents()];
        space.toward(&x, to, &mut hint);
        Place {
            x: self.moved(&x, &times(&step, &space.step_scales())),
            hint: rng.random_bool(0.5).then_some(hint),
            drawn: None,
        }
    }

    /// Part of the way down from a random point.
    fn anywhere(&self, id: u64, rng: &mut Rng) -> Place {
        let start = (self.draw)(&mut stream(self.settings.seed, Task::Start, id));
        let mut trace = vec![start.clone()];
        let drawn = quench_traced(self.energy, &start, &self.settings.quench, &mut |x, _| {
            trace.push(x.to_vec());
        });
        let stage = rng.random_range(0..trace.len());
        Place {
            x: trace.swap_remove(stage),
            hint: None,
            drawn: Some(drawn),
        }
    }

    /// A random plain tangent about as long as the way from a minimum to a saddle.
    fn kick(&self, census: &Census, rng: &mut Rng) -> Vec<f64> {
        let space = self.energy.space();
        let length = census.reach.unwrap_or(5.0 * self.settings.length) * rng.random_range(0.1..1.5);
        let step = random_tangent(space.tangents(), length, rng);
        times(&step, &space.step_scales())
    }

    fn moved(&self, x: &[f64], step: &[f64]) -> Vec<f64> {
        let mut x = x.to_vec();
        self.energy.space().shift(&mut x, step);
        x
    }
}
