//! Tests by rigid-body simulation whether the object stays in the hand.
//!
//! [`Protocol`] defines a test with all its numbers; [`simulate`] tests one grasp. The hand consists of its capsules,
//! and of balls where it has meshes, boxes and cylinders ([`Hand::balls`](crate::hand::Hand::balls)). The elastic layer has
//! the same shape, so the energy and the engine agree on contacts. The object is a [`Solid`] of
//! convex pieces. [`World`] contains both; the tests with known outcomes use it too.
//!
//! Results have the same bits on any number of threads, because each grasp has a world of its own and the engine runs in
//! its deterministic mode.

mod convert;
mod ghosts;
mod inertia;
mod judge;
mod rest;
mod settings;
mod solid;
mod squeeze;
mod world;

pub use judge::{Outcome, Reason, simulate};
pub use settings::{Drop, Protocol, ProtocolError, Rest, SixDirections, Solver, Squeeze};
pub use solid::{Build, Fit, Piece, Solid};
pub use squeeze::joint_targets;
pub use world::{Part, World};
