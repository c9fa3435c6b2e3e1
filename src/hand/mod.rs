//! The hand: a kinematic tree with surface points, posed in the object's frame.
//!
//! [`Hand::from_files`] derives everything a grasp needs from a URDF or MJCF description: contact candidates,
//! self-collision pairs, palm and digits, rest pose, prior and metric. A side file may override any of it. [`Hand::pose`]
//! places the hand, [`Hand::pull_back`] turns forces on its links into a gradient, and [`Hand::skin`] draws it.

mod blend;
mod capsule_decomposition;
mod derived;
mod description;
mod error;
mod files;
mod geometry;
mod hull;
mod inscribed;
mod kinematics;
mod loops;
mod mano;
mod mass;
mod mesh;
mod metric;
mod mirror;
mod mjcf;
mod model;
mod named;
mod plausibility;
mod prior;
mod region;
mod roles;
mod sampling;
mod self_pairs;
mod side_file;
mod skin;
mod solid;
mod sources;
mod surface;
mod urdf;
mod urdf_form;
mod virtual_wrist;
mod volar;

use nalgebra::{Matrix3, Vector3};
use std::ops::Range;
use std::sync::Arc;

use blend::Blend;
use geometry::LinkMesh;
use side_file::MetricEntry;
use solid::Parts;

use crate::space::Pose;

pub use error::HandError;
pub use files::{HandFile, HandFiles};
pub use inscribed::Ball;
pub use mass::LinkMass;
pub use named::HAND_NAMES;
pub use region::PatchSide;
pub use self_pairs::{SegmentPair, axis_distance, closest_points, rounded_closest_points};
pub use skin::{Skin, SkinVertex};
pub(crate) use solid::{Part, Solid};
pub use virtual_wrist::VirtualWrist;
pub(crate) use volar::volar_directions;

/// Number of a link in [`Hand::links`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub usize);

/// A rigid transform `p ↦ R p + t`, kept as a matrix because it is applied to hundreds of points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Rotation R.
    pub rotation: Matrix3<f64>,
    /// Translation t, metres.
    pub translation: Vector3<f64>,
}

impl Default for Frame {
    fn default() -> Self {
        Self {
            rotation: Matrix3::identity(),
            translation: Vector3::zeros(),
        }
    }
}

impl Frame {
    /// The transformed point.
    #[inline]
    pub fn point(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.translation
    }

    /// The transformed direction.
    #[inline]
    pub fn direction(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * direction
    }

    /// The point that the transform takes to `point`.
    #[inline]
    pub fn inverse_point(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(&(point - self.translation))
    }

    /// Greatest distance between the two images under `self` and `other` of any point of a ball, metres: that of the images
    /// of its centre plus the rotation about it.
    pub(crate) fn greatest_movement_m(
        &self,
        other: &Self,
        centre: &Vector3<f64>,
        radius_m: f64,
    ) -> f64 {
        let turn = self.rotation - other.rotation;
        let shift = turn * centre + (self.translation - other.translation);
        // The difference of two rotations stretches two directions by 2 sin(φ/2), and the third not at all.
        let stretch = (0.5 * turn.norm_squared()).sqrt();
        shift.norm() + stretch * radius_m
    }

    /// `self ∘ inner`: first `inner`, then `self`.
    #[inline]
    #[must_use]
    pub fn compose(&self, inner: &Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            translation: self.point(&inner.translation),
        }
    }
}

/// A rigid body of the hand. Links are in depth-first order: parents before children, each subtree contiguous.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Name in the description file.
    pub name: String,
    /// The parent link; `None` for the root only.
    pub parent: Option<LinkId>,
    /// Fixed transform from this link's frame at joint angle zero to the parent's frame.
    pub parent_from_link: Frame,
    /// How a joint moves it relative to its parent; `None` if it is fixed or on a ball joint.
    pub motion: Option<Motion>,
    /// Name of that joint in the description file, also if the joint follows another one; empty if there is none.
    pub joint_name: String,
    /// Number of its ball joint (MANO), which turns about the origin of the link's frame.
    pub ball: Option<usize>,
    /// Digit this link belongs to: 0 = palm, 1.. = digits (1 = thumb, 2 = index … 5 = little on a human hand).
    pub digit: usize,
}

impl Link {
    /// Whether it moves relative to its parent.
    pub fn moves(&self) -> bool {
        self.motion.is_some() || self.ball.is_some()
    }
}

/// Kind of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis; its coordinate is an angle in radians.
    Hinge,
    /// Slides along its axis; its coordinate is a length in metres.
    Slide,
}

impl JointKind {
    /// The factor that makes coordinates of hinges and slides comparable: radians per radian, or radians per metre at a
    /// lever of 100 mm, the length of a finger.
    pub fn radians_per_unit(self) -> f64 {
        match self {
            Self::Hinge => 1.0,
            Self::Slide => 10.0,
        }
    }
}

/// How a link moves relative to its parent: by the displacement `ratio · q + offset`, with q the coordinate of joint
/// `joint`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Index into [`Hand::joints`]: the link's own joint, or the joint that it follows.
    pub joint: usize,
    /// Hinge or slide.
    pub kind: JointKind,
    /// Unit axis in the frame of the link that moves; the axis of a hinge passes through that frame's origin.
    pub axis: Vector3<f64>,
    /// Displacement of the link per displacement of the joint; 1 unless it follows another joint.
    pub ratio: f64,
    /// Displacement at coordinate zero, radians or metres; 0 unless the description says otherwise.
    pub offset: f64,
}

/// A joint, which is one coordinate of the hand. A joint that follows another one is not a coordinate, see [`Motion`].
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name in the description file.
    pub name: String,
    /// The link it moves; others may follow.
    pub link: LinkId,
    /// Hinge or slide.
    pub kind: JointKind,
    /// Lower and upper limit, radians; metres for sliding joints; ±π if the joint wraps.
    pub limits: [f64; 2],
    /// Whether it turns without limits, so that q and q + 2π are the same pose.
    pub wraps: bool,
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
    /// The area it represents, m².
    pub area_m2: f64,
    /// Index into [`Hand::regions`].
    pub region: usize,
}

/// Gaussian prior on joint angles: ½ (q − q₀)ᵀ Λ (q − q₀).
#[derive(Debug, Clone, PartialEq)]
pub struct PosePrior {
    /// Rest pose q₀, radians; metres for sliding joints.
    pub rest: Vec<f64>,
    /// Precision Λ, row-major k × k, one over the units of the two joints.
    pub precision: Vec<f64>,
    /// Standard deviation of each joint, √(Λ⁻¹)ᵢᵢ, radians; metres for sliding joints.
    pub deviations: Vec<f64>,
}

/// A kinematic tree with limits, geometry, surface points and a rest pose.
///
/// # Examples
/// The human hand in its rest pose.
///
/// ```
/// use landscape::hand::{Hand, PosedHand};
///
/// let hand = Hand::human();
/// let mut posed = PosedHand::default();
/// hand.pose(&hand.rest_coordinates(), &mut posed);
/// assert_eq!((hand.joints.len(), posed.points.len()), (22, 773));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Hand {
    /// Name, for instance `human`.
    pub name: String,
    /// Links, depth first, parents before children.
    pub links: Vec<Link>,
    /// Joints, in the order of the joint coordinates (the order of the description file).
    pub joints: Vec<Joint>,
    /// Capsules of the geometry, sorted by link.
    pub capsules: Vec<Capsule>,
    /// Pairs of capsules that may touch each other and are checked for self-penetration.
    pub self_pairs: Vec<[usize; 2]>,
    /// Surface points sorted by link.
    pub surface: Vec<SurfacePoint>,
    /// Names of the digits, indexed by [`Link::digit`]: `palm`, then one name per digit.
    pub digits: Vec<String>,
    /// Names of the regions that surface points are tagged with: `palm.thenar`, `index.distal.pad`, …; the name of the link
    /// if the hand names no region.
    pub regions: Vec<String>,
    /// Rest pose and prior.
    pub prior: PosePrior,
    /// Centre and directions of the palm's grasping side, root frame, for start poses.
    pub palm: PalmFrame,
    /// What was left out of the description or changed, one sentence each.
    pub notes: Vec<String>,
    /// Joints of the description that move the whole hand, for which the pose stands; `None` if there are none, or if the
    /// hand is the mirror image of the described one.
    pub virtual_wrist: Option<VirtualWrist>,
    /// Meshes to draw; a hand without any is drawn with a skin over its capsules.
    meshes: Vec<LinkMesh>,
    /// For each capsule, whether it is geometry of the description rather than the filling of a mesh or a box.
    exact: Vec<bool>,
    /// For each link: whether contacts on it are forbidden.
    untouching: Vec<bool>,
    /// The first link of the rigid body that the digits are attached to. Links not below it are wrist and forearm.
    palm_link: LinkId,
    /// Entries of the side file for the metric.
    metric: MetricEntry,
    /// The bending surface and the ball joints of MANO; `None` if surface points are fixed to links.
    blend: Option<Arc<Blend>>,
    /// Joints at which the skin is built, radians; metres for sliding joints. The fingers are apart.
    cast: Vec<f64>,
    /// The solid parts for measuring depths.
    parts: Parts,
    /// The balls that fill the meshes.
    inscribed: inscribed::Cache,
    /// For each link, one past the last link of its subtree.
    subtree_ends: Vec<usize>,
    /// For each link, its surface points.
    link_points: Vec<Range<usize>>,
}

/// Position and directions of the palm, in the root link's frame with the joints at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PalmFrame {
    /// Centre of the palm's volar surface, metres.
    pub centre: Vector3<f64>,
    /// Unit normal out of the palm, toward a grasped object.
    pub volar: Vector3<f64>,
    /// Unit vector from the palm to the fingertips, perpendicular to `volar`.
    pub distal: Vector3<f64>,
    /// Distance from the centre along `distal` to the point that faces the object at the start of a chain, metres. The
    /// point lies under the fingers of a hand and in front of the palm of a gripper.
    pub faced_m: f64,
}

/// How coordinates of MANO turn its ball joints, see [`Hand::bending`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bending<'a> {
    /// Angles of the ball joints at coordinates zero, three per joint, radians.
    pub offset_rad: &'a [f64],
    /// Derivatives of these angles: those by the first coordinate, then by the second, ….
    pub map: &'a [f64],
}

/// A hand in a pose; everything is in the object's frame.
#[derive(Debug, Clone, Default)]
pub struct PosedHand {
    /// Frame of each link.
    pub object_from_link: Vec<Frame>,
    /// Surface points, metres, in the order of [`Hand::surface`].
    pub points: Vec<Vector3<f64>>,
    /// Ends of the axis of each capsule, metres, in the order of [`Hand::capsules`].
    pub capsules: Vec<[Vector3<f64>; 2]>,
    /// Angles of ball joints, three per joint, radians.
    angles_rad: Vec<f64>,
    /// Entries of R − I of the rotations R of ball joints, in row-major order.
    entries: Vec<f64>,
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

impl Wrench {
    /// Adds the gradient `g` at point `p` (object frame).
    #[inline]
    pub fn add(&mut self, p: &Vector3<f64>, g: &Vector3<f64>) {
        self.force += g;
        self.moment += p.cross(g);
    }
}

impl Hand {
    /// The hand described by some files: a URDF or MJCF description, recognised by its root element, and the files it
    /// refers to.
    ///
    /// Joints may be hinges, slides, fixed, or follow others. Geometry may be spheres, capsules, cylinders, boxes,
    /// ellipsoids and meshes; a mesh is replaced by its convex hull, or by those of its pieces. The collision geometry is used.
    /// Visual geometry counts if the hand has no other; beside collision geometry, only visual meshes of rigid bodies without
    /// any count. Joint coordinates have the order of the joints in the file. [`Hand::notes`]
    /// lists what was left out.
    ///
    /// # Errors
    /// If a text cannot be read, the joints do not form one tree, or a joint or a link's geometry is of an unsupported
    /// kind. The message names it, with its line where the form of the document is wrong.
    pub fn from_files(files: &HandFiles) -> Result<Self, HandError> {
        description::read(files, files)
    }

    /// The same hand with only every `stride`-th surface point, each representing more area. A MANO hand loses its skin,
    /// because its triangles join all points.
    ///
    /// # Panics
    /// If `stride` is 0.
    #[must_use]
    pub fn thinned(&self, stride: usize) -> Self {
        let mut hand = self.clone();
        hand.surface = self.surface.iter().step_by(stride).copied().collect();
        for point in &mut hand.surface {
            point.area_m2 *= stride as f64;
        }
        if let Some(blend) = &self.blend {
            let mut thinned = (**blend).clone();
            thinned.vertices = blend.vertices.iter().step_by(stride).cloned().collect();
            if stride > 1 {
                thinned.triangles.clear();
            }
            hand.blend = Some(Arc::new(thinned));
        }
        hand.index_surface();
        hand
    }

    /// Whether surface points are carried by several links (MANO).
    pub fn bends(&self) -> bool {
        self.blend.is_some()
    }

    /// The angles of the ball joints, for programs that pose the hand themselves; `None` if it has none.
    pub fn bending(&self) -> Option<Bending<'_>> {
        let blend = self.blend.as_ref()?;
        Some(Bending {
            offset_rad: blend.offset_rad.as_slice(),
            map: blend.map.as_slice(),
        })
    }

    /// Finds each link's surface points, which are sorted by link.
    fn index_surface(&mut self) {
        let first = |l: usize| self.surface.partition_point(|point| point.link.0 < l);
        self.link_points = (0..self.links.len())
            .map(|l| first(l)..first(l + 1))
            .collect();
    }

    /// Whether a link is wrist or forearm: it belongs to no digit, and it is neither the body that the digits are attached
    /// to nor below it. Such a link keeps its capsules for collisions but has no surface points.
    pub fn is_arm(&self, link: LinkId) -> bool {
        !(self.palm_link.0..self.subtree_ends[self.palm_link.0]).contains(&link.0)
    }

    /// The frame of the outermost body if the root of the hand is the world, which is so if that body is displaced from the
    /// origin of the description; `None` if the root is the outermost body.
    pub fn root_offset(&self) -> Option<Frame> {
        let [root, body, ..] = self.links.as_slice() else {
            return None;
        };
        let fixed = root.name == "world" && body.parent == Some(LinkId(0)) && body.motion.is_none();
        fixed.then_some(body.parent_from_link)
    }

    /// The palm's frame at these joint angles, root frame. It differs from [`Hand::palm`] only if the hand has a wrist.
    ///
    /// # Panics
    /// If there is not one angle per joint.
    pub fn palm_at(&self, joints: &[f64]) -> PalmFrame {
        if self.palm_link.0 == 0 {
            return self.palm;
        }
        let [rest, moved] = [&self.prior.rest, joints].map(|joints| {
            let mut posed = PosedHand::default();
            self.pose_links(&Pose::at_origin(joints), &mut posed);
            posed.object_from_link[self.palm_link.0]
        });
        let turned = |v: &Vector3<f64>| moved.direction(&rest.rotation.tr_mul(v));
        PalmFrame {
            centre: moved.point(&rest.inverse_point(&self.palm.centre)),
            volar: turned(&self.palm.volar),
            distal: turned(&self.palm.distal),
            faced_m: self.palm.faced_m,
        }
    }

    /// The link that carries the palm, and the palm's frame in it, which does not depend on the joints: the origin is the
    /// centre of the palm, x points to the fingertips, z out of the palm.
    pub fn palm_on_link(&self) -> (LinkId, Frame) {
        let mut rest = PosedHand::default();
        self.pose_links(&Pose::at_origin(&self.prior.rest), &mut rest);
        let link = &rest.object_from_link[self.palm_link.0];
        let PalmFrame { volar, distal, .. } = self.palm;
        let axes = Matrix3::from_columns(&[distal, volar.cross(&distal), volar]);
        let frame = Frame {
            rotation: link.rotation.tr_mul(&axes),
            translation: link.inverse_point(&self.palm.centre),
        };
        (self.palm_link, frame)
    }

    /// Whether a surface point may be a contact: the side file may forbid links.
    pub fn may_touch(&self, point: &SurfacePoint) -> bool {
        self.link_may_touch(point.link)
    }

    /// Whether a link may carry contacts: the side file may forbid it.
    pub fn link_may_touch(&self, link: LinkId) -> bool {
        !self.untouching[link.0]
    }

    /// Whether there is a thumb. It is the first digit then.
    pub fn has_thumb(&self) -> bool {
        self.digits.get(1).is_some_and(|name| name == "thumb")
    }

    /// Whether no link beyond this one has capsules.
    pub fn is_last_link(&self, link: LinkId) -> bool {
        let beyond = link.0 + 1..self.subtree_ends[link.0];
        !self.capsules.iter().any(|c| beyond.contains(&c.link.0))
    }

    /// Whether a surface point lies on the tip or pad of the last link of a digit, or anywhere on that link if the hand
    /// names no pads.
    pub fn is_fingertip(&self, point: &SurfacePoint) -> bool {
        let last = self.is_last_link(point.link);
        let region = &self.regions[point.region];
        let behind = [".back", ".radial", ".ulnar"]
            .iter()
            .any(|side| region.ends_with(side));
        self.links[point.link.0].digit > 0 && last && !behind
    }

    /// Number of the link with this name.
    pub fn link(&self, name: &str) -> Option<LinkId> {
        self.links
            .iter()
            .position(|link| link.name == name)
            .map(LinkId)
    }

    /// Number of the joint with this name.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Coordinates `[t, q(wxyz), joints]` of the rest pose with the root frame at the object's origin.
    pub fn rest_coordinates(&self) -> Vec<f64> {
        Pose::at_origin(&self.prior.rest).into()
    }
}
