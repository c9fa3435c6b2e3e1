//! Converts the result of a search into a network and its tree.

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;

use super::{Exploration, TransitionState};
use crate::energy::Energy;
use crate::topography::barrier::{Connection, Crossing, rising_term};
use crate::topography::families::{Families, FamilySettings};
use crate::topography::landscape::Landscape;
use crate::topography::network::{Edge, Evidence, MinimumId, Network};
use crate::topography::support::Attempts;
use crate::topography::tree::Tree;

impl Exploration {
    /// The network of minima and *all* saddles; edge i is saddle i. Several saddles between one pair give several edges,
    /// and a degenerate rearrangement gives a loop.
    pub fn network(&self, energy: &dyn Energy) -> Network {
        let mut network = self.nodes();
        for saddle in &self.saddles {
            let [from, to] = saddle.ends.map(|end| NodeIndex::new(end.0));
            network.add_edge(from, to, self.edge(energy, saddle));
        }
        network
    }

    /// The landscape with the lowest saddle of each pair, the bounds between minima that no saddles join, the merge tree, and
    /// families.
    pub fn landscape(&self, energy: &dyn Energy, families: &FamilySettings) -> Landscape {
        let mut pairs: BTreeMap<[MinimumId; 2], Vec<&TransitionState>> = BTreeMap::new();
        for saddle in self
            .saddles
            .iter()
            .filter(|saddle| saddle.ends[0] != saddle.ends[1])
        {
            pairs.entry(saddle.ends).or_default().push(saddle);
        }
        let mut network = self.nodes();
        let mut connections = Vec::with_capacity(pairs.len());
        for ([from, to], saddles) in pairs {
            // Saddles are sorted by energy.
            let lowest = saddles[0];
            let edge = self.edge(energy, lowest);
            network.add_edge(NodeIndex::new(from.0), NodeIndex::new(to.0), edge.clone());
            let mut path = lowest.path.clone();
            // The points of a descent follow each other, so no copy of a cluster is nearer than the next point.
            path.follow(energy.space());
            connections.push(Connection {
                from,
                to,
                edge,
                path,
                forward: Vec::new(),
                backward: Vec::new(),
                start: None,
                invalid_reason: energy.invalid_reason(&lowest.coordinates),
                crossings: saddles.into_iter().map(Crossing::from).collect(),
                evaluations: 0,
            });
        }
        for bound in &self.bounds {
            let ends = [bound.from, bound.to].map(|end| NodeIndex::new(end.0));
            network.add_edge(ends[0], ends[1], bound.edge.clone());
            connections.push(bound.clone());
        }
        let tree = Tree::from_network(&network, Evidence::Chain);
        let further = self.further.as_ref();
        Landscape {
            attempts: further.map_or_else(Attempts::default, |further| further.verified(&tree)),
            tree,
            families: Families::new(&network, families),
            network,
            connections,
            rejected: Vec::new(),
            unlisted_minima: Vec::new(),
            evaluations: self.evaluations,
        }
    }

    fn nodes(&self) -> Network {
        let mut network = Network::default();
        for minimum in &self.minima {
            network.add_node(minimum.clone());
        }
        network
    }

    fn edge(&self, energy: &dyn Energy, saddle: &TransitionState) -> Edge {
        let [from, to] = saddle.ends.map(|end| &self.minima[end.0]);
        Edge {
            height: saddle.energy,
            evidence: match energy.invalid_reason(&saddle.coordinates) {
                Some(_) => Evidence::Chain,
                None => Evidence::Saddle,
            },
            term: rising_term(energy, &saddle.coordinates, (from, to)),
            length: saddle.path.length(energy.space()),
        }
    }
}

impl From<&TransitionState> for Crossing {
    fn from(saddle: &TransitionState) -> Self {
        Self {
            pass: saddle.top,
            evidence: Evidence::Saddle,
            path: saddle.path.clone(),
        }
    }
}
