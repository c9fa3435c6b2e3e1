//! Search for all stationary points: minima, saddles, and an estimate of how many are missing.
//!
//! Random starts give the first minima. Single-ended searches climb from minima, from saddles and from random points to
//! stationary points of index 1. Descents on both sides of those give the minima they join and new starting points. The
//! search ends when it has found nothing new for long, relative to what it has found.

mod census;
mod coverage;
mod flat;
#[cfg(feature = "chemistry")]
mod funnels;
mod further;
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
#[cfg(feature = "chemistry")]
pub use funnels::{
    LowestReport, LowestSettings, LowestTrace, SizeProbe, explore_lowest, probe_size,
};
pub use further::Further;
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
use super::build::PairSearch;
use super::journal::{JournalError, Run};
use super::network::Minimum;
use super::{Phase, Tally};
use crate::energy::{Counted, Energy};
use crate::sample::Rng;

/// Searches between two updates of the census. It affects the result, so it must not depend on the number of threads.
const BATCH: usize = 32;

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
    /// The further searches between two of the minima, if more was wanted there.
    pub further: Option<Further>,
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
/// The result depends on the settings and the seed, not on the number of threads or interruptions.
///
/// # Errors
/// If the journal of `run` cannot store a record.
pub fn explore(
    energy: &dyn Energy,
    draw: &Draw<'_>,
    settings: &SearchSettings,
    run: &Run<'_>,
) -> Result<Exploration, JournalError> {
    explore_from(energy, draw, &[], None, settings, run)
}

/// As [`explore`], beginning with one search from each of the points `known`, such as those of another program.
///
/// If more is wanted between two minima, further searches by attraction–diffusion between them follow when the others have
/// ended ([`Exploration::further`]), and the search goes on from what is new. The numbers of the pair are those of the minima
/// that a search without it returns. If it does not return so many, nothing further is searched.
///
/// # Errors
/// If the journal of `run` cannot store a record.
///
/// # Panics
/// If a point has the wrong length, or both minima of the pair are the same.
pub fn explore_from(
    energy: &dyn Energy,
    draw: &Draw<'_>,
    known: &[Vec<f64>],
    pair: Option<PairSearch>,
    settings: &SearchSettings,
    run: &Run<'_>,
) -> Result<Exploration, JournalError> {
    let mut explorer = Explorer {
        energy,
        counted: Counted::new(energy),
        draw,
        known,
        settings,
        census: Census::new(settings),
        limit: Limit::new(settings),
        queue: (0..known.len()).map(Start::Known).collect(),
        queued: 0,
        round: 0,
        joiner: Joiner::default(),
        stopped: false,
    };
    explorer.search(run)?;
    let further = match pair {
        Some(pair) => explorer.search_further(pair, run)?,
        None => None,
    };
    Ok(explorer.finish(further))
}

/// A search in progress.
struct Explorer<'a> {
    energy: &'a dyn Energy,
    counted: Counted<'a>,
    draw: &'a Draw<'a>,
    known: &'a [Vec<f64>],
    settings: &'a SearchSettings,
    census: Census,
    limit: Limit,
    /// Planned searches.
    queue: VecDeque<Start>,
    /// Number of minima from which searches have been planned.
    queued: usize,
    round: usize,
    joiner: Joiner,
    /// Whether it was stopped before it ended by itself.
    stopped: bool,
}

impl Explorer<'_> {
    /// Searches until nothing new has been found for long, or until it is stopped.
    fn search(&mut self, run: &Run<'_>) -> Result<(), JournalError> {
        loop {
            let limited = self.limit.settings().clone();
            let searcher = Searcher {
                energy: self.energy,
                draw: self.draw,
                known: self.known,
                settings: &limited,
            };
            self.search_batch(&searcher, run)?;
            if self.census.searches >= self.settings.max_searches || run.is_over() {
                self.stopped = true;
                return Ok(());
            }
            if self.limit.rises() {
                self.queue.extend(self.limit.rise(&self.census));
                continue;
            }
            let idle = self.census.searches - self.limit.since(&self.census);
            if self.queue.is_empty()
                && idle >= self.patience()
                && !(self.joiner).join(&searcher, &mut self.census, &self.counted, run)?
            {
                return Ok(());
            }
        }
    }

    /// Number of searches without a new point after which the search ends.
    fn patience(&self) -> usize {
        let found = self.census.found().max(1);
        self.settings.patience.saturating_mul(found)
    }

    fn search_batch(&mut self, searcher: &Searcher<'_>, run: &Run<'_>) -> Result<(), JournalError> {
        let plan: Vec<Start> = (0..BATCH)
            .map(|_| self.queue.pop_front().unwrap_or(Start::Random))
            .collect();
        let census = &self.census;
        let expected = self.limit.since(census).saturating_add(self.patience());
        let tally = Tally::after(
            Phase::Search,
            census.searches,
            expected.saturating_add(self.queue.len()),
            run.observer,
        );
        let outcomes = run.remember(&format!("search/{}", self.round), || {
            let first = census.searches as u64;
            let search = |(k, start): (usize, &Start)| {
                let outcome = searcher.run(first + k as u64, *start, census);
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
        self.round += 1;
        for (start, outcome) in plan.into_iter().zip(outcomes) {
            let end = self.census.take(&self.counted, outcome);
            self.limit.note(start, end);
        }
        self.plan();
        Ok(())
    }

    /// Plans searches from the minima that are new.
    fn plan(&mut self) {
        for (minimum, known) in self.census.minima.iter().enumerate().skip(self.queued) {
            let modes = known.modes.len().min(self.settings.modes);
            self.queue.extend(along_modes(minimum, modes));
        }
        self.queued = self.census.minima.len();
    }

    /// The result so far.
    fn finish(self, further: Option<Further>) -> Exploration {
        let spent = usize::try_from(self.counted.evaluations()).unwrap_or(usize::MAX);
        let planned = self.stopped.then_some(self.queue.len());
        Exploration {
            further,
            ..(self.census).finish(
                self.energy,
                spent,
                planned,
                self.limit.counts,
                self.joiner.bounds,
            )
        }
    }
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
