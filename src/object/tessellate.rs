//! Fine meshes of primitives.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Rotation3, Vector3};

use super::{Capsule, Cuboid, Cylinder, ObjectError, Primitive, Sphere, within};
use crate::limits::{MESH_COORDINATE, MESH_SIZE};
use crate::mesh::Mesh;

/// Number of corners around an axis.
const AROUND: u32 = 96;
/// Number of steps of a quarter circle.
const QUARTER: u32 = 24;
/// Number of steps of a rounded edge.
const EDGE: u32 = 6;

impl Primitive {
    /// The shape as a mesh whose corners lie on it. Faces deviate by less than a thousandth of a radius.
    ///
    /// # Errors
    /// If a size or position is beyond its limit, or if a rounding is larger than the shape.
    pub fn mesh(&self, name: &str) -> Result<Mesh, ObjectError> {
        self.check(name)?;
        let (vertices, triangles) = match self {
            Self::Sphere(Sphere { centre, radius_m }) => {
                let profile = arc([0.0, 0.0], *radius_m, -FRAC_PI_2, FRAC_PI_2, 2 * QUARTER);
                revolved(centre, &Vector3::z(), &profile)
            }
            Self::Capsule(Capsule { a, b, radius_m }) => {
                let half = (b - a).norm() / 2.0;
                let mut profile = arc([0.0, -half], *radius_m, -FRAC_PI_2, 0.0, QUARTER);
                profile.extend(arc([0.0, half], *radius_m, 0.0, FRAC_PI_2, QUARTER));
                let axis = (b - a).try_normalize(1e-12).unwrap_or_else(Vector3::z);
                revolved(&((a + b) / 2.0), &axis, &profile)
            }
            Self::Cylinder(cylinder) => {
                let Cylinder {
                    centre,
                    axis,
                    radius_m,
                    half_height_m,
                    edge_radius_m: edge,
                } = cylinder;
                let (rim, top) = (radius_m - edge, half_height_m - edge);
                let mut profile = vec![[0.0, -half_height_m]];
                profile.extend(arc([rim, -top], *edge, -FRAC_PI_2, 0.0, EDGE));
                profile.extend(arc([rim, top], *edge, 0.0, FRAC_PI_2, EDGE));
                profile.push([0.0, *half_height_m]);
                revolved(centre, axis, &profile)
            }
            Self::Cuboid(cuboid) => box_of(cuboid),
        };
        Ok(Mesh::new(name, vertices, triangles)?)
    }

    /// Refuses sizes and positions beyond their limits, and roundings larger than the shape. `name` is its name in errors.
    pub(super) fn check(&self, name: &str) -> Result<(), ObjectError> {
        let sizes = |field, sizes: &[f64]| within(MESH_SIZE, sizes, (name, field));
        let place = |field, place: &Vector3<f64>| within(MESH_COORDINATE, place, (name, field));
        let rounding = |edge: f64, most: f64| {
            (0.0..=most)
                .contains(&edge)
                .then_some(())
                .ok_or_else(|| ObjectError::Value {
                    name: name.to_owned(),
                    field: "edge_radius_m",
                    problem: "it must lie between 0 and the smallest half size",
                })
        };
        match self {
            Self::Sphere(Sphere { centre, radius_m }) => {
                place("centre", centre)?;
                sizes("radius_m", &[*radius_m])
            }
            Self::Capsule(Capsule { a, b, radius_m }) => {
                place("a", a)?;
                place("b", b)?;
                sizes("radius_m", &[*radius_m])
            }
            Self::Cylinder(cylinder) => {
                let [radius, half] = [cylinder.radius_m, cylinder.half_height_m];
                place("centre", &cylinder.centre)?;
                sizes("radius_m", &[radius])?;
                sizes("half_height_m", &[half])?;
                rounding(cylinder.edge_radius_m, radius.min(half))
            }
            Self::Cuboid(cuboid) => {
                let half = &cuboid.half_extents;
                place("centre", &cuboid.centre)?;
                sizes("half_extents", half.as_slice())?;
                rounding(cuboid.edge_radius_m, half.min())
            }
        }
    }
}

type Parts = (Vec<Vector3<f64>>, Vec<[u32; 3]>);

/// Points (distance from the axis, height) of an arc.
fn arc([x, z]: [f64; 2], radius: f64, from: f64, to: f64, steps: u32) -> Vec<[f64; 2]> {
    let point = |step: u32| {
        let angle = from + (to - from) * f64::from(step) / f64::from(steps);
        [x + radius * libm::cos(angle), z + radius * libm::sin(angle)]
    };
    if radius > 0.0 {
        (0..=steps).map(point).collect()
    } else {
        vec![[x, z]]
    }
}

/// A profile from the lower end of the axis to the upper, revolved about it.
fn revolved(centre: &Vector3<f64>, axis: &Vector3<f64>, profile: &[[f64; 2]]) -> Parts {
    let turn = Rotation3::rotation_between(&Vector3::z(), axis)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), PI));
    let scale = profile
        .iter()
        .flatten()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    // Roundings as large as the shape give equal neighbours.
    let mut rings: Vec<[f64; 2]> = Vec::new();
    for &[x, z] in profile {
        let same = |[a, b]: &[f64; 2]| libm::hypot(a - x, b - z) < 1e-9 * scale;
        if !rings.last().is_some_and(same) {
            rings.push([x, z]);
        }
    }
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    let mut starts = Vec::new();
    for &[x, z] in &rings {
        starts.push(u32::try_from(vertices.len()).unwrap_or(u32::MAX));
        let pole = x < 1e-9 * scale;
        for step in 0..if pole { 1 } else { AROUND } {
            let angle = 2.0 * PI * f64::from(step) / f64::from(AROUND);
            let x = if pole { 0.0 } else { x };
            let point = Vector3::new(x * libm::cos(angle), x * libm::sin(angle), z);
            vertices.push(centre + turn * point);
        }
    }
    let single = |ring: usize| rings[ring][0] < 1e-9 * scale;
    for ring in 1..rings.len() {
        for step in 0..AROUND {
            let at = |ring: usize, step: u32| {
                starts[ring] + if single(ring) { 0 } else { step % AROUND }
            };
            let [a, b] = [at(ring - 1, step), at(ring - 1, step + 1)];
            let [c, d] = [at(ring, step), at(ring, step + 1)];
            if !single(ring - 1) {
                triangles.push([a, b, d]);
            }
            if !single(ring) {
                triangles.push([a, d, c]);
            }
        }
    }
    (vertices, triangles)
}

/// A box with rounded edges: a grid on each face is moved outward from the box without its rounding.
fn box_of(cuboid: &Cuboid) -> Parts {
    let edge = cuboid.edge_radius_m;
    let half = cuboid.half_extents;
    let inner = half.add_scalar(-edge);
    // Coordinates along each axis: the rounding in equal angles, the flat part between them.
    let lines: [Vec<f64>; 3] = [0, 1, 2].map(|axis| {
        let steps = if edge > 0.0 { EDGE } else { 0 };
        let bend = |step: u32| {
            // Between two faces the direction turns by 90°, half of it on either face.
            inner[axis] + edge * libm::tan(PI / 4.0 * f64::from(step) / f64::from(steps.max(1)))
        };
        let mut line: Vec<f64> = (0..=steps).map(bend).collect();
        if let Some(last) = line.last_mut() {
            *last = half[axis];
        }
        let mut both: Vec<f64> = line.iter().rev().map(|x| -x).collect();
        if inner[axis] > 0.0 {
            both.extend([-0.5, 0.0, 0.5].map(|share| share * inner[axis]));
            both.extend(&line);
        } else {
            both.extend(&line[1..]);
        }
        both
    });
    let place = |point: Vector3<f64>| {
        let core = point.zip_map(&inner, |x, limit| x.clamp(-limit, limit));
        let out = point - core;
        let length = out.norm();
        let moved = if length > 0.0 {
            core + out * (edge / length)
        } else {
            point
        };
        cuboid.centre + moved
    };
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        for side in [-1.0, 1.0] {
            let first = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
            let across = u32::try_from(lines[v].len()).unwrap_or(u32::MAX);
            for &a in &lines[u] {
                for &b in &lines[v] {
                    let mut point = Vector3::zeros();
                    point[axis] = side * half[axis];
                    point[u] = a;
                    point[v] = b;
                    vertices.push(place(point));
                }
            }
            let rows = u32::try_from(lines[u].len()).unwrap_or(u32::MAX);
            for i in 0..rows - 1 {
                for j in 0..across - 1 {
                    let [a, b] = [first + i * across + j, first + i * across + j + 1];
                    let [c, d] = [a + across, b + across];
                    let quad = [[a, c, d], [a, d, b]];
                    let outward =
                        |[p, q, r]: [u32; 3]| if side > 0.0 { [p, q, r] } else { [p, r, q] };
                    triangles.extend(quad.map(outward));
                }
            }
        }
    }
    (vertices, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Unit;

    fn corners_lie_on(shape: &Primitive, mesh: &Mesh) {
        let formula = shape.shape();
        let off = mesh
            .vertices()
            .iter()
            .map(|v| formula.distance(v).abs())
            .fold(0.0, f64::max);
        assert!(off < 1e-12, "{shape:?}: {off}");
    }

    #[test]
    fn corners_lie_on_the_shape_and_volumes_are_right() {
        let tilted = Unit::new_normalize(Vector3::new(0.3, -1.0, 0.2));
        let centre = Vector3::new(0.01, 0.02, 0.03);
        let shapes = [
            (
                Primitive::Sphere(Sphere {
                    centre,
                    radius_m: 0.04,
                }),
                4.0 / 3.0 * PI * 0.04f64.powi(3),
            ),
            (
                Primitive::Capsule(Capsule {
                    a: centre,
                    b: centre + tilted.into_inner() * 0.1,
                    radius_m: 0.02,
                }),
                PI * 0.02f64.powi(2) * (0.1 + 4.0 / 3.0 * 0.02),
            ),
            (
                Primitive::Cylinder(Cylinder {
                    centre,
                    axis: tilted,
                    radius_m: 0.03,
                    half_height_m: 0.05,
                    edge_radius_m: 0.0,
                }),
                PI * 0.03f64.powi(2) * 0.1,
            ),
            (
                Primitive::Cuboid(Cuboid {
                    centre,
                    half_extents: Vector3::new(0.02, 0.03, 0.05),
                    edge_radius_m: 0.0,
                }),
                8.0 * 0.02 * 0.03 * 0.05,
            ),
        ];
        for (shape, volume) in shapes {
            let mesh = shape.mesh("shape").unwrap();
            assert!(
                (mesh.volume() / volume - 1.0).abs() < 3e-3,
                "{shape:?}: {}",
                mesh.volume()
            );
            corners_lie_on(&shape, &mesh);
        }
        let rounded = [
            Primitive::Cylinder(Cylinder {
                centre,
                axis: tilted,
                radius_m: 0.03,
                half_height_m: 0.05,
                edge_radius_m: 0.01,
            }),
            Primitive::Cylinder(Cylinder {
                centre,
                axis: tilted,
                radius_m: 0.03,
                half_height_m: 0.03,
                edge_radius_m: 0.03,
            }),
            Primitive::Cuboid(Cuboid {
                centre,
                half_extents: Vector3::new(0.02, 0.03, 0.05),
                edge_radius_m: 0.01,
            }),
            Primitive::Cuboid(Cuboid {
                centre,
                half_extents: Vector3::new(0.02, 0.03, 0.05),
                edge_radius_m: 0.02,
            }),
        ];
        for shape in rounded {
            let mesh = shape.mesh("shape").unwrap();
            corners_lie_on(&shape, &mesh);
            let formula = shape.shape();
            let within = mesh
                .sample_surface(300, 0)
                .iter()
                .map(|s| formula.distance(&s.point).abs())
                .fold(0.0, f64::max);
            assert!(within < 3e-4, "{shape:?}: {within}");
        }
    }

    #[test]
    fn impossible_sizes_are_refused() {
        let ball = Primitive::Sphere(Sphere {
            centre: Vector3::zeros(),
            radius_m: -1.0,
        });
        assert!(
            ball.mesh("ball")
                .unwrap_err()
                .to_string()
                .contains("radius_m")
        );
    }
}
