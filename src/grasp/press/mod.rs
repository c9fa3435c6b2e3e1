//! Closing a hand until it presses: the last step from a minimum of the energy to a hand that holds.
//!
//! The energy has its contacts within a millimetre or two of the surface, some off it and some in it, and cares for no
//! others. A hand that is to hold must touch, and touch so that what it presses balances. [`press`] moves pose and joints
//! by a millimetre or so until every capsule that nearly touches is as deep in the object as its share of balanced contact
//! forces asks for, as if its skin were a spring, and until free digits within reach touch, too.

mod close;
mod firm;
mod touch;

pub use close::{PressSettings, press};
pub use firm::{FIRM_FRICTION, Firmness, firmness};
pub use touch::{Touch, touches};
