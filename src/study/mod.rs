//! The main workflow as library calls: from a hand and an object to grasps, to their landscape, and to tables, reports and
//! drawings.
//!
//! | from | to | call |
//! | --- | --- | --- |
//! | a hand and an object | grasps that pass a filter | [`synthesize_population`] with [`PopulationSettings`] |
//! | a hand and objects | the grasp types that it can do on them | [`hand_abilities`] |
//! | a set of grasps or a landscape | grasps that it lacks | [`synthesize_beyond`] with an [`Archive`] |
//! | grasps of another program | rows of `grasps.parquet`, judged | [`import_grasps`] with [`GraspImportSettings`] |
//! | the grasps of a file | outcomes of a simulation | [`simulate_all`] |
//! | the grasps of a file | grasp types | [`label_all`] |
//! | a landscape, or two | a page on which they are explored | [`landscape_page`] |
//! | the grasps of a file | a page on which they are explored and labelled | [`grasp_page`], read back by [`given_labels`] |
//! | the grasps of a file | judgements on the exact mesh | [`judge_all`], counted by [`JudgedPopulation`] |
//! | contacts without a hand | a judgement of them | [`GivenContacts::judge`] |
//! | the grasps of a file | their landscape | [`map_population`] with [`GraspMapSettings`] |
//! | more grasps and a finished landscape | the landscape of all of them | [`EarlierLandscape::read`], [`grow_population`] |
//! | a landscape of grasps | tables, pictures, `summary.md` | [`GraspReport::write`] |
//! | a surface | its minima and saddles, and their landscape | [`search_surface`] |
//! | a searched surface | tables, pictures, `summary.md` | [`SurfaceReport::write`] |
//! | points of a surface | the landscape between their minima | [`map_surface`], written by [`SurfaceMapReport::write`] |
//! | a hand | its model for other simulators | [`hand_urdf`] |
//! | the grasps of a file | a scene of `MuJoCo` | [`MujocoScene::files`] |
//! | `min.data` and `ts.data` | the same | [`ImportedLandscape::write`] |
//! | a landscape | pictures of a part of it | [`Drawing::write`] with [`Views`] |
//! | two minima of a landscape | the minimax path between them | [`MinimaxPath::between`], drawn by [`MinimaxPath::strip`] |
//! | an edge of a landscape | whether a hand can go its way | [`Drives::path`], [`Drives::replay`] |
//! | the minima of a landscape | their types in the GRASP taxonomy | [`GraspSetting::names`] |
//! | named minima | statistics of heights against types | [`compare_with_taxonomy`] with [`StatisticsSettings`] |
//! | a landscape with curvatures | heat capacity, occupation, free energies | [`Thermodynamics::new`] |
//! | a landscape with curvatures, two sets of minima | rates, committors, pathways | [`Kinetics::new`] |
//! | two landscapes | the types that each of them holds | [`compare_types`] |
//! | files of grasps of many objects | what all of them cover, share and lack | [`Survey::new`] with [`SurveyedPopulation`]s |
//! | files of grasps, landscapes | which of them is more diverse | [`compare_diversity`] with [`DiversitySet`]s |
//! | the grasps of a file | the measures of publications | [`referee::measures::measure`] of a [`MeasuredSet`](referee::measures::MeasuredSet) |
//!
//! Long calls work in parallel on the threads of rayon's current pool and take a [`Run`]: the journal of finished tasks, and
//! who is told of progress. [`store`](crate::store) reads and writes the files. Nothing here reads arguments or prints.
//!
//! # A population of grasps
//! How a single grasp is made and judged is shown [below](#one-grasp).
//!
//! ```no_run
//! use landscape::store::GraspFile;
//! use landscape::study::{Origin, PopulationSettings, Run, synthesize_population};
//!
//! let origin = Origin::named("human", "ball")?;
//! let settings = PopulationSettings { chains: 16, ..PopulationSettings::default() };
//! let energy = origin.energy(&settings)?;
//! let found = synthesize_population(&energy, &origin, &settings, &Run::default())?;
//! let file = GraspFile { metadata: origin.metadata(&energy, &settings)?, grasps: found.grasps };
//! file.write("grasps.parquet".as_ref())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # One grasp
//! Hand, object, energy, synthesis, judgement, label and picture. A chain is this short only to keep the example quick:
//!
//! ```
//! use std::sync::Arc;
//!
//! use landscape::evaluation::taxonomy::{Labeller, Rule};
//! use landscape::figure::Scene;
//! use landscape::grasp::synthesis::{SynthesisSettings, synthesize};
//! use landscape::grasp::{EnergySettings, GraspEnergy, judge};
//! use landscape::hand::Hand;
//! use landscape::object::Object;
//! use landscape::optimize::QuenchSettings;
//!
//! let (hand, ball) = (Arc::new(Hand::human()), Arc::new(Object::named("ball")?));
//! let energy = GraspEnergy::new(hand.clone(), ball.clone(), EnergySettings::default())?;
//!
//! let short = SynthesisSettings { steps: 1, ..Default::default() };
//! let descent = QuenchSettings::default().with_max_evaluations(20);
//! let end = synthesize(&energy, &short, &descent, 0, 0);
//! assert_eq!(end.refined.pose.joints().len(), hand.joints.len());
//!
//! let judgement = judge(&energy, &end.refined);
//! println!("{:?}", judgement.strict_objection().unwrap_or("a grasp"));
//!
//! let label = Labeller::new(&hand, &ball, Rule::standard()).label(&end.refined.pose);
//! println!("{}", label.text());
//!
//! let scene = Scene::of_grasp(&hand, &hand.skin(), &ball, &end.refined);
//! let picture = scene.render(&scene.best_camera(nalgebra::Vector3::z()), 64, 64);
//! assert!(!picture.to_png()?.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod abilities;
mod beyond;
mod build;
mod chain_choice;
mod configuration;
mod connected;
mod contacts;
mod digits;
mod diversity;
mod drawing;
mod earlier;
mod error;
mod examples;
mod experiment;
mod export;
mod family_names;
mod given_labels;
mod gradient_points;
mod grasp_import;
mod import_doubt;
mod import_frame;
mod imported;
mod inputs;
mod judging;
mod kinetics;
mod labels;
mod level;
mod looks;
mod lowest;
mod markdown;
mod minimax_path;
mod minimum_values;
mod names;
mod network_of_states;
mod page;
mod path_picture;
pub mod referee;
mod replaying;
mod report;
mod searched;
mod settings;
mod simulation;
mod size;
mod statistics;
mod surface;
mod surface_map;
mod surface_space;
mod survey;
mod synthesis;
mod tables;
mod teaching;
mod thermodynamics;
mod uncertainty;
mod ways;
mod wish;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use serde_json::Value;

pub use abilities::{Abilities, Ability, hand_abilities, possible_types};
pub use beyond::{Added, Archive, synthesize_beyond};
pub use build::{GraspLandscape, Growth, grow_population, map_population};
pub use chain_choice::ChainChoice;
pub use configuration::{
    ConfigurationError, ConfigurationFile, SurfaceConfiguration, protocol_of_text,
};
pub use connected::ConnectedPair;
pub use contacts::{BalancingForces, ContactsError, ContactsReport, GivenContact, GivenContacts};
pub(crate) use digits::Digits;
pub use diversity::{
    Counted, Counts, DiversityComparison, DiversitySet, DiversitySettings, Measure, OTHER_LEVELS,
    RatioOfSets, check_set_sizes, compare_diversity,
};
pub use drawing::{Drawing, Put, Quantities, Resolution, Titles, Views};
pub use earlier::{EarlierLandscape, JoinedGrasps};
pub use error::{FewGrasps, StudyError};
pub use examples::{Colouring, MinimumNames};
pub use experiment::{Experiment, ExperimentError};
pub use export::{
    Approach, ExportError, ExportedFile, MujocoScene, OPENED_M, approaches, check_rigid, hand_urdf,
    roadmap, squeezing_test,
};
pub use family_names::FamilyName;
pub use given_labels::{GivenLabel, GivenLabelError, given_labels};
pub use gradient_points::{BrokenSymmetry, broken_symmetry, difference_step, gradient_points};
pub use grasp_import::{
    GraspImportError, GraspImportSettings, ImportedGrasps, ScaleCounts, import_grasps,
};
pub use imported::{ImportedLandscape, StationaryCoordinates};
pub use inputs::{
    InputError, hand_files, hand_metadata, object_metadata, read_grasps, rename_object,
};
pub use judging::{JudgedContact, JudgedGrasp, JudgedPopulation, judge_all};
pub use kinetics::{Kinetics, KineticsAt, KineticsSettings};
pub use labels::{HumanLabel, human_label, label_all, record_labels};
pub use level::FamilyLevel;
pub use minimax_path::{MinimaxPath, Waypoint};
pub use minimum_values::MinimumValues;
pub use names::{GraspSetting, MinimumName};
pub use network_of_states::{NetworkOfStates, NumberedMinima};
pub use page::{PageGrasps, PageLandscape, comparison_notes, grasp_page, landscape_page};
pub use replaying::{Drives, Success};
pub use report::{GraspReport, WrittenLandscape};
pub use searched::{Searched, SurfaceSearch};
pub use settings::{GraspMapSettings, MapSearch, StudyRun, settings_for_grasps};
pub use simulation::{
    ObjectFit, Simulation, simulate_all, simulate_sample, simulation_fingerprint,
};
pub use size::{SizeDoubt, doubted_size};
pub use statistics::{
    Basin, Basins, NamedLandscape, Part, StatisticsSettings, TaxonomyComparison, TypeComparison,
    compare_types, compare_with_taxonomy,
};
use surface::spell;
pub use surface::{Subject, SurfaceReport, search_surface};
pub use surface_map::{SurfaceMap, SurfaceMapReport, map_surface};
pub use surface_space::{Coordinates, CoordinatesError, in_region, onto, surface_space};
pub use survey::{
    HandSurvey, KindCounts, SharedContacts, Survey, SurveyFailure, SurveyedFamily, SurveyedMap,
    SurveyedPopulation,
};
pub use synthesis::{
    Keep, Origin, PopulationSettings, Synthesis, WishOutcome, synthesize_population,
};
pub(crate) use tables::family_of;
pub use teaching::examples;
pub use thermodynamics::{AtTemperature, Thermodynamics, ThermodynamicsSettings};
pub use ways::Way;
pub use wish::{Asked, HandNames, Served, WishError, Wishes};

pub(crate) use crate::topography::median;
pub use crate::topography::{JournalError, Run};

/// Counts of each name, most frequent first.
pub(crate) fn tally<'a>(names: impl Iterator<Item = &'a str>) -> Vec<(String, usize)> {
    let mut counts = BTreeMap::new();
    for name in names {
        *counts.entry(name.to_owned()).or_insert(0) += 1;
    }
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
    counts
}

/// The name of a file or folder, even if given as `.` or `..`.
pub(crate) fn name_of(path: &Path) -> String {
    let whole = match path.file_name() {
        Some(_) => path.to_owned(),
        None => path.canonicalize().unwrap_or_default(),
    };
    let name = whole.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

fn json(value: impl Serialize) -> Value {
    serde_json::to_value(value).expect("plain data with text keys is always JSON")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_given_by_dots_have_names() {
        let here = std::env::current_dir().unwrap();
        assert_eq!(name_of(Path::new(".")), name_of(&here));
        assert_eq!(name_of(Path::new("a/b.npy")), "b.npy");
    }
}
