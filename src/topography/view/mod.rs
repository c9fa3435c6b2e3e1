//! Views of a merge tree: which part of it is shown, chosen after the analysis.
//!
//! A view hides minima or coarsens heights without repeating the analysis. Hidden minima still connect those that are kept,
//! so no filter changes the height at which two kept minima merge; only [`View::swept`] changes heights. Filters can be
//! chained in any order: `View::whole(&tree).lowest(50).with_members(&counts, 2)`.
//!
//! The program disconnectionDPS (D. J. Wales, keywords `LOWEST`, `PICK`, `MONOTONIC`) prunes in the same way.

mod network;

use std::collections::BTreeSet;

pub use network::{bottoms, network_of_families, restricted};

use super::network::{Evidence, MinimumId};
use super::tree::{Node, NodeId, Tree};

/// Part of a merge tree.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct View {
    /// The visible tree. Its leaf i is minimum `minima[i]`.
    pub tree: Tree,
    /// The visible minima, numbered and ordered as in the whole tree.
    pub minima: Vec<MinimumId>,
}

/// Energy levels of a superbasin analysis: `count` levels `first`, `first + step`, …
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Levels {
    /// The lowest level.
    pub first: f64,
    /// Distance between two levels, positive.
    pub step: f64,
    /// Number of levels.
    pub count: usize,
}

/// Fraction of a step by which a height may exceed a level and still be on it, to allow for rounding.
const ON_LEVEL: f64 = 1e-9;

impl Levels {
    /// `count` evenly spaced levels from the lowest merge of `tree` to the highest; only the highest if `count` is 1.
    /// `None` for a tree without merges, or if `count` is 0.
    pub fn spanning(tree: &Tree, count: usize) -> Option<Self> {
        let merges = tree.nodes.iter().filter(|node| node.minimum.is_none());
        let (low, high) = merges.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), node| {
            (low.min(node.energy), high.max(node.energy))
        });
        if low > high || count == 0 {
            return None;
        }
        if count == 1 || high - low <= 0.0 {
            let (first, step, count) = (high, 1.0, 1);
            return Some(Self { first, step, count });
        }
        Some(Self {
            first: low,
            step: (high - low) / (count - 1) as f64,
            count,
        })
    }

    /// Energy of level `k`.
    pub fn energy(&self, k: usize) -> f64 {
        self.first + k as f64 * self.step
    }

    /// Index of the lowest level at which a pass of this height is open; `None` above the last.
    pub fn of(&self, height: f64) -> Option<usize> {
        // A negative number of steps gives level 0.
        let steps = ((height - self.first) / self.step - ON_LEVEL)
            .ceil()
            .max(0.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number, not negative, of the size of a count"
        )]
        (steps < self.count as f64).then_some(steps as usize)
    }
}

impl View {
    /// The whole tree.
    pub fn whole(tree: &Tree) -> Self {
        let leaves = tree.nodes.iter().map_while(|node| node.minimum);
        Self {
            minima: leaves.collect(),
            tree: tree.clone(),
        }
    }

    /// Keeps the `count` lowest minima (of equal energies the lower numbers), like `LOWEST` of disconnectionDPS.
    #[must_use]
    pub fn lowest(&self, count: usize) -> Self {
        let mut leaves: Vec<usize> = (0..self.minima.len()).collect();
        leaves.sort_by(|a, b| {
            let [one, other] = [a, b].map(|leaf| self.tree.nodes[*leaf].energy);
            one.total_cmp(&other).then(a.cmp(b))
        });
        leaves.truncate(count);
        let kept: BTreeSet<usize> = leaves.into_iter().collect();
        self.keep(|leaf, _| kept.contains(&leaf))
    }

    /// Keeps the `count` minima at the bottom of the deepest valleys. The depth of a valley is the height of the merge at
    /// which it joins one with a lower bottom, above its own bottom (its persistence). The lowest minimum of each tree is
    /// infinitely deep; of equal depths the lower minima are kept.
    ///
    /// This keeps the funnels of a large landscape, where [`View::lowest`] may show only one of them.
    #[must_use]
    pub fn deepest(&self, count: usize) -> Self {
        let nodes = &self.tree.nodes;
        let lower = |a: &usize, b: &usize| {
            let [one, other] = [a, b].map(|leaf| nodes[*leaf].energy);
            one.total_cmp(&other).then(a.cmp(b))
        };
        let mut depths = vec![f64::INFINITY; self.minima.len()];
        // The lowest leaf below each node.
        let mut bottoms: Vec<usize> = (0..self.minima.len()).collect();
        for node in &nodes[self.minima.len()..] {
            let below = || node.children.iter().map(|child| bottoms[child.0]);
            // Every merge has children.
            let lowest = below().min_by(lower).unwrap_or_default();
            for bottom in below().filter(|bottom| *bottom != lowest) {
                depths[bottom] = node.energy - nodes[bottom].energy;
            }
            bottoms.push(lowest);
        }
        let mut leaves: Vec<usize> = (0..self.minima.len()).collect();
        leaves.sort_by(|a, b| depths[*b].total_cmp(&depths[*a]).then(lower(a, b)));
        leaves.truncate(count);
        let kept: BTreeSet<usize> = leaves.into_iter().collect();
        self.keep(|leaf, _| kept.contains(&leaf))
    }

    /// Keeps the named minima, like `PICK` of disconnectionDPS. Names that are not in the view are ignored.
    #[must_use]
    pub fn picked(&self, names: &[MinimumId]) -> Self {
        let names: BTreeSet<MinimumId> = names.iter().copied().collect();
        self.keep(|_, minimum| names.contains(&minimum))
    }

    /// Keeps minima with at least `least` members; `members[i]` is the number of members of minimum i of the whole tree.
    ///
    /// # Panics
    /// If a minimum of the view has no count.
    #[must_use]
    pub fn with_members(&self, members: &[usize], least: usize) -> Self {
        self.keep(|_, minimum| members[minimum.0] >= least)
    }

    /// Keeps only minima with `keep(leaf number, minimum)`. A merge stays if two or more of its branches hold kept minima.
    #[must_use]
    pub fn keep(&self, keep: impl Fn(usize, MinimumId) -> bool) -> Self {
        let (mut nodes, mut minima) = (Vec::new(), Vec::new());
        // The node of the new tree, if any, that represents each old node.
        let mut image: Vec<Option<NodeId>> = Vec::with_capacity(self.tree.nodes.len());
        for (number, node) in self.tree.nodes.iter().enumerate() {
            let new = NodeId(nodes.len());
            if node.minimum.is_some() {
                let kept = keep(number, self.minima[number]);
                if kept {
                    minima.push(self.minima[number]);
                    nodes.push(leaf(new.0, node.energy));
                }
                image.push(kept.then_some(new));
                continue;
            }
            let children: Vec<NodeId> = (node.children.iter())
                .filter_map(|child| image[child.0])
                .collect();
            image.push(match children[..] {
                [] => None,
                [only] => Some(only),
                _ => {
                    merge(&mut nodes, node.energy, node.evidence, children);
                    Some(new)
                }
            });
        }
        Self {
            tree: grown(nodes),
            minima,
        }
    }

    /// Removes the merges above `height`, so that their branches become separate trees.
    #[must_use]
    pub fn below(&self, height: f64) -> Self {
        let mut nodes = self.tree.nodes.clone();
        // Merges are sorted by height, so the removed ones come last.
        nodes.retain(|node| node.minimum.is_some() || node.energy <= height);
        let count = nodes.len();
        for node in &mut nodes {
            node.parent = node.parent.filter(|parent| parent.0 < count);
        }
        Self {
            tree: grown(nodes),
            minima: self.minima.clone(),
        }
    }

    /// The superbasin analysis of O. M. Becker and M. Karplus, J. Chem. Phys. 106, 1495 (1997), at `levels`. A superbasin
    /// of a level is a set of minima joined by passes no higher than it.
    ///
    /// Every merge is raised to the lowest level at which its pass is open (including a pass exactly on the level) and
    /// united with its parent if that is on the same level. Passes above the last level join nothing.
    #[must_use]
    pub fn swept(&self, levels: &Levels) -> Self {
        let mut nodes: Vec<Node> = (self.tree.nodes.iter())
            .take(self.minima.len())
            .enumerate()
            .map(|(number, node)| leaf(number, node.energy))
            .collect();
        // The new nodes of each old node: itself, or its children if the merge above is on the same level.
        let mut images: Vec<(Vec<NodeId>, Evidence)> = (0..nodes.len())
            .map(|number| (vec![NodeId(number)], Evidence::Saddle))
            .collect();
        for node in &self.tree.nodes[self.minima.len()..] {
            let mut children = Vec::new();
            let mut evidence = node.evidence;
            let Some(level) = levels.of(node.energy) else {
                images.push((children, evidence));
                continue;
            };
            for child in &node.children {
                let (below, worst) = &mut images[child.0];
                if below.len() > 1 {
                    evidence = evidence.max(*worst);
                }
                // The list of a child is used only by its parent, so it can be moved. The longer list takes in the shorter
                // one, which bounds the cost by n log n for any tree.
                if below.len() > children.len() {
                    std::mem::swap(&mut children, below);
                }
                children.append(below);
            }
            let above = node.parent.map(|parent| self.tree.nodes[parent.0].energy);
            if above.is_none_or(|height| levels.of(height) != Some(level)) {
                let new = NodeId(nodes.len());
                // Rounding may put a pass on a level slightly above it.
                let energy = levels.energy(level).max(node.energy);
                merge(&mut nodes, energy, evidence, children);
                images.push((vec![new], evidence));
            } else {
                images.push((children, evidence));
            }
        }
        Self {
            tree: grown(nodes),
            minima: self.minima.clone(),
        }
    }
}

fn leaf(number: usize, energy: f64) -> Node {
    Node {
        energy,
        minimum: Some(MinimumId(number)),
        children: Vec::new(),
        parent: None,
        evidence: Evidence::Saddle,
    }
}

fn merge(nodes: &mut Vec<Node>, energy: f64, evidence: Evidence, mut children: Vec<NodeId>) {
    let number = NodeId(nodes.len());
    children.sort_unstable();
    for child in &children {
        nodes[child.0].parent = Some(number);
    }
    nodes.push(Node {
        energy,
        minimum: None,
        children,
        parent: None,
        evidence,
    });
}

fn grown(nodes: Vec<Node>) -> Tree {
    let roots = (0..nodes.len())
        .filter(|node| nodes[*node].parent.is_none())
        .map(NodeId)
        .collect();
    Tree { nodes, roots }
}

#[cfg(test)]
mod tests;
