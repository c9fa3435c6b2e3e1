//! `landscape objects inspect`: quantities derived from an object.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueHint};
use nalgebra::Vector3;
use serde_json::{Value, json};

use super::args::{Common, within};
use super::hands::picture_named;
use super::output::{check_picture, check_side_file, source_of};
use super::{input, progress};
use crate::cli::printing::tell_written;
use crate::figure::{Image, Scene, Surface, contact_sheet_canvas};
use crate::limits::OBJECT_SCALE;
use crate::object::{Description, FoundSymmetry, OBJECT_NAMES, Object, find_symmetry};
use crate::printable::counted;
use crate::space::Symmetry;
use crate::store::FileSet;

/// Derived properties of an object.
#[derive(Debug, Args)]
pub(super) struct ObjectsInspect {
    /// The object: the name of a built-in object, a mesh (OBJ, STL, PLY, glTF), or a TOML file of shapes.
    #[arg(value_name = "NAME|FILE", value_hint = ValueHint::FilePath)]
    object: String,
    /// Metres per unit of the mesh.
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    scale: Option<f64>,
    /// Make open surfaces, such as a sheet or a cup without walls, walls of this many millimetres (0.1 to 100).
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    thickness: Option<f64>,
    /// The picture to write, with or without .png; by default the name of the object, in the current folder.
    #[arg(long, short, value_name = "NAME")]
    output: Option<PathBuf>,
    /// Write a description (.json) with the symmetry found. A description beside the mesh, with the same name, is read with
    /// it.
    #[arg(long, value_name = "FILE")]
    side_file: Option<PathBuf>,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape objects inspect bottle.obj                     a table, and bottle.png
  landscape objects inspect scan.ply --scale 0.001         a mesh in millimetres
  landscape objects inspect cup.obj --thickness 2          a surface without walls: they become 2 mm thick
  landscape objects inspect bottle.obj --side-file bottle.json
                                                           also write a description that declares the symmetry found

A mesh may consist of several closed pieces; where these overlap or touch, the solid is their union. Small holes,
triangles that face the wrong way, faces that are there twice or in both directions, and pieces that are inside out are
repaired, with a warning. A surface that encloses nothing is refused, or becomes a wall with --thickness; half of the
wall lies on each side of the surface.

Shapes (TOML; metres; a union of all parts):
  name = \"dumbbell\"
  mass_kg = 0.4
  [[parts]]
  cylinder = { centre = [0, 0, 0], axis = [0, 0, 1], radius_m = 0.012, half_height_m = 0.06 }
  [[parts]]
  sphere = { centre = [0, 0, 0.06], radius_m = 0.025 }
  [[parts]]
  cuboid = { centre = [0, 0, -0.06], half_extents = [0.02, 0.02, 0.015], edge_radius_m = 0.003 }
There is also capsule = { a = […], b = […], radius_m = … }.

The smooth field is kept between runs; `landscape cache` says where, and empties that folder.";

/// Side of each image, pixels.
const SIDE: u32 = 420;
/// Fraction of the surface above which a mesh is called self-intersecting. Smaller fractions are slivers where walls touch.
const LEAST_BURIED: f64 = 0.002;

pub(super) fn run(command: &ObjectsInspect, common: &Common) -> anyhow::Result<()> {
    if let Some(scale) = command.scale {
        within("--scale", OBJECT_SCALE, scale)?;
    }
    let picture = picture_named(command.output.as_deref(), &command.object);
    let source = source_of(&command.object, &OBJECT_NAMES, &picture);
    check_picture(&picture, &command.object, &source, common.force)?;
    if let Some(side_file) = &command.side_file {
        check_side_file(side_file, common.force)?;
    }
    let working = progress::spinner("measuring the object", common.quiet);
    let (metadata, mut notes) = input::object(&command.object, command.scale, command.thickness)?;
    let object = metadata.build(command.scale.unwrap_or(1.0))?;
    notes.extend(object.notes.iter().cloned());
    let buried = object.mesh.buried_share();
    if buried > LEAST_BURIED {
        notes.push(format!(
            "{} intersects itself: {:.1} % of its surface lies inside it and does not count as surface; contacts there \
             and the volume are wrong, so repair it in a mesh editor",
            object.name,
            100.0 * buried
        ));
    }
    let found = find_symmetry(&object.mesh, &object.exact, object.tolerance_m());
    working.finish_and_clear();
    input::warn(&notes);
    let (images, captions): (Vec<Image>, Vec<String>) = sheet(&object).into_iter().unzip();
    let sheet = contact_sheet_canvas(&images, &captions, 3).made_of(source);
    let sheet = sheet.encode(&picture);
    let sheet = sheet.with_context(|| format!("--output {}", picture.display()))?;
    let mut outputs = FileSet::default();
    outputs.add(&picture, &sheet)?;
    let mut wrote = vec![picture.as_path()];
    if let Some(side_file) = &command.side_file {
        let description = described(
            &object,
            found.symmetry.clone(),
            command.scale.unwrap_or(1.0),
        );
        let text = serde_json::to_string_pretty(&description)? + "\n";
        outputs.add(side_file, text.as_bytes())?;
        wrote.push(side_file);
    }
    outputs.finish()?;
    let written: Vec<String> = wrote
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    tell_written(
        common,
        &value(&object, &found, &notes, &wrote),
        &written.join(" and "),
    )
}

/// The description of the object, with the symmetry found if it declares none. `scale`: metres per unit of the mesh.
fn described(object: &Object, symmetry: Symmetry, scale: f64) -> Description {
    let mut description = object.description.clone();
    if description.symmetry == Symmetry::None {
        // Converted to the units of the mesh file, because the side file belongs to it.
        let of_mesh = Description {
            symmetry,
            ..Default::default()
        };
        description.symmetry = of_mesh.scaled(1.0 / scale).symmetry;
    }
    description
}

/// The report: derived quantities, in metres and kilograms.
fn value(object: &Object, found: &FoundSymmetry, notes: &[String], wrote: &[&Path]) -> Value {
    let mesh = &object.mesh;
    let [low, high] = mesh.bounds();
    let report = object.field_report.as_ref();
    json!({
        "name": object.name,
        "size_m": (high - low).as_slice(),
        "low_m": low.as_slice(),
        "high_m": high.as_slice(),
        "triangles": mesh.triangles().len(),
        "pieces": mesh.piece_count(),
        "overlapping": mesh.overlaps(),
        "area_m2": mesh.area_m2(),
        "volume_m3": mesh.volume(),
        "mass_kg": object.mass_kg,
        "mass_given": object.description.mass_kg.is_some(),
        "centroid_m": object.centroid.as_slice(),
        "radius_m": object.radius_m,
        "thin_share": object.thin_share,
        "field_cell_m": report.map(|report| report.cell_m),
        "field_error_m": report.map(|report| report.max_error_m),
        "symmetry_declared": told(&object.symmetry),
        "symmetry_found": told(&found.symmetry),
        "symmetry_deviation_m": found.deviation_m,
        "notes": notes,
        "wrote": wrote,
    })
}

fn told(symmetry: &Symmetry) -> String {
    match symmetry {
        Symmetry::None => "none".to_owned(),
        Symmetry::Axis { point, direction } => format!(
            "round about ({:.3}, {:.3}, {:.3}) through ({:.1}, {:.1}, {:.1}) mm",
            direction.x,
            direction.y,
            direction.z,
            1e3 * point.x,
            1e3 * point.y,
            1e3 * point.z
        ),
        Symmetry::Sphere { .. } => "a ball".to_owned(),
        Symmetry::Finite(motions) => {
            let turns: Vec<String> = motions
                .iter()
                .take(4)
                .filter_map(|motion| {
                    let (axis, angle) = motion.rotation.axis_angle()?;
                    Some(format!(
                        "{:.0}° about ({:.2}, {:.2}, {:.2})",
                        angle.to_degrees(),
                        axis.x,
                        axis.y,
                        axis.z
                    ))
                })
                .collect();
            let more = motions.len().saturating_sub(4);
            let more = if more > 0 {
                format!(" and {more} more")
            } else {
                String::new()
            };
            format!(
                "{}: {}{more}",
                counted(motions.len(), "motion"),
                turns.join(", ")
            )
        }
    }
}

fn sheet(object: &Object) -> Vec<(Image, String)> {
    let scene = Scene {
        surfaces: vec![Surface::of_mesh(&object.mesh)],
        markers: Vec::new(),
        cones: Vec::new(),
    };
    let views = [
        (Vector3::new(1.0, 0.35, 0.3), Vector3::z(), "from +x"),
        (Vector3::new(-0.35, 1.0, 0.3), Vector3::z(), "from +y"),
        (Vector3::new(0.2, 0.1, 1.0), Vector3::y(), "from +z, y up"),
    ];
    let draw = |(from, up, caption): (Vector3<f64>, Vector3<f64>, &str)| {
        (
            scene.render(&scene.framed(from, up), SIDE, SIDE),
            caption.to_owned(),
        )
    };
    views.map(draw).into()
}
