//! The palmar side of each link.

use nalgebra::Vector3;

use super::{Capsule, Hand, JointKind, LinkId, PosedHand};
use crate::space::Pose;

/// Least displacement that tells the direction in which a link closes, metres.
const LEAST_M: f64 = 0.001;

/// The unit vector out of the palmar side of each link, link frame: for links of the palm the side that faces objects, for
/// those of a digit the direction in which they close. `None` for arms and links that hardly move.
pub(crate) fn volar_directions(hand: &Hand) -> Vec<Option<Vector3<f64>>> {
    let straight = hand.straight();
    let mut rest = PosedHand::default();
    hand.pose_links(&hand.rest_coordinates(), &mut rest);
    let palm = hand.palm_at(&hand.prior.rest);
    let mut directions: Vec<Option<Vector3<f64>>> = Vec::with_capacity(hand.links.len());
    for (l, link) in hand.links.iter().enumerate() {
        let direction = if hand.is_arm(LinkId(l)) {
            None
        } else if link.digit == 0 {
            Some(rest.object_from_link[l].rotation.tr_mul(&palm.volar))
        } else {
            closing(hand, l)
        };
        directions.push(direction);
    }
    // A link that only turns the digit about its axis closes like the next one.
    for l in (0..hand.links.len()).rev() {
        if directions[l].is_none() && hand.links[l].digit > 0 {
            let child = (l + 1..hand.links.len())
                .find(|&c| hand.links[c].parent == Some(LinkId(l)) && directions[c].is_some());
            directions[l] = child.and_then(|c| {
                let [link, next] = [l, c].map(|k| straight.object_from_link[k].rotation);
                directions[c].map(|d| link.tr_mul(&(next * d)))
            });
        }
    }
    directions
}

/// The displacement of a link's middle as its own joint closes, across the link's own axis.
fn closing(hand: &Hand, link: usize) -> Option<Vector3<f64>> {
    let capsules = || hand.capsules.iter().filter(move |c| c.link.0 == link);
    let count = capsules().count();
    let middle = capsules().map(|c| (c.a + c.b) * 0.5).sum::<Vector3<f64>>() / count.max(1) as f64;
    let longest = capsules().max_by(|a, b| {
        let length = |c: &Capsule| (c.b - c.a).norm_squared();
        length(a).total_cmp(&length(b))
    })?;
    let axis = (longest.b - longest.a)
        .try_normalize(1e-6)
        .filter(|_| (longest.b - longest.a).norm() > longest.radius_m);
    let motion = hand.links[link].motion?;
    let mut joints = hand.straight_joints();
    let pose = |joints: &[f64]| {
        let mut posed = PosedHand::default();
        hand.pose_links(&Pose::at_origin(joints), &mut posed);
        posed.object_from_link[link]
    };
    let straight = pose(&joints);
    let [lower, upper] = hand.joints[motion.joint].limits;
    joints[motion.joint] = match motion.kind {
        JointKind::Hinge => f64::midpoint(lower, upper),
        JointKind::Slide => lower,
    };
    let moved = pose(&joints).point(&middle) - straight.point(&middle);
    let moved = straight.rotation.tr_mul(&moved);
    let across = axis.map_or(moved, |axis| moved - axis * axis.dot(&moved));
    (across.norm() > LEAST_M).then(|| across.normalize())
}
