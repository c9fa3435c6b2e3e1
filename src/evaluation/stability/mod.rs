//! Would the object stay in the hand? Rigid bodies in a physics engine.
//!
//! [`Protocol`] says what is tested, with every number; [`simulate`] tests one grasp. The hand is its capsules, on whose
//! surface the contact points lie, so nothing lies between what the energy and what the engine calls contact. The object
//! is a [`Solid`] of convex pieces. [`World`] is what both are put into, and what the tests with known outcomes use.
//!
//! Results are the same bits on any number of threads: each grasp has a world of its own, and the engine runs in its
//! deterministic mode.

mod convert;
mod ghosts;
mod judge;
mod rest;
mod settings;
mod solid;
mod squeeze;
mod world;

pub use judge::{Outcome, Reason, simulate};
pub use settings::{
    Combine, Drop, Friction, Protocol, ProtocolError, Rest, SixDirections, Solver, Squeeze,
};
pub use solid::{Build, Fit, Piece, Solid};
pub use world::{Part, World};
