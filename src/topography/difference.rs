//! What moved between two landscapes of one space: built with another temperature, other weights, another object of the
//! same hand.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::network::{Minimum, MinimumId};
use super::tree::{Ancestors, NodeId, Tree};
use super::view::View;
use crate::space::Space;

/// Two minima that are one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Match {
    /// In the first landscape.
    pub before: MinimumId,
    /// In the second.
    pub after: MinimumId,
    /// How far they are apart in the space.
    pub distance: f64,
    /// Energies in the first and in the second.
    pub energies: [f64; 2],
}

/// A merge of the first tree, of matched minima only, and what became of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MergeChange {
    /// The lowest matched minima of the two branches that merge, as the first landscape numbers them.
    pub ends: [MinimumId; 2],
    /// Height in the first.
    pub before: f64,
    /// Height at which the same two minima merge in the second; `None` where nothing joins them.
    pub after: Option<f64>,
}

/// How alike two trees are, over all pairs of matched minima.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Likeness {
    /// Pairs joined in both.
    pub pairs: usize,
    /// Pairs joined in one of them only.
    pub joined_in_one: usize,
    /// Mean change of the minimax height (second minus first).
    pub mean_change: f64,
    /// Root mean square change of the minimax height: the ℓ² cophenetic distance over the root of the number of pairs.
    pub rms_change: f64,
    /// Largest change of a minimax height or of an energy: the ℓ^∞ cophenetic distance.
    pub largest_change: f64,
    /// Cophenetic correlation: Pearson's between the heights of both; 1 where all moved alike. `None` where the heights
    /// of one are all equal, or pairs are fewer than two.
    pub correlation: Option<f64>,
}

/// What differs between two landscapes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TreeDifference {
    /// Minima found in both, by their number in the first.
    pub matches: Vec<Match>,
    /// Minima of the first that the second does not have.
    pub vanished: Vec<MinimumId>,
    /// Minima of the second that the first does not have.
    pub appeared: Vec<MinimumId>,
    /// The merges of the matched minima, by their height in the first.
    pub merges: Vec<MergeChange>,
    /// All pairs at once.
    pub likeness: Likeness,
}

impl TreeDifference {
    /// Compares the merge trees of two lists of minima of one space, each with its tree.
    ///
    /// Minima correspond if they are within `reach` of each other, modulo the symmetry of the space: the nearest pair
    /// first, each minimum once (at equal distances the lower numbers). Merges are those of the first tree restricted to
    /// the minima that have a partner; minima of one landscape alone still join the others ([`View`]).
    ///
    /// The likeness of two trees over common leaves is measured as in numerical taxonomy: R. R. Sokal and F. J. Rohlf,
    /// Taxon 11, 33 (1962) (correlation); G. Cardona et al., BMC Bioinformatics 14, 3 (2013) (distances; with the energies
    /// of the leaves on the diagonal, and ℓ^∞, an interleaving distance: E. Munch and A. Stefanou, 2019).
    ///
    /// O(n m) distances for n and m minima, and a step for each pair of those that correspond.
    ///
    /// # Panics
    /// If a tree does not belong to its minima, or a coordinate does not belong to the space.
    pub fn between(
        space: &dyn Space,
        (minima_before, before): (&[Minimum], &Tree),
        (minima_after, after): (&[Minimum], &Tree),
        reach: f64,
    ) -> Self {
        let matches = partners(space, minima_before, minima_after, reach);
        let mut partner = vec![None; minima_before.len()];
        let mut met = vec![false; minima_after.len()];
        for matched in &matches {
            partner[matched.before.0] = Some(matched.after);
            met[matched.after.0] = true;
        }
        let alone = |met: &mut dyn Iterator<Item = bool>| {
            let numbered = met.enumerate().filter(|(_, met)| !met);
            numbered.map(|(number, _)| MinimumId(number)).collect()
        };
        Self {
            vanished: alone(&mut partner.iter().map(Option::is_some)),
            appeared: alone(&mut met.iter().copied()),
            merges: merges(before, after, &partner),
            likeness: Likeness::of(&matches, before, after),
            matches,
        }
    }
}

/// Pairs within `reach`, nearest first, each minimum once; returned by the number of the first.
fn partners(space: &dyn Space, before: &[Minimum], after: &[Minimum], reach: f64) -> Vec<Match> {
    let near = |(i, one): (usize, &Minimum)| -> Vec<Match> {
        let measured = after.iter().enumerate().map(|(j, other)| Match {
            before: MinimumId(i),
            after: MinimumId(j),
            distance: space.distance(&one.coordinates, &other.coordinates),
            energies: [one.energy, other.energy],
        });
        measured.filter(|pair| pair.distance <= reach).collect()
    };
    let rows: Vec<Vec<Match>> = before.par_iter().enumerate().map(near).collect();
    let mut pairs = rows.concat();
    pairs.sort_by(|a, b| {
        let names = |pair: &Match| (pair.before, pair.after);
        a.distance
            .total_cmp(&b.distance)
            .then(names(a).cmp(&names(b)))
    });
    let (mut left, mut right) = (vec![false; before.len()], vec![false; after.len()]);
    pairs.retain(|pair| {
        let free = !left[pair.before.0] && !right[pair.after.0];
        if free {
            left[pair.before.0] = true;
            right[pair.after.0] = true;
        }
        free
    });
    pairs.sort_by_key(|pair| pair.before);
    pairs
}

/// The merges of the first tree between minima with a partner.
fn merges(before: &Tree, after: &Tree, partner: &[Option<MinimumId>]) -> Vec<MergeChange> {
    let view = View::whole(before).keep(|_, minimum| partner[minimum.0].is_some());
    // The lowest minimum below each node; leaves come first and children before their parents.
    let mut lowest: Vec<usize> = Vec::with_capacity(view.tree.nodes.len());
    let ancestors = Ancestors::of(after);
    let mut changes = Vec::new();
    for (number, node) in view.tree.nodes.iter().enumerate() {
        if node.minimum.is_some() {
            lowest.push(number);
            continue;
        }
        let mut branches: Vec<usize> = node
            .children
            .iter()
            .map(|child: &NodeId| lowest[child.0])
            .collect();
        branches.sort_by(|a, b| {
            let [one, other] = [a, b].map(|leaf| view.tree.nodes[*leaf].energy);
            one.total_cmp(&other).then(a.cmp(b))
        });
        lowest.push(branches[0]);
        for branch in &branches[1..] {
            let ends = [view.minima[branches[0]], view.minima[*branch]];
            let after = match ends.map(|end| partner[end.0]) {
                [Some(a), Some(b)] => {
                    (ancestors.joint(a, b)).map(|node| after.nodes[node.0].energy)
                }
                _ => None,
            };
            changes.push(MergeChange {
                ends,
                before: node.energy,
                after,
            });
        }
    }
    changes
}

impl Likeness {
    fn of(matches: &[Match], before: &Tree, after: &Tree) -> Self {
        let rows = matches.par_iter().enumerate().map(|(k, one)| {
            let first = heights_from(before, one.before);
            let second = heights_from(after, one.after);
            let mut row = Pairs::default();
            for other in &matches[k + 1..] {
                match (first[other.before.0], second[other.after.0]) {
                    (Some(first), Some(second)) => row.add([first, second]),
                    (None, None) => {}
                    _ => row.joined_in_one += 1,
                }
            }
            row
        });
        // Rows come together in their order, whatever thread made them.
        let rows: Vec<Pairs> = rows.collect();
        let all = rows.iter().fold(Pairs::default(), Pairs::with);
        let energies = matches.iter().map(|matched| matched.energies);
        let largest = energies.fold(all.largest_change, |largest, [a, b]| {
            largest.max((b - a).abs())
        });
        let count = all.count.max(1) as f64;
        let correlated = all.count > 1 && all.squares.iter().all(|square| *square > 0.0);
        Self {
            pairs: all.count,
            joined_in_one: all.joined_in_one,
            mean_change: all.mean[1] - all.mean[0],
            rms_change: (all.squared_changes / count).sqrt(),
            largest_change: largest,
            correlation: correlated
                .then(|| all.products / (all.squares[0].sqrt() * all.squares[1].sqrt())),
        }
    }
}

/// Height at which `minimum` merges with each minimum of the tree, `None` where it never does.
fn heights_from(tree: &Tree, minimum: MinimumId) -> Vec<Option<f64>> {
    let mut heights = vec![None; tree.nodes.len()];
    let mut above = Some(NodeId(minimum.0));
    while let Some(node) = above {
        heights[node.0] = Some(tree.nodes[node.0].energy);
        above = tree.nodes[node.0].parent;
    }
    // Parents have larger numbers than their children.
    for (number, node) in tree.nodes.iter().enumerate().rev() {
        if let (None, Some(parent)) = (heights[number], node.parent) {
            heights[number] = heights[parent.0];
        }
    }
    heights
}

/// Sums over pairs of minima, each with its heights in both trees; means and deviations from them are updated together (T. F.
/// Chan, G. H. Golub and R. J. `LeVeque`, Am. Stat. 37, 242 (1983)), so that no list of all pairs is needed.
#[derive(Debug, Clone, Copy, Default)]
struct Pairs {
    count: usize,
    joined_in_one: usize,
    /// Mean heights.
    mean: [f64; 2],
    /// Sums of the squared deviations from the means.
    squares: [f64; 2],
    /// Sum of the products of both deviations.
    products: f64,
    squared_changes: f64,
    largest_change: f64,
}

impl Pairs {
    fn add(&mut self, heights: [f64; 2]) {
        let change = heights[1] - heights[0];
        let one = Self {
            count: 1,
            mean: heights,
            squared_changes: change * change,
            largest_change: change.abs(),
            ..Self::default()
        };
        *self = self.with(&one);
    }

    /// The sums over both.
    fn with(self, other: &Self) -> Self {
        let count = self.count + other.count;
        let share = other.count as f64 / count.max(1) as f64;
        let weight = self.count as f64 * share;
        let apart = [0, 1].map(|side| other.mean[side] - self.mean[side]);
        Self {
            count,
            joined_in_one: self.joined_in_one + other.joined_in_one,
            mean: [0, 1].map(|side| self.mean[side] + share * apart[side]),
            squares: [0, 1].map(|side| {
                self.squares[side] + other.squares[side] + weight * apart[side].powi(2)
            }),
            products: self.products + other.products + weight * apart[0] * apart[1],
            squared_changes: self.squared_changes + other.squared_changes,
            largest_change: self.largest_change.max(other.largest_change),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Euclidean;
    use crate::topography::network::{Evidence, Network};
    use crate::topography::tree::tests::network;

    /// Minima at their energies on a line, as the helper places them.
    fn sides(network: &Network) -> (Vec<Minimum>, Tree) {
        let minima = network.node_weights().cloned().collect();
        (minima, Tree::from_network(network, Evidence::Chain))
    }

    fn compare(before: &Network, after: &Network, reach: f64) -> TreeDifference {
        let (one, other) = (sides(before), sides(after));
        TreeDifference::between(
            &Euclidean::new(1),
            (&one.0, &one.1),
            (&other.0, &other.1),
            reach,
        )
    }

    #[test]
    fn a_landscape_does_not_differ_from_itself() {
        use Evidence::{Path, Saddle};
        let same = network(&[0.0, 1.0, 2.0], &[(0, 1, 3.0, Saddle), (1, 2, 5.0, Path)]);
        let found = compare(&same, &same, 0.1);
        assert_eq!(found.matches.len(), 3);
        assert!(found.vanished.is_empty() && found.appeared.is_empty());
        assert!(
            found
                .merges
                .iter()
                .all(|merge| merge.after == Some(merge.before))
        );
        assert_eq!((found.likeness.pairs, found.likeness.joined_in_one), (3, 0));
        approx::assert_abs_diff_eq!(found.likeness.largest_change, 0.0);
        approx::assert_abs_diff_eq!(found.likeness.correlation.unwrap(), 1.0, epsilon = 1e-12);
    }

    #[test]
    fn what_moved_appeared_and_vanished_is_told() {
        use Evidence::Path;
        // Minima at 0, 1, 2, 3 and at 0.04, 1.1, 2, 7; the one at 3 is between 0 and 2 in the first.
        let before = network(
            &[0.0, 1.0, 2.0, 3.0],
            &[(0, 1, 4.0, Path), (0, 3, 5.0, Path), (3, 2, 6.0, Path)],
        );
        let after = network(
            &[0.04, 1.1, 2.0, 7.0],
            &[(0, 1, 4.5, Path), (1, 3, 8.0, Path)],
        );
        let found = compare(&before, &after, 0.2);
        let pairs: Vec<_> = found
            .matches
            .iter()
            .map(|m| (m.before.0, m.after.0))
            .collect();
        assert_eq!(pairs, [(0, 0), (1, 1), (2, 2)]);
        assert_eq!(found.vanished, [MinimumId(3)]);
        assert_eq!(found.appeared, [MinimumId(3)]);
        let merges: Vec<_> = found
            .merges
            .iter()
            .map(|m| (m.ends.map(|end| end.0), m.before, m.after))
            .collect();
        assert_eq!(merges, [([0, 1], 4.0, Some(4.5)), ([0, 2], 6.0, None)]);
        let likeness = found.likeness;
        assert_eq!((likeness.pairs, likeness.joined_in_one), (1, 2));
        approx::assert_abs_diff_eq!(likeness.mean_change, 0.5, epsilon = 1e-12);
        approx::assert_abs_diff_eq!(likeness.largest_change, 0.5, epsilon = 1e-12);
        assert_eq!(likeness.correlation, None);
    }

    /// Chains of minima whose heights change without any rule, some links of which are missing in one of them.
    #[test]
    fn likeness_is_that_of_all_pairs_one_by_one() {
        let count = 40_usize;
        let energies: Vec<f64> = (0..count).map(|k| k as f64).collect();
        let chain = |factor: usize, gap: usize| {
            let links: Vec<_> = (1..count)
                .filter(|k| *k != gap)
                .map(|k| (k - 1, k, 50.0 + (k * factor % 17) as f64, Evidence::Saddle))
                .collect();
            network(&energies, &links)
        };
        let (before, after) = (chain(5, 33), chain(7, 12));
        let likeness = compare(&before, &after, 0.1).likeness;
        let [one, other] = [&before, &after].map(|side| Tree::from_network(side, Evidence::Chain));
        let (mut heights, mut joined_in_one) = (Vec::new(), 0);
        for i in (0..count).map(MinimumId) {
            for j in (0..i.0).map(MinimumId) {
                match (one.minimax(i, j), other.minimax(i, j)) {
                    (Some(first), Some(second)) => heights.push([first, second]),
                    (None, None) => {}
                    _ => joined_in_one += 1,
                }
            }
        }
        assert_eq!(
            (likeness.pairs, likeness.joined_in_one),
            (heights.len(), joined_in_one)
        );
        let mean = |value: &dyn Fn([f64; 2]) -> f64| {
            heights.iter().map(|pair| value(*pair)).sum::<f64>() / heights.len() as f64
        };
        let [first, second] = [mean(&|h| h[0]), mean(&|h| h[1])];
        let largest = heights
            .iter()
            .map(|h| (h[1] - h[0]).abs())
            .fold(0.0, f64::max);
        let covariance = mean(&|h| (h[0] - first) * (h[1] - second));
        let variances = [
            mean(&|h| (h[0] - first).powi(2)),
            mean(&|h| (h[1] - second).powi(2)),
        ];
        for (found, expected) in [
            (likeness.mean_change, second - first),
            (likeness.rms_change, mean(&|h| (h[1] - h[0]).powi(2)).sqrt()),
            (likeness.largest_change, largest),
            (
                likeness.correlation.unwrap(),
                covariance / (variances[0] * variances[1]).sqrt(),
            ),
        ] {
            approx::assert_relative_eq!(found, expected, epsilon = 1e-12, max_relative = 1e-12);
        }
    }

    #[test]
    fn nothing_in_common_is_no_negative_difference() {
        let (before, after) = (network(&[0.0], &[]), network(&[9.0], &[]));
        let likeness = compare(&before, &after, 0.2).likeness;
        assert_eq!(likeness.pairs, 0);
        assert!(!likeness.rms_change.is_sign_negative());
        assert!(!likeness.mean_change.is_sign_negative());
    }

    #[test]
    fn the_nearest_pair_is_matched_first() {
        let before = network(&[0.0, 0.3], &[]);
        let after = network(&[0.2, 9.0], &[]);
        let found = compare(&before, &after, 0.25);
        assert_eq!(found.matches.len(), 1);
        assert_eq!(found.matches[0].before, MinimumId(1));
        assert_eq!(found.vanished, [MinimumId(0)]);
    }
}
