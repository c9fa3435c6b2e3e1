//! Search for all stationary points: minima, saddles, and an estimate of how many are missing.
//!
//! Random starts give the first minima. Single-ended searches climb from minima, from saddles and from random points to
//! stationary points of index 1. Descents on both sides of those give the minima they join and new starting points. The
//! search ends when it has found nothing new for long, relative to what it has found.

mod census;
mod coverage;
mod flat;
mod funnels;
mod join;
mod landscape;
mod limit;
mod outcome;
mod searcher;
mod settings;
mod start;
mod task;

use std::collections::{BTreeMap, VecDeque};

use census::Census;
#[cfg(feature = "cli")]
pub(crate) use census::mark_branches;
pub use census::{Refused, TransitionState};
pub use coverage::{Coverage, Doubt};
pub use funnels::{
    LowestReport, LowestSettings, LowestTrace, SizeProbe, explore_lowest, probe_size,
};
use join::Joiner;
use limit::Limit;
pub use limit::Limits;
use outcome::Outcome;
pub use outcome::SearchEnd;
use rayon::prelude::*;
use searcher::Searcher;
pub use settings::SearchSettings;
pub use start::in_box;
use start::{Gait, Start};

use super::audit::{Audit, Verdict};
use super::barrier::Connection;
use super::journal::{JournalError, Run};
use super::network::Minimum;
use super::{Phase, Tally};
use crate::energy::{Counted, Energy};
use crate::sample::Rng;

/// Draws a random point of the region of interest.
pub type Draw<'a> = dyn Fn(&mut Rng) -> Vec<f64> + Sync + 'a;

/// The result of a search. All its points passed their audit.
#[derive(Debug, Clone)]
pub struct Exploration {
    /// Distinct minima, lowest first. Members are the numbers of the searches whose random draw quenched into the minimum.
    pub minima: Vec<Minimum>,
    /// The audit of each minimum.
    pub audits: Vec<Audit>,
    /// Distinct saddles, lowest first. A saddle where n > 2 valleys meet is listed n − 1 times, with different ends; the
    /// audits of all but the first say of which one they are duplicates.
    pub saddles: Vec<TransitionState>,
    /// Relaxed paths between minima that no sequence of saddles joins: upper bounds and no transition states.
    pub bounds: Vec<Connection>,
    /// Points that failed their audit.
    pub refused: Vec<Refused>,
    /// Number of searches by the way they ended.
    pub search_ends: BTreeMap<SearchEnd, usize>,
    /// The limits of the searches and what they did; `None` if only the lowest part was searched.
    pub limits: Option<Limits>,
    /// How complete the minima and saddles are.
    pub coverage: Coverage,
    /// Evaluations spent.
    pub evaluations: usize,
    /// Whether the search was stopped before it ended by itself: by the greatest number of searches or by [`Run::enough`].
    pub stopped: bool,
}

impl Exploration {
    /// The saddles, each once, however many valleys meet there.
    pub fn distinct_saddles(&self) -> impl Iterator<Item = &TransitionState> {
        let saddles = self.saddles.iter();
        saddles.filter(|saddle| saddle.audit.verdict != Verdict::Duplicate)
    }

    /// Number of sets of minima that saddles join.
    pub fn components(&self) -> usize {
        let mut sets = petgraph::unionfind::UnionFind::new(self.minima.len());
        let ends = self.saddles.iter().map(|saddle| saddle.ends);
        let joined = ends.filter(|[from, to]| sets.union(from.0, to.0)).count();
        self.minima.len() - joined
    }
}

/// Explores a smooth surface, given only its energy and random points.
///
/// Single-ended searches (eigenvector following) climb along every mode of every minimum in both directions, and then from
/// random places: around minima and saddles and, most often, part of the way down from random points. From each distinct
/// saddle two descents lead to minima; new minima are searched from in turn. Points are distinguished by energy and by
/// distance modulo the symmetry of the space. The search ends when `patience` searches for every point found brought
/// nothing new. Where its limits of steps and evaluations end many searches, and more than arrive at a saddle, they are doubled,
/// up to four times, and what they had ended is tried again. Minima that no saddle joins are then joined by relaxed paths if
/// possible, and the search continues from what those find. Where it finds no saddle, the path is an upper bound
/// ([`Exploration::bounds`]). No expected number of points is used. Rings, troughs and plateaus consist of points that are not
/// isolated; each is represented by the first point found. Two of one energy are one if a walk along level directions joins them,
/// and apart if descents from between their points end on both sides of a ridge. Where these descents end elsewhere, both count
/// as one.
///
/// The result depends on the settings and the seed, not on the number of threads or interruptions. An energy with discrete
/// choices has passes on seams, which this search does not find: see [`build_landscape`](super::build_landscape).
///
/// # Errors
/// If the journal of `run` cannot store a record.
pub fn explore(
    energy: &dyn Energy,
    draw: &Draw<'_>,
    settings: &SearchSettings,
    run: &Run<'_>,
) -> Result<Exploration, JournalError> {
    explore_from(energy, draw, &[], settings, run)
}

/// As [`explore`], beginning with one search from each of the points `known`, such as those of another program.
///
/// # Errors
/// If the journal of `run` cannot store a record.
///
/// # Panics
/// If a point has the wrong length.
pub fn explore_from(
    energy: &dyn Energy,
    draw: &Draw<'_>,
    known: &[Vec<f64>],
    settings: &SearchSettings,
    run: &Run<'_>,
) -> Result<Exploration, JournalError> {
    let counted = Counted::new(energy);
    let mut census = Census::new(settings);
    let mut limit = Limit::new(settings);
    let mut queue: VecDeque<Start> = (0..known.len()).map(Start::Known).collect();
    let (mut queued, mut round) = (0, 0);
    let mut joiner = Joiner::default();
    let planned = loop {
        let limited = limit.settings().clone();
        let searcher = Searcher {
            energy,
            draw,
            known,
            settings: &limited,
        };
        let plan: Vec<Start> = (0..settings.batch.max(1))
            .map(|_| queue.pop_front().unwrap_or(Start::Random))
            .collect();
        let patience = settings.patience.saturating_mul(census.found().max(1));
        let expected = limit.since(&census).saturating_add(patience);
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
        for (start, outcome) in plan.into_iter().zip(outcomes) {
            limit.note(start, census.take(&counted, outcome));
        }
        for (minimum, known) in census.minima.iter().enumerate().skip(queued) {
            queue.extend(along_modes(minimum, known.modes.len().min(settings.modes)));
        }
        queued = census.minima.len();
        if census.searches >= settings.max_searches || run.is_over() {
            break Some(queue.len());
        }
        if limit.rises() {
            queue.extend(limit.rise(&census));
            continue;
        }
        let idle = census.searches - limit.since(&census);
        let patience = settings.patience.saturating_mul(census.found().max(1));
        if queue.is_empty()
            && idle >= patience
            && !joiner.join(&searcher, &mut census, &counted, run)?
        {
            break None;
        }
    };
    let spent = usize::try_from(counted.evaluations()).unwrap_or(usize::MAX);
    Ok(census.finish(energy, spent, planned, limit.counts, joiner.bounds))
}

/// Starts from a minimum along its first modes, in both directions, carefully and boldly.
fn along_modes(minimum: usize, modes: usize) -> impl Iterator<Item = Start> {
    let ways = [Gait::Careful, Gait::Bold]
        .into_iter()
        .flat_map(move |gait| (0..modes).map(move |mode| (gait, mode)));
    ways.flat_map(move |(gait, mode)| {
        [true, false].map(|forward| Start::Mode {
            minimum,
            mode,
            forward,
            gait,
        })
    })
}
