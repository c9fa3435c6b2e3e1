//! `landscape draw`: draws a finished landscape again, with views applied.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, anyhow, ensure};
use clap::{Args, ValueEnum};

use super::args::{Common, FamilyBarrier, minimum_named};
use super::input::open_landscape;
use super::output::{check_folder, given_or_beside, make_folder};
use super::report::held;
use crate::cli::printing::tell_path;
use crate::figure::Leaf;
use crate::store::{FileSet, MinimumRow, read_attempts};
use crate::study::{
    Colouring, Drawing, FamilyName, MinimumNames, MinimumValues, Quantities, Titles, Views,
    family_of,
};
use crate::topography::{Evidence, MinimumId, Tree};

/// Draw a landscape again.
#[derive(Debug, Args)]
pub(super) struct Draw {
    /// The landscape: a folder of `landscape build`, `surface` or `import`.
    #[arg(value_name = "FOLDER")]
    landscape: PathBuf,
    /// The folder to write; by default the name of the landscape with the ending `.view`.
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Draw only the N lowest minima (or families).
    #[arg(long, value_name = "N")]
    lowest: Option<usize>,
    /// Draw only the minima (or families) at the bottom of the N deepest valleys: the depth of a valley is the height of the
    /// merge that joins it to a lower one, above its bottom.
    #[arg(long, value_name = "N")]
    deepest: Option<usize>,
    /// Draw only minima (or families) with at least N members.
    #[arg(long, value_name = "N")]
    min_members: Option<usize>,
    /// Draw only the bottoms of monotonic sequences: minima that no connection joins to a lower one.
    #[arg(long)]
    monotonic: bool,
    /// Draw only these minima, named as in the tree: m0,m4,m31.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pick: Vec<String>,
    /// Colour minima by whether their grasps held in simulation, from the file that `landscape stability` wrote for the
    /// same grasps.
    #[arg(long, value_name = "FILE")]
    stability: Option<PathBuf>,
    /// Colour minima by the grasp types of `landscape label` (labels given when the landscape was built override the rule).
    #[arg(long, value_name = "DIFFERENCES", conflicts_with = "stability")]
    colour: Option<Differences>,
    /// Place the branches of disconnectivity graphs at a quantity of their minima, with an axis below (a metric
    /// disconnectivity graph): energy, members, a coordinate (x0, x1, …), or a column of --values.
    #[arg(long, value_name = "QUANTITY")]
    place_by: Option<String>,
    /// Colour the circles of disconnectivity graphs by a quantity of their minima, named as for --place-by.
    #[arg(long, value_name = "QUANTITY", conflicts_with_all = ["stability", "colour"])]
    colour_by: Option<String>,
    /// A table (CSV) of your own quantities. Its column `minimum` names each minimum (m0, m1, …).
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    values: Option<PathBuf>,
    /// Put N rendered grasps with the names of their types below the disconnectivity graph of the families.
    #[arg(long, value_name = "N")]
    examples: Option<usize>,
    /// Raise every merge to the next of N even levels between the lowest and the highest merge.
    #[arg(long, value_name = "N")]
    levels: Option<usize>,
    #[command(flatten)]
    families: FamilyBarrier,
    /// Seed of the layout; by default that of the landscape.
    #[arg(long)]
    seed: Option<u64>,
}

/// Differences between grasp types that colours show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Differences {
    /// Power, intermediate, precision.
    Category,
    /// The 33 types; of a grasp that several types fit about equally, the cell or the category.
    Type,
}

impl From<Differences> for Colouring {
    fn from(differences: Differences) -> Self {
        match differences {
            Differences::Category => Self::Category,
            Differences::Type => Self::Type,
        }
    }
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape draw grasps.landscape --lowest 50              grasps.view/: the 50 lowest minima (and families)
  landscape draw lj-38.landscape --deepest 300             the funnels of a large landscape
  landscape draw grasps.landscape --min-members 2 --levels 20
  landscape draw grasps.landscape --pick m0,m4,m31 -o three
  landscape draw grasps.landscape --stability grasps.stability.parquet
  landscape draw grasps.landscape --colour category --examples 8
  landscape draw grasps.landscape --colour type            a colour and a symbol for each grasp type
  landscape draw muller-brown.landscape --place-by x0      a metric disconnectivity graph, over the first coordinate
  landscape draw lj-38.landscape --values q4.csv --place-by q4 --colour-by energy

Paths through hidden minima still count, so no choice of minima moves a merge. The pictures of grasps show their families
(disconnectivity, barriers) and their minima (disconnectivity_minima, barriers_minima). Those of surfaces and imported
landscapes show the minima (disconnectivity, barriers), and the families (disconnectivity_families, barriers_families) if there
are fewer of them, but more than one. The same choice applies to both, separately to families and to minima; a picked
minimum picks its family. Writes the pictures (SVG and PNG), and tree.nwk, tree.dot, tree.json and barriers.graphml of the
minima that are shown.";

pub(super) fn run(command: &Draw, common: &Common) -> anyhow::Result<()> {
    for (flag, value) in [
        ("lowest", command.lowest),
        ("deepest", command.deepest),
        ("levels", command.levels),
        ("min-members", command.min_members),
        ("examples", command.examples),
    ] {
        ensure!(value != Some(0), "--{flag} 0: at least 1 is needed");
    }
    let family_barrier = command.families.checked()?;
    let files = open_landscape(&command.landscape)?;
    let network = files.network(&command.landscape)?;
    let tree = Tree::from_network(&network, Evidence::Chain);
    let views = Views {
        lowest: command.lowest,
        deepest: command.deepest,
        members: command.min_members,
        monotonic: command.monotonic,
        levels: command.levels,
        picked: picked(&command.pick, files.minima.len())?,
    };
    let output = given_or_beside(command.output.as_ref(), &command.landscape, "view")?;
    let mut inputs = vec![command.landscape.as_path()];
    inputs.extend(command.stability.as_deref());
    inputs.extend(command.values.as_deref());
    check_folder(&output, &inputs, Drawing::writes, common)?;
    let titles = Titles::of_manifest(&files.manifest, command.seed);
    let types = (command.colour.is_some() || command.examples.is_some())
        .then(|| MinimumNames::of(&files, &command.landscape.display().to_string()))
        .transpose()?;
    let family_of = family_of(&files, &network, family_barrier);
    let leaves = leaves(command, &files.minima, types.as_ref())?;
    let examples = match (&types, command.examples) {
        (Some(types), Some(count)) => types.examples(&files, (&family_of, &leaves), count),
        _ => Vec::new(),
    };
    // The names are those of the families of the map.
    let as_mapped = crate::study::family_of(&files, &network, None) == family_of;
    let family_names = FamilyName::of_manifest(&files.manifest)
        .into_iter()
        .filter(|_| as_mapped);
    let attempts = read_attempts(&command.landscape, &files)?;
    let drawing = Drawing {
        attempts: Some(&attempts),
        family_of,
        family_names: family_names.map(|family| family.name).collect(),
        views,
        quantities: quantities(command, &files.minima)?,
        examples,
        ..Drawing::new(&network, &tree, leaves, &titles)
    };
    let _made = make_folder(&output)?;
    let mut outputs = FileSet::default();
    drawing.write(&mut |name, bytes| outputs.add(&output.join(name), bytes))?;
    outputs.finish()?;
    tell_path(common, &output)
}

/// The quantities that the flags name.
fn quantities(command: &Draw, minima: &[MinimumRow]) -> anyhow::Result<Quantities> {
    let mut values = MinimumValues::of(minima);
    if let Some(path) = &command.values {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("cannot read {}", path.display()))?;
        (values.add_table(&text, minima.len()))
            .map_err(|problem| anyhow!("{}: {problem}", path.display()))?;
    }
    let named = |flag: &str, name: &Option<String>| {
        let found = name.as_ref().map(|name| values.named(name)).transpose();
        found.map_err(|problem| anyhow!("{flag}: {problem}"))
    };
    Ok(Quantities {
        place_by: named("--place-by", &command.place_by)?,
        colour_by: named("--colour-by", &command.colour_by)?,
    })
}

/// The minima with the labels that the flags select.
fn leaves(
    command: &Draw,
    minima: &[MinimumRow],
    types: Option<&MinimumNames>,
) -> anyhow::Result<Vec<Leaf>> {
    let mut leaves: Vec<Leaf> = minima.iter().map(leaf).collect();
    if let (Some(differences), Some(types)) = (command.colour, types) {
        for (leaf, label) in leaves.iter_mut().zip(types.labels(differences.into())) {
            leaf.label = Some(label);
        }
    }
    if let Some(path) = &command.stability {
        let held = held(path)?;
        for (leaf, minimum) in leaves.iter_mut().zip(minima) {
            leaf.label = Some(mark(&minimum.members, &held).to_owned());
        }
    }
    Ok(leaves)
}

/// Parses names such as `m3` or `3`.
fn picked(names: &[String], count: usize) -> anyhow::Result<Vec<MinimumId>> {
    let number = |name: &String| minimum_named("pick", name, count);
    names.iter().map(number).collect()
}

fn leaf(minimum: &MinimumRow) -> Leaf {
    Leaf {
        members: minimum.members.len(),
        label: minimum.label().map(str::to_owned),
        caption: None,
    }
}

/// Outcome of most simulated members of a minimum.
fn mark(members: &[u64], held: &BTreeMap<u64, bool>) -> &'static str {
    let known: Vec<bool> = members
        .iter()
        .filter_map(|id| held.get(id).copied())
        .collect();
    let stable = known.iter().filter(|held| **held).count();
    match known.len() {
        0 => "not simulated",
        all if 2 * stable >= all => "stable",
        _ => "unstable",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minima_are_marked_by_most_of_their_members() {
        let held = BTreeMap::from([(1, true), (2, false), (3, false)]);
        assert_eq!(mark(&[1, 9], &held), "stable");
        assert_eq!(mark(&[1, 2], &held), "stable");
        assert_eq!(mark(&[1, 2, 3], &held), "unstable");
        assert_eq!(mark(&[9], &held), "not simulated");
    }

    #[test]
    fn minima_are_picked_by_name() {
        let names = ["m3", "0"].map(str::to_owned);
        assert_eq!(picked(&names, 4).unwrap(), [3, 0].map(MinimumId));
        let names = "write minima as the tree names them";
        for (name, said) in [("m4", "m0 to m3"), ("x", names), ("-1", names)] {
            let error = picked(&[name.to_owned()], 4).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
    }
}
