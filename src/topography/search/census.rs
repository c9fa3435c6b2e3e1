//! The distinct minima and saddles found so far, and how often each saddle was met.

use super::coverage::{Counts, Coverage, Doubt};
use super::flat::{Bottom, is_of_bottom, same_bottom, same_saddle};
use super::outcome::{Outcome, SearchEnd};
use super::{Exploration, Limits, SearchSettings};
use crate::energy::Energy;
use crate::space::Space;
use crate::space::vector::times;
use crate::topography::audit::{Audit, AuditSettings, Verdict, examine};
use crate::topography::barrier::{Connection, Crossing};
use crate::topography::eigen::Scaled;
use crate::topography::minima::MatchTolerance;
use crate::topography::network::{Minimum, MinimumId};
use crate::topography::path::{Path, near};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A verified saddle: index 1, and descents on both sides end in known minima.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TransitionState {
    /// Coordinates of the saddle.
    pub coordinates: Vec<f64>,
    /// Its energy.
    pub energy: f64,
    /// The minima it joins, lower first; both are equal for a degenerate rearrangement, which joins two copies of one.
    pub ends: [MinimumId; 2],
    /// The path from the first end over the saddle to the second.
    pub path: Path,
    /// Index of the saddle in the path.
    pub top: usize,
    /// Number of searches that ended here without having begun beside it; 0 if it was found only on a path between two
    /// minima.
    pub hits: usize,
    /// Its audit.
    pub audit: Audit,
}

/// Marks the entries of a saddle after its first one as duplicates of that: more than two valleys meet there. The saddles are
/// sorted by energy.
pub(crate) fn mark_branches(saddles: &mut [TransitionState]) {
    for k in 0..saddles.len() {
        let (earlier, others) = saddles.split_at_mut(k);
        let saddle = &mut others[0];
        let level = earlier.partition_point(|other| other.energy < saddle.energy);
        let mut alike = earlier[level..].iter();
        let first = alike.position(|other| other.coordinates == saddle.coordinates);
        if first.is_some() {
            saddle.audit.verdict = Verdict::Duplicate;
        } else if saddle.audit.verdict == Verdict::Duplicate {
            // The entry that was the first one is listed no more.
            saddle.audit.verdict = Verdict::Sound;
        }
        saddle.audit.duplicate_of = first.map(|first| level + first);
    }
}

/// A stationary point of a descent or a climb that failed its audit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Refused {
    /// Number of the search.
    pub search: usize,
    /// The index it should have: 0 for a minimum, 1 for a saddle.
    pub expected_index: usize,
    /// Its energy.
    pub energy: f64,
    /// The audit it failed.
    pub audit: Audit,
}

impl Refused {
    /// Whether it is the bottom of a kink.
    pub(crate) fn is_kink(&self) -> bool {
        self.audit.verdict == Verdict::Kink
    }
}

#[derive(Clone)]
pub(super) struct Known {
    pub(super) x: Vec<f64>,
    energy: f64,
    /// Plain tangents of its modes, softest first.
    pub(super) modes: Vec<Vec<f64>>,
    audit: Audit,
    draws: Vec<usize>,
}

impl Known {
    fn bottom(&self) -> Bottom<'_> {
        Bottom {
            x: &self.x,
            energy: self.energy,
            audit: &self.audit,
        }
    }
}

/// How a saddle was found.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// A search ended at it.
    Search,
    /// It is on a path between two minima.
    Path,
}

/// How far a search may rise above all stationary points, in units of their range and of the surface's energy.
const FAR: f64 = 10.0;

/// Indices sorted by energy.
#[derive(Clone, Default)]
pub(super) struct Shelf(pub(super) Vec<(f64, usize)>);

impl Shelf {
    pub(super) fn insert(&mut self, energy: f64, number: usize) {
        let place = self.0.partition_point(|(e, _)| *e < energy);
        self.0.insert(place, (energy, number));
    }

    pub(super) fn near(&self, energy: f64, tolerance: f64) -> impl Iterator<Item = usize> {
        let first = self.0.partition_point(|(e, _)| *e < energy - tolerance);
        let end = self.0.partition_point(|(e, _)| *e <= energy + tolerance);
        self.0[first..end].iter().map(|(_, number)| *number)
    }
}

#[derive(Clone)]
pub(super) struct Census {
    pub(super) minima: Vec<Known>,
    pub(super) saddles: Vec<Found>,
    /// Median distance between saddles and the minima they join.
    pub(super) reach: Option<f64>,
    by_energy: [Shelf; 2],
    sameness: MatchTolerance,
    audit: AuditSettings,
    refused: Vec<Refused>,
    search_ends: BTreeMap<SearchEnd, usize>,
    pub(super) searches: usize,
    pub(super) last_new: usize,
    /// Points that may be minima, saddles or neither, and their energies.
    undecided: Vec<(Vec<f64>, f64)>,
    unfinished: usize,
    evaluations: usize,
}

#[derive(Clone)]
pub(super) struct Found {
    pub(super) x: Vec<f64>,
    pub(super) energy: f64,
    ends: [usize; 2],
    /// Index of the first saddle found at this point.
    place: usize,
    crossing: Crossing,
    hits: usize,
    audit: Audit,
    reach: f64,
}

impl Found {
    fn point(&self) -> Bottom<'_> {
        Bottom {
            x: &self.x,
            energy: self.energy,
            audit: &self.audit,
        }
    }
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
            search_ends: BTreeMap::new(),
            searches: 0,
            last_new: 0,
            undecided: Vec::new(),
            unfinished: 0,
            evaluations: 0,
        }
    }

    pub(super) fn found(&self) -> usize {
        self.minima.len() + self.saddles.len()
    }

    pub(super) fn saddle(&self, space: &dyn Space, x: &[f64], energy: f64) -> Option<usize> {
        self.by_energy[1]
            .near(energy, self.sameness.energy)
            .find(|k| space.within(&self.saddles[*k].x, x, self.sameness.distance))
    }

    /// Whether two entries are branches of one saddle.
    pub(super) fn are_one(&self, a: usize, b: usize) -> bool {
        self.saddles[a].place == self.saddles[b].place
    }

    /// The known minimum at `x`.
    pub(super) fn minimum_at(&self, space: &dyn Space, x: &[f64], energy: f64) -> Option<usize> {
        self.by_energy[0]
            .near(energy, self.sameness.energy)
            .find(|k| space.within(&self.minima[*k].x, x, self.sameness.distance))
    }

    /// Whether `x` belongs to the bottom of a known minimum.
    fn is_of_minimum(&self, energy: &dyn Energy, x: &[f64], height: f64) -> bool {
        let alike = self.by_energy[0].near(height, self.sameness.energy);
        let mut alike = alike.map(|k| (self.minima[k].x.as_slice(), self.minima[k].energy));
        alike.any(|known| is_of_bottom(energy, (x, height), known, &self.audit))
    }

    /// The known minimum at `x`; a new one that passes its audit is added. All points of a flat bottom are represented by the
    /// one found first ([`same_bottom`]).
    fn minimum(&mut self, energy: &dyn Energy, x: &[f64], height: f64) -> Option<usize> {
        let known = self.minimum_at(energy.space(), x, height);
        if known.is_some() {
            return known;
        }
        let audit = self.passed(energy, x, 0)?;
        let alike = self.by_energy[0].near(height, self.sameness.energy);
        let alike = alike.map(|k| (k, self.minima[k].bottom()));
        let new = Bottom {
            x,
            energy: height,
            audit: &audit,
        };
        let of_its_set = same_bottom(energy, &new, alike, &self.audit);
        if of_its_set.is_some() {
            return of_its_set;
        }
        let surface = Scaled::new(energy);
        let modes = surface.modes(x, self.audit.difference)?.tangents;
        self.by_energy[0].insert(height, self.minima.len());
        self.minima.push(Known {
            x: x.to_vec(),
            energy: height,
            modes: modes
                .iter()
                .map(|mode| times(mode, &surface.scales))
                .collect(),
            audit,
            draws: Vec::new(),
        });
        self.last_new = self.searches;
        Some(self.minima.len() - 1)
    }

    /// The audit of the point if it passes; otherwise the point is recorded as refused.
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

    /// Takes over what a search found and returns how it ended.
    pub(super) fn take(&mut self, energy: &dyn Energy, outcome: Outcome) -> SearchEnd {
        self.searches += 1;
        self.evaluations += outcome.evaluations;
        let mut unfinished = outcome.unfinished;
        let refused = self.refused.len();
        if let Some(drawn) = outcome.drawn {
            let quench = drawn.0;
            if let Some(minimum) = self.minimum(energy, &quench.x, quench.energy) {
                self.minima[minimum].draws.push(self.searches - 1);
            } else if self.refused[refused..].iter().any(Refused::is_kink) {
                // It is counted with the refused points.
                unfinished = false;
            }
        }
        self.unfinished += usize::from(unfinished);
        let mut fate = outcome.fate;
        if let Some((x, height)) = outcome.undecided {
            fate = SearchEnd::Index;
            if !self.is_of_minimum(energy, &x, height) {
                fate = SearchEnd::Undecided;
                self.undecided.push((x, height));
            }
        }
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
        *self.search_ends.entry(fate).or_insert(0) += 1;
        fate
    }

    /// The minima in the form that the path search needs.
    pub(super) fn as_minima(&self) -> Vec<Minimum> {
        let minimum = |known: &Known| Minimum::bare(known.x.clone(), known.energy);
        self.minima.iter().map(minimum).collect()
    }

    pub(super) fn spend(&mut self, evaluations: usize) {
        self.evaluations += evaluations;
    }

    /// Adds a saddle that was unknown when its search began.
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

    /// Adds hits to a saddle, including all its entries at the same place.
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

    /// Adds an unknown saddle, or a further branch of the saddle whose first entry is `place`.
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
        // Where a flat bottom ends, rounding makes saddles of its points.
        let bottom = &self.minima[from];
        let rise = height - bottom.energy;
        if from == to && bottom.bottom().is_degenerate() && rise <= self.sameness.energy {
            return SearchEnd::Flat;
        }
        let Some(audit) = self.passed(energy, &x, 1) else {
            return SearchEnd::Index;
        };
        let alike = self.by_energy[1].near(height, self.sameness.energy);
        let alike = alike.map(|k| (k, self.saddles[k].point()));
        let new = Bottom {
            x: &x,
            energy: height,
            audit: &audit,
        };
        let is_first = place == self.saddles.len();
        if let Some(known) = same_saddle(energy, &new, alike, &self.audit).filter(|_| is_first) {
            self.hit(known, hits);
            return SearchEnd::Arrived;
        }
        if audit.verdict == Verdict::Degenerate {
            let joins = |ends: [usize; 2]| ends == [from, to] || ends == [to, from];
            let of_its_set = (self.by_energy[1].near(height, self.sameness.energy)).find(|k| {
                let saddle = &self.saddles[*k];
                saddle.audit.verdict == Verdict::Degenerate && joins(saddle.ends)
            });
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

    /// Energy far above all known stationary points, above which no saddle is expected.
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

    /// Numbers of the minima, lowest first: the place of each here is its number in the result.
    pub(super) fn order(&self) -> Vec<usize> {
        let sorted = self.by_energy[0].0.iter();
        sorted.map(|(_, number)| *number).collect()
    }

    /// Connected component of each minimum in the network of saddles.
    pub(super) fn components(&self) -> Vec<usize> {
        self.components_with(&[])
    }

    /// Connected component of each minimum in the network of saddles and some bounds.
    pub(super) fn components_with(&self, bounds: &[Connection]) -> Vec<usize> {
        let mut sets = petgraph::unionfind::UnionFind::new(self.minima.len());
        for bound in bounds {
            sets.union(bound.from.0, bound.to.0);
        }
        for saddle in &self.saddles {
            sets.union(saddle.ends[0], saddle.ends[1]);
        }
        sets.into_labeling()
    }

    /// The reason, if any, why completeness cannot be claimed.
    fn doubt(&self, energy: &dyn Energy, stopped: bool, limits: &Limits) -> Option<Doubt> {
        let audits = (self.minima.iter().map(|known| &known.audit))
            .chain(self.saddles.iter().map(|found| &found.audit));
        let components = self.components();
        if audits
            .into_iter()
            .any(|audit| audit.verdict == Verdict::Degenerate)
        {
            Some(Doubt::Degenerate)
        } else if self.refused.iter().any(Refused::is_kink) {
            Some(Doubt::Kinks)
        } else if self.unfinished > 0 {
            Some(Doubt::Unfinished)
        } else if components
            .iter()
            .any(|component| *component != components[0])
        {
            Some(Doubt::Apart)
        } else if (self.undecided.iter()).any(|(x, height)| !self.is_of_minimum(energy, x, *height))
        {
            Some(Doubt::Undecided)
        } else if limits.few().is_some() && !self.saddles.is_empty() {
            Some(Doubt::Few)
        } else if stopped {
            Some(Doubt::Stopped)
        } else {
            self.saddles.is_empty().then_some(Doubt::Alone)
        }
    }

    /// All results, sorted by energy. `planned` is the number of searches that were still to be made if the search was
    /// stopped before it ended by itself. Of the `bounds`, those between components of the network of saddles are kept.
    pub(super) fn finish(
        self,
        energy: &dyn Energy,
        spent: usize,
        planned: Option<usize>,
        limits: Limits,
        mut bounds: Vec<Connection>,
    ) -> Exploration {
        let stopped = planned.is_some();
        let component = self.components();
        bounds.retain(|bound| component[bound.from.0] != component[bound.to.0]);
        let saddles = self.saddles.iter().enumerate();
        let places = saddles.filter(|(number, saddle)| saddle.place == *number);
        let hits: Vec<usize> = places.map(|(_, saddle)| saddle.hits).collect();
        let draws: Vec<usize> = self.minima.iter().map(|known| known.draws.len()).collect();
        let coverage = Coverage::new(&Counts {
            searches: self.searches,
            last_new: self.last_new,
            planned: planned.unwrap_or(0),
            unfinished: self.unfinished,
            hits: &hits,
            draws: &draws,
            doubt: self.doubt(energy, stopped, &limits),
        });
        let order = self.order();
        let mut number = vec![0; order.len()];
        for (id, old) in order.iter().enumerate() {
            number[*old] = id;
        }
        for bound in &mut bounds {
            let [from, to] = [bound.from, bound.to].map(|end| MinimumId(number[end.0]));
            (bound.from, bound.to) = (from.min(to), from.max(to));
            if from > to {
                bound.path = std::mem::take(&mut bound.path).reversed();
            }
        }
        bounds.sort_by_key(|bound| (bound.from, bound.to));
        let mut saddles: Vec<Option<Found>> = self.saddles.into_iter().map(Some).collect();
        let by_energy = self.by_energy[1].0.iter();
        let mut saddles: Vec<TransitionState> = by_energy
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
        mark_branches(&mut saddles);
        let (mut minima, mut audits) = (Vec::new(), Vec::new());
        let mut known: Vec<Option<Known>> = self.minima.into_iter().map(Some).collect();
        for minimum in order.iter().filter_map(|old| known[*old].take()) {
            minima.push(Minimum {
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
            bounds,
            refused: self.refused,
            search_ends: self.search_ends,
            limits: Some(limits),
            coverage,
            evaluations: self.evaluations + spent,
            stopped,
            further: None,
        }
    }
}
