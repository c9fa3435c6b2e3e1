//! What a population of grasps is worth: simulation, names of grasp types, diversity.
//!
//! [`stability`] tests in a physics engine whether the object stays in the hand. [`taxonomy`] names the type of a grasp.
//! [`Diversity`] says how far the grasps of a population lie apart,
//! and [`HandUse`] how each uses the hand, so that it can be compared with people's grasps.

pub mod diversity;
pub mod human_likeness;
#[cfg(feature = "simulation")]
pub mod stability;
pub mod taxonomy;

pub use diversity::{Diversity, TOUCHING_M, contact_regions, regions_within};
pub use human_likeness::HandUse;
