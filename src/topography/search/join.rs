//! Joins separate components of minima by relaxing paths between them. What no saddle joins gets an upper bound: the height of
//! a relaxed path.

use std::collections::BTreeSet;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::census::{Census, Source};
use super::searcher::Searcher;
use super::task::PUSH;
use crate::energy::{Counted, Energy};
use crate::topography::Phase;
use crate::topography::barrier::{Connection, Crossing, Start, rising_term};
use crate::topography::journal::{JournalError, Run};
use crate::topography::network::{Edge, Evidence, Minimum, MinimumId};
use crate::topography::pairs::{BetweenMinima, Distances, bridges};
use crate::topography::path::{PathSettings, geodesics, relax};

/// Times that components are joined before paths count as joining them.
const JOIN_ROUNDS: usize = 2;

#[derive(Default)]
pub(super) struct Joiner {
    joins: usize,
    rounds: usize,
    tried: BTreeSet<(usize, usize)>,
    /// The relaxed path of each pair that was tried, by the numbers of the census.
    pub(super) bounds: Vec<Connection>,
}

#[derive(Serialize, Deserialize)]
struct Relaxed {
    crossings: Vec<Crossing>,
    bound: Option<Connection>,
    evaluations: usize,
}

impl Joiner {
    /// Relaxes the straight line from every component to its nearest neighbour. Where that finds nothing new, paths count as
    /// joining their ends, and the components that are left are joined in the same way. Returns whether the search should
    /// go on from what was found.
    pub(super) fn join(
        &mut self,
        searcher: &Searcher<'_>,
        census: &mut Census,
        energy: &dyn Energy,
        run: &Run<'_>,
    ) -> Result<bool, JournalError> {
        let mut bounding = self.joins >= JOIN_ROUNDS;
        self.joins += 1;
        let mut before = usize::MAX;
        while !run.is_over() {
            let known = if bounding { &self.bounds[..] } else { &[] };
            let component = census.components_with(known);
            let parts = component.iter().collect::<BTreeSet<_>>().len();
            if parts < 2 || (bounding && parts >= before) {
                break;
            }
            if bounding {
                before = parts;
            }
            if self.relax_round(&component, searcher, census, energy, run)?
                && self.joins <= JOIN_ROUNDS
            {
                return Ok(true);
            }
            bounding = true;
        }
        Ok(false)
    }

    /// Relaxes the shortest untried pair of every component. Returns whether anything new was found.
    fn relax_round(
        &mut self,
        component: &[usize],
        searcher: &Searcher<'_>,
        census: &mut Census,
        energy: &dyn Energy,
        run: &Run<'_>,
    ) -> Result<bool, JournalError> {
        let minima = census.as_minima();
        let distances = BetweenMinima::new(energy.space(), &minima);
        let pairs = bridges(&distances, component, &|pair| self.tried.contains(&pair));
        let tally = run.tally(Phase::Join, pairs.len());
        let relaxed = run.remember(&format!("join/{}", self.rounds), || {
            let connect = |&(i, j): &(usize, usize)| {
                let relaxed =
                    searcher.relax((i, j), (&minima[i], &minima[j]), distances.between(i, j));
                tally.tick();
                relaxed
            };
            let relaxed: Vec<Relaxed> = pairs.par_iter().with_max_len(1).map(connect).collect();
            relaxed
        })?;
        self.rounds += 1;
        self.tried.extend(pairs);
        let before = census.found();
        for Relaxed {
            crossings,
            bound,
            evaluations,
        } in relaxed
        {
            census.spend(evaluations);
            self.bounds.extend(bound);
            for crossing in crossings {
                census.meet(energy, crossing, Source::Path);
            }
        }
        Ok(census.found() > before)
    }
}

impl Searcher<'_> {
    /// The relaxed passes on the straight line between two minima, and on the other way round.
    fn relax(
        &self,
        (from, to): (usize, usize),
        ends: (&Minimum, &Minimum),
        distance: f64,
    ) -> Relaxed {
        let ids = [from, to].map(MinimumId);
        let counted = Counted::new(self.energy);
        let space = self.energy.space();
        let settings = PathSettings {
            push: PUSH * self.settings.length,
            ..PathSettings::for_scales(self.settings.energy, distance)
        };
        let (from, to) = (&ends.0.coordinates, &ends.1.coordinates);
        let outcome = relax(
            &counted,
            ends,
            &geodesics(space, from, to, settings.detour),
            &settings,
            &self.settings.quench,
            &self.settings.sameness,
            f64::INFINITY,
        );
        let (mut passes, mut bound) = (Vec::new(), None);
        if let Some(mut outcome) = outcome {
            passes = outcome.passes;
            outcome.path.crest(&counted);
            let top = outcome.path.top();
            if outcome.path.energies[top] > outcome.height {
                outcome.height = outcome.path.energies[top];
                outcome.top.clone_from(&outcome.path.images[top]);
            }
            let edge = Edge {
                term: rising_term(self.energy, &outcome.top, ends),
                length: outcome.path.length(space),
                // However well the path relaxed, the search verifies every saddle, and this path has none.
                ..Edge::bare(outcome.height, Evidence::Chain)
            };
            bound = outcome.height.is_finite().then(|| Connection {
                start: [Start::Straight, Start::Round].get(outcome.start).copied(),
                invalid_reason: outcome.invalid_reason,
                ..Connection::new(ids[0], ids[1], edge, outcome.path)
            });
        }
        Relaxed {
            crossings: passes.into_iter().map(Crossing::from).collect(),
            bound,
            evaluations: usize::try_from(counted.evaluations()).unwrap_or(usize::MAX),
        }
    }
}
