//! Searches between two minima of a landscape, apart from any map.

use std::collections::BTreeSet;

use petgraph::graph::NodeIndex;

use super::waypoints::ordered;
use super::{Charted, LandscapeBuilder, MapSettings, PairSearch};
use crate::energy::Energy;
use crate::sample::Kernel;
use crate::topography::Phase;
use crate::topography::barrier::{Connection, Crossing, Start};
use crate::topography::journal::{JournalError, Run};
use crate::topography::landscape::Landscape;
use crate::topography::merges::minimax_path;
use crate::topography::network::{Edge, Evidence, MinimumId, Network};
use crate::topography::path::Path;
use crate::topography::support::Attempt;
use crate::topography::tree::Tree;

/// Rounds in which the lowest way is divided at its passes.
const DIVISIONS: usize = 8;

/// What searches between two minima found.
#[derive(Debug)]
pub(in crate::topography) struct Between {
    /// The passes that they crossed, known ones among them.
    pub(in crate::topography) crossings: Vec<Crossing>,
    /// The searches, whose minima have the numbers of the landscape.
    pub(in crate::topography) attempts: Vec<Attempt>,
    pub(in crate::topography) evaluations: usize,
}

/// Makes the searches of `pair` on a landscape, as [`grow_landscape`](super::grow_landscape) makes them, and then finds every
/// pass on the lowest way between its minima.
///
/// # Errors
/// If the journal of `run` cannot store a record.
///
/// # Panics
/// If a minimum of the pair is not in the landscape, or both are the same.
pub(in crate::topography) fn search_between(
    (energy, kernel): (&dyn Energy, &dyn Kernel),
    landscape: &Landscape,
    pair: PairSearch,
    settings: &MapSettings,
    run: &Run<'_>,
) -> Result<Between, JournalError> {
    let settings = MapSettings {
        searches: 0,
        ..settings.clone()
    };
    let added = (Vec::new(), Some(pair));
    let start = Charted::onto(energy, landscape, added, &settings.sameness);
    let known = start.attempts.len();
    let mapped = start.minima.clone();
    let mut builder = LandscapeBuilder::new((energy, kernel), &mapped, start, &settings, run);
    builder.search()?;
    builder.divide(pair.minima)?;
    Ok(Between {
        crossings: builder.crossed,
        attempts: builder.attempts.split_off(known),
        evaluations: builder.evaluations,
    })
}

/// A part of a leg, from one of its ends to the foot of its pass.
struct Part {
    pair: (usize, usize),
    /// Points from the first basin of the pair to the second.
    way: Vec<Vec<f64>>,
    /// The height of the leg.
    height: f64,
}

impl LandscapeBuilder<'_> {
    /// Relaxes the parts of the lowest way between two minima on both sides of its passes, until passes join the two as low
    /// as the way does. Of a relaxed path only the highest pass is known, and others may lie below it.
    fn divide(&mut self, [from, to]: [MinimumId; 2]) -> Result<(), JournalError> {
        let mut tried = BTreeSet::new();
        for round in 0..DIVISIONS {
            let Some(route) = minimax_path(&self.network_of_legs(), from, to) else {
                break;
            };
            let passes = Tree::from_network(&self.network_of_passes(), Evidence::Chain);
            let (mut open, mut seen) = (Vec::new(), BTreeSet::new());
            for step in route.windows(2) {
                let pair = ordered((step[0].0, step[1].0));
                self.open_parts(pair, &passes, &tried, (&mut open, &mut seen));
            }
            if open.is_empty() {
                break;
            }
            tried.extend(open.iter().map(|part| part.pair));
            let tally = (self.run).tally_of_round(Phase::Cross, (round, DIVISIONS), open.len());
            let legs: Vec<Connection> = self.run.each(
                &tally,
                &open,
                |part| format!("part/{}-{}", part.pair.0, part.pair.1),
                |part| {
                    let pair = self.pair_of(part.pair, part.height);
                    let start = (Start::Straight, part.way.clone());
                    self.connector().connect_along(self.energy, pair, start)
                },
            )?;
            for leg in legs {
                self.evaluations += leg.evaluations;
                self.keep_leg(leg);
            }
        }
        Ok(())
    }

    /// Adds the parts of a leg that are to be relaxed: of the leg, or of its parts that were relaxed before.
    fn open_parts(
        &self,
        pair: (usize, usize),
        passes: &Tree,
        tried: &BTreeSet<(usize, usize)>,
        (open, seen): (&mut Vec<Part>, &mut BTreeSet<(usize, usize)>),
    ) {
        let Some(leg) = self.leg(pair).filter(|_| seen.insert(pair)) else {
            return;
        };
        let highest = leg.edge.height + self.settings.sameness.energy;
        let joined = |(a, b): (usize, usize)| {
            let height = passes.minimax(MinimumId(a), MinimumId(b));
            a == b || height.is_some_and(|height| height <= highest)
        };
        if joined(pair) {
            return;
        }
        for part in self.parts(leg).into_iter().flatten() {
            if joined(part.pair) {
                continue;
            }
            if tried.contains(&part.pair) {
                self.open_parts(part.pair, passes, tried, (&mut *open, &mut *seen));
            } else if !open.iter().any(|other| other.pair == part.pair) {
                open.push(part);
            }
        }
    }

    /// The ways from both ends of a leg to the feet of the pass that decides its height, if that joins known basins.
    fn parts(&self, leg: &Connection) -> Option<[Part; 2]> {
        let apart =
            |crossing: &Crossing| (crossing.path.energies[crossing.pass] - leg.edge.height).abs();
        let crossings = leg.crossings.iter();
        let crossing = crossings.min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        let (top, last) = (leg.path.top(), leg.path.images.len() - 1);
        if top == 0 || top == last {
            return None;
        }
        let (space, images) = (self.energy.space(), &leg.path.images);
        // The descents from the pass may lead along another copy of the path.
        let beside = |crossing: &Crossing| {
            let apart = [1, -1].map(|side| {
                let [ours, theirs] = [top, crossing.pass].map(|k| k.checked_add_signed(side));
                let points = ours.zip(theirs).and_then(|(ours, theirs)| {
                    Some((images.get(ours)?, crossing.path.images.get(theirs)?))
                });
                points.map_or(f64::INFINITY, |(a, b)| space.distance(a, b))
            });
            apart[0] + apart[1]
        };
        let turned = Crossing {
            pass: crossing.path.images.len() - 1 - crossing.pass,
            evidence: crossing.evidence,
            path: crossing.path.clone().reversed(),
        };
        let crossing = if beside(&turned) < beside(crossing) {
            &turned
        } else {
            crossing
        };
        let (path, end) = (&crossing.path, crossing.path.images.len() - 1);
        let foot = |k: usize| self.known_basin(&path.images[k], path.energies[k]);
        let (near_foot, far_foot) = (foot(0)?, foot(end)?);
        // A string that touches the pass would rest there, so that both ways are cut off half as high.
        let low = |foot: usize| {
            let level = f64::midpoint(path.energies[foot], path.energies[crossing.pass]);
            move |energy: &f64| *energy <= level
        };
        let here = leg.path.energies[..top].iter().rposition(low(0));
        let down = path.energies[..crossing.pass].iter().rposition(low(0));
        let down = path.images[..=down?].iter().rev();
        let to_foot = images[..=here.unwrap_or(0)].iter().chain(down);
        let there = leg.path.energies[top..].iter().position(low(end));
        let up = path.energies[crossing.pass..].iter().position(low(end));
        let up = path.images[crossing.pass + up?..].iter().rev();
        let from_foot = up.chain(&images[there.map_or(last, |k| top + k)..]);
        let part = |(a, b): (usize, usize), way: Vec<Vec<f64>>| {
            let mut way = Path {
                energies: vec![0.0; way.len()],
                images: way,
            };
            if a > b {
                way = way.reversed();
            }
            way.unfold(space);
            Part {
                pair: ordered((a, b)),
                way: way.images,
                height: leg.edge.height,
            }
        };
        let [to_foot, from_foot] = [to_foot.cloned().collect(), from_foot.cloned().collect()];
        Some([
            part((leg.from.0, near_foot), to_foot),
            part((far_foot, leg.to.0), from_foot),
        ])
    }

    /// All basins and the legs between them, without those that are composed of others.
    fn network_of_legs(&self) -> Network {
        let mut network = self.whole_network();
        network.retain_edges(|network, edge| {
            let ends = network.edge_endpoints(edge);
            let pair = ends.map(|(a, b)| ordered((a.index(), b.index())));
            pair.is_some_and(|pair| {
                let crosses = |leg: &Connection| !leg.crossings.is_empty();
                self.passes.contains_key(&pair) || self.leg(pair).is_some_and(crosses)
            })
        });
        network
    }

    /// The basins, joined by single passes alone.
    fn network_of_passes(&self) -> Network {
        let mut network = self.whole_network();
        network.clear_edges();
        for ((a, b), height) in &self.passes {
            let edge = Edge::bare(*height, Evidence::Saddle);
            network.add_edge(NodeIndex::new(*a), NodeIndex::new(*b), edge);
        }
        network
    }
}
