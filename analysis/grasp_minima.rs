//! What the programs about maps share: the minima of a file of grasps, with their energy and the usual settings.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use landscape::cli::settings_for_grasps;
use landscape::energy::Energy;
use landscape::grasp::{EnergySettings, GraspEnergy};
use landscape::hand::Hand;
use landscape::object::{Mesh, Object};
use landscape::sample::{Task, stream};
use landscape::store::{GraspFile, Overrides};
use landscape::topography::{MapSettings, Minimum, NoJournal, distinct, quench_all, silent};
use rand::seq::SliceRandom;

/// The first hand on the first object of a file.
pub(crate) struct Grasps {
    pub(crate) energy: GraspEnergy,
    pub(crate) settings: MapSettings,
    /// Where descents from the grasps end, row by row.
    starts: Vec<Vec<f64>>,
}

impl Grasps {
    /// Reads `path`.
    pub(crate) fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let (file, _) = GraspFile::read(path, Overrides::default())?;
        let population = file
            .landscapes()
            .into_iter()
            .next()
            .ok_or("the file is empty")?;
        let [urdf, side @ ..] = population.hand.description.as_slice() else {
            return Err("the file holds no description of the hand".into());
        };
        let hand = Hand::from_urdf(&urdf.text, side.first().map(|file| file.text.as_str()))?;
        let object = population.object;
        let mesh = object
            .mesh_obj
            .as_ref()
            .ok_or("the file holds no mesh of the object")?;
        let object = Object::from_mesh(
            &object.name,
            Mesh::from_obj(&object.name, &mut mesh.as_bytes())?,
            &serde_json::from_value(object.description.clone())?,
        )?;
        let settings: EnergySettings = serde_json::from_value(file.metadata.energy.clone())?;
        let energy = GraspEnergy::new(Arc::new(hand), Arc::new(object), settings)?;
        let starts = population.grasps.iter().map(|grasp| {
            let mut x = grasp.translation_m.to_vec();
            x.extend(grasp.rotation_wxyz);
            x.extend(&grasp.joints_rad);
            x
        });
        Ok(Self {
            settings: settings_for_grasps(&energy),
            starts: starts.collect(),
            energy,
        })
    }

    /// The minima of all grasps in an order drawn with `seed`, so that the first n of them are n at random.
    pub(crate) fn minima(&self, seed: u64) -> Vec<Minimum> {
        shuffled(
            &self.energy,
            &self.starts,
            &self.settings,
            f64::INFINITY,
            seed,
        )
    }
}

/// The distinct minima that descents from `starts` reach, in an order drawn with `seed`.
pub(crate) fn shuffled(
    energy: &dyn Energy,
    starts: &[Vec<f64>],
    settings: &MapSettings,
    max_gradient: f64,
    seed: u64,
) -> Vec<Minimum> {
    let quenches = quench_all(energy, starts, &settings.quench, &NoJournal, &silent);
    let (mut minima, _) = distinct(energy, &quenches, &settings.sameness, max_gradient);
    minima.shuffle(&mut stream(seed, Task::Start, u64::MAX));
    minima
}
