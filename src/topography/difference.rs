//! Differences between two landscapes of one space, for example with another temperature, other weights or another object.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::minima::MatchTolerance;
use super::network::{Minimum, MinimumId};
use super::places::Places;
use super::tree::{Ancestors, NodeId, Tree};
use super::view::View;
use crate::space::Space;

/// A minimum that both landscapes have.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Match {
    /// In the first landscape.
    pub before: MinimumId,
    /// In the second.
    pub after: MinimumId,
    /// Distance between the two in the space.
    pub distance: f64,
    /// Energies in the first and in the second.
    pub energies: [f64; 2],
}

/// A merge of the first tree, restricted to matched minima, and its height in the second.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MergeChange {
    /// The lowest matched minima of the two merging branches, as numbered in the first landscape.
    pub ends: [MinimumId; 2],
    /// Height in the first.
    pub before: f64,
    /// Height at which the same two minima merge in the second; `None` if nothing joins them.
    pub after: Option<f64>,
}

/// Too many pairs of minima lie within the reach for it to tell minima apart.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "more than {MOST_PAIRS} pairs of minima lie within {reach} of each other: choose a shorter length within which two \
     minima count as one"
)]
pub struct TooNear {
    /// The length within which two minima may be one.
    pub reach: f64,
}

/// How far from an unmatched minimum the one may lie that it may be, in units of the reach.
pub const NEIGHBOUR_REACH: f64 = 5.0;

/// Greatest number of pairs within reach that are kept at a time (some gigabytes).
const MOST_PAIRS: usize = 50_000_000;

/// The differences between two landscapes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TreeDifference {
    /// Minima found in both, ordered by their number in the first.
    pub matches: Vec<Match>,
    /// Unmatched minima beside the one that each may be: the nearest of the other landscape within [`NEIGHBOUR_REACH`] times the reach
    /// whose energy is equal within the tolerance. Ordered by the numbers. A minimum may be in several pairs, and one of the
    /// two may be matched to another minimum.
    pub possible: Vec<Match>,
    /// Minima of the first without a match and without a possible one.
    pub only_before: Vec<MinimumId>,
    /// Minima of the second without a match and without a possible one.
    pub only_after: Vec<MinimumId>,
    /// The merges of the matched minima, ordered by their height in the first.
    pub merges: Vec<MergeChange>,
}

impl TreeDifference {
    /// Compares the merge trees of two lists of minima of one space, each with its tree.
    ///
    /// Two minima correspond if they are within `reach.distance` of each other, modulo the symmetry of the space. The nearest pair
    /// is matched first, and each minimum is matched once (at equal distances the lower numbers first). The merges are
    /// those of the first tree restricted to the matched minima. Unmatched minima still join the others ([`View`]).
    ///
    /// In a flat valley two searches may end at points farther apart than the reach. An unmatched minimum is therefore told
    /// beside the nearest one, matched or not, whose energy is equal within `reach.energy` and that is within [`NEIGHBOUR_REACH`] times
    /// `reach.distance`.
    ///
    /// Distances are measured of those pairs only whose [`Space::landmarks`] are near; everything else is O(n log² n).
    ///
    /// # Errors
    /// If more pairs lie within `reach` than fit into memory.
    ///
    /// # Panics
    /// If a tree does not belong to its minima, or a coordinate does not belong to the space.
    pub fn between(
        space: &dyn Space,
        (minima_before, before): (&[Minimum], &Tree),
        (minima_after, after): (&[Minimum], &Tree),
        reach: &MatchTolerance,
    ) -> Result<Self, TooNear> {
        let matches = partners(space, minima_before, minima_after, reach.distance)?;
        let mut partner = vec![None; minima_before.len()];
        let mut met = vec![false; minima_after.len()];
        for matched in &matches {
            partner[matched.before.0] = Some(matched.after);
            met[matched.after.0] = true;
        }
        let alone = |met: &mut dyn Iterator<Item = bool>| -> Vec<MinimumId> {
            let numbered = met.enumerate().filter(|(_, met)| !met);
            numbered.map(|(number, _)| MinimumId(number)).collect()
        };
        let mut only_before = alone(&mut partner.iter().map(Option::is_some));
        let mut only_after = alone(&mut met.iter().copied());
        let mut possible = neighbours(space, (minima_before, &only_before), minima_after, reach);
        let turned = neighbours(space, (minima_after, &only_after), minima_before, reach);
        only_before.retain(|id| possible.iter().all(|pair| pair.before != *id));
        only_after.retain(|id| turned.iter().all(|pair| pair.before != *id));
        possible.extend(turned.into_iter().map(Match::turned));
        possible.sort_by_key(|pair| (pair.before, pair.after));
        possible.dedup_by_key(|pair| (pair.before, pair.after));
        // The tree is restricted to the matched minima; the others still join them.
        let restricted = View::whole(before).keep(|_, minimum| partner[minimum.0].is_some());
        Ok(Self {
            possible,
            only_before,
            only_after,
            merges: merges(&restricted, after, &partner),
            matches,
        })
    }
}

impl Match {
    /// The same with the landscapes exchanged.
    fn turned(self) -> Self {
        let [one, other] = self.energies;
        Self {
            before: self.after,
            after: self.before,
            energies: [other, one],
            ..self
        }
    }
}

/// The nearest minimum of `others` to each of these, within [`NEIGHBOUR_REACH`] times the reach and with an equal energy.
fn neighbours(
    space: &dyn Space,
    (minima, ids): (&[Minimum], &[MinimumId]),
    others: &[Minimum],
    reach: &MatchTolerance,
) -> Vec<Match> {
    let landmarks = |minimum: &Minimum| space.landmarks(&minimum.coordinates);
    let places = Places::new(others.par_iter().map(landmarks).collect());
    let far = NEIGHBOUR_REACH * reach.distance;
    let nearest = |id: &MinimumId| {
        let one = &minima[id.0];
        let candidates = places.within(far, &landmarks(one)).into_iter();
        let equal = candidates.filter(|k| (others[*k].energy - one.energy).abs() <= reach.energy);
        let measured = equal.map(|k| Match {
            before: *id,
            after: MinimumId(k),
            distance: space.distance(&one.coordinates, &others[k].coordinates),
            energies: [one.energy, others[k].energy],
        });
        // At equal distances the lower number, because it comes first.
        let near = measured.filter(|pair| pair.distance <= far);
        near.min_by(|a, b| a.distance.total_cmp(&b.distance))
    };
    ids.par_iter().filter_map(nearest).collect()
}

/// Matches pairs within `reach`, nearest first, each minimum once; sorted by the number in the first landscape.
fn partners(
    space: &dyn Space,
    before: &[Minimum],
    after: &[Minimum],
    reach: f64,
) -> Result<Vec<Match>, TooNear> {
    let landmarks = |minimum: &Minimum| space.landmarks(&minimum.coordinates);
    let places = Places::new(after.par_iter().map(landmarks).collect());
    let found = AtomicUsize::new(0);
    let near = |(i, one): (usize, &Minimum)| -> Vec<Match> {
        if found.load(Ordering::Relaxed) > MOST_PAIRS {
            return Vec::new();
        }
        let measured = places
            .within(reach, &landmarks(one))
            .into_iter()
            .map(|j| Match {
                before: MinimumId(i),
                after: MinimumId(j),
                distance: space.distance(&one.coordinates, &after[j].coordinates),
                energies: [one.energy, after[j].energy],
            });
        let row: Vec<Match> = measured.filter(|pair| pair.distance <= reach).collect();
        found.fetch_add(row.len(), Ordering::Relaxed);
        row
    };
    let rows: Vec<Vec<Match>> = before.par_iter().enumerate().map(near).collect();
    if found.into_inner() > MOST_PAIRS {
        return Err(TooNear { reach });
    }
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
    Ok(pairs)
}

/// The merges of the first tree, restricted by `view` to the matched minima.
fn merges(view: &View, after: &Tree, partner: &[Option<MinimumId>]) -> Vec<MergeChange> {
    // The lowest minimum below each node. Leaves come first, and children come before their parents.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Euclidean;
    use crate::topography::network::{Evidence, Network};
    use crate::topography::tree::tests::{any_network, network};
    use proptest::prelude::*;

    /// Minima on a line, placed at their energies.
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
            &MatchTolerance {
                energy: 1e-3,
                distance: reach,
            },
        )
        .unwrap()
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
        assert_eq!(found.only_before, [MinimumId(3)]);
        assert_eq!(found.only_after, [MinimumId(3)]);
        assert!(found.possible.is_empty(), "3 and 7 are far apart");
        let merges: Vec<_> = found
            .merges
            .iter()
            .map(|m| (m.ends.map(|end| end.0), m.before, m.after))
            .collect();
        assert_eq!(merges, [([0, 1], 4.0, Some(4.5)), ([0, 2], 6.0, None)]);
    }

    proptest! {
        #[test]
        fn merges_are_those_of_the_whole_trees(
            before in any_network(),
            after in any_network(),
            chosen in any::<u64>(),
        ) {
            let counts = [&before, &after].map(Network::node_count);
            // Minimum k of both is the same if both have it and it is chosen. All others are far apart.
            let [one, other] = [(&before, 0.5), (&after, 0.25)].map(|(side, away)| {
                let mut placed = side.clone();
                for (k, minimum) in placed.node_weights_mut().enumerate() {
                    let own = if chosen >> k & 1 == 1 { 0.0 } else { away };
                    minimum.coordinates = vec![k as f64 + own];
                }
                placed
            });
            let found = compare(&one, &other, 0.1);
            let common: Vec<usize> = (0..counts[0].min(counts[1])).filter(|k| chosen >> k & 1 == 1).collect();
            let matched: Vec<usize> = found.matches.iter().map(|pair| pair.before.0).collect();
            prop_assert_eq!(&matched, &common);
            prop_assert!(found.matches.iter().all(|pair| pair.before.0 == pair.after.0));
            let [first, second] = [&before, &after].map(|side| Tree::from_network(side, Evidence::Chain));
            for merge in found.merges {
                let [a, b] = merge.ends;
                prop_assert_eq!(first.minimax(a, b), Some(merge.before));
                prop_assert_eq!(second.minimax(a, b), merge.after);
            }
        }
    }

    #[test]
    fn many_in_one_place_are_refused() {
        let crowd = vec![Minimum::bare(vec![0.0], 0.0); 8000];
        let found = partners(&Euclidean::new(1), &crowd, &crowd, 0.5);
        assert_eq!(found, Err(TooNear { reach: 0.5 }));
    }

    /// Ends of a flat valley: equally high, and farther apart than two minima that count as one.
    #[test]
    fn ends_of_a_valley_may_be_one_minimum() {
        let placed = |places: &[(f64, f64)]| -> Network {
            let mut network = network(&vec![0.0; places.len()], &[]);
            for (minimum, (place, energy)) in network.node_weights_mut().zip(places) {
                minimum.coordinates = vec![*place];
                minimum.energy = *energy;
            }
            network
        };
        let before = placed(&[(0.0, 0.0), (1.0, 0.5), (1.25, 0.5), (5.0, 0.7), (9.0, 0.9)]);
        let after = placed(&[(0.0, 0.0), (1.05, 0.5002), (5.3, 0.72), (9.6, 0.9)]);
        let found = compare(&before, &after, 0.1);
        let pairs = |pairs: &[Match]| -> Vec<(usize, usize)> {
            pairs
                .iter()
                .map(|pair| (pair.before.0, pair.after.0))
                .collect()
        };
        assert_eq!(pairs(&found.matches), [(0, 0), (1, 1)]);
        // m2 lies 0.2 from the partner of m1; m3 has a neighbour of another energy, m4 one that is too far.
        assert_eq!(pairs(&found.possible), [(2, 1)]);
        approx::assert_abs_diff_eq!(found.possible[0].distance, 0.2, epsilon = 1e-12);
        assert_eq!(found.only_before, [MinimumId(3), MinimumId(4)]);
        assert_eq!(found.only_after, [MinimumId(2), MinimumId(3)]);
        // The same with the landscapes exchanged.
        let turned = compare(&after, &before, 0.1);
        assert_eq!(pairs(&turned.possible), [(1, 2)]);
        assert_eq!(turned.only_before, found.only_after);
    }
}
