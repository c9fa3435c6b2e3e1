//! A known failure of penetration measured at points (Liu et al. 2021, Fig. 11): thin parts of the object pass between the
//! hand's surface points.

use landscape::grasp::depth::object_inside_hand_m;
use landscape::hand::{Hand, PosedHand};
use landscape::mesh::ExactMesh;

/// Depth above which a part of the object inside the hand passes through it, metres.
const SWALLOWED_M: f64 = 0.004;

/// Greatest depth of a surface point of the hand that the strict filter accepts, metres.
const UNSEEN_M: f64 = 0.002;

/// Depth of the deepest surface point of the hand inside the object, metres; 0 if none is inside.
pub(crate) fn points_inside_object_m(exact: &ExactMesh, posed: &PosedHand) -> f64 {
    posed.points.iter().fold(0.0, |deepest: f64, point| {
        deepest.max(-exact.distance(point))
    })
}

/// Whether a part of the object passes through the hand although all surface points of the hand are at most 2 mm deep.
///
/// # Panics
/// If `posed` belongs to another hand.
pub(crate) fn passes_between_points(exact: &ExactMesh, hand: &Hand, posed: &PosedHand) -> bool {
    object_inside_hand_m(exact, hand, posed) > SWALLOWED_M
        && points_inside_object_m(exact, posed) < UNSEEN_M
}
