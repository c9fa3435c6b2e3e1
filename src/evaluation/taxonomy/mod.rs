//! The 33 types of the GRASP taxonomy (Feix et al. 2016), and the rule that labels a grasp and explains the label.
//!
//! [`Taxonomy`] is the table, [`Anatomy`] interprets a hand as a human one, [`touches`] gives all surface points near the
//! object (not only the few contacts of force closure), and [`held`] tells the form of the part that the hand holds.
//! [`Labeller`] measures facts of these and decides in the order of the taxonomy: opposition and category, virtual fingers
//! and thumb, then the type. What each type expects stands in the [`Rule`]. All facts use directions of the hand itself, so a
//! mirrored grasp has the same label.

mod anatomy;
mod certainty;
mod decision;
mod expected;
mod explain;
mod facts;
mod features;
mod form;
mod label;
mod learned;
mod pose_correction;
mod rule;
mod table;
mod taught;
mod touch;

pub use anatomy::{Anatomy, Bone, PalmAxes, PalmPart, Patch, Unlike};
pub use certainty::Certainty;
pub use decision::Evidence;
pub use expected::{ExpectedTouch, ImaginedTouch};
pub use explain::explain;
pub(super) use facts::{DIGITS, flexion, thumb_elevation, touches_enough};
pub use features::Features;
pub use form::{Held, Solid, held, held_by_contacts};
pub use label::{
    By, Candidate, Inapplicable, Label, Labeller, NOT_APPLICABLE, UNLISTED, Verdict, label_contacts,
};
pub use learned::{Example, Regression, UNLISTED_CLASS, Unseen, answer};
pub use pose_correction::{PoseCorrection, readings};
pub use rule::{Rule, Sharpness};
pub use table::{Category, Disagreement, Form, GraspType, Opposition, Taxonomy, Thumb};
pub use taught::{Judged, LEAST_LABELS, OfCertainty, Taught, TaughtWith, TeachError};
pub use touch::{NEAR_M, TouchingPatch, touches};

/// Why a table of types or a rule cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TaxonomyError {
    /// Not TOML of the expected form.
    #[error("the table of grasp types is invalid: {0}")]
    Toml(#[from] toml::de::Error),
    /// An entry contradicts itself or others.
    #[error("grasp type {name}: {problem}")]
    Type {
        /// Name of the type.
        name: String,
        /// What is wrong.
        problem: String,
    },
    /// Not a labeller that was taught.
    #[error("this is not a labeller that `landscape label --learn` wrote: {0}")]
    Labeller(String),
}
