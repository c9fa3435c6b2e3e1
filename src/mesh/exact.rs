//! Exact signed distance to a mesh. Filters, reports and the baking of fields use it.
//!
//! Only this module and the trees use parry, whose vectors are not nalgebra's.

use nalgebra::Vector3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::{Pose, Vector as ParryVector};
use parry3d_f64::query::details::distance_segment_segment;
use parry3d_f64::query::{PointQuery, PointQueryWithLocation, Ray, RayCast};
use parry3d_f64::shape::{Segment, TriMesh, Triangle};

use super::Mesh;
use super::winding::Winding;

/// A mesh with search trees for the nearest point and for inside tests.
///
/// The solid is the union of its closed pieces. If these overlap or touch, distances are those to the surface of the union.
/// A point is inside if its winding number exceeds one half. Unlike pseudo-normals at the nearest point, this test is
/// robust to degenerate triangles, which published meshes contain.
#[derive(Debug, Clone)]
pub struct ExactMesh {
    surface: TriangleTree,
    winding: Winding,
}

/// Triangles with a search tree, closed or not.
#[derive(Debug, Clone)]
pub struct TriangleTree(TriMesh);

/// The nearest point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Signed distance, metres, negative inside.
    pub distance_m: f64,
    /// The nearest point.
    pub point: Vector3<f64>,
    /// Gradient of the distance: away from the surface outside, toward it inside. On the surface it is the triangle's
    /// normal.
    pub normal: Vector3<f64>,
}

/// Distance below which a direction from the surface is rounding error, metres.
const ON_SURFACE_M: f64 = 1e-9;

/// Number of triangles from which on the tree of discs finds distances sooner than parry's tree of boxes. Both find the
/// same.
const FINE: usize = 20_000;

/// Accuracy of depths, metres.
pub const DEPTH_TOLERANCE_M: f64 = 8e-5;

impl TriangleTree {
    /// A tree over `triangles`, which index `vertices`; `None` if there are no triangles.
    pub fn new(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Option<Self> {
        let corners = vertices.iter().map(to_parry).collect();
        TriMesh::new(corners, triangles.to_vec()).ok().map(Self)
    }

    /// The corners of each triangle.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [Vector3<f64>; 3]> + '_ {
        let corners = self.0.triangles();
        corners.map(|triangle| triangle.vertices().map(from_parry))
    }

    /// The nearest point of the triangles.
    pub(crate) fn foot(&self, point: &Vector3<f64>) -> Vector3<f64> {
        from_parry(self.0.project_local_point(to_parry(point), false).point)
    }
}

impl ExactMesh {
    /// Prepares `mesh` for queries.
    ///
    /// # Panics
    /// Never: a [`Mesh`] has triangles.
    pub fn new(mesh: &Mesh) -> Self {
        let (vertices, triangles) = mesh.boundary();
        Self {
            surface: TriangleTree::new(vertices, triangles).expect("a mesh has triangles"),
            winding: Winding::new(vertices, triangles),
        }
    }

    /// The surface of the solid.
    pub fn surface(&self) -> &TriangleTree {
        &self.surface
    }

    /// Signed distance at `point`, metres, negative inside.
    pub fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.nearest(point).distance_m
    }

    /// The nearest point of the surface. It costs a few microseconds.
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
        let (projection, (triangle, _)) = self
            .surface
            .0
            .project_local_point_and_get_location_with_max_dist(query, false, reach_m)?;
        let nearest = from_parry(projection.point);
        let offset = point - nearest;
        let length = offset.norm();
        let sign = if self.surrounds(point) { -1.0 } else { 1.0 };
        let normal = if length > ON_SURFACE_M {
            offset * (sign / length)
        } else {
            self.surface
                .0
                .triangle(triangle)
                .normal()
                .map_or_else(Vector3::z, from_parry)
        };
        Some(Nearest {
            distance_m: sign * length,
            point: nearest,
            normal,
        })
    }

    /// Unsigned distance of `point` from the surface, metres. It costs less than the signed one.
    ///
    /// # Panics
    /// If `point` is not finite.
    pub(crate) fn gap(&self, point: &Vector3<f64>) -> f64 {
        self.gap_within(point, f64::MAX)
            .expect("a finite point has a nearest point on a mesh")
    }

    /// Unsigned distance of `point` from the surface if it is less than `reach_m`.
    pub(crate) fn gap_within(&self, point: &Vector3<f64>, reach_m: f64) -> Option<f64> {
        if self.surface.0.indices().len() > FINE {
            return self.winding.gap_within(point, reach_m);
        }
        let query = to_parry(point);
        let (projection, _) = self
            .surface
            .0
            .project_local_point_and_get_location_with_max_dist(query, false, reach_m)?;
        Some((point - from_parry(projection.point)).norm())
    }

    /// Distance from a point of the surface along a unit vector to the next point of the surface, metres; `None` if there is
    /// none.
    pub fn next_along(&self, point: &Vector3<f64>, direction: &Vector3<f64>) -> Option<f64> {
        /// How far before the start nothing is looked for, metres, because the triangle of the start is there.
        const START_M: f64 = 1e-6;
        let ray = Ray::new(
            to_parry(&(point + direction * START_M)),
            to_parry(direction),
        );
        let met = self.surface.0.cast_local_ray(&ray, f64::MAX, false)?;
        Some(met + START_M)
    }

    /// Whether `point` lies inside the solid.
    pub(crate) fn surrounds(&self, point: &Vector3<f64>) -> bool {
        self.winding.surrounds(point)
    }

    /// Largest depth of a point of the triangles inside the solid, metres, if it exceeds `known_m`; otherwise `known_m`.
    ///
    /// `place` is the rigid motion that takes the triangles to the frame of the solid. The result is the depth of a point
    /// of the triangles, and no point is deeper by more than [`DEPTH_TOLERANCE_M`]. The method is branch and bound with two
    /// bounds: the signed distance changes no faster than a point moves, and a point of a triangle is no deeper than the
    /// greatest distance of its corners from any one triangle of the surface, because that distance is convex.
    pub fn deepest(
        &self,
        triangles: &TriangleTree,
        place: impl Fn(&Vector3<f64>) -> Vector3<f64>,
        known_m: f64,
    ) -> f64 {
        let found = triangles.0.bvh().find_best(
            -known_m,
            |node, best| {
                let (low, high) = (from_parry(node.mins()), from_parry(node.maxs()));
                let radius_m = (high - low).norm() / 2.0;
                let beaten_m = DEPTH_TOLERANCE_M - best;
                self.depth_near(&place(&low.lerp(&high, 0.5)), radius_m, beaten_m)
                    .map_or(f64::MAX, |(depth_m, _)| {
                        DEPTH_TOLERANCE_M - (depth_m + radius_m)
                    })
            },
            |triangle, best| {
                let Triangle { a, b, c } = triangles.0.triangle(triangle);
                let corners = [a, b, c].map(|corner| place(&from_parry(corner)));
                Some(-self.deepest_in(corners, -best))
            },
        );
        found.map_or(known_m, |(_, cost)| -cost)
    }

    /// [`ExactMesh::deepest`] for a single triangle.
    fn deepest_in(&self, corners: [Vector3<f64>; 3], known_m: f64) -> f64 {
        let mut best_m = known_m;
        let mut open = vec![corners];
        while let Some([a, b, c]) = open.pop() {
            let middle = (a + b + c) / 3.0;
            let radius_m = [a, b, c].iter().fold(0.0, |radius: f64, corner| {
                radius.max((corner - middle).norm())
            });
            let beaten_m = best_m + DEPTH_TOLERANCE_M;
            let Some((depth_m, nearest)) = self.depth_near(&middle, radius_m, beaten_m) else {
                continue;
            };
            best_m = best_m.max(depth_m);
            let nearest = self.surface.0.triangle(nearest);
            let far =
                |corner: &Vector3<f64>| nearest.distance_to_local_point(to_parry(corner), true);
            let (corner, far_m) = [a, b, c]
                .map(|corner| (corner, far(&corner)))
                .into_iter()
                .fold(
                    (a, 0.0),
                    |most, next| if next.1 > most.1 { next } else { most },
                );
            let bound_m = far_m.min(depth_m + radius_m);
            if bound_m <= best_m + DEPTH_TOLERANCE_M {
                continue;
            }
            best_m = best_m.max(-self.distance(&corner));
            if bound_m > best_m + DEPTH_TOLERANCE_M {
                open.extend(halves([a, b, c]));
            }
        }
        best_m
    }

    /// Depth at `point`, negative outside, and the nearest triangle. The result is `None` if no point within `radius_m` can
    /// be deeper than `beaten_m`.
    fn depth_near(&self, point: &Vector3<f64>, radius_m: f64, beaten_m: f64) -> Option<(f64, u32)> {
        let query = to_parry(point);
        // A point outside must be nearer to the surface than this to have a point deeper than `beaten_m` within `radius_m`.
        let reach_m = radius_m - beaten_m;
        let bounds = self.surface.0.bvh().root_aabb();
        let apart_m = bounds.distance_to_local_point(query, true);
        if apart_m > 0.0 && apart_m >= reach_m {
            return None;
        }
        let nearest = |reach_m| {
            let (projection, (triangle, _)) = self
                .surface
                .0
                .project_local_point_and_get_location_with_max_dist(query, false, reach_m)?;
            Some(((point - from_parry(projection.point)).norm(), triangle))
        };
        if reach_m > 0.0
            && let Some((distance_m, triangle)) = nearest(reach_m)
        {
            let sign = if self.surrounds(point) { 1.0 } else { -1.0 };
            return Some((sign * distance_m, triangle));
        }
        if self.surrounds(point) {
            nearest(f64::MAX)
        } else {
            None
        }
    }

    /// Exact distance of the surface from the segment between two ends, metres, if it is less than `reach_m`; 0 if they
    /// cross. It costs a microsecond if the surface is out of reach and somewhat more otherwise.
    pub fn segment_distance_within(&self, ends: &[Vector3<f64>; 2], reach_m: f64) -> Option<f64> {
        let segment = Segment::new(to_parry(&ends[0]), to_parry(&ends[1]));
        let middle = (segment.a + segment.b) * 0.5;
        let half = (segment.b - segment.a).abs() * 0.5;
        let nearest = self.surface.0.bvh().find_best(
            reach_m,
            // The distance of two boxes is a lower bound of the distance of their contents.
            |node, _| {
                let (low, high) = (node.mins() - half, node.maxs() + half);
                Aabb::new(low, high).distance_to_local_point(middle, true)
            },
            |triangle, _| {
                Some(triangle_distance(
                    &self.surface.0.triangle(triangle),
                    &segment,
                ))
            },
        );
        nearest
            .map(|(_, distance)| distance)
            .filter(|&distance| distance < reach_m)
    }
}

/// Splits a triangle through the middle of its longest edge.
fn halves(corners: [Vector3<f64>; 3]) -> [[Vector3<f64>; 3]; 2] {
    let [a, b, c] = corners;
    let turns = [[a, b, c], [b, c, a], [c, a, b]];
    let longest = turns.into_iter().fold(turns[0], |longest, turn| {
        let squared = |[from, to, _]: [Vector3<f64>; 3]| (to - from).norm_squared();
        if squared(turn) > squared(longest) {
            turn
        } else {
            longest
        }
    });
    let [from, to, other] = longest;
    let middle = from.lerp(&to, 0.5);
    [[from, middle, other], [middle, to, other]]
}

/// Distance of a segment from a triangle. It is attained at an end, at the crossing with the triangle's plane, or at an
/// edge.
fn triangle_distance(triangle: &Triangle, segment: &Segment) -> f64 {
    let along = segment.b - segment.a;
    let normal = (triangle.b - triangle.a).cross(triangle.c - triangle.a);
    let crossing = normal.dot(triangle.a - segment.a) / normal.dot(along);
    // The crossing is not finite if the segment is parallel to the plane; the other points then decide.
    let crossing = if crossing.is_finite() {
        crossing.clamp(0.0, 1.0)
    } else {
        0.0
    };
    let points = [segment.a, segment.b, segment.a + along * crossing];
    let of_points = points.map(|point| triangle.distance_to_local_point(point, true));
    let of_edges = triangle
        .edges()
        .map(|edge| distance_segment_segment(&Pose::IDENTITY, &edge, segment));
    of_points
        .into_iter()
        .chain(of_edges)
        .fold(f64::INFINITY, f64::min)
}

/// Six times the volume that `triangles` enclose; negative if they are inside out.
pub(crate) fn signed_volume(mesh: &Mesh, triangles: &[[u32; 3]]) -> f64 {
    let corner =
        |index: u32| mesh.vertices()[index as usize] - mesh.vertices()[triangles[0][0] as usize];
    triangles
        .iter()
        .map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))))
        .sum()
}

pub(super) fn to_parry(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}

fn from_parry(v: ParryVector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::super::testing::box_mesh;
    use super::*;

    fn boxes(boxes: &[([f64; 3], [f64; 3], bool)]) -> ExactMesh {
        ExactMesh::new(&box_mesh(boxes))
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
    fn distances_from_a_segment_are_exact() {
        let cube = boxes(&[([0.0; 3], [0.1; 3], false)]);
        let reach_m = 0.03;
        for (ends, distance) in [
            // Over a face, out of reach, over an edge, before a corner, across an edge.
            ([[0.02, 0.03, 0.12], [0.05, 0.06, 0.15]], Some(0.02)),
            ([[0.13, 0.05, 0.131], [0.13, 0.20, 0.131]], None),
            (
                [[0.12, 0.05, 0.12], [0.12, 0.20, 0.12]],
                Some(0.02 * 2.0_f64.sqrt()),
            ),
            ([[0.105, 0.11, 0.11], [0.2, 0.2, 0.2]], Some(0.015)),
            ([[0.12, 0.08, 0.05], [0.08, 0.12, 0.05]], Some(0.0)),
            // Through it, within it, without length.
            ([[0.05, 0.04, -1.0], [0.05, 0.04, 1.0]], Some(0.0)),
            ([[0.05, 0.04, 0.05], [0.04, 0.05, 0.08]], Some(0.02)),
            ([[0.05, 0.04, 0.11], [0.05, 0.04, 0.11]], Some(0.01)),
        ] {
            let found = cube.segment_distance_within(&ends.map(Vector3::from), reach_m);
            let off = match (found, distance) {
                (Some(found), Some(distance)) => f64::abs(found - distance),
                _ => f64::from(found.is_some() != distance.is_some()),
            };
            assert!(off < 1e-12, "{ends:?}: {found:?}");
        }
    }

    /// A bar laid on its edge on a block, 3 mm into it: the edge is 3 mm deep in the block, the face of the block at most
    /// 3 mm · sin 45° in the bar.
    #[test]
    fn depths_of_triangles_are_exact() {
        let block = boxes(&[([0.0; 3], [0.1; 3], false)]);
        let bar = boxes(&[([-0.01; 3], [0.01; 3], false)]);
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::x_axis(), PI / 4.0);
        let pressed = |depth_m: f64| {
            let middle = Vector3::new(0.047, 0.052, 0.1 + 0.01 * 2.0_f64.sqrt() - depth_m);
            let into_block = block.deepest(bar.surface(), |p| turn * p + middle, 0.0);
            let place = |p: &Vector3<f64>| turn.inverse() * (p - middle);
            [into_block, bar.deepest(block.surface(), place, 0.0)]
        };
        let [edge, face] = pressed(0.003);
        for (found, exact) in [(edge, 0.003), (face, 0.003 / 2.0_f64.sqrt())] {
            let short = exact - found;
            assert!((-1e-12..=DEPTH_TOLERANCE_M).contains(&short), "{found}");
        }
        assert!(pressed(-1e-3).iter().all(|depth_m| *depth_m < 1e-12));
        // A bar inside the block: the middles of its faces toward the block's middle.
        let inside = |known_m| {
            block.deepest(
                bar.surface(),
                |p| p + Vector3::new(0.03, 0.05, 0.05),
                known_m,
            )
        };
        assert!((0.04 - inside(0.0)).abs() <= DEPTH_TOLERANCE_M);
        assert!((inside(0.05) - 0.05).abs() < 1e-15);
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
