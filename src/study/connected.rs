//! What further searches between two minima found.

use std::fmt::Write;

use petgraph::graph::NodeIndex;
use serde::Serialize;

use crate::printable::counted;
use crate::topography::{Attempt, Further, Landscape, MinimumId, NodeId, PairSearch, Start};

/// What further searches between two minima found, after a landscape was finished or after all other searches of a surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConnectedPair {
    /// The two minima before these searches.
    pub asked: [MinimumId; 2],
    /// The same minima now; both are the same if only ripples divide them.
    pub minima: [MinimumId; 2],
    /// Height at which they merged; `None` if they did not.
    pub before: Option<f64>,
    /// Height at which they merge now; `None` if they do not.
    pub height: Option<f64>,
    /// Number of the further searches.
    pub searches: usize,
    /// How many of these ended at the height of the merge.
    pub ended_here: usize,
    /// Number of all searches across this merge.
    pub of_merge: usize,
    /// Chance that a lower way exists, by all searches across this merge; `None` if none crosses it.
    pub lower: Option<f64>,
}

impl ConnectedPair {
    /// What the searches of `pair`, which were made last, found. `grown` holds the members of all minima of `earlier`.
    pub(super) fn of(earlier: &Landscape, grown: &Landscape, pair: &PairSearch) -> Self {
        let minima = pair.minima.map(|minimum| heir(earlier, grown, minimum));
        let before = earlier.tree.minimax(pair.minima[0], pair.minima[1]);
        Self::new(grown, (pair.minima, minima), before, pair.searches)
    }

    /// What the further searches on a surface found. `landscape` is that of its result.
    pub(super) fn of_surface(landscape: &Landscape, further: &Further) -> Self {
        let minima = (further.asked, further.minima);
        let searches = further.attempts.list.len();
        Self::new(landscape, minima, further.before, searches)
    }

    /// What the last `searches` of a landscape found, which were made between two minima.
    fn new(
        landscape: &Landscape,
        (asked, minima): ([MinimumId; 2], [MinimumId; 2]),
        before: Option<f64>,
        searches: usize,
    ) -> Self {
        let (tree, attempts) = (&landscape.tree, &landscape.attempts);
        let [a, b] = minima;
        let merge = tree.joint(a, b).filter(|_| a != b);
        let height = merge.map(|NodeId(merge)| tree.nodes[merge].energy);
        let searched = merge.and_then(|NodeId(merge)| attempts.of_merges(tree)[merge]);
        let highest = height.map(|height| height + attempts.tolerance);
        let ended_here = |attempt: &&Attempt| {
            let ends = attempt.height.zip(highest);
            ends.is_some_and(|(height, highest)| height <= highest)
        };
        let last = (attempts.list.iter().rev())
            .filter(|attempt| matches!(attempt.start, Start::Chain { .. }))
            .take(searches);
        Self {
            asked,
            minima,
            before,
            height,
            searches,
            ended_here: last.filter(ended_here).count(),
            of_merge: searched.map_or(0, |searched| searched.searches),
            lower: searched.map(|searched| searched.lower),
        }
    }

    /// One sentence without full stop, in which `show` writes heights.
    pub(super) fn spell(&self, show: impl Fn(f64) -> String) -> String {
        let name = |[a, b]: [MinimumId; 2]| format!("m{} and m{}", a.0, b.0);
        let mut text = name(self.asked);
        if self.minima[0] == self.minima[1] {
            let _ = write!(
                text,
                ": only ripples divide them, and m{} stands for both now",
                self.minima[0].0
            );
            return text;
        }
        if self.minima != self.asked {
            let _ = write!(text, " (now {})", name(self.minima));
        }
        text += ": ";
        match (self.before, self.height) {
            (None, None) => text += "not joined, as before",
            (None, Some(height)) => {
                let _ = write!(text, "joined at {} (not joined before)", show(height));
            }
            (before, Some(height)) if before == self.height => {
                let _ = write!(text, "joined at {}, as before", show(height));
            }
            (before, height) => {
                let [before, height] =
                    [before, height].map(|height| show(height.unwrap_or(f64::INFINITY)));
                let _ = write!(text, "joined at {height} (before {before})");
            }
        }
        let _ = write!(
            text,
            "; {}, {} of which ended there",
            counted(self.searches, "further search"),
            self.ended_here
        );
        if let Some(lower) = self.lower {
            let chance = if lower < 0.01 {
                "below 1 %".to_owned()
            } else {
                format!("{:.0} %", 100.0 * lower)
            };
            let _ = write!(
                text,
                "; by all {} across this merge, the chance of a lower way is {chance}",
                counted(self.of_merge, "search")
            );
        }
        text
    }
}

/// The minimum of `grown` that holds the members of a minimum of `earlier`.
fn heir(earlier: &Landscape, grown: &Landscape, minimum: MinimumId) -> MinimumId {
    let members = &earlier.network[NodeIndex::new(minimum.0)].members;
    let holds = |node: &NodeIndex| {
        let held = &grown.network[*node].members;
        members.first().is_some_and(|member| held.contains(member))
    };
    let heir = grown.network.node_indices().find(holds);
    MinimumId(heir.map_or(minimum.0, NodeIndex::index))
}
