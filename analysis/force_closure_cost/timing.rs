//! Measurement of times.

use std::hint::black_box;
use std::time::{Duration, Instant};

use nalgebra::Vector3;

use crate::relaxed::Touch;

/// Least duration of a batch, long compared with the cost of the clock.
const BATCH: Duration = Duration::from_millis(4);
/// After this time, turns with slow works end early.
const PATIENCE: Duration = Duration::from_secs(8);

/// Contact points.
pub(crate) type Set = Vec<Vector3<f64>>;
/// Work that is measured on a set. Its arguments are the points, alone and with room for answers.
pub(crate) type Work<'a> = &'a dyn Fn(&[Vector3<f64>], &mut [Touch]) -> f64;

/// Amount of repetition.
#[derive(Clone, Copy)]
pub(crate) struct Clock {
    pub(crate) turns: usize,
}

/// Costs of several works. They are timed alternately, so that in each turn the machine is in the same state for all.
pub(crate) struct Turns {
    /// Seconds on one set, for each work and each turn.
    seconds: Vec<Vec<f64>>,
}

/// Share of a whole: quartiles over the turns of the ratio of both times in the same turn.
#[derive(Clone, Copy)]
pub(crate) struct Share {
    pub(crate) lower: f64,
    pub(crate) median: f64,
    pub(crate) upper: f64,
}

impl Clock {
    /// Times `works` on `sets` in turns. Every other turn is in reverse order, so that drift favours none.
    pub(crate) fn over(self, sets: &[Set], works: &[Work<'_>]) -> Turns {
        let mut touches: Vec<Vec<Touch>> = sets
            .iter()
            .map(|points| points.iter().copied().map(Touch::at).collect())
            .collect();
        let mut seconds_of = |work: Work<'_>, rounds: usize| {
            let begin = Instant::now();
            for _ in 0..rounds {
                for (points, touches) in sets.iter().zip(&mut touches) {
                    black_box(work(black_box(points), black_box(touches)));
                }
            }
            begin.elapsed().as_secs_f64() / rounds as f64
        };
        let begin = Instant::now();
        // The first round is a warm-up and determines the size of a batch.
        let rounds: Vec<usize> = works
            .iter()
            .map(|work| {
                let first = seconds_of(*work, 1);
                (1..1 << 20)
                    .find(|&rounds| rounds as f64 * first >= BATCH.as_secs_f64())
                    .unwrap_or(1 << 20)
            })
            .collect();
        let mut seconds = vec![Vec::new(); works.len()];
        for turn in 0..self.turns {
            if turn > 0 && begin.elapsed() > PATIENCE {
                break;
            }
            for place in 0..works.len() {
                let index = if turn % 2 == 0 {
                    place
                } else {
                    works.len() - 1 - place
                };
                let time = seconds_of(works[index], rounds[index]);
                seconds[index].push(time / sets.len() as f64);
            }
        }
        Turns { seconds }
    }
}

impl Turns {
    /// Seconds of a work on one set in the fastest turn, because other load on the machine only adds time.
    pub(crate) fn least(&self, work: usize) -> f64 {
        self.seconds[work]
            .iter()
            .fold(f64::INFINITY, |least, &t| least.min(t))
    }

    /// Share of the work `part` in the work `whole`.
    pub(crate) fn share(&self, part: usize, whole: usize) -> Share {
        let mut ratios: Vec<f64> = self.seconds[part]
            .iter()
            .zip(&self.seconds[whole])
            .map(|(part, whole)| part / whole)
            .collect();
        ratios.sort_by(f64::total_cmp);
        let quartile = |k: usize| {
            let last = ratios.len() - 1;
            let (below, above) = (k * last / 4, (k * last).div_ceil(4));
            let fraction = (k * last % 4) as f64 / 4.0;
            ratios[below] + (ratios[above] - ratios[below]) * fraction
        };
        Share {
            lower: quartile(1),
            median: quartile(2),
            upper: quartile(3),
        }
    }
}
