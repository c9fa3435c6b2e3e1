//! Views of a network: monotonic sequences, and connections through hidden minima.

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;

use crate::topography::network::{Edge, Evidence, Minimum, MinimumId, Network};
use crate::topography::tree::spanning_forest;

/// The minima at the bottom of monotonic sequences: no connection with evidence `worst` or better leads from them to a
/// lower minimum (at equal energy, to a lower number). `MONOTONIC` of disconnectionDPS keeps these.
///
/// A monotonic sequence goes from minimum to minimum with falling energy. Every minimum is on one. R. S. Berry and R.
/// Breitengraser-Kunz, Phys. Rev. Lett. 74, 3951 (1995).
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

/// The network of the minima `kept`, where node i is `kept[i]`. It has their own connections and one for each merge through
/// hidden minima, so its merge tree is that of the whole restricted to `kept`.
///
/// A connection through hidden minima joins the kept minima that are nearest on either side along the spanning tree of
/// lowest passes. Its height, evidence and term are those of the deciding pass, and its length is that of the whole way. If
/// two kept minima have both, the lower one is used. Connections with weaker evidence than `worst` are ignored.
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
    for edge in spanning_forest(network, worst) {
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

struct Forest<'a> {
    kept: &'a [Option<NodeIndex>],
    neighbours: Vec<Vec<(usize, f64)>>,
    /// The nearest kept minimum along the tree of each minimum, with its distance; the lower number if equally near.
    nearest: Vec<Option<(f64, usize)>>,
}

impl<'a> Forest<'a> {
    fn new(count: usize, kept: &'a [Option<NodeIndex>]) -> Self {
        let nearest = kept.iter().enumerate();
        Self {
            kept,
            neighbours: vec![Vec::new(); count],
            nearest: nearest
                .map(|(node, kept)| kept.map(|_| (0.0, node)))
                .collect(),
        }
    }

    /// Joins two trees by an edge. Returns the kept minima nearest to its ends, with distances, if both trees have one.
    fn join(&mut self, a: usize, b: usize, length: f64) -> Option<[(usize, f64); 2]> {
        let found = [a, b].map(|node| self.nearest[node]);
        self.neighbours[a].push((b, length));
        self.neighbours[b].push((a, length));
        for (end, other) in [(a, found[1]), (b, found[0])] {
            self.offer(end, other.map(|(distance, kept)| (distance + length, kept)));
        }
        match found {
            [Some(one), Some(other)] => Some([one, other].map(|(distance, kept)| (kept, distance))),
            _ => None,
        }
    }

    /// Offers a kept minimum at a given distance to `start` and beyond, up to nodes that know a nearer one.
    fn offer(&mut self, start: usize, candidate: Option<(f64, usize)>) {
        let Some((distance, found)) = candidate else {
            return;
        };
        let mut rest = vec![(start, distance)];
        while let Some((node, distance)) = rest.pop() {
            let nearer = |known: (f64, usize)| {
                (distance.total_cmp(&known.0))
                    .then(found.cmp(&known.1))
                    .is_lt()
            };
            if self.kept[node].is_some() || !self.nearest[node].is_none_or(nearer) {
                continue;
            }
            self.nearest[node] = Some((distance, found));
            for &(next, length) in &self.neighbours[node] {
                rest.push((next, distance + length));
            }
        }
    }
}

/// The network of families: minimum i is in family `family_of[i]`, counted from 0. A family has the energy and coordinates of
/// its lowest minimum and the members of all. Between two families the lowest connection is kept (then the best evidence).
///
/// # Panics
/// If `family_of` does not have one entry for each minimum, or a family is empty.
pub fn network_of_families(network: &Network, family_of: &[usize]) -> Network {
    assert_eq!(
        family_of.len(),
        network.node_count(),
        "one family a minimum"
    );
    let count = family_of.iter().max().map_or(0, |largest| largest + 1);
    let mut minima: Vec<Vec<&Minimum>> = vec![Vec::new(); count];
    for (minimum, family) in network.node_weights().zip(family_of) {
        minima[*family].push(minimum);
    }
    let mut families = Network::default();
    for minima in minima {
        // Of equally low minima the first is used.
        let lowest = minima.iter().min_by(|a, b| a.energy.total_cmp(&b.energy));
        let lowest = *lowest.expect("no family is empty");
        let mut members: Vec<usize> = minima
            .iter()
            .flat_map(|minimum| &minimum.members)
            .copied()
            .collect();
        if minima.len() > 1 {
            members.sort_unstable();
        }
        families.add_node(Minimum {
            coordinates: lowest.coordinates.clone(),
            energy: lowest.energy,
            members,
        });
    }
    let mut edges: BTreeMap<[usize; 2], &Edge> = BTreeMap::new();
    for edge in network.edge_references() {
        let [a, b] = [edge.source(), edge.target()].map(|end| family_of[end.index()]);
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
        families.add_edge(NodeIndex::new(a), NodeIndex::new(b), edge.clone());
    }
    families
}
