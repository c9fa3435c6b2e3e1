//! Exact contacts between the hand's capsules and an object.

use nalgebra::Vector3;

use crate::grasp::closure::PointContact;
use crate::hand::{Hand, LinkId, PosedHand};
use crate::mesh::ExactMesh;

/// Places along an axis tried first. The search continues between the neighbours of the best one.
const PLACES: usize = 9;
/// Golden-section steps in that interval, which reduce it to a millionth.
const SECTIONS: usize = 28;

/// The place where a capsule is nearest to the surface of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CapsuleTouch {
    /// Index into [`Hand::capsules`].
    pub capsule: usize,
    /// The link of the capsule.
    pub link: LinkId,
    /// Signed distance of the capsule from the mesh, metres; negative if they overlap.
    pub gap_m: f64,
    /// The nearest point of the object's surface, metres.
    pub on_object: Vector3<f64>,
    /// The point of the capsule's surface that is nearest to the object or deepest in it, metres.
    pub on_hand: Vector3<f64>,
    /// Unit normal into the object, in which the capsule pushes.
    pub inward_normal: Vector3<f64>,
}

impl CapsuleTouch {
    /// The contact for the tests of [`closure`](crate::grasp::closure): arm from `centre` in units of `unit_m`.
    pub fn contact(&self, centre: &Vector3<f64>, unit_m: f64) -> PointContact {
        PointContact {
            arm: (self.on_object - centre) / unit_m,
            inward_normal: self.inward_normal,
        }
    }
}

/// The touches of all capsules of the posed hand within `reach_m` of the mesh, in the order of the capsules.
///
/// # Panics
/// If `posed` belongs to another hand.
pub fn capsule_touches(
    exact: &ExactMesh,
    hand: &Hand,
    posed: &PosedHand,
    reach_m: f64,
) -> Vec<CapsuleTouch> {
    let capsules = hand.capsules.iter().zip(&posed.capsules).enumerate();
    capsules
        .filter_map(|(index, (capsule, axis))| {
            let radius_m = capsule.radius_m;
            exact.segment_distance_within(axis, radius_m + reach_m)?;
            let nearest = exact.nearest(&nearest_place(exact, axis));
            Some(CapsuleTouch {
                capsule: index,
                link: capsule.link,
                gap_m: nearest.distance_m - radius_m,
                on_object: nearest.point,
                on_hand: nearest.point + nearest.normal * (nearest.distance_m - radius_m),
                inward_normal: -nearest.normal,
            })
        })
        .collect()
}

/// The point of a segment with the least signed distance.
fn nearest_place(exact: &ExactMesh, [a, b]: &[Vector3<f64>; 2]) -> Vector3<f64> {
    let along = b - a;
    if along.norm_squared() == 0.0 {
        return *a;
    }
    let place = |t: f64| a + along * t;
    let distance = |t: f64| exact.distance(&place(t));
    let last = PLACES - 1;
    let at = |index: usize| index as f64 / last as f64;
    let tried: Vec<f64> = (0..PLACES).map(|index| distance(at(index))).collect();
    let best = (0..PLACES)
        .min_by(|&i, &j| tried[i].total_cmp(&tried[j]))
        .unwrap_or(0);
    let (mut low, mut high) = (at(best.saturating_sub(1)), at((best + 1).min(last)));
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut inner = [high - golden * (high - low), low + golden * (high - low)];
    let mut values = inner.map(distance);
    for _ in 0..SECTIONS {
        if values[0] <= values[1] {
            high = inner[1];
            inner = [high - golden * (high - low), inner[0]];
            values = [distance(inner[0]), values[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + golden * (high - low)];
            values = [values[1], distance(inner[1])];
        }
    }
    // An end may be lower than the inside of the last interval.
    let found = 0.5 * (low + high);
    let candidates = [at(best), found];
    let found = if distance(found) <= tried[best] {
        candidates[1]
    } else {
        candidates[0]
    };
    place(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::Object;

    #[test]
    fn touches_of_a_hand_are_no_farther_than_any_point_of_its_capsules() {
        let object = Object::named("ball").unwrap();
        let hand = Hand::human();
        let mut x = hand.rest_coordinates();
        x[2] = object.centroid.z + object.radius_m - hand.palm.centre.z;
        let mut posed = PosedHand::default();
        hand.pose(&x, &mut posed);
        let found = capsule_touches(&object.exact, &hand, &posed, 0.02);
        assert!(!found.is_empty());
        for touch in found {
            let radius_m = hand.capsules[touch.capsule].radius_m;
            let [a, b] = posed.capsules[touch.capsule];
            let gap_m = (0..=200)
                .map(|k| {
                    object
                        .exact
                        .distance(&(a + (b - a) * (f64::from(k) / 200.0)))
                })
                .fold(f64::INFINITY, f64::min)
                - radius_m;
            assert!((touch.gap_m - gap_m).abs() < 5e-5, "{touch:?}: {gap_m}");
            assert!((touch.on_object - touch.on_hand).norm() - touch.gap_m.abs() < 1e-9);
            let across = (touch.on_hand - touch.on_object).dot(&touch.inward_normal);
            assert!((across + touch.gap_m).abs() < 1e-9, "{touch:?}");
        }
    }
}
