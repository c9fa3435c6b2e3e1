//! `landscape diff`: differences between two landscapes of one space.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail, ensure};
use clap::Args;
use serde_json::{Value, json};

use super::args::Common;
use super::input::open_landscape;
use crate::cli::printing::{print_json, tell};
use crate::object::Description;
use crate::printable::counted;
use crate::space::{PoseSpace, Space, Symmetry};
use crate::store::{LandscapeFiles, Manifest};
use crate::study::{self, FamilyLevel, comparison_notes};
use crate::topography::{Evidence, MatchTolerance, Minimum, MinimumId, Tree, TreeDifference};

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
other grasps meet at other points. A note warns if the families of the two landscapes were made at different levels.";

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
        let level = |side: &Side| FamilyLevel::of(&side.manifest, None);
        let levels = level(&before).zip(level(&after));
        value["family_note"] = json!(levels.and_then(|(one, other)| {
            FamilyLevel::difference((&before.name, &one), (&after.name, &other))
        }));
        return print_json(&value);
    }
    if !common.quiet {
        tell(common, &summary(&before, &after, reach, &found))?;
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

/// Changes of this share of the largest energy are rounding.
const ROUNDING: f64 = 1e-9;

/// What a reader sees: how many minima correspond, and what differs most.
fn summary(before: &Side, after: &Side, reach: f64, found: &TreeDifference) -> Value {
    let energies = found.matches.iter().flat_map(|pair| pair.energies);
    let rounding = ROUNDING * energies.map(f64::abs).fold(0.0, f64::max);
    let mut energies: Vec<(f64, Value)> = (found.matches.iter())
        .map(|pair| {
            let change = pair.energies[1] - pair.energies[0];
            let row = json!({
                "before": named(pair.before),
                "after": named(pair.after),
                "energy": pair.energies[0],
                "change": change,
                "distance": pair.distance,
            });
            (change.abs(), row)
        })
        .collect();
    let mut merges: Vec<(f64, Value)> = (found.merges.iter())
        .map(|merge| {
            let change = merge.after.map(|after| after - merge.before);
            let row = json!({
                "lowest minima of the two sides": merge.ends.map(named).join(" and "),
                "height": merge.before,
                "change": change.map_or_else(|| json!("they do not merge"), |change| json!(change)),
            });
            (change.map_or(f64::INFINITY, f64::abs), row)
        })
        .collect();
    let possible = found.possible.iter().map(|pair| {
        json!({
            "minimum": format!("{} may be {}′", named(pair.before), named(pair.after)),
            "apart in energy": (pair.energies[1] - pair.energies[0]).abs(),
            "distance": pair.distance,
        })
    });
    json!({
        "before": counted_of(before),
        "after": counted_of(after),
        "notes": notes(before, after),
        "greatest distance of a match": reach,
        "minima in both": found.matches.len(),
        (format!("only in {}", before.name)): all_named(&found.only_before),
        (format!("only in {}", after.name)): all_named(&found.only_after),
        "energies that moved most": most(&mut energies, rounding),
        "merges that moved most": most(&mut merges, rounding),
        "minima that may be the same (equal energy, within five times the distance of a match)": possible.collect::<Vec<_>>(),
    })
}

fn counted_of(side: &Side) -> String {
    format!("{} ({})", side.name, counted(side.minima.len(), "minimum"))
}

fn all_named(minima: &[MinimumId]) -> Vec<String> {
    minima.iter().map(|minimum| named(*minimum)).collect()
}

fn named(minimum: MinimumId) -> String {
    format!("m{}", minimum.0)
}

/// The rows that changed by more than rounding, those that changed most first.
fn most(rows: &mut Vec<(f64, Value)>, rounding: f64) -> Vec<&Value> {
    rows.retain(|(change, _)| *change > rounding);
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    rows.iter().map(|(_, row)| row).collect()
}
