//! Hands, objects and grasps that a user names: by the name of one that comes with the program, or by a file.

use std::path::{Path, PathBuf};

use crate::hand::{HAND_NAMES, HandError, HandFiles};
use crate::mesh::MeshError;
use crate::object::{OBJECT_NAMES, Object, ObjectError, ObjectParts};
use crate::printable::is_command;
use crate::store::{
    GraspFile, HandMetadata, ObjectMetadata, Overrides, RebuildError, StoreError, Warning,
};

/// Reason why a hand, an object or a file of grasps cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// A hand is neither built in nor a file.
    #[error("this is neither a file nor a hand that comes with the program ({})", HAND_NAMES.join(", "))]
    NoHand,
    /// An object is neither built in nor a file.
    #[error("this is neither a file nor an object that comes with the program ({})", OBJECT_NAMES.join(", "))]
    NoObject,
    /// The file of a hand is wrong.
    #[error(transparent)]
    Hand(#[from] HandError),
    /// The file of an object is wrong.
    #[error(transparent)]
    Object(#[from] ObjectError),
    /// A hand or an object cannot be stored or built.
    #[error(transparent)]
    Rebuild(#[from] RebuildError),
    /// The name of an object, which is used in names of files.
    #[error("{name:?}: {problem}; give a name without slashes and marks that are not shown")]
    Name {
        /// The name.
        name: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The file of grasps is wrong.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The grasps of a file cannot be measured.
    #[error("{}", path.display())]
    Measure {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: Box<RebuildError>,
    },
}

/// The files of a hand: of a built-in one by its name, or of a URDF, MJCF or MANO file with an optional JSON side file of the
/// same stem. Files that these refer to must be in `folder`, or in the same folder. With `mirror`, its mirror image.
///
/// # Errors
/// If there is no such hand, or its files are wrong.
pub fn hand_files(
    name_or_file: &str,
    folder: Option<&Path>,
    mirror: bool,
) -> Result<HandFiles, InputError> {
    let files = if HAND_NAMES.contains(&name_or_file) {
        HandFiles::named(name_or_file)?
    } else {
        let path = Path::new(name_or_file);
        if !path.exists() {
            return Err(InputError::NoHand);
        }
        match folder {
            Some(folder) => HandFiles::load_within(path, folder)?,
            None => HandFiles::load(path)?,
        }
    };
    if mirror {
        return Ok(files.mirrored()?);
    }
    Ok(files)
}

/// The metadata of the hand of `files`, which [`hand_files`] found with the same arguments.
///
/// # Errors
/// If the files do not describe a hand.
pub fn hand_metadata(
    name_or_file: &str,
    files: &HandFiles,
    mirror: bool,
) -> Result<HandMetadata, RebuildError> {
    let mut name = if HAND_NAMES.contains(&name_or_file) {
        name_or_file.to_owned()
    } else {
        let stem = Path::new(name_or_file).file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    };
    if mirror {
        name += "_mirrored";
    }
    HandMetadata::new(name, files)
}

/// The metadata at scale 1 of an object (a built-in one, a mesh, or a TOML file of shapes), and a list of repairs. A mass in
/// the description refers to the object at `scale`. With `thickness_m`, open surfaces of the mesh become walls that are so
/// thick at `scale`.
///
/// # Errors
/// If there is no such object, its file is wrong, or there is nothing to thicken.
pub fn object_metadata(
    name_or_file: &str,
    scale: f64,
    thickness_m: Option<f64>,
) -> Result<(ObjectMetadata, Vec<String>), InputError> {
    let path = Path::new(name_or_file);
    let mut parts = if OBJECT_NAMES.contains(&name_or_file) {
        if thickness_m.is_some() {
            let error = MeshError::Closed(name_or_file.to_owned());
            return Err(ObjectError::from(error).into());
        }
        let (mesh, description) = Object::parts_of_named(name_or_file)?;
        ObjectParts {
            name: name_or_file.to_owned(),
            mesh,
            notes: Vec::new(),
            description,
        }
    } else {
        if !path.exists() {
            return Err(InputError::NoObject);
        }
        Object::parts_of_file(path, thickness_m.map(|thickness_m| thickness_m / scale))?
    };
    let mass_kg = &mut parts.description.mass_kg;
    *mass_kg = mass_kg.map(|mass| mass / scale.powi(3));
    Ok((ObjectMetadata::new(&parts)?, parts.notes))
}

/// Gives an object another name.
///
/// # Errors
/// If names of files cannot contain the name.
pub fn rename_object(object: &mut ObjectMetadata, name: &str) -> Result<(), InputError> {
    let problem = if name.trim().is_empty() {
        Some("the name is empty".to_owned())
    } else if let Some(slash) = name.chars().find(|c| ['/', '\\'].contains(c)) {
        Some(format!("the name contains `{slash}`"))
    } else {
        let hidden = name.chars().find(|c| is_command(*c));
        hidden.map(|c| {
            let kind = match c {
                '\n' | '\r' | '\u{2028}' | '\u{2029}' => "a line break",
                '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => "a mark of direction",
                _ => "a control character",
            };
            format!("the name contains {kind} (U+{:04X})", u32::from(c))
        })
    };
    if let Some(problem) = problem {
        let name = name.to_owned();
        return Err(InputError::Name { name, problem });
    }
    name.clone_into(&mut object.name);
    Ok(())
}

/// Reads a file of grasps, with the given hand and object if there are any. If these differ from those in the file, all
/// measures are computed anew, and if no checksum vouches for the file, those that are not of its poses
/// ([`GraspFile::verify`]). Also returns warnings.
///
/// # Errors
/// If the file is wrong, or its grasps cannot be measured.
pub fn read_grasps(
    path: &Path,
    overrides: Overrides,
) -> Result<(GraspFile, Vec<String>), InputError> {
    let (mut file, found) = GraspFile::read(path, overrides)?;
    let unsealed = |warning: &&Warning| matches!(warning, Warning::Unsealed(_));
    let mut warnings: Vec<String> = (found.iter())
        .filter(|warning| !unsealed(warning))
        .map(told)
        .collect();
    if file.metadata.energy.is_null() {
        warnings.push(
            "the energy of the grasps is not recorded in the file (other programs drop the metadata when they rewrite it): \
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
    let failed = |source| InputError::Measure {
        path: path.to_path_buf(),
        source: Box::new(source),
    };
    if found.iter().any(is_other) {
        file.measure().map_err(failed)?;
    } else if found.iter().any(|warning| unsealed(&warning)) {
        warnings.extend(
            file.verify()
                .map_err(failed)?
                .map(|found| found.to_string()),
        );
        let simulated = file.grasps.iter().filter(|grasp| grasp.stable.is_some());
        let (outcomes, grasps) = (simulated.count(), file.grasps.len());
        if outcomes > 0 {
            warnings.push(Warning::UnverifiedOutcomes { outcomes, grasps }.to_string());
            file.mark_unverified();
        }
    }
    Ok((file, warnings))
}

fn told(warning: &Warning) -> String {
    match warning {
        Warning::OtherHand { told, given } => format!(
            "using hand `{given}` instead of `{told}`: contacts are chosen and all measures computed again; labels and \
             outcomes of simulations are dropped"
        ),
        Warning::OtherObject { told, given } => format!(
            "using object `{given}` instead of `{told}`: all measures are computed again; labels and outcomes of simulations \
             are dropped"
        ),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refused_name_says_what_is_wrong_with_it() {
        let said = |name: &str| {
            let mut object = ObjectMetadata::default();
            rename_object(&mut object, name).map_err(|error| error.to_string())
        };
        assert!(said("Kanne 'x' ü").is_ok());
        for (name, problem) in [
            (" ", "the name is empty"),
            ("a/b", "the name contains `/`"),
            ("a\nb", "a line break (U+000A)"),
            ("a\u{202e}b", "a mark of direction (U+202E)"),
            ("a\u{1b}[2J", "a control character (U+001B)"),
        ] {
            let sentence = said(name).unwrap_err();
            assert!(sentence.contains(problem), "{sentence}");
        }
    }
}
