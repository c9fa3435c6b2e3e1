//! Contacts of the hand with the object, and the form of the object there.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::anatomy::{Anatomy, Patch};
use super::table::Form;
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
/// The object's form is measured within this share of its width from the middle of the contacts, and at least this far.
const AROUND_WIDTHS: f64 = 1.0;
const AROUND_M: f64 = 0.02;
/// Step of the search for the other side of the object, and the longest distance searched, metres.
const STEP_M: f64 = 2.5e-4;
const WIDEST_M: f64 = 0.25;

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

/// The form of the object where it is held.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// Width under the contacts: the distance through the object along the normal, median over the contacts, metres.
    pub width_m: f64,
    /// Degree of each form, in the order of [`Form::ALL`], 0 to 1.
    pub forms: [f64; 4],
    /// Long axis of a rod, axis of a disk, normal of a plate: unit vector, object frame, up to its sign.
    pub axis: Vector3<f64>,
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
) -> Vec<(TouchingPatch, Vector3<f64>)> {
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
            weight_mm2,
        };
        (weight_mm2 > 0.0).then_some((touch, nearest.normal))
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

/// The form of the object under the contacts; `None` without contacts.
pub fn held(object: &Object, touches: &[(TouchingPatch, Vector3<f64>)]) -> Option<Held> {
    let total: f64 = touches.iter().map(|(touch, _)| touch.weight_mm2).sum();
    if total <= 0.0 {
        return None;
    }
    let width_m = median_width(object, touches, total);

    // The middle of the held part: half of the width below each contact.
    let middle: Vector3<f64> = touches
        .iter()
        .map(|(touch, normal)| (touch.point - normal * (0.5 * width_m)) * touch.weight_mm2)
        .sum::<Vector3<f64>>()
        / total;
    let around = (AROUND_WIDTHS * width_m).max(AROUND_M);
    let near: Vec<(Vector3<f64>, Vector3<f64>)> = object
        .surface_samples
        .iter()
        .filter(|sample| (sample.point - middle).norm() < around)
        .map(|sample| (sample.point - middle, sample.normal))
        .collect();
    let [(short, short_axis), (middle, _), (long, long_axis)] = extents(&near).try_into().ok()?;
    if !(short.is_finite() && long > 0.0) {
        return None;
    }
    let flat = 1.0 - ramp(short / middle, 0.45, 0.75);
    let long_share = ramp(long / middle, 1.15, 1.5);
    // Whether the contacts press on the faces or on the rim of a flat object.
    let faces = touches
        .iter()
        .map(|(touch, normal)| touch.weight_mm2 * normal.dot(&short_axis).abs())
        .sum::<f64>()
        / total;
    let by_rim = 1.0 - ramp(faces, 0.35, 0.75);
    let round = (1.0 - flat) * (1.0 - long_share);
    let rod = long_share * (1.0 - flat);
    let forms = Form::ALL.map(|form| match form {
        Form::Sphere => round,
        Form::Rod => rod,
        Form::Disk => flat * by_rim,
        Form::Plate => flat * (1.0 - by_rim),
    });
    Some(Held {
        width_m,
        forms,
        axis: if flat > 0.5 { short_axis } else { long_axis },
    })
}

/// Median width of the object below the contacts, weighted with their areas, whose sum is `total`; metres.
fn median_width(object: &Object, touches: &[(TouchingPatch, Vector3<f64>)], total: f64) -> f64 {
    let mut widths: Vec<[f64; 2]> = touches
        .iter()
        .map(|(touch, normal)| [width(object, &touch.point, normal), touch.weight_mm2])
        .collect();
    widths.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut below = 0.0;
    widths
        .iter()
        .find(|[_, weight]| {
            below += weight;
            below >= 0.5 * total
        })
        .map_or(0.0, |[width, _]| *width)
}

/// Extents of points along the principal axes of their normals, shortest first.
fn extents(near: &[(Vector3<f64>, Vector3<f64>)]) -> Vec<(f64, Vector3<f64>)> {
    let scatter: Matrix3<f64> = near
        .iter()
        .map(|(_, normal)| normal * normal.transpose())
        .sum::<Matrix3<f64>>()
        / near.len().max(1) as f64;
    let axes = SymmetricEigen::new(scatter).eigenvectors;
    let mut extents: Vec<(f64, Vector3<f64>)> = axes
        .column_iter()
        .map(|axis| {
            let along = near.iter().map(|(point, _)| axis.dot(point));
            let high = along.clone().fold(f64::NEG_INFINITY, f64::max);
            let low = along.fold(f64::INFINITY, f64::min);
            ((high - low).max(0.0), axis.into_owned())
        })
        .collect();
    extents.sort_by(|a, b| a.0.total_cmp(&b.0));
    extents
}

/// The distance from a surface point through the object along its inward normal, metres.
fn width(object: &Object, point: &Vector3<f64>, outward: &Vector3<f64>) -> f64 {
    let mut along = STEP_M;
    while along < WIDEST_M {
        let distance = object.shape.distance(&(point - outward * along));
        if distance > STEP_M {
            break;
        }
        along += distance.abs().max(STEP_M);
    }
    along
}

/// 0 up to `low`, 1 from `high`, linear between.
pub(super) fn ramp(x: f64, low: f64, high: f64) -> f64 {
    ((x - low) / (high - low)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use super::*;
    use crate::evaluation::taxonomy::{Bone, PalmPart};
    use crate::mesh::SurfaceSample;
    use crate::space::Pose;

    /// The object as held at those points of its surface that `test` chooses.
    fn held_at(object: &Object, test: impl Fn(&SurfaceSample) -> bool) -> Held {
        let touch = |sample: &SurfaceSample| {
            let touch = TouchingPatch {
                patch: Patch::Palm(PalmPart::Volar),
                link: LinkId(0),
                point: sample.point,
                normal: -sample.normal,
                weight_mm2: 10.0,
            };
            (touch, sample.normal)
        };
        let chosen = object.surface_samples.iter().filter(|sample| test(sample));
        let touches: Vec<_> = chosen.map(touch).collect();
        assert!(touches.len() > 5, "{}", object.name);
        held(object, &touches).unwrap()
    }

    #[test]
    fn forms_and_widths_are_those_under_the_contacts() {
        let is = |held: &Held, form: Form, width_mm: f64| {
            let share = held.forms[form as usize];
            assert!(share > 0.6, "{form:?}: {held:?}");
            let width = 1e3 * held.width_m;
            assert!(
                (width - width_mm).abs() < 0.08 * width_mm + 1.0,
                "{width} {width_mm}"
            );
        };
        let ball = Object::named("ball").unwrap();
        is(&held_at(&ball, |_| true), Form::Sphere, 70.0);
        // Between two fingers, too.
        is(
            &held_at(&ball, |sample| sample.normal.x.abs() > 0.95),
            Form::Sphere,
            70.0,
        );

        let bottle = Object::named("bottle_round").unwrap();
        let body = held_at(&bottle, |sample| (0.05..0.12).contains(&sample.point.z));
        is(&body, Form::Rod, 62.0);
        assert!(body.axis.z.abs() > 0.99);
    }

    #[test]
    fn what_is_flat_is_a_disk_by_its_rim_and_a_plate_by_its_faces() {
        let [corner, other] = [[-0.04, -0.03, -0.006], [0.04, 0.03, 0.006]];
        let mut obj = String::new();
        for code in 0..8 {
            let at = |axis: usize| {
                if (code >> axis) & 1 == 1 {
                    other[axis]
                } else {
                    corner[axis]
                }
            };
            writeln!(obj, "v {} {} {}", at(0), at(1), at(2)).unwrap();
        }
        obj += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
        let mesh = crate::mesh::Mesh::from_obj("slab", &mut obj.as_bytes()).unwrap();
        let slab = Object::from_mesh("slab", mesh, &crate::object::Description::default()).unwrap();
        let faces = held_at(&slab, |sample| sample.normal.z.abs() > 0.9);
        assert!(faces.forms[Form::Plate as usize] > 0.9, "{faces:?}");
        assert!((1e3 * faces.width_m - 12.0).abs() < 1.5, "{faces:?}");
        let rim = held_at(&slab, |sample| sample.normal.z.abs() < 0.1);
        assert!(rim.forms[Form::Disk as usize] > 0.9, "{rim:?}");
        assert!(1e3 * rim.width_m > 55.0, "{rim:?}");
        for held in [faces, rim] {
            assert!(held.axis.z.abs() > 0.99, "{held:?}");
        }
    }

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
        let weight_mm2: f64 = near.iter().map(|(touch, _)| touch.weight_mm2).sum();
        assert!(
            near.len() >= 3 && near.len() <= PLACES.len() * points.len() && weight_mm2 <= area_mm2,
            "{} at {} points, {weight_mm2} of {area_mm2} mm²",
            near.len(),
            points.len()
        );
        assert!(
            near.iter()
                .any(|(touch, _)| touch.patch == Patch::Palm(PalmPart::Volar))
        );
        assert!(
            near.iter()
                .all(|(touch, _)| touch.patch != Patch::Palm(PalmPart::Dorsum))
        );
        assert!(
            near.iter()
                .all(|(touch, _)| !matches!(touch.patch, Patch::Digit(2.., Bone::Distal, _)))
        );
        for (touch, normal) in &near {
            assert!(touch.weight_mm2 > 0.0 && touch.normal.dot(normal) < 0.0);
        }
    }
}
