//! Inputs that flags name: hands, objects, files of grasps and landscapes, with their warnings.

use std::path::Path;

use anyhow::Context;

use super::args::{Common, HandAndObject, within};
use crate::cli::printing::complain;
use crate::hand::{HAND_NAMES, HandFiles};
use crate::limits::OBJECT_SCALE;
use crate::object::{OBJECT_NAMES, Object, ObjectParts};
use crate::store::{GraspFile, HandMetadata, LandscapeFiles, ObjectMetadata, Overrides, Warning};

/// The files of the hand that a flag names: a built-in hand, or a URDF or MJCF file with an optional JSON side file of the
/// same stem. Files that these refer to must be in `folder`, or in the same folder.
pub(super) fn hand_files(
    flag: &str,
    folder: Option<&Path>,
    mirror: bool,
) -> anyhow::Result<HandFiles> {
    let files = if HAND_NAMES.contains(&flag) {
        HandFiles::named(flag)?
    } else {
        let path = Path::new(flag);
        anyhow::ensure!(
            path.exists(),
            "--hand {flag}: this is neither a file nor a hand that comes with the program ({})",
            HAND_NAMES.join(", ")
        );
        let files = match folder {
            Some(folder) => HandFiles::load_within(path, folder),
            None => HandFiles::load(path),
        };
        files.with_context(|| format!("--hand {flag}"))?
    };
    if mirror {
        return files.mirrored().with_context(|| format!("--hand {flag}"));
    }
    Ok(files)
}

/// The hand that a flag names, with its metadata for files.
pub(super) fn hand(
    flag: &str,
    folder: Option<&Path>,
    mirror: bool,
) -> anyhow::Result<HandMetadata> {
    let files = hand_files(flag, folder, mirror)?;
    let mut name = if HAND_NAMES.contains(&flag) {
        flag.to_owned()
    } else {
        let stem = Path::new(flag).file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    };
    if mirror {
        name += "_mirrored";
    }
    Ok(HandMetadata::new(name, &files)?)
}

/// Metadata at scale 1 of the object that a flag names (a built-in object, a mesh, or a TOML file of shapes), and a list of
/// repairs. A mass in the description refers to the object at `scale`.
pub(super) fn object(
    flag: &str,
    scale: Option<f64>,
) -> anyhow::Result<(ObjectMetadata, Vec<String>)> {
    let path = Path::new(flag);
    let mut parts = if OBJECT_NAMES.contains(&flag) {
        let (mesh, description) = Object::parts_of_named(flag)?;
        ObjectParts {
            name: flag.to_owned(),
            mesh,
            notes: Vec::new(),
            description,
        }
    } else {
        anyhow::ensure!(
            path.exists(),
            "--object {flag}: this is neither a file nor an object that comes with the program ({})",
            OBJECT_NAMES.join(", ")
        );
        Object::parts_of_file(path)?
    };
    if let Some(scale) = scale {
        within("--scale", OBJECT_SCALE, scale)?;
        let mass_kg = &mut parts.description.mass_kg;
        *mass_kg = mass_kg.map(|mass| mass / scale.powi(3));
    }
    Ok((ObjectMetadata::new(&parts)?, parts.notes))
}

/// Renames an object if a flag asks for it.
pub(super) fn rename(object: &mut ObjectMetadata, name: Option<&str>) -> anyhow::Result<()> {
    if let Some(name) = name {
        // Names are used in file names.
        anyhow::ensure!(
            !name.trim().is_empty()
                && !name.contains(['/', '\\'])
                && !name.contains(char::is_control),
            "--name {name:?}: a name without slashes and line breaks is needed"
        );
        name.clone_into(&mut object.name);
    }
    Ok(())
}

/// Reads a file of grasps as [`read`] does, and shows the warnings.
pub(super) fn grasps(
    path: &Path,
    of: &HandAndObject,
    common: &Common,
) -> anyhow::Result<GraspFile> {
    let (file, warnings) = read(path, of.hand.as_deref(), of.object.as_deref())?;
    if !common.quiet {
        warn(&warnings);
    }
    Ok(file)
}

/// Refuses ids, given with a flag, that no grasp of the file has.
pub(super) fn all_known(
    flag: &str,
    ids: &[u64],
    file: &GraspFile,
    path: &Path,
) -> anyhow::Result<()> {
    for id in ids {
        anyhow::ensure!(
            file.grasps.iter().any(|grasp| grasp.id == *id),
            "{flag} {id}: {} has no grasp with this id",
            path.display()
        );
    }
    Ok(())
}

/// Reads a file of grasps, with hand and object from `--hand` and `--object` if given. If these differ from those in the
/// file, all measures are computed anew. Also returns warnings.
pub(super) fn read(
    path: &Path,
    hand_flag: Option<&str>,
    object_flag: Option<&str>,
) -> anyhow::Result<(GraspFile, Vec<String>)> {
    let overrides = Overrides {
        hand: hand_flag.map(|flag| hand(flag, None, false)).transpose()?,
        object: match object_flag {
            Some(flag) => Some(object(flag, None)?.0),
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
        file.measure().with_context(|| path.display().to_string())?;
    }
    Ok((file, warnings))
}

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

/// Reads the landscape in `folder` and shows its warnings.
pub(super) fn open_landscape(folder: &Path) -> anyhow::Result<LandscapeFiles> {
    let files = LandscapeFiles::read(folder)?;
    let warning = LandscapeFiles::warning(folder)?;
    warn(&Vec::from_iter(warning.as_ref().map(ToString::to_string)));
    Ok(files)
}

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
