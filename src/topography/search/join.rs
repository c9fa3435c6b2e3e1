//! Joins separate components of minima by relaxing paths between them.

use std::collections::BTreeSet;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::census::{Census, Source};
use super::searcher::Searcher;
use super::task::PUSH;
use crate::energy::{Counted, Energy};
use crate::topography::Phase;
use crate::topography::barrier::Crossing;
use crate::topography::journal::{JournalError, Run};
use crate::topography::network::Minimum;
use crate::topography::pairs::{BetweenMinima, Distances, bridges};
use crate::topography::path::{PathSettings, geodesics, relax};

#[derive(Default)]
pub(super) struct Joiner {
    rounds: usize,
    tried: BTreeSet<(usize, usize)>,
}

#[derive(Serialize, Deserialize)]
struct Relaxed {
    crossings: Vec<Crossing>,
    evaluations: usize,
}

impl Joiner {
    /// Relaxes the straight line from every component to its nearest neighbour. Returns whether anything new was found.
    pub(super) fn join(
        &mut self,
        searcher: &Searcher<'_>,
        census: &mut Census,
        energy: &dyn Energy,
        run: &Run<'_>,
    ) -> Result<bool, JournalError> {
        if self.rounds >= searcher.settings.join_rounds {
            return Ok(false);
        }
        let component = census.components();
        let minima = census.as_minima();
        if component.iter().all(|c| *c == component[0]) {
            return Ok(false);
        }
        let distances = BetweenMinima::new(energy.space(), &minima);
        let pairs = bridges(&distances, &component, &|pair| self.tried.contains(&pair));
        let tally = run.tally(Phase::Join, pairs.len());
        let relaxed = run.remember(&format!("join/{}", self.rounds), || {
            let connect = |&(i, j): &(usize, usize)| {
                let relaxed = searcher.relax((&minima[i], &minima[j]), distances.between(i, j));
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
            evaluations,
        } in relaxed
        {
            census.spend(evaluations);
            for crossing in crossings {
                census.meet(energy, crossing, Source::Path);
            }
        }
        Ok(census.found() > before)
    }
}

impl Searcher<'_> {
    /// The relaxed passes on the straight line between two minima, and on the other way round.
    fn relax(&self, ends: (&Minimum, &Minimum), distance: f64) -> Relaxed {
        let counted = Counted::new(self.energy);
        let space = self.energy.space();
        let settings = PathSettings {
            method: self.settings.paths,
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
        let passes = outcome.map(|outcome| outcome.passes).unwrap_or_default();
        Relaxed {
            crossings: passes.into_iter().map(Crossing::from).collect(),
            evaluations: usize::try_from(counted.evaluations()).unwrap_or(usize::MAX),
        }
    }
}
