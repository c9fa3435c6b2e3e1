//! With the exact acceptance ratio the kernel samples a known density: a Gaussian in tangent coordinates of poses. Wrong ratios
//! are detected.

mod chain;
mod gaussian;
mod statistics;

/// Deviation that chance may reach, in standard deviations: once in 10⁵ per number, and each test examines a few.
pub(crate) const CHANCE: f64 = 4.5;
/// Deviation that a wrong distribution must reach, in standard deviations.
pub(crate) const WRONG: f64 = 8.0;
