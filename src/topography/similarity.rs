//! Similarity of two merge trees of the same minima over all pairs, without a loop over pairs.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::network::MinimumId;
use super::tree::{Ancestors, NodeId, Tree};

/// Similarity of two trees over all pairs of matched minima.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TreeSimilarity {
    /// Number of pairs joined in both trees.
    pub pairs: usize,
    /// Number of pairs joined in only one of them.
    pub joined_in_one: usize,
    /// Mean change of the minimax height (second minus first).
    pub mean_change: f64,
    /// Root mean square change of the minimax height: the ℓ² cophenetic distance divided by √pairs.
    pub rms_change: f64,
    /// Largest change of a minimax height or of an energy: the ℓ^∞ cophenetic distance.
    pub largest_change: f64,
    /// Cophenetic correlation: Pearson's correlation between the heights in both trees (1 if all changed alike). `None` if
    /// the heights of one tree are all equal, or for fewer than two pairs.
    pub correlation: Option<f64>,
}

/// Greatest relative variance of heights that is due to rounding (the square of a relative error).
const ROUNDED: f64 = 1e-30;

impl TreeSimilarity {
    /// Compares two trees with the same number of leaves; leaf k of the first is leaf `same[k]` of the second.
    ///
    /// O(n log² n). Sums are accurate to about 10⁻⁸ of the spread of heights; the largest change is exact.
    pub(super) fn of(before: &Tree, after: &Tree, same: &[usize]) -> Self {
        let mut back = vec![0; same.len()];
        for (first, second) in same.iter().enumerate() {
            back[*second] = first;
        }
        let energies = same.iter().enumerate().map(|(first, second)| {
            (after.nodes[*second].energy - before.nodes[first].energy).abs()
        });
        let of_energies = energies.fold(0.0, f64::max);
        let of_heights = excess(before, after, &back).max(excess(after, before, same));
        let parts = Parts::of(before);
        let steps = steps(after, &back);
        let first = sums(&parts, &steps, [0.0; 2]);
        let count = first.pairs.max(1.0);
        let means = first.heights.map(|sum| sum / count);
        // Sums around the means lose no digits. The rounding error of the means is subtracted as well.
        let sums = sums(&parts, &steps, means);
        let rest = sums.heights.map(|sum| sum / count);
        let square = |k: usize| sums.squares[k] - count * rest[k] * rest[k];
        let product = sums.product - count * rest[0] * rest[1];
        let mean_change = (means[1] + rest[1]) - (means[0] + rest[0]);
        let spread = square(0) + square(1) - 2.0 * product;
        let rms_change = (mean_change * mean_change + spread.max(0.0) / count).sqrt();
        let telling = |k: usize| square(k) > ROUNDED * count * means[k] * means[k];
        let correlated = sums.pairs > 1.0 && telling(0) && telling(1);
        Self {
            pairs: whole(sums.pairs),
            joined_in_one: whole(sums.joined_in_one),
            // Rounding must not cause a change where there is none.
            mean_change: mean_change.clamp(-of_heights, of_heights) + 0.0,
            rms_change: rms_change.min(of_heights),
            largest_change: of_energies.max(of_heights),
            correlation: correlated
                .then(|| (product / (square(0).sqrt() * square(1).sqrt())).clamp(-1.0, 1.0)),
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "sums of counts are whole, not negative and far below 2⁵³"
)]
fn whole(count: f64) -> usize {
    count as usize
}

/// A step in building a tree with a stack: a leaf is pushed, or the two topmost sets of leaves are joined.
enum Step {
    Leaf(usize),
    /// The height; `None` to combine the trees of a forest.
    Join(Option<f64>),
}

/// The steps that build `tree`, whose leaf k is called `names[k]`. Largest branches come first to keep the stack small.
fn steps(tree: &Tree, names: &[usize]) -> Vec<Step> {
    enum Task {
        Make(NodeId),
        Join(Option<f64>),
    }
    let counts = tree.leaves_below();
    let mut steps = Vec::with_capacity(2 * names.len());
    let mut tasks = Vec::new();
    let push = |tasks: &mut Vec<Task>, branches: &[NodeId], height: Option<f64>| {
        let mut branches = branches.to_vec();
        branches.sort_by_key(|branch| (std::cmp::Reverse(counts[branch.0]), *branch));
        for (place, branch) in branches.iter().enumerate().rev() {
            if place > 0 {
                tasks.push(Task::Join(height));
            }
            tasks.push(Task::Make(*branch));
        }
    };
    push(&mut tasks, &tree.roots, None);
    while let Some(task) = tasks.pop() {
        match task {
            Task::Join(height) => steps.push(Step::Join(height)),
            Task::Make(NodeId(number)) => {
                let node = &tree.nodes[number];
                if node.minimum.is_some() {
                    steps.push(Step::Leaf(names[number]));
                } else {
                    push(&mut tasks, &node.children, Some(node.energy));
                }
            }
        }
    }
    steps
}

/// The greatest excess of the joining height in `high` over that in `low`, among pairs that both trees join; at least 0.
/// Leaf k of `low` is leaf `names[k]` of `high`.
///
/// A merge of `low` joins every pair below it at its own height or lower, so the pair below it that `high` joins highest
/// decides. `high` joins a whole set at the greatest height at which it joins any member to the first.
fn excess(high: &Tree, low: &Tree, names: &[usize]) -> f64 {
    // The root above each node of `high`. Parents have larger numbers than their children.
    let mut roots: Vec<usize> = (0..high.nodes.len()).collect();
    for number in (0..high.nodes.len()).rev() {
        if let Some(parent) = high.nodes[number].parent {
            roots[number] = roots[parent.0];
        }
    }
    let ancestors = Ancestors::of(high);
    let mut most: f64 = 0.0;
    // For each set and root: one of the leaves below the root, and the height that joins them all.
    let mut sets: Vec<BTreeMap<usize, (usize, f64)>> = Vec::new();
    for step in steps(low, names) {
        match step {
            Step::Leaf(leaf) => {
                sets.push([(roots[leaf], (leaf, f64::NEG_INFINITY))].into());
            }
            Step::Join(height) => {
                let (Some(mut small), Some(mut large)) = (sets.pop(), sets.pop()) else {
                    continue;
                };
                if small.len() > large.len() {
                    std::mem::swap(&mut small, &mut large);
                }
                for (root, (leaf, joined)) in small {
                    let Some((other, known)) = large.get_mut(&root) else {
                        large.insert(root, (leaf, joined));
                        continue;
                    };
                    let joint = ancestors.joint(MinimumId(leaf), MinimumId(*other));
                    let both = joint.map_or(joined, |node| high.nodes[node.0].energy);
                    *known = known.max(joined).max(both);
                    if let Some(height) = height {
                        most = most.max(*known - height);
                    }
                }
                sets.push(large);
            }
        }
    }
    most
}

/// Marks a missing part or twig.
const NONE: usize = usize::MAX;

/// A tree that is recursively halved, to a depth of order log n however deep the tree is.
///
/// From each root the path along the largest branches is a line, and the other branches hang on it. The line is halved by
/// number of leaves, and so is every branch on it. Two leaves that hang on a line at different places are joined at the
/// upper place, so the height at which the upper half meets a leaf of the lower half depends only on the leaves of the
/// upper half.
struct Parts {
    parts: Vec<Part>,
    /// The part of each leaf.
    leaves: Vec<usize>,
}

/// A section of a line, a whole branch, or a leaf.
struct Part {
    /// The part of which this is a half.
    above: usize,
    /// Which half it is: 0 for the upper, 1 for the lower.
    side: usize,
    /// Where on its line it hangs, if it is a branch.
    place: Place,
}

#[derive(Clone, Copy)]
enum Place {
    /// No place of its own: a section of a line.
    Stretch,
    /// At this height.
    At(f64),
    /// A place that joins nothing: the end of a line, or the root of a tree in a forest.
    Apart,
}

/// A branch on a line, and its place.
type Hanging = (NodeId, Place);

impl Parts {
    fn of(tree: &Tree) -> Self {
        let counts = tree.leaves_below();
        let mut parts = vec![Part {
            above: NONE,
            side: 0,
            place: Place::Stretch,
        }];
        let mut leaves = vec![NONE; tree.nodes.len()];
        // The branches of each line, and the part that the line is.
        let mut lines: Vec<(usize, Vec<Hanging>)> = Vec::new();
        if !tree.roots.is_empty() {
            lines.push((
                0,
                tree.roots
                    .iter()
                    .map(|root| (*root, Place::Apart))
                    .collect(),
            ));
        }
        while let Some((part, line)) = lines.pop() {
            let mut before = vec![0];
            for (branch, _) in &line {
                before.push(before[before.len() - 1] + counts[branch.0]);
            }
            let mut stretches = vec![(part, 0, line.len())];
            while let Some((part, from, to)) = stretches.pop() {
                if to - from == 1 {
                    let (branch, place) = line[from];
                    parts[part].place = place;
                    if tree.nodes[branch.0].minimum.is_some() {
                        leaves[branch.0] = part;
                    } else {
                        // The branch gets a second part, because its place on the line and its inside are separate.
                        parts.push(Part {
                            above: part,
                            side: 0,
                            place: Place::Stretch,
                        });
                        lines.push((parts.len() - 1, line_from(tree, &counts, branch)));
                    }
                    continue;
                }
                let half = usize::midpoint(before[from], before[to]);
                let cut = before.partition_point(|count| *count < half);
                let cut = cut.clamp(from + 1, to - 1);
                for (side, from, to) in [(0, from, cut), (1, cut, to)] {
                    stretches.push((parts.len(), from, to));
                    parts.push(Part {
                        above: part,
                        side,
                        place: Place::Stretch,
                    });
                }
            }
        }
        Self { parts, leaves }
    }
}

/// The branches along the path from `branch` by largest branches, from above, with heights. The final leaf comes last.
fn line_from(tree: &Tree, counts: &[usize], branch: NodeId) -> Vec<Hanging> {
    let (mut line, mut at) = (Vec::new(), branch);
    loop {
        let node = &tree.nodes[at.0];
        let largest = (node.children.iter().copied())
            .max_by_key(|child| (counts[child.0], std::cmp::Reverse(*child)));
        let Some(largest) = largest else {
            line.push((at, Place::Apart));
            return line;
        };
        let others = node.children.iter().filter(|child| **child != largest);
        line.extend(others.map(|child| (*child, Place::At(node.energy))));
        at = largest;
    }
}

/// A set of leaves, restricted to one part.
#[derive(Clone, Copy)]
struct Twig {
    halves: [usize; 2],
    count: f64,
    /// Sums over the leaves of powers 0, 1, 2 of the height of their place on this line (power 0: places that join).
    places: [f64; 3],
}

/// Storage of disjoint sets of leaves.
#[derive(Default)]
struct Twigs {
    twigs: Vec<Twig>,
    free: Vec<usize>,
}

impl Twigs {
    /// The set of one leaf. Heights are relative to `origin`.
    fn leaf(&mut self, parts: &Parts, leaf: usize, origin: f64) -> usize {
        let (mut part, mut twig) = (parts.leaves[leaf], NONE);
        let (mut places, mut side) = ([0.0; 3], 0);
        while part != NONE {
            let known = &parts.parts[part];
            match known.place {
                Place::Stretch => {}
                Place::At(height) => {
                    let height = height - origin;
                    places = [1.0, height, height * height];
                }
                Place::Apart => places = [0.0; 3],
            }
            let mut halves = [NONE; 2];
            halves[side] = twig;
            let new = Twig {
                halves,
                count: 1.0,
                places,
            };
            twig = self.free.pop().unwrap_or(self.twigs.len());
            if twig == self.twigs.len() {
                self.twigs.push(new);
            } else {
                self.twigs[twig] = new;
            }
            (part, side) = (known.above, known.side);
        }
        twig
    }

    /// Unites two sets and adds to `cross` the powers of the heights of all pairs between them. Recursion depth O(log n).
    fn join(&mut self, one: usize, other: usize, cross: &mut [f64; 3]) -> usize {
        if one == NONE || other == NONE {
            return one.min(other);
        }
        let [a, b] = [one, other].map(|twig| self.twigs[twig]);
        for [upper, lower] in [[a.halves[0], b.halves[1]], [b.halves[0], a.halves[1]]] {
            if upper != NONE && lower != NONE {
                let [upper, lower] = [upper, lower].map(|twig| &self.twigs[twig]);
                for (sum, place) in cross.iter_mut().zip(upper.places) {
                    *sum += place * lower.count;
                }
            }
        }
        let halves = [0, 1].map(|side| self.join(a.halves[side], b.halves[side], cross));
        self.twigs[one] = Twig {
            halves,
            count: a.count + b.count,
            places: [0, 1, 2].map(|power| a.places[power] + b.places[power]),
        };
        self.free.push(other);
        one
    }

    fn count(&self, twig: usize) -> f64 {
        self.twigs[twig].count
    }
}

#[derive(Default)]
struct Sums {
    pairs: f64,
    joined_in_one: f64,
    /// Sums of the heights in both trees.
    heights: [f64; 2],
    squares: [f64; 2],
    product: f64,
}

/// Sums over all leaf pairs of the tree in `parts` and the tree built by `steps`. Heights are relative to `origins`.
fn sums(parts: &Parts, steps: &[Step], origins: [f64; 2]) -> Sums {
    let mut sums = Sums::default();
    let (mut twigs, mut sets) = (Twigs::default(), Vec::new());
    for step in steps {
        match step {
            Step::Leaf(leaf) => sets.push(twigs.leaf(parts, *leaf, origins[0])),
            Step::Join(height) => {
                let (Some(other), Some(one)) = (sets.pop(), sets.pop()) else {
                    continue;
                };
                let all = twigs.count(one) * twigs.count(other);
                let mut cross = [0.0; 3];
                sets.push(twigs.join(one, other, &mut cross));
                let [joined, first, squares] = cross;
                if let Some(height) = height {
                    let height = height - origins[1];
                    sums.pairs += joined;
                    sums.joined_in_one += all - joined;
                    sums.heights[0] += first;
                    sums.heights[1] += joined * height;
                    sums.squares[0] += squares;
                    sums.squares[1] += joined * height * height;
                    sums.product += first * height;
                } else {
                    sums.joined_in_one += joined;
                }
            }
        }
    }
    sums
}
