//! A mapped landscape: its minima, connections, tree and groups.

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;

use super::barrier::Connection;
use super::groups::Groups;
use super::network::{Evidence, Minimum, MinimumId, Network};
use super::tree::Tree;

/// What was given to [`build_landscape`](super::build_landscape) as a minimum and is none: not finite, not of the energy that the surface has there, or on a
/// slope that changes the energy, over the distance within which two points are one, by more than two minima that are one may
/// differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoMinimum {
    /// Its row among the minima given.
    pub row: usize,
    /// Norm of the gradient there, energy per length (NaN of a point that is not finite).
    pub gradient_norm: f64,
}

/// A mapped landscape.
#[derive(Debug, Clone)]
pub struct Landscape {
    /// Minima (lowest first) and the best connection known of each pair.
    pub network: Network,
    /// What those connections rest on; entry i belongs to edge i of the network.
    pub connections: Vec<Connection>,
    /// Merge tree over every finite connection.
    pub tree: Tree,
    /// Groups, see [`Groups::new`].
    pub groups: Groups,
    /// What was given as a minimum and is none: it has no part in the map.
    pub rejected: Vec<NoMinimum>,
    /// Minima that descents from passes found but the map was not given, lowest first, without members. Add them and map
    /// again for a finer map; merge heights are right without them.
    pub unlisted_minima: Vec<Minimum>,
    /// Trees of resampled chains: see [`support`](super::support()). Empty where no pair has two chains in one direction.
    pub resampled: Vec<Tree>,
    /// Evaluations spent on connections.
    pub evaluations: usize,
}

impl Landscape {
    /// The connection behind a pair of minima, if there is one.
    pub fn connection(&self, a: MinimumId, b: MinimumId) -> Option<&Connection> {
        let edge = self
            .network
            .find_edge(NodeIndex::new(a.0), NodeIndex::new(b.0))?;
        self.connections.get(edge.index())
    }

    /// Number of connections of each evidence, best first.
    pub fn tally(&self) -> BTreeMap<Evidence, usize> {
        let mut tally = BTreeMap::new();
        for edge in self.network.edge_references() {
            *tally.entry(edge.weight().evidence).or_insert(0) += 1;
        }
        tally
    }
}
