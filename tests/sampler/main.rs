//! With the exact acceptance ratio the kernels sample known densities: a Gaussian in tangent coordinates of poses, matrix
//! Fisher laws of rotations, and contact sets of a posed hand and of a hand that moves. Wrong ratios are told apart.
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod chain;
#[cfg(feature = "grasp")]
mod contacts;
mod gaussian;
#[cfg(feature = "grasp")]
mod grasps;
mod rotations;
mod statistics;

/// Standard deviations that chance may reach: once in 10⁵ for one number, and each test looks at a few.
pub(crate) const CHANCE: f64 = 4.5;
/// Standard deviations that a wrong law must reach.
pub(crate) const WRONG: f64 = 8.0;
