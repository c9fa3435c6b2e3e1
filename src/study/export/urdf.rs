//! A hand as URDF.

use std::fmt::Write as _;

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::text::{comment, name, numbers, obj};
use super::tree::{Attached, Moving, attached};
use super::{ExportError, ExportedFile, check_rigid};
use crate::evaluation::stability::{Closing, LoadTest};
use crate::figure::MAKER;
use crate::hand::{Capsule, Frame, Hand, JointKind, LinkId};

/// Largest speed of a joint, rad/s (a tenth of it in m/s for a slide). URDF demands a number; the program has none.
const VELOCITY: f64 = 10.0;
/// Mass and inertia that every link has at least.
const LEAST: [f64; 2] = [1e-3, 1e-7];

/// The hand as URDF, and its meshes as OBJ files beside it.
///
/// Links, joints, limits and couplings are those of the hand. A mesh stands for itself, for drawing and for collisions. A
/// capsule collides as a cylinder and two balls, because few readers know capsules, and is drawn as a mesh. The masses are
/// those of the simulations of stability.
///
/// # Errors
/// If the hand has a skin that bends.
pub fn hand_urdf(hand: &Hand) -> Result<Vec<ExportedFile>, ExportError> {
    check_rigid(hand)?;
    let mut files = Vec::new();
    let links = attached(hand);
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<!-- Made by {MAKER}: hand {}. Metres, radians, kilograms. -->\n<robot name=\"{}\">\n",
        comment(&hand.name),
        name(&hand.name)
    );
    for (place, part) in links.iter().enumerate() {
        link(&mut text, hand, place, part, &mut files);
    }
    for part in in_order(hand, &links) {
        joint(&mut text, hand, part);
    }
    text.push_str("</robot>\n");
    let description = ExportedFile {
        name: format!("{}.urdf", file_name(&hand.name)),
        bytes: text.into_bytes(),
    };
    files.insert(0, description);
    Ok(files)
}

/// A name without characters that file systems refuse.
fn file_name(text: &str) -> String {
    let safe = |letter: char| letter.is_ascii_alphanumeric() || "-_.".contains(letter);
    let name: String = text
        .chars()
        .map(|c| if safe(c) { c } else { '_' })
        .collect();
    let name = name.trim_start_matches('.');
    if name.is_empty() { "hand" } else { name }.to_owned()
}

/// The links below others, such that the coordinates have the order of the hand's joints, and otherwise depth first.
fn in_order<'a, 'h>(hand: &Hand, links: &'a [Attached<'h>]) -> Vec<&'a Attached<'h>> {
    let mut key = 0;
    let mut keyed: Vec<(usize, &Attached<'_>)> = links
        .iter()
        .filter(|part| part.link.parent.is_some())
        .map(|part| {
            if let Some(Moving {
                follows: None,
                leader,
                ..
            }) = part.joint
            {
                key = leader;
            }
            (key, part)
        })
        .collect();
    debug_assert!(keyed.iter().all(|(key, _)| *key < hand.joints.len()));
    keyed.sort_by_key(|(key, _)| *key);
    keyed.into_iter().map(|(_, part)| part).collect()
}

fn link(
    text: &mut String,
    hand: &Hand,
    place: usize,
    part: &Attached<'_>,
    files: &mut Vec<ExportedFile>,
) {
    let _ = writeln!(text, "  <link name=\"{}\">", name(&part.link.name));
    let least = if part.joint.is_some() {
        LEAST
    } else {
        [0.0; 2]
    };
    let mass = hand.link_mass(part.id, Closing::DENSITY_KG_M3, least);
    if mass.mass_kg > 0.0 {
        let i = &mass.inertia;
        let _ = writeln!(
            text,
            "    <inertial><origin xyz=\"{}\"/><mass value=\"{}\"/><inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/></inertial>",
            numbers(&mass.centre),
            mass.mass_kg,
            i[(0, 0)],
            i[(0, 1)],
            i[(0, 2)],
            i[(1, 1)],
            i[(1, 2)],
            i[(2, 2)],
        );
    }
    let mut count = 0;
    let mut add = |vertices: &[Vector3<f64>], triangles: &[[u32; 3]]| {
        let file = format!("link_{place:02}_{count}.obj");
        count += 1;
        files.push(obj(file.clone(), vertices, triangles));
        format!("<geometry><mesh filename=\"{file}\"/></geometry>")
    };
    for (_, vertices, triangles) in hand.link_meshes().filter(|(link, ..)| *link == part.id) {
        let geometry = add(vertices, triangles);
        let _ = writeln!(text, "    <visual>{geometry}</visual>");
        let _ = writeln!(text, "    <collision>{geometry}</collision>");
    }
    for capsule in capsules(hand, part.id) {
        let (vertices, triangles) = Hand::capsule_triangles(capsule);
        let geometry = add(&vertices, &triangles);
        let _ = writeln!(text, "    <visual>{geometry}</visual>");
        collision(text, capsule);
    }
    text.push_str("  </link>\n");
}

fn capsules(hand: &Hand, link: LinkId) -> impl Iterator<Item = &Capsule> {
    hand.exact_capsules()
        .filter(move |capsule| capsule.link == link)
}

/// A capsule as a cylinder between two balls; a ball if it has no length.
fn collision(text: &mut String, capsule: &Capsule) {
    let span = capsule.b - capsule.a;
    let ball = |text: &mut String, centre: &Vector3<f64>| {
        let _ = writeln!(
            text,
            "    <collision><origin xyz=\"{}\"/><geometry><sphere radius=\"{}\"/></geometry></collision>",
            numbers(centre),
            capsule.radius_m
        );
    };
    ball(text, &capsule.a);
    let Some(along) = span.try_normalize(1e-9) else {
        return;
    };
    ball(text, &capsule.b);
    // Half a turn where the axis points down.
    let turn = Rotation3::rotation_between(&Vector3::z(), &along)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let frame = Frame {
        rotation: *turn.matrix(),
        translation: capsule.a.lerp(&capsule.b, 0.5),
    };
    let _ = writeln!(
        text,
        "    <collision>{}<geometry><cylinder radius=\"{}\" length=\"{}\"/></geometry></collision>",
        origin(&frame),
        capsule.radius_m,
        span.norm()
    );
}

fn joint(text: &mut String, hand: &Hand, part: &Attached<'_>) {
    let Some(parent) = part.link.parent else {
        return;
    };
    let kind = match &part.joint {
        None => "fixed",
        Some(Moving { limits: None, .. }) => "continuous",
        Some(Moving {
            kind: JointKind::Hinge,
            ..
        }) => "revolute",
        Some(Moving {
            kind: JointKind::Slide,
            ..
        }) => "prismatic",
    };
    // Fixed joints have no name in the hand; that of the link is unique among them.
    let own = match &part.joint {
        None => format!("{}_fixed", part.link.name),
        Some(_) => part.link.joint_name.clone(),
    };
    let _ = writeln!(
        text,
        "  <joint name=\"{}\" type=\"{kind}\">\n    <parent link=\"{}\"/><child link=\"{}\"/>{}",
        name(&own),
        name(&hand.links[parent.0].name),
        name(&part.link.name),
        origin(&part.origin)
    );
    if let Some(moving) = &part.joint {
        let _ = writeln!(text, "    <axis xyz=\"{}\"/>", numbers(&moving.axis));
        let lever = moving.kind.radians_per_unit();
        let range = match moving.limits {
            Some([lower, upper]) => format!("lower=\"{lower}\" upper=\"{upper}\" "),
            None => String::new(),
        };
        let _ = writeln!(
            text,
            "    <limit {range}effort=\"{}\" velocity=\"{}\"/>",
            LoadTest::default().closing.torque_limit_n_m * lever,
            VELOCITY / lever
        );
        if let Some([ratio, offset]) = moving.follows {
            let _ = writeln!(
                text,
                "    <mimic joint=\"{}\" multiplier=\"{ratio}\" offset=\"{offset}\"/>",
                name(&hand.joints[moving.leader].name)
            );
        }
    }
    text.push_str("  </joint>\n");
}

fn origin(frame: &Frame) -> String {
    format!(
        "<origin xyz=\"{}\" rpy=\"{}\"/>",
        numbers(&frame.translation),
        numbers(&angles(&frame.rotation))
    )
}

/// Roll, pitch and yaw of R = Rz(yaw) Ry(pitch) Rx(roll), exact to rounding at a pitch of ±90° as well.
fn angles(rotation: &Matrix3<f64>) -> [f64; 3] {
    let r = |row: usize, column: usize| rotation[(row, column)];
    let pitch = libm::atan2(-r(2, 0), libm::hypot(r(0, 0), r(1, 0)));
    let yaw = libm::atan2(r(1, 0), r(0, 0));
    let (sin, cos) = libm::sincos(yaw);
    // Without its yaw, the rotation takes y to (…, cos roll, sin roll cos pitch), and z to (…, −sin roll, …).
    let roll = libm::atan2(sin * r(0, 2) - cos * r(1, 2), cos * r(1, 1) - sin * r(0, 1));
    [roll, pitch, yaw]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_give_the_rotation_again() {
        let half = std::f64::consts::FRAC_PI_2;
        for [a, b, c] in [
            [0.3, -0.7, 2.9],
            [-3.0, half, 0.1],
            [0.4, -half, 0.0],
            [1.4317, half - 1e-9, -2.0558],
        ] {
            let rotation = Rotation3::from_euler_angles(a, b, c);
            let [a, b, c] = angles(rotation.matrix());
            let again = Rotation3::from_euler_angles(a, b, c);
            assert!((rotation.matrix() - again.matrix()).norm() < 1e-14);
        }
    }
}
