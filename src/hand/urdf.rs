//! URDF: bodies, joints and parts as `urdf-rs` reads them.

use std::sync::Arc;

use nalgebra::{Rotation3, Vector3};
use urdf_rs::{Geometry, JointType, Pose, Robot};

use super::mesh::triangles;
use super::model::{Body, Coupling, Form, Model, ModelJoint, Part, check_tree};
use super::sources::Files;
use super::{Frame, HandError, JointKind, urdf_form};
use crate::doubt::Doubt;

/// Reads the text of the file `name`.
pub(super) fn read(name: &str, text: &str, files: &dyn Files) -> Result<Model, HandError> {
    let robot = urdf_rs::read_from_string(&urdf_form::check(name, text)?)?;
    let mut model = Model {
        name: robot.name.clone(),
        ..Model::default()
    };
    let tree = Tree::of(&robot)?;
    let mut number = vec![None; robot.joints.len()];
    for (j, joint) in robot.joints.iter().enumerate() {
        if let Some(read) = movable(joint, &mut model.notes)? {
            number[j] = Some(model.joints.len());
            model.joints.push(read);
        }
    }
    let mut stack = vec![(tree.root, None)];
    while let Some((l, parent)) = stack.pop() {
        let id = model.bodies.len();
        let above = tree.parent_joint[l].map(|j| &robot.joints[j]);
        model.bodies.push(Body {
            name: robot.links[l].name.clone(),
            parent,
            in_parent: above.map_or_else(
                || Ok(Frame::default()),
                |joint| frame(&joint.origin, &joint.name),
            )?,
            joint: tree.parent_joint[l].and_then(|j| number[j]),
            parts: parts(&robot.links[l], files)?,
        });
        let below = tree.children[l].iter().rev();
        stack.extend(below.map(|&child| (child, Some(id))));
    }
    let known = |name: &str| model.bodies.iter().any(|body| body.name == name);
    match robot.links.iter().find(|link| !known(&link.name)) {
        Some(link) => Err(HandError::Ring {
            link: link.name.clone(),
        }),
        None => Ok(model),
    }
}

/// Parents and children of links, by index in the file.
struct Tree {
    root: usize,
    parent_joint: Vec<Option<usize>>,
    children: Vec<Vec<usize>>,
}

impl Tree {
    fn of(robot: &Robot) -> Result<Self, HandError> {
        check_tree(robot.links.len(), robot.joints.len())?;
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
            children[parent].push(child);
        }
        let roots: Vec<usize> = (0..robot.links.len())
            .filter(|&l| parent_joint[l].is_none())
            .collect();
        let [root] = roots[..] else {
            return Err(HandError::Roots {
                roots: roots.iter().map(|&l| robot.links[l].name.clone()).collect(),
            });
        };
        Ok(Self {
            root,
            parent_joint,
            children,
        })
    }
}

/// The joint, unless it is fixed.
fn movable(
    joint: &urdf_rs::Joint,
    notes: &mut Vec<String>,
) -> Result<Option<ModelJoint>, HandError> {
    let unsupported = |kind| {
        Err(HandError::UnsupportedJoint {
            joint: joint.name.clone(),
            kind,
        })
    };
    let range = Some([joint.limit.lower, joint.limit.upper]);
    let (kind, limits) = match joint.joint_type {
        JointType::Fixed => return Ok(None),
        JointType::Revolute => (JointKind::Hinge, range),
        JointType::Continuous => {
            notes.extend(endless(joint));
            (JointKind::Hinge, None)
        }
        JointType::Prismatic => (JointKind::Slide, range),
        JointType::Floating => {
            notes.push(format!(
                "joint \"{}\" is floating and is taken as fixed: the pose of a grasp places the hand",
                joint.name
            ));
            return Ok(None);
        }
        JointType::Planar => return unsupported("planar"),
        JointType::Spherical => return unsupported("spherical"),
    };
    let axis = Vector3::from(joint.axis.xyz.0)
        .try_normalize(1e-9)
        .filter(|axis| axis.iter().all(|x| x.is_finite()))
        .ok_or_else(|| HandError::NoAxis {
            joint: joint.name.clone(),
        })?;
    let follows = joint.mimic.as_ref().map(|mimic| Coupling {
        joint: mimic.joint.clone(),
        ratio: mimic.multiplier.unwrap_or(1.0),
        offset: mimic.offset.unwrap_or(0.0),
    });
    if let Some(Coupling { ratio, offset, .. }) = &follows
        && !(ratio.is_finite() && offset.is_finite())
    {
        return Err(HandError::NotFinite {
            place: format!("the mimic of joint \"{}\"", joint.name),
        });
    }
    Ok(Some(ModelJoint {
        name: joint.name.clone(),
        kind,
        axis,
        limits,
        zero: 0.0,
        follows,
    }))
}

/// The doubt about a joint that turns endlessly although it has limits.
fn endless(joint: &urdf_rs::Joint) -> Option<String> {
    let range = [joint.limit.lower, joint.limit.upper].map(f64::to_degrees);
    let [lower, upper] = range;
    // Exporters write a whole turn to say that there is no limit.
    let given = lower < upper && upper - lower < 359.0;
    given.then(|| {
        let doubt = Doubt {
            subject: format!("joint \"{}\"", joint.name),
            finding: format!(
                "it is continuous and turns endlessly, although it has limits ({lower:.0}° to {upper:.0}°)"
            ),
            cause: "probably it should stop there".to_owned(),
            remedy: "write type=\"revolute\" for the limits to hold, or delete them".to_owned(),
        };
        doubt.to_string()
    })
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

/// Collision geometry of a link, or its visual geometry if it has none, which may not count ([`super::geometry`]).
fn parts(link: &urdf_rs::Link, files: &dyn Files) -> Result<Vec<Part>, HandError> {
    let read = |pose: &Pose, geometry: &Geometry, solid| {
        Ok(Part {
            in_body: frame(pose, &link.name)?,
            form: form(geometry, &link.name, files)?,
            solid,
        })
    };
    if link.collision.is_empty() {
        let seen = link.visual.iter();
        return seen
            .map(|part| read(&part.origin, &part.geometry, false))
            .collect();
    }
    let solid = link.collision.iter();
    solid
        .map(|part| read(&part.origin, &part.geometry, true))
        .collect()
}

fn form(geometry: &Geometry, link: &str, files: &dyn Files) -> Result<Form, HandError> {
    Ok(match geometry {
        &Geometry::Sphere { radius } => Form::Sphere { radius },
        &Geometry::Capsule { radius, length } => Form::Capsule { radius, length },
        &Geometry::Cylinder { radius, length } => Form::Cylinder { radius, length },
        Geometry::Box { size } => Form::Cuboid { size: size.0 },
        Geometry::Mesh { filename, scale } => {
            let scale = scale.map_or(Vector3::repeat(1.0), |scale| Vector3::from(scale.0));
            if !scale.iter().all(|x| x.is_finite() && *x != 0.0) {
                return Err(HandError::NotFinite {
                    place: format!("the scale of the mesh of link \"{link}\""),
                });
            }
            let read = files
                .mesh(filename)
                .and_then(|text| triangles(text.as_bytes()));
            let mut mesh = match read {
                Ok(mesh) => mesh,
                Err(problem) => {
                    return Ok(Form::Unread(format!("the mesh {filename}: {problem}")));
                }
            };
            for vertex in &mut mesh.vertices {
                vertex.component_mul_assign(&scale);
            }
            if scale.product() < 0.0 {
                for triangle in &mut mesh.triangles {
                    triangle.swap(1, 2);
                }
            }
            Form::Mesh(Arc::new(mesh))
        }
    })
}
