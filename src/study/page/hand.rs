//! Hands and objects of a page: the joint tree, the skin with its weights, and the mesh.

use serde_json::{Value, json};

use super::pack::Pack;
use crate::hand::{Hand, JointKind, Link, Skin};
use crate::mesh::Mesh;

/// The hand: what forward kinematics and skinning need, in the units of [`Hand`].
pub(super) fn hand(name: &str, hand: &Hand, pack: &mut Pack) -> Value {
    let joints = hand.joints.iter().map(|joint| {
        json!({
            "name": joint.name,
            "limits": joint.limits,
            "slides": joint.kind == JointKind::Slide,
        })
    });
    json!({
        "name": name,
        "links": hand.links.iter().map(link).collect::<Vec<_>>(),
        "joints": joints.collect::<Vec<_>>(),
        "digits": hand.digits,
        // Of MANO only capsules: its surface may not be passed on.
        "skin": skin(&if hand.bends() { hand.capsule_skin() } else { hand.skin() }, pack),
        "bending": bending(hand, pack),
    })
}

fn link(link: &Link) -> Value {
    let frame = &link.parent_from_link;
    let motion = link.motion.map(|motion| {
        json!({
            "joint": motion.joint,
            "slides": motion.kind == JointKind::Slide,
            "axis": motion.axis.as_slice(),
            "ratio": motion.ratio,
            "offset": motion.offset,
        })
    });
    json!({
        "name": link.name,
        "parent": link.parent.map(|parent| parent.0),
        // Row by row.
        "rotation": frame.rotation.transpose().as_slice(),
        "translation": frame.translation.as_slice(),
        "motion": motion,
        "ball": link.ball,
        "digit": link.digit,
    })
}

fn skin(skin: &Skin, pack: &mut Pack) -> Value {
    let bindings = || skin.vertices.iter().flat_map(|vertex| &vertex.bindings);
    let values: Vec<f64> = bindings()
        .flat_map(|(_, point, weight)| [point.x, point.y, point.z, *weight])
        .collect();
    let counts = skin.vertices.iter().map(|vertex| vertex.bindings.len());
    json!({
        "count": pack.bytes(counts.map(|count| u8::try_from(count).unwrap_or(u8::MAX))),
        "link": pack.wholes(bindings().map(|(link, ..)| link.0)),
        // x, y, z in the frame of the link, and the weight.
        "binding": pack.table(4, &values),
        "triangles": triangles(&skin.triangles, pack),
    })
}

fn bending(hand: &Hand, pack: &mut Pack) -> Value {
    let Some(bending) = hand.bending() else {
        return Value::Null;
    };
    json!({
        "offset": pack.doubles(bending.offset_rad),
        "map": pack.doubles(bending.map),
    })
}

fn triangles(triangles: &[[u32; 3]], pack: &mut Pack) -> Value {
    pack.wholes(triangles.iter().flatten().map(|corner| *corner as usize))
}

/// The mesh of an object.
pub(super) fn object(name: &str, mesh: &Mesh, pack: &mut Pack) -> Value {
    let places: Vec<f64> = (mesh.vertices().iter())
        .flat_map(|vertex| [vertex.x, vertex.y, vertex.z])
        .collect();
    json!({
        "name": name,
        "vertices": pack.floats(&places),
        "triangles": triangles(mesh.triangles(), pack),
    })
}
