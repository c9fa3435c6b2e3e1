//! Contacts of the hand with the object.

use nalgebra::Vector3;

use super::anatomy::{Anatomy, Patch};
use crate::hand::{Hand, LinkId, PosedHand};
use crate::object::Object;

/// Surface points nearer than this to the object belong to the contact set; a finger's pad yields by about this much.
pub const NEAR_M: f64 = 0.005;
/// A point with at most this gap counts fully.
const TOUCHING_M: f64 = 0.002;
/// Points whose distance to the smooth field exceeds this are not measured exactly.
const FAR_M: f64 = 0.01;
/// Places where the area of a point is sampled: offsets from its middle, in halves of its radius.
const PLACES: [[f64; 2]; 4] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
/// A patch of the hand in contact with the object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TouchingPatch {
    /// Part of the hand.
    pub patch: Patch,
    /// The link it belongs to.
    pub link: LinkId,
    /// Position, object frame, metres.
    pub point: Vector3<f64>,
    /// Outward unit normal of the hand, object frame.
    pub normal: Vector3<f64>,
    /// Outward unit normal of the object there, object frame.
    pub object_normal: Vector3<f64>,
    /// Weight: the area of the point, reduced by its gap and by its angle to the object, mm².
    pub weight_mm2: f64,
}

impl TouchingPatch {
    /// The same contact on another pose of the hand; it keeps its place on its link.
    #[must_use]
    pub fn carried(&self, from: &PosedHand, to: &PosedHand) -> Self {
        let [from, to] = [from, to].map(|posed| &posed.object_from_link[self.link.0]);
        let local = from.rotation.tr_mul(&(self.point - from.translation));
        Self {
            point: to.point(&local),
            normal: to.direction(&from.rotation.tr_mul(&self.normal)),
            ..*self
        }
    }
}

/// The proximity contact set of a posed hand: every surface point nearer than [`NEAR_M`] or inside the object.
///
/// A point counts with its area, times a factor of 1 up to a gap of 2 mm that falls to 0 at [`NEAR_M`], times the cosine
/// between its normal and the object's inward normal. The area is sampled at four places around the point, because a
/// finger's pad has few points.
///
/// # Panics
/// If the hand was posed without its surface points, or `anatomy` belongs to another hand.
pub fn touches(
    hand: &Hand,
    anatomy: &Anatomy,
    posed: &PosedHand,
    object: &Object,
) -> Vec<TouchingPatch> {
    let touch = |i: usize, normal: &Vector3<f64>, place: Vector3<f64>| {
        let nearest = object.exact.nearest(&place);
        if nearest.distance_m >= NEAR_M {
            return None;
        }
        let facing = (-normal.dot(&nearest.normal)).max(0.0);
        let near = ((NEAR_M - nearest.distance_m) / (NEAR_M - TOUCHING_M)).min(1.0);
        let area_m2 = hand.surface[i].area_m2 / PLACES.len() as f64;
        let weight_mm2 = 1e6 * area_m2 * near * facing;
        let touch = TouchingPatch {
            patch: anatomy.patch(i),
            link: hand.surface[i].link,
            point: nearest.point,
            normal: *normal,
            object_normal: nearest.normal,
            weight_mm2,
        };
        (weight_mm2 > 0.0).then_some(touch)
    };
    let mut all = Vec::new();
    for (i, point) in posed.points.iter().enumerate() {
        if object.shape.distance(point) > FAR_M {
            continue;
        }
        let normal = hand.point_normal(posed, i);
        let along = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
        let across = normal.cross(&along);
        let off = 0.5 * (hand.surface[i].area_m2 / std::f64::consts::PI).sqrt();
        let places = PLACES.map(|[a, b]| point + (along * a + across * b) * off);
        all.extend(places.iter().filter_map(|place| touch(i, &normal, *place)));
    }
    all
}

/// 0 up to `low`, 1 from `high`, linear between.
pub(super) fn ramp(x: f64, low: f64, high: f64) -> f64 {
    ((x - low) / (high - low)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::taxonomy::{Bone, PalmPart};
    use crate::space::Pose;

    #[test]
    fn the_contact_set_is_all_that_is_near() {
        let hand = Hand::from_files(&crate::hand::HandFiles::named("human").unwrap()).unwrap();
        let anatomy = Anatomy::of(&hand).unwrap();
        let ball = Object::named("ball").unwrap();
        // The ball in the hollow of the flat hand: the palm touches, the back of the hand does not.
        let mut x = Pose::at_origin(&vec![0.0; hand.joints.len()]);
        let palm = hand.palm;
        let away = palm.centre + palm.volar * 0.034;
        let root = ball.centroid - away;
        x[..3].copy_from_slice(root.as_slice());
        let mut posed = PosedHand::default();
        hand.pose(&x, &mut posed);
        let near = touches(&hand, &anatomy, &posed, &ball);
        // No place is farther from its point than half the radius of the point's area.
        let reach =
            |i: usize| NEAR_M + 0.5 * (hand.surface[i].area_m2 / std::f64::consts::PI).sqrt();
        let close = |i: &usize| ball.exact.distance(&posed.points[*i]) < reach(*i);
        let points: Vec<usize> = (0..hand.surface.len()).filter(close).collect();
        let area_mm2: f64 = points.iter().map(|&i| 1e6 * hand.surface[i].area_m2).sum();
        let weight_mm2: f64 = near.iter().map(|touch| touch.weight_mm2).sum();
        assert!(
            near.len() >= 3 && near.len() <= PLACES.len() * points.len() && weight_mm2 <= area_mm2,
            "{} at {} points, {weight_mm2} of {area_mm2} mm²",
            near.len(),
            points.len()
        );
        assert!(
            near.iter()
                .any(|touch| touch.patch == Patch::Palm(PalmPart::Volar))
        );
        assert!(
            near.iter()
                .all(|touch| touch.patch != Patch::Palm(PalmPart::Dorsum))
        );
        assert!(
            near.iter()
                .all(|touch| !matches!(touch.patch, Patch::Digit(2.., Bone::Distal, _)))
        );
        for touch in &near {
            assert!(touch.weight_mm2 > 0.0 && touch.normal.dot(&touch.object_normal) < 0.0);
        }
    }
}
