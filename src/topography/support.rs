//! What independent searches say of a merge: how sure it is that no lower way was missed.

use super::barrier::Start;
use super::network::MinimumId;
use super::tree::{NodeId, Tree};

/// Share of merges for which a lower pass exists before any search has been made.
///
/// It and [`SHAPE`] were chosen before any surface was looked at; surfaces with known trees judged them
/// (`tests/random_surfaces/planted.rs`).
const MISSED_BEFORE: f64 = 0.5;

/// Shape of the distribution of how often searches meet a missed lower pass, relative to the pass that is known.
const SHAPE: f64 = 2.0;

/// An attempt to join two minima by a chain or a geodesic.
#[derive(Debug, Clone, PartialEq)]
pub struct Attempt {
    /// The lower minimum.
    pub from: MinimumId,
    /// The higher minimum.
    pub to: MinimumId,
    /// A search, numbered through the map, or a geodesic.
    pub start: Start,
    /// Temperature T and force F = αT of the chain that arrived, or of the last one; `None` for a geodesic.
    pub law: Option<[f64; 2]>,
    /// Temperature of the free walk with which the search began; `None` if it began with its chain.
    pub free_temperature: Option<f64>,
    /// Highest energy of the chain that arrived; `None` if none did, and for a geodesic.
    pub barrier: Option<f64>,
    /// Height of the way that was relaxed from it; `None` if there is none.
    pub height: Option<f64>,
}

/// The attempts of a map, and how near two heights of the same pass are.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Attempts {
    /// Searches and geodesics, by pair.
    pub list: Vec<Attempt>,
    /// Greatest difference of two heights that count as one.
    pub tolerance: f64,
}

/// What the searches across a merge found. A search is one across a merge if its two minima hang on different branches of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Searched {
    /// Number of independent searches, each of which was free to find a lower way.
    pub searches: usize,
    /// How many of them began with a free walk.
    pub free: usize,
    /// How many of them ended at the height of the merge.
    pub ended_here: usize,
    /// Chance that a lower way exists; see [`chance_of_lower`].
    pub lower: f64,
    /// How much lower the merge may be: the tolerance, and what further searches are expected to gain.
    pub uncertainty: f64,
}

impl Searched {
    /// 1 − the chance that a lower way exists.
    pub fn support(&self) -> f64 {
        1.0 - self.lower
    }
}

/// The chance that a lower way across a merge exists, if `ended_here` independent searches ended at its height and none below.
///
/// Before any search, a lower way exists with probability π = 0.5. Let searches end at the known pass at the rate p and at a
/// lower one, if it exists, at the rate r p. The ratio r is unknown; it follows the gamma distribution of mean 1 and shape
/// s = 2, so that a lower way which is met a tenth as often is unlikely but possible. While k searches end at the known pass,
/// none meets the lower one with probability E[exp(−r k)] = (1 + k/s)⁻ˢ = u, and by Bayes' rule the chance is
/// π u / (π u + 1 − π). This is capture and recapture: what counts is how often the same pass was found again, not how many
/// searches were made.
pub fn chance_of_lower(ended_here: usize) -> f64 {
    let unseen = libm::pow(1.0 + ended_here as f64 / SHAPE, -SHAPE);
    let missed = MISSED_BEFORE * unseen;
    missed / (missed + 1.0 - MISSED_BEFORE)
}

impl Attempts {
    /// What the searches across each merge of `tree` found; `None` for leaves and for merges that no search has tested. The
    /// leaves of the tree are the minima of the attempts.
    pub fn of_merges(&self, tree: &Tree) -> Vec<Option<Searched>> {
        let mut heights: Vec<Vec<f64>> = vec![Vec::new(); tree.nodes.len()];
        let mut free = vec![0; tree.nodes.len()];
        for attempt in &self.list {
            if !matches!(attempt.start, Start::Chain { .. }) {
                continue;
            }
            if let Some(NodeId(merge)) = tree.joint(attempt.from, attempt.to) {
                heights[merge].push(attempt.height.unwrap_or(f64::INFINITY));
                free[merge] += usize::from(attempt.free_temperature.is_some());
            }
        }
        let found = tree.nodes.iter().zip(heights).zip(free);
        let searched = found.map(|((node, mut heights), free)| {
            if node.children.is_empty() || heights.is_empty() {
                return None;
            }
            heights.sort_by(f64::total_cmp);
            let here = |height: &&f64| **height <= node.energy + self.tolerance;
            let ended_here = heights.iter().filter(here).count();
            let lower = chance_of_lower(ended_here);
            Some(Searched {
                searches: heights.len(),
                free,
                ended_here,
                lower,
                uncertainty: self.tolerance + lower * gain(&heights, node.energy),
            })
        });
        searched.collect()
    }
}

/// What a further search is expected to gain if it finds a lower way: as much as the lower half of the searches lies above
/// the merge on average. `heights` are sorted.
fn gain(heights: &[f64], merge: f64) -> f64 {
    let half = heights.iter().take(heights.len().div_ceil(2));
    let above: Vec<f64> = half
        .filter(|height| height.is_finite())
        .map(|height| (height - merge).max(0.0))
        .collect();
    above.iter().sum::<f64>() / above.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use petgraph::graph::NodeIndex;

    use super::*;
    use crate::topography::tree::tests::network;
    use crate::topography::{Evidence, Network};

    fn three() -> Network {
        let edges = [(0, 1, 1.0, Evidence::Saddle), (1, 2, 2.0, Evidence::Saddle)];
        network(&[0.0, 0.1, 0.2], &edges)
    }

    fn attempt(a: usize, b: usize, start: Start, height: Option<f64>) -> Attempt {
        Attempt {
            from: MinimumId(a),
            to: MinimumId(b),
            start,
            law: None,
            free_temperature: None,
            barrier: None,
            height,
        }
    }

    #[test]
    fn only_searches_across_a_merge_support_it() {
        let tree = Tree::from_network(&three(), Evidence::Chain);
        let search = |replica| Start::Chain {
            backward: false,
            replica,
        };
        let list = vec![
            attempt(0, 1, Start::Straight, Some(1.0)),
            attempt(0, 2, search(0), Some(2.0)),
            attempt(1, 2, search(1), Some(2.0005)),
            attempt(1, 2, search(2), Some(2.5)),
            attempt(0, 2, search(3), None),
        ];
        let attempts = Attempts {
            list,
            tolerance: 0.001,
        };
        let found = attempts.of_merges(&tree);
        assert!(
            found[..4].iter().all(Option::is_none),
            "a straight line is no test"
        );
        let top = found[4].unwrap();
        assert_eq!((top.searches, top.ended_here), (4, 2));
        assert!((top.lower - 0.2).abs() < 1e-12, "{}", top.lower);
        assert!(top.uncertainty > 0.001 && top.uncertainty < 0.5);
        assert!(tree.nodes[4].energy > three()[NodeIndex::new(2)].energy);
    }

    #[test]
    fn searches_that_end_at_a_pass_make_a_lower_one_unlikely() {
        assert!((chance_of_lower(0) - 0.5).abs() < 1e-12);
        let chances: Vec<f64> = (0..20).map(chance_of_lower).collect();
        assert!(chances.is_sorted_by(|a, b| a > b));
        assert!(chances[6] > 0.05 && chances[7] < 0.05);
    }
}
