//! What a population of grasps is worth: simulation, names of grasp types, diversity.
//!
//! [`stability`] tests in a physics engine whether the object stays in the hand. [`taxonomy`] names the type of a grasp.
//! [`Diversity`] says how far the grasps of a population lie apart.

pub mod diversity;
#[cfg(feature = "simulation")]
pub mod stability;
pub mod taxonomy;

pub use diversity::Diversity;
