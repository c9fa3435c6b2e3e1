//! Where a hand starts and to which joint coordinates it closes.

use nalgebra::Vector3;

use super::load_test::{Closing, ClosingRule, LoadTest};
use super::solid::Solid;
use crate::grasp::Grasp;
use crate::grasp::closure::{PointContact, contact_forces};
use crate::hand::{Hand, JointKind, LinkId, Motion, PosedHand};

/// [`ClosingRule::Inwards`]: skin counts up to this distance from the object, metres. The target lies as far inside; there
/// one step down the gradient of the squared distance, at a rate of 500, moves the joints by 2 · 500 · 0.001 Jᵀn = Jᵀn.
const INWARDS_REACH_M: f64 = 0.001;
/// [`ClosingRule::Step`]: skin counts up to this distance from the object, metres.
const STEP_REACH_M: f64 = 0.005;
/// [`ClosingRule::Step`]: how far each joint moves, radians: the rate of the first step of Adam, which depends on the sign of
/// the gradient alone.
const STEP_RAD: f64 = 0.5;
/// [`ClosingRule::Step`]: a smaller |Jᵀn| is zero, metres.
const LEAST_GRADIENT_M: f64 = 1e-9;
/// [`ClosingRule::Closed`]: the least share of the motion of the skin that is along the normals: cos 60°.
const ALONG: f64 = 0.5;
/// Scales the arms to order one; the balance does not depend on it.
const TORQUE_UNIT_M: f64 = 0.05;

/// A hand that closes.
#[derive(Debug)]
pub(super) struct Closed {
    /// The rule that was followed.
    pub(super) rule: ClosingRule,
    /// The hand in the grasp.
    pub(super) posed: PosedHand,
    /// Unit vectors of [`Axes::Palm`](super::Axes::Palm), object frame.
    pub(super) palm_axes: [Vector3<f64>; 3],
    /// Differences of the targets from the coordinates of the grasp, radians or metres.
    pub(super) targets: Vec<f64>,
}

/// The joint coordinates to which the hand of a grasp is driven, radians or metres.
///
/// # Panics
/// If the grasp or `squeeze_joints` are those of another hand.
pub fn joint_targets(
    hand: &Hand,
    grasp: &Grasp,
    squeeze_joints: Option<&[f64]>,
    solid: &Solid,
    test: &LoadTest,
) -> Vec<f64> {
    let closed = closed(hand, grasp, squeeze_joints, solid, test);
    let targets = grasp.pose.joints().iter().zip(closed.targets);
    targets.map(|(q, further)| q + further).collect()
}

/// How the hand of a grasp closes by the rule of a test.
pub(super) fn closed(
    hand: &Hand,
    grasp: &Grasp,
    squeeze_joints: Option<&[f64]>,
    solid: &Solid,
    test: &LoadTest,
) -> Closed {
    let mut posed = PosedHand::default();
    hand.pose(&grasp.pose, &mut posed);
    let start = grasp.pose.joints();
    let mut rule = test.closing.rule;
    let still = || vec![0.0; hand.joints.len()];
    let targets = match (rule, squeeze_joints) {
        (ClosingRule::None, _) => still(),
        (ClosingRule::Given, Some(squeezed)) => {
            assert_eq!(squeezed.len(), hand.joints.len(), "joints of this hand");
            squeezed.iter().zip(start).map(|(to, q)| to - q).collect()
        }
        (ClosingRule::Given | ClosingRule::Squeeze, _) => {
            rule = ClosingRule::Squeeze;
            squeeze(hand, &posed, &grasp.contacts, solid, test)
        }
        (ClosingRule::Inwards, _) => within_limits(hand, start, inwards(hand, &posed, solid)),
        (ClosingRule::Step, _) => within_limits(hand, start, step(hand, &posed, solid)),
        (ClosingRule::Closed, _) => to_closed_limits(hand, &posed, solid, start),
    };
    let palm = hand.palm_at(start);
    let z = posed.object_from_link[0].direction(&palm.volar);
    let x = posed.object_from_link[0].direction(&palm.distal);
    Closed {
        rule,
        posed,
        palm_axes: [x, z.cross(&x), z],
        targets,
    }
}

/// The joints that move a link, from the link to the palm: motion, axis and origin in the object's frame. Those of wrist and
/// forearm come last.
fn moving<'a>(
    hand: &'a Hand,
    posed: &'a PosedHand,
    link: LinkId,
) -> impl Iterator<Item = (LinkId, &'a Motion, Vector3<f64>, Vector3<f64>)> {
    let chain = std::iter::successors(Some(link), |&LinkId(l)| hand.links[l].parent);
    chain.filter_map(|link| {
        let motion = hand.links[link.0].motion.as_ref()?;
        let placed = &posed.object_from_link[link.0];
        Some((
            link,
            motion,
            placed.direction(&motion.axis),
            placed.translation,
        ))
    })
}

/// Adds Jᵀf of a force at a point of a link to the loads of the joints, N·m or N.
fn pull_back(
    hand: &Hand,
    posed: &PosedHand,
    (link, point): (LinkId, Vector3<f64>),
    force: &Vector3<f64>,
    loads: &mut [f64],
) {
    for (_, motion, axis, origin) in moving(hand, posed, link) {
        let load = match motion.kind {
            JointKind::Hinge => axis.dot(&(point - origin).cross(force)),
            JointKind::Slide => axis.dot(force),
        };
        loads[motion.joint] += motion.ratio * load;
    }
}

/// Loads over the stiffness of each joint, which is that of a hinge in N·m/rad: radians, metres of slides.
fn yields(hand: &Hand, loads: &[f64], stiffness_n_m: f64) -> Vec<f64> {
    let stiffness = |kind: JointKind| stiffness_n_m * kind.radians_per_unit().powi(2);
    let loads = loads.iter().zip(&hand.joints);
    loads
        .map(|(load, joint)| load / stiffness(joint.kind))
        .collect()
}

fn squeeze(
    hand: &Hand,
    posed: &PosedHand,
    contacts: &[u32],
    solid: &Solid,
    test: &LoadTest,
) -> Vec<f64> {
    let forces = pressing(posed, contacts, solid, test);
    let mut loads = vec![0.0; hand.joints.len()];
    for (&contact, force) in contacts.iter().zip(forces) {
        let point = posed.points[contact as usize];
        let link = hand.surface[contact as usize].link;
        pull_back(hand, posed, (link, point), &force, &mut loads);
    }
    yields(hand, &loads, test.closing.stiffness_n_m)
}

/// Contact forces that have the given mean and balance each other; equal forces along the normals if none balance.
fn pressing(
    posed: &PosedHand,
    contacts: &[u32],
    solid: &Solid,
    test: &LoadTest,
) -> Vec<Vector3<f64>> {
    let force_n = test.closing.force_n.unwrap_or(Closing::USUAL_FORCE_N);
    let centre = solid.centre();
    let bare: Vec<PointContact> = contacts
        .iter()
        .map(|&contact| {
            let point = posed.points[contact as usize];
            PointContact {
                arm: (point - centre) / TORQUE_UNIT_M,
                inward_normal: solid.inward_normal(&point),
            }
        })
        .collect();
    let sum_n = force_n * bare.len() as f64;
    match contact_forces(&bare, test.friction) {
        Some(balanced) => balanced.forces.iter().map(|force| force * sum_n).collect(),
        None => bare
            .iter()
            .map(|contact| contact.inward_normal * force_n)
            .collect(),
    }
}

/// The skin point of each link nearest to the object or deepest in it, with its signed distance, metres.
fn nearest_skin(hand: &Hand, posed: &PosedHand, solid: &Solid) -> Vec<(usize, f64)> {
    let mut nearest: Vec<Option<(usize, f64)>> = vec![None; hand.links.len()];
    for (number, point) in posed.points.iter().enumerate() {
        let distance_m = solid.distance_m(point);
        let of_link = &mut nearest[hand.surface[number].link.0];
        if of_link.is_none_or(|(_, least)| distance_m < least) {
            *of_link = Some((number, distance_m));
        }
    }
    nearest.into_iter().flatten().collect()
}

/// Jᵀn of [`ClosingRule::Inwards`], radians, metres of slides.
fn inwards(hand: &Hand, posed: &PosedHand, solid: &Solid) -> Vec<f64> {
    let mut loads = vec![0.0; hand.joints.len()];
    for (number, distance_m) in nearest_skin(hand, posed, solid) {
        if distance_m < INWARDS_REACH_M {
            let point = posed.points[number];
            let normal = solid.inward_normal(&point);
            let link = hand.surface[number].link;
            pull_back(hand, posed, (link, point), &normal, &mut loads);
        }
    }
    yields(hand, &loads, 1.0)
}

/// Half a radian for every joint of [`ClosingRule::Step`] that has a direction.
fn step(hand: &Hand, posed: &PosedHand, solid: &Solid) -> Vec<f64> {
    let mut loads = vec![0.0; hand.joints.len()];
    for (number, point) in posed.points.iter().enumerate() {
        if solid.distance_m(point).abs() < STEP_REACH_M {
            let normal = hand.point_normal(posed, number);
            let link = hand.surface[number].link;
            pull_back(hand, posed, (link, *point), &normal, &mut loads);
        }
    }
    let joints = hand.joints.iter().zip(loads);
    joints
        .map(|(joint, load)| {
            if load.abs() < LEAST_GRADIENT_M || hand.is_arm(joint.link) {
                0.0
            } else {
                STEP_RAD.copysign(load) / joint.kind.radians_per_unit()
            }
        })
        .collect()
}

/// The ways to the limits of [`ClosingRule::Closed`].
fn to_closed_limits(hand: &Hand, posed: &PosedHand, solid: &Solid, start: &[f64]) -> Vec<f64> {
    let mut along = vec![0.0; hand.joints.len()];
    let mut whole = vec![0.0; hand.joints.len()];
    for (number, _) in nearest_skin(hand, posed, solid) {
        let point = posed.points[number];
        let normal = solid.inward_normal(&point);
        for (_, motion, axis, origin) in moving(hand, posed, hand.surface[number].link) {
            let way = match motion.kind {
                JointKind::Hinge => axis.cross(&(point - origin)),
                JointKind::Slide => axis,
            };
            along[motion.joint] += motion.ratio * way.dot(&normal);
            whole[motion.joint] += motion.ratio.abs() * way.norm();
        }
    }
    let joints = hand.joints.iter().enumerate();
    joints
        .map(|(j, joint)| {
            let sideways = along[j].abs() < ALONG * whole[j] || whole[j] == 0.0;
            if sideways || joint.wraps || hand.is_arm(joint.link) {
                0.0
            } else {
                let limit = joint.limits[usize::from(along[j] > 0.0)];
                limit - start[j]
            }
        })
        .collect()
}

/// Changes of coordinates, cut where they leave the limits of the joints. A coordinate beyond a limit does not go farther.
fn within_limits(hand: &Hand, start: &[f64], mut further: Vec<f64>) -> Vec<f64> {
    for ((joint, q), further) in hand.joints.iter().zip(start).zip(&mut further) {
        if !joint.wraps {
            let [lower, upper] = joint.limits;
            *further = further.clamp((lower - q).min(0.0), (upper - q).max(0.0));
        }
    }
    further
}
