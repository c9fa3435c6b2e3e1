//! One task of the growth: a climb from a minimum, or a path between two minima.

use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::climb::{Climbing, Summit, climb};
use super::pool::{Crossed, End, Pool};
use crate::energy::{Counted, Energy};
use crate::sample::{Rng, Task, stream};
use crate::space::vector::{scale, times};
use crate::topography::eigen::Scaled;
use crate::topography::path::{Path, PathSettings, descend, leave_ridges, tops};
use crate::topography::scales::random_tangent;
use crate::topography::search::outcome::SearchEnd;
use crate::topography::search::task::PUSH;
use crate::topography::search::{Refused, SearchSettings};

/// Greatest number of steps of a climb along its mode.
const STEPS: usize = 150;
/// Range of the longest step of a climb from a minimum, and that of a climb from the top of a path, in lengths of the
/// surface.
const STRIDES: std::ops::Range<f64> = 0.5..2.0;
const STRIDE: f64 = 1.0;
/// Greatest root-mean-square displacement of the start of a climb along each tangent, in lengths of the surface.
const SHAKE: f64 = 0.1;
/// Step of finite differences, in lengths of the surface.
const DIFFERENCE: f64 = 1e-3;
/// Images of a path for each length of the surface, and their least and greatest number.
const DENSITY: f64 = 0.5;
const SEGMENTS: (f64, f64) = (10.0, 40.0);
/// Greatest number of tops of one path from which climbs begin.
const TOPS: usize = 8;
/// Number of points that are kept of each descent.
const KEPT: usize = 3;

/// What a task does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Plan {
    /// Climbs from a minimum.
    Climb {
        site: usize,
        /// Greatest energy of interest.
        ceiling: f64,
    },
    /// Relaxes the straight line between two minima roughly and climbs from its tops.
    Bridge { ends: [usize; 2], ceiling: f64 },
}

/// What a task found.
#[derive(Serialize, Deserialize, Default)]
pub(super) struct Outcome {
    /// How its climbs ended.
    pub(super) ends: Vec<SearchEnd>,
    /// Known saddles that it met.
    pub(super) known: Vec<usize>,
    /// Saddles that were unknown when it began.
    pub(super) crossed: Vec<Crossed>,
    /// Points that failed their audit.
    pub(super) refused: Vec<Refused>,
    pub(super) evaluations: usize,
}

pub(super) struct Worker<'a> {
    pub(super) settings: &'a SearchSettings,
}

impl Worker<'_> {
    /// Does task number `id`. The outcome depends only on the number, the plan and the pool.
    pub(super) fn work(&self, id: u64, plan: Plan, pool: &Pool<'_>) -> Outcome {
        let counted = Counted::new(pool.energy);
        let mut rng = stream(self.settings.seed, Task::Saddle, id);
        let mut outcome = Outcome::default();
        let search = usize::try_from(id).unwrap_or(usize::MAX);
        match plan {
            Plan::Climb { site, ceiling } => {
                let (x, hint, longest) = self.start(&counted, &pool.sites[site].x, &mut rng);
                self.climb(
                    &counted,
                    (&x, &hint),
                    longest,
                    ceiling,
                    (pool, search),
                    &mut outcome,
                );
            }
            Plan::Bridge { ends, ceiling } => {
                self.bridge(&counted, ends, ceiling, (pool, search), &mut outcome);
            }
        }
        outcome.evaluations = usize::try_from(counted.evaluations()).unwrap_or(usize::MAX);
        outcome
    }

    /// A point near a minimum, a random direction (plain tangent), and the longest step.
    fn start(&self, energy: &dyn Energy, x: &[f64], rng: &mut Rng) -> (Vec<f64>, Vec<f64>, f64) {
        let (space, length) = (energy.space(), self.settings.length);
        let n = space.tangents();
        let shake = SHAKE * length * rng.random_range(0.0..1.0);
        let scales = space.step_scales();
        let mut start = x.to_vec();
        let kick = random_tangent(n, shake * (n as f64).sqrt(), rng);
        space.exp(&mut start, &times(&kick, &scales));
        // Powers of a random direction concentrate it on few coordinates.
        let power: i32 = [1, 3, 5][rng.random_range(0..3)];
        let direction = random_tangent(n, 1.0, rng);
        let direction: Vec<f64> = direction.iter().map(|d| d.powi(power)).collect();
        (
            start,
            times(&direction, &scales),
            length * rng.random_range(STRIDES),
        )
    }

    fn climbing(&self, longest: f64, ceiling: f64) -> Climbing {
        Climbing {
            tolerance: self.settings.quench.gradient_tolerance * 5.0,
            longest,
            difference: DIFFERENCE * self.settings.length,
            steps: STEPS,
            ceiling,
        }
    }

    /// Climbs from a point along a plain tangent, and records what is found.
    fn climb(
        &self,
        energy: &dyn Energy,
        (x, hint): (&[f64], &[f64]),
        longest: f64,
        ceiling: f64,
        pool: (&Pool<'_>, usize),
        outcome: &mut Outcome,
    ) {
        let surface = Scaled::new(energy);
        let end = match climb(
            &surface,
            x,
            &surface.scaled(hint),
            self.climbing(longest, ceiling),
        ) {
            Ok(summit) => self.cross(energy, summit, pool, outcome),
            Err(end) => end,
        };
        outcome.ends.push(end);
    }

    /// Audits a summit and descends on both sides of it.
    fn cross(
        &self,
        energy: &dyn Energy,
        summit: Summit,
        (pool, search): (&Pool<'_>, usize),
        outcome: &mut Outcome,
    ) -> SearchEnd {
        if let Some(known) = pool.gate(&summit.x, summit.energy) {
            outcome.known.push(known);
            return SearchEnd::Arrived;
        }
        let descents = descend(
            energy,
            (&summit.x, summit.energy),
            &summit.mode,
            PUSH * self.settings.length,
            &self.settings.quench,
        );
        let Some(descents) = descents else {
            return SearchEnd::Evaporated;
        };
        let Ok(saddle) = pool.examined(summit.x, 1, search) else {
            return SearchEnd::Index;
        };
        let [first, second] = descents.map(|mut descent| {
            let last = descent.images.len() - 1;
            if pool
                .site(&descent.images[last], descent.energies[last])
                .is_none()
            {
                let (push, difference) = (PUSH * self.settings.length, pool.audit.difference);
                leave_ridges(
                    energy,
                    &mut descent,
                    push,
                    difference,
                    &self.settings.quench,
                );
            }
            descent.thinned(KEPT)
        });
        let mut path: Path = first.reversed();
        let top = path.images.len() - 1;
        path.images.extend(second.images.into_iter().skip(1));
        path.energies.extend(second.energies.into_iter().skip(1));
        let mut ends = Vec::with_capacity(2);
        for place in [0, path.images.len() - 1] {
            let (x, height) = (&path.images[place], path.energies[place]);
            if let Some(known) = pool.site(x, height) {
                ends.push(End::Known(known));
                continue;
            }
            match pool.examined(x.clone(), 0, search) {
                Ok(found) => ends.push(End::New(found)),
                Err(refused) => {
                    outcome.refused.push(refused);
                    return SearchEnd::Evaporated;
                }
            }
        }
        if let Ok(ends) = <[End; 2]>::try_from(ends) {
            outcome.crossed.push(Crossed {
                saddle,
                ends,
                path,
                top,
            });
        }
        SearchEnd::Arrived
    }

    /// Climbs from the tops of the straight line between two minima, relaxed roughly.
    fn bridge(
        &self,
        energy: &dyn Energy,
        ends: [usize; 2],
        ceiling: f64,
        pool: (&Pool<'_>, usize),
        outcome: &mut Outcome,
    ) {
        let space = energy.space();
        let [from, to] = ends.map(|end| &pool.0.sites[end]);
        let mut tangent = vec![0.0; space.tangents()];
        let distance = space.log_quickly(&from.x, &to.x, &mut tangent);
        let length = self.settings.length;
        let settings = PathSettings {
            segments: segments(distance / length),
            coarse_iterations: 100,
            max_step: length,
            ..PathSettings::for_scales(self.settings.energy, length)
        };
        let found = tops(energy, &from.x, &tangent, &settings);
        for top in found.into_iter().take(TOPS) {
            let mut hint = top.tangent;
            scale(&mut hint, 1.0);
            self.climb(
                energy,
                (&top.x, &hint),
                STRIDE * length,
                ceiling,
                pool,
                outcome,
            );
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to a small range"
)]
fn segments(lengths: f64) -> usize {
    (DENSITY * lengths).clamp(SEGMENTS.0, SEGMENTS.1) as usize
}
