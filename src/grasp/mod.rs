//! Half one: hand + object → energy → grasps.
//!
//! [`term`] holds the terms of the energy, [`energy`] their sum and its envelope over contact sets. [`kernel`] proposes moves,
//! and [`synthesis`] runs the search. [`filter`] and [`closure`] judge a grasp; [`depth`] measures how deep hand and object
//! lie in each other, and [`failure`] finds what relaxed force closure alone does not see. [`relaxed`] is the relaxed test of
//! bare points, and [`contact_points`] searches for its minima. [`press`] closes a hand until it presses.

pub mod closure;
pub mod contact;
pub mod contact_points;
pub mod depth;
pub mod energy;
pub mod failure;
pub mod filter;
pub mod hover;
pub mod kernel;
pub mod press;
pub mod relaxed;
pub mod spread;
pub mod start;
pub mod synthesis;
pub mod term;

pub use energy::{EnergySettings, GraspEnergy};
pub use filter::{Judgement, MeasuredContact, judge, measure_contacts};
pub use kernel::GraspKernel;
