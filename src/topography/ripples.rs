//! Minima that only ripples divide are one: they are merged before anything is counted.

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;
use petgraph::unionfind::UnionFind;

use super::barrier::{Connection, Start};
use super::build::claim;
use super::merges::minimax_path;
use super::network::{Evidence, Minimum, MinimumId, Network};
use super::pairs::{Distances, candidates};
use super::path::Path;
use super::support::Attempt;
use super::tree::spanning_forest;
use crate::space::Space;

/// For each minimum the lowest minimum of its basin. A basin that lies less than `roughness` below its lowest pass belongs
/// to the basin on the other side of this pass.
///
/// This is the simplification of a merge tree by persistence (H. Edelsbrunner, D. Letscher and A. Zomorodian, Discrete
/// Comput. Geom. 28, 511 (2002)).
pub(super) fn basins(network: &Network, roughness: f64) -> Vec<usize> {
    let count = network.node_count();
    let mut edges = spanning_forest(network, Evidence::Chain);
    edges.sort_by(|a, b| {
        let heights = network[*a].height.total_cmp(&network[*b].height);
        heights.then(a.cmp(b))
    });
    let (mut branches, mut basins) = (UnionFind::new(count), UnionFind::new(count));
    // Minima are sorted by energy.
    let mut lowest: Vec<usize> = (0..count).collect();
    for edge in edges {
        let Some((a, b)) = network.edge_endpoints(edge) else {
            continue;
        };
        let [one, two] = [a, b].map(|end| lowest[branches.find(end.index())]);
        let depth = network[edge].height - network[NodeIndex::new(one.max(two))].energy;
        if depth <= roughness {
            basins.union(a.index(), b.index());
        }
        branches.union(a.index(), b.index());
        lowest[branches.find(a.index())] = one.min(two);
    }
    let labels = basins.into_labeling();
    let mut least: Vec<Option<usize>> = vec![None; count];
    labels
        .iter()
        .enumerate()
        .map(|(i, label)| *least[*label].get_or_insert(i))
        .collect()
}

/// Pairs of minima of near basins, the nearest of each two basins; see [`candidates`].
pub(super) fn between(
    distances: &dyn Distances,
    basins: &[usize],
    neighbours: usize,
) -> Vec<(usize, usize)> {
    let (lowest, place) = numbered(basins);
    let mut members = vec![Vec::new(); lowest.len()];
    for (i, basin) in place.iter().enumerate() {
        members[*basin].push(i);
    }
    let between = BetweenBasins { distances, members };
    let pairs = candidates(&between, neighbours).into_iter();
    pairs
        .filter_map(|(a, b)| Some(between.nearest(a, b)?.0))
        .collect()
}

/// Distances of basins: of their nearest minima.
struct BetweenBasins<'a> {
    distances: &'a dyn Distances,
    /// Minima of each basin, ascending.
    members: Vec<Vec<usize>>,
}

impl BetweenBasins<'_> {
    /// The nearest minima of two basins and their distance; of equal ones those with the lowest numbers.
    fn nearest(&self, a: usize, b: usize) -> Option<((usize, usize), f64)> {
        let mut best: Option<((usize, usize), f64)> = None;
        for pair in self.pairs(a, b) {
            let least = self.distances.least(pair.0, pair.1);
            if best.is_some_and(|(_, known)| least > known) {
                continue;
            }
            let here = (pair, self.distances.between(pair.0, pair.1));
            let nearer = |(other, known): &((usize, usize), f64)| {
                here.1.total_cmp(known).then(pair.cmp(other)).is_lt()
            };
            if best.as_ref().is_none_or(nearer) {
                best = Some(here);
            }
        }
        best
    }

    /// The pairs of minima of two basins.
    fn pairs(&self, a: usize, b: usize) -> impl Iterator<Item = (usize, usize)> {
        self.members[a].iter().flat_map(move |i| {
            let others = self.members[b].iter();
            others.map(move |j| (*i.min(j), *i.max(j)))
        })
    }
}

impl Distances for BetweenBasins<'_> {
    fn len(&self) -> usize {
        self.members.len()
    }

    fn between(&self, a: usize, b: usize) -> f64 {
        self.nearest(a, b).map_or(f64::INFINITY, |(_, least)| least)
    }

    fn least(&self, a: usize, b: usize) -> f64 {
        let pairs = self.pairs(a, b);
        pairs
            .map(|(i, j)| self.distances.least(i, j))
            .fold(f64::INFINITY, f64::min)
    }
}

/// The lowest minimum of each basin, ascending, and the number of the basin of each minimum.
fn numbered(basins: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let lowest: Vec<usize> = (0..basins.len()).filter(|i| basins[*i] == *i).collect();
    let place = |basin: &usize| lowest.partition_point(|known| known < basin);
    let place = basins.iter().map(place).collect();
    (lowest, place)
}

/// Minima, connections and attempts of a map.
pub(super) struct Parts {
    pub(super) minima: Vec<Minimum>,
    pub(super) best: BTreeMap<(usize, usize), Connection>,
    pub(super) attempts: Vec<Attempt>,
}

/// The map of whole basins. Of the connections between two basins the best one is kept; its path begins and ends in the
/// lowest minima of the basins.
pub(super) fn merged(
    space: &dyn Space,
    network: &Network,
    parts: Parts,
    basins: &[usize],
) -> Parts {
    let (lowest, place) = numbered(basins);
    let Parts {
        minima,
        best,
        attempts,
    } = parts;
    let mut whole: Vec<Minimum> = lowest.iter().map(|i| minima[*i].clone()).collect();
    for (i, minimum) in minima.iter().enumerate() {
        if basins[i] != i {
            whole[place[i]].members.extend_from_slice(&minimum.members);
        }
    }
    for minimum in &mut whole {
        minimum.members.sort_unstable();
        minimum.members.dedup();
    }
    let mut chosen: BTreeMap<(usize, usize), (usize, usize)> = BTreeMap::new();
    for (pair, connection) in &best {
        let ends = (place[pair.0], place[pair.1]);
        if ends.0 == ends.1 {
            continue;
        }
        let ends = (ends.0.min(ends.1), ends.0.max(ends.1));
        let known = chosen.get(&ends).map(|known| claim(&best[known]));
        if known.is_none_or(|known| claim(connection).beats(known, 0.0, 0.0)) {
            chosen.insert(ends, *pair);
        }
    }
    let lead = |from: usize, to: usize| ripple_path(network, &best, from, to);
    let between = |(ends, pair): (&(usize, usize), &(usize, usize))| {
        let mut connection = best[pair].clone();
        let pair = if place[pair.0] == ends.0 {
            *pair
        } else {
            connection = reversed(connection);
            (pair.1, pair.0)
        };
        let mut path = lead(lowest[ends.0], pair.0);
        path.append(&connection.path);
        path.append(&lead(pair.1, lowest[ends.1]));
        path.unfold(space);
        connection.from = MinimumId(ends.0);
        connection.to = MinimumId(ends.1);
        if connection.edge.height.is_finite() {
            connection.edge.height = connection.edge.height.max(path.height());
            connection.edge.length = path.length(space);
            connection.path = path;
        }
        (*ends, connection)
    };
    let joined: BTreeMap<_, _> = chosen.iter().map(between).collect();
    let between_basins = |mut attempt: Attempt| {
        let (from, to) = (place[attempt.from.0], place[attempt.to.0]);
        if from > to
            && let Start::Chain { backward, .. } = &mut attempt.start
        {
            *backward = !*backward;
        }
        (attempt.from, attempt.to) = (MinimumId(from.min(to)), MinimumId(from.max(to)));
        (from != to).then_some(attempt)
    };
    Parts {
        minima: whole,
        best: joined,
        attempts: attempts.into_iter().filter_map(between_basins).collect(),
    }
}

fn reversed(mut connection: Connection) -> Connection {
    connection.path = connection.path.reversed();
    if let Some(Start::Chain { backward, .. }) = &mut connection.start {
        *backward = !*backward;
    }
    connection
}

/// The path between two minima of a basin.
fn ripple_path(
    network: &Network,
    best: &BTreeMap<(usize, usize), Connection>,
    from: usize,
    to: usize,
) -> Path {
    let mut path = Path::default();
    if from == to {
        return path;
    }
    let route = minimax_path(network, MinimumId(from), MinimumId(to)).unwrap_or_default();
    for step in route.windows(2) {
        let (a, b) = (step[0].0, step[1].0);
        if let Some(known) = best.get(&(a.min(b), a.max(b))) {
            let part = known.path.clone();
            path.append(&if a < b { part } else { part.reversed() });
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::tree::tests::network;

    #[test]
    fn shallow_basins_belong_to_deep_ones() {
        let edge = |a, b, height| (a, b, height, Evidence::Path);
        // 0 and 1 are divided by a ripple, 3 is a shoulder above 2, and 4 stands apart.
        let energies = [0.0, 0.001, 0.1, 0.2, 0.3];
        let edges = [
            edge(0, 1, 0.004),
            edge(1, 2, 0.25),
            edge(2, 3, 0.203),
            edge(3, 4, 0.4),
        ];
        let network = network(&energies, &edges);
        assert_eq!(basins(&network, 0.005), [0, 0, 2, 2, 4]);
        assert_eq!(basins(&network, 0.0), [0, 1, 2, 3, 4]);
        let distances: Vec<Vec<f64>> = (0..5_i32)
            .map(|i| (0..5).map(|j| f64::from((i - j).abs())).collect())
            .collect();
        assert_eq!(
            between(&distances, &[0, 0, 2, 2, 4], 1),
            [(1, 2), (3, 4)],
            "the nearest minima of two basins"
        );
    }
}
