//! Detection of the motions that map a surface onto itself.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Rotation3, SymmetricEigen, Unit, Vector3};
use rayon::prelude::*;

use crate::space::Symmetry;

use crate::mesh::{ExactMesh, Mesh};

/// A symmetry and its accuracy.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundSymmetry {
    /// The motions.
    pub symmetry: Symmetry,
    /// Largest distance from the surface to which a motion takes one of its points, metres.
    pub deviation_m: f64,
}

/// Highest order of a rotation that is tested.
const ORDERS: u32 = 8;
/// Order of the largest finite group that is tested: the rotations of a cube.
const LARGEST_GROUP: usize = 24;
/// Number of vertices that are tested first, to reject early.
const FEW: usize = 300;
/// Cosine above which two axes are the same.
const PARALLEL: f64 = 0.99996;
/// Angle below which two rotations are the same, radians.
const SAME_RAD: f64 = 1e-2;

/// Tests for symmetry about the principal axes of the surface and the axes of its frame, through the centroid: rotational
/// symmetry about a point or an axis, or rotations by 360°/n. A motion counts if it takes no point of the surface farther
/// than `tolerance_m` from it.
///
/// If the principal axes are not unique, axes in other directions are not tested.
pub fn find_symmetry(mesh: &Mesh, exact: &ExactMesh, tolerance_m: f64) -> FoundSymmetry {
    let finder = Finder {
        centre: mesh.centroid(),
        points: mesh.boundary().0,
        exact,
        tolerance_m,
    };
    let axes = axes(mesh, &finder.centre);
    let round: Vec<(Unit<Vector3<f64>>, f64)> = axes
        .iter()
        .filter_map(|axis| Some((*axis, finder.about(axis, &[0.1, 1.0, 2.0, 3.0, 4.5])?)))
        // Two axes make a ball.
        .take(2)
        .collect();
    if let [(_, a), (_, b)] = round[..] {
        return FoundSymmetry {
            symmetry: Symmetry::Sphere {
                centre: finder.centre,
            },
            deviation_m: a.max(b),
        };
    }
    if let [(axis, deviation_m)] = round[..] {
        return FoundSymmetry {
            symmetry: Symmetry::Axis {
                point: finder.centre,
                direction: axis.into_inner(),
            },
            deviation_m,
        };
    }
    let mut generators = Vec::new();
    let mut deviation_m: f64 = 0.0;
    for axis in &axes {
        for order in (2..=ORDERS).rev() {
            let angle = 2.0 * PI / f64::from(order);
            if let Some(off) = finder.about(axis, &[angle]) {
                generators.push(Rotation3::from_axis_angle(axis, angle));
                deviation_m = deviation_m.max(off);
                break;
            }
        }
    }
    let group = group(&generators);
    if group.is_empty() {
        return FoundSymmetry {
            symmetry: Symmetry::None,
            deviation_m: 0.0,
        };
    }
    let motion = |rotation: &Rotation3<f64>| {
        let centre = finder.centre;
        Isometry3::from_parts((centre - rotation * centre).into(), (*rotation).into())
    };
    FoundSymmetry {
        symmetry: Symmetry::Finite(group.iter().map(motion).collect()),
        deviation_m,
    }
}

struct Finder<'a> {
    centre: Vector3<f64>,
    points: &'a [Vector3<f64>],
    exact: &'a ExactMesh,
    tolerance_m: f64,
}

impl Finder<'_> {
    /// Largest distance from the surface to which the rotations take a point, if it is within the tolerance.
    fn about(&self, axis: &Unit<Vector3<f64>>, angles: &[f64]) -> Option<f64> {
        let turns: Vec<Rotation3<f64>> = angles
            .iter()
            .map(|angle| Rotation3::from_axis_angle(axis, *angle))
            .collect();
        // The search for the nearest point ends at this distance, slightly beyond the tolerance because of rounding.
        let reach_m = self.tolerance_m * (1.0 + 1e-9);
        let off = |point: &Vector3<f64>| {
            turns.iter().try_fold(0.0, |worst: f64, turn| {
                let moved = turn * (point - self.centre) + self.centre;
                let gap_m = self.exact.gap_within(&moved, reach_m)?;
                (gap_m <= self.tolerance_m).then_some(worst.max(gap_m))
            })
        };
        let stride = (self.points.len() / FEW).max(1);
        for point in self.points.iter().step_by(stride) {
            off(point)?;
        }
        let all = self.points.par_iter().map(off);
        all.try_reduce(|| 0.0, |a, b| Some(a.max(b)))
    }
}

/// Principal axes of the surface and the axes of the frame, each direction once.
fn axes(mesh: &Mesh, centre: &Vector3<f64>) -> Vec<Unit<Vector3<f64>>> {
    let (vertices, triangles) = mesh.boundary();
    // ∫ x xᵀ dA over a triangle = A/12 (Σ vᵢ vᵢᵀ + (Σ vᵢ)(Σ vᵢ)ᵀ).
    let tensor = triangles
        .iter()
        .fold(Matrix3::zeros(), |sum: Matrix3<f64>, triangle| {
            let corners = triangle.map(|vertex| vertices[vertex as usize] - centre);
            let [a, b, c] = corners;
            let area = (b - a).cross(&(c - a)).norm() / 2.0;
            let total = a + b + c;
            let squares: Matrix3<f64> = corners.iter().map(|v| v * v.transpose()).sum();
            sum + (squares + total * total.transpose()) * (area / 12.0)
        });
    let eigen = SymmetricEigen::new(tensor);
    let principal =
        (0..3).map(|column| Unit::new_normalize(eigen.eigenvectors.column(column).into_owned()));
    let mut axes: Vec<Unit<Vector3<f64>>> = Vec::new();
    // The axes of the frame come first because they are exact where a principal axis is only close.
    let frame = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
    for axis in frame.into_iter().chain(principal) {
        if axes.iter().all(|known| known.dot(&axis).abs() < PARALLEL) {
            axes.push(axis);
        }
    }
    axes
}

/// All products of some rotations, without the identity; empty if there are more than in the group of a cube.
fn group(generators: &[Rotation3<f64>]) -> Vec<Rotation3<f64>> {
    let mut members = vec![Rotation3::identity()];
    let mut next = 0;
    while let Some(member) = members.get(next).copied() {
        next += 1;
        for generator in generators {
            let product = generator * member;
            if members
                .iter()
                .all(|known| known.angle_to(&product) > SAME_RAD)
            {
                members.push(product);
            }
        }
        if members.len() > LARGEST_GROUP {
            return Vec::new();
        }
    }
    members.remove(0);
    members
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::{Cuboid, Object, Primitive};

    fn found(mesh: &Mesh) -> FoundSymmetry {
        find_symmetry(mesh, &ExactMesh::new(mesh), 0.5e-3)
    }

    fn motions(half: [f64; 3]) -> usize {
        let cuboid = Cuboid {
            centre: Vector3::new(0.01, 0.0, 0.2),
            half_extents: half.into(),
            edge_radius_m: 0.0,
        };
        match found(&Primitive::Cuboid(cuboid).mesh("box").unwrap()).symmetry {
            Symmetry::Finite(motions) => motions.len(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn boxes_bottles_and_balls() {
        assert_eq!(motions([0.02, 0.03, 0.05]), 3);
        assert_eq!(motions([0.03, 0.03, 0.05]), 7);
        assert_eq!(motions([0.03, 0.03, 0.03]), 23);
        let (bottle, _) = Object::parts_of_named("bottle_round").unwrap();
        let Symmetry::Axis { direction, .. } = found(&bottle).symmetry else {
            panic!("a round bottle has an axis");
        };
        assert!(direction.z.abs() > 1.0 - 1e-6);
        let (ball, _) = Object::parts_of_named("ball").unwrap();
        assert!(matches!(found(&ball).symmetry, Symmetry::Sphere { .. }));
        let (mug, _) = Object::parts_of_named("mug").unwrap();
        assert_eq!(found(&mug).symmetry, Symmetry::None);
    }

    #[test]
    fn a_tilted_bottle_keeps_its_axis() {
        let (bottle, _) = Object::parts_of_named("bottle_round").unwrap();
        let turn = Rotation3::from_euler_angles(0.4, 0.3, 0.2);
        let vertices = bottle.vertices().iter().map(|v| turn * v).collect();
        let tilted = Mesh::new("bottle", vertices, bottle.triangles().to_vec()).unwrap();
        let Symmetry::Axis { direction, .. } = found(&tilted).symmetry else {
            panic!("a round bottle has an axis");
        };
        assert!((turn * Vector3::z()).dot(&direction).abs() > 1.0 - 1e-5);
    }

    /// The search ends at the tolerance and works in parallel; its number is that of signed distances one by one.
    #[test]
    fn the_deviation_is_that_of_all_vertices() {
        let (bottle, _) = Object::parts_of_named("bottle_round").unwrap();
        let exact = ExactMesh::new(&bottle);
        let found = find_symmetry(&bottle, &exact, 0.5e-3);
        let Symmetry::Axis { point, direction } = found.symmetry else {
            panic!("a round bottle has an axis");
        };
        let axis = Unit::new_normalize(direction);
        let mut worst: f64 = 0.0;
        for angle in [0.1, 1.0, 2.0, 3.0, 4.5] {
            let turn = Rotation3::from_axis_angle(&axis, angle);
            for vertex in bottle.vertices() {
                let moved = turn * (vertex - point) + point;
                worst = worst.max(exact.distance(&moved).abs());
            }
        }
        assert!(worst > 0.0);
        assert_eq!(found.deviation_m.to_bits(), worst.to_bits());
        // Just below the deviation it is none.
        let none = find_symmetry(&bottle, &exact, worst * (1.0 - 1e-6));
        assert!(!matches!(none.symmetry, Symmetry::Axis { .. }), "{none:?}");
        let still = find_symmetry(&bottle, &exact, worst);
        assert!(matches!(still.symmetry, Symmetry::Axis { .. }), "{still:?}");
    }
}
