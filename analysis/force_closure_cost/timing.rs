//! Stop watch.

use std::hint::black_box;
use std::time::{Duration, Instant};

use landscape::grasp::relaxed::Touch;
use nalgebra::Vector3;

/// Least length of a batch: long against the clock's own cost.
const BATCH: Duration = Duration::from_millis(4);
/// Turns with something slow may end earlier.
const PATIENCE: Duration = Duration::from_secs(8);

/// Contact points.
pub(crate) type Set = Vec<Vector3<f64>>;
/// What is measured on a set: given its points, bare and with room for answers.
pub(crate) type Work<'a> = &'a dyn Fn(&[Vector3<f64>], &mut [Touch]) -> f64;

/// How often something is measured.
#[derive(Clone, Copy)]
pub(crate) struct Clock {
    pub(crate) turns: usize,
}

/// What several works cost, timed one after the other again and again, so that each turn finds the machine in one state.
pub(crate) struct Turns {
    /// Seconds on one set, of each work in each turn.
    seconds: Vec<Vec<f64>>,
}

/// Part of a whole: quartiles over the turns of the ratio of what both took in the same turn.
#[derive(Clone, Copy)]
pub(crate) struct Share {
    pub(crate) lower: f64,
    pub(crate) median: f64,
    pub(crate) upper: f64,
}

impl Clock {
    /// Times `works` on `sets` in turns; every other turn goes backwards, so that drift favours none.
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
        // The first round is a warm-up and tells how many make a batch.
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
    /// Seconds that a work takes on one set: the fastest turn. Whatever else the machine does only adds.
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
