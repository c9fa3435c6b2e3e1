//! How deep hand and object lie in each other: on the hand as it is exported and on the exact mesh of the object.

use nalgebra::Vector3;

use super::hand::{Hand, Part, PosedHand, Solid};
use super::object::ExactMesh;

/// Depth of the deepest point of one of hand and object inside the other, metres; 0 where they do not overlap.
///
/// ```text
/// max { −d(p, O) : p ∈ ∂H } ∪ { −d(p, P) : p ∈ ∂O, P part of H },   d: signed distance
/// ```
///
/// ∂H are the triangles of the hand as it is exported ([`Hand::solid_skin`]): of its parts (meshes, hulls of boxes and
/// cylinders, capsules), or the skin of MANO. The skin that is drawn over a hand of capsules alone is fuller at creases and
/// does not count. Inside a part is inside its mesh where that bounds a solid, if need be after repair, else inside its
/// convex hull; inside a capsule exactly. Within [`DEPTH_TOLERANCE_M`](super::object::DEPTH_TOLERANCE_M) from
/// below.
///
/// # Panics
/// If `posed` is another hand.
pub fn deepest_m(exact: &ExactMesh, hand: &Hand, posed: &PosedHand) -> f64 {
    fold_parts(exact, hand, posed, |deepest_m, part| {
        let deepest_m = part.holds(exact, posed, deepest_m);
        part.is_in(exact, posed, deepest_m)
    })
}

/// Depth of the deepest point of the object's surface inside a part of the hand, metres; 0 if none is inside. The second
/// half of [`deepest_m`].
///
/// A part within a thick object and farther from its surface than it is thick counts nothing: there the hand's own
/// surface is inside the object.
///
/// # Panics
/// If `posed` is another hand.
pub fn object_inside_hand_m(exact: &ExactMesh, hand: &Hand, posed: &PosedHand) -> f64 {
    fold_parts(exact, hand, posed, |deepest_m, part| {
        part.holds(exact, posed, deepest_m)
    })
}

/// Runs through the parts that may touch the object.
fn fold_parts(
    exact: &ExactMesh,
    hand: &Hand,
    posed: &PosedHand,
    deeper: impl Fn(f64, &Part) -> f64,
) -> f64 {
    hand.parts(posed)
        .iter()
        .filter(|part| {
            let centre = part.frame(posed).point(&part.centre);
            exact.gap_within(&centre, part.radius_m).is_some() || exact.surrounds(&centre)
        })
        .fold(0.0, deeper)
}

impl Part {
    /// Depth of the deepest point of the object's surface inside this part, if it is more than `known_m`.
    fn holds(&self, exact: &ExactMesh, posed: &PosedHand, known_m: f64) -> f64 {
        match &self.solid {
            Solid::Capsule { number, radius_m } => exact
                .segment_distance_within(&posed.capsules[*number], radius_m - known_m)
                .map_or(known_m, |distance_m| radius_m - distance_m),
            Solid::Mesh(solid) => {
                let frame = self.frame(posed);
                let place = |point: &Vector3<f64>| frame.inverse_point(point);
                solid.deepest(exact.surface(), place, known_m)
            }
            Solid::Nothing => known_m,
        }
    }

    /// Depth of the deepest point of this part's surface inside the object, if it is more than `known_m`, which is at least
    /// [`Part::holds`].
    fn is_in(&self, exact: &ExactMesh, posed: &PosedHand, known_m: f64) -> f64 {
        if let Solid::Capsule { number, .. } = self.solid {
            let axis = &posed.capsules[number];
            let crossed = exact.segment_distance_within(axis, ON_AXIS_M).is_some();
            // While the axis stays outside, the surface comes no deeper into the object than that into the capsule.
            if !crossed && !exact.surrounds(&axis[0]) {
                return known_m;
            }
        }
        let frame = self.frame(posed);
        exact.deepest(&self.surface, |point| frame.point(point), known_m)
    }
}

/// An axis closer to the surface than this crosses it, metres.
const ON_AXIS_M: f64 = 1e-9;
