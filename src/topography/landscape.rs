//! A mapped landscape: its minima, connections, tree and families.

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;

use super::barrier::Connection;
use super::families::Families;
use super::network::{Evidence, Minimum, MinimumId, Network};
use super::support::Attempts;
use super::tree::Tree;

/// A point that was given to [`build_landscape`](super::build_landscape) as a minimum but is none. Either it is not finite,
/// or its energy is not that of the surface, or the gradient times the distance tolerance exceeds the energy tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoMinimum {
    /// Its row among the given minima.
    pub row: usize,
    /// Norm of the gradient there, energy per length (NaN if the point is not finite).
    pub gradient_norm: f64,
}

/// A mapped landscape.
#[derive(Debug, Clone)]
pub struct Landscape {
    /// Minima (lowest first) and the best known connection of each pair.
    pub network: Network,
    /// Details of those connections; entry i belongs to edge i of the network.
    pub connections: Vec<Connection>,
    /// Merge tree over every finite connection.
    pub tree: Tree,
    /// Families, see [`Families::new`].
    pub families: Families,
    /// Given points that are no minima; they are not in the map.
    pub rejected: Vec<NoMinimum>,
    /// Minima found by descents from passes but not given, lowest first, without members. Merge heights are right without
    /// them; mapping again with them gives a finer map.
    pub unlisted_minima: Vec<Minimum>,
    /// All searches and geodesics that were tried, from which the support of merges follows.
    pub attempts: Attempts,
    /// Evaluations spent on connections.
    pub evaluations: usize,
}

impl Landscape {
    /// The connection between two minima, if there is one.
    pub fn connection(&self, a: MinimumId, b: MinimumId) -> Option<&Connection> {
        let edge = self
            .network
            .find_edge(NodeIndex::new(a.0), NodeIndex::new(b.0))?;
        self.connections.get(edge.index())
    }

    /// Number of connections with each kind of evidence, best first.
    pub fn tally(&self) -> BTreeMap<Evidence, usize> {
        let mut tally = BTreeMap::new();
        for edge in self.network.edge_references() {
            *tally.entry(edge.weight().evidence).or_insert(0) += 1;
        }
        tally
    }
}
