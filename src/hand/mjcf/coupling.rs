//! Joints that follow others, loops of bodies, and bodies that never collide.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::super::loops::Loop;
use super::super::model::{Coupling, within};
use super::super::{Frame, HandError};
use super::Reader;
use super::element::Element;
use crate::limits::HAND_POSITION;

/// A `<fixed>` tendon: a weighted sum of joint coordinates.
struct Tendon<'a> {
    element: &'a Element,
    joints: Vec<(&'a str, f64)>,
}

pub(super) fn read(reader: &mut Reader<'_>, root: &Element) -> Result<(), HandError> {
    for exclude in root
        .children_named("contact")
        .flat_map(|contact| contact.children_named("exclude"))
    {
        let bodies = ["body1", "body2"].map(|name| exclude.attribute(name));
        if let [Some(first), Some(second)] = bodies {
            reader.model.apart.push([first, second].map(str::to_owned));
        }
    }
    let tendons = tendons(root)?;
    let mut coupled = Vec::new();
    for equality in root.children_named("equality") {
        for element in &equality.children {
            if !element.flag("active", true)? {
                continue;
            }
            match element.tag.as_str() {
                "joint" => of_joints(reader, element)?,
                "tendon" => coupled.push(of_tendon(reader, element, &tendons)?),
                "connect" | "weld" => of_bodies(reader, element)?,
                _ => reader.note(format!(
                    "{} is left out: only couplings of joints and closed loops are read",
                    element.place()
                )),
            }
        }
    }
    for tendon in &tendons {
        let limited = tendon.element.attribute("range").is_some()
            && tendon.element.attribute("limited") != Some("false");
        if limited
            && !coupled
                .iter()
                .any(|name| Some(name.as_str()) == tendon.element.attribute("name"))
        {
            let joints: Vec<&str> = tendon.joints.iter().map(|(joint, _)| *joint).collect();
            reader.note(format!(
                "{} bounds a sum of the joints {}, which stay independent here",
                tendon.element.place(),
                joints.join(" and ")
            ));
        }
    }
    Ok(())
}

fn tendons(root: &Element) -> Result<Vec<Tendon<'_>>, HandError> {
    let fixed = root
        .children_named("tendon")
        .flat_map(|tendon| tendon.children_named("fixed"));
    let read = |element| {
        let element: &Element = element;
        let mut joints = Vec::new();
        for joint in element.children_named("joint") {
            let (Some(name), Some(coefficient)) =
                (joint.attribute("joint"), joint.attribute("coef"))
            else {
                return Err(joint.error("joint and coef are needed"));
            };
            let [coefficient] = joint.exactly("coef", coefficient)?;
            joints.push((name, coefficient));
        }
        Ok(Tendon { element, joints })
    };
    fixed.map(read).collect()
}

/// `joint1 − ref1 = c₀ + c₁ (joint2 − ref2)`.
fn of_joints(reader: &mut Reader<'_>, element: &Element) -> Result<(), HandError> {
    let Some(first) = element.attribute("joint1") else {
        return Err(element.error("joint1 is missing"));
    };
    let coefficients = match element.attribute("polycoef") {
        Some(text) => element.numbers("polycoef", text)?,
        None => vec![0.0, 1.0],
    };
    if coefficients.iter().skip(2).any(|c| *c != 0.0) {
        return Err(element.error("polycoef: only linear couplings (two coefficients) are read"));
    }
    let Some(second) = element.attribute("joint2") else {
        return Err(element
            .error("a joint held at a constant is not supported: remove it from the description"));
    };
    let at = |i: usize| coefficients.get(i).copied().unwrap_or_default();
    couple(reader, element, [first, second], at(0), at(1))
}

/// `a₁ (joint1 − ref1) + a₂ (joint2 − ref2) = c₀`; returns the tendon's name.
fn of_tendon(
    reader: &mut Reader<'_>,
    element: &Element,
    tendons: &[Tendon<'_>],
) -> Result<String, HandError> {
    let name = element.attribute("tendon1").unwrap_or_default();
    let tendon = tendons
        .iter()
        .find(|tendon| tendon.element.attribute("name") == Some(name));
    let Some(tendon) = tendon.filter(|_| element.attribute("tendon2").is_none()) else {
        return Err(element.error("only the equality of one fixed tendon is read"));
    };
    let [(first, a), (second, b)] = tendon.joints[..] else {
        return Err(element.error("only tendons of two joints are read"));
    };
    if a == 0.0 || b == 0.0 {
        return Err(tendon.element.error("a coefficient of 0 couples nothing"));
    }
    let constant = match element.attribute("polycoef") {
        Some(text) => element
            .numbers("polycoef", text)?
            .first()
            .copied()
            .unwrap_or_default(),
        None => 0.0,
    };
    couple(reader, element, [first, second], constant / a, -b / a)?;
    Ok(name.to_owned())
}

/// Distance of the points that hold the orientation of a weld from its origin, metres: the length of a finger.
const LEVER_M: f64 = 0.1;

/// A point (`connect`) or a frame (`weld`) that two bodies share. Without `relpose`, bodies stand to each other as they do with
/// all joints at displacement zero.
fn of_bodies(reader: &mut Reader<'_>, element: &Element) -> Result<(), HandError> {
    let weld = element.tag == "weld";
    let numbers = |name: &str| {
        let text = element.attribute(name);
        text.map(|text| element.numbers(name, text)).transpose()
    };
    let sites = ["site1", "site2"].map(|name| element.attribute(name));
    let found = if let [Some(first), Some(second)] = sites {
        let place = |name: &str| reader.sites.get(name).cloned();
        place(first).zip(place(second))
    } else {
        let Some(first) = element.attribute("body1") else {
            return Err(element.error("body1 is missing"));
        };
        // The world holds the hand where it is, as the root does.
        let root = reader.model.bodies.first().map(|body| body.name.as_str());
        let second = element.attribute("body2").or(root).unwrap_or_default();
        let frames = reader.model.frames_at_zero();
        let body = |name: &str| {
            reader
                .model
                .bodies
                .iter()
                .position(|body| body.name == name)
        };
        let anchor = match numbers("anchor")?.as_deref() {
            Some([x, y, z]) => Vector3::new(*x, *y, *z),
            None if weld => Vector3::zeros(),
            _ => return Err(element.error("anchor: three numbers are needed")),
        };
        let at = |translation| Frame {
            translation,
            ..Frame::default()
        };
        body(first).zip(body(second)).map(|(one, other)| {
            let [mut one_from_other, other_from_one] =
                [[one, other], [other, one]].map(|[to, from]| between(&frames[to], &frames[from]));
            if let Ok(Some(pose)) = numbers("relpose")
                && let Some(given) = relative_pose(&pose)
            {
                one_from_other = given;
            }
            // The anchor of a weld is in the second body, that of a point in the first.
            let [first_frame, second_frame] = if weld {
                [one_from_other.compose(&at(anchor)), at(anchor)]
            } else {
                [at(anchor), other_from_one.compose(&at(anchor))]
            };
            (
                (first.to_owned(), first_frame),
                (second.to_owned(), second_frame),
            )
        })
    };
    let Some(((first, first_frame), (second, second_frame))) = found else {
        reader.note(format!(
            "{} is left out: it names a body that does not belong to the hand",
            element.place()
        ));
        return Ok(());
    };
    let mut corners = vec![Vector3::zeros()];
    if weld {
        corners.extend((0..3).map(|axis| Vector3::ith(axis, LEVER_M)));
    }
    let pair = |corner| [first_frame, second_frame].map(|frame| frame.point(corner));
    let points: Vec<[Vector3<f64>; 2]> = corners.iter().map(pair).collect();
    for &coordinate in points.iter().flatten().flatten() {
        within(HAND_POSITION, coordinate, || {
            format!("a point of {}", element.place())
        })?;
    }
    reader.model.loops.push(Loop {
        place: element.place(),
        points,
        links: [first, second],
    });
    Ok(())
}

/// The transform from one frame to another, both given in a third.
fn between(to: &Frame, from: &Frame) -> Frame {
    Frame {
        rotation: to.rotation.tr_mul(&from.rotation),
        translation: to.inverse_point(&from.translation),
    }
}

/// Position and quaternion (w x y z) of the second body in the first; `None` if all of the quaternion is zero.
fn relative_pose(pose: &[f64]) -> Option<Frame> {
    let [x, y, z, w, i, j, k] = *pose else {
        return None;
    };
    let turn = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-9)?;
    Some(Frame {
        rotation: *turn.to_rotation_matrix().matrix(),
        translation: Vector3::new(x, y, z),
    })
}

fn couple(
    reader: &mut Reader<'_>,
    element: &Element,
    [first, second]: [&str; 2],
    constant: f64,
    ratio: f64,
) -> Result<(), HandError> {
    let joints = &mut reader.model.joints;
    let find = |name: &str| {
        let place = joints.iter().position(|joint| joint.name == name);
        place.ok_or_else(|| element.error(format!("the hand has no joint \"{name}\"")))
    };
    let (follower, leader) = (find(first)?, find(second)?);
    let offset = joints[follower].zero + constant - ratio * joints[leader].zero;
    if joints[follower].follows.is_some() {
        return Err(element.error(format!("joint \"{first}\" follows two others")));
    }
    joints[follower].follows = Some(Coupling {
        joint: second.to_owned(),
        ratio,
        offset,
    });
    Ok(())
}
