//! What the summary of `landscape surface` says of a landscape of which only the lowest part was searched.

use super::Digits;
use super::markdown::table;
use super::surface::told_ends;
use crate::printable::counted;
use crate::topography::{Exploration, LowestReport, Merge};

/// Number of merges that are listed.
const LISTED: usize = 12;

/// Sentences on how the search went and what is missing.
pub(super) fn told(found: &Exploration, report: &LowestReport, merges: &[Merge]) -> Vec<String> {
    let coverage = &found.coverage;
    let sought = report.sought.min(found.minima.len());
    let joined = merges.iter().filter(|merge| merge.shallower.0 < sought);
    let apart = sought.saturating_sub(1) - joined.count();
    let missing = match apart {
        0 => "they are all joined".to_owned(),
        _ => format!("**{apart} of them are not yet joined to lower ones**"),
    };
    let tree = if report.stopped {
        format!(
            "last changed in round {} of {}",
            report.last_change, report.rounds
        )
    } else {
        format!(
            "has not changed by more than a hundredth since round {} of {}",
            report.last_change, report.rounds
        )
    };
    vec![
        "- **only the lowest part of the landscape was searched** (`--search all` enumerates)"
            .to_owned(),
        format!(
            "- lowest minimum: {} of {} independent runs of hops ended in it ({} hops, parallel tempering); a lower one that all \
             runs missed cannot be excluded",
            report.finds, report.runs, report.hops
        ),
        format!("- tree of the {sought} lowest minima: {missing}; the sum of its depths {tree}"),
        format!(
            "- barriers are upper bounds: every one is a verified saddle, and a lower way that was not found cannot be \
             excluded. Of the climbs that ended at a saddle, {:.0} % ended at one that no other climb has met (Good and Turing). \
             What lies above the barriers was not followed, so nothing is said about the number of all minima and saddles",
            100.0 * coverage.chance_of_news
        ),
        format!(
            "- {}, {} of which ended at a saddle met by climbing; climbs ended: {}",
            counted(coverage.searches, "search"),
            coverage.arrived,
            told_ends(found)
        ),
    ]
}

/// A sentence on what pictures and texts leave out.
pub(super) fn not_drawn(report: &LowestReport, minima: usize) -> Option<String> {
    (minima > report.sought).then(|| {
        format!(
            "pictures and the texts of the tree and the network show the {} lowest minima; min.data, ts.data and the tables \
             contain all, and `landscape draw` draws what its views choose",
            report.sought
        )
    })
}

/// The deepest merges, which divide funnels.
pub(super) fn deepest(
    found: &Exploration,
    report: &LowestReport,
    merges: &[Merge],
    digits: Digits,
) -> String {
    let sought = merges
        .iter()
        .filter(|merge| merge.shallower.0 < report.sought);
    let mut deepest: Vec<&Merge> = sought.collect();
    deepest.sort_by(|a, b| {
        b.depth
            .total_cmp(&a.depth)
            .then(a.shallower.cmp(&b.shallower))
    });
    let lowest = found.minima[0].energy;
    let rows = deepest.into_iter().take(LISTED).map(|merge| {
        vec![
            format!("m{}", merge.shallower.0),
            digits.show(found.minima[merge.shallower.0].energy),
            digits.show(merge.height),
            digits.show(merge.depth),
            digits.show(merge.height - lowest),
        ]
    });
    let head = [
        "minimum",
        "energy",
        "joins a deeper one at",
        "barrier from it",
        "barrier from m0",
    ];
    format!(
        "## Deepest merges\n\nWhat a minimum must climb to reach a deeper one.\n\n{}",
        table(&head, rows)
    )
}
