//! The way between two minima of a finished landscape.

use std::collections::VecDeque;

use anyhow::ensure;

use crate::energy::Piecewise;
use crate::grasp::GraspEnergy;
use crate::space::{PoseSpace, Space};
use crate::store::{LandscapeFiles, PathRow};
use crate::topography::{Evidence, MinimumId, Network, spanning_forest};

/// A point of a way.
pub(super) struct Place {
    pub(super) x: Vec<f64>,
    /// Metres from the start.
    pub(super) along_m: f64,
    /// The contact set on file; empty where none was recorded.
    recorded: Vec<u32>,
}

impl Place {
    pub(super) fn contacts(&self, energy: &GraspEnergy) -> Vec<u32> {
        if self.recorded.is_empty() {
            energy.active_piece(&self.x)
        } else {
            self.recorded.clone()
        }
    }
}

/// The minima along the way that rises least: it leads along the edges that make the tree.
pub(super) fn route(network: &Network, from: MinimumId, to: MinimumId) -> Option<Vec<MinimumId>> {
    let mut neighbours = vec![Vec::new(); network.node_count()];
    for edge in spanning_forest(network, Evidence::Chain) {
        let (a, b) = network.edge_endpoints(edge)?;
        neighbours[a.index()].push(b.index());
        neighbours[b.index()].push(a.index());
    }
    let mut before = vec![None; network.node_count()];
    let mut queue = VecDeque::from([from.0]);
    before[from.0] = Some(from.0);
    while let Some(at) = queue.pop_front() {
        for &next in &neighbours[at] {
            if before[next].is_none() {
                before[next] = Some(at);
                queue.push_back(next);
            }
        }
    }
    let mut route = vec![to];
    while let Some(&MinimumId(at)) = route.last()
        && at != from.0
    {
        route.push(MinimumId(before[at]?));
    }
    route.reverse();
    Some(route)
}

/// The points of the paths along a route, each turned by the object's symmetry so that it lies next to the one before.
pub(super) fn places(
    files: &LandscapeFiles,
    space: &PoseSpace,
    route: &[MinimumId],
) -> anyhow::Result<Vec<Place>> {
    let mut places: Vec<Place> = Vec::new();
    for pair in route.windows(2) {
        let [a, b] = [pair[0].0 as u64, pair[1].0 as u64];
        let mut rows: Vec<&PathRow> = (files.paths.iter())
            .filter(|row| (row.a, row.b) == (a, b) || (row.a, row.b) == (b, a))
            .collect();
        ensure!(
            rows.len() > 1,
            "the landscape holds no path from m{a} to m{b}"
        );
        rows.sort_by_key(|row| row.image);
        if rows[0].a != a {
            rows.reverse();
        }
        for row in rows {
            let (x, along_m) = match places.last() {
                Some(last) => {
                    let x = space.align(&last.x, &row.coordinates);
                    let length = space.distance(&last.x, &x);
                    (x, last.along_m + length)
                }
                None => (row.coordinates.clone(), 0.0),
            };
            // Where one path ends the next one begins.
            if places
                .last()
                .is_none_or(|last| along_m - last.along_m > 1e-9)
            {
                places.push(Place {
                    x,
                    along_m,
                    recorded: row.choice.clone(),
                });
            }
        }
    }
    Ok(places)
}

#[cfg(test)]
mod tests {
    use petgraph::graph::NodeIndex;

    use super::*;
    use crate::topography::{Edge, Minimum};

    #[test]
    fn the_way_goes_round_a_high_pass() {
        let mut network = Network::default();
        for _ in 0..4 {
            network.add_node(Minimum {
                coordinates: vec![0.0],
                energy: 0.0,
                choice: Vec::new(),
                members: Vec::new(),
            });
        }
        for (a, b, height) in [(0, 2, 9.0), (0, 1, 1.0), (2, 1, 2.0)] {
            let edge = Edge {
                height,
                evidence: Evidence::Path,
                term: None,
                length: 1.0,
            };
            network.add_edge(NodeIndex::new(a), NodeIndex::new(b), edge);
        }
        let ids = |numbers: &[usize]| numbers.iter().copied().map(MinimumId).collect::<Vec<_>>();
        assert_eq!(
            route(&network, MinimumId(2), MinimumId(0)),
            Some(ids(&[2, 1, 0]))
        );
        assert_eq!(route(&network, MinimumId(0), MinimumId(3)), None);
    }
}
