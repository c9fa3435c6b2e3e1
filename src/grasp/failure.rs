//! Two known failures of relaxed force closure with penetration measured at points (Liu et al. 2021, Fig. 11): all contacts
//! lie in one concavity, or thin parts of the object pass between the hand's surface points.

use nalgebra::Vector3;

use super::depth::object_inside_hand_m;
use crate::hand::{Hand, PosedHand};
use crate::mesh::ExactMesh;

/// Depth above which a part of the object inside the hand passes through it, metres.
pub const SWALLOWED_M: f64 = 0.004;

/// Greatest depth of a surface point of the hand that the strict filter accepts, metres.
const UNSEEN_M: f64 = 0.002;

/// Greatest depth in the solid of a line of sight that counts as free, metres.
const GRAZING_M: f64 = 1e-4;
/// Least and greatest step along a line of sight, metres.
const STEP_M: [f64; 2] = [2.5e-4, 5e-3];

/// Whether all pairs of these surface points can see each other outside the solid.
///
/// On a convex solid no two points can, except very close neighbours. Points that see each other *and* push against each
/// other lie in one concavity, such as the inside of a bowl, a mug or a handle.
pub fn in_one_concavity(exact: &ExactMesh, points: &[Vector3<f64>]) -> bool {
    points.iter().enumerate().all(|(index, point)| {
        points[..index]
            .iter()
            .all(|other| sees(exact, point, other))
    })
}

/// Whether the straight line between two points stays outside the solid.
pub fn sees(exact: &ExactMesh, from: &Vector3<f64>, to: &Vector3<f64>) -> bool {
    let line = to - from;
    let length = line.norm();
    let mut along = 0.0;
    while along < length {
        let distance = exact.distance(&(from + line * (along / length)));
        if distance < -GRAZING_M {
            return false;
        }
        // The signed distance is a safe step.
        along += distance.clamp(STEP_M[0], STEP_M[1]);
    }
    true
}

/// Depth of the deepest surface point of the hand inside the object, metres; 0 if none is inside.
pub fn points_inside_object_m(exact: &ExactMesh, posed: &PosedHand) -> f64 {
    posed.points.iter().fold(0.0, |deepest: f64, point| {
        deepest.max(-exact.distance(point))
    })
}

/// Whether a part of the object passes through the hand although all surface points of the hand are at most 2 mm deep.
///
/// # Panics
/// If `posed` belongs to another hand.
pub fn passes_between_points(exact: &ExactMesh, hand: &Hand, posed: &PosedHand) -> bool {
    object_inside_hand_m(exact, hand, posed) > SWALLOWED_M
        && points_inside_object_m(exact, posed) < UNSEEN_M
}
