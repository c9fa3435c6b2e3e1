//! Meshes of primitives and pictures of fixtures.

use std::f64::consts::{PI, TAU};

use landscape::figure::{Image, Marker, Scene, Surface};
use landscape::hand::{Hand, PosedHand, Skin};
use landscape::object::{Primitive, Shape};
use nalgebra::{Isometry3, Vector3};

use crate::fixture::Fixture;
use crate::shape::{Union, points};

const COLOUR: [u8; 3] = [128, 164, 190];
const CONTACT: [u8; 3] = [213, 40, 20];
/// Spacing of a mesh's vertices, metres.
const SPACING_M: f64 = 4e-3;

/// A mesh of a primitive, object frame.
pub(crate) fn mesh(primitive: &Primitive) -> Surface {
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
fn lathe(centre: Vector3<f64>, axis: Vector3<f64>, profile: &[[f64; 2]]) -> Surface {
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
    let rows = u32::try_from(profile.len()).expect("a profile has few points");
    let mut triangles = Vec::new();
    for row in 0..rows - 1 {
        for k in 0..around {
            let at = |row: u32, k: u32| row * around + k % around;
            let [a, b, c, d] = [
                at(row, k),
                at(row, k + 1),
                at(row + 1, k),
                at(row + 1, k + 1),
            ];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    Surface {
        vertices,
        triangles,
        colour: COLOUR,
    }
}

fn cuboid(centre: Vector3<f64>, half: Vector3<f64>) -> Surface {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for face in 0..6 {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (columns, rows) = (steps(2.0 * half[u]), steps(2.0 * half[v]));
        let first = u32::try_from(vertices.len()).expect("a box has few vertices");
        for row in 0..=rows {
            for column in 0..=columns {
                let mut p = Vector3::zeros();
                p[axis] = sign * half[axis];
                p[u] = half[u] * (2.0 * f64::from(column) / f64::from(columns) - 1.0);
                p[v] = half[v] * (2.0 * f64::from(row) / f64::from(rows) - 1.0);
                vertices.push(centre + p);
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let at = |r: u32, c: u32| first + r * (columns + 1) + c;
                let [a, b, c, d] = [
                    at(row, column),
                    at(row, column + 1),
                    at(row + 1, column),
                    at(row + 1, column + 1),
                ];
                let both = if sign > 0.0 {
                    [[a, b, d], [a, d, c]]
                } else {
                    [[a, d, b], [a, c, d]]
                };
                triangles.extend(both);
            }
        }
    }
    Surface {
        vertices,
        triangles,
        colour: COLOUR,
    }
}

/// Points of the object's surface that lie in none of its parts.
pub(crate) fn samples(shape: &Union) -> Vec<Vector3<f64>> {
    let all = shape
        .0
        .iter()
        .flat_map(|primitive| mesh(primitive).vertices);
    all.filter(|p| shape.distance(p) > -1e-3).collect()
}

/// Two views of a fixture in the hand's frame: the best one, and one from the thumb's side.
pub(crate) fn views(hand: &Hand, skin: &Skin, fixture: &Fixture, side: u32) -> Option<[Image; 2]> {
    let x = fixture.coordinates(hand)?;
    let shape = fixture.shape();
    let mut posed = PosedHand::default();
    hand.pose(&x, &mut posed);
    let mut markers = Vec::new();
    for region in &fixture.touching {
        let nearest = points(hand, region).into_iter().min_by(|&a, &b| {
            shape
                .distance(&posed.points[a])
                .total_cmp(&shape.distance(&posed.points[b]))
        });
        markers.extend(nearest.map(|i| Marker {
            centre: posed.points[i],
            radius_m: 0.003,
            colour: CONTACT,
        }));
    }
    let mut surfaces = vec![Surface::of_hand(skin, &posed)];
    surfaces.extend(fixture.object.iter().map(mesh));
    let hand_from_object: Isometry3<f64> = landscape::space::object_from_hand(&x).inverse();
    let moved =
        |p: &Vector3<f64>| hand_from_object.rotation * p + hand_from_object.translation.vector;
    for p in surfaces
        .iter_mut()
        .flat_map(|surface| &mut surface.vertices)
    {
        *p = moved(p);
    }
    for marker in &mut markers {
        marker.centre = moved(&marker.centre);
    }
    let scene = Scene {
        surfaces,
        markers,
        ..Scene::default()
    };
    let directions = [
        Vector3::new(0.45, 0.25, 0.86),
        Vector3::new(0.95, 0.2, -0.15),
    ];
    Some(
        directions
            .map(|toward_eye| scene.render(&scene.framed(toward_eye, Vector3::y()), side, side)),
    )
}
