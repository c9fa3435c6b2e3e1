//! The exact merge tree (disconnectivity graph) of a [`Network`](super::Network).

use serde::{Deserialize, Serialize};

use super::network::{Evidence, MinimumId};

/// Number of a node in [`Tree::nodes`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct NodeId(pub usize);

/// A leaf (one minimum) or a merge of two or more subtrees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Node {
    /// Energy of the minimum, or height of the pass at which the children merge.
    pub energy: f64,
    /// The minimum of a leaf.
    pub minimum: Option<MinimumId>,
    /// Subtrees merged here, empty for a leaf.
    pub children: Vec<NodeId>,
    /// The merge above; `None` for a root.
    pub parent: Option<NodeId>,
    /// Worst evidence among the connections that make this merge; [`Evidence::Saddle`] for a leaf.
    pub evidence: Evidence,
}

/// A forest: one root per connected component. Leaves come first, node i being minimum i; merges follow by rising
/// height, so a parent always has a larger number than its children.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Tree {
    /// Leaves, then merges.
    pub nodes: Vec<Node>,
    /// Nodes without parent.
    pub roots: Vec<NodeId>,
}
