//! Virtual wrists: joints in front of a hand that stand for its pose.
//!
//! Descriptions made for simulators often move the whole hand by joints: three slides, then three hinges, with links without
//! geometry between them. The pose of a grasp already says where the hand is, so these joints are removed.

use nalgebra::{Matrix6, Quaternion, Rotation3, UnitQuaternion, Vector3, Vector6};

use super::kinematics::moved;
use super::model::{Body, Model, ModelJoint};
use super::{Frame, JointKind};
use crate::space::Pose;

/// Least ranges of the joints of a virtual wrist: a slide of 10 cm, a hinge of nearly half a turn. Real wrists turn less.
const WIDE_M: f64 = 0.1;
const WIDE_RAD: f64 = 3.0;
/// Fewest joints of a virtual wrist. A forearm without geometry may turn by half a turn.
const FEWEST: usize = 3;
/// The hand is taken as undisplaced from the root of its description if its frame differs by less, metres and radians.
const DISPLACED: f64 = 1e-9;

/// The joints of a virtual wrist, from the root to the hand.
#[derive(Debug, Clone, PartialEq)]
pub struct VirtualWrist {
    /// The joints.
    joints: Vec<WristJoint>,
    /// Frame of the link that the last joint moves, with all joints at displacement zero, in the hand's root frame.
    root_from_last: Frame,
}

/// One of its joints.
#[derive(Debug, Clone, PartialEq)]
struct WristJoint {
    /// Frame of its link in that of the joint before, at displacement zero.
    in_parent: Frame,
    joint: ModelJoint,
}

/// How exactly coordinates give a pose, metres and radians.
const EXACT: f64 = 1e-9;
const STEPS: usize = 60;

impl VirtualWrist {
    /// Names of the joints in the description.
    pub fn joint_names(&self) -> impl Iterator<Item = &str> {
        self.joints.iter().map(|of| of.joint.name.as_str())
    }

    /// Coordinates of the joints (radians, metres) that put the hand at a pose; `None` if they cannot within their limits.
    pub fn coordinates(&self, pose: &Pose) -> Option<Vec<f64>> {
        let [w, i, j, k] = pose.rotation_wxyz();
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        let target = Frame {
            rotation: *turn.to_rotation_matrix().matrix(),
            translation: Vector3::from_column_slice(pose.translation_m()),
        };
        let target = target.compose(&self.root_from_last);
        if self.joints.len() > 6 {
            return None;
        }
        // Angles far from the solution can lead to a place where no step is better.
        let mut starts = (0..27).map(|start| {
            let mut digits = start;
            let displacement = |of: &WristJoint| {
                if of.joint.kind == JointKind::Slide {
                    return 0.0;
                }
                let angle = [0.0, 1.0, -1.0][digits % 3];
                digits /= 3;
                angle
            };
            self.joints.iter().map(displacement).collect::<Vec<f64>>()
        });
        starts.find_map(|start| self.solved(start, &target))
    }

    /// Newton's method with damping from some displacements.
    fn solved(&self, mut at: Vec<f64>, target: &Frame) -> Option<Vec<f64>> {
        const DIFFERENCE: f64 = 1e-6;
        let mut off = self.off(&at, target);
        let mut damping = 1e-6;
        for _ in 0..STEPS {
            if off.amax() < 1e-3 * EXACT {
                break;
            }
            let mut jacobian = Matrix6::zeros();
            for k in 0..at.len().min(6) {
                let mut ahead = at.clone();
                ahead[k] += DIFFERENCE;
                jacobian.set_column(k, &((self.off(&ahead, target) - off) / DIFFERENCE));
            }
            let normal = jacobian.tr_mul(&jacobian) + Matrix6::identity() * damping;
            let step = normal.cholesky()?.solve(&jacobian.tr_mul(&off));
            let tried: Vec<f64> = at.iter().zip(&step).map(|(q, step)| q - step).collect();
            let there = self.off(&tried, target);
            if there.norm_squared() < off.norm_squared() {
                (at, off, damping) = (tried, there, damping / 10.0);
            } else {
                damping = 10.0 * damping.max(1e-12);
            }
        }
        let whole = std::f64::consts::TAU;
        let coordinate = |(of, displacement): (&WristJoint, f64)| {
            let q = displacement + of.joint.zero;
            let Some([low, high]) = of.joint.limits else {
                return Some(q);
            };
            let turns = match of.joint.kind {
                JointKind::Hinge => ((q - f64::midpoint(low, high)) / whole).round(),
                JointKind::Slide => 0.0,
            };
            let q = q - turns * whole;
            (low - EXACT..=high + EXACT).contains(&q).then_some(q)
        };
        let coordinates = self.joints.iter().zip(at).map(coordinate).collect();
        if off.amax() < EXACT {
            coordinates
        } else {
            None
        }
    }

    /// Translation and rotation vector from the target to the hand.
    fn off(&self, displacements: &[f64], target: &Frame) -> Vector6<f64> {
        let mut frame = Frame::default();
        for (of, displacement) in self.joints.iter().zip(displacements) {
            frame = frame.compose(&of.in_parent);
            moved(&mut frame, of.joint.kind, &of.joint.axis, *displacement);
        }
        let turn = Rotation3::from_matrix_unchecked(target.rotation.tr_mul(&frame.rotation));
        let shift = frame.translation - target.translation;
        // The angle of a matrix has half the digits near zero, that of a quaternion has all.
        let turn = UnitQuaternion::from_rotation_matrix(&turn).scaled_axis();
        Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
    }
}

impl Model {
    /// Removes a virtual wrist and notes its joints. The hand stays where it is with these joints at displacement zero.
    ///
    /// A virtual wrist is the longest chain of joints from the root in which each joint is wide, moves all the geometry of the
    /// hand, and is coupled with no other. The first link with geometry or branches behind it becomes the root; if it is displaced from the
    /// root of the description, that root is kept and carries it.
    pub(super) fn fold_virtual_wrist(&mut self) {
        // Marks for drawing on these links are no geometry.
        let solid = |body: &Body| body.parts.iter().any(|part| part.solid);
        let any_solid = self.bodies.iter().any(solid);
        let (mut last, mut wrist) = (0, Vec::new());
        for (b, body) in self.bodies.iter().enumerate() {
            // Depth first: in a chain each link is followed by its only child.
            if b > 0 && body.parent != Some(b - 1) {
                break;
            }
            if let Some(j) = body.joint {
                if !self.is_wide(&self.joints[j]) {
                    break;
                }
                wrist.push(j);
            }
            last = b;
            let children = self.bodies.iter().filter(|child| child.parent == Some(b));
            let shaped = if any_solid {
                solid(body)
            } else {
                !body.parts.is_empty()
            };
            if shaped || children.count() != 1 {
                break;
            }
        }
        if wrist.len() < FEWEST || wrist.len() == self.joints.len() {
            return;
        }
        let names: Vec<&str> = wrist
            .iter()
            .map(|&j| self.joints[j].name.as_str())
            .collect();
        self.notes.push(format!(
            "the joints {} move the whole hand, so they are taken as a virtual wrist and not as joints of the hand. The pose \
             of a grasp, which is that of link \"{}\" with these joints at zero, replaces them; only `export qpos` writes them",
            names.join(", "),
            self.bodies[if self.is_displaced(last) { 0 } else { last }].name
        ));
        self.virtual_wrist = Some(self.wrist_to(last));
        self.remove_wrist(&wrist, last);
    }

    /// The joints in front of and at link `last` of the chain from the root.
    fn wrist_to(&self, last: usize) -> VirtualWrist {
        let mut joints = Vec::new();
        let (mut in_parent, mut root_from_last) = (Frame::default(), Frame::default());
        for (body, at_zero) in self.bodies[..=last].iter().zip(self.frames_at_zero()) {
            in_parent = in_parent.compose(&body.in_parent);
            if let Some(j) = body.joint {
                joints.push(WristJoint {
                    in_parent: std::mem::take(&mut in_parent),
                    joint: self.joints[j].clone(),
                });
                root_from_last = at_zero;
            }
        }
        VirtualWrist {
            joints,
            root_from_last,
        }
    }

    /// Whether a joint has the range of one that places a hand, and no other joint follows it or is followed by it.
    fn is_wide(&self, joint: &ModelJoint) -> bool {
        let least = match joint.kind {
            JointKind::Hinge => WIDE_RAD,
            JointKind::Slide => WIDE_M,
        };
        let follows = |other: &ModelJoint| {
            let leader = other.follows.as_ref().map(|coupling| &coupling.joint);
            leader == Some(&joint.name)
        };
        let wide = joint.limits.is_none_or(|[low, high]| high - low >= least);
        wide && joint.follows.is_none() && !self.joints.iter().any(follows)
    }

    fn is_displaced(&self, last: usize) -> bool {
        let (frame, none) = (self.frames_at_zero()[last], Frame::default());
        let turn = (frame.rotation - none.rotation).amax();
        turn.max(frame.translation.amax()) > DISPLACED
    }

    /// Removes the joints `wrist` and the links in front of link `last`, which they move.
    fn remove_wrist(&mut self, wrist: &[usize], last: usize) {
        let frame = self.frames_at_zero()[last];
        let displaced = self.is_displaced(last);
        let kept = usize::from(displaced);
        self.bodies.drain(kept..last);
        if displaced {
            self.bodies[0].in_parent = Frame::default();
        }
        self.bodies[kept].parent = displaced.then_some(0);
        self.bodies[kept].in_parent = if displaced { frame } else { Frame::default() };
        for body in &mut self.bodies[kept + 1..] {
            body.parent = body.parent.map(|parent| parent + kept - last);
        }
        // These joints are the first in the tree, but not always in the file.
        let left = |j: &usize| !wrist.contains(j);
        let before = |j: usize| wrist.iter().filter(|&&of_wrist| of_wrist < j).count();
        for body in &mut self.bodies {
            body.joint = body.joint.filter(left).map(|j| j - before(j));
        }
        let mut number = 0;
        self.joints.retain(|_| {
            number += 1;
            left(&(number - 1))
        });
    }
}
