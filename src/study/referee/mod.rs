//! Sets of grasps of any origin under the tests and measures that publications use: what each says of a set, and where they
//! disagree.
//!
//! [`measures`] has the measures of quality and diversity, [`crate::evaluation::stability::NAMED`] the tests.

mod chart;
pub mod measures;
mod report;
mod verdict;

pub use verdict::{
    JudgedSet, RefereeSettings, SetVerdict, TestVerdict, Verdicts, judge_sets, referee_fingerprint,
};
