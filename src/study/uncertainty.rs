//! Reported uncertainties: support of merges, what the searches found, unseen families.

use std::collections::BTreeMap;

use serde::Serialize;

use super::error::StudyError;
use super::{json, median};
use crate::figure::rarefaction_chart;
use crate::printable::counted;
use crate::store::AtomicFolder;
use crate::topography::{Attempt, Evidence, LEAST_MEMBERS, Landscape, Node, Rarefaction, Start};

/// The inputs of a landscape of grasps.
pub(super) const GRASPS: &str = "grasps";

/// Points of a rarefaction curve up to the actual sample size.
const POINTS: usize = 50;

/// A merge of the tree in the manifest.
#[derive(Debug, Serialize)]
pub(super) struct MergeRow {
    height: f64,
    /// Number of minima below it.
    minima: usize,
    /// The lowest minimum of each branch.
    lowest: Vec<usize>,
    evidence: Evidence,
    /// Number of independent searches across it.
    searches: usize,
    /// How many of them ended at its height.
    ended_here: usize,
    /// 1 − the chance that a lower way exists; none if nothing was searched.
    support: Option<f64>,
    /// How much lower it may be.
    uncertainty: Option<f64>,
}

/// Uncertainties of a landscape, for its manifest and its summary.
#[derive(Debug)]
pub(super) struct Uncertainty {
    /// The merges, sorted by height.
    pub(super) merges: Vec<MergeRow>,
    /// What the searches did.
    pub(super) searches: SearchCounts,
    /// Families and minima that the inputs did not show.
    pub(super) unseen: Unseen,
}

impl Uncertainty {
    /// The uncertainties of a landscape made from `inputs`, named in the plural. Where these are [`GRASPS`], minima are called
    /// different grasps.
    pub(super) fn of(landscape: &Landscape, inputs: &'static str) -> Self {
        Self {
            merges: merges(landscape),
            searches: searches(landscape),
            unseen: Unseen::of(landscape, inputs),
        }
    }
}

fn merges(landscape: &Landscape) -> Vec<MergeRow> {
    let tree = &landscape.tree;
    let searched = landscape.attempts.of_merges(tree);
    let leaves = tree.leaves_below();
    // Minima are sorted by energy.
    let lowest =
        tree.fold(|node, branches: &[usize]| branches.iter().copied().min().unwrap_or(node.0));
    let merges = (tree.nodes.iter().enumerate()).filter(|(_, node)| !node.children.is_empty());
    let row = |(id, node): (usize, &Node)| MergeRow {
        height: node.energy,
        minima: leaves[id],
        lowest: node.children.iter().map(|child| lowest[child.0]).collect(),
        evidence: node.evidence,
        searches: searched[id].map_or(0, |found| found.searches),
        ended_here: searched[id].map_or(0, |found| found.ended_here),
        support: searched[id].map(|found| found.support()),
        uncertainty: searched[id].map(|found| found.uncertainty),
    };
    merges.map(row).collect()
}

/// What the searches did.
#[derive(Debug, Serialize)]
pub(super) struct SearchCounts {
    searches: usize,
    /// Those whose chain arrived.
    arrived: usize,
    /// Median, over these, of the highest energy of the chain minus the height of the way relaxed from it.
    median_excess: Option<f64>,
}

fn searches(landscape: &Landscape) -> SearchCounts {
    let list = landscape.attempts.list.iter();
    let chains: Vec<&Attempt> = list
        .filter(|attempt| matches!(attempt.start, Start::Chain { .. }))
        .collect();
    let excesses = chains.iter().filter_map(|attempt| {
        let (barrier, height) = attempt.barrier.zip(attempt.height)?;
        Some(barrier - height)
    });
    SearchCounts {
        searches: chains.len(),
        arrived: chains
            .iter()
            .filter(|attempt| attempt.barrier.is_some())
            .count(),
        median_excess: median(excesses.collect()),
    }
}

/// Lines of the summary.
pub(super) fn lines(uncertainty: &Uncertainty) -> Vec<String> {
    let Uncertainty {
        merges,
        searches,
        unseen,
    } = uncertainty;
    let mut lines = vec![unseen.line()];
    if searches.searches > 0 {
        let supports: Vec<f64> = merges.iter().filter_map(|merge| merge.support).collect();
        let sure = supports.iter().filter(|share| **share >= 0.95).count();
        let doubtful = supports.iter().filter(|share| **share < 0.7).count();
        lines.push(format!(
            "- support of merges: {} by attraction–diffusion, {} of which arrived, looked for lower ways. For {sure} of {} the \
             chance that a lower way exists is at most 5 %, for {doubtful} more than 30 %, and {} not searched",
            counted(searches.searches, "search"),
            searches.arrived,
            counted(merges.len(), "merge"),
            merges.len() - supports.len(),
        ));
        if let Some(excess) = searches.median_excess {
            lines.push(format!(
                "- raw chains: in the median, the highest energy of a chain lies {excess:.3} above the way relaxed from it"
            ));
        }
    }
    lines
}

/// Rarefaction of families and minima over the inputs.
#[derive(Debug)]
pub(super) struct Unseen {
    inputs: &'static str,
    families: Rarefaction,
    minima: Rarefaction,
}

impl Unseen {
    fn of(landscape: &Landscape, inputs: &'static str) -> Self {
        let sizes: Vec<usize> = (landscape.network.node_weights())
            .map(|minimum| minimum.members.len())
            .collect();
        let families = landscape.families.members.iter();
        let families: Vec<usize> = families
            .map(|members| members.iter().map(|id| sizes[id.0]).sum())
            .collect();
        Self {
            inputs,
            families: Rarefaction::new(&families, POINTS),
            minima: Rarefaction::new(&sizes, POINTS),
        }
    }

    pub(super) fn to_json(&self) -> serde_json::Value {
        json(BTreeMap::from([
            ("families", &self.families),
            ("minima", &self.minima),
        ]))
    }

    /// The chance that one more grasp falls into a known family, in whole grasps of a hundred, if it can be estimated:
    /// `about 98 of 100`, `at least 90 of 100`.
    pub(super) fn coverage(&self) -> Option<String> {
        let coverage = self.families.estimate?.coverage;
        Some(format!(
            "{} of 100",
            share_known(coverage, self.families.members as f64)
        ))
    }

    fn line(&self) -> String {
        let minimum = if self.inputs == GRASPS {
            "grasp"
        } else {
            "minimum"
        };
        let (Some(seen), Some(minima)) = (self.families.estimate, self.minima.estimate) else {
            return format!(
                "- families still unseen: {} {} are too few to estimate it (at least {LEAST_MEMBERS} are needed)",
                self.families.members, self.inputs
            );
        };
        let [low, high] = seen.unseen_interval;
        let unseen = if high < 0.5 {
            "probably none".to_owned()
        } else if seen.unseen < 0.5 {
            format!("probably none (at most {high:.0}, with 95 % confidence)")
        } else {
            format!(
                "at least about {:.0} (95 % interval {low:.0} to {high:.0})",
                seen.unseen
            )
        };
        format!(
            "- families still unseen: {unseen}; one more of the {} falls into a known family with a chance of {} %, into a \
             known {minimum} with {} % (estimates of Chao, Good and Turing). This takes the {} for independent draws: if they \
             were chosen to be spread, it is too pessimistic",
            self.inputs,
            share_known(seen.coverage, self.families.members as f64),
            share_known(minima.coverage, self.minima.members as f64),
            self.inputs
        )
    }

    /// Draws `rarefaction.svg` and `.png`.
    pub(super) fn draw(&self, title: &str, folder: &AtomicFolder) -> Result<(), StudyError> {
        let curves = [("families", &self.families), ("minima", &self.minima)];
        let canvas = rarefaction_chart(title, self.inputs, &curves).draw()?;
        for name in ["rarefaction.svg", "rarefaction.png"] {
            folder.write(name, &canvas.encode(name.as_ref())?)?;
        }
        Ok(())
    }
}

/// The chance that one more of `members` draws is of a known kind, in per cent, from the `coverage` that is estimated. If no
/// kind was met only once, it is estimated as 1; then the bound that holds with 95 % confidence is told (1 − 3/n, the rule of
/// three). It never is 100.
pub(super) fn share_known(coverage: f64, members: f64) -> String {
    if coverage >= 1.0 {
        let least = (100.0 - 300.0 / members).max(0.0).floor();
        format!("at least {least:.0}")
    } else if coverage >= 0.995 {
        "more than 99".to_owned()
    } else {
        format!("about {:.0}", 100.0 * coverage)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unseen(sizes: &[usize]) -> Unseen {
        let rarefaction = || Rarefaction::new(sizes, POINTS);
        Unseen {
            inputs: GRASPS,
            families: rarefaction(),
            minima: rarefaction(),
        }
    }

    #[test]
    fn what_is_unseen_is_told_in_words() {
        let (some, none, few) = (unseen(&[58, 1, 1]), unseen(&[30, 30]), unseen(&[5, 1]));
        assert_eq!(some.coverage().as_deref(), Some("about 97 of 100"));
        assert_eq!(none.coverage().as_deref(), Some("at least 95 of 100"));
        assert_eq!(few.coverage(), None);
        assert_eq!(share_known(1.0, 1e6), "at least 99");
        assert_eq!(share_known(0.999, 1000.0), "more than 99");
        let line = none.line();
        assert!(
            line.starts_with("- families still unseen: probably none;"),
            "{line}"
        );
        let line = some.line();
        assert!(
            line.starts_with("- families still unseen: at least about 1 ("),
            "{line}"
        );
        assert!(
            few.line().contains("6 grasps are too few"),
            "{}",
            few.line()
        );
    }
}
