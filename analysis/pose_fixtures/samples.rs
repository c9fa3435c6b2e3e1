//! Points of the surfaces of primitives.

use std::f64::consts::{PI, TAU};

use landscape::object::{Primitive, Shape};
use nalgebra::Vector3;

use crate::shape::Union;

/// Spacing of the points, metres.
const SPACING_M: f64 = 4e-3;

/// Points of a primitive, object frame.
fn points(primitive: &Primitive) -> Vec<Vector3<f64>> {
    match primitive {
        Primitive::Sphere(s) => lathe(s.centre, Vector3::z(), &arc(s.radius_m, 0.0, 0.0, PI)),
        Primitive::Capsule(c) => {
            let axis = c.b - c.a;
            let half = 0.5 * axis.norm();
            let mut profile = arc(c.radius_m, half, 0.0, 0.5 * PI);
            profile.extend(straight([c.radius_m, half], [c.radius_m, -half]));
            profile.extend(arc(c.radius_m, -half, 0.5 * PI, PI));
            let axis = axis.try_normalize(1e-9).unwrap_or_else(Vector3::z);
            lathe(0.5 * (c.a + c.b), axis, &profile)
        }
        Primitive::Cylinder(c) => {
            let (r, h) = (c.radius_m, c.half_height_m);
            let mut profile = straight([0.0, h], [r, h]);
            profile.extend(straight([r, h], [r, -h]));
            profile.extend(straight([r, -h], [0.0, -h]));
            lathe(c.centre, c.axis.into_inner(), &profile)
        }
        Primitive::Cuboid(c) => cuboid(c.centre, c.half_extents),
    }
}

fn steps(length: f64) -> u32 {
    let mut count = 1;
    while f64::from(count) * SPACING_M < length {
        count += 1;
    }
    count
}

fn arc(radius: f64, height: f64, from: f64, to: f64) -> Vec<[f64; 2]> {
    let count = steps(radius * (to - from)).max(5);
    let angle = |k: u32| from + (to - from) * f64::from(k) / f64::from(count);
    (0..=count)
        .map(|k| {
            [
                radius * libm::sin(angle(k)),
                height + radius * libm::cos(angle(k)),
            ]
        })
        .collect()
}

fn straight(from: [f64; 2], to: [f64; 2]) -> Vec<[f64; 2]> {
    let count = steps(libm::hypot(to[0] - from[0], to[1] - from[1]));
    (0..=count)
        .map(|k| {
            let t = f64::from(k) / f64::from(count);
            [
                from[0] + t * (to[0] - from[0]),
                from[1] + t * (to[1] - from[1]),
            ]
        })
        .collect()
}

/// The surface of revolution of a profile (radius, height) with descending height.
fn lathe(centre: Vector3<f64>, axis: Vector3<f64>, profile: &[[f64; 2]]) -> Vec<Vector3<f64>> {
    let side = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
    let other = axis.cross(&side);
    let widest = profile.iter().map(|p| p[0]).fold(0.0, f64::max);
    let around = steps(TAU * widest).max(16);
    let mut vertices = Vec::new();
    for [radius, height] in profile {
        for k in 0..around {
            let (sin, cos) = libm::sincos(TAU * f64::from(k) / f64::from(around));
            vertices.push(centre + axis * *height + (side * cos + other * sin) * *radius);
        }
    }
    vertices
}

fn cuboid(centre: Vector3<f64>, half: Vector3<f64>) -> Vec<Vector3<f64>> {
    let mut vertices = Vec::new();
    for face in 0..6 {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (columns, rows) = (steps(2.0 * half[u]), steps(2.0 * half[v]));
        for row in 0..=rows {
            for column in 0..=columns {
                let mut p = Vector3::zeros();
                p[axis] = sign * half[axis];
                p[u] = half[u] * (2.0 * f64::from(column) / f64::from(columns) - 1.0);
                p[v] = half[v] * (2.0 * f64::from(row) / f64::from(rows) - 1.0);
                vertices.push(centre + p);
            }
        }
    }
    vertices
}

/// Points of the object's surface that lie in none of its parts.
pub(crate) fn of(shape: &Union) -> Vec<Vector3<f64>> {
    let all = shape.0.iter().flat_map(points);
    all.filter(|p| shape.distance(p) > -1e-3).collect()
}
