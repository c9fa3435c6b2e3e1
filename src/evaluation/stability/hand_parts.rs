//! The solid parts of a posed hand.

use super::convert::vector;
use super::solid::Solid;
use super::world::{Part, World};
use crate::hand::{Hand, LinkId, PosedHand};

/// Adds a rigid hand.
pub(super) fn fix_hand(world: &mut World, hand: &Hand, posed: &PosedHand, solid: &Solid) {
    for (link, part, _) in capsules(hand, posed).filter(|(.., fills)| !fills) {
        let collider = world.holder(&part, hand, link);
        world.physics.insert_collider(collider, None);
    }
    for (link, part) in balls(hand, posed, solid, NEAR_M) {
        let collider = world.holder(&part, hand, link);
        world.physics.insert_collider(collider, None);
    }
}

/// Balls farther than this from the object at the start are left out, metres: an object that moves so far is not held.
pub(super) const NEAR_M: f64 = 0.01;

/// The capsules of a posed hand with their links, and whether each only fills a mesh.
pub(super) fn capsules<'a>(
    hand: &'a Hand,
    posed: &'a PosedHand,
) -> impl Iterator<Item = (LinkId, Part, bool)> + 'a {
    let capsules = hand.capsules.iter().zip(&posed.capsules).enumerate();
    capsules.map(|(number, (capsule, [a, b]))| {
        let part = Part::Capsule {
            a: *a,
            b: *b,
            radius_m: capsule.radius_m,
        };
        (capsule.link, part, hand.is_filling(number))
    })
}

/// The balls that fill meshes, boxes and cylinders of a posed hand and are within `near_m` of the object, with their links.
pub(super) fn balls<'a>(
    hand: &'a Hand,
    posed: &'a PosedHand,
    solid: &'a Solid,
    near_m: f64,
) -> impl Iterator<Item = (LinkId, Part)> + 'a {
    let placed = hand.balls().iter().map(|ball| {
        let frame = &posed.object_from_link[ball.link.0];
        (ball, frame.point(&ball.centre))
    });
    let near = placed.filter(move |(ball, centre)| {
        let shape = &solid.shape;
        let distance_m = shape.distance_to_local_point(vector(centre), true);
        distance_m <= ball.radius_m + near_m
    });
    near.map(|(ball, centre)| {
        let part = Part::Ball {
            centre,
            radius_m: ball.radius_m,
        };
        (ball.link, part)
    })
}
