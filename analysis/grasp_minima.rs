//! Shared by the programs about maps: the minima of a file of grasps, with their energy and the usual settings.

use std::error::Error;
use std::path::Path;

use landscape::energy::Energy;
use landscape::grasp::GraspEnergy;
use landscape::sample::{Task, stream};
use landscape::store::{GraspFile, Overrides};
use landscape::study::settings_for_grasps;
use landscape::topography::{JournalError, MapSettings, Minimum, Run, distinct, quench_all};
use rand::seq::SliceRandom;

/// The first hand with the first object of a file.
pub(crate) struct Grasps {
    pub(crate) energy: GraspEnergy,
    pub(crate) settings: MapSettings,
    /// Ends of descents from the grasps, in the order of rows.
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
        let energy = population.energy()?;
        let starts = population
            .grasps
            .iter()
            .map(|grasp| grasp.grasp.pose.to_vec());
        Ok(Self {
            settings: settings_for_grasps(&energy),
            starts: starts.collect(),
            energy,
        })
    }

    /// The minima of all grasps in a random order given by `seed`, so that the first n are a random sample.
    pub(crate) fn minima(&self, seed: u64) -> Result<Vec<Minimum>, JournalError> {
        shuffled(
            &self.energy,
            &self.starts,
            &self.settings,
            f64::INFINITY,
            seed,
        )
    }
}

/// The distinct minima that descents from `starts` reach, in a random order given by `seed`.
pub(crate) fn shuffled(
    energy: &dyn Energy,
    starts: &[Vec<f64>],
    settings: &MapSettings,
    max_gradient: f64,
    seed: u64,
) -> Result<Vec<Minimum>, JournalError> {
    let quenches = quench_all(energy, starts, &settings.quench, &Run::default())?;
    let (mut minima, _) = distinct(energy, &quenches, &settings.sameness, max_gradient);
    minima.shuffle(&mut stream(seed, Task::Start, u64::MAX));
    Ok(minima)
}
