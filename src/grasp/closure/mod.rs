//! Tests of contacts without hand or object: exact force closure, contact forces, and the Ferrari–Canny ε.
//!
//! | question | function |
//! |---|---|
//! | what wrench remains when all push equally along their normals | [`net_wrench`] |
//! | how much friction is needed for balance | [`least_friction`] |
//! | do the contacts resist any wrench at friction μ | [`is_force_closure`] |
//! | which forces balance | [`contact_forces`] |
//! | how well do they resist the worst wrench | [`epsilon()`] |
//!
//! # Examples
//! Three fingers around a ball at 120° from each other: their normals balance, so they need no friction.
//!
//! ```
//! use landscape::grasp::closure::{PointContact, is_force_closure, least_friction, net_wrench};
//! use nalgebra::Vector3;
//!
//! let contacts = [0.0_f64, 1.0, 2.0].map(|third| {
//!     let (sine, cosine) = (third * std::f64::consts::TAU / 3.0).sin_cos();
//!     let arm = Vector3::new(cosine, sine, 0.0);
//!     PointContact { arm, inward_normal: -arm }
//! });
//! assert!(net_wrench(&contacts) < 1e-12 && least_friction(&contacts) < 1e-9);
//! assert!(is_force_closure(&contacts, 0.5));
//! ```

use std::borrow::Cow;

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

mod cone_programme;
mod epsilon;
mod expanding;
mod friction;
mod triangle;

pub use cone_programme::{ContactForces, contact_forces};
pub use epsilon::{Epsilon, EpsilonSettings, epsilon, epsilon_of_wrenches};
pub use friction::{LARGEST_FRICTION, is_force_closure, least_friction};

/// A point contact: its position and direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointContact {
    /// Arm from the torque centre, divided by the length unit of torques.
    pub arm: Vector3<f64>,
    /// Inward unit normal: the direction in which the contact pushes the object.
    pub inward_normal: Vector3<f64>,
}

impl PointContact {
    /// Wrench (force, torque) of a unit normal force at this contact.
    pub fn wrench(&self) -> Vector6<f64> {
        self.wrench_of(&self.inward_normal)
    }

    fn is_finite(&self) -> bool {
        self.arm
            .iter()
            .chain(&self.inward_normal)
            .all(|x| x.is_finite())
    }

    /// Wrench (force, torque) of `force` at this contact.
    pub fn wrench_of(&self, force: &Vector3<f64>) -> Vector6<f64> {
        let torque = self.arm.cross(force);
        Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
    }
}

/// ‖Gc‖₂, the net wrench when every contact pushes with a unit force along its normal.
///
/// ```text
/// G = [I … I; [x₁]ₓ … [xₙ]ₓ]  (6 × 3n),   c = (c₁, …, cₙ)
/// ```
///
/// Dimensionless, zero when the normals alone balance. Liu et al. (2021), Eq. 6.
pub fn net_wrench(contacts: &[PointContact]) -> f64 {
    contacts
        .iter()
        .map(PointContact::wrench)
        .sum::<Vector6<f64>>()
        .norm()
}

/// Smallest eigenvalue of `GGᵀ`, which is positive if the contacts' forces span all six wrench directions. For two point
/// contacts it is zero, because no force turns the object about the line through them.
pub fn grasp_matrix_rank_margin(contacts: &[PointContact]) -> f64 {
    let mut moment = Matrix3::zeros();
    let mut inertia = Matrix3::zeros();
    for contact in contacts {
        let cross = contact.arm.cross_matrix();
        moment += cross;
        inertia += cross * cross.transpose();
    }
    let mut gram = Matrix6::zeros();
    gram.fixed_view_mut::<3, 3>(0, 0)
        .copy_from(&(Matrix3::identity() * contacts.len() as f64));
    gram.fixed_view_mut::<3, 3>(3, 0).copy_from(&moment);
    gram.fixed_view_mut::<3, 3>(0, 3)
        .copy_from(&moment.transpose());
    gram.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
    gram.symmetric_eigenvalues().min()
}

/// The ε of the rank condition `GGᵀ` ≻ εI of force closure (Liu et al. 2021, Eq. 3, with arms of order one).
pub const RANK_EPSILON: f64 = 1e-4;

/// Two unit vectors perpendicular to a unit vector and to each other.
fn tangents_of(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let mut axis = Vector3::zeros();
    axis[normal.iamin()] = 1.0;
    let first = normal.cross(&axis).normalize();
    [first, normal.cross(&first)]
}

/// Numbers are not scaled if the largest is within this factor of one, since solvers scale them.
const MODERATE: f64 = 1e6;

/// Divisor that brings numbers to order one: an exact power of two, or one if they are moderate, zero, or not finite.
fn excess(numbers: impl Iterator<Item = f64>) -> f64 {
    let largest = numbers.fold(0.0, |largest: f64, number| largest.max(number.abs()));
    if largest == 0.0 || (MODERATE.recip()..=MODERATE).contains(&largest) {
        return 1.0;
    }
    let power = f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits());
    if power.is_finite() {
        power.max(f64::MIN_POSITIVE)
    } else {
        1.0
    }
}

/// The contacts with arms above 10⁶ scaled to order one. Gf = 0 does not depend on the unit of torque.
fn with_moderate_arms(contacts: &[PointContact]) -> Cow<'_, [PointContact]> {
    let excess = excess(
        contacts
            .iter()
            .flat_map(|contact| contact.arm.iter().copied()),
    );
    if excess <= 1.0 {
        return Cow::Borrowed(contacts);
    }
    contacts
        .iter()
        .map(|contact| PointContact {
            arm: contact.arm / excess,
            ..*contact
        })
        .collect()
}
