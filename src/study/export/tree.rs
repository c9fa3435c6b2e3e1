//! The links of a hand with joints whose coordinates are those of the description.

use nalgebra::{Rotation3, Unit, Vector3};

use crate::hand::{Frame, Hand, JointKind, Link, LinkId, Motion};

/// A link and how it is attached to its parent.
#[derive(Debug, Clone)]
pub(super) struct Attached<'a> {
    pub(super) id: LinkId,
    pub(super) link: &'a Link,
    /// Its frame in that of its parent while the joint's own coordinate is zero.
    pub(super) origin: Frame,
    /// `None` if it does not move.
    pub(super) joint: Option<Moving>,
}

/// A joint of one axis.
#[derive(Debug, Clone)]
pub(super) struct Moving {
    pub(super) kind: JointKind,
    /// Unit axis through the origin of the link's frame, in that frame.
    pub(super) axis: Vector3<f64>,
    /// Limits of its own coordinate, radians or metres; `None` if it turns without end.
    pub(super) limits: Option<[f64; 2]>,
    /// Index of the hand's joint that it is or follows.
    pub(super) leader: usize,
    /// Its own coordinate is `ratio · q + offset` with q the coordinate of the leader; `None` if it is the leader.
    pub(super) follows: Option<[f64; 2]>,
}

/// All links, parents before children.
pub(super) fn attached(hand: &Hand) -> Vec<Attached<'_>> {
    let links = hand.links.iter().enumerate();
    links
        .map(|(place, link)| {
            let (origin, joint) = match &link.motion {
                None => (link.parent_from_link, None),
                Some(motion) => of_motion(hand, LinkId(place), link, motion),
            };
            Attached {
                id: LinkId(place),
                link,
                origin,
                joint,
            }
        })
        .collect()
}

fn of_motion(hand: &Hand, id: LinkId, link: &Link, motion: &Motion) -> (Frame, Option<Moving>) {
    let leader = &hand.joints[motion.joint];
    // A joint's coordinate may be zero where it is displaced (`ref` of MJCF).
    let displaced = || {
        link.parent_from_link
            .compose(&displacement(motion, motion.offset))
    };
    let moving = |limits, follows| Moving {
        kind: motion.kind,
        axis: motion.axis,
        limits,
        leader: motion.joint,
        follows,
    };
    let limits = (!leader.wraps).then_some(leader.limits);
    if leader.link == id {
        return (displaced(), Some(moving(limits, None)));
    }
    if motion.ratio == 0.0 {
        return (displaced(), None);
    }
    let own = limits.map(|limits| {
        let [a, b] = limits.map(|limit| motion.ratio * limit + motion.offset);
        [a.min(b), a.max(b)]
    });
    let follows = Some([motion.ratio, motion.offset]);
    (link.parent_from_link, Some(moving(own, follows)))
}

/// The motion of a link by `way`, radians or metres, in its own frame.
fn displacement(motion: &Motion, way: f64) -> Frame {
    match motion.kind {
        JointKind::Hinge => Frame {
            rotation: *Rotation3::from_axis_angle(&Unit::new_normalize(motion.axis), way).matrix(),
            ..Frame::default()
        },
        JointKind::Slide => Frame {
            translation: motion.axis * way,
            ..Frame::default()
        },
    }
}

/// Names for the links, all different and none of `taken`: a model of `MuJoCo` has a body called `world` already.
pub(super) fn names(hand: &Hand, taken: &[&str]) -> Vec<String> {
    let own = |name: &str| hand.links.iter().any(|link| link.name == name);
    let links = hand.links.iter();
    links
        .map(|link| {
            let mut name = link.name.clone();
            while taken.contains(&name.as_str()) || (name != link.name && own(&name)) {
                name.push('_');
            }
            name
        })
        .collect()
}
