//! Closes a hand until it presses: the last step from a minimum of the energy to a hand that holds.
//!
//! The contacts of the energy are within a millimetre or two of the surface, inside or outside, and it ignores all other
//! points. A hand that holds must touch, and the forces of its touches must balance. [`close_hand`] moves pose and joints by a
//! millimetre or so until every capsule that nearly touches is as deep in the object as its share of balanced contact
//! forces requires, as if the skin were a spring. Free digits within reach are closed until they touch. [`opened`] goes the
//! other way, for programs that close the hand themselves.

mod close;
mod open;
mod preload;
mod touch;

pub use close::{ClosingSettings, close_hand};
pub use open::opened;
pub use preload::{PRELOAD_FRICTION, Preload, preload};
pub use touch::{CapsuleTouch, capsule_touches};
