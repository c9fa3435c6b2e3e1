//! Builds the landscape of the grasps of one hand on one object.

use serde::Serialize;

use super::chain_choice::ChainChoice;
use super::connected::ConnectedPair;
use super::earlier::EarlierLandscape;
use super::error::StudyError;
use super::settings::{GraspMapSettings, MapSearch, StudyRun};
use crate::energy::Energy;
use crate::grasp::{GraspEnergy, GraspKernel};
use crate::sample::Kernel;
use crate::store::{Population, Source};
use crate::topography::{
    Addition, JournalError, Landscape, MapSettings, Minimum, MinimumId, PairSearch,
    SequentialSettings, build_landscape, distinct, grow_landscape, quench_all, sequential,
};

/// A landscape of grasps and how it was made.
#[derive(Debug)]
pub struct GraspLandscape {
    /// Minima, connections, tree and families.
    pub landscape: Landscape,
    /// The settings, including chosen ones.
    pub settings: MapSettings,
    /// Minima in order of arrival, if the order mattered (sequential ADELM).
    pub arrivals: Option<Vec<MinimumId>>,
    /// How temperature and force were chosen.
    pub choice: ChainChoice,
    /// Energy evaluations of all stages, with those of the landscape that it grew from.
    pub evaluations: usize,
    /// What it grew from, if grasps were added to a finished landscape.
    pub growth: Option<Growth>,
}

/// The landscape to which grasps were added, and what it cost.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Growth {
    /// The folder of the landscape, and the hash of its manifest.
    pub onto: Source,
    /// Number of its grasps.
    pub grasps: usize,
    /// Number of its minima.
    pub minima: usize,
    /// Energy evaluations spent on what was added.
    pub evaluations: usize,
    /// What further searches between two of its minima found, if any were made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub connected: Option<ConnectedPair>,
}

/// Maps the landscape between the grasps of one hand on one object: descends from every grasp, merges equal minima,
/// chooses temperature and force, and connects the minima.
///
/// The relative barrier of families is [`FamilyLevel::default_of`](super::FamilyLevel::default_of) the energy. The result depends only on the grasps, the energy and the settings, not
/// on threads and interruptions.
///
/// # Errors
/// [`StudyError::OneMinimum`] if all grasps lie in one minimum, [`StudyError::Journal`] if a finished task cannot be
/// stored.
///
/// # Panics
/// If the energy belongs to another hand than the population's.
///
/// # Examples
/// From a file of grasps to the folder that `landscape build` writes. A large population takes hours.
///
/// ```no_run
/// use std::path::Path;
///
/// use landscape::store::{AtomicFolder, GraspFile, Overrides, Source, content_hash};
/// use landscape::study::{GraspMapSettings, GraspReport, StudyRun, map_population};
///
/// let path = Path::new("grasps.parquet");
/// let (file, _) = GraspFile::read(path, Overrides::default())?;
/// for population in file.landscapes() {
///     let energy = population.energy()?;
///     let settings = GraspMapSettings::new(&energy);
///     let found = map_population(&population, &energy, &settings, &StudyRun::default())?;
///     let report = GraspReport {
///         found: &found,
///         energy: &energy,
///         population: &population,
///         source: Source {
///             name: "grasps.parquet".to_owned(),
///             content_hash: content_hash(&[&std::fs::read(path)?]),
///         },
///         command: String::new(),
///         warnings: Vec::new(),
///     };
///     let folder = AtomicFolder::open(&path.with_extension("landscape"), true)?;
///     println!("{}", report.write(&folder)?.text);
///     folder.finish()?;
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn map_population(
    population: &Population<'_>,
    energy: &GraspEnergy,
    settings: &GraspMapSettings,
    run: &StudyRun<'_>,
) -> Result<GraspLandscape, StudyError> {
    let kernel = GraspKernel::new(energy);
    let mut map = settings.map_settings();
    let (minima, evaluations) = descended(population, 0, energy, &map, run)?;
    if minima.len() < 2 {
        return Err(StudyError::OneMinimum(population.grasps.len()));
    }
    let choice = ChainChoice::make(settings, (energy, &kernel), &minima, &mut map, run)?;
    let (landscape, arrivals) = joined(settings.search, (energy, &kernel), minima, &map, run)?;
    Ok(GraspLandscape {
        evaluations: evaluations + choice.evaluations() + landscape.evaluations,
        settings: map,
        landscape,
        arrivals,
        choice,
        growth: None,
    })
}

/// Joins `minima` as `search` says. For attraction–diffusion alone they arrive in the order of the points that descended to
/// them, which is returned.
pub(super) fn joined(
    search: MapSearch,
    (energy, kernel): (&dyn Energy, &dyn Kernel),
    mut minima: Vec<Minimum>,
    map: &MapSettings,
    run: &StudyRun<'_>,
) -> Result<(Landscape, Option<Vec<MinimumId>>), JournalError> {
    let (landscape, arrivals) = match search {
        MapSearch::Passes => {
            let found = build_landscape(energy, kernel, minima, map, &run.run)?;
            (found, None)
        }
        MapSearch::Adelm => {
            minima.sort_by_key(|minimum| minimum.members.first().copied());
            let settings = SequentialSettings {
                chain: map.chain.clone(),
                quench: map.quench.clone(),
                sameness: map.sameness,
                pruned: map.pruned,
                seed: map.seed,
            };
            let found = sequential(energy, kernel, &minima, &settings, &run.run)?;
            (found.landscape, Some(found.arrivals))
        }
    };
    (run.stage_ended)("connect", landscape.evaluations);
    Ok((landscape, arrivals))
}

/// Adds grasps to a finished landscape and does only what is new: descends from them, connects the minima that the landscape
/// does not have, and leaves its own connections as they are; see [`grow_landscape`]. `population` is that of
/// [`JoinedGrasps::file`](super::JoinedGrasps::file). `pair` are two minima of the landscape between which further searches
/// are made; then there need be no new grasp. The settings are those of the landscape, but the level of families may be another
/// one.
///
/// # Errors
/// [`StudyError::OtherEnergy`] if the energy is not that of the landscape, [`StudyError::Journal`] if a finished task cannot
/// be stored.
///
/// # Panics
/// If the energy belongs to another hand than the population's, a minimum of the pair does not exist, or both are the same.
pub fn grow_population(
    earlier: &EarlierLandscape,
    population: &Population<'_>,
    energy: &GraspEnergy,
    family_barrier: Option<f64>,
    pair: Option<PairSearch>,
    run: &StudyRun<'_>,
) -> Result<GraspLandscape, StudyError> {
    let kernel = GraspKernel::new(energy);
    let mut map = earlier.settings.clone();
    map.families.barrier = family_barrier.or(map.families.barrier);
    let known = earlier.landscape(energy)?;
    let (minima, descents) = descended(population, earlier.grasps(), energy, &map, run)?;
    let addition = Addition { minima, pair };
    let landscape = grow_landscape(energy, &kernel, &known, addition, &map, &run.run)?;
    (run.stage_ended)("connect", landscape.evaluations);
    let spent = descents + landscape.evaluations;
    let connected = pair.map(|pair| ConnectedPair::of(&known, &landscape, &pair));
    Ok(GraspLandscape {
        evaluations: earlier.evaluations() + spent,
        settings: map,
        landscape,
        arrivals: None,
        choice: ChainChoice::of_earlier(&earlier.source.name),
        growth: Some(Growth {
            onto: earlier.source.clone(),
            grasps: earlier.grasps(),
            minima: earlier.minima(),
            evaluations: spent,
            connected,
        }),
    })
}

/// The minima below the grasps from row `first` on, and the evaluations spent. Members are rows of the population.
fn descended(
    population: &Population<'_>,
    first: usize,
    energy: &GraspEnergy,
    map: &MapSettings,
    run: &StudyRun<'_>,
) -> Result<(Vec<Minimum>, usize), StudyError> {
    let grasps = population.grasps.iter().skip(first);
    let starts: Vec<Vec<f64>> = grasps.map(|row| row.grasp.pose.to_vec()).collect();
    let quenches = quench_all(energy, &starts, &map.quench, &run.run)?;
    let evaluations: usize = quenches.iter().map(|quench| quench.evaluations).sum();
    let (mut minima, _) = distinct(energy, &quenches, &map.sameness, f64::INFINITY);
    for minimum in &mut minima {
        for member in &mut minimum.members {
            *member += first;
        }
    }
    (run.stage_ended)("quench", evaluations);
    Ok((minima, evaluations))
}
