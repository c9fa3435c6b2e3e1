//! The form and the size of the part of an object that a hand holds.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::table::Form;
use super::touch::{TouchingPatch, ramp};
use crate::object::Object;

/// The held part reaches from the middle of the contacts this many times as far as the contacts themselves, and at least so
/// many metres.
const PART: f64 = 1.25;
const PART_LEAST_M: f64 = 0.02;
/// Its extents are measured this many times as far: a bar that goes on beyond the hand is long.
const BEYOND: f64 = 2.0;
/// Step of the search for the other side of the object, and the longest distance searched, metres.
const STEP_M: f64 = 2.5e-4;
const WIDEST_M: f64 = 0.25;
/// The hand touches the far side of an object if a contact is so near, metres.
const OPPOSITE_M: f64 = 0.015;
/// A surface belongs to an end if the cosine between its normal and the axis is larger.
const END: f64 = 0.7;
/// Mean angle between the normals of a part and those of a solid at which they hardly match, radians (12°).
const MATCHES_RAD: f64 = 0.21;
/// Weight of a solid without a name, against which ball, cylinder and box compete.
const NAMELESS: f64 = 0.15;
/// Normals within this cosine of each other belong to one face (15°).
const ONE_FACE: f64 = 0.966;

/// A point of the surface of the held part, from the part's middle, and the outward normal there.
type Sample = (Vector3<f64>, Vector3<f64>);

/// A solid that a part is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solid {
    /// A ball.
    Ball,
    /// A cylinder; its axis is the direction in question.
    Cylinder,
    /// A box.
    Box,
    /// None of these; known by its extents only.
    Nameless,
}

impl Solid {
    /// All solids.
    pub const ALL: [Self; 4] = [Self::Ball, Self::Cylinder, Self::Box, Self::Nameless];

    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ball => "ball",
            Self::Cylinder => "cylinder",
            Self::Box => "box",
            Self::Nameless => "no simple solid",
        }
    }
}

/// The part of an object that a hand holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// Width under the contacts: the distance through the object along the normal, median over the contacts, metres.
    pub width_m: f64,
    /// How well the part matches each solid, in the order of [`Solid::ALL`]; the sum is 1.
    pub solids: [f64; 4],
    /// Extents of the part, shortest first, metres.
    pub extents_m: [f64; 3],
    /// Degree of each form, in the order of [`Form::ALL`], 0 to 1. A cube is a block and half a ball.
    pub forms: [f64; 5],
    /// Long axis of a rod, axis of a disk, normal of a plate: unit vector, object frame, up to its sign.
    pub axis: Vector3<f64>,
}

/// The axes of a part and its extents along them, shortest extent first.
struct Extents {
    axes: [Vector3<f64>; 3],
    along_m: [f64; 3],
}

/// The part of the object that these contacts hold; `volar` is the direction out of the palm. `None` without contacts.
///
/// The part is all of the surface within 1.25 times the reach of the contacts. Its normals are compared with those of a
/// ball, a cylinder and a box:
///
/// ```text
/// share of a solid ∝ exp(−(a/12°)²)
/// ```
///
/// `a`: mean angle between the normals of the part and those of the solid that fits best. Extents, the direction of the axis
/// in the hand, and whether the contacts press on ends or sides decide which form the solid has for the hand.
pub fn held(object: &Object, touches: &[TouchingPatch], volar: &Vector3<f64>) -> Option<Held> {
    let total: f64 = touches.iter().map(|touch| touch.weight_mm2).sum();
    if total <= 0.0 {
        return None;
    }
    let width_m = median_width(object, touches, total);
    let middle: Vector3<f64> = touches
        .iter()
        .map(|touch| (touch.point - touch.object_normal * (0.5 * width_m)) * touch.weight_mm2)
        .sum::<Vector3<f64>>()
        / total;
    let reach = (touches.iter())
        .map(|touch| (touch.point - middle).norm())
        .fold(0.0, f64::max);
    let within = (PART * reach).max(PART_LEAST_M);
    let samples = |far: f64| -> Vec<Sample> {
        let near = (object.surface_samples.iter()).filter(|s| (s.point - middle).norm() < far);
        near.map(|s| (s.point - middle, s.normal)).collect()
    };
    let part = Part {
        near: samples(within),
        around: samples(BEYOND * within),
        within,
    };
    if part.near.len() < 4 {
        return None;
    }
    let pressed = |axis: &Vector3<f64>| {
        let along = touches
            .iter()
            .map(|touch| touch.weight_mm2 * touch.object_normal.dot(axis).abs());
        along.sum::<f64>() / total
    };
    Some(part.held(width_m, volar, &pressed))
}

/// The part that these contacts hold where nothing is known of the object but the contacts themselves: the solid that fits
/// them best. `None` for fewer than five contacts, which no solid would contradict.
pub fn held_by_contacts(touches: &[TouchingPatch], volar: &Vector3<f64>) -> Option<Held> {
    const LEAST: usize = 5;
    if touches.len() < LEAST {
        return None;
    }
    let count = touches.len() as f64;
    let middle = touches.iter().map(|t| t.point).sum::<Vector3<f64>>() / count;
    let samples = || touches.iter().map(|t| (t.point - middle, t.object_normal));
    let part = Part {
        near: samples().collect(),
        around: samples().collect(),
        within: f64::INFINITY,
    };
    let pressed = |axis: &Vector3<f64>| {
        let along = touches
            .iter()
            .map(|touch| touch.object_normal.dot(axis).abs());
        along.sum::<f64>() / count
    };
    // Twice the mean distance of the contacts, along their normals, from the middle.
    let across = samples().map(|(point, normal)| point.dot(&normal).max(0.0));
    let width_m = 2.0 * across.sum::<f64>() / count;
    Some(part.held(width_m, volar, &pressed))
}

impl Held {
    /// Degree of a form.
    pub fn degree(&self, form: Form) -> f64 {
        self.forms[form as usize]
    }

    /// The size that counts for a type that usually holds these forms, metres: the thickness of what is flat, the diameter of
    /// a disk, else the width between the contacts.
    pub fn size_m(&self, forms: &[Form]) -> f64 {
        let most = forms
            .iter()
            .max_by(|a, b| self.degree(**a).total_cmp(&self.degree(**b)));
        let [thickness, middle, long] = self.extents_m;
        match most {
            Some(Form::Plate) => self.width_m.min(thickness),
            Some(Form::Disk) if forms.contains(&Form::Plate) => self.width_m.min(thickness),
            Some(Form::Disk) => 0.5 * (middle + long),
            _ => self.width_m,
        }
    }
}

struct Part {
    /// Samples of the part, and of the object around it.
    near: Vec<Sample>,
    around: Vec<Sample>,
    /// Radius of the part, metres.
    within: f64,
}

impl Part {
    fn held(
        &self,
        width_m: f64,
        volar: &Vector3<f64>,
        pressed: &dyn Fn(&Vector3<f64>) -> f64,
    ) -> Held {
        let (axis, [round, edged]) = self.axis();
        let ball = self.ball();
        let match_of = |angle: f64| libm::exp(-(angle / MATCHES_RAD).powi(2));
        let matches = [match_of(ball), match_of(round), match_of(edged), NAMELESS];
        let sum: f64 = matches.iter().sum();
        let solids = matches.map(|value| value / sum);

        let cylinder = self.extents(cylinder_axes(&axis));
        let boxed = self.extents(self.box_axes(&axis));
        let shape = if solids[1] >= solids[2] {
            &cylinder
        } else {
            &boxed
        };
        let parts = [
            [1.0, 0.0, 0.0, 0.0, 0.0],
            forms_of_cylinder(&axis, &cylinder, volar, pressed),
            forms_of_box(&boxed, pressed),
            forms_of_any(&boxed, pressed),
        ];
        let mut forms = [0.0; 5];
        for (share, own) in solids.iter().zip(parts) {
            for (form, degree) in forms.iter_mut().zip(own) {
                *form += share * degree;
            }
        }
        let degree = |form: Form| forms[form as usize];
        let flat = degree(Form::Plate) + degree(Form::Disk) > degree(Form::Rod) + degree(Form::Box);
        Held {
            width_m,
            solids,
            extents_m: shape.along_m,
            forms,
            axis: match () {
                () if solids[1] >= solids[2] => axis,
                () if flat => boxed.axes[0],
                () => boxed.axes[2],
            },
        }
    }

    /// Mean angle between the normals and the directions from the centre of the ball that fits best.
    fn ball(&self) -> f64 {
        let mut left = Matrix3::identity() * 1e-6;
        let mut right = Vector3::zeros();
        for (point, normal) in &self.near {
            let across = Matrix3::identity() - normal * normal.transpose();
            left += across;
            right += across * point;
        }
        let Some(centre) = left.cholesky().map(|factor| factor.solve(&right)) else {
            return std::f64::consts::PI;
        };
        mean(
            self.near
                .iter()
                .map(|(point, normal)| normal.angle(&(point - centre))),
        )
    }

    /// The axis along which the part is most like a cylinder or a prism, and the mean angles of its normals to those of a
    /// cylinder and of a box with this axis.
    fn axis(&self) -> (Vector3<f64>, [f64; 2]) {
        let scatter: Matrix3<f64> = self.near.iter().map(|(_, n)| n * n.transpose()).sum();
        let eigen = SymmetricEigen::new(scatter).eigenvectors;
        let first = self.face(None);
        let second = self.face(Some(&first));
        let candidates = [first, second, first.cross(&second)]
            .into_iter()
            .chain(eigen.column_iter().map(nalgebra::Matrix::into_owned));
        let judged = candidates.map(|axis| {
            let angles = [self.cylinder(&axis), self.prism(&axis)];
            (axis, angles)
        });
        let least = |angles: &[f64; 2]| angles[0].min(angles[1]);
        judged
            .min_by(|a, b| least(&a.1).total_cmp(&least(&b.1)))
            .unwrap_or((first, [std::f64::consts::PI; 2]))
    }

    /// The normal that most samples share, if `across` is given among those at right angles to it.
    fn face(&self, across: Option<&Vector3<f64>>) -> Vector3<f64> {
        let level = |normal: &Vector3<f64>| across.map_or(0.0, |axis| axis.dot(normal).abs());
        let candidates = self.near.iter().filter(|(_, normal)| level(normal) < 0.26);
        let alike = |normal: &Vector3<f64>| {
            let same = self.near.iter();
            same.filter(|(_, other)| normal.dot(other).abs() > ONE_FACE)
                .count()
        };
        let best = candidates
            .step_by(1 + self.near.len() / 200)
            .max_by_key(|(_, normal)| alike(normal));
        let normal = best.map_or_else(Vector3::z, |(_, normal)| *normal);
        match across {
            Some(axis) => (normal - axis * axis.dot(&normal))
                .try_normalize(1e-9)
                .unwrap_or_else(|| perpendicular(axis)),
            None => normal,
        }
    }

    /// Mean angle of the normals to those of the best cylinder with this axis.
    fn cylinder(&self, axis: &Vector3<f64>) -> f64 {
        let flat = |v: &Vector3<f64>| v - axis * axis.dot(v);
        let sides = || self.near.iter().filter(|(_, n)| n.dot(axis).abs() < END);
        let mut left = Matrix3::identity() * 1e-6 + axis * axis.transpose();
        let mut right = Vector3::zeros();
        for (point, normal) in sides() {
            let Some(outward) = flat(normal).try_normalize(1e-9) else {
                continue;
            };
            let across = axis.cross(&outward);
            left += across * across.transpose();
            right += across * across.dot(point);
        }
        let centre = left
            .cholesky()
            .map_or_else(Vector3::zeros, |f| f.solve(&right));
        let angles = sides().map(|(point, normal)| normal.angle(&flat(&(point - centre))));
        self.with_ends(axis, angles.collect())
    }

    /// Mean angle of the normals to those of the best box of which one edge has the direction `axis`.
    fn prism(&self, axis: &Vector3<f64>) -> f64 {
        let axes = self.box_axes(axis);
        let angle = |normal: &Vector3<f64>| {
            let most = axes[1..].iter().map(|side| side.dot(normal).abs());
            libm::acos(most.fold(0.0, f64::max).min(1.0))
        };
        let sides = self.near.iter().filter(|(_, n)| n.dot(axis).abs() < END);
        self.with_ends(axis, sides.map(|(_, normal)| angle(normal)).collect())
    }

    /// The mean of the angles of sides, which is `sides`, and of ends. Sides count at least half, unless there are none.
    fn with_ends(&self, axis: &Vector3<f64>, sides: Vec<f64>) -> f64 {
        let ends: Vec<f64> = (self.near.iter())
            .map(|(_, normal)| normal.dot(axis).abs())
            .filter(|along| *along >= END)
            .map(|along| libm::acos(along.min(1.0)))
            .collect();
        let share = sides.len() as f64 / self.near.len() as f64;
        let weight = if share > 0.05 { share.max(0.5) } else { share };
        weight * mean(sides.into_iter()) + (1.0 - weight) * mean(ends.into_iter())
    }

    /// Edges of a box: `axis`, and the two directions across it that match the normals of its sides best.
    fn box_axes(&self, axis: &Vector3<f64>) -> [Vector3<f64>; 3] {
        let side = self.face(Some(axis));
        [*axis, side, axis.cross(&side)]
    }

    /// The extents of the part along some axes. Along each it may reach twice as far as its radius.
    fn extents(&self, axes: [Vector3<f64>; 3]) -> Extents {
        let mut extents = axes.map(|axis| {
            let tube = self
                .around
                .iter()
                .filter(|(point, _)| (point - axis * axis.dot(point)).norm() < self.within);
            let along = tube.map(|(point, _)| axis.dot(point));
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            });
            ((high - low).max(0.0), axis)
        });
        extents.sort_by(|a, b| a.0.total_cmp(&b.0));
        Extents {
            axes: extents.map(|(_, axis)| axis),
            along_m: extents.map(|(along, _)| along),
        }
    }
}

/// Form of a cylinder for the hand: a rod if it is long and lies across the palm, a disk if it is flat or its end faces the
/// palm, a plate if it is flat and pressed on its ends.
fn forms_of_cylinder(
    axis: &Vector3<f64>,
    extents: &Extents,
    volar: &Vector3<f64>,
    pressed: &dyn Fn(&Vector3<f64>) -> f64,
) -> [f64; 5] {
    let along = |k: usize| extents.axes[k].dot(axis).abs();
    let place = (0..3).max_by(|a, b| along(*a).total_cmp(&along(*b)));
    let length = extents.along_m[place.unwrap_or(0)];
    let across: f64 = (0..3)
        .filter(|k| Some(*k) != place)
        .map(|k| 0.5 * extents.along_m[k])
        .sum();
    let ratio = length / across.max(1e-6);
    // The end of a can is a disk to the hand; a stick stays a stick.
    let facing = ramp(axis.dot(volar).abs(), 0.6, 0.9) * (1.0 - ramp(ratio, 1.5, 3.0));
    let long = ramp(ratio, 0.5, 1.1);
    let ends = ramp(pressed(axis), 0.45, 0.8);
    let plate = (1.0 - long) * ends;
    let disk = (1.0 - long) * (1.0 - ends) + long * facing * (1.0 - ends);
    [0.0, 1.0 - plate - disk, disk, plate, 0.0]
}

/// Form of a box: a plate if it is flat and pressed on its faces, else a disk or a rod if it is flat; a block if it is not
/// flat, and then also a rod if it is long, or as compact as a ball (half, because it has the parallel sides of a prism).
fn forms_of_box(extents: &Extents, pressed: &dyn Fn(&Vector3<f64>) -> f64) -> [f64; 5] {
    let [short, middle, long] = extents.along_m;
    let flat = 1.0 - ramp(short / middle.max(1e-6), 0.25, 0.5);
    let faces = ramp(pressed(&extents.axes[0]), 0.35, 0.75);
    let rod = ramp(long / middle.max(1e-6), 1.15, 1.6);
    let block = 1.0 - flat;
    let compact = 0.5 * block * (1.0 - rod);
    [
        compact,
        flat * (1.0 - faces) * rod,
        flat * (1.0 - faces) * (1.0 - rod),
        flat * faces,
        block,
    ]
}

/// Form by extents alone.
fn forms_of_any(extents: &Extents, pressed: &dyn Fn(&Vector3<f64>) -> f64) -> [f64; 5] {
    let [short, middle, long] = extents.along_m;
    let flat = 1.0 - ramp(short / middle.max(1e-6), 0.45, 0.75);
    let rod = ramp(long / middle.max(1e-6), 1.15, 1.5);
    let faces = ramp(pressed(&extents.axes[0]), 0.35, 0.75);
    let sphere = (1.0 - flat) * (1.0 - rod);
    let flat_rod = flat * (1.0 - faces) * rod;
    [
        sphere,
        rod * (1.0 - flat) + flat_rod,
        flat * (1.0 - faces) * (1.0 - rod),
        flat * faces,
        0.0,
    ]
}

fn cylinder_axes(axis: &Vector3<f64>) -> [Vector3<f64>; 3] {
    let side = perpendicular(axis);
    [*axis, side, axis.cross(&side)]
}

fn perpendicular(axis: &Vector3<f64>) -> Vector3<f64> {
    axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), v| (sum + v, count + 1));
    sum / count.max(1) as f64
}

/// Median width of the object below the contacts, weighted with their areas, whose sum is `total`; metres.
fn median_width(object: &Object, touches: &[TouchingPatch], total: f64) -> f64 {
    let mut widths: Vec<[f64; 2]> = touches
        .iter()
        .map(|touch| [width(object, touch, touches), touch.weight_mm2])
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

/// The distance from a contact through the object along its inward normal, metres: to the far side of a hollow object if
/// the hand touches there, else to the near one.
fn width(object: &Object, touch: &TouchingPatch, touches: &[TouchingPatch]) -> f64 {
    let mut along = STEP_M;
    let (mut inside, mut width): (bool, Option<f64>) = (true, None);
    while along < WIDEST_M {
        let place = touch.point - touch.object_normal * along;
        let distance = object.shape.distance(&place);
        let out = distance > STEP_M;
        if inside && out {
            let touched = || {
                touches
                    .iter()
                    .any(|t| (t.point - place).norm() < OPPOSITE_M)
            };
            if width.is_none() || touched() {
                width = Some(along);
            }
        }
        inside = !out;
        along += distance.abs().max(STEP_M);
    }
    width.unwrap_or(along)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use super::*;
    use crate::evaluation::taxonomy::{PalmPart, Patch};
    use crate::hand::LinkId;
    use crate::mesh::SurfaceSample;

    /// Contacts at those points of the object's surface that `test` chooses.
    fn touching(object: &Object, test: impl Fn(&SurfaceSample) -> bool) -> Vec<TouchingPatch> {
        let touch = |sample: &SurfaceSample| TouchingPatch {
            patch: Patch::Palm(PalmPart::Volar),
            link: LinkId(0),
            point: sample.point,
            normal: -sample.normal,
            object_normal: sample.normal,
            weight_mm2: 10.0,
        };
        let chosen = object.surface_samples.iter().filter(|sample| test(sample));
        let touches: Vec<_> = chosen.map(touch).collect();
        assert!(touches.len() > 5, "{}", object.name);
        touches
    }

    /// The object as held there, by a palm that faces along x.
    fn held_at(object: &Object, test: impl Fn(&SurfaceSample) -> bool) -> Held {
        held(object, &touching(object, test), &Vector3::x()).unwrap()
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
        assert!(rim.degree(Form::Disk) > rim.degree(Form::Rod), "{rim:?}");
        assert!(rim.degree(Form::Plate) < 0.2, "{rim:?}");
        assert!(1e3 * rim.width_m > 55.0, "{rim:?}");
        for held in [faces, rim] {
            assert!(held.axis.z.abs() > 0.99, "{held:?}");
        }
    }

    #[test]
    fn a_can_is_a_rod_from_the_side_and_a_disk_from_above_and_a_brick_is_a_block() {
        let object = |name: &str, part: serde_json::Value| {
            let assembly = crate::object::Assembly {
                parts: vec![serde_json::from_value(part).unwrap()],
                ..crate::object::Assembly::default()
            };
            let (mesh, description) = assembly.object(name).unwrap();
            Object::from_mesh(name, mesh, &description).unwrap()
        };
        let can = object(
            "can",
            serde_json::json!({"cylinder": {"centre": [0.0, 0.0, 0.0], "axis": [0.0, 0.0, 1.0],
                "radius_m": 0.05, "half_height_m": 0.07, "edge_radius_m": 0.001}}),
        );
        let side = held_at(&can, |sample| sample.normal.z.abs() < 0.1);
        assert!(side.degree(Form::Rod) > 0.7, "{side:?}");
        assert!(side.degree(Form::Sphere) < 0.2, "{side:?}");
        let rim = touching(&can, |sample| {
            sample.normal.z.abs() < 0.1 && sample.point.z > 0.03
        });
        let above = held(&can, &rim, &Vector3::z()).unwrap();
        assert!(above.degree(Form::Disk) > 0.6, "{above:?}");
        let brick = object(
            "brick",
            serde_json::json!({"cuboid": {"centre": [0.0, 0.0, 0.0],
                "half_extents": [0.025, 0.026, 0.039], "edge_radius_m": 0.001}}),
        );
        let block = held_at(&brick, |sample| sample.normal.x.abs() > 0.9);
        assert!(block.degree(Form::Box) > 0.7, "{block:?}");
        assert!(
            (1e3 * block.size_m(&[Form::Box]) - 50.0).abs() < 2.0,
            "{block:?}"
        );
    }
}
