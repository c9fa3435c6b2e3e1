//! Files of grasps: reading them with what the flags add, and the energy of what they hold.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context;
use rayon::prelude::*;

use super::{complain, models};
use crate::energy::Energy;
use crate::grasp::{EnergySettings, GraspEnergy, Judgement, judge};
use crate::limits::Limit;
use crate::store::{Grasp, GraspFile, LandscapeFiles, Overrides, Population, Warning};

/// Refuses the number of a flag that is beyond its limit.
pub(super) fn within(flag: &str, limit: Limit, value: f64) -> anyhow::Result<()> {
    let told = |beyond| anyhow::anyhow!("{flag} {beyond}");
    limit.check(value).map_err(told)
}

/// Reads a file of grasps, with hand and object from the flags `--hand` and `--object` where given. Where these are others
/// than the file describes, everything that was measured is measured anew with them. Returns warnings, too.
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
    let (mut file, found) = GraspFile::read(path, overrides)?;
    let mut warnings: Vec<String> = found.iter().map(told).collect();
    if file.metadata.energy.is_null() {
        warnings.push(
            "the file does not tell the energy of its grasps (metadata are lost when another program writes a file anew): \
             the default one is used"
                .to_owned(),
        );
    }
    let is_other = |warning: &Warning| {
        matches!(
            warning,
            Warning::OtherHand { .. } | Warning::OtherObject { .. }
        )
    };
    if found.iter().any(is_other) {
        measure_anew(&mut file).with_context(|| path.display().to_string())?;
    }
    Ok((file, warnings))
}

/// A warning as the command line means it.
fn told(warning: &Warning) -> String {
    match warning {
        Warning::OtherHand { told, given } => format!(
            "the poses are judged with the hand given, `{given}`, instead of `{told}` as the file describes it: contacts are \
             chosen and all measures taken anew; labels and outcomes of simulations are dropped"
        ),
        Warning::OtherObject { told, given } => format!(
            "the poses are judged with the object given, `{given}`, instead of `{told}` as the file describes it: all \
             measures are taken anew; labels and outcomes of simulations are dropped"
        ),
        other => other.to_string(),
    }
}

/// Measures all grasps with the hands and objects that are described now.
fn measure_anew(file: &mut GraspFile) -> anyhow::Result<()> {
    let mut measured = BTreeMap::new();
    let mut terms = Vec::new();
    for population in file.landscapes() {
        let energy = energy(file, &population)?;
        terms = energy.term_names();
        let grasps = population.grasps.par_iter().map(|grasp| {
            let mut grasp = (*grasp).clone();
            measure(&mut grasp, &energy);
            (grasp.id, grasp)
        });
        measured.extend(grasps.collect::<Vec<_>>());
    }
    for grasp in &mut file.grasps {
        if let Some(anew) = measured.remove(&grasp.id) {
            *grasp = anew;
        }
    }
    file.metadata.terms = terms;
    Ok(())
}

/// Fills in energies and measures, and the best contacts where there are none.
pub(super) fn measure(grasp: &mut Grasp, energy: &GraspEnergy) -> Judgement {
    let mut x = coordinates(grasp);
    // Stored as read; measured at unit length.
    let norm = grasp
        .rotation_wxyz
        .iter()
        .map(|q| q * q)
        .sum::<f64>()
        .sqrt();
    x[3..7].iter_mut().for_each(|q| *q /= norm);
    if grasp.contacts.is_empty() {
        grasp.contacts = energy.choice(&x);
    }
    let terms = energy.terms_of(&x, &grasp.contacts);
    grasp.terms = terms.into_iter().map(|(_, value)| value).collect();
    grasp.energy = grasp.terms.iter().sum();
    let judgement = judge(energy, &x, &grasp.contacts);
    grasp.net_wrench = judgement.net_wrench;
    grasp.distance_squared = judgement.distance_squared;
    grasp.penetration = judgement.penetration;
    grasp.friction = judgement.least_friction;
    grasp.epsilon = Some(judgement.epsilon);
    judgement
}

/// The landscape in `folder`; tells what is worth a warning about it.
pub(super) fn open_landscape(folder: &Path) -> anyhow::Result<LandscapeFiles> {
    let files = LandscapeFiles::read(folder)?;
    let warning = LandscapeFiles::warning(folder)?;
    warn(&Vec::from_iter(warning.as_ref().map(ToString::to_string)));
    Ok(files)
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
