//! `landscape diff`: differences between two landscapes of one space.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail, ensure};
use clap::Args;
use serde_json::json;

use super::args::Common;
use super::input::open_landscape;
use crate::cli::printing::{print, print_json};
use crate::figure::number;
use crate::object::Description;
use crate::space::{PoseSpace, Space, Symmetry};
use crate::store::{LandscapeFiles, Manifest};
use crate::study::{self, Digits, GroupLevel, comparison_notes, median};
use crate::topography::{
    Evidence, Match, MatchTolerance, MergeChange, Minimum, MinimumId, NEIGHBOUR_REACH, Tree,
    TreeDifference,
};

/// Compare two landscapes.
#[derive(Debug, Args)]
pub(super) struct Diff {
    /// The first landscape.
    #[arg(value_name = "BEFORE")]
    before: PathBuf,
    /// The second landscape.
    #[arg(value_name = "AFTER")]
    after: PathBuf,
    /// Greatest distance of corresponding minima (metres for grasps); by default the tolerance with which the landscape was
    /// made.
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    within: Option<f64>,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape diff warm.landscape cold.landscape             tables on standard output
  landscape diff a.landscape b.landscape --within 0.01 --json

Compares landscapes of one hand, or of one surface, made at different temperatures, with different weights or on
different objects. The tables show which minima correspond (the nearest ones within the distance at which two minima are
merged, or within --within), whose energies changed, which merges of the first landscape moved and by how much, and
which minima only one of the two has. A minimum without a match that has a neighbour of equal energy in the other
landscape, within five times that distance, is listed beside it: both may be ends of one flat valley, which descents from
other grasps meet at other points. A note warns if the groups of the two landscapes were made at different levels.";

/// Greatest number of rows of a table in the text.
const SHOWN: usize = 20;

/// One of two landscapes that are compared.
pub(super) struct Side {
    name: String,
    manifest: Manifest,
    minima: Vec<Minimum>,
    tree: Tree,
}

pub(super) fn run(command: &Diff, common: &Common) -> anyhow::Result<()> {
    check_reach(command.within)?;
    let before = side(&command.before)?;
    let after = side(&command.after)?;
    let (reach, found) = between(&before, &after, command.within)?;
    if common.json {
        let mut value = serde_json::to_value(&found)?;
        value["before"] = json!(before.name);
        value["after"] = json!(after.name);
        value["within"] = json!(reach);
        value["equal_energy"] = json!(equal_energy(&before).max(equal_energy(&after)));
        value["group_note"] = json!(levels(&before, &after));
        print_json(&value)?;
    } else if !common.quiet {
        print(&text(&before, &after, reach, &found));
    }
    Ok(())
}

fn check_reach(within: Option<f64>) -> anyhow::Result<()> {
    if let Some(reach) = within {
        ensure!(
            reach >= 0.0 && reach.is_finite(),
            "--within {reach}: a length is needed"
        );
    }
    Ok(())
}

/// What to know before the two are compared.
pub(super) fn notes(before: &Side, after: &Side) -> Vec<String> {
    comparison_notes([before, after].map(|side| (side.name.as_str(), &side.manifest)))
}

/// The distance within which minima of the two correspond, and what differs.
pub(super) fn between(
    before: &Side,
    after: &Side,
    within: Option<f64>,
) -> anyhow::Result<(f64, TreeDifference)> {
    check_reach(within)?;
    let space = common_space(before, after)?;
    let reach = match within {
        Some(reach) => reach,
        None => sameness(before)?.max(sameness(after)?),
    };
    let found = TreeDifference::between(
        &*space,
        (&before.minima, &before.tree),
        (&after.minima, &after.tree),
        &MatchTolerance {
            distance: reach,
            energy: equal_energy(before).max(equal_energy(after)),
        },
    );
    let found = found.map_err(|refused| anyhow!("{refused} (--within)"))?;
    Ok((reach, found))
}

fn side(folder: &Path) -> anyhow::Result<Side> {
    Side::of(folder.display().to_string(), &open_landscape(folder)?)
}

impl Side {
    /// The landscape of these files; `name` is its name in texts and errors.
    pub(super) fn of(name: String, files: &LandscapeFiles) -> anyhow::Result<Self> {
        let network = files.network(Path::new(&name))?;
        Ok(Self {
            name,
            tree: Tree::from_network(&network, Evidence::Chain),
            minima: network.node_weights().cloned().collect(),
            manifest: files.manifest.clone(),
        })
    }
}

/// The distance tolerance for minima with which the landscape was made.
fn sameness(side: &Side) -> anyhow::Result<f64> {
    let distance = side.manifest.settings["sameness"]["distance"].as_f64();
    distance.with_context(|| {
        format!(
            "{} does not record the distance within which two minima are one: give it with --within",
            side.name
        )
    })
}

/// The energy tolerance for minima with which the landscape was made; zero if it records none.
fn equal_energy(side: &Side) -> f64 {
    let energy = side.manifest.settings["sameness"]["energy"].as_f64();
    energy.filter(|energy| *energy >= 0.0).unwrap_or(0.0)
}

/// The common space. If two objects have different symmetries, the space has none.
fn common_space(before: &Side, after: &Side) -> anyhow::Result<Box<dyn Space>> {
    let sides = [before, after];
    for side in sides {
        ensure!(
            side.minima
                .iter()
                .all(|minimum| !minimum.coordinates.is_empty()),
            "{} does not record the coordinates of its minima, so they cannot be matched",
            side.name
        );
    }
    let space = match sides.map(|side| &side.manifest.hand) {
        [Some(one), Some(other)] => {
            ensure!(
                one.content_hash == other.content_hash,
                "the two landscapes are of different hands (`{}`, `{}`), so their minima cannot be matched; `landscape \
                 diversity` compares how diverse the grasps of different hands are",
                one.name,
                other.name
            );
            let hand = one.build()?;
            let [one, other] = sides.map(|side| symmetry(&side.manifest));
            let (one, other) = (one?, other?);
            let shared = if one == other { one } else { Symmetry::None };
            Box::new(PoseSpace::new(hand.pose_metric().clone(), shared))
        }
        [None, None] => {
            let [one, other] = sides.map(|side| surface_space(&side.manifest));
            let ((one, kind), (_, other_kind)) = (one?, other?);
            ensure!(
                kind == other_kind,
                "the two landscapes are of different spaces ({kind}, {other_kind})"
            );
            one
        }
        _ => bail!("one landscape is of grasps, the other of a surface"),
    };
    let wanted = space.coordinates();
    for side in sides {
        let odd = (side.minima.iter()).position(|minimum| minimum.coordinates.len() != wanted);
        if let Some(row) = odd {
            bail!(
                "{}: m{row} has {} coordinates, but a point of the space has {wanted}",
                side.name,
                side.minima[row].coordinates.len()
            );
        }
    }
    Ok(space)
}

/// The symmetry of a landscape's object, with its scale.
fn symmetry(manifest: &Manifest) -> anyhow::Result<Symmetry> {
    let Some(object) = &manifest.object else {
        return Ok(Symmetry::None);
    };
    let description: Description = serde_json::from_value(object.description.clone())
        .with_context(|| format!("the description of object `{}`", object.name))?;
    Ok(description.scaled(manifest.scale).symmetry)
}

/// The space of a searched surface, and its identification.
fn surface_space(manifest: &Manifest) -> anyhow::Result<(Box<dyn Space + Send>, String)> {
    study::surface_space(manifest)
        .with_context(|| format!("the space of `{}` is not recorded", manifest.source.name))
}

fn text(before: &Side, after: &Side, reach: f64, found: &TreeDifference) -> String {
    let minima = before.minima.iter().chain(&after.minima);
    let digits = Digits::of(minima.map(|minimum| minimum.energy));
    let length = |length: f64| {
        if before.manifest.hand.is_some() {
            format!("{} mm", number(1e3 * length))
        } else {
            Digits::of([length]).show(length)
        }
    };
    let moved: Vec<f64> = (found.matches.iter())
        .map(|matched| (matched.energies[1] - matched.energies[0]).abs())
        .collect();
    let mut lines = vec![
        format!("# {} → {}\n", before.name, after.name),
        format!(
            "- {} in both (of {} and of {}; at most {} apart)",
            are(found.matches.len()),
            before.minima.len(),
            after.minima.len(),
            length(reach)
        ),
    ];
    lines.extend(unmatched(before, after, found));
    if let (Some(usual), Some(most)) = (
        median(moved.clone()),
        moved.iter().copied().reduce(f64::max),
    ) {
        lines.push(format!(
            "- energies of corresponding minima moved by {} (median), {} at most",
            digits.show(usual),
            digits.show(most)
        ));
    }
    let notes = notes(before, after);
    lines.extend(notes.iter().map(|note| format!("- note: {note}")));
    if found.matches.is_empty() {
        lines.push(
            "- there is nothing to compare: no two minima correspond (--within LENGTH says how near they must be)"
                .to_owned(),
        );
        lines.extend(possible(found, (reach, &length)));
        lines.push(String::new());
        return lines.join("\n");
    }
    lines.extend(energies(found, digits));
    lines.extend(merges(found, digits));
    lines.extend(possible(found, (reach, &length)));
    let only = |side: &Side| format!("Only in {}", side.name);
    lines.extend(alone(
        &only(before),
        &before.minima,
        &found.only_before,
        digits,
    ));
    lines.extend(alone(
        &only(after),
        &after.minima,
        &found.only_after,
        digits,
    ));
    lines.push(String::new());
    lines.join("\n")
}

/// `6 minima are`.
fn are(minima: usize) -> String {
    match minima {
        1 => "1 minimum is".to_owned(),
        several => format!("{several} minima are"),
    }
}

/// How many minima only one of the two has, and how many may be those of the other.
fn unmatched(before: &Side, after: &Side, found: &TreeDifference) -> Vec<String> {
    let mut lines = Vec::new();
    let matched = |of: fn(&Match) -> MinimumId| -> BTreeSet<MinimumId> {
        found.matches.iter().map(of).collect()
    };
    let unmatched = |of: fn(&Match) -> MinimumId| -> BTreeSet<MinimumId> {
        let matched = matched(of);
        let possible = found.possible.iter().map(of);
        possible.filter(|id| !matched.contains(id)).collect()
    };
    let [one, other] = [unmatched(|pair| pair.before), unmatched(|pair| pair.after)];
    if !found.possible.is_empty() {
        lines.push(format!(
            "- {} of {} and {} of {} may be in both: they have a neighbour of equal energy there",
            one.len(),
            before.name,
            other.len(),
            after.name
        ));
    }
    lines.push(format!(
        "- {} only in {}, {} only in {}",
        are(found.only_before.len()),
        before.name,
        found.only_after.len(),
        after.name
    ));
    lines
}

/// Minima that may be those of the other landscape.
fn possible(found: &TreeDifference, (reach, length): (f64, &dyn Fn(f64) -> String)) -> Vec<String> {
    // A small difference of two energies that are equal within the tolerance needs its own digits.
    let apart = |pair: &Match| (pair.energies[1] - pair.energies[0]).abs();
    let rows = found.possible.iter().map(|pair| {
        format!(
            "| m{} may be m{}′ | {} | {} |",
            pair.before.0,
            pair.after.0,
            number(apart(pair)),
            length(pair.distance)
        )
    });
    let rows: Vec<String> = rows.collect();
    if rows.is_empty() {
        return rows;
    }
    let mut lines = table(
        "May be the same (′: after)",
        "| minimum | apart in energy | in place |\n|---|---|---|",
        rows,
    );
    lines.push(format!(
        "\nThe rule: no match within {}, but the nearest minimum of the other landscape with the same energy (within the tolerance \
         of the maps) lies within {}. Ends of one flat valley look like this.",
        length(reach),
        length(NEIGHBOUR_REACH * reach)
    ));
    lines
}

/// Why the groups of the two cannot be compared, if they have any and this is so.
fn levels(before: &Side, after: &Side) -> Option<String> {
    let [one, other] = [before, after].map(|side| GroupLevel::of(&side.manifest, None));
    GroupLevel::difference((&before.name, &one?), (&after.name, &other?))
}

fn energies(found: &TreeDifference, digits: Digits) -> Vec<String> {
    let mut matches = found.matches.clone();
    let change = |matched: &Match| matched.energies[1] - matched.energies[0];
    matches.retain(|matched| change(matched).abs() > 0.0);
    matches.sort_by(|a, b| change(b).abs().total_cmp(&change(a).abs()));
    let lengths = Digits::of(matches.iter().map(|matched| matched.distance));
    let rows = matches.iter().map(|matched| {
        let [one, other] = matched.energies;
        format!(
            "| m{} | m{} | {} | {} | {} | {} |",
            matched.before.0,
            matched.after.0,
            digits.show(one),
            digits.show(other),
            digits.change(other - one),
            lengths.show(matched.distance)
        )
    });
    table(
        "Energies that moved most",
        "| before | after | energy before | after | change | distance |\n|---|---|---|---|---|---|",
        rows.collect(),
    )
}

/// The merges with the largest changes, separated ones first.
fn merges(found: &TreeDifference, digits: Digits) -> Vec<String> {
    let mut merges = found.merges.clone();
    let change = |merge: &MergeChange| {
        merge
            .after
            .map_or(f64::INFINITY, |after| (after - merge.before).abs())
    };
    merges.retain(|merge| change(merge) > 0.0);
    merges.sort_by(|a, b| change(b).total_cmp(&change(a)));
    let rows = merges.iter().map(|merge| {
        let [a, b] = merge.ends.map(|end| end.0);
        match merge.after {
            Some(after) => format!(
                "| m{a}, m{b} | {} | {} | {} |",
                digits.show(merge.before),
                digits.show(after),
                digits.change(after - merge.before)
            ),
            None => format!("| m{a}, m{b} | {} | apart | |", digits.show(merge.before)),
        }
    });
    table(
        "Merges that moved most",
        "| lowest minima of the two sides (before) | height before | after | change |\n|---|---|---|---|",
        rows.collect(),
    )
}

fn alone(heading: &str, minima: &[Minimum], names: &[MinimumId], digits: Digits) -> Vec<String> {
    let rows = names.iter().map(|name| {
        let minimum = &minima[name.0];
        format!(
            "| m{} | {} | {} |",
            name.0,
            digits.show(minimum.energy),
            minimum.members.len()
        )
    });
    table(
        heading,
        "| minimum | energy | members |\n|---|---|---|",
        rows.collect(),
    )
}

fn table(heading: &str, head: &str, rows: Vec<String>) -> Vec<String> {
    if rows.is_empty() {
        return Vec::new();
    }
    let left_out = rows.len().saturating_sub(SHOWN);
    let mut lines = vec![format!("\n## {heading}\n\n{head}")];
    lines.extend(rows.into_iter().take(SHOWN));
    if left_out > 0 {
        lines.push(format!("\n… and {left_out} more (--json has all)"));
    }
    lines
}
