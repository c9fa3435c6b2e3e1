//! Shows how diverse a population of grasps really is.
#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod energy;
pub mod figure;
pub mod optimize;
pub mod sample;
pub mod space;

#[cfg(feature = "grasp")]
pub mod grasp;
#[cfg(feature = "topography")]
pub mod topography;

#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
pub mod store;
