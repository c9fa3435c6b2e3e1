//! The 33 types of the GRASP taxonomy (Feix et al. 2016), and the rule that labels a grasp and explains the label.
//!
//! [`Taxonomy`] is the table, [`Anatomy`] interprets a hand as a human one, and [`touches`] gives all surface points near
//! the object (not only the few contacts of force closure). [`Labeller`] compares features of these with a signature of
//! each type. All features use directions of the hand itself, so a mirrored grasp has the same label.

mod anatomy;
mod classifier;
mod features;
mod pose_correction;
mod signature;
mod table;
mod touch;

pub use anatomy::{Anatomy, Bone, PalmPart, Patch};
pub use classifier::{
    Candidate, Evidence, Inapplicable, Label, Labeller, NOT_APPLICABLE, UNLISTED, Verdict, explain,
    label_contacts,
};
pub use pose_correction::{PoseCorrection, readings};
pub use signature::Rule;
pub use table::{Category, Disagreement, Form, GraspType, Opposition, Taxonomy, Thumb};
pub use touch::{Held, NEAR_M, TouchingPatch, held, touches};

/// Why a table of types or of signatures cannot be used.
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
}
