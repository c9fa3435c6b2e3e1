//! What `landscape build` writes: tables, pictures, and the summary a person reads.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context;
use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;
use rayon::prelude::*;

use super::build::tally;
use crate::energy::Energy;
use crate::figure::{BarrierPicture, DisconnectivityPicture, Leaf};
use crate::grasp::GraspEnergy;
use crate::grasp::hover::HoverCost;
use crate::store::{
    Counts, EdgeRow, Grasp, LandscapeFiles, Manifest, MinimumRow, PathRow, Population, Source,
};
use crate::topography::{Evidence, Landscape, MapSettings, MinimumId, Tree, decisive};

/// A mapped population and everything that describes it.
pub(super) struct Mapped<'a> {
    pub(super) landscape: &'a Landscape,
    pub(super) energy: &'a GraspEnergy,
    pub(super) grasps: &'a [&'a Grasp],
    pub(super) population: &'a Population<'a>,
    pub(super) settings: &'a MapSettings,
    pub(super) hover: &'a [HoverCost],
    pub(super) source: Source,
    pub(super) command: String,
    pub(super) seed: u64,
    pub(super) quench_evaluations: usize,
    pub(super) warnings: Vec<String>,
}

/// A merge of the tree: the edge that makes it.
struct Merge {
    ends: [usize; 2],
    height: f64,
    evidence: Evidence,
    term: Option<String>,
    /// Height above the lowest minimum of the shallower of the two sides.
    depth: f64,
}

impl Mapped<'_> {
    fn group_of(&self) -> Vec<usize> {
        let mut group_of = vec![0; self.landscape.network.node_count()];
        for (group, members) in self.landscape.groups.members.iter().enumerate() {
            for member in members {
                group_of[member.0] = group;
            }
        }
        group_of
    }

    /// Label of most labelled members of a minimum: the human label, else the automatic one.
    fn label(&self, members: &[usize]) -> Option<String> {
        tally(members.iter().filter_map(|&row| label_of(self.grasps[row])))
            .into_iter()
            .next()
            .map(|(label, _)| label)
    }

    /// The edges that make the tree, by rising height.
    fn merges(&self) -> Vec<Merge> {
        let network = &self.landscape.network;
        let energies: Vec<f64> = network
            .node_weights()
            .map(|minimum| minimum.energy)
            .collect();
        let mut bottom = energies.clone();
        let mut sets = petgraph::unionfind::UnionFind::new(energies.len());
        let mut edges: Vec<_> = decisive(network, Evidence::Chain);
        edges.sort_by(|a, b| {
            network[*a]
                .height
                .total_cmp(&network[*b].height)
                .then(a.cmp(b))
        });
        let mut merges = Vec::new();
        for edge in edges {
            let Some((a, b)) = network.edge_endpoints(edge) else {
                continue;
            };
            let (one, two) = (sets.find(a.index()), sets.find(b.index()));
            let (low, high) = (bottom[one].min(bottom[two]), bottom[one].max(bottom[two]));
            sets.union(one, two);
            bottom[sets.find(one)] = low;
            let weight = &network[edge];
            merges.push(Merge {
                ends: [a.index(), b.index()],
                height: weight.height,
                evidence: weight.evidence,
                term: weight.term.clone(),
                depth: weight.height - high,
            });
        }
        merges
    }
}

fn label_of(grasp: &Grasp) -> Option<&str> {
    grasp.label.as_deref().or(grasp.label_auto.as_deref())
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// The Parquet tables and the manifest.
pub(super) fn tables(mapped: &Mapped<'_>) -> anyhow::Result<LandscapeFiles> {
    let network = &mapped.landscape.network;
    let group_of = mapped.group_of();
    let minima = network
        .node_weights()
        .zip(&group_of)
        .enumerate()
        .map(|(id, (minimum, group))| MinimumRow {
            id: id as u64,
            energy: minimum.energy,
            coordinates: minimum.coordinates.clone(),
            choice: minimum.choice.clone(),
            members: minimum
                .members
                .iter()
                .map(|&row| mapped.grasps[row].id)
                .collect(),
            group: *group as u64,
            labels: tally(
                minimum
                    .members
                    .iter()
                    .filter_map(|&row| label_of(mapped.grasps[row])),
            )
            .into_iter()
            .map(|(label, count)| (label, count as u64))
            .collect(),
        })
        .collect();
    let least = |barriers: &[Option<f64>]| barriers.iter().flatten().copied().reduce(f64::min);
    let edges: Vec<EdgeRow> = network
        .edge_references()
        .zip(&mapped.landscape.connections)
        .map(|(edge, connection)| {
            let weight = edge.weight();
            let floor = network[edge.source()]
                .energy
                .max(network[edge.target()].energy);
            let height = weight.height.is_finite().then_some(weight.height);
            EdgeRow {
                a: edge.source().index() as u64,
                b: edge.target().index() as u64,
                height,
                relative_barrier: height.map(|height| height - floor),
                length: height.map(|_| weight.length),
                evidence: weight.evidence.name().to_owned(),
                term: weight.term.clone(),
                chain_forward: least(&connection.forward),
                chain_backward: least(&connection.backward),
                evaluations: connection.evaluations as u64,
            }
        })
        .collect();
    let paths: Vec<Vec<PathRow>> = mapped
        .landscape
        .connections
        .par_iter()
        .map(|connection| {
            let top = connection.path.top();
            let images = connection.path.images.iter().zip(&connection.path.energies);
            images
                .enumerate()
                .map(|(image, (x, energy))| PathRow {
                    a: connection.from.0 as u64,
                    b: connection.to.0 as u64,
                    image: image as u64,
                    coordinates: x.clone(),
                    energy: *energy,
                    // Far above, where no contact set is any good, the best one is costly to find and says nothing.
                    choice: if *energy <= mapped.settings.path.exact_below {
                        mapped.energy.choice(x)
                    } else {
                        Vec::new()
                    },
                    terms: (image == top)
                        .then(|| mapped.energy.terms(x).into_iter().map(|(_, v)| v).collect()),
                })
                .collect()
        })
        .collect();
    let manifest = manifest(mapped, edges.len())?;
    Ok(LandscapeFiles {
        manifest,
        minima,
        edges,
        paths: paths.into_iter().flatten().collect(),
    })
}

fn manifest(mapped: &Mapped<'_>, pairs: usize) -> anyhow::Result<Manifest> {
    let landscape = mapped.landscape;
    let merges = mapped.merges();
    let mut findings = BTreeMap::new();
    findings.insert("hover_cost".to_owned(), serde_json::to_value(mapped.hover)?);
    findings.insert(
        "median_merge_depth".to_owned(),
        serde_json::to_value(median(merges.iter().map(|merge| merge.depth).collect()))?,
    );
    findings.insert(
        "evidence_of_merges".to_owned(),
        serde_json::to_value(tally(merges.iter().map(|merge| merge.evidence.name())))?,
    );
    findings.insert(
        "dominating_terms_of_merges".to_owned(),
        serde_json::to_value(tally(
            merges.iter().filter_map(|merge| merge.term.as_deref()),
        ))?,
    );
    findings.insert(
        "group_scan".to_owned(),
        serde_json::to_value(&landscape.groups.scan)?,
    );
    Ok(Manifest {
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        command: mapped.command.clone(),
        seed: mapped.seed,
        source: mapped.source.clone(),
        hand: Some(mapped.population.hand.clone()),
        object: Some(mapped.population.object.clone()),
        scale: mapped.population.scale,
        energy: serde_json::to_value(mapped.energy.settings())?,
        settings: serde_json::to_value(mapped.settings)?,
        terms: mapped.energy.term_names(),
        group_barrier: Some(landscape.groups.barrier),
        counts: Counts {
            grasps: mapped.grasps.len() as u64,
            minima: landscape.network.node_count() as u64,
            groups: landscape.groups.members.len() as u64,
            pairs: pairs as u64,
            components: landscape.tree.roots.len() as u64,
            evaluations: (landscape.evaluations + mapped.quench_evaluations) as u64,
        },
        evidence: landscape
            .tally()
            .into_iter()
            .map(|(evidence, count)| (evidence.name().to_owned(), count as u64))
            .collect(),
        findings,
        warnings: warnings(mapped, &merges),
    })
}

/// What a reader should know before trusting the landscape.
fn warnings(mapped: &Mapped<'_>, merges: &[Merge]) -> Vec<String> {
    let mut warnings = mapped.warnings.clone();
    let depth = median(merges.iter().map(|merge| merge.depth).collect());
    if let (Some(depth), Some(hover)) = (depth, mapped.hover.get(1))
        && hover.quartiles[1] < depth
    {
        warnings.push(format!(
            "hovering {:.0} mm off the object costs {:.3}, less than the median merge depth {depth:.3}: barriers \
             measure letting go, not force closure",
            hover.clearance_m * 1e3,
            hover.quartiles[1]
        ));
    }
    let unrelaxed = merges
        .iter()
        .filter(|merge| merge.evidence > Evidence::Path)
        .count();
    if unrelaxed > 0 {
        warnings.push(format!(
            "{unrelaxed} of {} merges rest on an upper bound (evidence `chain`): drawn dashed, listed in summary.md",
            merges.len()
        ));
    }
    warnings
}

/// The disconnectivity graph and the barrier graph, as SVG and PNG.
pub(super) fn pictures(mapped: &Mapped<'_>, folder: &Path) -> anyhow::Result<()> {
    let landscape = mapped.landscape;
    let leaves: Vec<Leaf> = landscape
        .network
        .node_weights()
        .map(|minimum| Leaf {
            members: minimum.members.len(),
            label: mapped.label(&minimum.members),
            caption: None,
        })
        .collect();
    let group_of = mapped.group_of();
    let (tree, left_out) = legible_tree(mapped);
    let title = format!(
        "{} grasps, {} hand on {}",
        mapped.grasps.len(),
        mapped.population.hand.name,
        mapped.population.object.name
    );
    let mut tree = DisconnectivityPicture::new(tree, &landscape.network);
    tree.leaves.clone_from(&leaves);
    tree.title = match left_out {
        Some((count, height)) => format!("{title} ({count} merges above {height:.2} not drawn)"),
        None => title.clone(),
    };
    if let Some((_, height)) = left_out {
        tree.apart = format!("apart: joined above {height:.2}");
    }
    tree.size = [1600, 900];
    "energy E(H, O)".clone_into(&mut tree.energy_label);
    "grasps".clone_into(&mut tree.members_label);
    let mut graph = BarrierPicture::new(&landscape.network);
    graph.leaves = leaves;
    graph.title = title;
    "energy E(H, O)".clone_into(&mut graph.energy_label);
    "grasps".clone_into(&mut graph.members_label);
    graph.seed = mapped.seed;
    let pictures = [
        ("disconnectivity", tree.grouped(&group_of).draw()?),
        ("disconnectivity_minima", tree.draw()?),
        ("barriers", graph.grouped(&group_of).draw()?),
        ("barriers_minima", graph.draw()?),
    ];
    for (name, canvas) in pictures {
        for ending in ["svg", "png"] {
            canvas
                .save(&folder.join(format!("{name}.{ending}")))
                .context("cannot draw")?;
        }
    }
    Ok(())
}

/// The tree as drawn: where the highest twentieth of the merges would squash the rest, it is cut below them, and how many
/// merges that leaves out above which height.
fn legible_tree(mapped: &Mapped<'_>) -> (Tree, Option<(usize, f64)>) {
    let heights: Vec<f64> = mapped.merges().iter().map(|merge| merge.height).collect();
    let whole = (mapped.landscape.tree.clone(), None);
    let Some((&highest, &usual)) = heights.last().zip(heights.get(heights.len() * 19 / 20)) else {
        return whole;
    };
    if highest < 2.0 * usual {
        return whole;
    }
    let network = mapped.landscape.network.filter_map(
        |_, node| Some(node.clone()),
        |_, edge| (edge.height <= usual).then(|| edge.clone()),
    );
    let left_out = heights.iter().filter(|height| **height > usual).count();
    (
        Tree::from_network(&network, Evidence::Chain),
        Some((left_out, usual)),
    )
}

/// `summary.md`, which is also what the terminal shows.
pub(super) fn summary(mapped: &Mapped<'_>, files: &LandscapeFiles) -> String {
    let merges = mapped.merges();
    let mut lines = overview(mapped, files, &merges);
    lines.extend(
        files
            .manifest
            .warnings
            .iter()
            .map(|warning| format!("Note: {warning}.\n")),
    );
    lines.extend(largest_groups(mapped));
    lines.extend(upper_bounds(&merges));
    lines.push(format!(
        "\nMade by `{}`, landscape {}.\n",
        files.manifest.command, files.manifest.program_version
    ));
    lines.join("\n")
}

fn overview(mapped: &Mapped<'_>, files: &LandscapeFiles, merges: &[Merge]) -> Vec<String> {
    let counts = &files.manifest.counts;
    let spell = |counts: &[(String, usize)]| {
        let parts: Vec<String> = counts
            .iter()
            .map(|(name, n)| format!("{n} {name}"))
            .collect();
        parts.join(", ")
    };
    let mut lines = vec![
        format!(
            "# {} grasps of the {} hand on {}\n",
            counts.grasps, mapped.population.hand.name, mapped.population.object.name
        ),
        format!(
            "- **{} minima** in **{} groups** (minima joined by relaxed connections with relative barrier up to {:.3})",
            counts.minima, counts.groups, mapped.landscape.groups.barrier
        ),
        format!(
            "- {} pairs connected; no path joins {} component(s) to the rest",
            counts.pairs,
            counts.components - 1
        ),
        format!(
            "- evidence of connections: {}",
            spell(&tally(
                files.edges.iter().map(|edge| edge.evidence.as_str())
            ))
        ),
        format!(
            "- evidence of merges: {}",
            spell(&tally(merges.iter().map(|merge| merge.evidence.name())))
        ),
        format!(
            "- what dominates the tops of merges: {}",
            spell(&tally(
                merges.iter().filter_map(|merge| merge.term.as_deref())
            ))
        ),
    ];
    if let Some(depth) = median(merges.iter().map(|merge| merge.depth).collect()) {
        lines.push(format!("- median merge depth: {depth:.3}"));
    }
    lines.extend(mapped.hover.iter().map(|hover| {
        format!(
            "- hovering {:.0} mm off the object costs {:.3} (quartiles {:.3} to {:.3}; {:.1} mm reached)",
            hover.clearance_m * 1e3,
            hover.quartiles[1],
            hover.quartiles[0],
            hover.quartiles[2],
            hover.reached_m * 1e3
        )
    }));
    lines.push(format!("- {} energy evaluations\n", counts.evaluations));
    lines
}

fn largest_groups(mapped: &Mapped<'_>) -> Vec<String> {
    let minimum = |id: &MinimumId| &mapped.landscape.network[NodeIndex::new(id.0)];
    let mut groups: Vec<(usize, usize, Vec<usize>, f64)> = mapped
        .landscape
        .groups
        .members
        .iter()
        .enumerate()
        .map(|(group, members)| {
            let rows = members
                .iter()
                .flat_map(|id| minimum(id).members.clone())
                .collect();
            let energies = members.iter().map(|id| minimum(id).energy);
            (
                group,
                members.len(),
                rows,
                energies.fold(f64::INFINITY, f64::min),
            )
        })
        .collect();
    groups.sort_by_key(|(group, _, rows, _)| (std::cmp::Reverse(rows.len()), *group));
    let mut lines = vec![
        "## Largest groups\n".to_owned(),
        "| group | minima | grasps | lowest energy | label |\n|---|---|---|---|---|".to_owned(),
    ];
    lines.extend(
        groups
            .into_iter()
            .take(12)
            .map(|(group, minima, rows, lowest)| {
                format!(
                    "| {group} | {minima} | {} | {lowest:.3} | {} |",
                    rows.len(),
                    mapped.label(&rows).unwrap_or_default()
                )
            }),
    );
    lines
}

fn upper_bounds(merges: &[Merge]) -> Vec<String> {
    let mut lines: Vec<String> = merges
        .iter()
        .filter(|merge| merge.evidence > Evidence::Path)
        .map(|merge| {
            format!(
                "| m{}, m{} | {:.3} | {} |",
                merge.ends[0],
                merge.ends[1],
                merge.height,
                merge.term.as_deref().unwrap_or("")
            )
        })
        .collect();
    if !lines.is_empty() {
        let header = "\n## Merges that rest on an upper bound\n\n| minima | height | dominating term |\n|---|---|---|";
        lines.insert(0, header.to_owned());
    }
    lines
}
