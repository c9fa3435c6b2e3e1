//! The hand: a kinematic tree with surface points, posed in the object's frame.

use nalgebra::{Isometry3, Vector3};

/// Number of a link in [`Hand::links`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub usize);

/// A rigid body of the hand. Parents come before their children.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Name in the description file.
    pub name: String,
    /// The link this one hangs on; `None` for the root only.
    pub parent: Option<LinkId>,
    /// Fixed transform from the parent's frame to this link's frame at joint angle zero.
    pub parent_from_link: Isometry3<f64>,
    /// Index of the revolute joint between parent and this link in [`Hand::joints`]; `None` if fixed.
    pub joint: Option<usize>,
    /// Digit this link belongs to: 0 = palm, 1.. = digits (1 = thumb, 2 = index … 5 = little on a human hand).
    pub digit: usize,
}

/// A revolute joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name in the description file.
    pub name: String,
    /// Unit axis in the frame of the link the joint moves.
    pub axis: Vector3<f64>,
    /// Lower and upper limit, radians.
    pub limits_rad: [f64; 2],
}

/// A capsule of a link's geometry, link frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capsule {
    /// The link it is fixed to.
    pub link: LinkId,
    /// First end of the axis, metres.
    pub a: Vector3<f64>,
    /// Second end of the axis, metres.
    pub b: Vector3<f64>,
    /// Radius, metres.
    pub radius_m: f64,
}

/// A point of the hand's surface, link frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The link it is fixed to.
    pub link: LinkId,
    /// Position, metres.
    pub point: Vector3<f64>,
    /// Outward unit normal.
    pub normal: Vector3<f64>,
    /// The area it stands for, m².
    pub area_m2: f64,
    /// Index into [`Hand::regions`].
    pub region: usize,
}

/// Gaussian prior on joint angles: ½ (q − q₀)ᵀ Λ (q − q₀).
#[derive(Debug, Clone, PartialEq)]
pub struct PosePrior {
    /// Rest pose q₀, radians.
    pub rest_rad: Vec<f64>,
    /// Precision Λ, row-major k × k, 1/rad².
    pub precision: Vec<f64>,
}

/// A kinematic tree with limits, geometry, surface points and a rest pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Hand {
    /// Name, for instance `human`.
    pub name: String,
    /// Links, parents first.
    pub links: Vec<Link>,
    /// Joints, in the order of the joint coordinates.
    pub joints: Vec<Joint>,
    /// Geometry.
    pub capsules: Vec<Capsule>,
    /// Pairs of capsules that may touch each other and are checked for self-penetration.
    pub self_pairs: Vec<[usize; 2]>,
    /// Surface points sorted by link.
    pub surface: Vec<SurfacePoint>,
    /// Names of the regions that surface points are tagged with.
    pub regions: Vec<String>,
    /// Rest pose and prior.
    pub prior: PosePrior,
    /// Outward volar (palm) direction and centre of the palm's grasping side, root frame, for start poses.
    pub palm: PalmFrame,
}

/// Where the palm is and what it faces, in the root link's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PalmFrame {
    /// Centre of the palm's volar surface, metres.
    pub centre: Vector3<f64>,
    /// Unit normal pointing out of the palm (toward what it grasps).
    pub volar: Vector3<f64>,
    /// Unit vector from the palm to the fingertips.
    pub distal: Vector3<f64>,
}

/// A hand in a pose: everything in the object's frame.
#[derive(Debug, Clone, Default)]
pub struct PosedHand {
    /// Frame of each link.
    pub object_from_link: Vec<Isometry3<f64>>,
    /// Surface points, metres, in the order of [`Hand::surface`].
    pub points: Vec<Vector3<f64>>,
}

/// A generalised force on a rigid link as the gradient of an energy: Σ g and Σ p × g over points p (object frame)
/// with ∂E/∂p = g.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wrench {
    /// Σ g.
    pub force: Vector3<f64>,
    /// Σ p × g about the object's origin.
    pub moment: Vector3<f64>,
}
