//! With the exact acceptance ratio the kernels sample known densities: a Gaussian in tangent coordinates of poses and matrix
//! Fisher distributions of rotations. Wrong ratios are detected.
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod chain;
mod gaussian;
mod rotations;
mod statistics;

/// Deviation that chance may reach, in standard deviations: once in 10⁵ per number, and each test examines a few.
pub(crate) const CHANCE: f64 = 4.5;
/// Deviation that a wrong distribution must reach, in standard deviations.
pub(crate) const WRONG: f64 = 8.0;
