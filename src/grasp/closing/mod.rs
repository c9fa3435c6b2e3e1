//! Contacts of a hand's capsules, and the hand before it closes.
//!
//! Minima of the energy are closed hands already. [`capsule_touches`] says exactly what touches. [`opened`] gives the hand
//! before it closes, for programs that close it themselves.

mod open;
mod touch;

pub use open::opened;
pub use touch::{CapsuleTouch, capsule_touches};
