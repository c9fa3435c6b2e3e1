//! The terms of the grasp energy, one file each.
//!
//! A term adds forces at points of links, or torques at joints. The hand converts their sum to the derivative with respect
//! to the pose ([`Hand::pull_back`](crate::hand::Hand::pull_back)).

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::grasp::layer::{Layer, NearSphere};
use crate::hand::{Hand, LinkId, PosedHand, Wrench};
use crate::object::Object;

mod alignment;
mod compliance;
mod distance;
mod force_closure;
mod hand_in_object;
mod joint_limits;
mod object_in_hand;
mod pressing;
mod prior;
mod proximity;
mod reach;
mod self_penetration;

pub use alignment::Alignment;
pub use compliance::LayerCompliance;
pub use distance::Distance;
pub(crate) use force_closure::point_contact;
pub use force_closure::{ForceClosure, Rank, RankForm};
pub use hand_in_object::HandInObject;
pub use joint_limits::JointLimits;
pub use object_in_hand::ObjectInHand;
pub use pressing::Pressing;
pub use prior::{Prior, PriorForm};
pub use proximity::Proximity;
pub use reach::Reach;
pub use self_penetration::SelfPenetration;
pub(crate) use self_penetration::for_each_overlap;

/// A contact: a surface point of the hand with the object's distance and derivatives there (object frame).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Index into [`Hand::surface`].
    pub index: u32,
    /// The link of the point.
    pub link: LinkId,
    /// Position, metres.
    pub point: Vector3<f64>,
    /// Signed distance to the object, metres.
    pub distance_m: f64,
    /// Gradient of the signed distance.
    pub gradient: Vector3<f64>,
    /// Hessian of the signed distance, 1/m.
    pub hessian: Matrix3<f64>,
}

/// A surface point of the hand near the object, with the object's distance there (object frame).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearPoint {
    /// Index into [`Hand::surface`].
    pub index: u32,
    /// Position, metres.
    pub point: Vector3<f64>,
    /// Signed distance to the object, metres.
    pub distance_m: f64,
    /// Gradient of the signed distance, if known; it is always known at or below the required clearance.
    pub gradient: Option<Vector3<f64>>,
}

/// Input of a term.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The hand.
    pub hand: &'a Hand,
    /// The posed hand, object frame. Of its surface points only those in `near` and `contacts` are posed.
    pub posed: &'a PosedHand,
    /// Joint angles.
    pub joints_rad: &'a [f64],
    /// The object.
    pub object: &'a Object,
    /// Surface points that may be at or below the required clearance, by ascending index.
    pub near: &'a [NearPoint],
    /// Pairs of other parts that may overlap.
    pub proximity: &'a Proximity,
    /// The contact set.
    pub contacts: &'a [Contact],
    /// The elastic layer of the hand; empty if no term needs it.
    pub layer: &'a Layer,
    /// Its spheres that may touch the object, by ascending index.
    pub near_spheres: &'a [NearSphere],
    /// Length unit of arms and depths, metres.
    pub unit_m: f64,
    /// Factor on the weight of contact distances (1, except during the ramp of a synthesis).
    pub distance_factor: f64,
}

/// Derivatives collected from the terms.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Forces {
    /// One wrench for each link.
    pub wrenches: Vec<Wrench>,
    /// Direct ∂E/∂θ of terms, for each joint.
    pub joints: Vec<f64>,
    /// Whether surface points depend on several links, so that their forces are stored by point until they are gathered.
    pub by_point: bool,
    /// ∂E/∂p by index of the surface point, if `by_point`.
    pub points: Vec<(u32, Vector3<f64>)>,
    /// Derivatives by rotation of the normals of surface points, if `by_point`.
    pub normals: Vec<(u32, Vector3<f64>)>,
}

impl Forces {
    /// Sets everything to zero for this hand.
    pub fn reset(&mut self, hand: &Hand) {
        self.wrenches.clear();
        self.wrenches.resize(hand.links.len(), Wrench::default());
        self.joints.clear();
        self.joints.resize(hand.joints.len(), 0.0);
        self.by_point = hand.bends();
        self.points.clear();
        self.normals.clear();
    }

    /// Multiplies everything collected so far.
    pub fn scale(&mut self, factor: f64) {
        for wrench in &mut self.wrenches {
            wrench.force *= factor;
            wrench.moment *= factor;
        }
        for force in &mut self.joints {
            *force *= factor;
        }
        for (_, force) in self.points.iter_mut().chain(&mut self.normals) {
            *force *= factor;
        }
    }

    /// Adds the force ∂E/∂p at `point` of `link`.
    pub fn push(&mut self, link: LinkId, point: &Vector3<f64>, force: &Vector3<f64>) {
        self.wrenches[link.0].add(point, force);
    }

    /// Adds the force ∂E/∂p at surface point `index` of `link`, which is at `point`.
    pub fn push_surface(
        &mut self,
        index: u32,
        link: LinkId,
        point: &Vector3<f64>,
        force: &Vector3<f64>,
    ) {
        if self.by_point {
            self.points.push((index, *force));
        } else {
            self.push(link, point, force);
        }
    }

    /// Adds the derivative of E by rotation of the normal of surface point `index` of `link`.
    pub fn turn_surface(&mut self, index: u32, link: LinkId, moment: &Vector3<f64>) {
        if self.by_point {
            self.normals.push((index, *moment));
        } else {
            self.wrenches[link.0].moment += moment;
        }
    }

    /// Moves the forces on surface points to the links.
    pub fn gather(&mut self, hand: &Hand, posed: &PosedHand) {
        hand.gather(posed, &self.points, &self.normals, &mut self.wrenches);
        self.points.clear();
        self.normals.clear();
    }
}

/// Inputs that a term depends on, in the order in which terms are listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The contact set.
    Contacts,
    /// Penetration of the object by the hand, of the hand by the object, and of the hand by itself.
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

/// Function from a length to an energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NormForm {
    /// √(s² + r²) − r: the norm, rounded within r.
    Norm,
    /// s² without rounding, as in the code of Liu et al. (2021), whose text has the norm.
    Square,
}

impl NormForm {
    /// Energy of a length s and its derivative.
    pub fn apply(self, s: f64, rounding: f64) -> (f64, f64) {
        match self {
            Self::Norm => rounded_norm(s, rounding),
            Self::Square => (s * s, 2.0 * s),
        }
    }

    /// Greatest length that costs at most `energy`.
    pub fn reach(self, energy: f64, rounding: f64) -> f64 {
        let energy = energy.max(0.0);
        match self {
            Self::Norm => {
                let total = energy + rounding;
                (total * total - rounding * rounding).max(0.0).sqrt()
            }
            Self::Square => energy.sqrt(),
        }
    }
}

/// √(s² + r²) − r and its derivative by s: a norm rounded within `rounding`.
pub(crate) fn rounded_norm(s: f64, rounding: f64) -> (f64, f64) {
    let root = (s * s + rounding * rounding).sqrt();
    if root == 0.0 {
        return (0.0, 0.0);
    }
    (root - rounding, s / root)
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
