//! What can be wrong with a description.

use crate::limits::Beyond;

/// Why a description is not a hand.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HandError {
    /// A file that cannot be read.
    #[error("cannot read {}: {problem}", path.display())]
    File {
        /// The file.
        path: std::path::PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A file of MANO that does not do.
    #[error("{file} {problem}")]
    Mano {
        /// The file.
        file: String,
        /// What is wrong.
        problem: String,
    },
    /// No description at all.
    #[error("there is no description of a hand")]
    NoDescription,
    /// An element of an MJCF document.
    #[error("{place}: {problem}")]
    Mjcf {
        /// Element, file and line.
        place: String,
        /// What is wrong with it.
        problem: String,
    },
    /// No hand of that name comes with the program.
    #[error("there is no hand \"{name}\" ({})", super::HAND_NAMES.join(", "))]
    NoSuchHand {
        /// The name.
        name: String,
    },
    /// The description is something else than XML: a mesh, a table.
    #[error(
        "this is no description of a hand, which is a URDF or MJCF file (XML) or a MANO file (.npz)"
    )]
    NotADescription,
    /// The description is not XML, or not such as anybody writes.
    #[error("the URDF cannot be read: {0}")]
    Xml(String),
    /// The description is not a URDF document.
    #[error("the URDF cannot be read: {0}")]
    Urdf(#[from] urdf_rs::UrdfError),
    /// The side file is not what it should be.
    #[error("the side file cannot be read: {0}")]
    SideFile(#[from] serde_json::Error),
    /// A name in the side file or a joint that the description does not have.
    #[error("{place} names {kind} \"{name}\", which the description does not have")]
    Unknown {
        /// Where the name stands.
        place: String,
        /// `link` or `joint`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// Two links or two joints of one name.
    #[error("there are two {kind}s named \"{name}\"")]
    Twice {
        /// `link` or `joint`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A link hangs on two joints.
    #[error("link \"{link}\" is the child of two joints, \"{first}\" and \"{second}\": not a tree")]
    TwoParents {
        /// The link.
        link: String,
        /// One joint.
        first: String,
        /// The other joint.
        second: String,
    },
    /// No root, or several.
    #[error("a hand has one link without a parent; this description has {}: {}", roots.len(), roots.join(", "))]
    Roots {
        /// Links without a parent.
        roots: Vec<String>,
    },
    /// Links in a ring.
    #[error("link \"{link}\" is not connected to the root: its joints form a ring")]
    Ring {
        /// One of the links.
        link: String,
    },
    /// A joint of a kind that is not handled.
    #[error(
        "joint \"{joint}\" is {kind}; only revolute, continuous, prismatic and fixed joints are handled"
    )]
    UnsupportedJoint {
        /// The joint.
        joint: String,
        /// Its type.
        kind: &'static str,
    },
    /// Joints that follow each other.
    #[error("joint \"{joint}\" follows others in a circle")]
    Circle {
        /// One of them.
        joint: String,
    },
    /// A slide without limits.
    #[error("joint \"{joint}\" slides without limits: give it a range")]
    Endless {
        /// The joint.
        joint: String,
    },
    /// Limits that leave no range.
    #[error("joint \"{joint}\" may move from {lower} to {upper}: that is no range")]
    EmptyRange {
        /// The joint.
        joint: String,
        /// Lower limit, radians.
        lower: f64,
        /// Upper limit, radians.
        upper: f64,
    },
    /// A joint axis of no direction.
    #[error("joint \"{joint}\" has an axis of length zero")]
    NoAxis {
        /// The joint.
        joint: String,
    },
    /// Nothing moves.
    #[error("the description has no movable joint")]
    NoJoints,
    /// A mesh that cannot be read.
    #[error(
        "link \"{link}\", {problem} (or give it capsules in the side file: \"capsules\": {{\"{link}\": …}})"
    )]
    Mesh {
        /// The link.
        link: String,
        /// The mesh and what is wrong with it.
        problem: String,
    },
    /// A number that nobody means.
    #[error("{place}: {beyond}")]
    Beyond {
        /// Element and what is told of it.
        place: String,
        /// The number and its limit.
        beyond: Beyond,
    },
    /// An orientation whose numbers are too large or too small to turn by.
    #[error(
        "link \"{link}\": an orientation is no rotation: its numbers are too large or too small"
    )]
    NoRotation {
        /// The link.
        link: String,
    },
    /// Far more than a hand has.
    #[error("the description has {count} {kind}, of at most {most}: {advice}")]
    TooMany {
        /// Of what.
        kind: &'static str,
        /// How many.
        count: usize,
        /// How many there may be.
        most: usize,
        /// What to do.
        advice: &'static str,
    },
    /// No geometry at all.
    #[error("no link has geometry: there is nothing to touch with")]
    NoGeometry,
    /// A number that is not finite.
    #[error("{place} has a number that is not finite")]
    NotFinite {
        /// Where.
        place: String,
    },
    /// Directions of the side file that do not span a frame.
    #[error("{place}: directions must not be zero or parallel")]
    Degenerate {
        /// Where.
        place: &'static str,
    },
    /// An angle for a slide or a length for a hinge.
    #[error(
        "{place} names joint \"{joint}\", whose unit it is not: degrees are for hinges, millimetres for slides"
    )]
    Unit {
        /// Where.
        place: String,
        /// The joint.
        joint: String,
    },
    /// A number that has to be positive.
    #[error("{what} is {value}: a positive number is needed")]
    NotPositive {
        /// What.
        what: String,
        /// The number.
        value: f64,
    },
}
