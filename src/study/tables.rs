//! The rows of a landscape's tables, and its pictures.

use std::collections::BTreeMap;

use petgraph::visit::EdgeRef;
use rayon::prelude::*;
use serde_json::Value;

use super::drawing::{Drawing, Titles, Views};
use super::error::StudyError;
use super::uncertainty::Uncertainty;
use super::ways::Way;
use super::{json, median, tally};
use crate::energy::Energy;
use crate::figure::Leaf;
use crate::store::{
    AtomicFolder, Counts, EdgeRow, LandscapeFiles, Manifest, MinimumRow, PathPoint, StoreError,
    write_attempts,
};
use crate::topography::exchange::{Database, Layout};
use crate::topography::{self, Evidence, Families, FamilySettings, Landscape, Merge, Network};

pub(super) struct Mapped<'a> {
    pub(super) landscape: &'a Landscape,
    pub(super) energy: &'a dyn Energy,
    /// The input points. Members of minima are row numbers of this list.
    pub(super) inputs: Vec<Input>,
    /// What each connection is; empty if the energy does not tell.
    pub(super) ways: Vec<Option<Way>>,
}

pub(super) struct Input {
    pub(super) id: u64,
    pub(super) label: Option<String>,
}

impl Mapped<'_> {
    /// Most frequent label of the members of a minimum.
    fn label(&self, members: &[usize]) -> Option<String> {
        let labels = members
            .iter()
            .filter_map(|&row| self.inputs[row].label.as_deref());
        tally(labels).into_iter().next().map(|(label, _)| label)
    }

    fn minima(&self) -> Vec<MinimumRow> {
        let minima = self
            .landscape
            .network
            .node_weights()
            .zip(self.landscape.families.family_of());
        let row = |(id, (minimum, family)): (usize, (&topography::Minimum, usize))| {
            let members = || minimum.members.iter().map(|&row| &self.inputs[row]);
            MinimumRow {
                id: id as u64,
                energy: minimum.energy,
                coordinates: minimum.coordinates.clone(),
                members: members().map(|input| input.id).collect(),
                family: family as u64,
                labels: tally(members().filter_map(|input| input.label.as_deref()))
                    .into_iter()
                    .map(|(label, count)| (label, count as u64))
                    .collect(),
            }
        };
        minima.enumerate().map(row).collect()
    }

    fn edges(&self) -> Vec<EdgeRow> {
        let network = &self.landscape.network;
        let least = |barriers: &[Option<f64>]| barriers.iter().flatten().copied().reduce(f64::min);
        network
            .edge_references()
            .zip(&self.landscape.connections)
            .enumerate()
            .map(|(number, (edge, connection))| {
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
                    chains_forward: connection.forward.iter().flatten().copied().collect(),
                    chains_backward: connection.backward.iter().flatten().copied().collect(),
                    chain_runs: (connection.forward.len() + connection.backward.len()) as u64,
                    evaluations: connection.evaluations as u64,
                    way: (self.ways.get(number).copied().flatten())
                        .map(|way| way.name().to_owned()),
                }
            })
            .collect()
    }

    fn paths(&self) -> Vec<PathPoint> {
        let paths: Vec<Vec<PathPoint>> = self
            .landscape
            .connections
            .par_iter()
            .map(|connection| {
                let top = connection.path.top();
                let images = connection.path.images.iter().zip(&connection.path.energies);
                images
                    .enumerate()
                    .map(|(image, (x, energy))| PathPoint {
                        a: connection.from.0 as u64,
                        b: connection.to.0 as u64,
                        image: image as u64,
                        coordinates: x.clone(),
                        energy: *energy,
                        terms: (image == top)
                            .then(|| self.energy.terms(x).into_iter().map(|(_, v)| v).collect()),
                    })
                    .collect()
            })
            .collect();
        paths.into_iter().flatten().collect()
    }

    /// The tables, and a manifest with what all landscapes have. `manifest` has what is particular to this one.
    pub(super) fn files(&self, manifest: Manifest) -> LandscapeFiles {
        let edges = self.edges();
        let counts = Counts {
            minima: self.landscape.network.node_count() as u64,
            families: self.landscape.families.members.len() as u64,
            pairs: edges.len() as u64,
            components: self.landscape.tree.roots.len() as u64,
            ..manifest.counts
        };
        LandscapeFiles {
            manifest: Manifest {
                program_version: env!("CARGO_PKG_VERSION").to_owned(),
                family_barrier: Some(self.landscape.families.barrier),
                counts,
                evidence: self.evidence(),
                ..manifest
            },
            minima: self.minima(),
            edges,
            paths: self.paths(),
        }
    }

    /// Manifest entries about merges and families.
    pub(super) fn findings(
        &self,
        merges: &[Merge],
        uncertainty: &Uncertainty,
    ) -> BTreeMap<String, Value> {
        let evidence = tally(merges.iter().map(|merge| merge.evidence.name()));
        let terms = tally(merges.iter().filter_map(|merge| merge.term.as_deref()));
        let depth = median(merges.iter().map(|merge| merge.depth).collect());
        let findings = [
            ("median_merge_depth", json(depth)),
            ("evidence_of_merges", json(evidence)),
            ("dominating_terms_of_merges", json(terms)),
            ("family_scan", json(&self.landscape.families.scan)),
            ("merges", json(&uncertainty.merges)),
            ("searches", json(&uncertainty.searches)),
            ("rarefaction", uncertainty.unseen.to_json()),
        ];
        findings
            .map(|(name, value)| (name.to_owned(), value))
            .into()
    }

    fn evidence(&self) -> BTreeMap<String, u64> {
        let counts = self.landscape.tally().into_iter();
        counts
            .map(|(evidence, count)| (evidence.name().to_owned(), count as u64))
            .collect()
    }

    /// Writes trees and graphs as text and pictures, and the minima and passes as `min.data` and `ts.data`.
    pub(super) fn draw(
        &self,
        titles: &Titles,
        views: Views,
        database: &Database,
        family_names: Vec<String>,
        folder: &AtomicFolder,
    ) -> Result<(), StudyError> {
        let network = &self.landscape.network;
        let leaves = network.node_weights().map(|minimum| Leaf {
            members: minimum.members.len(),
            label: self.label(&minimum.members),
            caption: None,
        });
        write_database(database, folder)?;
        write_attempts(&self.landscape.attempts.list, folder)?;
        let drawing = Drawing {
            attempts: Some(&self.landscape.attempts),
            family_of: self.landscape.families.family_of(),
            family_names,
            views,
            ..Drawing::new(network, &self.landscape.tree, leaves.collect(), titles)
        };
        drawing.write(&mut |name, bytes| folder.write(name, bytes))
    }
}

/// Family numbers (without gaps) of the minima of a finished landscape, from the file or at another barrier.
pub(crate) fn family_of(
    files: &LandscapeFiles,
    network: &Network,
    barrier: Option<f64>,
) -> Vec<usize> {
    if let Some(barrier) = barrier {
        let families = Families::below(network, barrier, FamilySettings::default().worst);
        return families.family_of();
    }
    let mut names: Vec<u64> = files.minima.iter().map(|minimum| minimum.family).collect();
    names.sort_unstable();
    names.dedup();
    let places = files.minima.iter();
    places
        .map(|minimum| names.partition_point(|name| *name < minimum.family))
        .collect()
}

/// Writes `min.data` and `ts.data` in PATHSAMPLE's layout.
pub(super) fn write_database(database: &Database, folder: &AtomicFolder) -> Result<(), StoreError> {
    let minima = database.min_data(Layout::Pathsample);
    folder.write("min.data", minima.as_bytes())?;
    let states = database.ts_data(Layout::Pathsample);
    folder.write("ts.data", states.as_bytes())
}

pub(super) fn upper_bounds(merges: &[Merge]) -> Vec<String> {
    let mut lines: Vec<String> = merges
        .iter()
        .filter(|merge| merge.evidence > Evidence::Path)
        .map(|merge| {
            format!(
                "| m{}, m{} | {:.3} | {} |",
                merge.ends[0].0,
                merge.ends[1].0,
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
