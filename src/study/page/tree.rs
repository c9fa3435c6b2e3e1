//! Tree and graph of a page, with the coordinates of `figure/layout`: the page and the pictures agree.

use serde_json::{Value, json};

use super::pack::Pack;
use crate::figure::layout::place;
use crate::figure::{BarrierPicture, PlacedGraph};
use crate::store::{LandscapeFiles, MinimumRow};
use crate::study::error::StudyError;
use crate::study::tables::family_of;
use crate::topography::view::{View, network_of_families, restricted};
use crate::topography::{Attempts, Evidence, MinimumId, Network, Searched, Tree};

/// Names of the kinds of evidence, by their number in the arrays.
pub(super) const EVIDENCE: [Evidence; 5] = [
    Evidence::Saddle,
    Evidence::Given,
    Evidence::Path,
    Evidence::Chain,
    Evidence::None,
];

/// Width and height of the sheet of a graph: about those of its panel.
const SHEET: [u32; 2] = [940, 1060];

/// Number of a kind of evidence in the arrays.
pub(super) fn number(evidence: Evidence) -> u8 {
    let place = EVIDENCE.iter().position(|kind| *kind == evidence);
    place
        .and_then(|place| u8::try_from(place).ok())
        .unwrap_or(u8::MAX)
}

/// Number of a minimum or node, with the greatest number for none.
fn optional(node: Option<usize>) -> usize {
    node.unwrap_or(u32::MAX as usize)
}

/// The merge tree: leaves are the first nodes, node i is minimum i.
pub(super) fn tree(tree: &Tree, attempts: &Attempts, pack: &mut Pack) -> Value {
    let layout = place(tree);
    let nodes = || tree.nodes.iter();
    let energies: Vec<f64> = nodes().map(|node| node.energy).collect();
    let searched = attempts.of_merges(tree);
    let counts = |count: fn(&Searched) -> usize| {
        searched
            .iter()
            .map(move |found| found.as_ref().map_or(0, count))
    };
    json!({
        "width": layout.width,
        "x": pack.floats(&layout.x),
        "energy": pack.doubles(&energies),
        "parent": pack.wholes(nodes().map(|node| optional(node.parent.map(|parent| parent.0)))),
        "evidence": pack.bytes(nodes().map(|node| number(node.evidence))),
        "support": pack.known_floats(searched.iter().map(|found| found.map(|found| found.support()))),
        "searches": pack.wholes(counts(|found| found.searches)),
        "ended": pack.wholes(counts(|found| found.ended_here)),
        "uncertainty": pack.known_floats(searched.iter().map(|found| found.map(|found| found.uncertainty))),
        "order": pack.wholes(layout.leaves.iter().copied()),
        "tested": searched.iter().any(Option::is_some),
    })
}

/// What the circles of a graph are: each stands for a minimum, or for a family at its lowest minimum.
struct Circles {
    network: Network,
    /// The minimum that each circle shows.
    minima: Vec<usize>,
    are_families: bool,
}

impl Circles {
    fn of(files: &LandscapeFiles, network: &Network, tree: &Tree) -> Self {
        let most = BarrierPicture::MOST_NODES;
        if network.node_count() <= most {
            return Self {
                network: network.clone(),
                minima: (0..network.node_count()).collect(),
                are_families: false,
            };
        }
        let families = family_of(files, network, None);
        let mut lowest = vec![usize::MAX; families.iter().max().map_or(0, |family| family + 1)];
        for (minimum, family) in families.iter().enumerate() {
            // Minima are sorted by energy.
            lowest[*family] = lowest[*family].min(minimum);
        }
        let all = network_of_families(network, &families);
        if all.node_count() <= most {
            return Self {
                network: all,
                minima: lowest,
                are_families: true,
            };
        }
        let view = View::whole(&crate::figure::layout::collapse(tree, &families)).deepest(most);
        Self {
            network: restricted(&all, &view.minima, Evidence::Chain),
            minima: view
                .minima
                .iter()
                .map(|MinimumId(family)| lowest[*family])
                .collect(),
            are_families: true,
        }
    }
}

/// The barrier graph of the minima, or of the families if there are more minima than a picture can show.
///
/// # Errors
/// If an energy is not finite.
pub(super) fn graph(
    files: &LandscapeFiles,
    network: &Network,
    tree: &Tree,
    pack: &mut Pack,
) -> Result<Value, StudyError> {
    let circles = Circles::of(files, network, tree);
    let mut picture = BarrierPicture::new(&circles.network);
    picture.seed = files.manifest.seed;
    picture.size = SHEET;
    let PlacedGraph {
        points,
        radii,
        lines,
    } = picture.placed()?;
    let places = |axis: usize| points.iter().map(|point| point[axis]).collect::<Vec<_>>();
    let end = |end: usize| lines.iter().map(move |line| line.link.ends[end]);
    let heights: Vec<f64> = lines.iter().map(|line| line.link.height).collect();
    let widths: Vec<f64> = lines.iter().map(|line| line.width).collect();
    Ok(json!({
        "size": picture.size,
        "of": if circles.are_families { "families" } else { "minima" },
        "minimum": pack.wholes(circles.minima.iter().copied()),
        "x": pack.floats(&places(0)),
        "y": pack.floats(&places(1)),
        "radius": pack.floats(&radii),
        "a": pack.wholes(end(0)),
        "b": pack.wholes(end(1)),
        "height": pack.doubles(&heights),
        "width": pack.floats(&widths),
        "evidence": pack.bytes(lines.iter().map(|line| number(line.link.evidence))),
        "is_lowest": pack.bytes(lines.iter().map(|line| u8::from(line.is_lowest))),
    }))
}

/// Numbers of the families of the minima as the landscape has them.
pub(super) fn families(minima: &[MinimumRow], pack: &mut Pack) -> Value {
    let family = |row: &MinimumRow| usize::try_from(row.family).unwrap_or(usize::MAX);
    pack.wholes(minima.iter().map(family))
}
