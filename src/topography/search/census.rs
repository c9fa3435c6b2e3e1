//! What is known so far: distinct minima and saddles, and how often each saddle was met.

use super::coverage::{Counts, Coverage, Doubt};
use super::task::{Outcome, SearchEnd};
use super::{Exploration, SearchSettings};
use crate::energy::Energy;
use crate::optimize::Quench;
use crate::space::Space;
use crate::space::vector::times;
use crate::topography::audit::{Audit, AuditSettings, Verdict, examine};
use crate::topography::barrier::Crossing;
use crate::topography::eigen::Piece;
use crate::topography::minima::MatchTolerance;
use crate::topography::network::{Minimum, MinimumId};
use crate::topography::path::{Path, near};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A verified saddle: index 1, and descents on both sides end in known minima.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TransitionState {
    /// Where it is.
    pub coordinates: Vec<f64>,
    /// Its energy.
    pub energy: f64,
    /// The minima it joins, the lower first; the same twice where it joins two copies of one (a degenerate
    /// rearrangement).
    pub ends: [MinimumId; 2],
    /// From the first end over the saddle to the second.
    pub path: Path,
    /// Number of the saddle on the path.
    pub top: usize,
    /// How many searches ended here; none where only a path between two minima led over it.
    pub hits: usize,
    /// Its audit.
    pub audit: Audit,
}

/// The end of a descent or of a climb that did not pass its audit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Refused {
    /// Number of the search.
    pub search: usize,
    /// The index it should have: 0 of a minimum, 1 of a saddle.
    pub expected_index: usize,
    /// Its energy.
    pub energy: f64,
    /// What is wrong with it.
    pub audit: Audit,
}

/// A minimum of the census.
pub(super) struct Known {
    pub(super) x: Vec<f64>,
    energy: f64,
    /// Plain tangents of its modes, softest first.
    pub(super) modes: Vec<Vec<f64>>,
    audit: Audit,
    draws: Vec<usize>,
}

/// Where a saddle comes from.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// A search ended at it.
    Search,
    /// A path between two minima leads over it.
    Path,
}

/// How far above all stationary points a search may rise, in units of their range and the surface's energy.
const FAR: f64 = 10.0;

/// Numbers of things by rising energy.
#[derive(Default)]
struct Shelf(Vec<(f64, usize)>);

impl Shelf {
    fn insert(&mut self, energy: f64, number: usize) {
        let place = self.0.partition_point(|(e, _)| *e < energy);
        self.0.insert(place, (energy, number));
    }

    fn near(&self, energy: f64, tolerance: f64) -> impl Iterator<Item = usize> {
        let first = self.0.partition_point(|(e, _)| *e < energy - tolerance);
        let end = self.0.partition_point(|(e, _)| *e <= energy + tolerance);
        self.0[first..end].iter().map(|(_, number)| *number)
    }
}

pub(super) struct Census {
    pub(super) minima: Vec<Known>,
    pub(super) saddles: Vec<Found>,
    /// Median distance from a saddle to the minima it joins.
    pub(super) reach: Option<f64>,
    by_energy: [Shelf; 2],
    sameness: MatchTolerance,
    audit: AuditSettings,
    refused: Vec<Refused>,
    fates: BTreeMap<SearchEnd, usize>,
    pub(super) searches: usize,
    pub(super) last_new: usize,
    evaluations: usize,
}

/// A saddle of the census.
pub(super) struct Found {
    pub(super) x: Vec<f64>,
    pub(super) energy: f64,
    ends: [usize; 2],
    /// Number of the first saddle at this point.
    place: usize,
    crossing: Crossing,
    hits: usize,
    audit: Audit,
    reach: f64,
}

impl Census {
    pub(super) fn new(settings: &SearchSettings) -> Self {
        Self {
            minima: Vec::new(),
            saddles: Vec::new(),
            reach: None,
            by_energy: [Shelf::default(), Shelf::default()],
            sameness: settings.sameness,
            audit: settings.audit(),
            refused: Vec::new(),
            fates: BTreeMap::new(),
            searches: 0,
            last_new: 0,
            evaluations: 0,
        }
    }

    /// Stationary points found.
    pub(super) fn found(&self) -> usize {
        self.minima.len() + self.saddles.len()
    }

    /// The known saddle at `x`.
    pub(super) fn saddle(&self, space: &dyn Space, x: &[f64], energy: f64) -> Option<usize> {
        self.by_energy[1]
            .near(energy, self.sameness.energy)
            .find(|k| space.distance(&self.saddles[*k].x, x) <= self.sameness.distance)
    }

    /// The known minimum at `x`, which is taken in if it is new and passes its audit. Points of a ring, a trough or a plateau
    /// are one: that of their energy that was found first.
    fn minimum(&mut self, energy: &dyn Energy, x: &[f64], height: f64) -> Option<usize> {
        let space = energy.space();
        let known = self.by_energy[0]
            .near(height, self.sameness.energy)
            .find(|k| space.distance(&self.minima[*k].x, x) <= self.sameness.distance);
        if known.is_some() {
            return known;
        }
        let audit = self.passed(energy, x, 0)?;
        if audit.verdict == Verdict::Degenerate {
            let of_its_set = self.by_energy[0]
                .near(height, self.sameness.energy)
                .find(|k| self.minima[*k].audit.verdict == Verdict::Degenerate);
            if of_its_set.is_some() {
                return of_its_set;
            }
        }
        let piece = Piece::new(energy, Vec::new());
        let modes = piece.modes(x, self.audit.difference)?.tangents;
        self.by_energy[0].insert(height, self.minima.len());
        self.minima.push(Known {
            x: x.to_vec(),
            energy: height,
            modes: modes
                .iter()
                .map(|mode| times(mode, &piece.scales))
                .collect(),
            audit,
            draws: Vec::new(),
        });
        self.last_new = self.searches;
        Some(self.minima.len() - 1)
    }

    /// The audit of a point, if it passes.
    fn passed(&mut self, energy: &dyn Energy, x: &[f64], expected_index: usize) -> Option<Audit> {
        let (height, audit) = examine(energy, x, expected_index, &self.audit);
        if audit.verdict.is_stationary() {
            return Some(audit);
        }
        self.refused.push(Refused {
            search: self.searches,
            expected_index,
            energy: height,
            audit,
        });
        None
    }

    /// Takes in what the next search brought.
    pub(super) fn take(&mut self, energy: &dyn Energy, outcome: Outcome) {
        self.searches += 1;
        self.evaluations += outcome.evaluations;
        if let Some(drawn) = outcome.drawn {
            let quench = Quench::from(drawn);
            if let Some(minimum) = self.minimum(energy, &quench.x, quench.energy) {
                self.minima[minimum].draws.push(self.searches - 1);
            }
        }
        let mut fate = outcome.fate;
        if let Some(known) = outcome.known {
            self.hit(known, 1);
        }
        if let Some(crossing) = outcome.found {
            let known = self.saddles.len();
            fate = self.meet(energy, crossing, Source::Search);
            if self.saddles.len() > known {
                for branch in outcome.branches {
                    self.admit(energy, branch, 1, known);
                }
            }
        }
        *self.fates.entry(fate).or_insert(0) += 1;
    }

    /// The minima as the path search knows them.
    pub(super) fn as_minima(&self) -> Vec<Minimum> {
        let minimum = |known: &Known| Minimum {
            coordinates: known.x.clone(),
            energy: known.energy,
            choice: Vec::new(),
            members: Vec::new(),
        };
        self.minima.iter().map(minimum).collect()
    }

    /// What relaxing paths cost.
    pub(super) fn spend(&mut self, evaluations: usize) {
        self.evaluations += evaluations;
    }

    /// Takes in a saddle that was not known when its search began.
    pub(super) fn meet(
        &mut self,
        energy: &dyn Energy,
        crossing: Crossing,
        source: Source,
    ) -> SearchEnd {
        let hits = usize::from(source == Source::Search);
        let space = energy.space();
        let (images, energies) = (&crossing.path.images, &crossing.path.energies);
        let (x, height) = (images[crossing.pass].clone(), energies[crossing.pass]);
        if let Some(known) = self.saddle(space, &x, height) {
            self.hit(known, hits);
            return SearchEnd::Arrived;
        }
        self.admit(energy, crossing, hits, self.saddles.len())
    }

    /// Counts searches that came to a saddle, which is listed as often as the minima it joins ask for.
    fn hit(&mut self, known: usize, hits: usize) {
        let place = self.saddles[known].place;
        for saddle in self
            .saddles
            .iter_mut()
            .filter(|saddle| saddle.place == place)
        {
            saddle.hits += hits;
        }
    }

    /// Takes in a saddle that is not known, or another way over the one that was the first in its `place`.
    fn admit(
        &mut self,
        energy: &dyn Energy,
        crossing: Crossing,
        hits: usize,
        place: usize,
    ) -> SearchEnd {
        let space = energy.space();
        let (images, energies) = (&crossing.path.images, &crossing.path.energies);
        let (x, height) = (images[crossing.pass].clone(), energies[crossing.pass]);
        let last = images.len() - 1;
        let ends = [0, last].map(|k| self.minimum(energy, &images[k], energies[k]));
        let [Some(from), Some(to)] = ends else {
            return SearchEnd::Evaporated;
        };
        let mut there = self.saddles.iter().filter(|saddle| saddle.place == place);
        if there.any(|saddle| saddle.ends.contains(&to)) {
            return SearchEnd::Arrived;
        }
        let Some(audit) = self.passed(energy, &x, 1) else {
            return SearchEnd::Index;
        };
        if audit.verdict == Verdict::Degenerate {
            let of_its_set = self.by_energy[1]
                .near(height, self.sameness.energy)
                .find(|k| self.saddles[*k].audit.verdict == Verdict::Degenerate);
            if let Some(known) = of_its_set {
                self.saddles[known].hits += hits;
                return SearchEnd::Arrived;
            }
        }
        let reach = near(space, &x, &images[0]).max(near(space, &x, &images[last]));
        self.by_energy[1].insert(height, self.saddles.len());
        self.saddles.push(Found {
            x,
            energy: height,
            ends: [from, to],
            place,
            crossing,
            hits,
            audit,
            reach,
        });
        self.last_new = self.searches;
        let mut reaches: Vec<f64> = self.saddles.iter().map(|saddle| saddle.reach).collect();
        reaches.sort_by(f64::total_cmp);
        self.reach = reaches.get(reaches.len() / 2).copied();
        SearchEnd::Arrived
    }

    /// Energy above which no saddle is expected: far above all stationary points known.
    pub(super) fn ceiling(&self, scale: f64) -> f64 {
        let ends = self
            .by_energy
            .iter()
            .flat_map(|shelf| [shelf.0.first(), shelf.0.last()]);
        let energies = ends.flatten().map(|(energy, _)| *energy);
        let (low, high) = energies.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| {
            (low.min(e), high.max(e))
        });
        if low > high {
            return f64::INFINITY;
        }
        high + FAR * (high - low + scale)
    }

    /// Component of each minimum in the network of saddles.
    pub(super) fn components(&self) -> Vec<usize> {
        let mut sets = petgraph::unionfind::UnionFind::new(self.minima.len());
        for saddle in &self.saddles {
            sets.union(saddle.ends[0], saddle.ends[1]);
        }
        sets.into_labeling()
    }

    /// Why completeness cannot be claimed, if so.
    fn doubt(&self, stopped: bool) -> Option<Doubt> {
        let audits = (self.minima.iter().map(|known| &known.audit))
            .chain(self.saddles.iter().map(|found| &found.audit));
        let components = self.components();
        if audits
            .into_iter()
            .any(|audit| audit.verdict == Verdict::Degenerate)
        {
            Some(Doubt::Degenerate)
        } else if self
            .refused
            .iter()
            .any(|refused| refused.audit.verdict == Verdict::Kink)
        {
            Some(Doubt::Kinks)
        } else if components
            .iter()
            .any(|component| *component != components[0])
        {
            Some(Doubt::Apart)
        } else {
            stopped.then_some(Doubt::Stopped)
        }
    }

    /// Everything found, by rising energy. `stopped`: whether the search had not ended by itself.
    pub(super) fn finish(self, energy: &dyn Energy, spent: usize, stopped: bool) -> Exploration {
        let hits: Vec<usize> = self.saddles.iter().map(|saddle| saddle.hits).collect();
        let draws: Vec<usize> = self.minima.iter().map(|known| known.draws.len()).collect();
        let coverage = Coverage::new(&Counts {
            searches: self.searches,
            last_new: self.last_new,
            hits: &hits,
            draws: &draws,
            doubt: self.doubt(stopped),
        });
        let order: Vec<usize> = self.by_energy[0]
            .0
            .iter()
            .map(|(_, number)| *number)
            .collect();
        let mut number = vec![0; order.len()];
        for (id, old) in order.iter().enumerate() {
            number[*old] = id;
        }
        let mut saddles: Vec<Option<Found>> = self.saddles.into_iter().map(Some).collect();
        let by_energy = self.by_energy[1].0.iter();
        let saddles = by_energy
            .filter_map(|(_, old)| saddles[*old].take())
            .map(|found| {
                let ends = found.ends.map(|end| MinimumId(number[end]));
                let (mut path, mut top) = (found.crossing.path, found.crossing.pass);
                if ends[0] > ends[1] {
                    top = path.images.len() - 1 - top;
                    path = path.reversed();
                }
                TransitionState {
                    coordinates: found.x,
                    energy: found.energy,
                    ends: [ends[0].min(ends[1]), ends[0].max(ends[1])],
                    path,
                    top,
                    hits: found.hits,
                    audit: found.audit,
                }
            })
            .collect();
        let (mut minima, mut audits) = (Vec::new(), Vec::new());
        let mut known: Vec<Option<Known>> = self.minima.into_iter().map(Some).collect();
        for minimum in order.iter().filter_map(|old| known[*old].take()) {
            minima.push(Minimum {
                choice: energy.active_piece(&minimum.x),
                coordinates: minimum.x,
                energy: minimum.energy,
                members: minimum.draws,
            });
            audits.push(minimum.audit);
        }
        Exploration {
            minima,
            audits,
            saddles,
            refused: self.refused,
            fates: self.fates,
            coverage,
            evaluations: self.evaluations + spent,
        }
    }
}
