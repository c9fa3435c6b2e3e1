//! Exact signed distance to a mesh: the judge that filters, reports and the baking of fields refer to.
//!
//! The only place that speaks to parry, whose vectors are not nalgebra's.

use nalgebra::Vector3;
use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

use super::Mesh;

/// A mesh with a search tree and angle-weighted pseudo-normals (Bærentzen and Aanæs 2005).
///
/// The solid is the union of its closed pieces. Outside, distances are exact; inside an overlap of pieces the depth is
/// that in the deepest single piece.
#[derive(Debug, Clone)]
pub struct ExactMesh {
    pieces: Vec<TriMesh>,
}

/// The nearest point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Signed distance, metres, negative inside.
    pub distance_m: f64,
    /// The nearest point.
    pub point: Vector3<f64>,
    /// Gradient of the distance: away from the surface outside, toward it inside; the triangle's normal on it.
    pub normal: Vector3<f64>,
}

/// Below this distance a direction from the surface is rounding error, metres.
const ON_SURFACE_M: f64 = 1e-9;

impl ExactMesh {
    /// Prepares `mesh` for queries.
    ///
    /// # Panics
    /// Never: a [`Mesh`] has triangles.
    pub fn new(mesh: &Mesh) -> Self {
        let vertices: Vec<ParryVector> = mesh.vertices().iter().map(to_parry).collect();
        let build = |triangles: Vec<[u32; 3]>| {
            TriMesh::with_flags(vertices.clone(), triangles, TriMeshFlags::ORIENTED)
                .expect("a mesh has triangles")
        };
        // A piece that is inside out is the wall of a cavity, and means something only together with the others.
        let pieces = mesh.pieces();
        let cavity =
            pieces.len() > 1 && pieces.iter().any(|piece| signed_volume(mesh, piece) < 0.0);
        let pieces = if cavity {
            vec![mesh.triangles().to_vec()]
        } else {
            pieces
        };
        Self {
            pieces: pieces.into_iter().map(build).collect(),
        }
    }

    /// Signed distance at `point`, metres, negative inside.
    pub fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.nearest(point).distance_m
    }

    /// The nearest point of the surface. Costs a few microseconds.
    ///
    /// # Panics
    /// If `point` is not finite.
    pub fn nearest(&self, point: &Vector3<f64>) -> Nearest {
        self.nearest_within(point, f64::MAX)
            .expect("a finite point has a nearest point on a mesh")
    }

    /// The nearest point of the surface if it is closer than `reach_m`.
    pub(super) fn nearest_within(&self, point: &Vector3<f64>, reach_m: f64) -> Option<Nearest> {
        let query = to_parry(point);
        let in_piece = |piece: &TriMesh| {
            let (projection, (triangle, _)) =
                piece.project_local_point_and_get_location_with_max_dist(query, false, reach_m)?;
            let nearest = from_parry(projection.point);
            let offset = point - nearest;
            let length = offset.norm();
            let sign = if projection.is_inside { -1.0 } else { 1.0 };
            let normal = if length > ON_SURFACE_M {
                offset * (sign / length)
            } else {
                piece
                    .triangle(triangle)
                    .normal()
                    .map_or_else(Vector3::z, from_parry)
            };
            Some(Nearest {
                distance_m: sign * length,
                point: nearest,
                normal,
            })
        };
        self.pieces
            .iter()
            .filter_map(in_piece)
            .min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))
    }
}

/// Six times the volume that `triangles` enclose; negative where they are inside out.
pub(super) fn signed_volume(mesh: &Mesh, triangles: &[[u32; 3]]) -> f64 {
    let corner =
        |index: u32| mesh.vertices()[index as usize] - mesh.vertices()[triangles[0][0] as usize];
    triangles
        .iter()
        .map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))))
        .sum()
}

fn to_parry(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}

fn from_parry(v: ParryVector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes from one corner to another as one mesh; `true` turns a box inside out.
    fn boxes(boxes: &[([f64; 3], [f64; 3], bool)]) -> ExactMesh {
        const FACES: [[u32; 3]; 12] = [
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ];
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for (first, &(low, high, inside_out)) in (0..).step_by(8).zip(boxes) {
            let side = |corner: u8, axis: usize| {
                if corner >> axis & 1 == 0 {
                    low[axis]
                } else {
                    high[axis]
                }
            };
            vertices.extend((0..8).map(|corner| Vector3::from_fn(|axis, _| side(corner, axis))));
            let face = |[a, b, c]: [u32; 3]| if inside_out { [a, c, b] } else { [a, b, c] };
            triangles.extend(FACES.map(|corners| face(corners.map(|corner| corner + first))));
        }
        ExactMesh::new(&Mesh::new("boxes", vertices, triangles).unwrap())
    }

    #[test]
    fn distances_to_a_box_are_exact() {
        let cube = boxes(&[([0.0; 3], [0.1; 3], false)]);
        for (point, distance_m, normal) in [
            ([0.05, 0.05, 0.12], 0.02, [0.0, 0.0, 1.0]),
            ([0.05, 0.05, 0.09], -0.01, [0.0, 0.0, 1.0]),
            ([0.13, 0.14, 0.05], 0.05, [0.6, 0.8, 0.0]),
            ([0.1, 0.04, 0.03], 0.0, [1.0, 0.0, 0.0]),
        ] {
            let nearest = cube.nearest(&point.into());
            assert!(
                (nearest.distance_m - distance_m).abs() < 1e-12,
                "{nearest:?}"
            );
            assert!(
                (nearest.normal - Vector3::from(normal)).norm() < 1e-9,
                "{nearest:?}"
            );
        }
    }

    #[test]
    fn overlapping_pieces_are_a_union() {
        let across = ([0.0, 0.04, 0.0], [0.1, 0.06, 0.02], false);
        let along = ([0.04, 0.0, 0.0], [0.06, 0.1, 0.02], false);
        let cross = boxes(&[across, along]);
        // Just outside the wall of one bar, but within the other.
        assert!(cross.distance(&Vector3::new(0.05, 0.062, 0.01)) < -0.009);
        assert!((cross.distance(&Vector3::new(0.08, 0.08, 0.01)) - 0.02).abs() < 1e-12);
    }

    #[test]
    fn an_inner_wall_is_a_cavity() {
        let shell = boxes(&[([0.0; 3], [0.1; 3], false), ([0.02; 3], [0.08; 3], true)]);
        assert!((shell.distance(&Vector3::repeat(0.05)) - 0.03).abs() < 1e-12);
        assert!((shell.distance(&Vector3::new(0.05, 0.05, 0.01)) + 0.01).abs() < 1e-12);
    }
}
