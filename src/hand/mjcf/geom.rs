//! Geoms: primitives and meshes in their frames.

use nalgebra::Vector3;

use super::super::model::{Form, Part};
use super::super::{Frame, HandError};
use super::Reader;
use super::defaults::Attributes;
use super::element::Element;
use super::orientation::turning_z_to;

/// The part that a geom is; `None` for planes and terrain, which are noted.
pub(super) fn read(
    reader: &mut Reader<'_>,
    element: &Element,
    class: Option<&str>,
) -> Result<Option<Part>, HandError> {
    let (part, note) = part(reader, element, class)?;
    if let Some(note) = note {
        reader.note(note);
    }
    Ok(part)
}

fn part(
    reader: &Reader<'_>,
    element: &Element,
    class: Option<&str>,
) -> Result<(Option<Part>, Option<String>), HandError> {
    let attributes = reader.defaults.resolve(element, class)?;
    let mesh = attributes.text("mesh");
    // MuJoCo fits a primitive to its mesh; here the mesh itself is used.
    let kind = if mesh.is_some() {
        "mesh"
    } else {
        attributes.text("type").unwrap_or("sphere")
    };
    if ["plane", "hfield"].contains(&kind) {
        let note = format!(
            "{} is left out: a {kind} is not part of a hand",
            element.place()
        );
        return Ok((None, Some(note)));
    }
    let mut in_body = reader.compiler.frame(&attributes)?;
    let form = match (kind, mesh) {
        ("mesh", Some(name)) => reader.mesh(element, name)?,
        ("mesh", None) => return Err(element.error("mesh is missing")),
        _ => primitive(&attributes, kind, &mut in_body)?,
    };
    let bits = |name: &str| -> Result<bool, HandError> {
        let numbers = attributes.exactly::<1>(name)?;
        Ok(numbers.is_none_or(|[bits]| bits != 0.0))
    };
    let solid = bits("contype")? || bits("conaffinity")?;
    let part = Part {
        in_body,
        form,
        solid,
    };
    Ok((Some(part), None))
}

/// A primitive; `fromto` replaces its frame and its length.
fn primitive(
    attributes: &Attributes<'_>,
    kind: &str,
    frame: &mut Frame,
) -> Result<Form, HandError> {
    let element = attributes.element();
    let sizes = attributes.numbers("size")?.unwrap_or_default();
    let fromto = attributes.exactly::<6>("fromto")?;
    let half = match fromto {
        Some([a, b, c, d, e, f]) if ["capsule", "cylinder", "box", "ellipsoid"].contains(&kind) => {
            let (from, to) = (Vector3::new(a, b, c), Vector3::new(d, e, f));
            let Some(axis) = (from - to).try_normalize(1e-12) else {
                return Err(element.error("fromto: the two ends must differ"));
            };
            *frame = Frame {
                rotation: turning_z_to(&axis),
                translation: from.lerp(&to, 0.5),
            };
            Some((to - from).norm() / 2.0)
        }
        _ => None,
    };
    let size = |i: usize| {
        let found = sizes.get(i).copied().filter(|size| *size > 0.0);
        found.ok_or_else(|| {
            element.error(format!(
                "size: a {kind} needs {} positive number{}",
                i + 1,
                if i == 0 { "" } else { "s" }
            ))
        })
    };
    // With `fromto`, a box or ellipsoid needs one size, or two if its sides are unequal.
    let across = |i: usize| {
        if half.is_some() && sizes.len() <= i {
            size(0)
        } else {
            size(i)
        }
    };
    let along = |i: usize| half.map_or_else(|| size(i), Ok);
    Ok(match kind {
        "sphere" => Form::Sphere { radius: size(0)? },
        "capsule" => Form::Capsule {
            radius: size(0)?,
            length: 2.0 * along(1)?,
        },
        "cylinder" => Form::Cylinder {
            radius: size(0)?,
            length: 2.0 * along(1)?,
        },
        "box" => Form::Cuboid {
            size: [2.0 * size(0)?, 2.0 * across(1)?, 2.0 * along(2)?],
        },
        "ellipsoid" => Form::Ellipsoid {
            radii: [size(0)?, across(1)?, along(2)?],
        },
        other => return Err(element.error(format!("type=\"{other}\" is not read"))),
    })
}
