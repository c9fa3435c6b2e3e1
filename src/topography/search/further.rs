//! Further searches between two minima of a search that has ended.

use super::census::{Census, Source};
use super::task::PUSH;
use super::{Exploration, Explorer};
use crate::sample::Mala;
use crate::space::Space;
use crate::topography::build::{MapSettings, PairSearch, search_between};
use crate::topography::families::FamilySettings;
use crate::topography::journal::{JournalError, Prefixed, Run};
use crate::topography::network::MinimumId;
use crate::topography::path::{PathSettings, near};
use crate::topography::scales::median;
use crate::topography::support::{Attempt, Attempts};
use crate::topography::tree::Tree;

/// Searches between two minima, made when all others had ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Further {
    /// The two minima as a search without these numbers them.
    pub asked: [MinimumId; 2],
    /// The same minima among those of the result.
    pub minima: [MinimumId; 2],
    /// Height at which they merged before; `None` if they did not.
    pub before: Option<f64>,
    /// The searches, and where each ended.
    pub attempts: Attempts,
}

impl Further {
    /// The searches, of which those that ended below the merge of `tree` count as having found no way: no saddle bears it out.
    pub(super) fn verified(&self, tree: &Tree) -> Attempts {
        let [a, b] = self.minima;
        let tolerance = self.attempts.tolerance;
        let merge = tree.minimax(a, b).unwrap_or(f64::INFINITY);
        let verified = |attempt: &Attempt| Attempt {
            height: attempt.height.filter(|height| *height >= merge - tolerance),
            ..attempt.clone()
        };
        Attempts {
            list: self.attempts.list.iter().map(verified).collect(),
            tolerance,
        }
    }
}

impl Explorer<'_> {
    /// Searches between the two minima of `pair`, and goes on from the points that are new. `None` if there are not so many
    /// minima.
    pub(super) fn search_further(
        &mut self,
        pair: PairSearch,
        run: &Run<'_>,
    ) -> Result<Option<Further>, JournalError> {
        let order = self.census.order();
        let [Some(a), Some(b)] = pair.minima.map(|minimum| order.get(minimum.0).copied()) else {
            return Ok(None);
        };
        let bounds = self.joiner.bounds.clone();
        let so_far = self.census.clone();
        let so_far = so_far.finish(self.energy, 0, None, self.limit.counts, bounds);
        let landscape = so_far.landscape(self.energy, &FamilySettings::default());
        let settings = self.settings_between(&so_far, pair);

        // What follows depends on the pair, and what came before does not: it is kept for other pairs.
        let own = format!("connect/{}-{}", pair.minima[0].0, pair.minima[1].0);
        let (chains, after) = (format!("{own}/chains/"), format!("{own}/"));
        let kept = |prefix| Prefixed {
            journal: run.journal,
            prefix,
        };
        let (chains, after) = (kept(&chains), kept(&after));
        let found = search_between(
            (self.energy, &Mala::new(self.energy)),
            &landscape,
            pair,
            &settings,
            &Run {
                journal: &chains,
                ..*run
            },
        )?;
        self.census.spend(found.evaluations);
        let before = self.census.found();
        for crossing in found.crossings {
            self.census.meet(&self.counted, crossing, Source::Path);
        }
        self.plan();
        if self.census.found() > before && !self.stopped {
            self.search(&Run {
                journal: &after,
                ..*run
            })?;
        }
        let minima = [a, b].map(|number| place_of(&self.census, number));
        let renumbered = |attempt: Attempt| Attempt {
            from: minima[0].min(minima[1]),
            to: minima[0].max(minima[1]),
            ..attempt
        };
        Ok(Some(Further {
            asked: pair.minima,
            minima,
            before: landscape.tree.minimax(pair.minima[0], pair.minima[1]),
            attempts: Attempts {
                list: found.attempts.into_iter().map(renumbered).collect(),
                tolerance: self.settings.sameness.energy,
            },
        }))
    }

    /// Settings of the chains and paths between two minima: in units of the barriers and ways that are known.
    fn settings_between(&self, found: &Exploration, pair: PairSearch) -> MapSettings {
        let space = self.energy.space();
        let settings = self.settings;
        let [from, to] = (pair.minima).map(|minimum| &found.minima[minimum.0].coordinates);
        let scales = scales(found, space);
        let (energy, length) = scales.unwrap_or((settings.energy, near(space, from, to)));
        MapSettings {
            path: PathSettings {
                push: PUSH * settings.length,
                ..PathSettings::for_scales(energy, length)
            },
            quench: settings.quench.clone(),
            sameness: settings.sameness,
            seed: settings.seed,
            ..MapSettings::for_scales(energy, length)
        }
    }
}

/// The median rise from the higher minimum to a saddle, and the median distance of the two minima that a saddle joins; `None`
/// if no saddle rises between two minima.
fn scales(found: &Exploration, space: &dyn Space) -> Option<(f64, f64)> {
    let between = found.distinct_saddles();
    let (rises, lengths) = between
        .filter(|saddle| saddle.ends[0] != saddle.ends[1])
        .map(|saddle| {
            let floor = found.minima[saddle.ends[1].0].energy;
            let images = &saddle.path.images;
            let [first, last] = [0, images.len() - 1].map(|k| &images[k]);
            (saddle.energy - floor, near(space, first, last))
        })
        .filter(|(rise, length)| *rise > 0.0 && *length > 0.0)
        .unzip();
    Some((median(rises)?, median(lengths)?))
}

/// The number that a minimum of the census has in the result.
fn place_of(census: &Census, number: usize) -> MinimumId {
    let order = census.order();
    let place = order.iter().position(|other| *other == number);
    MinimumId(place.unwrap_or(number))
}
