//! The starting points of searches.

use rand::RngExt;

use super::census::Census;
use super::searcher::Searcher;
use crate::optimize::{Quench, quench_traced};
use crate::sample::{Rng, Task, stream};
use crate::space::vector::{scale, times};
use crate::topography::scales::random_tangent;

/// Range of log₂ of the longest step of a search from a random place, in units of the length of the surface.
const BOLDNESS: std::ops::Range<f64> = -2.0..3.0;

/// Range of the steps from a minimum along one of its modes, in typical distances from a minimum to a saddle.
const FAR: std::ops::Range<f64> = -2.0..2.0;

/// Draws points uniformly from a box of coordinates.
///
/// # Panics
/// The returned function panics if a lower bound is not below its upper bound.
pub fn in_box<'a>(low: &'a [f64], high: &'a [f64]) -> impl Fn(&mut Rng) -> Vec<f64> + Sync + 'a {
    move |rng: &mut Rng| {
        let sides = low.iter().zip(high);
        sides
            .map(|(low, high)| rng.random_range(*low..*high))
            .collect()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Start {
    /// A step from a minimum along one of its modes.
    Mode {
        minimum: usize,
        mode: usize,
        forward: bool,
        gait: Gait,
    },
    /// A place on the descent from one of the known points.
    Known(usize),
    /// A random place, drawn by the search itself.
    Random,
}

/// Step length of a search. Careful searches stay with the mode they follow; bold ones leave it and end sooner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Gait {
    /// A fifth of the length of the surface.
    Careful,
    /// Several times the length of the surface.
    Bold,
}

impl Gait {
    /// Longest step, in units of the length of the surface.
    fn stride(self) -> f64 {
        match self {
            Self::Careful => 0.2,
            Self::Bold => 4.0,
        }
    }
}

pub(super) struct Place {
    pub(super) x: Vec<f64>,
    /// Longest step of the search.
    pub(super) longest: f64,
    /// Plain tangent of the mode to follow; `None` for the lowest mode.
    pub(super) hint: Option<Vec<f64>>,
    /// The descent that led there, if it began at a random point.
    pub(super) drawn: Option<Quench>,
    /// The known saddle beside which it lies, if it was chosen there.
    pub(super) beside: Option<usize>,
}

impl Place {
    fn new(x: Vec<f64>, hint: Option<Vec<f64>>) -> Self {
        Self {
            x,
            longest: 0.0,
            hint,
            drawn: None,
            beside: None,
        }
    }
}

impl Searcher<'_> {
    /// Finds the starting point of search number `id`.
    pub(super) fn place(&self, id: u64, start: Start, census: &Census) -> Place {
        let mut rng = stream(self.settings.seed, Task::Saddle, id);
        match start {
            Start::Mode {
                minimum,
                mode,
                forward,
                gait,
            } => {
                let length = gait.stride() * self.settings.length;
                let sign = if forward { 1.0 } else { -1.0 };
                // The first step is short even for bold searches. Longer ones would all leave the well on the same side.
                let first = sign * length.min(2.0 * self.settings.length);
                let known = &census.minima[minimum];
                let step: Vec<f64> = known.modes[mode].iter().map(|m| first * m).collect();
                Place {
                    longest: length,
                    ..Place::new(self.moved(&known.x, &step), Some(step))
                }
            }
            Start::Known(number) => Place {
                longest: self.settings.length * libm::exp2(rng.random_range(BOLDNESS)),
                ..self.below(&self.known[number], &mut rng)
            },
            Start::Random => {
                let mut place = self.somewhere(id, census, &mut rng);
                place.longest = self.settings.length * libm::exp2(rng.random_range(BOLDNESS));
                place
            }
        }
    }

    fn somewhere(&self, id: u64, census: &Census, rng: &mut Rng) -> Place {
        if census.minima.is_empty() {
            return self.anywhere(id, rng);
        }
        let minimum = &census.minima[rng.random_range(0..census.minima.len())];
        // Each kind of start meets some saddles that the others meet ten times less often. Of the rarest ones, steps along
        // modes meet most for each evaluation, and random points, with their descents, cost three times as much.
        match rng.random_range(0..16) {
            0..=1 => self.anywhere(id, rng),
            kind @ 2..=11 if !minimum.modes.is_empty() => {
                let mut step = minimum.modes[rng.random_range(0..minimum.modes.len())].clone();
                scale(&mut step, self.reach(census) * rng.random_range(FAR));
                Place::new(self.moved(&minimum.x, &step), (kind < 10).then_some(step))
            }
            _ if census.saddles.is_empty() => {
                Place::new(self.moved(&minimum.x, &self.kick(census, rng)), None)
            }
            _ => {
                let saddle = rng.random_range(0..census.saddles.len());
                let x = self.moved(&census.saddles[saddle].x, &self.kick(census, rng));
                Place {
                    beside: Some(saddle),
                    ..Place::new(x, None)
                }
            }
        }
    }

    /// A point in the first half of the steps of a descent from a random point.
    fn anywhere(&self, id: u64, rng: &mut Rng) -> Place {
        let start = (self.draw)(&mut stream(self.settings.seed, Task::Start, id));
        self.below(&start, rng)
    }

    /// A point in the first half of the steps of a descent from `start`.
    fn below(&self, start: &[f64], rng: &mut Rng) -> Place {
        let mut trace = vec![start.to_vec()];
        let drawn = quench_traced(self.energy, start, &self.settings.quench, &mut |x, _| {
            trace.push(x.to_vec());
        });
        let stage = rng.random_range(0..trace.len().div_ceil(2));
        Place {
            drawn: Some(drawn),
            ..Place::new(trace.swap_remove(stage), None)
        }
    }

    /// Typical distance from a minimum to a saddle.
    fn reach(&self, census: &Census) -> f64 {
        census.reach.unwrap_or(5.0 * self.settings.length)
    }

    /// A random tangent of up to 1.5 times that distance.
    fn kick(&self, census: &Census, rng: &mut Rng) -> Vec<f64> {
        self.random_tangent(self.reach(census) * rng.random_range(0.1..1.5), rng)
    }

    fn random_tangent(&self, length: f64, rng: &mut Rng) -> Vec<f64> {
        let space = self.energy.space();
        times(
            &random_tangent(space.tangents(), length, rng),
            &space.step_scales(),
        )
    }

    fn moved(&self, x: &[f64], step: &[f64]) -> Vec<f64> {
        let mut x = x.to_vec();
        self.energy.space().exp(&mut x, step);
        x
    }
}
