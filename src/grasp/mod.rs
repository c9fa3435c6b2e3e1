//! Half one: hand + object → energy → grasps.

pub mod closure;
pub mod hand;
pub mod object;
