//! Hands and objects: from flags, from the metadata of a file, and back into metadata.

use std::path::Path;
use std::sync::Arc;

use anyhow::Context;

use crate::grasp::hand::{HAND_NAMES, Hand, HandFiles};
use crate::grasp::object::{Description, Mesh, OBJECT_NAMES, Object};
use crate::store::{HandMetadata, ObjectMetadata, TextFile, content_hash};

/// The files of the hand that a flag names: one that comes with the program, or a URDF or MJCF file with a JSON side file
/// of the same stem, if there is one. What that refers to must lie in `folder`, or where it lies itself.
pub(super) fn hand_files(
    flag: &str,
    folder: Option<&Path>,
    mirror: bool,
) -> anyhow::Result<HandFiles> {
    let files = if HAND_NAMES.contains(&flag) {
        HandFiles::named(flag)?
    } else {
        anyhow::ensure!(
            Path::new(flag).exists(),
            "--hand {flag}: neither a file nor a hand that comes with the program ({})",
            HAND_NAMES.join(", ")
        );
        let path = Path::new(flag);
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

/// The hand that a flag names, with what a file must say about it.
pub(super) fn hand_metadata(
    flag: &str,
    folder: Option<&Path>,
    mirror: bool,
) -> anyhow::Result<HandMetadata> {
    let files = hand_files(flag, folder, mirror)?;
    let texts: Vec<&[u8]> = files
        .files
        .iter()
        .map(|file| file.text.as_bytes())
        .collect();
    let mut name = if HAND_NAMES.contains(&flag) {
        flag.to_owned()
    } else {
        let stem = Path::new(flag).file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    };
    if mirror {
        name += "_mirrored";
    }
    let mut metadata = HandMetadata {
        name,
        content_hash: content_hash(&texts),
        description: (files.files.iter())
            .map(|file| TextFile {
                name: file.name.clone(),
                text: file.text.clone(),
            })
            .collect(),
        ..HandMetadata::default()
    };
    let hand = hand(&metadata)?;
    metadata.joint_names = hand.joints.iter().map(|joint| joint.name.clone()).collect();
    metadata.limits_rad = hand.joints.iter().map(|joint| joint.limits_rad).collect();
    metadata.surface_points = hand.surface.len();
    Ok(metadata)
}

/// Builds the hand that metadata describe.
pub(super) fn hand(metadata: &HandMetadata) -> anyhow::Result<Arc<Hand>> {
    let Some(main) = metadata.description.first() else {
        anyhow::bail!(
            "the file does not describe hand `{}`: name it with --hand",
            metadata.name
        );
    };
    let texts = metadata.description.iter();
    let files = HandFiles::of_texts(texts.map(|file| [file.name.as_str(), file.text.as_str()]));
    let hand = Hand::from_files(&files).with_context(|| format!("hand {}", main.name))?;
    Ok(Arc::new(hand))
}

/// Checks that the hand built from a description is the one the rows were written for.
pub(super) fn check_hand(metadata: &HandMetadata, hand: &Hand) -> anyhow::Result<()> {
    let joints: Vec<&String> = hand.joints.iter().map(|joint| &joint.name).collect();
    if let Some((joint, name)) = joints
        .iter()
        .copied()
        .zip(&metadata.joint_names)
        .find(|(a, b)| a != b)
    {
        anyhow::bail!(
            "hand `{}` does not match: the file was written for joint `{name}` where its description has `{joint}`",
            metadata.name
        );
    }
    anyhow::ensure!(
        joints.len() == metadata.joint_names.len() && hand.surface.len() == metadata.surface_points,
        "hand `{}` does not match: the file was written for {} joints and {} surface points, its description gives {} \
         and {}",
        metadata.name,
        metadata.joint_names.len(),
        metadata.surface_points,
        joints.len(),
        hand.surface.len()
    );
    Ok(())
}

/// The object that a flag names, with what a file must say about it.
pub(super) fn object_metadata(flag: &str) -> anyhow::Result<(Arc<Object>, ObjectMetadata)> {
    let object = if OBJECT_NAMES.contains(&flag) {
        Object::named(flag)?
    } else {
        anyhow::ensure!(
            Path::new(flag).exists(),
            "--object {flag}: neither a file nor an object that comes with the program ({})",
            OBJECT_NAMES.join(", ")
        );
        Object::load(flag)?
    };
    let obj = object.mesh.to_obj();
    let description = serde_json::to_value(&object.description)?;
    let metadata = ObjectMetadata {
        name: object.name.clone(),
        mass_kg: object.mass_kg,
        content_hash: content_hash(&[obj.as_bytes(), description.to_string().as_bytes()]),
        description,
        mesh_obj: Some(obj),
    };
    // The mesh as it is stored, so that a run from a flag and one from a file agree to the last bit.
    Ok((self::object(&metadata, 1.0)?, metadata))
}

/// Builds the object that metadata describe, `scale` times as large.
pub(super) fn object(metadata: &ObjectMetadata, scale: f64) -> anyhow::Result<Arc<Object>> {
    let (mesh, description) = parts(metadata, scale)?;
    Ok(Arc::new(Object::from_mesh(
        &metadata.name,
        mesh,
        &description,
    )?))
}

/// Mesh and mass (kg) of the object that metadata describe, `scale` times as large: what needs no smooth field.
pub(super) fn mesh(metadata: &ObjectMetadata, scale: f64) -> anyhow::Result<(Mesh, f64)> {
    let (mesh, _) = parts(metadata, scale)?;
    Ok((mesh, metadata.mass_kg * scale.powi(3)))
}

fn parts(metadata: &ObjectMetadata, scale: f64) -> anyhow::Result<(Mesh, Description)> {
    let name = &metadata.name;
    let Some(obj) = &metadata.mesh_obj else {
        anyhow::bail!("the file does not hold the mesh of object `{name}`: name it with --object");
    };
    let description: Description = serde_json::from_value(metadata.description.clone())
        .with_context(|| format!("the description of object `{name}` in the file"))?;
    let mesh = Mesh::from_obj(name, &mut obj.as_bytes())?;
    Ok(if (scale - 1.0).abs() < f64::EPSILON {
        (mesh, description)
    } else {
        (mesh.scaled(name, scale)?, description.scaled(scale))
    })
}
