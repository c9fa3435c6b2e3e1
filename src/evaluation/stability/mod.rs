//! Tests by rigid-body simulation whether the object stays in the hand.
//!
//! [`Protocol`] defines a test with all its numbers, [`NAMED`] holds the published ones, and [`simulate`] tests one grasp. The hand consists of its capsules,
//! and of balls where it has meshes, boxes and cylinders ([`Hand::balls`](crate::hand::Hand::balls)). The elastic layer has
//! the same shape, so the energy and the engine agree on contacts. The object is a [`Solid`] of
//! convex pieces. [`World`] contains both; the tests with known outcomes use it too.
//!
//! Results have the same bits on any number of threads, because each grasp has a world of its own and the engine runs in
//! its deterministic mode.

mod closing;
mod convert;
mod driven_hand;
mod ghosts;
mod hand_parts;
mod inertia;
mod judge;
mod load_test;
mod named;
mod replay;
mod rest;
mod settings;
mod solid;
mod trials;
mod world;

pub use closing::joint_targets;
pub use judge::{Outcome, Reason, simulate};
pub use load_test::{
    Axes, Closing, ClosingRule, Criterion, EndContact, LoadTest, Loads, MeasuredFrom, Needed,
};
pub use named::{NAMED, NamedProtocol, named};
pub use replay::{Moment, Replay, Replayed, Target, moved_in_hand, replay, targets};
pub use settings::{Drop, Protocol, ProtocolError, Rest, Solver};
pub use solid::{Build, Fit, Piece, Solid};
pub use world::{Part, World};
