//! Every stationary point that can be found: minima, the saddles between them, and how much may still be missing.
//!
//! Random starts give the first minima; single-ended searches climb from minima, from saddles and from anywhere to
//! stationary points of index 1; descents on both sides of those give the minima they join, and more
//! places to climb from. The search ends when it has found nothing new for long, measured by what it has found.

mod census;
mod coverage;
mod join;
mod landscape;
mod settings;
mod start;
mod task;

use std::collections::{BTreeMap, VecDeque};

use census::Census;
pub use census::{Refused, TransitionState};
pub use coverage::{Coverage, Doubt};
use join::Joiner;
use rayon::prelude::*;
pub use settings::SearchSettings;
pub use start::in_box;
use start::{Gait, Start};
pub use task::SearchEnd;
use task::{Outcome, Searcher};

use super::audit::Audit;
use super::journal::{JournalError, Run};
use super::network::Minimum;
use super::{Phase, Tally};
use crate::energy::{Counted, Energy};
use crate::sample::Rng;

/// Draws a random point of the region of interest.
pub type Draw<'a> = dyn Fn(&mut Rng) -> Vec<f64> + Sync + 'a;

/// What a search found. Everything in it passed its audit.
#[derive(Debug, Clone)]
pub struct Exploration {
    /// Distinct minima, lowest first; members are the numbers of the searches whose random draw quenched into it.
    pub minima: Vec<Minimum>,
    /// The audit of each minimum.
    pub audits: Vec<Audit>,
    /// Distinct saddles, lowest first. One in which n > 2 valleys meet is listed n − 1 times: so many ordinary saddles would
    /// join their minima.
    pub saddles: Vec<TransitionState>,
    /// What was taken for a stationary point and did not pass its audit.
    pub refused: Vec<Refused>,
    /// How the searches ended.
    pub fates: BTreeMap<SearchEnd, usize>,
    /// How complete the minima and saddles are.
    pub coverage: Coverage,
    /// Evaluations spent.
    pub evaluations: usize,
}

/// Explores a smooth surface from nothing but its energy and random points.
///
/// Single-ended searches (eigenvector following) climb along every mode of every minimum, both ways, and then from random
/// places: around minima and saddles, and, most often, part of the way down from random points. Each distinct saddle gets
/// descents on both sides; their ends, if new, are searched from in turn. Points are distinct by energy and distance, so
/// modulo the symmetry of the space. The search ends when `patience` searches for every point found brought nothing new;
/// minima that no saddle joins are then joined by relaxed paths, if they can be, and the search goes on from what those
/// find. No expected number enters anywhere. Points of rings, troughs and plateaus, which are not isolated, stand for one
/// point: the first that is found of each energy.
///
/// The result depends on the settings and the seed, not on the number of threads or interruptions. An energy with discrete
/// choices has passes on seams, which this does not look for: see
/// [`build_landscape`](super::build_landscape).
///
/// # Errors
/// If the journal of `run` does not take a record.
pub fn explore(
    energy: &dyn Energy,
    draw: &Draw<'_>,
    settings: &SearchSettings,
    run: &Run<'_>,
) -> Result<Exploration, JournalError> {
    let counted = Counted::new(energy);
    let searcher = Searcher {
        energy,
        draw,
        settings,
    };
    let mut census = Census::new(settings);
    let mut queue = VecDeque::new();
    let (mut queued, mut round) = (0, 0);
    let mut joiner = Joiner::default();
    let stopped = loop {
        let plan: Vec<Start> = (0..settings.batch.max(1))
            .map(|_| queue.pop_front().unwrap_or(Start::Random))
            .collect();
        let patience = settings.patience.saturating_mul(census.found().max(1));
        let expected = census.last_new.saturating_add(patience);
        let tally = Tally::after(
            Phase::Search,
            census.searches,
            expected.saturating_add(queue.len()),
            run.observer,
        );
        let outcomes = run.remember(&format!("search/{round}"), || {
            let first = census.searches as u64;
            let search = |(k, start): (usize, &Start)| {
                let outcome = searcher.run(first + k as u64, *start, &census);
                tally.tick();
                outcome
            };
            let outcomes: Vec<Outcome> = plan
                .par_iter()
                .with_max_len(1)
                .enumerate()
                .map(search)
                .collect();
            outcomes
        })?;
        round += 1;
        for outcome in outcomes {
            census.take(&counted, outcome);
        }
        for (minimum, known) in census.minima.iter().enumerate().skip(queued) {
            for gait in [Gait::Careful, Gait::Bold] {
                for mode in 0..known.modes.len().min(settings.modes) {
                    queue.extend([true, false].map(|forward| Start::Mode {
                        minimum,
                        mode,
                        forward,
                        gait,
                    }));
                }
            }
        }
        queued = census.minima.len();
        if census.searches >= settings.max_searches {
            break true;
        }
        let idle = census.searches - census.last_new;
        let patience = settings.patience.saturating_mul(census.found().max(1));
        if queue.is_empty() && idle >= patience {
            if !joiner.join(&searcher, &mut census, &counted, run)? {
                break false;
            }
        }
    };
    let spent = usize::try_from(counted.evaluations()).unwrap_or(usize::MAX);
    Ok(census.finish(energy, spent, stopped))
}
