//! The content of a description in any format: a tree of bodies, their joints and their parts.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::loops::Loop;
use super::virtual_wrist::VirtualWrist;
use super::{Frame, HandError, Joint, JointKind, Link, LinkId, Motion};
use crate::formats::Triangles;
use crate::limits::{COUPLING_RATIO, HAND_POSITION, HINGE, Limit, SLIDE};

/// Largest number of links or joints; each is compared with all others.
const MOST_LINKS: usize = 1000;

/// Refuses a description that is far too large for a hand, before it costs minutes.
pub(super) fn check_count(
    kind: &'static str,
    count: usize,
    most: usize,
    advice: &'static str,
) -> Result<(), HandError> {
    if count <= most {
        return Ok(());
    }
    Err(HandError::TooMany {
        kind,
        count,
        most,
        advice,
    })
}

/// Refuses a number beyond its limit; `place` says which number it is.
pub(super) fn within(
    limit: Limit,
    value: f64,
    place: impl FnOnce() -> String,
) -> Result<(), HandError> {
    limit.check(value).map_err(|beyond| HandError::Beyond {
        place: place(),
        beyond,
    })
}

/// Limit of the coordinates of a joint.
pub(super) fn coordinates_of(kind: JointKind) -> Limit {
    match kind {
        JointKind::Hinge => HINGE,
        JointKind::Slide => SLIDE,
    }
}

/// Refuses a tree that is far too large for a hand.
pub(super) fn check_tree(links: usize, joints: usize) -> Result<(), HandError> {
    let advice = "describe the hand alone, without what it is mounted on";
    check_count("links", links, MOST_LINKS, advice)?;
    check_count("joints", joints, MOST_LINKS, advice)
}

/// A description that has been read but is not yet a hand.
#[derive(Debug, Clone, Default)]
pub(super) struct Model {
    pub(super) name: String,
    /// Depth first: parents before children, each subtree contiguous. The first is the root.
    pub(super) bodies: Vec<Body>,
    /// All movable joints, in the order of the file.
    pub(super) joints: Vec<ModelJoint>,
    /// Pairs of bodies that the file says never collide.
    pub(super) apart: Vec<[String; 2]>,
    /// Closed loops: links that the tree does not connect, but the file does.
    pub(super) loops: Vec<Loop>,
    /// The joints in front of the hand that were removed, see [`Model::fold_virtual_wrist`].
    pub(super) virtual_wrist: Option<VirtualWrist>,
    /// Name and place in the file of each slide of MJCF without limits.
    pub(super) endless_slides: Vec<[String; 2]>,
    /// What was left out or changed, one sentence each.
    pub(super) notes: Vec<String>,
}

/// A rigid body.
#[derive(Debug, Clone, Default)]
pub(super) struct Body {
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    /// Frame in the parent at joint displacement zero.
    pub(super) in_parent: Frame,
    /// Index of the joint that moves it.
    pub(super) joint: Option<usize>,
    pub(super) parts: Vec<Part>,
}

/// A joint, either independent or coupled to another one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ModelJoint {
    pub(super) name: String,
    pub(super) kind: JointKind,
    /// Unit vector in the frame of the body it moves; the axis passes through that frame's origin.
    pub(super) axis: Vector3<f64>,
    /// Radians or metres; `None` if it turns without limits.
    pub(super) limits: Option<[f64; 2]>,
    /// The coordinate at which the displacement is zero.
    pub(super) zero: f64,
    /// The joint that it follows: own coordinate = ratio · other + offset.
    pub(super) follows: Option<Coupling>,
}

/// A linear coupling of one joint to another.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coupling {
    pub(super) joint: String,
    pub(super) ratio: f64,
    pub(super) offset: f64,
}

/// A piece of geometry.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub(super) in_body: Frame,
    pub(super) form: Form,
    /// Whether it is collision geometry rather than only visual geometry.
    pub(super) solid: bool,
}

/// A shape in the frame of the part. Lengths in metres; long axes along z.
#[derive(Debug, Clone)]
pub(super) enum Form {
    Sphere {
        radius: f64,
    },
    Capsule {
        radius: f64,
        length: f64,
    },
    Cylinder {
        radius: f64,
        length: f64,
    },
    Cuboid {
        size: [f64; 3],
    },
    Ellipsoid {
        radii: [f64; 3],
    },
    Mesh(Arc<Triangles>),
    /// A mesh that could not be read, and why.
    Unread(String),
}

/// The independent joint at the end of a chain of couplings, with the total ratio and offset.
struct Drive {
    leader: usize,
    ratio: f64,
    offset: f64,
}

impl Model {
    /// Links and coordinates. A joint that follows another one has no coordinate of its own.
    pub(super) fn tree(&self) -> Result<(Vec<Link>, Vec<Joint>), HandError> {
        check_tree(self.bodies.len(), self.joints.len())?;
        for (i, joint) in self.joints.iter().enumerate() {
            if self.joints[..i]
                .iter()
                .any(|other| other.name == joint.name)
            {
                return Err(HandError::Twice {
                    kind: "joint",
                    name: joint.name.clone(),
                });
            }
        }
        for (i, body) in self.bodies.iter().enumerate() {
            if self.bodies[..i].iter().any(|other| other.name == body.name) {
                return Err(HandError::Twice {
                    kind: "link",
                    name: body.name.clone(),
                });
            }
        }
        let drives: Vec<Drive> = (0..self.joints.len())
            .map(|j| self.drive(j))
            .collect::<Result<_, _>>()?;
        for (joint, drive) in self.joints.iter().zip(&drives) {
            let place = || format!("the coupling of joint \"{}\"", joint.name);
            within(COUPLING_RATIO, drive.ratio, place)?;
            within(coordinates_of(joint.kind), drive.offset, place)?;
        }
        let mut coordinate = vec![None; self.joints.len()];
        let mut joints = Vec::new();
        for (j, joint) in self.joints.iter().enumerate() {
            if joint.follows.is_none() {
                coordinate[j] = Some(joints.len());
                joints.push(self.coordinate(j, &drives)?);
            }
        }
        if joints.is_empty() {
            return Err(HandError::NoJoints);
        }
        let links = (self.bodies.iter().enumerate())
            .map(|(b, body)| {
                let motion = body.joint.and_then(|j| {
                    let (own, drive) = (&self.joints[j], &drives[j]);
                    let joint = coordinate[drive.leader]?;
                    if own.follows.is_none() {
                        joints[joint].link = LinkId(b);
                    }
                    Some(Motion {
                        joint,
                        kind: own.kind,
                        axis: own.axis,
                        ratio: drive.ratio,
                        offset: drive.offset - own.zero,
                    })
                });
                Link {
                    name: body.name.clone(),
                    parent: body.parent.map(LinkId),
                    parent_from_link: body.in_parent,
                    joint_name: body
                        .joint
                        .filter(|_| motion.is_some())
                        .map_or(String::new(), |j| self.joints[j].name.clone()),
                    motion,
                    ball: None,
                    digit: 0,
                }
            })
            .collect();
        Ok((links, joints))
    }

    /// Refuses numbers beyond the limits, whatever the format, since later steps multiply and square them.
    pub(super) fn check_limits(&self) -> Result<(), HandError> {
        for joint in &self.joints {
            let place = |what: &str| format!("the {what} of joint \"{}\"", joint.name);
            let coordinates = coordinates_of(joint.kind);
            for limit in joint.limits.into_iter().flatten() {
                within(coordinates, limit, || place("limits"))?;
            }
            within(coordinates, joint.zero, || place("reference"))?;
            // For a far larger axis the square is infinite, and the normalised axis is zero.
            if (joint.axis.norm() - 1.0).abs() > 1e-6 || joint.axis.iter().any(|x| x.is_nan()) {
                return Err(HandError::NoAxis {
                    joint: joint.name.clone(),
                });
            }
        }
        for body in &self.bodies {
            let frames =
                std::iter::once(&body.in_parent).chain(body.parts.iter().map(|p| &p.in_body));
            for frame in frames {
                for &coordinate in &frame.translation {
                    let place = || format!("a position in link \"{}\"", body.name);
                    within(HAND_POSITION, coordinate, place)?;
                }
                let turn = &frame.rotation;
                let off = (turn * turn.transpose() - Matrix3::identity()).norm();
                if off > 1e-6 || off.is_nan() {
                    return Err(HandError::NoRotation {
                        link: body.name.clone(),
                    });
                }
            }
            for part in &body.parts {
                if let Form::Mesh(mesh) = &part.form {
                    for &coordinate in mesh.vertices.iter().flatten() {
                        let place = || format!("a vertex of a mesh of link \"{}\"", body.name);
                        within(HAND_POSITION, coordinate, place)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Removes links and all links below them.
    pub(super) fn remove(&mut self, names: &[String]) -> Result<(), HandError> {
        if names.is_empty() {
            return Ok(());
        }
        for name in names {
            if self.bodies.iter().all(|body| &body.name != name) {
                return Err(HandError::Unknown {
                    place: "\"without\" of the side file".to_owned(),
                    kind: "link",
                    name: name.clone(),
                });
            }
        }
        let mut place = vec![None; self.bodies.len()];
        let mut joint_place = vec![None; self.joints.len()];
        let (mut bodies, mut kept) = (Vec::new(), vec![false; self.joints.len()]);
        for (b, body) in self.bodies.iter().enumerate() {
            let parent = body.parent.map(|parent| place[parent]);
            if names.contains(&body.name) || parent == Some(None) {
                continue;
            }
            place[b] = Some(bodies.len());
            if let Some(j) = body.joint {
                kept[j] = true;
            }
            bodies.push(Body {
                parent: parent.flatten(),
                ..body.clone()
            });
        }
        let mut joints = Vec::new();
        for (j, joint) in self.joints.iter().enumerate().filter(|(j, _)| kept[*j]) {
            joint_place[j] = Some(joints.len());
            joints.push(joint.clone());
        }
        for body in &mut bodies {
            body.joint = body.joint.and_then(|j| joint_place[j]);
        }
        (self.bodies, self.joints) = (bodies, joints);
        if self.bodies.is_empty() {
            return Err(HandError::NoGeometry);
        }
        Ok(())
    }

    /// Frames of all bodies with all joints at displacement zero, in the frame of the description.
    pub(super) fn frames_at_zero(&self) -> Vec<Frame> {
        let mut frames: Vec<Frame> = Vec::with_capacity(self.bodies.len());
        for body in &self.bodies {
            let parent = body.parent.map(|parent| frames[parent]);
            frames.push(parent.map_or(body.in_parent, |parent| parent.compose(&body.in_parent)));
        }
        frames
    }

    /// The coordinate at which the displacement of a joint is zero.
    pub(super) fn zero_of(&self, joint: &str) -> f64 {
        self.position(joint).map_or(0.0, |j| self.joints[j].zero)
    }

    fn position(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Follows the couplings of a joint to an independent joint.
    fn drive(&self, start: usize) -> Result<Drive, HandError> {
        let mut drive = Drive {
            leader: start,
            ratio: 1.0,
            offset: 0.0,
        };
        for _ in 0..=self.joints.len() {
            let joint = &self.joints[drive.leader];
            let Some(coupling) = &joint.follows else {
                return Ok(drive);
            };
            drive.offset += drive.ratio * coupling.offset;
            drive.ratio *= coupling.ratio;
            drive.leader = self
                .position(&coupling.joint)
                .ok_or_else(|| HandError::Unknown {
                    place: format!("joint \"{}\"", joint.name),
                    kind: "joint",
                    name: coupling.joint.clone(),
                })?;
        }
        Err(HandError::Circle {
            joint: self.joints[start].name.clone(),
        })
    }

    /// Joint `j` as a coordinate, within the limits of all joints that follow it if these leave a range.
    fn coordinate(&self, j: usize, drives: &[Drive]) -> Result<Joint, HandError> {
        let joint = &self.joints[j];
        let wraps = joint.limits.is_none();
        if wraps && joint.kind == JointKind::Slide {
            let mut places = self.endless_slides.iter();
            if let Some([_, place]) = places.find(|[name, _]| *name == joint.name) {
                return Err(HandError::Element {
                    place: place.clone(),
                    problem: "a slide needs limits, but range is missing".to_owned(),
                });
            }
            return Err(HandError::Endless {
                joint: joint.name.clone(),
            });
        }
        let [mut lower, mut upper] = joint
            .limits
            .unwrap_or([-std::f64::consts::PI, std::f64::consts::PI]);
        if !(lower.is_finite() && upper.is_finite() && lower < upper) {
            return Err(HandError::EmptyRange {
                joint: joint.name.clone(),
                lower,
                upper,
            });
        }
        for (follower, drive) in self.joints.iter().zip(drives) {
            let (Some(_), Some(limits)) = (&follower.follows, follower.limits) else {
                continue;
            };
            if drive.leader != j || drive.ratio == 0.0 || wraps {
                continue;
            }
            let ends = limits.map(|limit| (limit - drive.offset) / drive.ratio);
            let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            if lower.max(low) < upper.min(high) {
                (lower, upper) = (lower.max(low), upper.min(high));
            }
        }
        Ok(Joint {
            name: joint.name.clone(),
            link: LinkId(0),
            kind: joint.kind,
            limits: [lower, upper],
            wraps,
        })
    }
}

/// For depth-first links: one past the last link of each subtree.
pub(super) fn subtree_ends(links: &[Link]) -> Vec<usize> {
    let mut ends: Vec<usize> = (1..=links.len()).collect();
    for l in (1..links.len()).rev() {
        if let Some(parent) = links[l].parent {
            ends[parent.0] = ends[parent.0].max(ends[l]);
        }
    }
    ends
}
