//! The elastic layer on the palmar side of a hand: spheres along the axes of its capsules, and spheres that fill its meshes.
//!
//! A sphere is nearest to an object at the right place of its capsule for every rotation about the axis, so the energy
//! does not jump from one surface point to the next. Meshes, boxes and cylinders are filled with balls up to their surface
//! ([`Hand::balls`]); the capsules that fill their hulls are no part of the layer. [`Layer`] holds the spheres of a hand; a [`NeighbourList`] finds those
//! near an object. [`mean_compliance`] tells how much the layer gives under loads on the object.
//!
//! The layer is an elastic foundation, which Winkler proposed: springs side by side that do not feel each other (Johnson,
//! *Contact Mechanics*, Cambridge University Press 1985, section 4.3). Unlike the foundation there, ours has no pressure of
//! its own: a gap or a depth only says how much of it carries, and the loads on the object are the only forces. That its
//! springs stand on spheres, carry smoothly within a few millimetres and are averaged over nodes is ours.

mod compliance;
mod cone;
mod factors;
mod neighbours;
mod settings;

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

pub use compliance::{
    Compliance, ComplianceSettings, LoadCompliance, Node, load_compliance, mean_compliance,
};
pub use neighbours::NeighbourList;
pub use settings::LayerSettings;
pub(crate) use settings::step;

use crate::grasp::grip::{Parts, Side};
use crate::hand::{Ball, Capsule, Hand, LinkId, PosedHand, volar_directions};
use crate::object::Shape;

/// Distance between neighbouring spheres of a capsule, metres.
const SPACING_M: f64 = 0.003;
/// Spheres that are excluded together if their common ball is far from the object.
const GROUP: usize = 6;
/// Greatest number of spheres in a group of a mesh.
const LEAF: usize = 4;
/// Distance between the points of a phalanx that are drawn to the object, metres.
const REACH_SPACING_M: f64 = 0.01;
/// Least cosine between a direction and the normal of a surface point that faces it.
const FACING: f64 = 0.7;
/// Greatest number of nodes of a ball in a mesh.
const MOST_NODES: usize = 3;
/// Least share with which a ball of a mesh is pressed: somewhat more than that of the spheres of a finger that touch a ball.
const LEAST_PRESSED: f64 = 2.5;
/// The area whose share is 1: 5 mm of a finger of 8 mm radius, m².
const UNIT_AREA_M2: f64 = 0.005 * 0.008;

/// A sphere of the layer, link frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Sphere {
    /// The link it is fixed to.
    pub link: LinkId,
    /// Centre, metres.
    pub centre: Vector3<f64>,
    /// Radius, metres.
    pub radius_m: f64,
    /// Its share of the area: the area of the capsule's section along its part of the axis, divided by that of 5 mm of a
    /// finger. A capsule's section is half as wide as its shadow, so a ball in a mesh counts with half the shadow of its part
    /// of the surface.
    pub share: f64,
    /// Its share when it is pressed into the object: as `share`, but for a ball in a mesh at least 2.5, so that edges, which
    /// are small areas, do not sink in.
    pub pressed_share: f64,
    /// Unit vector out of the palmar side of the link; zero if all sides count.
    pub volar: Vector3<f64>,
    /// Whether it may carry a contact.
    pub may_touch: bool,
    /// Whether it is a ball in a mesh rather than a piece of a capsule.
    pub fills_mesh: bool,
    /// Whether it rests and is kept off the object by [`Layer::clearance_m`].
    pub rests: bool,
    /// Its nodes and the fraction of the sphere that belongs to each; the fractions sum to 1.
    pub nodes: Vec<(u32, f64)>,
}

/// Points of a phalanx on its palmar surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Phalanx {
    /// The link.
    pub link: LinkId,
    /// Points, link frame, metres.
    pub points: Vec<Vector3<f64>>,
}

/// The elastic layer of a hand.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layer {
    /// The spheres, sorted by link.
    pub spheres: Vec<Sphere>,
    /// Number of nodes.
    pub nodes: usize,
    /// Parts of digits that are drawn to the object.
    pub phalanges: Vec<Phalanx>,
    /// Distance from the object that resting spheres keep, metres.
    pub clearance_m: f64,
    groups: Vec<Group>,
    /// A ball around the centres of the spheres of each link, link frame, metres; `None` for a link without spheres.
    link_balls: Vec<Option<(Vector3<f64>, f64)>>,
}

/// Consecutive spheres of one link and a ball around them. Groups form trees: a group that has parts comes before them.
#[derive(Debug, Clone, PartialEq)]
struct Group {
    link: LinkId,
    centre: Vector3<f64>,
    radius_m: f64,
    /// Its spheres, if it has no parts.
    spheres: Range<usize>,
    /// The group after the last of its parts.
    next: usize,
}

/// A sphere near the object, object frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearSphere {
    /// Index into [`Layer::spheres`].
    pub sphere: u32,
    /// Its centre, metres.
    pub centre: Vector3<f64>,
    /// Signed distance of the sphere from the object, metres.
    pub gap_m: f64,
    /// Gradient of the signed distance at the centre.
    pub gradient: Vector3<f64>,
    /// Hessian of the signed distance at the centre, 1/m.
    pub hessian: Matrix3<f64>,
}

impl Layer {
    /// The layer of `hand`, with nodes (patches) this far apart on each link.
    pub fn new(hand: &Hand, patch_spacing_m: f64) -> Self {
        Self::of_balls(hand, hand.balls(), patch_spacing_m)
    }

    /// A coarser layer for the meshes of `hand`, with a third of the spheres; identical for a hand of capsules.
    pub(crate) fn coarse(hand: &Hand, patch_spacing_m: f64) -> Self {
        Self::of_balls(hand, &hand.inscribed().coarse, patch_spacing_m)
    }

    fn of_balls(hand: &Hand, balls: &[Ball], patch_spacing_m: f64) -> Self {
        let volar = volar_directions(hand);
        let mut spheres = Vec::new();
        let mut groups = Vec::new();
        for (l, direction) in volar.iter().enumerate() {
            let link = LinkId(l);
            if hand.is_arm(link) {
                continue;
            }
            let direction = direction.unwrap_or_else(Vector3::zeros);
            let may_touch = hand.link_may_touch(link);
            for (number, capsule) in hand.capsules.iter().enumerate() {
                if capsule.link != link || hand.is_filling(number) {
                    continue;
                }
                let first = spheres.len();
                spheres.extend(along(capsule, direction, may_touch));
                let last = spheres.len();
                for start in (first..last).step_by(GROUP) {
                    groups.push(Group::of(&spheres, start..(start + GROUP).min(last)));
                    close_last(&mut groups);
                }
            }
            let balls = balls.iter().filter(|ball| ball.link == link);
            let balls = balls.map(|ball| of_ball(ball, direction, may_touch));
            let first = spheres.len();
            spheres.extend(balls);
            grow(&mut spheres, first, &mut groups);
        }
        let nodes = assign_nodes(&mut spheres, patch_spacing_m);
        let phalanges = phalanges(hand, &volar);
        let link_balls = (0..hand.links.len()).map(|link| ball_around(&spheres, LinkId(link)));
        Self {
            link_balls: link_balls.collect(),
            spheres,
            nodes,
            phalanges,
            clearance_m: 0.0,
            groups,
        }
    }

    /// The layer in which only some parts close, each with its side: the other parts rest, at least `clearance_m` off the
    /// object.
    #[must_use]
    pub fn for_grip(mut self, hand: &Hand, parts: &Parts, clearance_m: f64) -> Self {
        for sphere in &mut self.spheres {
            let side = parts.side(sphere.link);
            sphere.rests = side.is_none();
            sphere.may_touch &= !sphere.rests;
            if let Some(Side::Toward(direction)) = side {
                sphere.volar = direction;
            }
        }
        self.phalanges
            .retain(|phalanx| parts.side(phalanx.link).is_some());
        for phalanx in &mut self.phalanges {
            if let Some(Side::Toward(direction)) = parts.side(phalanx.link) {
                let points = points_toward(hand, phalanx.link, &direction);
                if !points.is_empty() {
                    phalanx.points = points;
                }
            }
        }
        if self.spheres.iter().any(|sphere| sphere.rests) {
            self.clearance_m = clearance_m;
        }
        self
    }

    /// The spheres near the object at one pose ([`NeighbourList::find`]).
    ///
    /// # Panics
    /// If `posed` belongs to another hand.
    pub fn near(&self, posed: &PosedHand, shape: &dyn Shape, reach_m: f64) -> Vec<NearSphere> {
        let mut near = Vec::new();
        NeighbourList::default().find(self, posed, shape, reach_m, &mut near);
        near
    }
}

/// The surface points of a link that face a direction of its frame.
fn points_toward(hand: &Hand, link: LinkId, direction: &Vector3<f64>) -> Vec<Vector3<f64>> {
    let own = hand.surface.iter().filter(|point| point.link == link);
    own.filter(|point| point.normal.dot(direction) > FACING)
        .map(|point| point.point)
        .collect()
}

/// A whole number of pieces of a hand; limits of files keep it small.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "lengths of hands are positive and limited, and the cast saturates"
)]
fn whole(pieces: f64) -> usize {
    pieces as usize
}

fn small(index: usize) -> u32 {
    u32::try_from(index).expect("a hand has fewer than 2³² spheres")
}

impl Group {
    fn of(spheres: &[Sphere], range: Range<usize>) -> Self {
        let members = &spheres[range.clone()];
        let centre = members.iter().map(|s| s.centre).sum::<Vector3<f64>>() / members.len() as f64;
        let radius_m = members
            .iter()
            .map(|s| (s.centre - centre).norm() + s.radius_m)
            .fold(0.0, f64::max);
        Self {
            link: members[0].link,
            centre,
            radius_m,
            spheres: range,
            next: usize::MAX,
        }
    }
}

/// Centre and radius of a ball around the centres of the spheres of a link.
fn ball_around(spheres: &[Sphere], link: LinkId) -> Option<(Vector3<f64>, f64)> {
    let centres = || {
        let members = spheres.iter().filter(|sphere| sphere.link == link);
        members.map(|sphere| sphere.centre)
    };
    let first = centres().next()?;
    let (low, high) = centres().fold((first, first), |(low, high), centre| {
        (low.inf(&centre), high.sup(&centre))
    });
    let middle = (low + high) / 2.0;
    let radius_m = centres().map(|centre| (centre - middle).norm());
    Some((middle, radius_m.fold(0.0, f64::max)))
}

/// Ends the tree of the last group after it.
fn close_last(groups: &mut [Group]) {
    let next = groups.len();
    if let Some(last) = groups.last_mut() {
        last.next = next;
    }
}

/// Sorts the spheres from `first` on so that those of a group are near each other, and adds their groups: each is halved
/// across its longest side until few spheres are left.
fn grow(spheres: &mut [Sphere], first: usize, groups: &mut Vec<Group>) {
    let members = &mut spheres[first..];
    let Some(link_place) = members.first().map(|sphere| sphere.centre) else {
        return;
    };
    let (low, high) = members
        .iter()
        .fold((link_place, link_place), |(low, high), sphere| {
            (low.inf(&sphere.centre), high.sup(&sphere.centre))
        });
    let count = members.len();
    let place = groups.len();
    groups.push(Group::of(spheres, first..first + count));
    if count > LEAF {
        let axis = (high - low).imax();
        spheres[first..].sort_by(|a, b| a.centre[axis].total_cmp(&b.centre[axis]));
        groups[place].spheres = first..first;
        let middle = first + count / 2;
        grow(&mut spheres[..middle], first, groups);
        grow(spheres, middle, groups);
    }
    groups[place].next = groups.len();
}

/// The sphere of a ball that fills a mesh.
fn of_ball(ball: &Ball, volar: Vector3<f64>, may_touch: bool) -> Sphere {
    let share = 0.5 * ball.shadow_m2 / UNIT_AREA_M2;
    Sphere {
        link: ball.link,
        centre: ball.centre,
        radius_m: ball.radius_m,
        share,
        pressed_share: share.max(LEAST_PRESSED),
        volar,
        may_touch,
        fills_mesh: true,
        rests: false,
        nodes: Vec::new(),
    }
}

/// Evenly spaced spheres along the axis of a capsule, with trapezoid weights. Half a radius at each end counts for the cap.
fn along(
    capsule: &Capsule,
    volar: Vector3<f64>,
    may_touch: bool,
) -> impl Iterator<Item = Sphere> + use<> {
    let capsule = *capsule;
    let length_m = (capsule.b - capsule.a).norm();
    let pieces = whole((length_m / SPACING_M).ceil());
    (0..=pieces).map(move |k| {
        let t = if pieces == 0 {
            0.5
        } else {
            k as f64 / pieces as f64
        };
        let piece_m = length_m / pieces.max(1) as f64;
        let ends = f64::from(u8::from(k == 0)) + f64::from(u8::from(k == pieces));
        let part_m = piece_m * (1.0 - 0.5 * ends) + 0.5 * capsule.radius_m * ends;
        let part_m = if pieces == 0 {
            capsule.radius_m
        } else {
            part_m
        };
        Sphere {
            link: capsule.link,
            centre: capsule.a + (capsule.b - capsule.a) * t,
            radius_m: capsule.radius_m,
            share: part_m * capsule.radius_m / UNIT_AREA_M2,
            pressed_share: part_m * capsule.radius_m / UNIT_AREA_M2,
            volar,
            may_touch,
            fills_mesh: false,
            rests: false,
            nodes: Vec::new(),
        }
    })
}

/// Distributes the spheres of each link over nodes, chosen one by one as the sphere farthest from those before, and returns
/// the number of nodes.
fn assign_nodes(spheres: &mut [Sphere], spacing_m: f64) -> usize {
    let mut count = 0;
    let mut first = 0;
    while first < spheres.len() {
        let link = spheres[first].link;
        let end = spheres.partition_point(|sphere| sphere.link <= link);
        let members = &mut spheres[first..end];
        let mut places: Vec<Vector3<f64>> = vec![members[0].centre];
        let away = |places: &[Vector3<f64>], point: &Vector3<f64>| {
            let distances = places.iter().map(|place| (place - point).norm());
            distances.fold(f64::INFINITY, f64::min)
        };
        loop {
            let distances = members.iter().map(|s| away(&places, &s.centre));
            let (farthest, most) =
                distances.enumerate().fold(
                    (0, 0.0),
                    |best, (i, d)| if d > best.1 { (i, d) } else { best },
                );
            // A link of meshes has nodes on a surface rather than along a line, which would be many.
            let apart = if members[0].fills_mesh { 0.8 } else { 0.6 };
            if most <= apart * spacing_m {
                break;
            }
            places.push(members[farthest].centre);
        }
        for sphere in members {
            let hats = places.iter().enumerate().map(|(k, place)| {
                let hat = 1.0 - (place - sphere.centre).norm() / spacing_m;
                (small(count + k), hat)
            });
            sphere.nodes = hats.filter(|(_, hat)| *hat > 0.0).collect();
            if sphere.fills_mesh {
                // On a surface more nodes are near than along a digit; the nearest ones are enough.
                sphere
                    .nodes
                    .sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
                sphere.nodes.truncate(MOST_NODES);
            }
            let sum: f64 = sphere.nodes.iter().map(|(_, hat)| hat).sum();
            for (_, hat) in &mut sphere.nodes {
                *hat /= sum;
            }
        }
        count += places.len();
        first = end;
    }
    count
}

/// Palmar points of the links of digits, in the order of the links.
fn phalanges(hand: &Hand, volar: &[Option<Vector3<f64>>]) -> Vec<Phalanx> {
    let mut phalanges = Vec::new();
    for (l, link) in hand.links.iter().enumerate() {
        let link_id = LinkId(l);
        let Some(direction) = volar[l].filter(|_| link.digit > 0 && hand.link_may_touch(link_id))
        else {
            continue;
        };
        let palmar = hand.inscribed().palmar.iter();
        let palmar = palmar.filter(|(link, _)| *link == link_id);
        let mut points: Vec<Vector3<f64>> = palmar.map(|(_, point)| *point).collect();
        for (number, capsule) in hand.capsules.iter().enumerate() {
            if capsule.link != link_id || hand.is_filling(number) {
                continue;
            }
            let length_m = (capsule.b - capsule.a).norm();
            let count = whole((length_m / REACH_SPACING_M).round()).max(1);
            for k in 0..count {
                let t = (k as f64 + 0.5) / count as f64;
                let centre = capsule.a + (capsule.b - capsule.a) * t;
                points.push(centre + direction * capsule.radius_m);
            }
        }
        if !points.is_empty() {
            phalanges.push(Phalanx {
                link: link_id,
                points,
            });
        }
    }
    phalanges
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The layer of a hand of capsules has one sphere every 3 mm along each of them and nothing else.
    #[test]
    fn a_hand_of_capsules_has_spheres_on_their_axes() {
        let hand = Hand::human();
        let layer = Layer::new(&hand, 0.025);
        assert!(hand.balls().is_empty());
        assert!(
            layer.spheres.iter().all(|sphere| !sphere.fills_mesh
                && sphere.pressed_share.to_bits() == sphere.share.to_bits())
        );
        let on_axes: usize = (hand.capsules.iter())
            .filter(|capsule| !hand.is_arm(capsule.link))
            .map(|capsule| 1 + whole(((capsule.b - capsule.a).norm() / SPACING_M).ceil()))
            .sum();
        assert_eq!(layer.spheres.len(), on_axes);
    }

    /// Each part of a digit of boxes has palmar points to be drawn to the object, and they lie on its surface.
    #[test]
    fn phalanges_of_boxes_have_palmar_points() {
        let hand = Hand::named("gripper_three_finger").unwrap();
        let layer = Layer::new(&hand, 0.025);
        for phalanx in &layer.phalanges {
            assert!(!phalanx.points.is_empty());
            let spheres = || layer.spheres.iter().filter(|s| s.link == phalanx.link);
            for point in &phalanx.points {
                let gaps = spheres().map(|s| (s.centre - point).norm() - s.radius_m);
                let gap = gaps.fold(f64::INFINITY, f64::min);
                assert!(gap.abs() < 0.003, "{gap}");
            }
        }
        let links = hand.links.iter().filter(|link| link.digit > 0);
        assert!(layer.phalanges.len() >= links.count() - 3);
    }

    /// The fractions of a sphere that belong to nodes sum to 1, and each node has spheres of one link.
    #[test]
    fn nodes_divide_the_spheres() {
        for name in ["human", "gripper_three_finger"] {
            let layer = Layer::new(&Hand::named(name).unwrap(), 0.025);
            let mut links = vec![None; layer.nodes];
            for sphere in &layer.spheres {
                let sum: f64 = sphere.nodes.iter().map(|(_, hat)| hat).sum();
                assert!((sum - 1.0).abs() < 1e-12);
                for &(node, _) in &sphere.nodes {
                    let link = links[node as usize].get_or_insert(sphere.link);
                    assert_eq!(*link, sphere.link);
                }
            }
        }
    }

    /// Fingers and palm of the human hand carry on their palmar side, the z axis of their links.
    #[test]
    fn palmar_sides_of_the_human_hand() {
        let hand = Hand::human();
        for sphere in Layer::new(&hand, 0.025).spheres {
            let link = &hand.links[sphere.link.0];
            if link.name != "thumb_metacarpal" {
                assert!(sphere.volar.z > 0.95, "{} {:?}", link.name, sphere.volar);
            }
        }
    }
}
