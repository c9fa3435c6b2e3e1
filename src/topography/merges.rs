//! The connections that make the merges of a tree, and the minimax path between two minima.

use std::collections::BTreeSet;

use petgraph::algo::astar;
use petgraph::graph::NodeIndex;
use petgraph::unionfind::UnionFind;
use petgraph::visit::{EdgeFiltered, EdgeRef};

use super::landscape::Landscape;
use super::network::{Evidence, MinimumId, Network};
use super::tree::spanning_forest;

/// A merge of two branches of a tree, and the connection that makes it. A node with n branches counts as n − 1 merges.
#[derive(Debug, Clone, PartialEq)]
pub struct Merge {
    /// The minima that the connection joins.
    pub ends: [MinimumId; 2],
    /// The lowest minimum of the shallower branch.
    pub shallower: MinimumId,
    /// Height of the connection.
    pub height: f64,
    /// Height above the lowest minimum of the shallower branch.
    pub depth: f64,
    /// Evidence of the connection.
    pub evidence: Evidence,
    /// The energy term that rises most along the connection.
    pub term: Option<String>,
}

impl Landscape {
    /// The merges of the tree, sorted by height. Minima are numbered by energy.
    pub fn merges(&self) -> Vec<Merge> {
        let network = &self.network;
        let mut edges = spanning_forest(network, Evidence::Chain);
        edges.sort_by(|a, b| {
            let heights = network[*a].height.total_cmp(&network[*b].height);
            heights.then(a.cmp(b))
        });
        let mut lowest: Vec<usize> = (0..network.node_count()).collect();
        let mut sets = UnionFind::new(lowest.len());
        let merge = |edge| {
            let (a, b) = network.edge_endpoints(edge)?;
            let [one, two] = [a, b].map(|end| lowest[sets.find(end.index())]);
            sets.union(one, two);
            lowest[sets.find(one)] = one.min(two);
            let (shallower, connection) = (one.max(two), &network[edge]);
            Some(Merge {
                ends: [a, b].map(|end| MinimumId(end.index())),
                shallower: MinimumId(shallower),
                height: connection.height,
                depth: connection.height - network[NodeIndex::new(shallower)].energy,
                evidence: connection.evidence,
                term: connection.term.clone(),
            })
        };
        edges.into_iter().filter_map(merge).collect()
    }
}

/// The minima along the path with the lowest highest point between two minima; `None` if nothing joins the two.
///
/// # Panics
/// If a minimum is not in the network.
pub fn minimax_path(network: &Network, from: MinimumId, to: MinimumId) -> Option<Vec<MinimumId>> {
    let forest: BTreeSet<_> = spanning_forest(network, Evidence::Chain)
        .into_iter()
        .collect();
    let forest = EdgeFiltered::from_fn(network, |edge| forest.contains(&edge.id()));
    let [from, to] = [from, to].map(|id| NodeIndex::new(id.0));
    let (_, path) = astar(&forest, from, |at| at == to, |_| 1_usize, |_| 0)?;
    Some(path.into_iter().map(|at| MinimumId(at.index())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::tree::tests::network;

    #[test]
    fn the_path_goes_round_a_high_pass() {
        let connections = [(0, 2, 9.0), (0, 1, 1.0), (2, 1, 2.0)];
        let connections = connections.map(|(a, b, height)| (a, b, height, Evidence::Path));
        let network = network(&[0.0; 4], &connections);
        let path = minimax_path(&network, MinimumId(2), MinimumId(0));
        assert_eq!(path, Some([2, 1, 0].map(MinimumId).to_vec()));
        assert_eq!(minimax_path(&network, MinimumId(0), MinimumId(3)), None);
    }
}
