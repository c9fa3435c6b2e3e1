//! Views of the network behind a tree: monotonic sequences, and connections through hidden minima.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::graph::NodeIndex;
use petgraph::unionfind::UnionFind;
use petgraph::visit::EdgeRef;

use crate::topography::network::{Edge, Evidence, Minimum, MinimumId, Network};
use crate::topography::tree::decisive;

/// The minima at the bottoms of monotonic sequences: those from which no connection of evidence `worst` or better leads
/// to a lower minimum (at equal energies to one of lower number). `MONOTONIC` of disconnectionDPS keeps these.
///
/// A monotonic sequence goes from minimum to minimum with falling energy; every minimum is on one that ends in a bottom.
/// R. S. Berry and R. Breitengraser-Kunz, Phys. Rev. Lett. 74, 3951 (1995).
pub fn bottoms(network: &Network, worst: Evidence) -> Vec<MinimumId> {
    let mut bottom = vec![true; network.node_count()];
    for edge in network.edge_references() {
        let weight = edge.weight();
        if weight.evidence > worst || !weight.height.is_finite() || edge.source() == edge.target() {
            continue;
        }
        let (a, b) = (edge.source(), edge.target());
        let order = network[a]
            .energy
            .total_cmp(&network[b].energy)
            .then(a.cmp(&b));
        let higher = if order.is_lt() { b } else { a };
        bottom[higher.index()] = false;
    }
    (0..bottom.len())
        .filter(|minimum| bottom[*minimum])
        .map(MinimumId)
        .collect()
}

/// The network of the minima `kept`, node i being `kept[i]`: their own connections, and one for each merge that leads
/// through hidden minima, so that the merge tree of the result is that of the whole restricted to `kept`.
///
/// A connection through hidden minima joins, of either side, the kept minimum that is nearest along the spanning tree of
/// lowest passes; height, evidence and term are those of the pass that decides, the length that of the whole way. Where
/// two kept minima have both, the lower one stays. Connections of evidence worse than `worst` join nothing.
///
/// # Panics
/// If `kept` names a minimum twice, or one that is not in the network.
pub fn restricted(network: &Network, kept: &[MinimumId], worst: Evidence) -> Network {
    let mut place = vec![None; network.node_count()];
    let mut shown = Network::default();
    for minimum in kept {
        let node = shown.add_node(network[NodeIndex::new(minimum.0)].clone());
        assert!(
            place[minimum.0].replace(node).is_none(),
            "m{} twice",
            minimum.0
        );
    }
    let mut edges: BTreeMap<[NodeIndex; 2], Edge> = BTreeMap::new();
    let mut offer = |a: NodeIndex, b: NodeIndex, edge: Edge| {
        let pair = [a.min(b), a.max(b)];
        let better = edges
            .get(&pair)
            .is_none_or(|known| edge.height.total_cmp(&known.height).is_lt());
        if better {
            edges.insert(pair, edge);
        }
    };
    for edge in network.edge_references() {
        if let (Some(a), Some(b)) = (place[edge.source().index()], place[edge.target().index()]) {
            offer(a, b, edge.weight().clone());
        }
    }
    let mut forest = Forest::new(network.node_count(), &place);
    for edge in decisive(network, worst) {
        let Some((a, b)) = network.edge_endpoints(edge) else {
            continue;
        };
        let weight = &network[edge];
        if let Some([(from, before), (to, after)]) =
            forest.join(a.index(), b.index(), weight.length)
            && let (Some(one), Some(other)) = (place[from], place[to])
        {
            let floor = network[a].energy.max(network[b].energy);
            let length = before + weight.length + after;
            let height = weight.height.max(floor);
            offer(
                one,
                other,
                Edge {
                    height,
                    length,
                    ..weight.clone()
                },
            );
        }
    }
    for ([a, b], edge) in edges {
        shown.add_edge(a, b, edge);
    }
    shown
}

/// A spanning forest that grows by the lowest pass.
struct Forest<'a> {
    kept: &'a [Option<NodeIndex>],
    sets: UnionFind<usize>,
    /// Whether a set holds a kept minimum, by its representative.
    holds: Vec<bool>,
    neighbours: Vec<Vec<(usize, f64)>>,
}

impl<'a> Forest<'a> {
    fn new(count: usize, kept: &'a [Option<NodeIndex>]) -> Self {
        Self {
            kept,
            sets: UnionFind::new(count),
            holds: kept.iter().map(Option::is_some).collect(),
            neighbours: vec![Vec::new(); count],
        }
    }

    /// Joins two trees by an edge; the kept minima nearest to its ends, with their distances, if both trees hold any.
    fn join(&mut self, a: usize, b: usize, length: f64) -> Option<[(usize, f64); 2]> {
        let sets = [a, b].map(|node| self.sets.find(node));
        let both = sets.map(|set| self.holds[set]);
        let nearest = [a, b].map(|node| self.nearest(node));
        self.sets.union(a, b);
        let set = self.sets.find(a);
        self.holds[set] = both[0] || both[1];
        self.neighbours[a].push((b, length));
        self.neighbours[b].push((a, length));
        match nearest {
            [Some(one), Some(other)] => Some([one, other]),
            _ => None,
        }
    }

    /// The kept minimum nearest to `start` along its tree (at equal distances the one of lower number).
    fn nearest(&self, start: usize) -> Option<(usize, f64)> {
        if !self.holds[self.sets.find(start)] {
            return None;
        }
        let mut best: Option<(usize, f64)> = None;
        let mut stack = vec![(start, 0.0)];
        let mut seen = BTreeSet::from([start]);
        while let Some((node, distance)) = stack.pop() {
            let nearer = |known: (usize, f64)| (distance, node) < (known.1, known.0);
            if self.kept[node].is_some() {
                // Whatever lies behind a kept minimum is farther.
                if best.is_none_or(nearer) {
                    best = Some((node, distance));
                }
                continue;
            }
            for &(next, length) in &self.neighbours[node] {
                if seen.insert(next) {
                    stack.push((next, distance + length));
                }
            }
        }
        best
    }
}

/// Groups of minima as the minima of a network: minimum i goes to group `group_of[i]`, groups count from 0. A group has
/// the energy and the coordinates of its lowest minimum and the members of all; of the connections between two groups the
/// lowest stays (at equal heights the one of best evidence).
///
/// # Panics
/// If `group_of` has not one entry a minimum, or a group has none.
pub fn grouped(network: &Network, group_of: &[usize]) -> Network {
    assert_eq!(group_of.len(), network.node_count(), "one group a minimum");
    let mut minima: BTreeMap<usize, Minimum> = BTreeMap::new();
    for (minimum, group) in network.node_weights().zip(group_of) {
        let Some(known) = minima.get_mut(group) else {
            minima.insert(*group, minimum.clone());
            continue;
        };
        let mut members = std::mem::take(&mut known.members);
        members.extend(&minimum.members);
        members.sort_unstable();
        if minimum.energy < known.energy {
            *known = minimum.clone();
        }
        known.members = members;
    }
    let mut groups = Network::default();
    for (number, (group, minimum)) in minima.into_iter().enumerate() {
        assert_eq!(number, group, "groups count from 0");
        groups.add_node(minimum);
    }
    let mut edges: BTreeMap<[usize; 2], &Edge> = BTreeMap::new();
    for edge in network.edge_references() {
        let [a, b] = [edge.source(), edge.target()].map(|end| group_of[end.index()]);
        if a == b {
            continue;
        }
        let known = edges.entry([a.min(b), a.max(b)]).or_insert(edge.weight());
        let order = edge.weight().height.total_cmp(&known.height);
        if order
            .then(edge.weight().evidence.cmp(&known.evidence))
            .is_lt()
        {
            *known = edge.weight();
        }
    }
    for ([a, b], edge) in edges {
        groups.add_edge(NodeIndex::new(a), NodeIndex::new(b), edge.clone());
    }
    groups
}
