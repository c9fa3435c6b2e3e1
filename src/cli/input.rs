//! Inputs that flags name: hands, objects, files of grasps and landscapes, with their warnings.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::Context;

use super::args::{Common, HandAndObject, Lacking, within};
use crate::cli::printing::{complain, explain, is_new_warning};
use crate::hand::HandFiles;
use crate::limits::{OBJECT_SCALE, WALL_THICKNESS};
use crate::printable::counted;
use crate::store::{GraspFile, HandMetadata, LandscapeFiles, ObjectMetadata, Overrides};
use crate::study::{self, InputError, name_of};

/// The files of the hand that a flag names: a built-in hand, or a URDF or MJCF file with an optional JSON side file of the
/// same stem. Files that these refer to must be in `folder`, or in the same folder.
pub(super) fn hand_files(
    flag: &str,
    folder: Option<&Path>,
    mirror: bool,
) -> anyhow::Result<HandFiles> {
    study::hand_files(flag, folder, mirror).with_context(|| format!("--hand {flag}"))
}

/// The hand that a flag names, with its metadata for files.
pub(super) fn hand(
    flag: &str,
    folder: Option<&Path>,
    mirror: bool,
) -> anyhow::Result<HandMetadata> {
    let files = hand_files(flag, folder, mirror)?;
    explain(|| {
        format!("hand {flag}: `landscape hands inspect {flag}` shows what is derived of it")
    });
    Ok(study::hand_metadata(flag, &files, mirror)?)
}

/// Metadata at scale 1 of the object that a flag names (a built-in object, a mesh, or a TOML file of shapes), and a list of
/// repairs. A mass in the description refers to the object at `scale`. With a thickness (millimetres at `scale`), open surfaces
/// become walls.
pub(super) fn object(
    flag: &str,
    scale: Option<f64>,
    thickness_mm: Option<f64>,
) -> anyhow::Result<(ObjectMetadata, Vec<String>)> {
    if let Some(scale) = scale {
        within("--scale", OBJECT_SCALE, scale)?;
    }
    if let Some(thickness_mm) = thickness_mm {
        within("--thickness", WALL_THICKNESS, thickness_mm)?;
    }
    let thickness_m = thickness_mm.map(|thickness_mm| 1e-3 * thickness_mm);
    study::object_metadata(flag, scale.unwrap_or(1.0), thickness_m).map_err(|error| match error {
        InputError::NoObject => anyhow::anyhow!("--object {flag}: {error}"),
        error => error.into(),
    })
}

/// Renames an object if a flag asks for it.
pub(super) fn rename(object: &mut ObjectMetadata, name: Option<&str>) -> anyhow::Result<()> {
    if let Some(name) = name {
        let renamed = study::rename_object(object, name);
        renamed.map_err(|error| anyhow::anyhow!("--name {error}"))?;
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
/// file, all measures are computed again. Also returns warnings, the last of which are those of the hands.
pub(super) fn read(
    path: &Path,
    hand_flag: Option<&str>,
    object_flag: Option<&str>,
) -> anyhow::Result<(GraspFile, Vec<String>)> {
    let overrides = Overrides {
        hand: hand_flag.map(|flag| hand(flag, None, false)).transpose()?,
        object: match object_flag {
            Some(flag) => Some(object(flag, None, None)?.0),
            None => None,
        },
    };
    let (file, mut warnings) = study::read_grasps(path, overrides)?;
    warnings.extend(file.metadata.hands.iter().flat_map(HandMetadata::warnings));
    explain(|| {
        let count = counted(file.grasps.len(), "grasp");
        format!("read {count} from {}", path.display())
    });
    Ok((file, warnings))
}

/// Reads a file of grasps, with hand and object from flags if the file does not describe its own.
pub(super) fn read_lacking(
    path: &Path,
    flags: &Lacking,
) -> anyhow::Result<(GraspFile, Vec<String>)> {
    let (hand, object) = (flags.hand.as_deref(), flags.object.as_deref());
    let given = hand.is_some() || object.is_some();
    if given && !GraspFile::describes_itself(path)? {
        return read(path, hand, object);
    }
    read(path, None, None)
}

/// Reads the landscape in `folder` and shows its warnings.
pub(super) fn open_landscape(folder: &Path) -> anyhow::Result<LandscapeFiles> {
    let files = LandscapeFiles::read(folder)?;
    explain(|| {
        let minima = counted(files.minima.len(), "minimum");
        format!("read {minima} from {}", folder.display())
    });
    Ok(files)
}

/// Writes warnings, each once in a command: several files may have the same hand.
pub(super) fn warn(warnings: &[String]) {
    let new = warnings.iter().filter(|warning| is_new_warning(warning));
    let warnings: Vec<&String> = new.collect();
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

/// The names of the files and folders, or their paths if two names are the same.
pub(super) fn names(paths: &[PathBuf]) -> Vec<String> {
    let short: Vec<String> = paths.iter().map(|path| name_of(path)).collect();
    let different: BTreeSet<&String> = short.iter().collect();
    if different.len() == paths.len() {
        return short;
    }
    paths
        .iter()
        .map(|path| path.display().to_string())
        .collect()
}
