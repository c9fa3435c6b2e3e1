//! Independent searches for lower ways across the merges of the tree, by attraction–diffusion.
//!
//! A search draws two minima on both sides of a merge, a temperature and a direction, and runs a chain from one to the other
//! whose force grows until it arrives. No chain begins a way that leads away from its target. Where the chains agree, a few
//! more searches therefore begin with a free walk out of their minimum, and the chain starts where it ends. Raw chains lie far above the passes that they cross, but they go from basin to basin in
//! a good order. Descents from their points find these basins, straight strings between neighbouring basins find the passes,
//! and the search has the height of the highest of them. A chain that visits no basin between its ends is relaxed itself.

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;
use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::LandscapeBuilder;
use super::waypoints::ordered;
use crate::optimize::quench;
use crate::sample::{Rng, Task, stream};
use crate::topography::Phase;
use crate::topography::adelm::{ChainSettings, chain, leave};
use crate::topography::barrier::{Connection, Pair, Start};
use crate::topography::journal::{JournalError, bits};
use crate::topography::network::{Edge, Evidence, Minimum, MinimumId, Network};
use crate::topography::pairs::Distances as _;
use crate::topography::path::Path;
use crate::topography::support::{Attempt, Attempts, Searched, chance_of_lower};
use crate::topography::tree::{NodeId, Tree};

/// A merge is searched until the chance that a lower way exists is at most this.
const SETTLED: f64 = 0.05;

/// Temperatures of the searches, as multiples of the usual one: a cold chain keeps to a valley, and a hot one leaves it.
const TEMPERATURES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// A merge that counts as settled is tested by this many searches that begin with a free walk, half of them in each direction.
const FREE: usize = 4;

/// Of the further searches between two minima, one in this many pairs of them begins with a free walk.
const FREE_PAIRS: usize = 4;

/// Number of times that a free walk is tested for having left its minimum.
const LEAVINGS: usize = 4;

/// Each point at which a search descends is passed over with this probability in favour of the next nearest one on the other
/// side of the merge.
const FARTHER: f64 = 2.0 / 3.0;

/// Number of further searches between two minima in each round; later ones begin with what the rounds before have found.
const ROUND: usize = 8;

/// How often the way of a chain is halved at most: descents from up to 2ⁿ − 1 of its points find its basins.
const HALVINGS: u32 = 3;

/// First random stream of the chains of searches; sequential maps have a kind of their own.
const CHAINS: u64 = 1 << 60;

/// A search to be made.
struct Draw {
    pair: (usize, usize),
    number: usize,
    backward: bool,
    temperature: f64,
    /// Whether it begins with a free walk.
    free: bool,
    /// The merge that it crosses.
    height: f64,
}

impl Draw {
    fn start(&self) -> Start {
        Start::Chain {
            backward: self.backward,
            replica: self.number,
        }
    }

    /// Temperature of the free walk from the minimum `from`: the height of the merge above it. A colder walk seldom leaves a
    /// minimum of many dimensions within its patience.
    fn free_temperature(&self, from: &Minimum) -> Option<f64> {
        let rise = self.height - from.energy;
        (self.free && rise > 0.0 && rise.is_finite()).then_some(rise)
    }
}

/// What a chain found.
#[derive(Serialize, Deserialize)]
struct Way {
    /// Highest energy of the chain, infinite if none arrived, and the last force.
    #[serde(with = "bits::list")]
    barrier_and_force: Vec<f64>,
    /// Bottoms of the basins that it visited, in order from the lower minimum; empty if no chain arrived.
    basins: Path,
    /// The chain itself if it visited no basin between its ends; else empty.
    direct: Path,
    evaluations: usize,
}

impl Way {
    fn visit(&mut self, basin: &Minimum) {
        self.basins.images.push(basin.coordinates.clone());
        self.basins.energies.push(basin.energy);
    }
}

impl LandscapeBuilder<'_> {
    /// Searches for lower ways across every merge until their chance is small or the budget is spent, and then between the two
    /// minima of which more is wanted.
    pub(super) fn search(&mut self) -> Result<(), JournalError> {
        let most = match self.settings.searches / 2 {
            0 => 0,
            rounds => rounds + FREE / 2,
        };
        if self.pair.is_none() && (most == 0 || self.draws().is_empty()) {
            return Ok(());
        }
        for connection in self.best.values().cloned().collect::<Vec<_>>() {
            self.keep_passes(&connection);
        }
        self.join_over_waypoints();
        for round in 0..most {
            let draws = self.draws();
            if draws.is_empty() {
                break;
            }
            self.search_each(&draws, (round, most))?;
        }
        let further = self.pair.map_or(0, |pair| pair.searches);
        let rounds = further.div_ceil(ROUND);
        for round in 0..rounds {
            let draws = self.draws_between(ROUND.min(further - round * ROUND));
            self.search_each(&draws, (round, rounds))?;
        }
        Ok(())
    }

    /// Makes the searches of a round, and joins minima over what they found.
    fn search_each(&mut self, draws: &[Draw], round: (usize, usize)) -> Result<(), JournalError> {
        let tally = self.run.tally_of_round(Phase::Cross, round, draws.len());
        let ways: Vec<Way> = self.run.each(
            &tally,
            draws,
            |draw| format!("search/{}", draw.number),
            |draw| self.way(draw),
        )?;
        self.connect_basins(draws, &ways, round)?;
        self.join_over_waypoints();
        Ok(())
    }

    /// `count` searches between the two minima of which more is wanted, in turn in each direction; none if only ripples divide
    /// them.
    fn draws_between(&self, count: usize) -> Vec<Draw> {
        let basins = self.basins();
        let Some([a, b]) = (self.pair).map(|pair| pair.minima.map(|minimum| basins[minimum.0]))
        else {
            return Vec::new();
        };
        if a == b {
            return Vec::new();
        }
        let tree = Tree::from_network(&self.whole_basins(&basins), Evidence::Chain);
        let height = tree.minimax(MinimumId(a), MinimumId(b));
        let draw = |k| {
            let number = self.searches + k;
            let mut rng = stream(self.settings.seed, Task::Search, number as u64);
            Draw {
                pair: ordered((a, b)),
                number,
                backward: k % 2 == 1,
                temperature: self.temperature(&mut rng),
                free: k / 2 % FREE_PAIRS == FREE_PAIRS - 1,
                height: height.unwrap_or(f64::INFINITY),
            }
        };
        (0..count).map(draw).collect()
    }

    fn temperature(&self, rng: &mut Rng) -> f64 {
        TEMPERATURES[rng.random_range(0..TEMPERATURES.len())] * self.settings.chain.temperature
    }

    /// Two searches, one in each direction, for each merge that is not settled.
    fn draws(&self) -> Vec<Draw> {
        let basins = self.basins();
        let tree = Tree::from_network(&self.whole_basins(&basins), Evidence::Chain);
        let searched = self.searched(&tree, &basins);
        let leaves: Vec<Vec<usize>> = tree.fold(|node, branches: &[Vec<usize>]| {
            if branches.is_empty() {
                vec![node.0]
            } else {
                branches.concat()
            }
        });
        let mut draws = Vec::new();
        let mut number = self.searches;
        for (merge, node) in tree.nodes.iter().enumerate() {
            let found = searched[merge];
            let chance = found.map_or_else(|| chance_of_lower(0), |found| found.lower);
            let (all, freed) = found.map_or((0, 0), |found| (found.searches, found.free));
            let known = leaves[merge].iter().all(|leaf| self.settled[*leaf]);
            let free = chance <= SETTLED;
            let spent = if free {
                freed >= FREE
            } else {
                all - freed + 2 > self.settings.searches
            };
            if node.children.is_empty() || spent || known && all > 0 {
                continue;
            }
            for backward in [false, true] {
                let mut rng = stream(self.settings.seed, Task::Search, number as u64);
                let pair = self.across(&tree, NodeId(merge), &leaves, &mut rng);
                draws.push(Draw {
                    pair: ordered(pair),
                    number,
                    backward,
                    temperature: self.temperature(&mut rng),
                    free,
                    height: node.energy,
                });
                number += 1;
            }
        }
        draws
    }

    /// What the searches so far say of each merge of a tree of whole basins.
    fn searched(&self, tree: &Tree, basins: &[usize]) -> Vec<Option<Searched>> {
        let of_basins = |attempt: &Attempt| Attempt {
            from: MinimumId(basins[attempt.from.0]),
            to: MinimumId(basins[attempt.to.0]),
            ..attempt.clone()
        };
        let searches = self.attempts.iter().filter(|attempt| attempt.law.is_some());
        let attempts = Attempts {
            list: searches.map(of_basins).collect(),
            tolerance: self.settings.sameness.energy,
        };
        attempts.of_merges(tree)
    }

    /// The network of whole basins; a minimum that is not the lowest of its basin has no edge. Components are joined at the
    /// ceiling, if there is one.
    fn whole_basins(&self, basins: &[usize]) -> Network {
        let mut network = Network::default();
        for minimum in &self.minima {
            network.add_node(Minimum {
                coordinates: Vec::new(),
                members: Vec::new(),
                ..*minimum
            });
        }
        let ceiling = self.settings.ceiling.unwrap_or(f64::INFINITY);
        for ((i, j), connection) in &self.best {
            let (a, b) = (basins[*i], basins[*j]);
            if a != b && connection.edge.height.is_finite() {
                let edge = Edge {
                    term: None,
                    height: connection.edge.height.min(ceiling),
                    ..connection.edge
                };
                network.add_edge(NodeIndex::new(a), NodeIndex::new(b), edge);
            }
        }
        if ceiling.is_finite() {
            for (a, basin) in basins.iter().enumerate().skip(1) {
                if a == *basin {
                    let edge = Edge::bare(ceiling, Evidence::Path);
                    network.add_edge(NodeIndex::new(0), NodeIndex::new(a), edge);
                }
            }
        }
        network
    }

    /// A minimum of one branch of a merge, but not the largest, and one of the others, most likely near it.
    fn across(
        &self,
        tree: &Tree,
        merge: NodeId,
        leaves: &[Vec<usize>],
        rng: &mut Rng,
    ) -> (usize, usize) {
        let mut branches: Vec<usize> = (tree.nodes[merge.0].children.iter())
            .map(|child| child.0)
            .collect();
        branches.sort_by_key(|branch| leaves[*branch].len());
        let small = branches[rng.random_range(0..branches.len() - 1)];
        let from = leaves[small][rng.random_range(0..leaves[small].len())];
        let others = branches.iter().filter(|branch| **branch != small);
        let mut others: Vec<(f64, usize)> = others
            .flat_map(|branch| &leaves[*branch])
            .map(|to| (self.distances.between(from, *to), *to))
            .collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut rank = 0;
        while rng.random_bool(FARTHER) {
            rank += 1;
        }
        (from, others[rank % others.len()].1)
    }

    /// Runs the chain of a search, and descends from its points.
    fn way(&self, draw: &Draw) -> Way {
        let (lower, higher) = (&self.minima[draw.pair.0], &self.minima[draw.pair.1]);
        let ends = if draw.backward {
            (higher, lower)
        } else {
            (lower, higher)
        };
        let settings = ChainSettings {
            temperature: draw.temperature,
            ..self.settings.chain.clone()
        };
        let (quenching, sameness) = (&self.settings.quench, &self.settings.sameness);
        let mut force = settings.force;
        let random = |part: usize| {
            let id = CHAINS | (draw.number as u64) << 8 | part as u64;
            stream(self.settings.seed, Task::AttractionDiffusion, id)
        };
        let mut way = Way {
            barrier_and_force: vec![f64::INFINITY, force],
            basins: Path::default(),
            direct: Path::default(),
            evaluations: 0,
        };
        let free_temperature = draw.free_temperature(ends.0);
        let left = free_temperature.and_then(|temperature| {
            let (left, spent) = leave(
                self.energy,
                self.kernel,
                ends.0,
                &ChainSettings {
                    temperature,
                    ..settings.clone()
                },
                LEAVINGS,
                (quenching, sameness),
                &mut random(0),
            );
            way.evaluations += spent;
            left
        });
        let start = left.as_ref().map_or(ends.0, |(reached, _)| reached);
        for attempt in 0..settings.attempts {
            let found = chain(
                self.energy,
                self.kernel,
                (start, ends.1),
                force,
                &settings,
                (quenching, sameness),
                f64::INFINITY,
                &mut random(attempt + 1),
            );
            way.evaluations += found.evaluations;
            way.barrier_and_force[1] = force;
            if found.arrived {
                way.barrier_and_force[0] = found.barrier;
                way.visit(ends.0);
                let mut path = Path::default();
                if let Some((reached, walked)) = &left {
                    self.descend_between(&walked.images, (ends.0, reached), HALVINGS, &mut way);
                    way.visit(reached);
                    path = walked.clone();
                }
                self.descend_between(&found.path.images, (start, ends.1), HALVINGS, &mut way);
                way.visit(ends.1);
                path.append(&found.path);
                if draw.backward {
                    way.basins = way.basins.reversed();
                    path = path.reversed();
                }
                if way.basins.images.len() == 2 {
                    way.direct = path;
                }
                break;
            }
            force *= settings.escalation;
        }
        way
    }

    /// Appends the basins of the points between two points of a chain, whose own basins are `ends`.
    fn descend_between(
        &self,
        points: &[Vec<f64>],
        ends: (&Minimum, &Minimum),
        halvings: u32,
        way: &mut Way,
    ) {
        let (space, sameness) = (self.energy.space(), &self.settings.sameness);
        let same = |a: &Minimum, b: &Minimum| sameness.holds(space, &a.coordinates, a.energy, b);
        if points.len() < 3 || halvings == 0 || same(ends.0, ends.1) {
            return;
        }
        let middle = points.len() / 2;
        let end = quench(self.energy, &points[middle], &self.settings.quench);
        way.evaluations += end.evaluations;
        let here = Minimum::bare(end.x, end.energy);
        self.descend_between(&points[..=middle], (ends.0, &here), halvings - 1, way);
        if !same(&here, ends.0) && !same(&here, ends.1) {
            way.visit(&here);
        }
        self.descend_between(&points[middle..], (&here, ends.1), halvings - 1, way);
    }

    /// Two basins of which only a way below `height` matters.
    pub(super) fn pair_of(&self, (a, b): (usize, usize), height: f64) -> Pair<'_> {
        Pair {
            ids: (MinimumId(a), MinimumId(b)),
            minima: (self.basin(a), self.basin(b)),
            attempt: 0,
            known: height,
        }
    }

    /// Connects the neighbouring basins of all ways of a round, and adds the searches to the attempts.
    fn connect_basins(
        &mut self,
        draws: &[Draw],
        ways: &[Way],
        round: (usize, usize),
    ) -> Result<(), JournalError> {
        let known = Tree::from_network(&self.whole_network(), Evidence::Chain);
        let count = self.minima.len() + self.waypoints.minima.len();
        let joined = |(a, b): (usize, usize)| {
            let both = b < count;
            both.then(|| known.minimax(MinimumId(a), MinimumId(b)))
                .flatten()
        };
        let tolerance = self.settings.sameness.energy;
        let mut routes = Vec::with_capacity(ways.len());
        // The new pairs, and the height above which each does not matter.
        let mut open: Vec<((usize, usize), f64)> = Vec::new();
        for (draw, way) in draws.iter().zip(ways) {
            self.evaluations += way.evaluations;
            let mut route: Vec<usize> = Vec::new();
            for (x, energy) in way.basins.images.iter().zip(&way.basins.energies) {
                let basin = self.basin_at(x, *energy);
                // Loops are cut off.
                if let Some(before) = route.iter().position(|known| *known == basin) {
                    route.truncate(before);
                }
                route.push(basin);
            }
            for step in route.windows(2) {
                let pair = ordered((step[0], step[1]));
                let below = joined(pair).is_some_and(|height| height < draw.height - tolerance);
                if !below && !self.has_leg(pair) {
                    open.push((pair, draw.height + tolerance));
                }
            }
            routes.push(route);
        }
        open.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        open.dedup_by_key(|(pair, _)| *pair);
        let tally = self.run.tally_of_round(Phase::Cross, round, open.len());
        let legs: Vec<Connection> = self.run.each(
            &tally,
            &open,
            |((a, b), _)| format!("leg/{a}-{b}"),
            |(pair, height)| {
                let pair = self.pair_of(*pair, *height);
                self.connector().connect_straight(self.energy, pair)
            },
        )?;
        let direct: Vec<(&Draw, &Path)> = (draws.iter().zip(ways))
            .filter(|(_, way)| !way.direct.images.is_empty())
            .map(|(draw, way)| (draw, &way.direct))
            .collect();
        let tally = self.run.tally_of_round(Phase::Cross, round, direct.len());
        let relaxed: Vec<Connection> = self.run.each(
            &tally,
            &direct,
            |(draw, _)| format!("direct/{}", draw.number),
            |(draw, path)| {
                let pair = self.pair_of(draw.pair, draw.height + tolerance);
                let points = path.images.clone();
                self.connector()
                    .connect_along(self.energy, pair, (draw.start(), points))
            },
        )?;
        let heights = relaxed.iter().map(|connection| connection.edge.height);
        let own: BTreeMap<usize, f64> = (direct.iter())
            .map(|(draw, _)| draw.number)
            .zip(heights)
            .collect();
        for leg in legs.into_iter().chain(relaxed) {
            self.evaluations += leg.evaluations;
            self.collect_unlisted_minima(&leg);
            self.keep_leg(leg);
        }
        for ((draw, way), route) in draws.iter().zip(ways).zip(&routes) {
            let steps = route.windows(2).map(|step| {
                let pair = ordered((step[0], step[1]));
                let direct = self.leg(pair).map_or(f64::INFINITY, |leg| leg.edge.height);
                let below = joined(pair).filter(|height| *height < draw.height - tolerance);
                direct.min(below.unwrap_or(f64::INFINITY))
            });
            let composed = steps.fold(f64::NEG_INFINITY, f64::max);
            let height = own.get(&draw.number).copied().unwrap_or(composed);
            let (barrier, force) = (way.barrier_and_force[0], way.barrier_and_force[1]);
            let [lower, higher] = [draw.pair.0, draw.pair.1].map(|end| &self.minima[end]);
            let first = if draw.backward { higher } else { lower };
            self.attempts.push(Attempt {
                from: MinimumId(draw.pair.0),
                to: MinimumId(draw.pair.1),
                start: draw.start(),
                law: Some([draw.temperature, force]),
                free_temperature: draw.free_temperature(first),
                barrier: Some(barrier).filter(|barrier| barrier.is_finite()),
                height: Some(height).filter(|height| height.is_finite()),
            });
            self.searches = self.searches.max(draw.number + 1);
        }
        Ok(())
    }
}
