//! Data that can be read but is hardly meant: units, frames and orders that were probably confused.
//!
//! A reader that finds such data gives a [`Doubt`]. If the data could still be right, the doubt is a note beside the result; if
//! it cannot, the doubt is the reason of the refusal. Both are the same sentence.

use std::fmt;

/// Why given data is implausible.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Doubt {
    /// What is doubted: a file, joint, link or grasp.
    pub subject: String,
    /// What was found, with numbers and units.
    pub finding: String,
    /// The likely cause, which begins with `probably`.
    pub cause: String,
    /// What to do, in the imperative.
    pub remedy: String,
}

impl fmt::Display for Doubt {
    /// For instance `joint f1_j1: its range is -4584° to 4584°; probably its limits are in degrees; give them in radians`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            subject,
            finding,
            cause,
            remedy,
        } = self;
        write!(f, "{subject}: {finding}; {cause}; {remedy}")
    }
}
