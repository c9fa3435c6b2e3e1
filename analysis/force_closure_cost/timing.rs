//! Stop watch.

use std::hint::black_box;
use std::time::{Duration, Instant};

use landscape::grasp::relaxed::Touch;
use nalgebra::Vector3;

/// Least length of a batch: long against the clock's own cost.
const BATCH: Duration = Duration::from_millis(4);
/// Batches of something slow may end earlier.
const PATIENCE: Duration = Duration::from_secs(20);

/// Contact points.
pub(crate) type Set = Vec<Vector3<f64>>;
/// What is measured on a set: given its points, bare and with room for answers.
pub(crate) type Work<'a> = &'a dyn Fn(&[Vector3<f64>], &mut [Touch]) -> f64;

/// How often something is measured.
#[derive(Clone, Copy)]
pub(crate) struct Clock {
    pub(crate) batches: usize,
}

impl Clock {
    /// Seconds that `work` takes on one of `sets`: the mean of the fastest batch. Whatever else the machine does only adds.
    pub(crate) fn over(self, sets: &[Set], work: Work<'_>) -> f64 {
        let mut touches: Vec<Vec<Touch>> = sets
            .iter()
            .map(|points| points.iter().copied().map(Touch::at).collect())
            .collect();
        let mut round = || {
            for (points, touches) in sets.iter().zip(&mut touches) {
                black_box(work(black_box(points), black_box(touches)));
            }
        };
        let begin = Instant::now();
        round();
        let first = begin.elapsed();
        let rounds = (BATCH.as_secs_f64() / first.as_secs_f64()).ceil().max(1.0);
        let mut least = first.as_secs_f64();
        for _ in 0..self.batches {
            if begin.elapsed() > PATIENCE {
                break;
            }
            let begin = Instant::now();
            let mut done = 0.0;
            while done < rounds {
                round();
                done += 1.0;
            }
            least = least.min(begin.elapsed().as_secs_f64() / rounds);
        }
        least / sets.len() as f64
    }
}
