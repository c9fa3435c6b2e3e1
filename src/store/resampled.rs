//! `resampled.parquet`: the trees of resampled chains, from which the support of merges is computed.
//!
//! A row joins two minima at a height: `resampling`, `a`, `b`, `height`. The rows of one resampling form one tree.

use std::path::Path;

use petgraph::graph::NodeIndex;

use super::atomic::AtomicFolder;
use super::columns::Columns;
use super::error::{Fault, StoreError};
use super::landscape::{has_table, read_table, table_head};
use super::table::{FLOAT, WHOLE};
use crate::topography::{Edge, Evidence, Network, Tree};

const RESAMPLED: &str = "resampled.parquet";

/// Writes the merges of `trees`, if there are any trees. Equal trees give equal bytes.
///
/// # Errors
/// If a height is not finite, or the folder cannot be written.
pub fn write_resampled(trees: &[Tree], folder: &AtomicFolder) -> Result<(), StoreError> {
    if trees.is_empty() {
        return Ok(());
    }
    let rows: Vec<(u64, [u64; 2], f64)> = (trees.iter().enumerate())
        .flat_map(|(number, tree)| {
            let merges = merges(tree).into_iter();
            merges.map(move |(ends, height)| (number as u64, ends, height))
        })
        .collect();
    let mut columns = Columns::default();
    columns.wholes("resampling", rows.iter().map(|row| row.0));
    columns.wholes("a", rows.iter().map(|row| row.1[0]));
    columns.wholes("b", rows.iter().map(|row| row.1[1]));
    columns.floats("height", rows.iter().map(|row| row.2));
    let path = folder.path().join(RESAMPLED);
    folder.write(RESAMPLED, &columns.encode(&path, &table_head(RESAMPLED))?)
}

/// For each merge, the first leaf of its first branch with the first leaf of each other branch, and the height.
fn merges(tree: &Tree) -> Vec<([u64; 2], f64)> {
    let mut merges = Vec::new();
    tree.fold(|id, firsts: &[u64]| {
        let Some((first, others)) = firsts.split_first() else {
            return id.0 as u64;
        };
        let height = tree.nodes[id.0].energy;
        merges.extend(others.iter().map(|other| ([*first, *other], height)));
        *first
    });
    merges
}

/// Reads the trees of a finished landscape whose minima are the nodes of `network`. There are none if the folder has no
/// such table.
///
/// # Errors
/// If the table is damaged, altered, or of another landscape, version or set of minima.
pub fn read_resampled(folder: &Path, network: &Network) -> Result<Vec<Tree>, StoreError> {
    let path = folder.join(RESAMPLED);
    if !has_table(folder, RESAMPLED)? {
        return Ok(Vec::new());
    }
    let table = read_table(folder, RESAMPLED)?;
    let resampling = table.required("resampling", &WHOLE)?;
    let ends = [table.required("a", &WHOLE)?, table.required("b", &WHOLE)?];
    let heights = table.required("height", &FLOAT)?;
    let mut bare = Network::default();
    for minimum in network.node_weights() {
        bare.add_node(minimum.clone());
    }
    let mut networks: Vec<Network> = Vec::new();
    let mut last = None;
    for (row, number) in resampling.into_iter().enumerate() {
        if last != Some(number) {
            networks.push(bare.clone());
            last = Some(number);
        }
        let end = |k: usize| {
            let number = usize::try_from(ends[k][row]).ok();
            let known = number.filter(|number| *number < bare.node_count());
            known.map(NodeIndex::new).ok_or_else(|| StoreError::Row {
                path: path.clone(),
                row,
                fault: Fault::Unexpected {
                    column: ["a", "b"][k].to_owned(),
                    value: ends[k][row].to_string(),
                    expected: format!("one of the {} minima", bare.node_count()),
                },
            })
        };
        let edge = Edge {
            height: heights[row],
            evidence: Evidence::Chain,
            term: None,
            length: 0.0,
        };
        let (a, b) = (end(0)?, end(1)?);
        if let Some(network) = networks.last_mut() {
            network.add_edge(a, b, edge);
        }
    }
    let trees = networks.iter();
    Ok(trees
        .map(|network| Tree::from_network(network, Evidence::Chain))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::LandscapeFiles;
    use crate::topography::Minimum;

    #[test]
    fn trees_come_back() {
        let mut network = Network::default();
        for energy in [0.0, 0.1, 0.2, 0.3] {
            network.add_node(Minimum {
                coordinates: Vec::new(),
                energy,
                choice: Vec::new(),
                members: Vec::new(),
            });
        }
        let tree = |edges: &[(usize, usize, f64)]| {
            let mut network = network.clone();
            for (a, b, height) in edges {
                let edge = Edge {
                    height: *height,
                    evidence: Evidence::Chain,
                    term: None,
                    length: 0.0,
                };
                network.add_edge(NodeIndex::new(*a), NodeIndex::new(*b), edge);
            }
            Tree::from_network(&network, Evidence::Chain)
        };
        // A merge of three, a forest, and a ladder.
        let trees = [
            tree(&[(0, 1, 1.0), (1, 2, 1.0), (2, 3, 2.0)]),
            tree(&[(2, 3, 0.5)]),
            tree(&[(3, 2, 0.4), (2, 1, 0.6), (1, 0, 0.7)]),
        ];
        let place = tempfile::tempdir().unwrap();
        let folder = AtomicFolder::open(&place.path().join("a.landscape"), false).unwrap();
        write_resampled(&trees, &folder).unwrap();
        LandscapeFiles::default().write(&folder).unwrap();
        assert_eq!(read_resampled(folder.path(), &network).unwrap(), trees);
        // Of other minima.
        network.remove_node(NodeIndex::new(3));
        let error = read_resampled(folder.path(), &network).unwrap_err();
        assert!(error.to_string().contains("one of the 3 minima"), "{error}");
        // The manifest lists the table, so it cannot go unnoticed.
        std::fs::remove_file(folder.path().join(RESAMPLED)).unwrap();
        let error = read_resampled(folder.path(), &network).unwrap_err();
        assert!(error.to_string().starts_with("no such file"), "{error}");
    }
}
