//! Support of merges: a bootstrap over the chains of the map.

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;
use rand::RngExt;

use super::barrier::{Connection, Start};
use super::network::{Edge, Evidence, Minimum, MinimumId, Network};
use super::tree::Tree;
use crate::sample::{Task, stream};

/// First random stream of the bootstrap. The groups use the streams before it.
const FIRST_STREAM: u64 = 1 << 32;

/// An attempt to connect two minima: a chain or a geodesic, what it met, and what the path relaxed from it found.
#[derive(Debug, Clone, PartialEq)]
pub struct Attempt {
    /// The lower minimum.
    pub from: MinimumId,
    /// The higher minimum.
    pub to: MinimumId,
    /// The chain (replicas count the chains of this pair and direction) or geodesic.
    pub start: Start,
    /// Raw barrier of the chain, or least height of the roughly relaxed straight line; `None` if nothing arrived or nothing
    /// was measured.
    pub barrier: Option<f64>,
    /// For each pass on the relaxed paths, and for their tops, the two minima and the height; empty if none was relaxed.
    pub found: Vec<(MinimumId, MinimumId, f64)>,
}

/// All trials of one pair: their chains and the heights found.
#[derive(Debug, Clone, Default)]
pub(super) struct Trial {
    /// Raw barriers of the chains in each direction.
    chains: [Vec<Option<f64>>; 2],
    /// Least height of the roughly relaxed straight line.
    straight: Option<f64>,
    /// For each relaxed path its start (chains numbered through all trials), and its passes: height and minima.
    found: Vec<(Start, Vec<Found>)>,
}

/// Two minima and the height of a path between them.
type Found = ((usize, usize), f64);

impl Trial {
    pub(super) fn replicas(&self) -> usize {
        self.chains[0].len().min(self.chains[1].len())
    }

    /// Number of chains, of those of the pair `own`, whose relaxed paths led to the pair `edge` at this height or lower.
    /// `None` if a straight line did, which is run always.
    pub(super) fn chains_that_found(
        &self,
        own: (usize, usize),
        edge: (usize, usize),
        height: f64,
    ) -> Option<usize> {
        if own == edge && self.straight.is_some_and(|straight| straight <= height) {
            return None;
        }
        let mut chains = 0;
        for (start, heights) in &self.found {
            let led = |(pair, found): &Found| *pair == edge && *found <= height;
            if heights.iter().any(led) {
                match start {
                    Start::Chain { .. } => chains += 1,
                    Start::Straight | Start::Round => return None,
                }
            }
        }
        Some(chains)
    }

    /// Adds the trial that gave `connection` and the passes `side_connections` on its paths.
    pub(super) fn add(&mut self, connection: &Connection, side_connections: &[Connection]) {
        let before = [self.chains[0].len(), self.chains[1].len()];
        self.chains[0].extend(&connection.forward);
        self.chains[1].extend(&connection.backward);
        let straight = self.straight.unwrap_or(f64::INFINITY);
        self.straight = Some(straight.min(connection.straight));
        let start = match connection.start {
            Some(Start::Chain { backward, replica }) => Start::Chain {
                backward,
                replica: before[usize::from(backward)] + replica,
            },
            Some(geodesic) => geodesic,
            None => return,
        };
        let height = |connection: &Connection| {
            let pair = (connection.from.0, connection.to.0);
            (pair, connection.edge.height)
        };
        let heights = std::iter::once(connection)
            .chain(side_connections)
            .map(height);
        self.found.push((start, heights.collect()));
    }

    /// Adds an attempt. Those of one direction come in the order of their replicas.
    pub(super) fn add_attempt(&mut self, attempt: &Attempt) {
        match attempt.start {
            Start::Chain { backward, .. } => {
                self.chains[usize::from(backward)].push(attempt.barrier);
            }
            Start::Straight | Start::Round => {
                let known = self.straight.into_iter().chain(attempt.barrier);
                self.straight = known.reduce(f64::min);
            }
        }
        let found = attempt.found.iter();
        let found = found.map(|(a, b, height)| ((a.0, b.0), *height)).collect();
        self.found.push((attempt.start, found));
    }

    /// Adds the chains and paths of another pair of minima of the same two basins, `turned` if that pair runs the other way.
    /// `place` gives the basin of each minimum.
    pub(super) fn absorb(&mut self, mut other: Self, turned: bool, place: &[usize]) {
        if turned {
            other.chains.swap(0, 1);
        }
        let before = [self.chains[0].len(), self.chains[1].len()];
        for (chains, more) in self.chains.iter_mut().zip(&other.chains) {
            chains.extend_from_slice(more);
        }
        let least = other.straight.unwrap_or(f64::INFINITY);
        self.straight = Some(self.straight.unwrap_or(f64::INFINITY).min(least));
        for (start, heights) in other.found {
            let start = match start {
                Start::Chain { backward, replica } => {
                    let backward = backward != turned;
                    Start::Chain {
                        backward,
                        replica: before[usize::from(backward)] + replica,
                    }
                }
                geodesic => geodesic,
            };
            let basins = |((a, b), height): Found| {
                let (a, b) = (place[a], place[b]);
                ((a.min(b), a.max(b)), height)
            };
            self.found
                .push((start, heights.into_iter().map(basins).collect()));
        }
    }

    /// The heights of the pair `ends` and of other pairs that would be known if only the `drawn` chains had been run.
    fn heights(&self, ends: (usize, usize), drawn: &[Vec<bool>; 2]) -> Vec<Found> {
        let raw = self.chains.iter().zip(drawn).flat_map(|(chains, drawn)| {
            let pairs = chains.iter().zip(drawn).filter(|(_, drawn)| **drawn);
            pairs.filter_map(|(barrier, _)| *barrier)
        });
        let least = raw.fold(self.straight.unwrap_or(f64::INFINITY), f64::min);
        let mut known = vec![(ends, least)];
        for (start, heights) in &self.found {
            let had = match start {
                Start::Chain { backward, replica } => drawn[usize::from(*backward)][*replica],
                Start::Straight | Start::Round => true,
            };
            if had {
                known.extend_from_slice(heights);
            }
        }
        known
    }
}

/// All attempts in `trials`, by pair.
pub(super) fn attempts(trials: &BTreeMap<(usize, usize), Trial>) -> Vec<Attempt> {
    let of_pair = |((from, to), trial): (&(usize, usize), &Trial)| {
        let chains = [false, true].into_iter().flat_map(|backward| {
            let barriers = trial.chains[usize::from(backward)].iter().enumerate();
            barriers.map(move |(replica, barrier)| (Start::Chain { backward, replica }, *barrier))
        });
        let straight = trial.straight.filter(|height| height.is_finite());
        let starts = chains.chain([(Start::Straight, straight), (Start::Round, None)]);
        let attempt = |(start, barrier)| Attempt {
            from: MinimumId(*from),
            to: MinimumId(*to),
            start,
            barrier,
            found: (trial.found.iter())
                .filter(|(origin, _)| *origin == start)
                .flat_map(|(_, found)| found)
                .filter(|(_, height)| height.is_finite())
                .map(|((a, b), height)| (MinimumId(*a), MinimumId(*b), *height))
                .collect(),
        };
        let told = |attempt: &Attempt| {
            let chain = matches!(attempt.start, Start::Chain { .. });
            chain || attempt.barrier.is_some() || !attempt.found.is_empty()
        };
        starts.map(attempt).filter(told).collect::<Vec<_>>()
    };
    trials.iter().flat_map(of_pair).collect()
}

/// Merge trees of `count` resamplings of the chains; none if no pair has two chains in one direction.
///
/// In each direction of each pair as many chains are drawn, with replacement, as there are. The height of a pair is then
/// the lowest of the raw barriers of the chains drawn, the straight line, and the relaxed paths (with the passes on them)
/// that started from a chain drawn or from the straight line. It is never lower than in the map itself, which has the best
/// known height. A relaxed path whose chain is not drawn is lost, although another chain might have relaxed to the same
/// path. The bootstrap therefore underestimates the support.
pub(super) fn resample(
    network: &Network,
    trials: &BTreeMap<(usize, usize), Trial>,
    count: usize,
    seed: u64,
) -> Vec<Tree> {
    let replicated = |trial: &Trial| trial.chains.iter().any(|chains| chains.len() > 1);
    if !trials.values().any(replicated) {
        return Vec::new();
    }
    let mut skeleton = network.map(
        |_, minimum| Minimum {
            energy: minimum.energy,
            coordinates: Vec::new(),
            choice: Vec::new(),
            members: Vec::new(),
        },
        |_, edge| Edge {
            evidence: Evidence::Chain,
            term: None,
            ..*edge
        },
    );
    let resampling = |id| {
        let mut rng = stream(seed, Task::Resampling, FIRST_STREAM + id as u64);
        for edge in skeleton.edge_weights_mut() {
            edge.height = f64::INFINITY;
        }
        for (ends, trial) in trials {
            let drawn = [0, 1].map(|direction| {
                let chains = trial.chains[direction].len();
                let mut drawn = vec![false; chains];
                for _ in 0..chains {
                    drawn[rng.random_range(0..chains)] = true;
                }
                drawn
            });
            for ((a, b), height) in trial.heights(*ends, &drawn) {
                let Some(edge) = skeleton.find_edge(NodeIndex::new(a), NodeIndex::new(b)) else {
                    continue;
                };
                let least = network[edge].height;
                skeleton[edge].height = skeleton[edge].height.min(height.max(least));
            }
        }
        Tree::from_network(&skeleton, Evidence::Chain)
    };
    (0..count).map(resampling).collect()
}

/// Support of each node of `tree`: the fraction of `resampled` trees in which some node has exactly the same leaves below
/// it. It is `None` for leaves, and if nothing was resampled.
///
/// J. Felsenstein, Evolution 39, 783 (1985). Clusters are compared by W. H. E. Day's intervals, J. Classif. 2, 7 (1985), in
/// O(leaves) for each tree. Leaf i must be the same in all trees.
///
/// # Panics
/// If a resampled tree has other leaves.
pub fn support(tree: &Tree, resampled: &[Tree]) -> Vec<Option<f64>> {
    let place = places(tree);
    let own = intervals(tree, &place);
    let mut hits = vec![0_usize; tree.nodes.len()];
    let mut lookup: Vec<((usize, usize), usize)> = (0..tree.nodes.len())
        .filter(|node| !tree.nodes[*node].children.is_empty())
        .map(|node| ((own[node].first, own[node].last), node))
        .collect();
    lookup.sort_unstable();
    for other in resampled {
        let theirs = intervals(other, &place);
        for (node, interval) in other.nodes.iter().zip(&theirs) {
            let whole = interval.last - interval.first + 1 == interval.leaves;
            if node.children.is_empty() || !whole {
                continue;
            }
            let key = (interval.first, interval.last);
            if let Ok(found) = lookup.binary_search_by(|(known, _)| known.cmp(&key)) {
                hits[lookup[found].1] += 1;
            }
        }
    }
    let share = |(hits, node): (usize, &super::tree::Node)| {
        let asked = !node.children.is_empty() && !resampled.is_empty();
        asked.then(|| hits as f64 / resampled.len() as f64)
    };
    hits.into_iter().zip(&tree.nodes).map(share).collect()
}

/// The leaves below a node: least and greatest place, and number.
#[derive(Clone, Copy)]
struct Interval {
    first: usize,
    last: usize,
    leaves: usize,
}

/// A numbering of the leaves in which the leaves below any node are contiguous.
fn places(tree: &Tree) -> Vec<usize> {
    let leaves = tree.nodes.iter().filter(|node| node.children.is_empty());
    let mut place = vec![0; leaves.count()];
    let mut next = 0;
    let mut stack: Vec<usize> = tree.roots.iter().rev().map(|root| root.0).collect();
    while let Some(node) = stack.pop() {
        let children = &tree.nodes[node].children;
        if children.is_empty() {
            place[node] = next;
            next += 1;
        }
        stack.extend(children.iter().rev().map(|child| child.0));
    }
    place
}

fn intervals(tree: &Tree, place: &[usize]) -> Vec<Interval> {
    tree.fold(|node, branches: &[Interval]| {
        let joined = branches.iter().copied().reduce(|a, b| Interval {
            first: a.first.min(b.first),
            last: a.last.max(b.last),
            leaves: a.leaves + b.leaves,
        });
        joined.unwrap_or_else(|| Interval {
            first: place[node.0],
            last: place[node.0],
            leaves: 1,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::tree::tests::network;

    fn tree(edges: &[(usize, usize, f64)]) -> Tree {
        let edges: Vec<_> = edges
            .iter()
            .map(|(a, b, height)| (*a, *b, *height, Evidence::Chain))
            .collect();
        Tree::from_network(&network(&[0.0; 5], &edges), Evidence::Chain)
    }

    #[test]
    fn clusters_are_counted() {
        // The first tree is ((0 1) 2) and (3 4). The second has (1 2) instead of (0 1), and the third does not join 2.
        let reference = tree(&[(0, 1, 1.0), (1, 2, 2.0), (3, 4, 1.5), (2, 3, 3.0)]);
        let second = tree(&[(1, 2, 1.0), (0, 1, 2.0), (3, 4, 1.5), (2, 3, 3.0)]);
        let third = tree(&[(0, 1, 1.0), (3, 4, 1.5)]);
        let found = support(&reference, &[reference.clone(), second, third]);
        assert_eq!(found.len(), reference.nodes.len());
        assert!(found[..5].iter().all(Option::is_none));
        // By ascending height: {0 1}, {3 4}, {0 1 2}, all.
        let thirds = [2.0, 3.0, 2.0, 2.0];
        for (value, thirds) in found[5..].iter().zip(thirds) {
            assert!((value.unwrap() - thirds / 3.0).abs() < 1e-12, "{found:?}");
        }
        assert!(support(&reference, &[]).iter().all(Option::is_none));
    }

    #[test]
    fn a_straight_line_needs_no_chains_to_confirm_it() {
        let chain = |replica| Start::Chain {
            backward: false,
            replica,
        };
        let mut trial = Trial {
            chains: [vec![Some(2.0); 3], Vec::new()],
            straight: Some(1.5),
            found: vec![
                (chain(0), vec![((0, 1), 1.0), ((1, 2), 0.8)]),
                (chain(2), vec![((0, 1), 1.1)]),
            ],
        };
        assert_eq!(trial.chains_that_found((0, 1), (0, 1), 1.05), Some(1));
        assert_eq!(trial.chains_that_found((0, 1), (0, 1), 1.2), Some(2));
        // A pass on the path of another pair.
        assert_eq!(trial.chains_that_found((0, 1), (1, 2), 0.9), Some(1));
        assert_eq!(trial.chains_that_found((0, 1), (2, 3), 9.0), Some(0));
        // The rough straight line is as low.
        assert_eq!(trial.chains_that_found((0, 1), (0, 1), 1.5), None);
        trial.found.push((Start::Straight, vec![((1, 2), 0.8)]));
        assert_eq!(trial.chains_that_found((0, 1), (1, 2), 0.9), None);
    }

    #[test]
    fn lost_chains_raise_heights() {
        let kept = network(
            &[0.0, 0.1, 0.2],
            &[
                (0, 1, 1.0, Evidence::Path),
                (1, 2, 1.2, Evidence::Path),
                (0, 2, 1.5, Evidence::Chain),
            ],
        );
        let trial = |chains: [&[Option<f64>]; 2], start, found| Trial {
            chains: chains.map(<[_]>::to_vec),
            straight: None,
            found: vec![(start, vec![found])],
        };
        let first = Start::Chain {
            backward: false,
            replica: 0,
        };
        let mut trials = BTreeMap::from([
            // The path came from one of two chains; the other is higher than all else.
            (
                (0, 1),
                trial([&[Some(1.3), Some(2.0)], &[None]], first, ((0, 1), 1.0)),
            ),
            (
                (1, 2),
                trial([&[Some(1.4)], &[None]], Start::Straight, ((1, 2), 1.2)),
            ),
            ((0, 2), trial([&[], &[]], Start::Straight, ((0, 2), 1.5))),
        ]);
        let reference = Tree::from_network(&kept, Evidence::Chain);
        let trees = resample(&kept, &trials, 400, 1);
        let found = support(&reference, &trees);
        // Two draws miss chain 0 of two with probability 1/4; then 0 joins last.
        let lower = found[3].unwrap();
        assert!((lower - 0.75).abs() < 0.08, "{lower}");
        assert!((found[4].unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(trees, resample(&kept, &trials, 400, 1));
        // Without a second chain nothing is known.
        trials.remove(&(0, 1));
        assert!(resample(&kept, &trials, 10, 1).is_empty());
    }
}
