//! Rebuilds the network of a landscape from its tables.

use std::path::Path;

use petgraph::graph::NodeIndex;

use super::error::{Fault, StoreError};
use super::landscape::LandscapeFiles;
use crate::topography::{Edge, Evidence, Minimum, Network};

impl LandscapeFiles {
    /// The network of the tables: node i is row i of the minima, and edge i is row i of the edges. Members are the numbers
    /// of the input points. A pair without a path has infinite height.
    ///
    /// # Errors
    /// If the rows are inconsistent; the error names `folder`.
    pub fn network(&self, folder: &Path) -> Result<Network, StoreError> {
        let mut network = Network::default();
        let row = |file: &str, row: usize, fault: Fault| StoreError::Row {
            path: folder.join(file),
            row,
            fault,
        };
        for (number, minimum) in self.minima.iter().enumerate() {
            if minimum.id != number as u64 {
                let fault = Fault::Unexpected {
                    column: "id".to_owned(),
                    value: minimum.id.to_string(),
                    expected: "the number of the row".to_owned(),
                };
                return Err(row("minima.parquet", number, fault));
            }
            network.add_node(Minimum {
                coordinates: minimum.coordinates.clone(),
                energy: minimum.energy,
                members: (minimum.members.iter())
                    .map(|member| usize::try_from(*member).unwrap_or(usize::MAX))
                    .collect(),
            });
        }
        for (number, edge) in self.edges.iter().enumerate() {
            let end = |column: &str, value: u64| {
                let known = usize::try_from(value).ok();
                let known = known.filter(|id| *id < self.minima.len());
                known.map(NodeIndex::new).ok_or_else(|| {
                    let fault = Fault::Unexpected {
                        column: column.to_owned(),
                        value: value.to_string(),
                        expected: format!("one of the {} minima", self.minima.len()),
                    };
                    row("edges.parquet", number, fault)
                })
            };
            let Some(evidence) = Evidence::named(&edge.evidence) else {
                let fault = Fault::Unexpected {
                    column: "evidence".to_owned(),
                    value: edge.evidence.clone(),
                    expected: "saddle, given, path, chain or none".to_owned(),
                };
                return Err(row("edges.parquet", number, fault));
            };
            let weight = Edge {
                height: edge.height.unwrap_or(f64::INFINITY),
                evidence,
                term: edge.term.clone(),
                length: edge.length.unwrap_or(0.0),
            };
            network.add_edge(end("a", edge.a)?, end("b", edge.b)?, weight);
        }
        Ok(network)
    }
}
