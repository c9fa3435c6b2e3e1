//! Search for the lowest minima of a landscape that is too large to enumerate, and for the lowest ways between them.
//!
//! Parallel tempering between minima finds the lowest ones ([`hop`]). Their network then grows: climbs from minima
//! ([`climb`]) and paths between pairs ([`task`]) bring new minima and saddles. Shortest paths over estimated costs choose the
//! pairs ([`choose`]). Once the lowest minima are joined, the effort goes to the deepest merges of their tree.

mod choose;
mod climb;
mod hop;
mod pool;
mod probe;
mod task;

use std::collections::{BTreeMap, BTreeSet};

use choose::{Fork, Roads, forks, sides};
use hop::{Hopping, Leg, Met, Team};
use pool::{Found, Pool};
pub use probe::{SizeProbe, probe_size};
use rand::RngExt;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use task::{Outcome, Plan, Worker};

use super::coverage::{Counts, Coverage, Doubt};
use super::{Draw, Exploration, Refused, SearchEnd, SearchSettings, TransitionState};
use crate::energy::{Counted, Energy};
use crate::optimize::quench;
use crate::sample::{Task, stream};
use crate::topography::journal::{JournalError, Run};
use crate::topography::network::{Minimum, MinimumId};
use crate::topography::{Phase, Tally};

/// Teams of walkers that hop at the same time.
const TEAMS: usize = 4;
/// Share of the time after which hopping ends: the rest is for ways between the minima.
const HOPPING: f64 = 0.5;
/// Tolerance of the gradient of a hop, relative to that of other descents, and of its energy, relative to the tolerance
/// within which two minima are the same.
const SLOPPY: (f64, f64) = (1e4, 100.0);
/// Greatest number of hops of all runs. The report states how many runs ended at the lowest minimum.
const MOST_HOPS: usize = 2_000_000;
/// Greatest number of evaluations of a hop.
const HOP: usize = 1000;
/// First root-mean-square displacement of a hop along each tangent, in lengths of the surface.
const STEP: f64 = 1.0;

/// How many more climbs each discovery from a minimum is worth to it.
const PROMISE: usize = 3;
/// Share of the paths among the tasks of a round: one in this number while minima are apart, and afterwards.
const PATHS: [usize; 2] = [4, 16];
/// Relative change of the sum of all depths below which the tree is the same.
const SAME: f64 = 0.01;
/// Tasks of the growth between two updates. It affects the result, so it must not depend on the number of threads.
const BATCH: usize = 32;
/// The growth ends when the tree has not changed for this share of all rounds: it has then withstood as many as made it.
const SETTLED: f64 = 0.5;
/// Least number of rounds of the growth, so that a lucky first tree does not end it.
const LEAST_ROUNDS: usize = 100;

/// Settings of [`explore_lowest`], beside those of [`SearchSettings`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LowestSettings {
    /// Number of the lowest minima whose tree is sought.
    pub minima: usize,
    /// Hopping ends when this many independent runs have ended at the same lowest minimum.
    pub finds: usize,
    /// A run of hops ends when (hops since its lowest minimum) reaches this number for each tangent, and as many as it took
    /// to find that minimum.
    pub patience: usize,
}

impl Default for LowestSettings {
    fn default() -> Self {
        Self {
            minima: 150,
            finds: 4,
            patience: 60,
        }
    }
}

/// How [`explore_lowest`] went.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LowestReport {
    /// Number of the lowest minima whose tree was sought.
    pub sought: usize,
    /// Hops of all runs.
    pub hops: usize,
    /// Independent runs of hops that ended by themselves.
    pub runs: usize,
    /// Those of them that ended at the lowest minimum.
    pub finds: usize,
    /// Rounds of the growth.
    pub rounds: usize,
    /// The last round that changed the tree.
    pub last_change: usize,
    /// Whether the time for hops was over before they ended by themselves.
    #[serde(default)]
    pub hopping_stopped: bool,
    /// Whether the search was stopped before it ended by itself.
    pub stopped: bool,
    /// The state after some of the rounds.
    pub trace: Vec<LowestTrace>,
}

/// State of the growth after a round.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LowestTrace {
    /// Number of the round.
    pub round: usize,
    /// Evaluations so far.
    pub evaluations: usize,
    /// Minima so far.
    pub minima: usize,
    /// Saddles so far.
    pub saddles: usize,
    /// Components of the lowest minima.
    pub components: usize,
    /// Sum of the depths of all merges of the tree of the lowest minima.
    pub depths: f64,
    /// Height of the deepest merge, and its depth.
    pub deepest: [f64; 2],
    /// Numbers of minima on both sides of the deepest merge that are joined below it.
    pub sides: [usize; 2],
}

/// Searches for the lowest minima of a smooth surface and for the lowest ways between them.
///
/// Independent runs of basin hopping at several temperatures end when they have found nothing lower for long, and the
/// hopping ends when several runs have ended at the same minimum. The lowest minima met are then joined. The growth ends when
/// the tree of the lowest minima has long been the same. No expected number or energy is used.
///
/// The points `known`, such as those of another program, count among the minima met.
///
/// The result is a sample: it says nothing about how many minima and saddles there are, and barriers are upper bounds. It
/// depends on the settings and the seed, not on the number of threads or interruptions.
///
/// # Errors
/// If the journal of `run` cannot store a record.
///
/// # Panics
/// If a known point has the wrong length.
pub fn explore_lowest(
    energy: &dyn Energy,
    draw: &Draw<'_>,
    known: &[Vec<f64>],
    settings: &SearchSettings,
    lowest: &LowestSettings,
    run: &Run<'_>,
) -> Result<(Exploration, LowestReport), JournalError> {
    let mut growth = Growth {
        settings,
        lowest,
        run,
        pool: Pool::new(energy, settings.audit(), settings.sameness),
        report: LowestReport {
            sought: lowest.minima,
            ..LowestReport::default()
        },
        refused: Vec::new(),
        ends: BTreeMap::new(),
        evaluations: 0,
        tried: BTreeSet::new(),
        tasks: 0,
        last_new: 0,
    };
    let seeds = growth.hop(draw, known)?;
    growth.plant(&seeds)?;
    growth.grow()?;
    Ok(growth.finish())
}

struct Growth<'a> {
    settings: &'a SearchSettings,
    lowest: &'a LowestSettings,
    run: &'a Run<'a>,
    pool: Pool<'a>,
    report: LowestReport,
    refused: Vec<Refused>,
    ends: BTreeMap<SearchEnd, usize>,
    evaluations: usize,
    /// Pairs of minima between which a path was relaxed.
    tried: BTreeSet<[usize; 2]>,
    tasks: u64,
    last_new: usize,
}

impl Growth<'_> {
    /// Hops until several runs have ended at the same lowest minimum. Returns the lowest minima met, lowest first.
    fn hop(&mut self, draw: &Draw<'_>, known: &[Vec<f64>]) -> Result<Vec<Met>, JournalError> {
        let quench = &self.settings.quench;
        let hopping = Hopping {
            energy: self.pool.energy,
            draw,
            quench: quench
                .clone()
                .with_gradient_tolerance(SLOPPY.0 * quench.gradient_tolerance)
                .with_max_evaluations(HOP),
            tie: SLOPPY.1 * self.settings.sameness.energy,
            step: STEP * self.settings.length,
            seed: self.settings.seed,
        };
        let patience = self.lowest.patience * self.pool.energy.space().tangents().max(1);
        let mut teams: Vec<Option<Team>> = vec![None; TEAMS];
        let mut met: Vec<Met> = known
            .iter()
            .map(|x| hopping.below(self.pool.energy, x))
            .collect();
        let mut ended: Vec<f64> = Vec::new();
        let mut round = 0;
        loop {
            if (self.run.enough)(HOPPING) {
                self.report.hopping_stopped = true;
                return Ok(met);
            }
            let tally = Tally::after(
                Phase::Hop,
                round * TEAMS,
                (round + 1) * TEAMS,
                self.run.observer,
            );
            let legs: Vec<Leg> = self.run.remember(&format!("hop/{round}"), || {
                let teams = teams.par_iter().with_max_len(1).enumerate();
                let leg = |(k, team): (usize, &Option<Team>)| {
                    let leg = hopping.leg((round * TEAMS + k) as u64, team.as_ref());
                    tally.tick();
                    leg
                };
                teams.map(leg).collect::<Vec<Leg>>()
            })?;
            round += 1;
            for (place, leg) in teams.iter_mut().zip(legs) {
                self.evaluations += leg.evaluations;
                met.extend(leg.met);
                let team = leg.team;
                self.report.hops += team.hops - place.as_ref().map_or(0, |team| team.hops);
                *place = if team.hops - team.best_at >= patience.max(team.best_at) {
                    ended.push(team.best);
                    None
                } else {
                    Some(team)
                };
            }
            met = hop::lowest(met, hopping.tie, 4 * self.lowest.minima);
            let Some(bottom) = met.first().map(|met| met.energy) else {
                continue;
            };
            self.report.runs = ended.len();
            self.report.finds = ended
                .iter()
                .filter(|best| **best <= bottom + hopping.tie)
                .count();
            if self.report.finds >= self.lowest.finds || self.report.hops >= MOST_HOPS {
                return Ok(met);
            }
        }
    }

    /// Descends to the lowest minima met, audits them and puts them into the pool.
    fn plant(&mut self, seeds: &[Met]) -> Result<(), JournalError> {
        type Planted = (Vec<Result<Found, Refused>>, usize);
        let pool = &self.pool;
        let (found, evaluations): Planted = self.run.remember("plant", || {
            let counted = Counted::new(pool.energy);
            let seeds = seeds.par_iter().take(self.lowest.minima).with_max_len(1);
            let found = seeds.map(|seed| {
                let end = quench(&counted, &seed.x, &self.settings.quench);
                pool.examined(end.x, 0, 0)
            });
            let found: Vec<_> = found.collect();
            let spent = usize::try_from(counted.evaluations()).unwrap_or(usize::MAX);
            (found, spent)
        })?;
        self.evaluations += evaluations;
        for found in found {
            match found {
                Ok(found) => {
                    let site = self.pool.put(found);
                    self.pool.sites[site].draws.push(0);
                }
                Err(refused) => self.refused.push(refused),
            }
        }
        Ok(())
    }

    fn targets(&self) -> Vec<usize> {
        self.pool.by_energy().take(self.lowest.minima).collect()
    }

    fn grow(&mut self) -> Result<(), JournalError> {
        let mut known = f64::INFINITY;
        let mut round = 0;
        while !self.pool.sites.is_empty() {
            let forks = forks(&self.pool, &self.targets());
            let depths: f64 = forks.iter().map(|fork| fork.depth).sum();
            let components = 1 + forks
                .iter()
                .filter(|fork| fork.height.is_infinite())
                .count();
            let changed = if known.is_finite() {
                (depths - known).abs() > SAME * known
            } else {
                true
            };
            if changed {
                (known, self.report.last_change) = (depths, round);
            }
            let deepest = forks
                .iter()
                .filter(|fork| fork.height.is_finite())
                .max_by(|a, b| a.depth.total_cmp(&b.depth));
            if round % 10 == 0 || changed {
                self.report.trace.push(LowestTrace {
                    round,
                    evaluations: self.evaluations,
                    minima: self.pool.sites.len(),
                    saddles: self.pool.gates.len(),
                    components,
                    depths,
                    deepest: deepest.map_or([0.0; 2], |fork| [fork.height, fork.depth]),
                    sides: deepest.map_or([0; 2], |fork| {
                        let sides = sides(&self.pool, fork.bottoms, fork.height);
                        [0, 1].map(|side| sides.iter().filter(|s| **s == Some(side)).count())
                    }),
                });
            }
            self.report.rounds = round;
            let idle = round - self.report.last_change;
            let enough = SETTLED * round as f64;
            if round >= LEAST_ROUNDS && idle as f64 >= enough && depths.is_finite() {
                return Ok(());
            }
            if self.tasks >= self.settings.max_searches as u64 || self.run.is_over() {
                self.report.stopped = true;
                return Ok(());
            }
            let plans = self.plans(round, &forks);
            self.round(round, &plans)?;
            round += 1;
        }
        Ok(())
    }

    /// The tasks of a round.
    fn plans(&mut self, round: usize, forks: &[Fork]) -> Vec<Plan> {
        let mut rng = stream(self.settings.seed, Task::Sequential, round as u64);
        let apart: Vec<&Fork> = (forks.iter())
            .filter(|fork| fork.height.is_infinite())
            .collect();
        let joined = || forks.iter().filter(|fork| fork.height.is_finite());
        let die = rng.random_range(0..4);
        let fork = if !apart.is_empty() && die > 0 {
            Some(apart[rng.random_range(0..apart.len().min(10))])
        } else if die % 2 == 0 {
            joined().max_by(|a, b| a.depth.total_cmp(&b.depth))
        } else {
            let total: f64 = joined().map(|fork| fork.depth.powi(3)).sum();
            let mut place = total * rng.random::<f64>();
            joined().find(|fork| {
                place -= fork.depth.powi(3);
                place <= 0.0
            })
        };
        let mut plans = Vec::new();
        let share = PATHS[usize::from(apart.is_empty())];
        let paths = BATCH.div_ceil(share);
        let Some(fork) = fork else {
            self.climbs(&mut plans, BATCH, f64::INFINITY, &|_| true);
            return plans;
        };
        let height = fork.height;
        let roads = Roads::below(&self.pool, height);
        while plans.len() < paths {
            let Some(pairs) = roads.missing(fork.bottoms, &self.tried) else {
                break;
            };
            if pairs.is_empty() {
                break;
            }
            for ends in pairs {
                if plans.len() < paths {
                    self.tried.insert(ends);
                    plans.push(Plan::Bridge {
                        ends,
                        ceiling: height,
                    });
                }
            }
        }
        let sides = sides(&self.pool, fork.bottoms, height);
        // Any lower way leaves each side over a saddle that is not known yet, so it is found from either side. The smaller side
        // is soon exhausted, and it must not wait for the larger one.
        let count = plans.len() + (BATCH - plans.len()) / 2;
        self.climbs(&mut plans, count, height, &|site| sides[site] == Some(0));
        self.climbs(&mut plans, BATCH, height, &|site| sides[site] == Some(1));
        plans
    }

    /// Adds climbs from the wanted minima: first from those from which few climbs began or many found something unknown, and
    /// of equal ones from the lowest.
    fn climbs(
        &mut self,
        plans: &mut Vec<Plan>,
        count: usize,
        ceiling: f64,
        wanted: &dyn Fn(usize) -> bool,
    ) {
        let mut sites: Vec<(f64, usize)> = (self.pool.by_energy())
            .filter(|site| wanted(*site) && self.pool.sites[*site].energy < ceiling)
            .map(|site| {
                let known = &self.pool.sites[site];
                let score = (known.climbs + 1) as f64 / (PROMISE * known.news + 1) as f64;
                (score, site)
            })
            .collect();
        sites.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut next = sites.iter().cycle();
        while plans.len() < count {
            let Some((_, site)) = next.next() else {
                break;
            };
            self.pool.sites[*site].climbs += 1;
            plans.push(Plan::Climb {
                site: *site,
                ceiling,
            });
        }
    }

    fn round(&mut self, round: usize, plans: &[Plan]) -> Result<(), JournalError> {
        let worker = Worker {
            settings: self.settings,
        };
        let first = self.tasks;
        let tally = Tally::after(
            Phase::Search,
            usize::try_from(first).unwrap_or(usize::MAX),
            usize::try_from(first).unwrap_or(usize::MAX) + plans.len(),
            self.run.observer,
        );
        let pool = &self.pool;
        let outcomes: Vec<Outcome> = self.run.remember(&format!("grow/{round}"), || {
            let work = |(k, plan): (usize, &Plan)| {
                let outcome = worker.work(first + k as u64, *plan, pool);
                tally.tick();
                outcome
            };
            let plans = plans.par_iter().with_max_len(1).enumerate();
            plans.map(work).collect::<Vec<Outcome>>()
        })?;
        self.tasks += plans.len() as u64;
        for (outcome, plan) in outcomes.into_iter().zip(plans) {
            let hits = usize::from(matches!(plan, Plan::Climb { .. }));
            self.evaluations += outcome.evaluations;
            for end in outcome.ends {
                *self.ends.entry(end).or_insert(0) += 1;
            }
            for known in outcome.known {
                self.pool.gates[known].hits += hits;
            }
            for crossed in outcome.crossed {
                if self.pool.join(crossed, hits) {
                    if let Plan::Climb { site, .. } = plan {
                        self.pool.sites[*site].news += 1;
                    }
                    self.last_new = usize::try_from(self.tasks).unwrap_or(usize::MAX);
                }
            }
            self.refused.extend(outcome.refused);
        }
        Ok(())
    }

    fn finish(self) -> (Exploration, LowestReport) {
        let Self {
            pool,
            report,
            refused,
            ends,
            evaluations,
            tasks,
            last_new,
            ..
        } = self;
        let hits: Vec<usize> = pool.gates.iter().map(|gate| gate.hits).collect();
        let draws: Vec<usize> = pool.sites.iter().map(|site| site.draws.len()).collect();
        let coverage = Coverage::new(&Counts {
            searches: usize::try_from(tasks).unwrap_or(usize::MAX),
            last_new,
            planned: 0,
            unfinished: 0,
            hits: &hits,
            draws: &draws,
            doubt: Some(Doubt::Sampled),
        });
        let order: Vec<usize> = pool.by_energy().collect();
        let gates: Vec<usize> = pool.gates_by_energy().collect();
        let mut number = vec![0; order.len()];
        for (id, old) in order.iter().enumerate() {
            number[*old] = id;
        }
        let mut sites: Vec<Option<pool::Site>> = pool.sites.into_iter().map(Some).collect();
        let mut all: Vec<Option<pool::Gate>> = pool.gates.into_iter().map(Some).collect();
        let (mut minima, mut audits) = (Vec::new(), Vec::new());
        for site in order.iter().filter_map(|old| sites[*old].take()) {
            minima.push(Minimum {
                coordinates: site.x,
                energy: site.energy,
                members: site.draws,
            });
            audits.push(site.audit);
        }
        let saddles = gates.iter().filter_map(|old| all[*old].take()).map(|gate| {
            let ends = gate.ends.map(|end| MinimumId(number[end]));
            let (mut path, mut top) = (gate.path, gate.top);
            if ends[0] > ends[1] {
                top = path.images.len() - 1 - top;
                path = path.reversed();
            }
            TransitionState {
                coordinates: gate.x,
                energy: gate.energy,
                ends: [ends[0].min(ends[1]), ends[0].max(ends[1])],
                path,
                top,
                hits: gate.hits,
                audit: gate.audit,
            }
        });
        let found = Exploration {
            minima,
            audits,
            saddles: saddles.collect(),
            bounds: Vec::new(),
            refused,
            search_ends: ends,
            limits: None,
            coverage,
            evaluations,
            stopped: report.stopped || report.hopping_stopped,
            further: None,
        };
        (found, report)
    }
}
