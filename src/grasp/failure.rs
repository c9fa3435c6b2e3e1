//! Two known failures of relaxed force closure with penetration measured at points (Liu et al. 2021, Fig. 11): contacts
//! that all lie in one concavity, and thin parts of the object that pass between the hand's surface points.

use nalgebra::Vector3;

use super::depth::object_inside_hand_m;
use crate::hand::{Hand, PosedHand};
use crate::mesh::ExactMesh;

/// A part of the object deeper than this inside the hand passes through it, metres.
pub const SWALLOWED_M: f64 = 0.004;

/// Depth of a surface point of the hand that the strict filter does not object to, metres.
const UNSEEN_M: f64 = 0.002;

/// A line of sight that comes no deeper into the solid than this is free, metres.
const GRAZING_M: f64 = 1e-4;
/// Least and longest step along a line of sight, metres.
const STEP_M: [f64; 2] = [2.5e-4, 5e-3];

/// Whether every two of these points of the surface see each other past the solid.
///
/// On a convex solid no two points do, but for neighbours closer than the eye can tell; points that see each other *and*
/// push against each other lie in one concavity: the inside of a bowl, of a mug, of its handle.
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
        // A solid this far away is not met before that.
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

/// Whether a part of the object passes through the posed hand although each of the hand's surface points keeps within 2 mm
/// of the outside.
///
/// # Panics
/// If `posed` is another hand.
pub fn passes_between_points(exact: &ExactMesh, hand: &Hand, posed: &PosedHand) -> bool {
    object_inside_hand_m(exact, hand, posed) > SWALLOWED_M
        && points_inside_object_m(exact, posed) < UNSEEN_M
}
