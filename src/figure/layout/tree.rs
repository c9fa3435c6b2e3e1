//! Layout of a disconnectivity graph, and its coarsening to families.

use crate::topography::{Evidence, MinimumId, Node, NodeId, Tree};

/// Horizontal places of a tree's nodes. Leaves are one unit apart, and the trees of a forest are farther apart.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TreeLayout {
    /// Place of each node, by node number. A parent stands at the mean of the leaves below it.
    pub x: Vec<f64>,
    /// Numbers of the leaves from left to right; the first is at 0.
    pub leaves: Vec<usize>,
    /// Place of the last leaf.
    pub width: f64,
}

/// Number of leaves of `tree`.
pub fn leaf_count(tree: &Tree) -> usize {
    tree.nodes
        .iter()
        .take_while(|node| node.minimum.is_some())
        .count()
}

/// Sizes and lowest energies of the branches, for sorting them: the one with the most leaves is in the middle of a merge, and
/// smaller ones alternate outward.
struct Branches<'a> {
    tree: &'a Tree,
    leaves: Vec<usize>,
    lowest: Vec<f64>,
}

impl Branches<'_> {
    /// Sort order: branches with more leaves first, then lower ones. Ties are broken by the number of the node.
    fn compare(&self, a: usize, b: usize) -> std::cmp::Ordering {
        let by_size = self.leaves[b].cmp(&self.leaves[a]);
        let by_energy = self.lowest[a].total_cmp(&self.lowest[b]);
        by_size.then(by_energy).then(a.cmp(&b))
    }

    fn sorted_children(&self, node: usize) -> Vec<usize> {
        let mut children: Vec<usize> = self.tree.nodes[node]
            .children
            .iter()
            .map(|child| child.0)
            .collect();
        children.sort_by(|&a, &b| self.compare(a, b));
        children
    }

    /// Appends the leaves under `root` from left to right.
    fn write(&self, root: usize, leaves: &mut Vec<usize>) {
        // Stack of branches to be written; the next is last.
        let mut rest = vec![root];
        while let Some(node) = rest.pop() {
            if self.tree.nodes[node].children.is_empty() {
                leaves.push(node);
            } else {
                let [left, spine, right] = self.around_spine(node);
                rest.extend(right.into_iter().chain(spine).chain(left.into_iter().rev()));
            }
        }
    }

    /// Walks down the spine of best branches. Every other branch goes to the side with fewer leaves so far, outermost
    /// first, so that the leaf at the end of the spine is in the middle. Returns the branches on the left from left to
    /// right, the end of the spine, and the branches on the right from right to left.
    fn around_spine(&self, node: usize) -> [Vec<usize>; 3] {
        let (mut left, mut right) = (Vec::new(), Vec::new());
        let mut counts = [0, 0];
        let mut spine = node;
        loop {
            let children = self.sorted_children(spine);
            let Some((&next, others)) = children.split_first() else {
                break;
            };
            for &other in others.iter().rev() {
                let side = usize::from(counts[1] < counts[0]);
                counts[side] += self.leaves[other];
                if side == 0 {
                    left.push(other);
                } else {
                    right.push(other);
                }
            }
            spine = next;
        }
        [left, vec![spine], right]
    }
}

/// Places the leaves of `tree` side by side so that no two branches cross, and each merge at the mean of the leaves below it
/// (O. M. Becker and M. Karplus, J. Chem. Phys. 106, 1495 (1997)), so that trunks are nearly straight.
///
/// The trees of a forest stand next to each other with a gap, the one with the most leaves first. Minima without any
/// connection come last, close together.
pub fn place(tree: &Tree) -> TreeLayout {
    let count = tree.nodes.len();
    let mut branches = Branches {
        tree,
        leaves: vec![1; count],
        lowest: vec![0.0; count],
    };
    for (index, node) in tree.nodes.iter().enumerate() {
        branches.lowest[index] = node.energy;
        if !node.children.is_empty() {
            branches.leaves[index] = node
                .children
                .iter()
                .map(|child| branches.leaves[child.0])
                .sum();
            branches.lowest[index] = node
                .children
                .iter()
                .map(|child| branches.lowest[child.0])
                .fold(f64::INFINITY, f64::min);
        }
    }
    let mut roots: Vec<usize> = tree.roots.iter().map(|root| root.0).collect();
    roots.sort_by(|&a, &b| {
        let alone = |root: usize| branches.leaves[root] == 1;
        alone(a)
            .cmp(&alone(b))
            .then(branches.leaves[b].cmp(&branches.leaves[a]))
            .then(branches.compare(a, b))
    });
    let gap = 1.0 + 0.01 * leaf_count(tree) as f64;
    let mut layout = TreeLayout {
        x: vec![0.0; count],
        ..TreeLayout::default()
    };
    let mut previous_alone = false;
    for &root in &roots {
        let alone = branches.leaves[root] == 1;
        if !layout.leaves.is_empty() {
            layout.width += if alone && previous_alone {
                1.0
            } else {
                1.0 + gap
            };
        }
        previous_alone = alone;
        let first = layout.leaves.len();
        branches.write(root, &mut layout.leaves);
        for (step, &leaf) in layout.leaves[first..].iter().enumerate() {
            layout.x[leaf] = layout.width + step as f64;
        }
        layout.width += (layout.leaves.len() - first - 1) as f64;
    }
    for (index, node) in tree.nodes.iter().enumerate() {
        if !node.children.is_empty() {
            // The mean of each child, as often as it has leaves.
            let children = node.children.iter();
            let sum: f64 = children
                .map(|child| branches.leaves[child.0] as f64 * layout.x[child.0])
                .sum();
            layout.x[index] = sum / branches.leaves[index] as f64;
        }
    }
    layout
}

/// The tree of families of minima. Leaf g represents all leaves i with `family_of[i]` = g, at their lowest energy.
///
/// Members of a family count as joined from the start. Two families therefore merge at the lowest height that joins any member
/// of one to any member of the other, and merges inside a family vanish.
///
/// # Panics
/// If `family_of` does not have one entry per leaf.
pub fn collapse(tree: &Tree, family_of: &[usize]) -> Tree {
    let leaves = leaf_count(tree);
    assert_eq!(family_of.len(), leaves, "one family a leaf");
    let families = family_of.iter().max().map_or(0, |largest| largest + 1);
    let mut nodes: Vec<Node> = (0..families)
        .map(|family| Node {
            energy: f64::INFINITY,
            minimum: Some(MinimumId(family)),
            children: Vec::new(),
            parent: None,
            evidence: Evidence::Saddle,
        })
        .collect();
    for (leaf, &family) in family_of.iter().enumerate() {
        nodes[family].energy = nodes[family].energy.min(tree.nodes[leaf].energy);
    }
    // Disjoint sets of families. `top` is the root of each set in the new tree.
    let mut above: Vec<usize> = (0..families).collect();
    let mut top = above.clone();
    let find = |above: &mut [usize], mut family: usize| {
        while above[family] != family {
            above[family] = above[above[family]];
            family = above[family];
        }
        family
    };
    // A family below each node of the old tree.
    let mut below = family_of.to_vec();
    for node in &tree.nodes[leaves..] {
        below.push(below[node.children[0].0]);
        let mut sets: Vec<usize> = node
            .children
            .iter()
            .map(|child| find(&mut above, below[child.0]))
            .collect();
        sets.sort_unstable();
        sets.dedup();
        if sets.len() < 2 {
            continue;
        }
        let merge = nodes.len();
        let children: Vec<NodeId> = sets.iter().map(|&set| NodeId(top[set])).collect();
        for &child in &children {
            nodes[child.0].parent = Some(NodeId(merge));
        }
        for &set in &sets {
            above[set] = sets[0];
        }
        top[sets[0]] = merge;
        nodes.push(Node {
            energy: node.energy,
            minimum: None,
            children,
            parent: None,
            evidence: node.evidence,
        });
    }
    let roots = (0..nodes.len())
        .filter(|&node| nodes[node].parent.is_none())
        .map(NodeId)
        .collect();
    Tree { nodes, roots }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::super::testing::{forest, random_tree};
    use super::*;

    /// Leaves under each node.
    fn below(tree: &Tree, node: usize) -> Vec<usize> {
        let children = &tree.nodes[node].children;
        if children.is_empty() {
            vec![node]
        } else {
            children
                .iter()
                .flat_map(|child| below(tree, child.0))
                .collect()
        }
    }

    proptest! {
        #[test]
        fn branches_never_cross(seed in 0u64..500, leaves in 1usize..60, parts in 1usize..4) {
            let tree = random_tree(seed, leaves, parts);
            let layout = place(&tree);
            let mut sorted = layout.leaves.clone();
            sorted.sort_unstable();
            prop_assert_eq!(sorted, (0..leaves).collect::<Vec<_>>());
            prop_assert!(layout.leaves.windows(2).all(|pair| layout.x[pair[1]] - layout.x[pair[0]] > 0.999));
            for node in 0..tree.nodes.len() {
                // A branch owns its interval: the leaves under it are neighbours, one unit apart.
                let mut places: Vec<f64> = below(&tree, node).iter().map(|&leaf| layout.x[leaf]).collect();
                places.sort_by(f64::total_cmp);
                prop_assert!(places.windows(2).all(|pair| (pair[1] - pair[0] - 1.0).abs() < 1e-9));
                let mean = places.iter().sum::<f64>() / places.len() as f64;
                prop_assert!((layout.x[node] - mean).abs() < 1e-9);
            }
        }

        #[test]
        fn collapsing_keeps_the_lowest_way_between_families(seed in 0u64..300, leaves in 2usize..25, families in 1usize..8) {
            let tree = random_tree(seed, leaves, 1 + leaves / 12);
            let family_of: Vec<usize> = (0..leaves).map(|leaf| (leaf * 7 + leaf / 3) % families.min(leaves)).collect();
            let coarse = collapse(&tree, &family_of);
            let count = family_of.iter().max().unwrap() + 1;
            // By brute force: lowest bottleneck over all chains of families (Floyd and Warshall).
            let mut heights = vec![vec![f64::INFINITY; count]; count];
            for a in 0..leaves {
                for b in 0..leaves {
                    let height = meet(&tree, a, b);
                    let cell = &mut heights[family_of[a]][family_of[b]];
                    *cell = cell.min(height);
                }
            }
            for k in 0..count {
                for i in 0..count {
                    for j in 0..count {
                        heights[i][j] = heights[i][j].min(heights[i][k].max(heights[k][j]));
                    }
                }
            }
            for (i, row) in heights.iter().enumerate() {
                for (j, height) in row.iter().enumerate().filter(|(j, _)| *j != i) {
                    prop_assert_eq!(meet(&coarse, i, j).to_bits(), height.to_bits());
                }
            }
        }
    }

    /// Energy of the lowest common ancestor; infinite in different trees.
    fn meet(tree: &Tree, a: usize, b: usize) -> f64 {
        let (mut a, mut b) = (a, b);
        while a != b {
            let lower = if a < b { &mut a } else { &mut b };
            match tree.nodes[*lower].parent {
                Some(parent) => *lower = parent.0,
                None => return f64::INFINITY,
            }
        }
        tree.nodes[a].energy
    }

    #[test]
    fn global_minimum_is_centred() {
        // Leaf by leaf joins the basin of the lowest one: any split of the others into two sides is possible.
        let energies: Vec<f64> = (0..41).map(|leaf| f64::from((leaf + 24) % 41)).collect();
        let lowest = 17;
        let mut merges: Vec<(f64, Vec<usize>)> = Vec::new();
        for (step, leaf) in (0..41).filter(|&leaf| leaf != lowest).enumerate() {
            let below = if step == 0 { lowest } else { 40 + step };
            merges.push((50.0 + step as f64, vec![leaf, below]));
        }
        let merges: Vec<(f64, &[usize])> = merges
            .iter()
            .map(|(height, children)| (*height, &children[..]))
            .collect();
        let tree = forest(&energies, &merges);
        let layout = place(&tree);
        assert!((layout.x[lowest] - 20.0).abs() < 1e-9);
        // The trunk above it is straight: leaves alternate sides.
        assert!(
            layout.x[41..]
                .iter()
                .all(|x| (x - 20.0).abs() <= 0.5 + 1e-9),
            "{:?}",
            &layout.x[41..]
        );
    }

    #[test]
    fn parents_stand_at_the_mean_of_their_leaves_and_trees_apart() {
        // Three leaves under one merge, a pair under another, one alone.
        let tree = forest(
            &[1.0, 0.0, 2.0, 5.0, 5.5, 9.0],
            &[(7.0, &[0, 1, 2]), (8.0, &[3, 4])],
        );
        let layout = place(&tree);
        assert_eq!(layout.leaves, [2, 1, 0, 4, 3, 5]);
        let gap = layout.x[4] - layout.x[0];
        assert!(gap > 2.0);
        assert!((layout.x[6] - 1.0).abs() < 1e-9);
        assert!((layout.x[7] - layout.x[4] - 0.5).abs() < 1e-9);
        assert!((layout.x[5] - layout.width).abs() < 1e-9);
    }

    #[test]
    fn nothing_gives_nothing() {
        assert_eq!(place(&Tree::default()), TreeLayout::default());
        assert_eq!(collapse(&Tree::default(), &[]), Tree::default());
    }
}
