//! Judges one grasp by one protocol.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::closing::closed;
use super::hand_parts::fix_hand;
use super::load_test::ClosingRule;
use super::rest::Watch;
use super::settings::{Drop, OVERLAP_M, Protocol, count};
use super::solid::Solid;
use super::trials::withstand;
use super::world::World;
use crate::grasp::Grasp;
use crate::hand::{Hand, PosedHand};

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
    /// The hand, or its digits, no longer press on the object at the end.
    Released,
    /// The engine lost the object: its position is not finite.
    Lost,
}

impl Reason {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Held,
        Self::Overlap,
        Self::Fell,
        Self::Moved,
        Self::Turned,
        Self::Released,
        Self::Lost,
    ];

    /// Its name in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Overlap => "overlap",
            Self::Fell => "fell",
            Self::Moved => "moved",
            Self::Turned => "turned",
            Self::Released => "released",
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
    /// trial of a test with loads (of those that held, if the grasp did).
    pub displacement_m: f64,
    /// Rotation of the object, radians: at the end of a drop, or the largest in any trial of a test with loads.
    pub turn_rad: f64,
    /// Overlap of hand and object at the start, metres.
    pub overlap_m: f64,
    /// How the hand closed: for [`ClosingRule::Given`] without squeezed joints in the file it is [`ClosingRule::Squeeze`].
    #[serde(default)]
    pub closed_by: ClosingRule,
}

impl Outcome {
    pub(super) const START: Self = Self {
        reason: Reason::Held,
        displacement_m: 0.0,
        turn_rad: 0.0,
        overlap_m: 0.0,
        closed_by: ClosingRule::None,
    };

    /// Whether the object stayed in the hand.
    pub fn is_stable(&self) -> bool {
        self.reason == Reason::Held
    }
}

/// Simulates a grasp of `hand` on an object of `mass_kg`, if the protocol sets no other mass. `squeeze_joints` are the
/// squeezed joint coordinates of the grasp's file, for protocols that use them.
///
/// # Panics
/// If the grasp or `squeeze_joints` are those of another hand.
pub fn simulate(
    hand: &Hand,
    grasp: &Grasp,
    squeeze_joints: Option<&[f64]>,
    solid: &Solid,
    mass_kg: f64,
    protocol: &Protocol,
) -> Outcome {
    match protocol {
        Protocol::Drop(drop) => {
            let mut posed = PosedHand::default();
            hand.pose(&grasp.pose, &mut posed);
            fall(hand, &posed, solid, mass_kg, drop)
        }
        Protocol::Loads(test) => {
            let closed = closed(hand, grasp, squeeze_joints, solid, test);
            withstand(hand, &closed, solid, mass_kg, test)
        }
    }
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

/// Records the overlap of hand and object; returns whether it is too large.
pub(super) fn overlaps(outcome: &mut Outcome, world: &World) -> bool {
    outcome.overlap_m = world.overlap_m();
    if outcome.overlap_m > OVERLAP_M {
        outcome.reason = Reason::Overlap;
    }
    outcome.reason != Reason::Held
}
