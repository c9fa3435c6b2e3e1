//! Files of grasps: reading them with what the flags add, and the energy of what they hold.

use std::path::Path;

use anyhow::Context;

use super::{complain, models};
use crate::grasp::{EnergySettings, GraspEnergy};
use crate::store::{Grasp, GraspFile, Overrides, Population};

/// Reads a file of grasps, with hand and object from the flags `--hand` and `--object` where given. Returns warnings, too.
pub(super) fn read(
    path: &Path,
    hand: Option<&str>,
    object: Option<&str>,
) -> anyhow::Result<(GraspFile, Vec<String>)> {
    let overrides = Overrides {
        hand: hand
            .map(|hand| models::hand_metadata(hand, None, false))
            .transpose()?,
        object: match object {
            Some(flag) => Some(models::object_metadata(flag, None)?.0),
            None => None,
        },
    };
    let (file, warnings) = GraspFile::read(path, overrides)?;
    let mut warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    if file.metadata.energy.is_null() {
        warnings.push(
            "the file does not tell the energy of its grasps: the default one is used".to_owned(),
        );
    }
    Ok((file, warnings))
}

/// Tells the first few warnings.
pub(super) fn warn(warnings: &[String]) {
    for warning in warnings.iter().take(5) {
        complain(&format!("warning: {warning}"));
    }
    if warnings.len() > 5 {
        complain(&format!(
            "warning: … and {} more like these",
            warnings.len() - 5
        ));
    }
}

/// The energy that the grasps of a population were made with.
pub(super) fn energy(file: &GraspFile, population: &Population<'_>) -> anyhow::Result<GraspEnergy> {
    let settings = match &file.metadata.energy {
        serde_json::Value::Null => EnergySettings::default(),
        told => serde_json::from_value(told.clone())
            .context("the energy in the metadata is not one this program knows")?,
    };
    let energy = GraspEnergy::new(
        models::hand(population.hand)?,
        models::object(population.object, population.scale)?,
        settings,
    )?;
    models::check_hand(population.hand, energy.hand())?;
    Ok(energy)
}

/// The pose of a row, as the pose space has it.
pub(super) fn coordinates(grasp: &Grasp) -> Vec<f64> {
    let mut x = grasp.translation_m.to_vec();
    x.extend(grasp.rotation_wxyz);
    x.extend(&grasp.joints_rad);
    x
}
