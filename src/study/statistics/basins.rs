//! Input of the statistics: the minima of a landscape, their labels and their distances.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;

use super::StatisticsSettings;
use crate::agreement::PairMatrix;
use crate::evaluation::taxonomy::{
    Anatomy, Candidate, Inapplicable, Patch, Rule, Taxonomy, touches,
};
use crate::hand::PosedHand;
use crate::space::{PoseSpace, Space, Symmetry};
use crate::store::{LandscapeFiles, MinimumRow};
use crate::study::error::StudyError;
use crate::study::tables::family_of;
use crate::study::{GraspSetting, MinimumName};
use crate::topography::{Ancestors, Evidence, MinimumId, Network, Tree};

/// A landscape of grasps whose minima are named.
#[derive(Debug)]
pub struct NamedLandscape<'a> {
    /// Name of the landscape in texts.
    pub name: String,
    /// Files of the landscape.
    pub files: &'a LandscapeFiles,
    /// Hand and object.
    pub setting: GraspSetting,
    /// Its network.
    pub network: Network,
    /// The tree of merges.
    pub tree: Tree,
    /// Taxonomy names of the minima. Labels given when the landscape was built override the rule.
    pub names: Vec<MinimumName>,
    /// The labelling rule.
    pub rule: &'a Rule,
}

impl<'a> NamedLandscape<'a> {
    /// Names the minima of the landscape in `folder`.
    ///
    /// # Errors
    /// If it is not a landscape of grasps, or if its rows do not fit each other, its hand or its object.
    pub fn of(
        files: &'a LandscapeFiles,
        folder: &Path,
        rule: &'a Rule,
    ) -> Result<Self, StudyError> {
        let name = folder.display().to_string();
        let setting = GraspSetting::of(files, &name)?;
        let network = files.network(folder)?;
        Ok(Self {
            tree: Tree::from_network(&network, Evidence::Chain),
            names: setting.names(files, rule),
            name,
            files,
            setting,
            network,
            rule,
        })
    }
}

/// A minimum with its labels.
#[derive(Debug)]
pub struct Basin {
    /// Number of its grasps.
    pub grasps: f64,
    /// Number of the type, if the label is a type.
    pub grasp_type: Option<u8>,
    /// Power, intermediate or precision as a number, if the label is a type or a cell.
    pub category: Option<usize>,
    /// The cell of the taxonomy's table, if the label is a type or a cell.
    pub cell: Option<String>,
    /// Category of the best-fitting type, however bad its fit.
    pub unfiltered: Option<usize>,
    /// The best-fitting types, best first.
    pub best: Vec<Candidate>,
    /// How well the type that fits best fits, 0 to 1.
    pub fit: f64,
}

/// The quantities of a landscape that are compared.
#[derive(Debug)]
pub struct Basins {
    /// Name of the landscape in texts.
    pub name: String,
    /// The minima.
    pub minima: Vec<Basin>,
    /// Why the labelling rule does not apply to the hand, if so.
    pub inapplicable: Option<Inapplicable>,
    /// Number of minima whose label is from a human or from the file.
    pub labelled_in_file: usize,
    /// Relative barrier of the families.
    pub family_barrier: f64,
    /// Number of families.
    pub families: usize,
    /// Lowest height at which two minima are joined; NaN if they are not.
    pub saddles: PairMatrix,
    /// The same above the higher minimum.
    pub barriers: PairMatrix,
    /// Differences in energy.
    pub energy_gaps: PairMatrix,
    /// 1 − Σ min / Σ max over the contact areas of all patches.
    pub contact_distances: PairMatrix,
    /// Distances of the poses.
    pub pose_distances: PairMatrix,
}

impl Basins {
    pub(super) fn of(
        landscape: &NamedLandscape<'_>,
        family_barrier: Option<f64>,
    ) -> Result<Self, StudyError> {
        let NamedLandscape {
            files,
            network,
            tree,
            ..
        } = landscape;
        let (hand, object) = (&landscape.setting.hand, &landscape.setting.object);
        let anatomy = Anatomy::of(hand);
        let areas: Vec<BTreeMap<Patch, f64>> = match &anatomy {
            Err(_) => vec![BTreeMap::new(); files.minima.len()],
            Ok(anatomy) => (files.minima.par_iter())
                .map(|row| {
                    let mut posed = PosedHand::default();
                    hand.pose(&row.coordinates, &mut posed);
                    let mut areas = BTreeMap::new();
                    for touch in touches(hand, anatomy, &posed, object) {
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
        let ancestors = Ancestors::of(tree);
        let minimax = |i: usize, j: usize| {
            (ancestors.joint(MinimumId(i), MinimumId(j)))
                .map(|node| tree.nodes[node.0].energy)
                .filter(|height| height.is_finite())
                .unwrap_or(f64::NAN)
        };
        let saddles = PairMatrix::from_fn(size, minimax);
        Ok(Self {
            inapplicable: anatomy.as_ref().err().copied().map(Inapplicable::Hand),
            labelled_in_file: rows.iter().filter(|row| !row.labels.is_empty()).count(),
            families: (family_of(files, network, family_barrier).iter().max())
                .map_or(0, |last| last + 1),
            family_barrier: family_barrier
                .or(files.manifest.family_barrier)
                .ok_or(StudyError::NoFamilyBarrier)?,
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
                .zip(&landscape.names)
                .map(|(row, named)| basin(row, named))
                .collect(),
            saddles,
            name: landscape.name.clone(),
        })
    }

    /// The minima that `keep` holds of, by number.
    pub fn cases(&self, keep: impl Fn(&Basin) -> bool) -> Vec<usize> {
        let numbered = self.minima.iter().enumerate();
        numbered
            .filter(|(_, basin)| keep(basin))
            .map(|(i, _)| i)
            .collect()
    }
}

/// Some of the minima with their labels, and the matrices between them.
#[derive(Debug)]
pub struct Part {
    /// Their numbers among all minima.
    pub cases: Vec<usize>,
    /// Class of each.
    pub labels: Vec<usize>,
    /// Block of each: labels are permuted within a block.
    pub blocks: Vec<usize>,
    /// [`Basins::saddles`] between them.
    pub saddles: PairMatrix,
    /// [`Basins::barriers`] between them.
    pub barriers: PairMatrix,
    /// Numbers of their grasps.
    pub weights: Vec<f64>,
}

impl Part {
    /// The minima with a class by `label`. Unknown heights are above all others.
    pub fn new(
        basins: &Basins,
        settings: &StatisticsSettings,
        label: impl Fn(&Basin) -> Option<usize>,
    ) -> Self {
        let cases = basins.cases(|basin| label(basin).is_some());
        let chosen = |matrix: &PairMatrix| {
            matrix
                .chosen(&cases, f64::NAN)
                .raised(settings.censored_factor)
        };
        Self {
            labels: cases
                .iter()
                .filter_map(|&i| label(&basins.minima[i]))
                .collect(),
            blocks: vec![0; cases.len()],
            saddles: chosen(&basins.saddles),
            barriers: chosen(&basins.barriers),
            weights: cases.iter().map(|&i| basins.minima[i].grasps).collect(),
            cases,
        }
    }

    /// Weights of the barrier graph: exp(−relative barrier / b).
    pub fn graph(&self, family_barrier: f64) -> PairMatrix {
        let scale = family_barrier.max(f64::MIN_POSITIVE);
        PairMatrix::from_fn(self.cases.len(), |i, j| {
            libm::exp(-self.barriers.get(i, j).max(0.0) / scale)
        })
    }
}

fn basin(row: &MinimumRow, named: &MinimumName) -> Basin {
    let best = named.rule.best.first();
    let unfiltered = best.and_then(|best| Taxonomy::feix().numbered(best.number));
    Basin {
        grasps: row.members.len().max(1) as f64,
        grasp_type: named.number,
        category: named.category.map(|category| category as usize),
        cell: named.cell.clone(),
        unfiltered: unfiltered.map(|entry| entry.category as usize),
        best: named.rule.best.clone(),
        fit: named.rule.fit,
    }
}

/// 1 − Σ min / Σ max (Ruzicka): 0 for equal areas (even if both are empty), 1 if no patch is shared.
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
