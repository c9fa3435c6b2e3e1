//! From a description file to a hand: the kinematic tree and its capsules.

use nalgebra::{Rotation3, Vector3};
use urdf_rs::{Geometry, JointType, Pose, Robot};

use super::side_file::{self, CapsuleEntry, SideFile};
use super::{
    Capsule, Frame, Hand, HandError, Joint, Link, LinkId, PalmFrame, PosedHand, coordinates, prior,
    region, self_pairs, surface,
};

pub(super) fn read(text: &str, side_file: Option<&str>) -> Result<Hand, HandError> {
    let side = side_file::parse(side_file)?;
    let robot = urdf_rs::read_from_string(text)?;
    let (mut links, joints) = tree(&robot)?;
    let capsules = capsules(&robot, &side, &links)?;
    let digits = region::assign_digits(&mut links, &joints, &capsules, &side)?;
    let (rest_rad, cast_rad) = prior::poses(&joints, &side)?;
    let prior = prior::gaussian(rest_rad, &joints, &side)?;

    let mut hand = Hand {
        name: side.name.clone().unwrap_or_else(|| robot.name.clone()),
        subtree_ends: subtree_ends(&links),
        link_points: vec![0..0; links.len()],
        links,
        joints,
        capsules,
        self_pairs: Vec::new(),
        surface: Vec::new(),
        digits,
        regions: Vec::new(),
        prior,
        palm: PalmFrame {
            centre: Vector3::zeros(),
            volar: Vector3::z(),
            distal: Vector3::y(),
        },
        cast_rad,
    };
    let mut rest = PosedHand::default();
    hand.pose(&coordinates(&hand.prior.rest_rad), &mut rest);
    hand.self_pairs = self_pairs::derive(&hand, &rest);
    hand.surface = surface::sample(&hand, &rest);
    hand.index_surface();
    hand.pose(&coordinates(&hand.prior.rest_rad), &mut rest);
    region::tag(&mut hand, &rest, &side)?;
    hand.palm = region::palm_frame(&hand, &rest, &side)?;
    Ok(hand)
}

/// Links depth first and joints in file order.
fn tree(robot: &Robot) -> Result<(Vec<Link>, Vec<Joint>), HandError> {
    let position = |name: &str| robot.links.iter().position(|link| link.name == name);
    for (i, link) in robot.links.iter().enumerate() {
        if position(&link.name) != Some(i) {
            return Err(HandError::Twice {
                kind: "link",
                name: link.name.clone(),
            });
        }
    }
    let mut parent_joint = vec![None; robot.links.len()];
    let mut children = vec![Vec::new(); robot.links.len()];
    for (j, joint) in robot.joints.iter().enumerate() {
        if robot.joints[..j]
            .iter()
            .any(|other| other.name == joint.name)
        {
            return Err(HandError::Twice {
                kind: "joint",
                name: joint.name.clone(),
            });
        }
        let find = |name: &str| {
            position(name).ok_or_else(|| HandError::Unknown {
                place: format!("joint \"{}\"", joint.name),
                kind: "link",
                name: name.to_owned(),
            })
        };
        let (parent, child) = (find(&joint.parent.link)?, find(&joint.child.link)?);
        if let Some(first) = parent_joint[child].replace(j) {
            return Err(HandError::TwoParents {
                link: joint.child.link.clone(),
                first: robot.joints[first].name.clone(),
                second: joint.name.clone(),
            });
        }
        children[parent].push((j, child));
    }
    let roots: Vec<usize> = (0..robot.links.len())
        .filter(|&l| parent_joint[l].is_none())
        .collect();
    let [root] = roots[..] else {
        return Err(HandError::Roots {
            roots: roots.iter().map(|&l| robot.links[l].name.clone()).collect(),
        });
    };

    let mut coordinate = vec![None; robot.joints.len()];
    let mut joints = Vec::new();
    for (j, joint) in robot.joints.iter().enumerate() {
        if let Some(joint) = movable(joint)? {
            coordinate[j] = Some(joints.len());
            joints.push(joint);
        }
    }
    if joints.is_empty() {
        return Err(HandError::NoJoints);
    }

    let mut links = Vec::with_capacity(robot.links.len());
    let mut stack = vec![(root, None)];
    while let Some((l, parent)) = stack.pop() {
        let id = LinkId(links.len());
        let above = parent_joint[l].map(|j: usize| &robot.joints[j]);
        let joint = parent_joint[l].and_then(|j| coordinate[j]);
        if let Some(j) = joint {
            joints[j].link = id;
        }
        links.push(Link {
            name: robot.links[l].name.clone(),
            parent,
            parent_from_link: above.map_or_else(
                || Ok(Frame::default()),
                |joint| frame(&joint.origin, &joint.name),
            )?,
            joint,
            digit: 0,
        });
        stack.extend(
            children[l]
                .iter()
                .rev()
                .map(|&(_, child)| (child, Some(id))),
        );
    }
    match robot
        .links
        .iter()
        .find(|link| links.iter().all(|known: &Link| known.name != link.name))
    {
        Some(link) => Err(HandError::Ring {
            link: link.name.clone(),
        }),
        None => Ok((links, joints)),
    }
}

/// The joint as a coordinate; `None` if it is fixed.
fn movable(joint: &urdf_rs::Joint) -> Result<Option<Joint>, HandError> {
    let unsupported = |kind| {
        Err(HandError::UnsupportedJoint {
            joint: joint.name.clone(),
            kind,
        })
    };
    if joint.mimic.is_some() {
        return unsupported("a mimic joint");
    }
    let (limits_rad, wraps) = match joint.joint_type {
        JointType::Fixed => return Ok(None),
        JointType::Revolute => ([joint.limit.lower, joint.limit.upper], false),
        JointType::Continuous => ([-std::f64::consts::PI, std::f64::consts::PI], true),
        JointType::Prismatic => return unsupported("prismatic"),
        JointType::Floating => return unsupported("floating"),
        JointType::Planar => return unsupported("planar"),
        JointType::Spherical => return unsupported("spherical"),
    };
    let [lower, upper] = limits_rad;
    if !(lower.is_finite() && upper.is_finite() && lower < upper) {
        return Err(HandError::EmptyRange {
            joint: joint.name.clone(),
            lower,
            upper,
        });
    }
    let axis = Vector3::from(joint.axis.xyz.0)
        .try_normalize(1e-9)
        .filter(|axis| axis.iter().all(|x| x.is_finite()))
        .ok_or_else(|| HandError::NoAxis {
            joint: joint.name.clone(),
        })?;
    Ok(Some(Joint {
        name: joint.name.clone(),
        link: LinkId(0),
        axis,
        limits_rad,
        wraps,
    }))
}

fn frame(pose: &Pose, place: &str) -> Result<Frame, HandError> {
    let [roll, pitch, yaw] = pose.rpy.0;
    let translation = Vector3::from(pose.xyz.0);
    if ![roll, pitch, yaw]
        .iter()
        .chain(&translation)
        .all(|x| x.is_finite())
    {
        return Err(HandError::NotFinite {
            place: format!("the origin of \"{place}\""),
        });
    }
    Ok(Frame {
        rotation: *Rotation3::from_euler_angles(roll, pitch, yaw).matrix(),
        translation,
    })
}

/// For depth-first links: one past the last link of each subtree.
fn subtree_ends(links: &[Link]) -> Vec<usize> {
    let mut ends: Vec<usize> = (1..=links.len()).collect();
    for l in (1..links.len()).rev() {
        if let Some(parent) = links[l].parent {
            ends[parent.0] = ends[parent.0].max(ends[l]);
        }
    }
    ends
}

/// Capsules of all links, sorted by link.
fn capsules(robot: &Robot, side: &SideFile, links: &[Link]) -> Result<Vec<Capsule>, HandError> {
    if let Some(name) = side
        .capsules
        .keys()
        .find(|&name| links.iter().all(|link| &link.name != name))
    {
        let place = "\"capsules\" of the side file".to_owned();
        return Err(HandError::Unknown {
            place,
            kind: "link",
            name: name.clone(),
        });
    }
    let solid = robot.links.iter().any(|link| !link.collision.is_empty());
    let mut capsules = Vec::new();
    for (l, link) in links.iter().enumerate() {
        if let Some(entries) = side.capsules.get(&link.name) {
            for &CapsuleEntry { a, b, radius_m } in entries {
                check_size(radius_m, &link.name)?;
                capsules.push(Capsule {
                    link: LinkId(l),
                    a: a.into(),
                    b: b.into(),
                    radius_m,
                });
            }
            continue;
        }
        let Some(described) = robot
            .links
            .iter()
            .find(|described| described.name == link.name)
        else {
            continue;
        };
        let parts: Vec<(&Pose, &Geometry)> = if solid {
            described
                .collision
                .iter()
                .map(|part| (&part.origin, &part.geometry))
                .collect()
        } else {
            described
                .visual
                .iter()
                .map(|part| (&part.origin, &part.geometry))
                .collect()
        };
        for (origin, geometry) in parts {
            let link_from_part = frame(origin, &link.name)?;
            for capsule in primitive(geometry, LinkId(l), &link.name)? {
                capsules.push(Capsule {
                    a: link_from_part.point(&capsule.a),
                    b: link_from_part.point(&capsule.b),
                    ..capsule
                });
            }
        }
    }
    if capsules.is_empty() {
        return Err(HandError::NoGeometry);
    }
    Ok(capsules)
}

fn check_size(size: f64, link: &str) -> Result<(), HandError> {
    if size > 0.0 && size.is_finite() {
        Ok(())
    } else {
        Err(HandError::Size {
            link: link.to_owned(),
            size,
        })
    }
}

/// A primitive as capsules in its own frame.
///
/// A cylinder becomes the capsule that reaches from cap to cap, a flat one the box around it; a box becomes a row of
/// parallel capsules as thick as its shortest side, which rounds its edges off.
fn primitive(geometry: &Geometry, link: LinkId, name: &str) -> Result<Vec<Capsule>, HandError> {
    let along_z = |radius_m: f64, half: f64| {
        vec![Capsule {
            link,
            a: Vector3::z() * -half,
            b: Vector3::z() * half,
            radius_m,
        }]
    };
    match geometry {
        Geometry::Sphere { radius } => {
            check_size(*radius, name)?;
            Ok(along_z(*radius, 0.0))
        }
        Geometry::Capsule { radius, length } => {
            check_size(*radius, name)?;
            check_size(*length, name)?;
            Ok(along_z(*radius, length / 2.0))
        }
        Geometry::Cylinder { radius, length } => {
            check_size(*radius, name)?;
            check_size(*length, name)?;
            if 2.0 * radius > *length {
                return Ok(rounded_box([2.0 * radius, 2.0 * radius, *length], link));
            }
            Ok(along_z(*radius, length / 2.0 - radius))
        }
        Geometry::Box { size } => {
            for &side in &size.0 {
                check_size(side, name)?;
            }
            Ok(rounded_box(size.0, link))
        }
        Geometry::Mesh { filename, .. } => Err(HandError::Mesh {
            link: name.to_owned(),
            file: filename.clone(),
        }),
    }
}

/// Parallel capsules along the longest side, their axes at most a radius apart.
fn rounded_box(size: [f64; 3], link: LinkId) -> Vec<Capsule> {
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| size[j].total_cmp(&size[i]));
    let [long, wide, thin] = order;
    let radius_m = size[thin] / 2.0;
    let half = |axis: usize| Vector3::ith(axis, size[axis] / 2.0 - radius_m);
    let gaps = (0..64)
        .find(|&gaps| 2.0 * half(wide)[wide] <= f64::from(gaps) * radius_m)
        .unwrap_or(64);
    (0..=gaps)
        .map(|row| {
            let centre = half(wide) * (f64::from(2 * row - gaps) / f64::from(gaps.max(1)));
            Capsule {
                link,
                a: centre - half(long),
                b: centre + half(long),
                radius_m,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes and flat cylinders reach exactly as far as they should along each axis, whichever side is longest.
    #[test]
    fn primitives_keep_their_extents() {
        let extents = |geometry: &Geometry| {
            let capsules = primitive(geometry, LinkId(0), "a").unwrap();
            let reach = |axis: usize| {
                let reach = |c: &Capsule| c.a[axis].abs().max(c.b[axis].abs()) + c.radius_m;
                2.0 * capsules.iter().map(reach).fold(0.0, f64::max)
            };
            [reach(0), reach(1), reach(2)]
        };
        let vec3 = urdf_rs::Vec3;
        for (geometry, expected) in [
            (
                Geometry::Box {
                    size: vec3([0.1, 0.02, 0.06]),
                },
                [0.1, 0.02, 0.06],
            ),
            (
                Geometry::Box {
                    size: vec3([0.03, 0.03, 0.03]),
                },
                [0.03; 3],
            ),
            (
                Geometry::Cylinder {
                    radius: 0.01,
                    length: 0.05,
                },
                [0.02, 0.02, 0.05],
            ),
            (
                Geometry::Cylinder {
                    radius: 0.04,
                    length: 0.02,
                },
                [0.08, 0.08, 0.02],
            ),
            (
                Geometry::Capsule {
                    radius: 0.01,
                    length: 0.05,
                },
                [0.02, 0.02, 0.07],
            ),
        ] {
            let found = extents(&geometry);
            for axis in 0..3 {
                assert!(
                    (found[axis] - expected[axis]).abs() < 1e-12,
                    "{geometry:?}: {found:?}"
                );
            }
        }
    }
}
