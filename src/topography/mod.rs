//! Half two: maps any energy. Minima, paths between them, barriers, the tree.

mod network;
mod tree;

pub use network::{Edge, Evidence, Minimum, MinimumId, Network};
pub use tree::{Node, NodeId, Tree};
