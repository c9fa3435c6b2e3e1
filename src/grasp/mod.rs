//! Half one: hand + object → energy → grasps.

pub mod hand;
pub mod object;
