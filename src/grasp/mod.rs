//! Half one: hand + object → energy → grasps.
//!
//! [`hand`] and [`object`] are what meets, [`term`] what a meeting costs, [`energy`] the sum and its envelope over contact
//! sets, [`kernel`] the moves, [`synthesis`] the search, [`filter`] and [`closure`] the judges,
//! [`depth`] how deep hand and object lie in each other, [`failure`] what relaxed force closure alone does not see, [`relaxed`] the relaxed test of bare points and
//! [`contact_points`] the search for its minima, [`press`] closes a hand until it presses, [`stability`] the test in a physics
//! engine, [`taxonomy`] the names of grasps.

pub mod closure;
pub mod contact;
pub mod contact_points;
pub mod depth;
pub mod diversity;
pub mod energy;
pub mod failure;
pub mod filter;
pub mod hand;
pub mod hover;
pub mod kernel;
pub mod object;
pub mod press;
pub mod relaxed;
pub mod spread;
pub mod stability;
pub mod start;
pub mod synthesis;
pub mod taxonomy;
pub mod term;

pub use diversity::Diversity;
pub use energy::{EnergySettings, GraspEnergy};
pub use filter::{Judgement, MeasuredContact, judge, measure_contacts};
pub use kernel::GraspKernel;
