//! Judges one grasp by one protocol.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::convert::vector;
use super::rest::Watch;
use super::settings::{Drop, OVERLAP_M, Protocol, SixDirections, Squeeze, count};
use super::solid::Solid;
use super::squeeze::{add_hand, closing};
use super::world::{Part, World};
use crate::grasp::Grasp;
use crate::hand::{Hand, LinkId, PosedHand};

/// Why a grasp is stable or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// It is stable.
    Held,
    /// Hand and object overlap too much at the start.
    Overlap,
    /// The object fell.
    Fell,
    /// The object moved too far.
    Moved,
    /// The object turned too much.
    Turned,
    /// The engine lost the object: its position is not finite.
    Lost,
}

impl Reason {
    /// Its name in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Overlap => "overlap",
            Self::Fell => "fell",
            Self::Moved => "moved",
            Self::Turned => "turned",
            Self::Lost => "lost",
        }
    }
}

/// Result of a simulated grasp.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The reason for the verdict.
    pub reason: Reason,
    /// Displacement of the object's centre of mass, metres: at the end of a drop (at rest or failed), or the largest in any
    /// of the six directions.
    pub displacement_m: f64,
    /// Rotation of the object, radians: at the end of a drop, or the largest in any of the six directions.
    pub turn_rad: f64,
    /// Overlap of hand and object at the start, metres.
    pub overlap_m: f64,
}

impl Outcome {
    const START: Self = Self {
        reason: Reason::Held,
        displacement_m: 0.0,
        turn_rad: 0.0,
        overlap_m: 0.0,
    };

    /// Whether the object stayed in the hand.
    pub fn is_stable(&self) -> bool {
        self.reason == Reason::Held
    }
}

/// Simulates a grasp of `hand` on an object of `mass_kg`. A squeezing protocol derives the squeeze from the contact set.
///
/// # Panics
/// If the grasp is one of another hand.
pub fn simulate(
    hand: &Hand,
    grasp: &Grasp,
    solid: &Solid,
    mass_kg: f64,
    protocol: &Protocol,
) -> Outcome {
    let mut posed = PosedHand::default();
    hand.pose(&grasp.pose, &mut posed);
    match protocol {
        Protocol::Drop(drop) => fall(hand, &posed, solid, mass_kg, drop),
        Protocol::SixDirections(six) => {
            let closing = (!six.rigid).then(|| closing(hand, &posed, &grasp.contacts, solid, six));
            push(hand, &posed, closing.as_deref(), solid, six)
        }
    }
}

fn fix_hand(world: &mut World, hand: &Hand, posed: &PosedHand, solid: &Solid) {
    for (_, part, _) in capsules(hand, posed).filter(|(.., fills)| !fills) {
        world.fix(&part);
    }
    for (_, part) in balls(hand, posed, solid) {
        world.fix(&part);
    }
}

/// Balls farther than this from the object at the start are left out, metres: an object that moves so far is not held.
const NEAR_M: f64 = 0.01;

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

/// The balls that fill meshes, boxes and cylinders of a posed hand and are near the object, with their links.
pub(super) fn balls<'a>(
    hand: &'a Hand,
    posed: &'a PosedHand,
    solid: &'a Solid,
) -> impl Iterator<Item = (LinkId, Part)> + 'a {
    let placed = hand.balls().iter().map(|ball| {
        let frame = &posed.object_from_link[ball.link.0];
        (ball, frame.point(&ball.centre))
    });
    let near = placed.filter(|(ball, centre)| {
        let shape = &solid.shape;
        let distance_m = shape.distance_to_local_point(vector(centre), true);
        distance_m <= ball.radius_m + NEAR_M
    });
    near.map(|(ball, centre)| {
        let part = Part::Ball {
            centre,
            radius_m: ball.radius_m,
        };
        (ball.link, part)
    })
}

fn fall(hand: &Hand, posed: &PosedHand, solid: &Solid, mass_kg: f64, drop: &Drop) -> Outcome {
    let solver = &drop.solver;
    let mut world = World::new(solid, mass_kg, [0.0; 3], drop.friction, solver);
    fix_hand(&mut world, hand, posed, solid);
    let settling = count(drop.settle_s, solver.time_step_s);
    let down = Vector3::from(drop.gravity_m_s2).normalize();
    let mut outcome = Outcome::START;
    if overlaps(&mut outcome, &world) {
        return outcome;
    }
    let mut watch = Watch::new(solid, &drop.rest, solver.time_step_s);
    for step in 0..settling + drop.steps {
        if step == settling {
            world.set_gravity(drop.gravity_m_s2);
        }
        world.step();
        let (way, turn_rad) = world.motion();
        if !(way.norm().is_finite() && turn_rad.is_finite()) {
            outcome.reason = Reason::Lost;
            return outcome;
        }
        outcome.displacement_m = way.norm();
        outcome.turn_rad = turn_rad;
        if way.dot(&down) >= drop.fall_m {
            outcome.reason = Reason::Fell;
            return outcome;
        }
        if step >= settling && watch.rests(world.object_pose()) {
            return outcome;
        }
    }
    outcome
}

fn push(
    hand: &Hand,
    posed: &PosedHand,
    closing: Option<&[f64]>,
    solid: &Solid,
    six: &SixDirections,
) -> Outcome {
    let mut closed = World::new(solid, six.mass_kg, [0.0; 3], six.friction, &six.solver);
    match closing {
        Some(closing) => add_hand(&mut closed, hand, posed, solid, closing, &six.squeeze),
        None => fix_hand(&mut closed, hand, posed, solid),
    }
    let mut outcome = Outcome::START;
    if overlaps(&mut outcome, &closed) {
        return outcome;
    }
    for _ in 0..count(Squeeze::TIME_S, six.solver.time_step_s).max(1) {
        closed.step();
        if fails(&mut outcome, &closed, six) {
            return outcome;
        }
    }
    for direction in 0..6 {
        let sign = if direction % 2 == 0 { 1.0 } else { -1.0 };
        let mut world = closed.fork();
        world.push_object(&Vector3::ith(direction / 2, sign * six.force_n));
        let mut watch = Watch::new(solid, &six.rest, six.solver.time_step_s);
        for _ in 0..count(six.push_s, six.solver.time_step_s) {
            world.step();
            if fails(&mut outcome, &world, six) {
                return outcome;
            }
            if watch.rests(world.object_pose()) {
                break;
            }
        }
    }
    outcome
}

/// Records the overlap of hand and object; returns whether it is too large.
fn overlaps(outcome: &mut Outcome, world: &World) -> bool {
    outcome.overlap_m = world.overlap_m();
    if outcome.overlap_m > OVERLAP_M {
        outcome.reason = Reason::Overlap;
    }
    outcome.reason != Reason::Held
}

/// Records the motion of the object; returns whether it is too large.
fn fails(outcome: &mut Outcome, world: &World, six: &SixDirections) -> bool {
    let (way, turn_rad) = world.motion();
    outcome.displacement_m = outcome.displacement_m.max(way.norm());
    outcome.turn_rad = outcome.turn_rad.max(turn_rad);
    outcome.reason = if !(way.norm().is_finite() && turn_rad.is_finite()) {
        Reason::Lost
    } else if outcome.displacement_m >= six.displacement_m {
        Reason::Moved
    } else if outcome.turn_rad >= six.turn_rad {
        Reason::Turned
    } else {
        Reason::Held
    };
    outcome.reason != Reason::Held
}
