//! The cases of a comparison: the minima of a landscape, what they are called, and how far they are apart.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context;
use rayon::prelude::*;

use crate::agreement::PairMatrix;
use crate::cli::input::open_landscape;
use crate::evaluation::taxonomy::{Anatomy, Candidate, Patch, Rule, Taxonomy, touches};
use crate::hand::PosedHand;
use crate::space::{PoseSpace, Space, Symmetry};
use crate::store::MinimumRow;
use crate::study::{GraspSetting, MinimumName, group_of};
use crate::topography::{Ancestors, Evidence, MinimumId, Tree};

/// A minimum and its label.
pub(super) struct Basin {
    pub(super) grasps: f64,
    /// Number of the type, where the label is one.
    pub(super) grasp_type: Option<u8>,
    /// Power, intermediate or precision as a number, where the label is a type or a cell.
    pub(super) category: Option<usize>,
    pub(super) cell: Option<String>,
    /// The category of the type that fits best, however badly.
    pub(super) unfiltered: Option<usize>,
    /// Types that fit best.
    pub(super) best: Vec<Candidate>,
}

/// What a landscape is compared by.
pub(super) struct Basins {
    pub(super) name: String,
    pub(super) minima: Vec<Basin>,
    /// Whether the taxonomy says anything of the hand.
    pub(super) applicable: bool,
    /// Minima whose label is a human's or was written into the file.
    pub(super) labelled_in_file: usize,
    /// Relative barrier up to which minima form one group, and the number of groups.
    pub(super) group_barrier: f64,
    pub(super) groups: usize,
    /// Lowest height at which two minima are joined; NaN where nothing joins them.
    pub(super) saddles: PairMatrix,
    /// That above the higher of the two.
    pub(super) barriers: PairMatrix,
    pub(super) energy_gaps: PairMatrix,
    /// 1 − Σ min / Σ max over the areas in touch, patch by patch.
    pub(super) contact_distances: PairMatrix,
    pub(super) pose_distances: PairMatrix,
}

impl Basins {
    /// Reads a landscape; with another barrier of groups, if one is given.
    pub(super) fn read(
        folder: &Path,
        rule: &Rule,
        group_barrier: Option<f64>,
    ) -> anyhow::Result<Self> {
        let files = open_landscape(folder)?;
        let name = folder.display().to_string();
        let manifest = &files.manifest;
        let setting = GraspSetting::of(&files, &name)?;
        let (hand, object) = (&setting.hand, &setting.object);
        let network = files.network(folder)?;
        let tree = Tree::from_network(&network, Evidence::Chain);
        let names = setting.names(&files, rule);
        let anatomy = Anatomy::of(hand);
        let areas: Vec<BTreeMap<Patch, f64>> = match &anatomy {
            None => vec![BTreeMap::new(); files.minima.len()],
            Some(anatomy) => (files.minima.par_iter())
                .map(|row| {
                    let mut posed = PosedHand::default();
                    hand.pose(&row.coordinates, &mut posed);
                    let mut areas = BTreeMap::new();
                    for (touch, _) in touches(hand, anatomy, &posed, object) {
                        *areas.entry(touch.patch).or_insert(0.0) += touch.weight_mm2;
                    }
                    areas
                })
                .collect(),
        };
        let space = PoseSpace::new(
            hand.pose_metric().clone(),
            Symmetry::clone(&object.symmetry),
        );
        let rows = &files.minima;
        let size = rows.len();
        let ancestors = Ancestors::of(&tree);
        let minimax = |i: usize, j: usize| {
            (ancestors.joint(MinimumId(i), MinimumId(j)))
                .map(|node| tree.nodes[node.0].energy)
                .filter(|height| height.is_finite())
                .unwrap_or(f64::NAN)
        };
        let saddles = PairMatrix::from_fn(size, minimax);
        Ok(Self {
            applicable: anatomy.is_some(),
            labelled_in_file: rows.iter().filter(|row| !row.labels.is_empty()).count(),
            groups: (group_of(&files, &network, group_barrier).iter().max())
                .map_or(0, |last| last + 1),
            group_barrier: group_barrier
                .or(manifest.group_barrier)
                .context("the landscape does not tell its group barrier")?,
            barriers: PairMatrix::from_fn(size, |i, j| {
                saddles.get(i, j) - rows[i].energy.max(rows[j].energy)
            }),
            energy_gaps: PairMatrix::from_fn(size, |i, j| (rows[i].energy - rows[j].energy).abs()),
            contact_distances: PairMatrix::from_fn(size, |i, j| apart(&areas[i], &areas[j])),
            pose_distances: PairMatrix::from_fn(size, |i, j| {
                space.distance(&rows[i].coordinates, &rows[j].coordinates)
            }),
            minima: rows
                .iter()
                .zip(names)
                .map(|(row, named)| basin(row, named))
                .collect(),
            saddles,
            name,
        })
    }

    /// The landscape of some of its minima only.
    pub(super) fn cases(&self, keep: impl Fn(&Basin) -> bool) -> Vec<usize> {
        let numbered = self.minima.iter().enumerate();
        numbered
            .filter(|(_, basin)| keep(basin))
            .map(|(i, _)| i)
            .collect()
    }
}

fn basin(row: &MinimumRow, named: MinimumName) -> Basin {
    let best = named.rule.best.first();
    let unfiltered = best.and_then(|best| Taxonomy::feix().numbered(best.number));
    Basin {
        grasps: row.members.len().max(1) as f64,
        grasp_type: named.number,
        category: named.category.map(|category| category as usize),
        cell: named.cell,
        unfiltered: unfiltered.map(|entry| entry.category as usize),
        best: named.rule.best,
    }
}

/// 1 − Σ min / Σ max (Ruzicka): 0 of equal areas, 1 where no patch is shared; 0 of two that touch nothing.
fn apart(one: &BTreeMap<Patch, f64>, other: &BTreeMap<Patch, f64>) -> f64 {
    let area =
        |areas: &BTreeMap<Patch, f64>, patch: &Patch| areas.get(patch).copied().unwrap_or(0.0);
    let (mut least, mut most) = (0.0, 0.0);
    for patch in one
        .keys()
        .chain(other.keys().filter(|patch| !one.contains_key(patch)))
    {
        let (a, b) = (area(one, patch), area(other, patch));
        least += a.min(b);
        most += a.max(b);
    }
    if most > 0.0 { 1.0 - least / most } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::taxonomy::PalmPart;

    #[test]
    fn contact_distance_is_one_without_shared_patches() {
        let [volar, web] = [PalmPart::Volar, PalmPart::Web].map(Patch::Palm);
        let one = BTreeMap::from([(volar, 2.0), (web, 1.0)]);
        let other = BTreeMap::from([(volar, 1.0)]);
        let none = BTreeMap::from([(web, 3.0)]);
        assert!(apart(&one, &one).abs() < 1e-15);
        assert!((apart(&one, &other) - (1.0 - 1.0 / 3.0)).abs() < 1e-15);
        assert!((apart(&other, &none) - 1.0).abs() < 1e-15);
        assert!(apart(&BTreeMap::new(), &BTreeMap::new()).abs() < 1e-15);
    }
}
