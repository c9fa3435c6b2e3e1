//! Hands and objects: from flags, from the metadata of a file, and back into metadata.

use std::path::Path;
use std::sync::Arc;

use anyhow::Context;

use crate::hand::{Frame, HAND_NAMES, Hand, HandFiles, LinkId};
use crate::limits::{OBJECT_MASS, OBJECT_SCALE};
use crate::object::{Assembly, Description, Mesh, OBJECT_NAMES, Object, ObjectParts};
use crate::store::{HandMetadata, ObjectMetadata, TextFile, content_hash};

use super::input::within;

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
    let identity = files.identity();
    let texts: Vec<&[u8]> = identity.iter().map(String::as_bytes).collect();
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

/// Where the outermost body of a hand stands whose root is the world, because it stands away from the origin.
pub(super) fn root_offset(hand: &Hand) -> Option<Frame> {
    let [root, body, ..] = hand.links.as_slice() else {
        return None;
    };
    let fixed = root.name == "world" && body.parent == Some(LinkId(0)) && body.motion.is_none();
    fixed.then_some(body.parent_from_link)
}

/// What a file must say about the object that a flag names, at scale 1: one that comes with the program, a mesh, or a TOML
/// file of shapes. Also what was repaired. A mass in the description is that of the object at `scale`.
pub(super) fn object_metadata(
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
            Path::new(flag).exists(),
            "--object {flag}: neither a file nor an object that comes with the program ({})",
            OBJECT_NAMES.join(", ")
        );
        if path
            .extension()
            .is_some_and(|kind| kind.eq_ignore_ascii_case("toml"))
        {
            of_toml(path)?
        } else {
            Object::parts_of_file(path)?
        }
    };
    if let Some(scale) = scale {
        within("--scale", OBJECT_SCALE, scale)?;
        let mass_kg = &mut parts.description.mass_kg;
        *mass_kg = mass_kg.map(|mass| mass / scale.powi(3));
    }
    let obj = parts.mesh.to_obj();
    let description = serde_json::to_value(&parts.description)?;
    let metadata = ObjectMetadata {
        name: parts.name,
        mass_kg: parts.description.mass_of(&parts.mesh),
        content_hash: content_hash(&[obj.as_bytes(), description.to_string().as_bytes()]),
        description,
        mesh_obj: Some(obj),
    };
    Ok((metadata, parts.notes))
}

/// Gives an object the name that a flag asks for, if any.
pub(super) fn rename(object: &mut ObjectMetadata, name: Option<&str>) -> anyhow::Result<()> {
    if let Some(name) = name {
        // Names become parts of file names.
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

/// An object of shapes.
fn of_toml(path: &Path) -> anyhow::Result<ObjectParts> {
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
    let assembly: Assembly = crate::toml_text::parse(&text).with_context(|| name.clone())?;
    let (mesh, description) = assembly.object(&name)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok(ObjectParts {
        name: assembly.name.clone().unwrap_or_else(|| stem.into_owned()),
        mesh,
        notes: Vec::new(),
        description,
    })
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
    mesh.check_size(&metadata.name)?;
    let mass_kg = metadata.mass_kg * scale.powi(3);
    let told = OBJECT_MASS.check(mass_kg);
    told.with_context(|| format!("the mass of object `{}`", metadata.name))?;
    Ok((mesh, mass_kg))
}

fn parts(metadata: &ObjectMetadata, scale: f64) -> anyhow::Result<(Mesh, Description)> {
    let name = &metadata.name;
    let Some(obj) = &metadata.mesh_obj else {
        anyhow::bail!("the file does not hold the mesh of object `{name}`: name it with --object");
    };
    let description: Description = serde_json::from_value(metadata.description.clone())
        .with_context(|| format!("the description of object `{name}` in the file"))?;
    let mesh = description.mesh_of_obj(name, obj)?;
    Ok(if (scale - 1.0).abs() < f64::EPSILON {
        (mesh, description)
    } else {
        (mesh.scaled(name, scale)?, description.scaled(scale))
    })
}
