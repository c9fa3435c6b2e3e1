//! The main workflow as library calls: from grasps to their landscape, and to tables, reports and drawings.
//!
//! | from | to | call |
//! | --- | --- | --- |
//! | the grasps of a file | their landscape | [`map_population`] with [`GraspMapSettings`] |
//! | a landscape of grasps | tables, pictures, `summary.md` | [`GraspReport::write`] |
//! | a surface | its minima and saddles, and their landscape | [`search_surface`] |
//! | a searched surface | tables, pictures, `summary.md` | [`SurfaceReport::write`] |
//! | `min.data` and `ts.data` | the same | [`ImportedLandscape::write`] |
//! | a landscape | pictures of a part of it | [`Drawing::write`] with [`Views`] |
//! | two minima of a landscape | the minimax path between them | [`MinimaxPath::between`], drawn by [`MinimaxPath::strip`] |
//! | the minima of a landscape | their types in the GRASP taxonomy | [`GraspSetting::names`] |
//! | named minima | statistics of heights against types, and a paper's claims | [`compare_with_taxonomy`] with [`ClaimSettings`] |
//! | two landscapes | the types that each of them holds | [`compare_types`] |
//!
//! [`store`](crate::store) reads and writes the files. Nothing here reads arguments or prints.

mod build;
mod chain_choice;
mod claims;
mod digits;
mod drawing;
mod error;
mod examples;
mod imported;
mod minimax_path;
mod names;
mod path_picture;
mod report;
mod settings;
mod statistics;
mod surface;
mod tables;
mod uncertainty;

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

pub use build::{GraspLandscape, GraspMapSettings, StudyRun, map_population};
pub use chain_choice::ChainChoice;
pub use claims::{ClaimSettings, Finding, TaxonomyComparison, Verdict, compare_with_taxonomy};
pub(crate) use digits::Digits;
pub use drawing::{Drawing, Put, Titles, Views};
pub use error::StudyError;
pub use examples::{Colouring, MinimumNames};
pub use imported::ImportedLandscape;
pub use minimax_path::{MinimaxPath, Waypoint};
pub use names::{GraspSetting, MinimumName};
pub use report::GraspReport;
pub use settings::settings_for_grasps;
pub use statistics::{NamedLandscape, StatisticsSettings, TypeComparison, compare_types};
use surface::spell;
pub use surface::{Subject, SurfaceReport, search_surface};
pub(crate) use tables::group_of;

pub(crate) use crate::topography::median;

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

fn json(value: impl Serialize) -> Value {
    serde_json::to_value(value).expect("plain data with text keys is always JSON")
}
