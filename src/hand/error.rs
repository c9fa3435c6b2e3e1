//! Errors of descriptions of hands.

use crate::doubt::Doubt;
use crate::limits::Beyond;

/// Why a description cannot be read as a hand.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages show the fields")]
pub enum HandError {
    /// A file that cannot be read.
    #[error("cannot read {}: {problem}", path.display())]
    File {
        path: std::path::PathBuf,
        problem: String,
    },
    /// A file of MANO that cannot be used.
    #[error("{file} {problem}")]
    Mano { file: String, problem: String },
    /// No description at all.
    #[error("no description of a hand is given")]
    NoDescription,
    /// A problem with an element of a description.
    #[error("{place}: {problem}")]
    Element { place: String, problem: String },
    /// No hand of that name comes with the program.
    #[error("no hand is called \"{name}\"; the hands are {}", super::HAND_NAMES.join(", "))]
    NoSuchHand { name: String },
    /// The description is not XML but, for example, a mesh or a table.
    #[error("not a description of a hand: give a URDF or MJCF file (XML) or a MANO file (.npz)")]
    NotADescription,
    /// The description is in a format that is not read.
    #[error("{file}: {format} is not read: {remedy}")]
    OtherFormat {
        file: String,
        format: &'static str,
        remedy: String,
    },
    /// The description is not a URDF document.
    #[error("the URDF cannot be read: {0}")]
    Urdf(#[from] urdf_rs::UrdfError),
    /// The side file does not have the right form.
    #[error("the side file cannot be read: {0}")]
    SideFile(#[from] serde_json::Error),
    /// The side file or a joint refers to a name that the description does not have.
    #[error("{place} names {kind} \"{name}\", which the description does not have")]
    Unknown {
        place: String,
        /// `link` or `joint`.
        kind: &'static str,
        name: String,
    },
    /// Two links or two joints have the same name.
    #[error("there are two {kind}s named \"{name}\"")]
    Twice {
        /// `link` or `joint`.
        kind: &'static str,
        name: String,
    },
    /// A link is the child of two joints.
    #[error(
        "link \"{link}\" is the child of two joints, \"{first}\" and \"{second}\", but the links of a hand form a tree: delete \
         one of the two; if they close a loop, let the other joints of the loop follow one of them (<mimic>)"
    )]
    TwoParents {
        link: String,
        first: String,
        second: String,
    },
    /// There is no root, or there are several.
    #[error("a hand has one link without a parent; this description has {}: {}", roots.len(), roots.join(", "))]
    Roots { roots: Vec<String> },
    /// Links form a ring.
    #[error("link \"{link}\" is not connected to the root: its joints form a ring")]
    Ring { link: String },
    /// A joint of a kind that is not handled.
    #[error(
        "joint \"{joint}\" is {kind}; only revolute, continuous, prismatic and fixed joints are handled"
    )]
    UnsupportedJoint { joint: String, kind: &'static str },
    /// Joints follow each other in a circle.
    #[error("joint \"{joint}\" follows others in a circle")]
    Circle { joint: String },
    /// A slide without limits.
    #[error("joint \"{joint}\" slides without limits: give it a range")]
    Endless { joint: String },
    /// The limits leave no range.
    #[error(
        "joint \"{joint}\" may move from {lower} to {upper}: give it finite limits, the lower below the upper"
    )]
    EmptyRange {
        joint: String,
        /// Lower limit, radians.
        lower: f64,
        /// Upper limit, radians.
        upper: f64,
    },
    /// The axis of a joint has length zero.
    #[error("joint \"{joint}\" has an axis of length zero")]
    NoAxis { joint: String },
    /// No joint moves.
    #[error("the description has no movable joint")]
    NoJoints,
    /// A mesh that cannot be read.
    #[error(
        "link \"{link}\", {problem} (or give it capsules in the side file: \"capsules\": {{\"{link}\": …}})"
    )]
    Mesh {
        link: String,
        /// The mesh and what is wrong with it.
        problem: String,
    },
    /// The description can be read, but it cannot be meant.
    #[error("{0}")]
    Implausible(Doubt),
    /// A number is beyond its limit.
    #[error("{place}: {beyond}")]
    Beyond { place: String, beyond: Beyond },
    /// An orientation whose numbers are too large or too small for a rotation.
    #[error(
        "link \"{link}\": the numbers of an orientation are too large or too small for a rotation"
    )]
    NoRotation { link: String },
    /// The description has more items than a hand can have.
    #[error("the description has {count} {kind}, but at most {most} are allowed: {advice}")]
    TooMany {
        kind: &'static str,
        count: usize,
        most: usize,
        advice: &'static str,
    },
    /// No link has geometry.
    #[error("no link has geometry, so the hand cannot touch anything")]
    NoGeometry,
    /// A number that is not finite.
    #[error("{place} has a number that is not finite")]
    NotFinite { place: String },
    /// Directions in the side file do not span a frame.
    #[error("{place}: directions must not be zero or parallel")]
    Degenerate { place: &'static str },
    /// An angle is given for a slide, or a length for a hinge.
    #[error(
        "{place} names joint \"{joint}\" in the wrong unit: degrees are for hinges, millimetres for slides"
    )]
    Unit { place: String, joint: String },
    /// A number has to be positive.
    #[error("{what} is {value}: a positive number is needed")]
    NotPositive { what: String, value: f64 },
}
