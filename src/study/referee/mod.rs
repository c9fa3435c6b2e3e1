//! Grasps of any origin, judged by the tests and measures that publications use.
//!
//! [`measures`] has the measures of quality and diversity.

pub mod measures;
