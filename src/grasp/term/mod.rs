//! The terms of the grasp energy, one file each.
//!
//! A term adds forces at points of links, or torques at joints. The hand converts their sum to the derivative with respect
//! to the pose ([`Hand::pull_back`](crate::hand::Hand::pull_back)).

use nalgebra::Vector3;

use crate::grasp::layer::{Layer, NearSphere};
use crate::hand::{Hand, LinkId, PosedHand, Wrench};
use crate::object::Object;

mod compliance;
mod joint_limits;
mod pressing;
mod prior;
mod proximity;
mod reach;
mod self_penetration;

pub use compliance::LayerCompliance;
pub use joint_limits::JointLimits;
pub use pressing::Pressing;
pub use prior::Prior;
pub use proximity::Proximity;
pub use reach::Reach;
pub use self_penetration::SelfPenetration;
pub(crate) use self_penetration::for_each_overlap;

/// Input of a term.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The hand.
    pub hand: &'a Hand,
    /// The posed hand, object frame. Its surface points need not be posed.
    pub posed: &'a PosedHand,
    /// Joints, radians; metres for sliding joints.
    pub joints: &'a [f64],
    /// The object.
    pub object: &'a Object,
    /// Pairs of parts of the hand that may overlap.
    pub proximity: &'a Proximity,
    /// The elastic layer of the hand; empty if no term needs it.
    pub layer: &'a Layer,
    /// Its spheres that may touch the object, by ascending index.
    pub near_spheres: &'a [NearSphere],
    /// Length unit of arms and depths, metres.
    pub unit_m: f64,
}

/// Derivatives collected from the terms.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Forces {
    /// One wrench for each link.
    pub wrenches: Vec<Wrench>,
    /// Direct ∂E/∂θ of terms, for each joint.
    pub joints: Vec<f64>,
}

impl Forces {
    /// Sets everything to zero for this hand.
    pub fn reset(&mut self, hand: &Hand) {
        self.wrenches.clear();
        self.wrenches.resize(hand.links.len(), Wrench::default());
        self.joints.clear();
        self.joints.resize(hand.joints.len(), 0.0);
    }

    /// Adds the force ∂E/∂p at `point` of `link`.
    pub fn push(&mut self, link: LinkId, point: &Vector3<f64>, force: &Vector3<f64>) {
        self.wrenches[link.0].add(point, force);
    }
}

/// Inputs that a term depends on, in the order in which terms are listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The layer near the object, and penetration of the hand by itself.
    Depths,
    /// The hand alone.
    Pose,
}

/// A weighted, named part of the grasp energy.
pub trait Term: std::fmt::Debug + Send + Sync {
    /// Name in files and figures.
    fn name(&self) -> &'static str;

    /// Weight. A term of weight 0 is left out.
    fn weight(&self) -> f64;

    /// Inputs that the term depends on.
    fn stage(&self) -> Stage;

    /// Energy of this term; adds its derivative to `forces`.
    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64;
}

/// A hinge max(0, s) that is quadratic up to `rounding`, and its derivative.
pub(crate) fn rounded_hinge(s: f64, rounding: f64) -> (f64, f64) {
    if s <= 0.0 {
        (0.0, 0.0)
    } else if s < rounding {
        (0.5 * s * s / rounding, s / rounding)
    } else {
        (s - 0.5 * rounding, 1.0)
    }
}
