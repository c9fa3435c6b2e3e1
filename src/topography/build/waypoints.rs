//! Basins between the minima of a map, and the legs between them: what all searches found together may join two minima lower
//! than any of them alone.
//!
//! This is the growing database of discrete path sampling (D. J. Wales, Mol. Phys. 100, 3285 (2002)), of which the map keeps
//! the ways between its own minima only.

use std::collections::{BTreeMap, VecDeque};

use petgraph::graph::NodeIndex;
use petgraph::unionfind::UnionFind;

use super::{LandscapeBuilder, claim};
use crate::space::interpolate;
use crate::topography::barrier::{Connection, Crossing, rising_term};
use crate::topography::network::{Edge, Evidence, Minimum, MinimumId, Network};
use crate::topography::path::Path;
use crate::topography::tree::spanning_forest;

/// Segments of the straight line that may join the foot of a descent with a minimum beside it: no ridge between two ripples
/// may hide between its points.
const PARTS: usize = 32;

/// Basins that are no minimum of the map, and legs that end in one. Numbers of waypoints follow those of the minima.
#[derive(Default)]
pub(super) struct Waypoints {
    pub(super) minima: Vec<Minimum>,
    pub(super) legs: BTreeMap<(usize, usize), Connection>,
}

pub(super) fn ordered((a, b): (usize, usize)) -> (usize, usize) {
    (a.min(b), a.max(b))
}

/// A minimum without what only a map needs.
fn bare(minimum: &Minimum) -> Minimum {
    Minimum::bare(Vec::new(), minimum.energy)
}

impl LandscapeBuilder<'_> {
    /// The minimum or waypoint with this number.
    pub(super) fn basin(&self, number: usize) -> &Minimum {
        let minima = self.minima.len();
        if number < minima {
            &self.minima[number]
        } else {
            &self.waypoints.minima[number - minima]
        }
    }

    /// The number of the basin at `x`, a new one if it is not known.
    pub(super) fn basin_at(&mut self, x: &[f64], energy: f64) -> usize {
        if let Some(known) = self.known_basin(x, energy) {
            return known;
        }
        self.waypoints
            .minima
            .push(Minimum::bare(x.to_vec(), energy));
        self.minima.len() + self.waypoints.minima.len() - 1
    }

    /// The number of the basin at `x`, if it is known.
    pub(super) fn known_basin(&self, x: &[f64], energy: f64) -> Option<usize> {
        let (space, sameness) = (self.energy.space(), &self.settings.sameness);
        let same = |waypoint: &Minimum| sameness.holds(space, x, energy, waypoint);
        self.find(x, energy).or_else(|| {
            let place = self.waypoints.minima.iter().position(same);
            place.map(|place| self.minima.len() + place)
        })
    }

    /// Whether a leg between two basins is known, however high.
    pub(super) fn has_leg(&self, pair: (usize, usize)) -> bool {
        self.best.contains_key(&pair) || self.waypoints.legs.contains_key(&pair)
    }

    /// The lowest leg that joins two basins directly.
    pub(super) fn leg(&self, pair: (usize, usize)) -> Option<&Connection> {
        let known = [self.best.get(&pair), self.waypoints.legs.get(&pair)];
        let lower = |a: &&Connection, b: &&Connection| a.edge.height.total_cmp(&b.edge.height);
        known.into_iter().flatten().min_by(lower)
    }

    /// Keeps a leg, and those over the passes that were found beside it.
    pub(super) fn keep_leg(&mut self, leg: Connection) {
        self.keep_passes(&leg);
        if self.pair.is_some() {
            self.crossed.extend(leg.crossings.iter().cloned());
        }
        self.keep(leg);
    }

    /// Keeps the passes of a connection as legs between the basins that their descents reach. On a surface with
    /// ripples, a straight line joins such a basin to an end of the connection if it rises by less than a ripple.
    pub(super) fn keep_passes(&mut self, connection: &Connection) {
        for crossing in &connection.crossings {
            let Some(ends) = self.keep_pass(crossing) else {
                continue;
            };
            for foot in ends {
                for end in [connection.from.0, connection.to.0] {
                    self.join_straight(ordered((foot, end)));
                }
            }
        }
    }

    fn keep_pass(&mut self, crossing: &Crossing) -> Option<[usize; 2]> {
        let (mut path, pass) = (crossing.path.clone(), crossing.pass);
        let last = path.images.len() - 1;
        let [a, b] = [0, last].map(|k| self.basin_at(&path.images[k], path.energies[k]));
        if a == b {
            return None;
        }
        let invalid_reason = self.energy.invalid_reason(&path.images[pass]);
        let evidence = match invalid_reason {
            Some(_) => Evidence::Chain,
            None => crossing.evidence,
        };
        let height = path.energies[pass];
        if a > b {
            path = path.reversed();
        }
        let lowest = self.passes.entry(ordered((a, b))).or_insert(height);
        *lowest = lowest.min(height);
        self.keep(Connection {
            invalid_reason,
            ..leg(ordered((a, b)), path, height, evidence)
        });
        Some([a, b])
    }

    fn join_straight(&mut self, pair: (usize, usize)) {
        if self.roughness() == 0.0 || pair.0 == pair.1 || self.has_leg(pair) {
            return;
        }
        let (from, to) = (self.basin(pair.0), self.basin(pair.1));
        let floor = from.energy.max(to.energy);
        let (space, [a, b]) = (
            self.energy.space(),
            [from, to].map(|basin| basin.coordinates.as_slice()),
        );
        let points = (0..=PARTS).map(|k| interpolate(space, a, b, k as f64 / PARTS as f64));
        let path = Path::through(self.energy, points.collect());
        self.evaluations += PARTS + 1;
        let height = path.height();
        if height <= floor + self.roughness() {
            self.keep(leg(pair, path, height, Evidence::Path));
        }
    }

    fn keep(&mut self, leg: Connection) {
        let pair = (leg.from.0, leg.to.0);
        if pair.1 < self.minima.len() {
            let mut leg = leg;
            if !leg.path.images.is_empty() {
                self.fasten(&mut leg.path, pair);
                let top = &leg.path.images[leg.path.top()];
                let minima = (&self.minima[pair.0], &self.minima[pair.1]);
                leg.edge.term = rising_term(self.energy, top, minima);
                leg.edge.length = leg.path.length(self.energy.space());
            }
            self.take(leg);
            return;
        }
        let known = self.waypoints.legs.get(&pair);
        if known.is_none_or(|known| claim(&leg).beats(claim(known), 0.0, 0.0)) {
            self.waypoints.legs.insert(pair, leg);
        }
    }

    /// Adds the minima themselves where a path ends at other points of their basins, as descents do.
    fn fasten(&self, path: &mut Path, pair: (usize, usize)) {
        let space = self.energy.space();
        for (minimum, first) in [(&self.minima[pair.0], true), (&self.minima[pair.1], false)] {
            let place = if first { 0 } else { path.images.len() - 1 };
            let mut toward = vec![0.0; space.tangents()];
            let mut end = path.images[place].clone();
            if space.log(&end, &minimum.coordinates, &mut toward) > 0.0 {
                space.exp(&mut end, &toward);
                let place = if first { 0 } else { place + 1 };
                path.images.insert(place, end);
                path.energies.insert(place, minimum.energy);
            }
        }
    }

    /// Minima and waypoints, with all connections and legs.
    pub(super) fn whole_network(&self) -> Network {
        let mut network = Network::default();
        for minimum in self.minima.iter().chain(&self.waypoints.minima) {
            network.add_node(bare(minimum));
        }
        for ((a, b), leg) in self.best.iter().chain(&self.waypoints.legs) {
            if leg.edge.height.is_finite() && !leg.path.images.is_empty() {
                let edge = Edge {
                    term: None,
                    ..leg.edge.clone()
                };
                network.add_edge(NodeIndex::new(*a), NodeIndex::new(*b), edge);
            }
        }
        network
    }

    /// Connects minima over waypoints where this joins them lower than they were.
    pub(super) fn join_over_waypoints(&mut self) {
        let (network, minima) = (self.whole_network(), self.minima.len());
        let count = network.node_count();
        let mut forest = spanning_forest(&network, Evidence::Chain);
        forest.sort_by(|a, b| {
            let heights = network[*a].height.total_cmp(&network[*b].height);
            heights.then(a.cmp(b))
        });
        let mut sets = UnionFind::new(count);
        // Whether a set holds a minimum of the map.
        let mut listed: Vec<bool> = (0..count).map(|basin| basin < minima).collect();
        let mut beside: Vec<Vec<usize>> = vec![Vec::new(); count];
        let mut routes = Vec::new();
        for edge in forest {
            let Some((a, b)) = network.edge_endpoints(edge) else {
                continue;
            };
            let (a, b) = (a.index(), b.index());
            let [one, two] = [sets.find(a), sets.find(b)].map(|set| listed[set]);
            if one && two && a.max(b) >= minima {
                let mut route = self.to_minimum(&beside, a);
                route.reverse();
                route.extend(self.to_minimum(&beside, b));
                routes.push(route);
            }
            sets.union(a, b);
            listed[sets.find(a)] = one || two;
            beside[a].push(b);
            beside[b].push(a);
        }
        for route in routes {
            if let Some(connection) = self.over(&route) {
                self.take(connection);
            }
        }
    }

    /// The basins from `start` to the minimum of the map that is nearest in steps, along legs of the forest.
    fn to_minimum(&self, beside: &[Vec<usize>], start: usize) -> Vec<usize> {
        let mut before = BTreeMap::from([(start, start)]);
        let mut queue = VecDeque::from([start]);
        while let Some(basin) = queue.pop_front() {
            if basin < self.minima.len() {
                let mut route = vec![basin];
                let mut last = basin;
                while last != start {
                    last = before[&last];
                    route.push(last);
                }
                route.reverse();
                return route;
            }
            for next in &beside[basin] {
                if !before.contains_key(next) {
                    before.insert(*next, basin);
                    queue.push_back(*next);
                }
            }
        }
        vec![start]
    }

    /// The connection of two minima along `route`. Its height and evidence are those of its highest leg.
    fn over(&self, route: &[usize]) -> Option<Connection> {
        let mut path = Path::default();
        let mut highest: Option<&Connection> = None;
        for step in route.windows(2) {
            let leg = self.leg(ordered((step[0], step[1])))?;
            let part = if step[0] < step[1] {
                leg.path.clone()
            } else {
                leg.path.clone().reversed()
            };
            path.append(&part);
            if highest.is_none_or(|known| leg.edge.height > known.edge.height) {
                highest = Some(leg);
            }
        }
        let (highest, space) = (highest?, self.energy.space());
        let ends = (*route.first()?, *route.last()?);
        if ends.0 > ends.1 {
            path = path.reversed();
        }
        let pair = ordered(ends);
        self.fasten(&mut path, pair);
        path.unfold(space);
        let minima = (&self.minima[pair.0], &self.minima[pair.1]);
        let top = &path.images[path.top()];
        let mut connection = leg(pair, Path::default(), 0.0, highest.edge.evidence);
        connection.edge.height = highest.edge.height.max(path.height());
        connection.edge.term = rising_term(self.energy, top, minima);
        connection.edge.length = path.length(space);
        connection
            .invalid_reason
            .clone_from(&highest.invalid_reason);
        connection.path = path;
        Some(connection)
    }
}

fn leg(pair: (usize, usize), path: Path, height: f64, evidence: Evidence) -> Connection {
    let edge = Edge::bare(height, evidence);
    Connection::new(MinimumId(pair.0), MinimumId(pair.1), edge, path)
}
