//! The tree of bodies and the joints between them.

use nalgebra::{Matrix3, Vector3};

use super::super::model::{Body, ModelJoint};
use super::super::{Frame, HandError, JointKind};
use super::element::Element;
use super::{Reader, geom};

/// Name of the root if it is the world itself.
const WORLD: &str = "world";

/// Reads the world. The root of the hand is its outermost body, or the world if that body is displaced from the origin.
pub(super) fn read_world(reader: &mut Reader<'_>, root: &Element) -> Result<(), HandError> {
    let mut outer = Vec::new();
    for world in root.children_named("worldbody") {
        list(reader, world, &Place::default(), &mut outer)?;
    }
    let counts: Vec<usize> = outer.iter().map(|(body, _)| joints(body)).collect();
    let Some(chosen) = (0..outer.len()).rev().max_by_key(|&i| counts[i]) else {
        return Err(root.error("the world has no body"));
    };
    for (i, (body, _)) in outer.iter().enumerate() {
        if i != chosen && counts[i] > 0 {
            reader.note(format!(
                "{} is left out: a hand is one tree of bodies, and {} has more joints",
                body.place(),
                outer[chosen].0.place()
            ));
        } else if i != chosen {
            reader.note(format!("{} is left out: nothing moves in it", body.place()));
        }
    }
    let (body, place) = outer.swap_remove(chosen);
    let attributes = reader.defaults.resolve(body, None)?;
    let frame = place.frame.compose(&reader.compiler.frame(&attributes)?);
    let parent = (frame != Frame::default()).then(|| {
        reader.model.bodies.push(Body {
            name: WORLD.to_owned(),
            ..Body::default()
        });
        0
    });
    read(reader, body, &place, parent)
}

/// Where an element is: a frame and the default class of its children.
#[derive(Debug, Clone, Default)]
struct Place {
    frame: Frame,
    class: Option<String>,
}

/// Lists the bodies of the world, also those inside frames.
fn list<'a>(
    reader: &mut Reader<'_>,
    element: &'a Element,
    place: &Place,
    bodies: &mut Vec<(&'a Element, Place)>,
) -> Result<(), HandError> {
    for child in &element.children {
        match child.tag.as_str() {
            "body" => bodies.push((child, place.clone())),
            "frame" => {
                let inner = inside(reader, child, place)?;
                list(reader, child, &inner, bodies)?;
            }
            "geom" => reader.note(format!(
                "{} is left out: it belongs to the world",
                child.place()
            )),
            _ => refuse_unknown(child)?,
        }
    }
    Ok(())
}

/// The place inside a `<frame>`.
fn inside(reader: &Reader<'_>, frame: &Element, place: &Place) -> Result<Place, HandError> {
    let attributes = reader.defaults.resolve(frame, place.class.as_deref())?;
    let own = frame.attribute("childclass").map(str::to_owned);
    Ok(Place {
        frame: place.frame.compose(&reader.compiler.frame(&attributes)?),
        class: own.or_else(|| place.class.clone()),
    })
}

/// Refuses elements that create bodies in ways that are not supported.
fn refuse_unknown(element: &Element) -> Result<(), HandError> {
    if ["replicate", "attach", "composite", "flexcomp"].contains(&element.tag.as_str()) {
        return Err(element.error(format!(
            "<{}> is not read: save the compiled model with MuJoCo (mj_saveLastXML) and use that file",
            element.tag
        )));
    }
    Ok(())
}

/// Number of joints of a body and all bodies below it.
fn joints(element: &Element) -> usize {
    let below = element
        .children
        .iter()
        .map(|child| match child.tag.as_str() {
            "joint" => 1,
            "body" | "frame" => joints(child),
            _ => 0,
        });
    below.sum()
}

/// Reads a body and all bodies below it, depth first.
fn read(
    reader: &mut Reader<'_>,
    element: &Element,
    outside: &Place,
    parent: Option<usize>,
) -> Result<(), HandError> {
    let attributes = reader.defaults.resolve(element, outside.class.as_deref())?;
    let frame = outside.frame.compose(&reader.compiler.frame(&attributes)?);
    let own = element.attribute("childclass").map(str::to_owned);
    let place = Place {
        frame: Frame::default(),
        class: own.or_else(|| outside.class.clone()),
    };
    let name = element.attribute("name").map_or_else(
        || format!("body {}", reader.model.bodies.len()),
        str::to_owned,
    );

    let mut contents = Contents::default();
    gather(reader, element, &place, &name, &mut contents)?;
    let body = chain(reader, &name, frame, parent, contents.joints);
    reader.model.bodies[body].parts = contents.parts;
    for (child, place) in contents.bodies {
        read(reader, child, &place, Some(body))?;
    }
    Ok(())
}

/// Contents of a body; each joint comes with the point through which its axis passes.
#[derive(Default)]
struct Contents<'a> {
    joints: Vec<(ModelJoint, Vector3<f64>)>,
    parts: Vec<super::super::model::Part>,
    bodies: Vec<(&'a Element, Place)>,
}

fn gather<'a>(
    reader: &mut Reader<'_>,
    element: &'a Element,
    place: &Place,
    body: &str,
    contents: &mut Contents<'a>,
) -> Result<(), HandError> {
    for child in &element.children {
        let class = place.class.as_deref();
        match child.tag.as_str() {
            "geom" => {
                if let Some(mut part) = geom::read(reader, child, class)? {
                    part.in_body = place.frame.compose(&part.in_body);
                    contents.parts.push(part);
                }
            }
            "joint" => {
                let unnamed = format!("{body} joint {}", contents.joints.len() + 1);
                if let Some((mut joint, point)) = joint(reader, child, class, unnamed)? {
                    joint.axis = place.frame.direction(&joint.axis);
                    contents.joints.push((joint, place.frame.point(&point)));
                }
            }
            "site" => {
                if let Some(name) = child.attribute("name") {
                    let attributes = reader.defaults.resolve(child, class)?;
                    let frame = place.frame.compose(&reader.compiler.frame(&attributes)?);
                    reader
                        .sites
                        .insert(name.to_owned(), (body.to_owned(), frame));
                }
            }
            "freejoint" => reader.note(free(child)),
            "body" => contents.bodies.push((child, place.clone())),
            "frame" => {
                let inner = inside(reader, child, place)?;
                gather(reader, child, &inner, body, contents)?;
            }
            _ => refuse_unknown(child)?,
        }
    }
    Ok(())
}

fn free(element: &Element) -> String {
    format!(
        "{} is free and is taken as fixed: the pose of a grasp places the hand",
        element.place()
    )
}

/// Makes one link per joint, which turns about its own origin. The last link is the body; if the last joint's point is not
/// the body's origin, one more link is added as the body.
fn chain(
    reader: &mut Reader<'_>,
    name: &str,
    frame: Frame,
    parent: Option<usize>,
    joints: Vec<(ModelJoint, Vector3<f64>)>,
) -> usize {
    let at = |translation: Vector3<f64>| Frame {
        rotation: Matrix3::identity(),
        translation,
    };
    let bodies = &mut reader.model.bodies;
    let (mut above, mut to_next) = (parent, frame);
    let (count, mut offset) = (joints.len(), Vector3::zeros());
    for (i, (joint, point)) in joints.into_iter().enumerate() {
        let last = i + 1 == count && point == Vector3::zeros();
        bodies.push(Body {
            name: if last {
                name.to_owned()
            } else {
                format!("{name}: {}", joint.name)
            },
            parent: above,
            in_parent: to_next.compose(&at(point - offset)),
            joint: Some(reader.model.joints.len()),
            parts: Vec::new(),
        });
        reader.model.joints.push(joint);
        (above, to_next, offset) = (Some(bodies.len() - 1), Frame::default(), point);
        if last {
            return bodies.len() - 1;
        }
    }
    bodies.push(Body {
        name: name.to_owned(),
        parent: above,
        in_parent: to_next.compose(&at(-offset)),
        joint: None,
        parts: Vec::new(),
    });
    bodies.len() - 1
}

/// A hinge or slide and the point through which it passes; a free joint gives `None` and a note.
fn joint(
    reader: &mut Reader<'_>,
    element: &Element,
    class: Option<&str>,
    unnamed: String,
) -> Result<Option<(ModelJoint, Vector3<f64>)>, HandError> {
    let attributes = reader.defaults.resolve(element, class)?;
    let kind = match attributes.text("type").unwrap_or("hinge") {
        "hinge" => JointKind::Hinge,
        "slide" => JointKind::Slide,
        "free" => {
            let note = free(element);
            drop(attributes);
            reader.note(note);
            return Ok(None);
        }
        other => {
            return Err(element.error(format!(
                "type=\"{other}\": only hinge, slide and free joints are read; write a ball as three hinges"
            )));
        }
    };
    let given = |value: f64| {
        if kind == JointKind::Hinge {
            reader.compiler.angle(value)
        } else {
            value
        }
    };
    let axis = attributes.exactly::<3>("axis")?.unwrap_or([0.0, 0.0, 1.0]);
    let axis = Vector3::from(axis)
        .try_normalize(1e-14)
        .ok_or_else(|| element.error("axis has no direction"))?;
    let range = attributes.exactly::<2>("range")?;
    let limited = match attributes.text("limited").unwrap_or("auto") {
        "true" => true,
        "false" => false,
        "auto" => reader.compiler.auto_limits && range.is_some(),
        other => {
            return Err(element.error(format!(
                "limited=\"{other}\": true, false or auto is needed"
            )));
        }
    };
    let limits = match (limited, range) {
        (false, _) => None,
        (true, Some(range)) => Some(range.map(given)),
        (true, None) => return Err(element.error("it is limited, but range is missing")),
    };
    if let Some([lower, upper]) = limits
        && lower >= upper
    {
        return Err(element.error(format!("the range from {lower} to {upper} is empty")));
    }
    let zero = attributes
        .exactly::<1>("ref")?
        .map_or(0.0, |[zero]| given(zero));
    let point = attributes.exactly::<3>("pos")?.unwrap_or_default();
    let joint = ModelJoint {
        name: attributes.text("name").map_or(unnamed, str::to_owned),
        kind,
        axis,
        limits,
        zero,
        follows: None,
    };
    if joint.limits.is_none() && kind == JointKind::Slide {
        // Those of a virtual wrist need no limits, and others are refused when it is known.
        let places = &mut reader.model.endless_slides;
        places.push([joint.name.clone(), element.place()]);
    }
    // The axis of a slide has a direction but no position.
    let point = if kind == JointKind::Slide {
        [0.0; 3]
    } else {
        point
    };
    Ok(Some((joint, point.into())))
}
