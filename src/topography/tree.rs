//! The exact merge tree (disconnectivity graph) of a [`Network`].

use std::collections::BTreeMap;

use petgraph::graph::EdgeIndex;
use petgraph::unionfind::UnionFind;
use petgraph::visit::{EdgeRef, IntoNodeReferences};
use serde::{Deserialize, Serialize};

use super::network::{Evidence, MinimumId, Network};

/// Relative height difference below which heights tie: two refinements of one saddle differ by rounding only.
const TIE: f64 = 1e-8;

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

/// A forest with one root for each connected component. Leaves come first (node i is minimum i), and merges follow by
/// height, so a parent has a larger number than its children.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Tree {
    /// Leaves, then merges.
    pub nodes: Vec<Node>,
    /// Nodes without parent.
    pub roots: Vec<NodeId>,
}

impl Tree {
    /// Merge tree of the finite connections with evidence `worst` or better: Kruskal's spanning forest, in which merges at
    /// (nearly) the same height form one node with several children. Among connections that tie, the one with the best
    /// evidence decides. O(E log E) for E connections.
    pub fn from_network(network: &Network, worst: Evidence) -> Self {
        let mut nodes: Vec<Node> = network
            .node_references()
            .map(|(node, minimum)| Node {
                energy: minimum.energy,
                minimum: Some(MinimumId(node.index())),
                children: Vec::new(),
                parent: None,
                evidence: Evidence::Saddle,
            })
            .collect();
        let leaves = nodes.len();
        let mut sets = UnionFind::new(leaves);
        // For each set (by its representative), the subtree at its top.
        let mut top: Vec<usize> = (0..leaves).collect();
        // Which subtrees belong together. Once joined, a subtree has a parent and is never again at the top of a set.
        let mut families = UnionFind::new(2 * leaves);
        for level in levels(network, worst) {
            let mut used = Vec::new();
            for link in level {
                let ends = link.ends.map(|end| top[sets.find(end)]);
                if families.union(ends[0], ends[1]) {
                    used.push((ends, link));
                }
            }
            for (_, link) in &used {
                sets.union(link.ends[0], link.ends[1]);
            }
            for (leaf, merge) in merges_of(&used, &families) {
                let id = nodes.len();
                for child in &merge.children {
                    nodes[child.0].parent = Some(NodeId(id));
                }
                top[sets.find(leaf)] = id;
                nodes.push(merge);
            }
        }
        let roots = (0..nodes.len())
            .filter(|node| nodes[*node].parent.is_none())
            .map(NodeId)
            .collect();
        Self { nodes, roots }
    }

    /// Computes a value for each node from the leaves up, from the values of its branches (none for a leaf).
    pub fn fold<T: Clone>(&self, mut value: impl FnMut(NodeId, &[T]) -> T) -> Vec<T> {
        let mut values: Vec<T> = Vec::with_capacity(self.nodes.len());
        for (id, node) in self.nodes.iter().enumerate() {
            let branches = node.children.iter().map(|child| values[child.0].clone());
            let branches: Vec<T> = branches.collect();
            values.push(value(NodeId(id), &branches));
        }
        values
    }

    /// Number of leaves at or below each node.
    pub fn leaves_below(&self) -> Vec<usize> {
        self.fold(|_, branches| branches.iter().sum::<usize>().max(1))
    }

    /// Lowest height at which `a` and `b` are connected (the energy of their lowest common ancestor); `None` if never.
    ///
    /// # Panics
    /// If a minimum is not in the tree.
    pub fn minimax(&self, a: MinimumId, b: MinimumId) -> Option<f64> {
        self.joint(a, b).map(|node| self.nodes[node.0].energy)
    }

    /// The lowest height at which each minimum is connected to `end`, as in [`Tree::minimax`]; `None` if never. One pass down
    /// the tree.
    ///
    /// # Panics
    /// If `end` is not in the tree.
    pub fn heights_to(&self, end: MinimumId) -> Vec<Option<f64>> {
        let mut above_end = vec![false; self.nodes.len()];
        let mut node = Some(NodeId(end.0));
        while let Some(NodeId(number)) = node {
            above_end[number] = true;
            node = self.nodes[number].parent;
        }
        let mut heights = vec![None; self.nodes.len()];
        // Parents have larger numbers than their children.
        for (number, node) in self.nodes.iter().enumerate().rev() {
            heights[number] = if above_end[number] {
                Some(node.energy)
            } else {
                node.parent.and_then(|parent| heights[parent.0])
            };
        }
        let leaves = self.nodes.iter().take_while(|node| node.minimum.is_some());
        heights.truncate(leaves.count());
        heights
    }

    /// The lowest common ancestor of two minima, by walking up; `None` in separate trees. For many pairs see [`Ancestors`].
    ///
    /// # Panics
    /// If a minimum is not in the tree.
    pub fn joint(&self, a: MinimumId, b: MinimumId) -> Option<NodeId> {
        let (mut a, mut b) = (a.0, b.0);
        while a != b {
            // Parents have larger numbers than children, so the smaller number cannot be the ancestor.
            if a < b {
                a = self.nodes[a].parent?.0;
            } else {
                b = self.nodes[b].parent?.0;
            }
        }
        Some(NodeId(a))
    }
}

/// Lowest common ancestors in a tree, in O(log n) steps each whatever the depth, after O(n) preparation.
///
/// Every node has a second pointer that jumps far up. Its length is given by the skew-binary digits of the depth (E. W.
/// Myers, Inf. Process. Lett. 17, 241 (1983)).
#[derive(Debug, Clone)]
pub struct Ancestors {
    /// The parent of each node; a root is its own parent.
    above: Vec<usize>,
    /// The ancestor to which each node's jump leads.
    jump: Vec<usize>,
    /// Number of steps from each node to its root.
    depth: Vec<usize>,
}

impl Ancestors {
    /// Prepares all nodes of `tree`.
    pub fn of(tree: &Tree) -> Self {
        let count = tree.nodes.len();
        let parents = tree.nodes.iter().enumerate();
        let above: Vec<usize> = parents
            .map(|(number, node)| node.parent.map_or(number, |parent| parent.0))
            .collect();
        let (mut jump, mut depth) = (above.clone(), vec![0; count]);
        for node in (0..count).rev() {
            let parent = above[node];
            if parent == node {
                continue;
            }
            depth[node] = depth[parent] + 1;
            let next = jump[parent];
            if depth[parent] - depth[next] == depth[next] - depth[jump[next]] {
                jump[node] = jump[next];
            }
        }
        Self { above, jump, depth }
    }

    /// The lowest common ancestor of `a` and `b`, as in [`Tree::joint`].
    ///
    /// # Panics
    /// If a minimum is not in the tree.
    pub fn joint(&self, a: MinimumId, b: MinimumId) -> Option<NodeId> {
        let [mut a, mut b] = if self.depth[a.0] < self.depth[b.0] {
            [b.0, a.0]
        } else {
            [a.0, b.0]
        };
        while self.depth[a] > self.depth[b] {
            let far = self.jump[a];
            a = if self.depth[far] < self.depth[b] {
                self.above[a]
            } else {
                far
            };
        }
        while a != b {
            if self.depth[a] == 0 {
                return None;
            }
            // At equal depths the jumps have equal lengths.
            let up = if self.jump[a] == self.jump[b] {
                &self.above
            } else {
                &self.jump
            };
            (a, b) = (up[a], up[b]);
        }
        Some(NodeId(a))
    }
}

#[derive(Clone, Copy)]
struct Link {
    edge: EdgeIndex,
    ends: [usize; 2],
    height: f64,
    evidence: Evidence,
}

/// The merges that the connections of one level make, lowest first, each with a minimum below it. `used` gives the two
/// subtrees that each connection joins, and `families` tells which subtrees belong together.
fn merges_of(used: &[([usize; 2], Link)], families: &UnionFind<usize>) -> Vec<(usize, Node)> {
    let mut members: Vec<(usize, usize)> = (used.iter().flat_map(|(ends, _)| ends))
        .map(|subtree| (families.find(*subtree), *subtree))
        .collect();
    members.sort_unstable();
    members.dedup();
    let mut merges: BTreeMap<usize, (usize, Node)> = BTreeMap::new();
    for (ends, link) in used {
        let family = merges.entry(families.find(ends[0]));
        let (_, merge) = family.or_insert_with(|| {
            let merge = Node {
                energy: f64::NEG_INFINITY,
                minimum: None,
                children: Vec::new(),
                parent: None,
                evidence: Evidence::Saddle,
            };
            (link.ends[0], merge)
        });
        merge.energy = merge.energy.max(link.height);
        merge.evidence = merge.evidence.max(link.evidence);
    }
    for (family, subtree) in members {
        if let Some((_, merge)) = merges.get_mut(&family) {
            merge.children.push(NodeId(subtree));
        }
    }
    let mut merges: Vec<_> = merges.into_values().collect();
    merges.sort_by(|(_, a), (_, b)| {
        (a.energy.total_cmp(&b.energy)).then(a.children.cmp(&b.children))
    });
    merges
}

/// Connections with evidence `worst` or better by height, grouped by ties. In a tie the best evidence comes first.
fn levels(network: &Network, worst: Evidence) -> Vec<Vec<Link>> {
    let mut links: Vec<Link> = network
        .edge_references()
        .filter(|edge| edge.weight().evidence <= worst && edge.weight().height.is_finite())
        .filter(|edge| edge.source() != edge.target())
        .map(|edge| {
            let (from, to) = (edge.source(), edge.target());
            Link {
                edge: edge.id(),
                ends: [from.index(), to.index()],
                // A pass cannot be below the minima it joins.
                height: (edge.weight().height)
                    .max(network[from].energy)
                    .max(network[to].energy),
                evidence: edge.weight().evidence,
            }
        })
        .collect();
    links.sort_by(|a, b| a.height.total_cmp(&b.height).then(a.edge.cmp(&b.edge)));
    let largest = links
        .iter()
        .fold(0.0, |most: f64, link| most.max(link.height.abs()));
    let mut levels: Vec<Vec<Link>> = Vec::new();
    for link in links {
        match levels.last_mut() {
            Some(level) if link.height <= level[0].height + TIE * largest => level.push(link),
            _ => levels.push(vec![link]),
        }
    }
    for level in &mut levels {
        level.sort_by_key(|link| link.evidence);
    }
    levels
}

/// The connections that decide the tree: a minimum spanning forest, lowest first.
pub fn spanning_forest(network: &Network, worst: Evidence) -> Vec<EdgeIndex> {
    let mut sets = UnionFind::new(network.node_count());
    levels(network, worst)
        .concat()
        .into_iter()
        .filter(|link| sets.union(link.ends[0], link.ends[1]))
        .map(|link| link.edge)
        .collect()
}

#[cfg(test)]
pub(super) mod tests {
    use petgraph::graph::NodeIndex;
    use proptest::prelude::*;

    use super::*;
    use crate::topography::{Edge, Minimum};

    pub(in crate::topography) fn network(
        energies: &[f64],
        edges: &[(usize, usize, f64, Evidence)],
    ) -> Network {
        let mut network = Network::default();
        for energy in energies {
            network.add_node(Minimum::bare(vec![*energy], *energy));
        }
        for (a, b, height, evidence) in edges {
            network.add_edge(
                NodeIndex::new(*a),
                NodeIndex::new(*b),
                Edge {
                    height: *height,
                    evidence: *evidence,
                    term: None,
                    length: 1.0,
                },
            );
        }
        network
    }

    #[test]
    fn ties_make_one_merge_and_evidence_is_the_worst_needed() {
        use Evidence::{Chain, Path, Saddle};
        let network = network(
            &[0.0, 0.1, 0.2, 0.3],
            &[
                (0, 1, 1.0, Path),
                (1, 2, 1.0, Saddle),
                (0, 2, 1.0, Saddle),
                (2, 3, 2.0, Chain),
            ],
        );
        let tree = Tree::from_network(&network, Chain);
        assert_eq!(tree.nodes.len(), 6);
        assert_eq!(tree.nodes[4].children, [NodeId(0), NodeId(1), NodeId(2)]);
        // The two saddles suffice; the path is not needed.
        assert_eq!(tree.nodes[4].evidence, Saddle);
        assert_eq!(tree.nodes[5].evidence, Chain);
        assert_eq!(tree.roots, [NodeId(5)]);
        assert_eq!(tree.minimax(MinimumId(0), MinimumId(3)), Some(2.0));
        assert_eq!(tree.minimax(MinimumId(2), MinimumId(2)), Some(0.2));

        let strict = Tree::from_network(&network, Path);
        assert_eq!(strict.roots.len(), 2);
        assert_eq!(strict.minimax(MinimumId(0), MinimumId(3)), None);
        assert_eq!(spanning_forest(&network, Chain).len(), 3);
    }

    #[test]
    fn two_merges_at_one_height_stay_apart() {
        let network = network(
            &[0.0; 4],
            &[(0, 3, 1.0, Evidence::Path), (1, 2, 1.0, Evidence::Path)],
        );
        let tree = Tree::from_network(&network, Evidence::Path);
        assert_eq!(tree.roots, [NodeId(4), NodeId(5)]);
        assert_eq!(tree.nodes[4].children, [NodeId(0), NodeId(3)]);
    }

    /// Least maximum over all paths, by the algorithm of Floyd and Warshall.
    fn brute_force(network: &Network) -> Vec<Vec<f64>> {
        let n = network.node_count();
        let mut best = vec![vec![f64::INFINITY; n]; n];
        for (i, minimum) in network.node_weights().enumerate() {
            best[i][i] = minimum.energy;
        }
        for edge in network.edge_references() {
            let (i, j) = (edge.source().index(), edge.target().index());
            if i != j {
                let height = edge.weight().height.max(best[i][i]).max(best[j][j]);
                best[i][j] = best[i][j].min(height);
                best[j][i] = best[i][j];
            }
        }
        for k in 0..n {
            for i in 0..n {
                for j in 0..n {
                    if i != j {
                        best[i][j] = best[i][j].min(best[i][k].max(best[k][j]));
                    }
                }
            }
        }
        best
    }

    prop_compose! {
        pub(in crate::topography) fn any_network()(n in 1_usize..9)(
            energies in proptest::collection::vec(-1.0..0.5_f64, n),
            // Heights on a coarse grid, so that many tie.
            edges in proptest::collection::vec((0..n, 0..n, 0..8_u8), 0..20),
        ) -> Network {
            let edges: Vec<_> = edges.into_iter()
                .map(|(a, b, h)| (a, b, f64::from(h) / 8.0, if h % 2 == 0 { Evidence::Path } else { Evidence::Saddle }))
                .collect();
            network(&energies, &edges)
        }
    }

    proptest! {
        #[test]
        fn minimax_equals_brute_force(network in any_network()) {
            let tree = Tree::from_network(&network, Evidence::Chain);
            let best = brute_force(&network);
            for (i, row) in best.iter().enumerate() {
                let walked: Vec<_> = (0..row.len())
                    .map(|j| tree.minimax(MinimumId(j), MinimumId(i)))
                    .collect();
                prop_assert_eq!(tree.heights_to(MinimumId(i)), walked);
                for (j, expected) in row.iter().enumerate() {
                    let found = tree.minimax(MinimumId(i), MinimumId(j)).unwrap_or(f64::INFINITY);
                    prop_assert!((found.is_infinite() && expected.is_infinite()) || (found - expected).abs() < 1e-7, "{i} {j}: {found} {expected}");
                }
            }
        }

        #[test]
        fn tree_is_well_formed_and_ultrametric(network in any_network()) {
            let tree = Tree::from_network(&network, Evidence::Chain);
            for (id, node) in tree.nodes.iter().enumerate() {
                prop_assert_eq!(node.minimum.is_some(), node.children.is_empty());
                prop_assert!(node.minimum.is_some() || node.children.len() > 1);
                for child in &node.children {
                    prop_assert!(child.0 < id);
                    prop_assert_eq!(tree.nodes[child.0].parent, Some(NodeId(id)));
                    prop_assert!(tree.nodes[child.0].energy <= node.energy);
                }
            }
            let leaves = network.node_count();
            let height = |i, j| tree.minimax(MinimumId(i), MinimumId(j)).unwrap_or(f64::INFINITY);
            for i in 0..leaves {
                for j in 0..leaves {
                    for k in 0..leaves {
                        prop_assert!(height(i, k) <= height(i, j).max(height(j, k)));
                    }
                }
            }
        }

        #[test]
        fn names_do_not_matter(network in any_network(), shuffle in any::<u64>()) {
            // A random permutation: minimum i is renamed order[i].
            let n = network.node_count();
            let mut keys: Vec<usize> = (0..n).collect();
            keys.sort_by_key(|i| (*i as u64 + 1).wrapping_mul(shuffle | 1));
            let mut order = vec![0; n];
            for (new, old) in keys.iter().enumerate() {
                order[*old] = new;
            }
            let mut renamed = Network::default();
            for old in &keys {
                renamed.add_node(network[NodeIndex::new(*old)].clone());
            }
            // The connections are also reversed, in order and direction.
            for edge in network.raw_edges().iter().rev() {
                let [a, b] = [edge.source(), edge.target()].map(|end| NodeIndex::new(order[end.index()]));
                renamed.add_edge(b, a, edge.weight.clone());
            }
            let [before, after] = [&network, &renamed].map(|network| Tree::from_network(network, Evidence::Chain));
            prop_assert_eq!(before.roots.len(), after.roots.len());
            prop_assert_eq!(before.nodes.len(), after.nodes.len());
            for i in 0..n {
                for j in 0..n {
                    prop_assert_eq!(
                        before.minimax(MinimumId(i), MinimumId(j)),
                        after.minimax(MinimumId(order[i]), MinimumId(order[j]))
                    );
                }
            }
        }

        #[test]
        fn another_connection_never_raises_a_merge(network in any_network(), height in 0.0..1.0_f64) {
            let before = Tree::from_network(&network, Evidence::Chain);
            let mut more = network.clone();
            let last = NodeIndex::new(network.node_count() - 1);
            more.add_edge(NodeIndex::new(0), last, Edge { height, evidence: Evidence::Path, term: None, length: 1.0 });
            let after = Tree::from_network(&more, Evidence::Chain);
            for i in 0..network.node_count() {
                for j in 0..network.node_count() {
                    let [old, new] = [&before, &after]
                        .map(|tree| tree.minimax(MinimumId(i), MinimumId(j)).unwrap_or(f64::INFINITY));
                    prop_assert!(new <= old + 1e-7);
                }
            }
        }
    }
}
