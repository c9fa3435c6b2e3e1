//! A finished landscape of grasps, to which others are added.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use petgraph::graph::NodeIndex;

use super::error::StudyError;
use super::{json, name_of};
use crate::energy::{Energy, Explain};
use crate::grasp::GraspEnergy;
use crate::store::{
    Fault, GraspFile, GraspRow, LandscapeFiles, Population, Source, StoreError, read_attempts,
};
use crate::topography::{
    Attempts, Connection, Evidence, Families, Landscape, MapSettings, MinimumId, Network,
    Path as MappedPath, Tree,
};

/// A finished landscape of grasps.
#[derive(Debug, Clone)]
pub struct EarlierLandscape {
    /// Its folder and the hash of its manifest.
    pub source: Source,
    /// The settings of its map, with the temperature and force that were chosen for it.
    pub settings: MapSettings,
    files: LandscapeFiles,
    grasps: GraspFile,
    attempts: Attempts,
    network: Network,
}

/// The grasps of an earlier landscape and those that are added to them.
#[derive(Debug, Clone)]
pub struct JoinedGrasps {
    /// Those of the earlier landscape, then the others.
    pub file: GraspFile,
    /// Number of grasps that the earlier landscape had already, and that are not added again.
    pub repeated: usize,
    /// Number of grasps whose ids the earlier landscape had given to others. They have new ones.
    pub renumbered: usize,
}

impl JoinedGrasps {
    /// Whether the earlier landscape had all grasps.
    pub fn are_known(&self, earlier: &EarlierLandscape) -> bool {
        self.file.grasps.len() == earlier.grasps()
    }
}

impl EarlierLandscape {
    /// Reads the folder of a landscape that `landscape build` made.
    ///
    /// # Errors
    /// If the folder is no landscape or damaged; if it was made from a surface, or by sequential ADELM, whose result depends on the order of arrival.
    pub fn read(folder: &Path) -> Result<Self, StudyError> {
        let name = folder.display().to_string();
        let files = LandscapeFiles::read(folder)?;
        if files.manifest.hand.is_none() {
            return Err(StudyError::NotOfGrasps(name));
        }
        if files.manifest.findings.contains_key("arrivals") {
            return Err(StudyError::Sequential(name));
        }
        let grasps = LandscapeFiles::grasps(folder)?;
        let grasps = grasps.ok_or_else(|| StudyError::NotOfGrasps(name.clone()))?;
        let settings = serde_json::from_value(files.manifest.settings.clone());
        let settings = settings.map_err(|source| StudyError::MapSettings {
            landscape: name,
            source,
        })?;
        let mut network = files.network(folder)?;
        let rows: BTreeMap<u64, usize> = (grasps.grasps.iter().enumerate())
            .map(|(row, grasp)| (grasp.id, row))
            .collect();
        for (row, minimum) in files.minima.iter().enumerate() {
            let members = minimum.members.iter().map(|id| {
                rows.get(id).copied().ok_or_else(|| StoreError::Row {
                    path: folder.join("minima.parquet"),
                    row,
                    fault: Fault::Unexpected {
                        column: "members".to_owned(),
                        value: id.to_string(),
                        expected: "the id of one of its grasps".to_owned(),
                    },
                })
            });
            let members = members.collect::<Result<_, _>>()?;
            network[NodeIndex::new(row)].members = members;
        }
        Ok(Self {
            source: Source {
                name: name_of(folder),
                content_hash: LandscapeFiles::content_hash(folder)?,
            },
            settings,
            attempts: read_attempts(folder, &files)?,
            files,
            grasps,
            network,
        })
    }

    /// Number of its grasps.
    pub fn grasps(&self) -> usize {
        self.grasps.grasps.len()
    }

    /// Number of its minima.
    pub fn minima(&self) -> usize {
        self.files.minima.len()
    }

    /// Energy evaluations spent on it.
    pub fn evaluations(&self) -> usize {
        usize::try_from(self.files.manifest.counts.evaluations).unwrap_or(usize::MAX)
    }

    /// Of the given populations the one whose hand, object and scale are those of this landscape.
    ///
    /// # Errors
    /// If there is none.
    pub fn same_population<'p>(
        &self,
        populations: Vec<Population<'p>>,
    ) -> Result<Population<'p>, StudyError> {
        let manifest = &self.files.manifest;
        let (hand, object) = (manifest.hand.as_ref(), manifest.object.as_ref());
        let same = |population: &Population<'_>| {
            let hand = hand.is_some_and(|hand| {
                hand.name == population.hand.name && hand.is_same_hand(population.hand)
            });
            let object = object.is_some_and(|object| {
                (&object.name, &object.content_hash)
                    == (&population.object.name, &population.object.content_hash)
            });
            hand && object && population.scale.to_bits() == manifest.scale.to_bits()
        };
        let found = populations.into_iter().find(same);
        found.ok_or_else(|| StudyError::OtherPopulation {
            landscape: self.source.name.clone(),
            hand: hand.map_or_else(String::new, |hand| hand.name.clone()),
            object: object.map_or_else(String::new, |object| object.name.clone()),
            scale: manifest.scale,
        })
    }

    /// The grasps of this landscape and those of `population` that it does not have. Two grasps are the same if their poses
    /// are, bit for bit.
    ///
    /// # Errors
    /// If the terms or the settings of the energy are others.
    pub fn joined(&self, population: &Population<'_>) -> Result<JoinedGrasps, StudyError> {
        let earlier = &self.grasps;
        let settings = [population.energy_settings(), &earlier.metadata.energy];
        let differ = settings[0] != settings[1] && settings.iter().all(|one| !one.is_null());
        if population.terms() != earlier.metadata.terms || differ {
            return Err(StudyError::OtherEnergy(self.source.name.clone()));
        }
        let pose = |row: &GraspRow| {
            let pose = row.grasp.pose.to_vec();
            pose.iter().map(|number| number.to_bits()).collect()
        };
        let known: BTreeSet<Vec<u64>> = earlier.grasps.iter().map(pose).collect();
        let new: Vec<&GraspRow> = (population.grasps.iter().copied())
            .filter(|row| !known.contains(&pose(row)))
            .collect();
        let taken: BTreeSet<u64> = earlier.grasps.iter().map(|row| row.id).collect();
        let used: BTreeSet<u64> = taken
            .iter()
            .copied()
            .chain(new.iter().map(|row| row.id))
            .collect();
        let last = used.last().copied().unwrap_or(0);
        // A file may use even the greatest number.
        let ids = (last..=u64::MAX).chain(0..=u64::MAX);
        let mut free = ids.filter(|id| !used.contains(id));
        let mut joined = JoinedGrasps {
            file: earlier.clone(),
            repeated: population.grasps.len() - new.len(),
            renumbered: 0,
        };
        for row in new {
            let mut row = row.clone();
            if taken.contains(&row.id)
                && let Some(id) = free.next()
            {
                row.id = id;
                joined.renumbered += 1;
            }
            joined.file.grasps.push(row);
        }
        Ok(joined)
    }

    /// The map, whose members are rows of [`JoinedGrasps::file`].
    ///
    /// # Errors
    /// If `energy` is not the energy of this landscape.
    pub(super) fn landscape(&self, energy: &GraspEnergy) -> Result<Landscape, StudyError> {
        let other = || StudyError::OtherEnergy(self.source.name.clone());
        if json(energy.settings()) != self.files.manifest.energy {
            return Err(other());
        }
        let mut gradient = vec![0.0; energy.space().tangents()];
        for minimum in &self.files.minima {
            let x = &minimum.coordinates;
            let same = x.len() == energy.space().coordinates()
                && (energy.evaluate(x, &mut gradient) - minimum.energy).abs()
                    <= self.settings.sameness.energy;
            if !same {
                return Err(other());
            }
        }
        let mut paths: BTreeMap<(u64, u64), MappedPath> = BTreeMap::new();
        for point in &self.files.paths {
            if point.coordinates.len() != energy.space().coordinates() {
                return Err(other());
            }
            let path = paths.entry((point.a, point.b)).or_default();
            path.images.push(point.coordinates.clone());
            path.energies.push(point.energy);
        }
        let edges = self.files.edges.iter().zip(self.network.edge_weights());
        let connections = edges.map(|(row, edge)| {
            let [from, to] = [row.a, row.b].map(minimum_id);
            let path = paths.remove(&(row.a, row.b)).unwrap_or_default();
            let top = path.images.get(path.top());
            Connection {
                from,
                to,
                edge: edge.clone(),
                invalid_reason: top.and_then(|top| energy.invalid_reason(top)),
                path,
                forward: Vec::new(),
                backward: Vec::new(),
                start: None,
                crossings: Vec::new(),
                evaluations: usize::try_from(row.evaluations).unwrap_or(usize::MAX),
            }
        });
        Ok(Landscape {
            connections: connections.collect(),
            tree: Tree::from_network(&self.network, Evidence::Chain),
            families: Families::new(&self.network, &self.settings.families),
            network: self.network.clone(),
            rejected: Vec::new(),
            unlisted_minima: Vec::new(),
            attempts: self.attempts.clone(),
            evaluations: 0,
        })
    }
}

/// The number of a minimum, which [`LandscapeFiles::network`] has checked.
fn minimum_id(number: u64) -> MinimumId {
    MinimumId(usize::try_from(number).unwrap_or(usize::MAX))
}
