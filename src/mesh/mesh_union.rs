//! The surface of a union of closed pieces, without the parts of one piece inside another.
//!
//! Meshes from convex decomposition consist of pieces that overlap or share a cut. Some faces lie inside the solid, so
//! distances to them would be wrong. Every triangle is therefore cut along the triangles of other pieces that it meets. The
//! fragments with the solid on one side only are kept. The winding number decides this, or the formulae of the pieces if
//! they are known.

use std::f64::consts::FRAC_PI_4;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::Vector3;
use rayon::prelude::*;

use super::Mesh;
use super::box_tree::BoxTree;
use super::winding::Winding;
use crate::formats::Triangles;

/// Points within this share of the object's size of a plane lie on it; coordinates are often 32-bit numbers.
const ON_PLANE: f64 = 1e-6;
/// Distance from a fragment at which the solid is tested, as a share of the object's size. Narrower gaps between pieces are
/// closed. Convex decompositions leave gaps of up to a ten-thousandth (bottle of `DexGraspNet`).
const BESIDE: f64 = 3e-4;
/// Parallel faces nearer than this share of the object's size are cut along each other's edges, because either may cover a
/// part of the other.
const NEAR: f64 = 2.0 * BESIDE;
/// A triangle with more fragments than this is not cut any further.
const MOST_FRAGMENTS: usize = 20_000;
/// Largest number of pairs of faces of different pieces that may meet. More pairs come from a mistake or malice, for
/// example a file that names one part thousands of times in one place.
const MOST_MEETINGS: usize = 20_000_000;

/// The faces of pieces meet in more than [`MOST_MEETINGS`] places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entangled;

/// The corners of a convex fragment in order.
type Polygon = Vec<Vector3<f64>>;

/// A triangle with its bounding box.
struct Face {
    piece: usize,
    corners: [Vector3<f64>; 3],
    normal: Vector3<f64>,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

/// Signed distance of a point to a convex solid, metres, negative inside.
pub(crate) type SignedDistance<'a> = Box<dyn Fn(&Vector3<f64>) -> f64 + Sync + 'a>;

/// Test whether a point is in the solid.
type Inside<'a> = dyn Fn(&Vector3<f64>) -> bool + Sync + 'a;

/// The surface of the union, as triangles without shared vertices, because corners of fragments may lie on edges of others.
/// `None` if no pieces overlap or touch, so that it is the mesh itself. `solids` are the signed distances of the convex shapes
/// that the pieces are meshes of, if they are known.
///
/// # Errors
/// If the pieces meet in too many places.
pub(super) fn united(
    mesh: &Mesh,
    solids: Option<&[SignedDistance<'_>]>,
) -> Result<Option<Triangles>, Entangled> {
    let pieces = mesh.pieces();
    if pieces.len() < 2 {
        return Ok(None);
    }
    let [low, high] = mesh.bounds();
    let size = (high - low).max();
    let mut faces = faces(mesh, &pieces);
    if !boxes_meet(&faces, pieces.len(), size * BESIDE) {
        return Ok(None);
    }
    let count = faces.len();
    if let Some(solids) = solids {
        faces.retain(|face| !is_covered(face, solids, size * BESIDE));
    }
    let others = others(&faces, size * NEAR)?;
    let windings: Vec<Winding> = match solids {
        Some(_) => Vec::new(),
        None => (pieces.iter())
            .map(|piece| Winding::new(mesh.vertices(), piece))
            .collect(),
    };
    // The winding number of a closed piece is zero outside its bounding ball.
    let balls = BoxTree::new(windings.iter().map(Winding::bounds));
    let winding = |point: &Vector3<f64>| -> f64 {
        let near = balls.near(point, point, size * ON_PLANE).into_iter();
        let near = near.map(|piece| &windings[piece]);
        let reaching = near.filter(|piece| piece.reaches(point));
        reaching.map(|piece| piece.at(point)).sum()
    };
    let inside = |point: &Vector3<f64>| match solids {
        Some(solids) => solids.iter().any(|solid| solid(point) < 0.0),
        None => winding(point) > 0.5,
    };
    let kept: Vec<Vec<Polygon>> = faces
        .par_iter()
        .zip(&others)
        .map(|(face, others)| fragments(face, others, &faces, &inside, size))
        .collect();
    let whole = faces.len() == count
        && kept
            .iter()
            .zip(&faces)
            .all(|(kept, face)| matches!(kept.as_slice(), [one] if one.as_slice() == face.corners));
    Ok(if whole { None } else { gathered(kept) })
}

/// The fragments as triangles; `None` if there are no fragments or too many for 32-bit indices.
fn gathered(kept: Vec<Vec<Polygon>>) -> Option<Triangles> {
    let mut union = Triangles::default();
    for polygon in kept.into_iter().flatten() {
        let first = u32::try_from(union.vertices.len()).ok()?;
        let count = u32::try_from(polygon.len()).ok()?;
        union.vertices.extend(polygon);
        let fan = (1..count - 1).map(|i| [first, first + i, first + i + 1]);
        union.triangles.extend(fan);
    }
    (!union.triangles.is_empty()).then_some(union)
}

fn faces(mesh: &Mesh, pieces: &[Vec<[u32; 3]>]) -> Vec<Face> {
    let face = |piece: usize, triangle: &[u32; 3]| {
        let corners @ [a, b, c] = triangle.map(|vertex| mesh.vertices()[vertex as usize]);
        Face {
            piece,
            corners,
            normal: (b - a).cross(&(c - a)).normalize(),
            low: a.inf(&b).inf(&c),
            high: a.sup(&b).sup(&c),
        }
    };
    let of_piece = |(piece, triangles): (usize, &Vec<[u32; 3]>)| {
        let faces: Vec<Face> = triangles
            .iter()
            .map(|triangle| face(piece, triangle))
            .collect();
        faces
    };
    let mut faces: Vec<Face> = pieces.iter().enumerate().flat_map(of_piece).collect();
    // Triangles without area cannot be cut.
    faces.retain(|face| face.normal.iter().all(|x| x.is_finite()));
    faces
}

/// Whether a face lies deeper in one of the solids than the distance at which the solid is tested. Such a face neither
/// bounds the union nor cuts other faces. Distances from a convex solid are convex, so testing the corners suffices.
fn is_covered(face: &Face, solids: &[SignedDistance<'_>], depth: f64) -> bool {
    let covers = |solid: &SignedDistance<'_>| face.corners.iter().all(|p| solid(p) < -depth);
    solids.iter().any(covers)
}

/// Whether the boxes of any two pieces intersect.
fn boxes_meet(faces: &[Face], pieces: usize, slack: f64) -> bool {
    let mut boxes: Vec<Option<[Vector3<f64>; 2]>> = vec![None; pieces];
    for face in faces {
        let [low, high] = boxes[face.piece].unwrap_or([face.low, face.high]);
        boxes[face.piece] = Some([low.inf(&face.low), high.sup(&face.high)]);
    }
    let boxes: Vec<[Vector3<f64>; 2]> = boxes.into_iter().flatten().collect();
    let tree = BoxTree::new(boxes.iter().copied());
    boxes.par_iter().enumerate().any(|(number, one)| {
        let near = tree.near(&one[0], &one[1], slack).into_iter();
        near.filter(|&other| other != number)
            .any(|other| meet(one, &boxes[other], slack))
    })
}

/// Whether two boxes are no farther than `slack` from each other along each axis.
fn meet(one: &[Vector3<f64>; 2], two: &[Vector3<f64>; 2], slack: f64) -> bool {
    (0..3).all(|axis| one[0][axis] <= two[1][axis] + slack && two[0][axis] <= one[1][axis] + slack)
}

/// For each face, the faces of other pieces whose boxes intersect its box.
fn others(faces: &[Face], slack: f64) -> Result<Vec<Vec<usize>>, Entangled> {
    let tree = BoxTree::new(faces.iter().map(|face| [face.low, face.high]));
    // Each meeting is seen from both of its faces.
    let meetings = AtomicUsize::new(0);
    let of_face = |face: &Face| {
        if meetings.load(Ordering::Relaxed) > 2 * MOST_MEETINGS {
            return Err(Entangled);
        }
        let mut others = tree.near(&face.low, &face.high, slack);
        others.retain(|&other| {
            let other = &faces[other];
            let boxes = [[face.low, face.high], [other.low, other.high]];
            other.piece != face.piece && meet(&boxes[0], &boxes[1], slack)
        });
        meetings.fetch_add(others.len(), Ordering::Relaxed);
        Ok(others)
    };
    let others: Result<Vec<Vec<usize>>, Entangled> = faces.par_iter().map(of_face).collect();
    let others = others?;
    if meetings.into_inner() > 2 * MOST_MEETINGS {
        return Err(Entangled);
    }
    Ok(others)
}

/// The fragments of a face that bound the solid.
fn fragments(
    face: &Face,
    others: &[usize],
    faces: &[Face],
    inside: &Inside<'_>,
    size: f64,
) -> Vec<Polygon> {
    let slack = size * ON_PLANE;
    let mut fragments: Vec<Polygon> = vec![face.corners.to_vec()];
    for other in others.iter().map(|&other| &faces[other]) {
        if fragments.len() > MOST_FRAGMENTS {
            break;
        }
        let mut cut = Vec::with_capacity(fragments.len());
        for fragment in fragments {
            cut_by(fragment, face, other, size, &mut cut);
        }
        fragments = cut;
    }
    let reach = size * BESIDE;
    let beside = face.normal * reach;
    fragments.retain(|fragment| {
        let middle = fragment.iter().sum::<Vector3<f64>>() / fragment.len() as f64;
        let solid = |point: Vector3<f64>| {
            // A gap between pieces is possible only beside another piece.
            let close = |&other: &usize| {
                let other = &faces[other];
                (other.corners[0] - point).dot(&other.normal).abs() < reach
                    && sides(other).iter().all(|side| side.of(&point) < reach)
            };
            inside(&point)
                || others.iter().any(close) && in_gap(&point, &face.normal, reach, inside)
        };
        let bounds = solid(middle - beside) && !solid(middle + beside);
        // Of two faces in the same place, only one is kept.
        let twin = |other: &Face| {
            other.piece < face.piece
                && other.normal.dot(&face.normal) > 0.999
                && (middle - other.corners[0]).dot(&other.normal).abs() < reach
                && sides(other).iter().all(|side| side.of(&middle) < slack)
        };
        bounds && !others.iter().any(|&other| twin(&faces[other]))
    });
    fragments
}

/// Whether a point outside lies in a gap: the solid is on both sides within `reach`.
///
/// A narrow face that closes the end of another gap has its test point in that gap.
fn in_gap(point: &Vector3<f64>, normal: &Vector3<f64>, reach: f64, inside: &Inside<'_>) -> bool {
    let along = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let across = normal.cross(&along);
    // Test directions lie in the face and halfway between it and the normal. Along the normal lies the face itself.
    let directions = (0..8).flat_map(|eighth| {
        let (sin, cos) = libm::sincos(f64::from(eighth) * FRAC_PI_4);
        let level = along * cos + across * sin;
        [
            (eighth < 4).then_some(level),
            Some((level + normal).normalize()),
        ]
    });
    directions.flatten().any(|direction| {
        [reach, -reach]
            .iter()
            .all(|&step| inside(&(point + direction * step)))
    })
}

/// A plane n·p = d.
struct Plane {
    normal: Vector3<f64>,
    offset: f64,
}

impl Plane {
    fn through(point: &Vector3<f64>, normal: Vector3<f64>) -> Self {
        Self {
            offset: normal.dot(point),
            normal,
        }
    }

    fn of(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// Planes through the edges of a face, perpendicular to it and facing outward.
fn sides(face: &Face) -> [Plane; 3] {
    let [a, b, c] = face.corners;
    [[a, b], [b, c], [c, a]].map(|[from, to]| {
        let outward = (to - from).cross(&face.normal);
        Plane::through(&from, outward.try_normalize(0.0).unwrap_or_default())
    })
}

/// Cuts a fragment of `face` where `other` crosses it. If both are nearly coplanar, it is cut along the edges of `other`.
fn cut_by(fragment: Polygon, face: &Face, other: &Face, size: f64, cut: &mut Vec<Polygon>) {
    const PARALLEL: f64 = 0.999;
    let slack = size * ON_PLANE;
    let plane = Plane::through(&other.corners[0], other.normal);
    let heights: Vec<f64> = fragment.iter().map(|p| plane.of(p)).collect();
    let parallel = face.normal.dot(&other.normal).abs() > PARALLEL;
    let reach = if parallel { size * NEAR } else { slack };
    if heights.iter().all(|h| h.abs() <= reach) {
        let sides = sides(other);
        let apart = |side: &Plane| fragment.iter().all(|p| side.of(p) >= -slack);
        if sides.iter().any(apart) {
            cut.push(fragment);
            return;
        }
        let mut inside = Some(fragment);
        for side in &sides {
            let Some(rest) = inside.take() else { break };
            let (below, above) = split(rest, side, slack);
            cut.extend(above);
            inside = below;
        }
        cut.extend(inside);
        return;
    }
    let crosses = heights.iter().any(|&h| h > slack) && heights.iter().any(|&h| h < -slack);
    if crosses && reaches(&fragment, &heights, other, slack) && {
        // Conversely, a triangle that ends before the plane of the face does not cut it.
        let own = Plane::through(&face.corners[0], face.normal);
        let own = other.corners.map(|p| own.of(&p));
        own.iter().any(|&h| h > -slack) && own.iter().any(|&h| h < slack)
    } {
        let (below, above) = split(fragment, &plane, slack);
        cut.extend(below);
        cut.extend(above);
    } else {
        cut.push(fragment);
    }
}

/// Whether the line in which a fragment meets the plane of `other` passes through `other`.
fn reaches(fragment: &Polygon, heights: &[f64], other: &Face, slack: f64) -> bool {
    let count = fragment.len();
    let mut ends = Vec::with_capacity(2);
    for i in 0..count {
        let j = (i + 1) % count;
        if (heights[i] > 0.0) != (heights[j] > 0.0) {
            let share = heights[i] / (heights[i] - heights[j]);
            ends.push(fragment[i] + (fragment[j] - fragment[i]) * share);
        }
    }
    let [mut a, mut b] = match ends.as_slice() {
        [a, b, ..] => [*a, *b],
        _ => return false,
    };
    for side in sides(other) {
        let (at_a, at_b) = (side.of(&a), side.of(&b));
        if at_a > slack && at_b > slack {
            return false;
        }
        if at_a > slack {
            a = b + (a - b) * (at_b / (at_b - at_a)).clamp(0.0, 1.0);
        } else if at_b > slack {
            b = a + (b - a) * (at_a / (at_a - at_b)).clamp(0.0, 1.0);
        }
    }
    true
}

/// The parts of a fragment below and above a plane. Slivers thinner than `slack` are dropped.
fn split(fragment: Polygon, plane: &Plane, slack: f64) -> (Option<Polygon>, Option<Polygon>) {
    let heights: Vec<f64> = fragment.iter().map(|p| plane.of(p)).collect();
    if heights.iter().all(|&h| h <= slack) {
        return (Some(fragment), None);
    }
    if heights.iter().all(|&h| h >= -slack) {
        return (None, Some(fragment));
    }
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for i in 0..fragment.len() {
        let j = (i + 1) % fragment.len();
        let (here, next) = (heights[i], heights[j]);
        if here <= slack {
            below.push(fragment[i]);
        }
        if here >= -slack {
            above.push(fragment[i]);
        }
        if (here > slack && next < -slack) || (here < -slack && next > slack) {
            let point = fragment[i] + (fragment[j] - fragment[i]) * (here / (here - next));
            below.push(point);
            above.push(point);
        }
    }
    let solid =
        |polygon: Polygon| (polygon.len() > 2 && !is_sliver(&polygon, slack)).then_some(polygon);
    (solid(below), solid(above))
}

/// Whether a polygon is thinner than `slack`.
fn is_sliver(polygon: &Polygon, slack: f64) -> bool {
    let first = polygon[0];
    let area = polygon[1..]
        .windows(2)
        .map(|pair| (pair[0] - first).cross(&(pair[1] - first)))
        .sum::<Vector3<f64>>()
        .norm()
        / 2.0;
    let around: f64 = (0..polygon.len())
        .map(|i| (polygon[(i + 1) % polygon.len()] - polygon[i]).norm())
        .sum();
    area < slack * around / 4.0
}

#[cfg(test)]
mod tests {
    use super::super::testing::box_mesh;
    use super::*;
    use crate::mesh::ExactMesh;

    /// Distance of the boundary of a union of boxes from a point, by the complement: from a fine grid it would be rough, so
    /// the shapes are such that it is known.
    fn of(boxes: &[([f64; 3], [f64; 3], bool)]) -> (Mesh, ExactMesh) {
        let mesh = box_mesh(boxes);
        let exact = ExactMesh::new(&mesh);
        (mesh, exact)
    }

    #[test]
    fn a_box_cut_in_two_is_the_box() {
        // Cut at z = 0.03; the second piece begins a tenth of a micrometre later, as rounded files have it.
        let (mesh, exact) = of(&[
            ([0.0; 3], [0.1, 0.1, 0.03], false),
            ([0.0, 0.0, 0.0300001], [0.1; 3], false),
        ]);
        let (whole, known) = of(&[([0.0; 3], [0.1; 3], false)]);
        assert!((mesh.volume() - whole.volume()).abs() < 1e-8);
        assert!(
            (mesh.area_m2() - whole.area_m2()).abs() < 1e-6,
            "{}",
            mesh.area_m2()
        );
        assert!((mesh.centroid() - whole.centroid()).norm() < 1e-6);
        for i in 0..20 {
            for j in 0..20 {
                let p = Vector3::new(
                    0.04,
                    f64::from(i) * 0.008 - 0.03,
                    f64::from(j) * 0.008 - 0.03,
                );
                let (here, there) = (exact.distance(&p), known.distance(&p));
                assert!((here - there).abs() < 1e-6, "{p}: {here}, not {there}");
            }
        }
    }

    /// As a file may have it that names one part again and again; found by fuzzing the reader of glTF.
    #[test]
    fn a_part_in_one_place_a_thousand_times_is_refused() {
        let one = box_mesh(&[([0.0; 3], [0.1; 3], false)]);
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for copy in 0..1_000u32 {
            let first = copy * u32::try_from(one.vertices().len()).unwrap();
            vertices.extend_from_slice(one.vertices());
            triangles.extend(one.triangles().iter().map(|t| t.map(|v| first + v)));
        }
        let said = Mesh::new("copies", vertices, triangles).unwrap_err();
        assert!(said.to_string().contains("copies"), "{said}");
    }

    #[test]
    fn a_box_on_a_larger_one_covers_a_part_of_it() {
        // 5 µm apart, as the pieces of a decomposition are.
        let (mesh, exact) = of(&[
            ([0.0; 3], [0.1, 0.1, 0.03], false),
            ([0.021, 0.033, 0.030005], [0.071, 0.083, 0.06], false),
        ]);
        let sides = 4.0 * 0.05 * 0.029995;
        let area = 2.0 * 0.01 + 4.0 * 0.1 * 0.03 + sides;
        assert!(
            (mesh.area_m2() / area - 1.0).abs() < 1e-3,
            "{}, not {area}",
            mesh.area_m2()
        );
        // On the cut, and in the gap itself.
        for z in [0.029, 0.0300025, 0.031] {
            let depth = -exact.distance(&Vector3::new(0.046, 0.058, z));
            assert!((depth - 0.025).abs() < 1e-3, "{z}: {depth}");
        }
    }

    #[test]
    fn where_gaps_meet_no_strips_are_left() {
        // The gap between the upper two boxes ends on the lower one.
        let (mesh, exact) = of(&[
            ([0.0; 3], [0.1, 0.1, 0.04], false),
            ([0.0, 0.0, 0.040003], [0.05, 0.1, 0.1], false),
            ([0.050004, 0.0, 0.040003], [0.1; 3], false),
        ]);
        assert!(
            (mesh.area_m2() / 0.06 - 1.0).abs() < 1e-3,
            "{}",
            mesh.area_m2()
        );
        for z in [0.035, 0.05] {
            let depth = -exact.distance(&Vector3::new(0.051, 0.05, z));
            let known = f64::min(z, 0.049);
            assert!((depth - known).abs() < 1e-4, "{z}: {depth}, not {known}");
        }
    }

    #[test]
    fn depth_in_an_overlap_is_that_below_the_common_surface() {
        // A plus sign: the middle lies 10 mm from both pieces' faces, but 14.1 mm from the nearest inner corner.
        let (mesh, exact) = of(&[
            ([0.0, 0.04, 0.0], [0.1, 0.06, 0.1], false),
            ([0.04, 0.0, 0.0], [0.06, 0.1, 0.1], false),
        ]);
        let volume = 0.1 * (2.0 * 0.1 * 0.02 - 0.02 * 0.02);
        assert!((mesh.volume() - volume).abs() < 1e-12, "{}", mesh.volume());
        let depth = -exact.distance(&Vector3::new(0.05, 0.05, 0.05));
        assert!((depth - 0.01 * 2f64.sqrt()).abs() < 1e-9, "{depth}");
        // Just beside a face that lies inside the other piece.
        let depth = -exact.distance(&Vector3::new(0.05, 0.0601, 0.05));
        assert!((depth - 0.01).abs() < 1e-4, "{depth}");
        assert!(
            mesh.sample_surface(500, 0)
                .iter()
                .all(|s| exact.distance(&s.point).abs() < 1e-9)
        );
    }

    #[test]
    fn faces_in_one_place_count_once_and_hidden_pieces_not_at_all() {
        let (mesh, exact) = of(&[
            ([0.0; 3], [0.1; 3], false),
            ([0.02; 3], [0.08; 3], false),
            ([0.05, 0.0, 0.0], [0.15, 0.1, 0.1], false),
        ]);
        assert!((mesh.volume() - 1.5e-3).abs() < 1e-10, "{}", mesh.volume());
        let area = 2.0 * (0.01 + 2.0 * 0.015);
        assert!((mesh.area_m2() - area).abs() < 1e-9, "{}", mesh.area_m2());
        assert!((exact.distance(&Vector3::new(0.07, 0.05, 0.05)) + 0.05).abs() < 1e-9);
    }

    #[test]
    fn pieces_apart_stay_as_they_are() {
        let (mesh, _) = of(&[([0.0; 3], [0.03; 3], false), ([0.05; 3], [0.1; 3], false)]);
        assert_eq!(united(&mesh, None), Ok(None));
        let (cavity, _) = of(&[([0.0; 3], [0.1; 3], false), ([0.02; 3], [0.08; 3], true)]);
        assert_eq!(united(&cavity, None), Ok(None));
    }

    /// Each face was compared with all of a slab, and each point with the balls around all pieces: minutes for these.
    #[test]
    fn thousands_of_pieces_are_united() {
        let mut boxes = Vec::new();
        for number in 0..8_000_u32 {
            let low = [number % 20, number / 20 % 20, number / 400].map(|n| 0.004 * f64::from(n));
            boxes.push((low, low.map(|x| x + 0.003), false));
        }
        let (apart, _) = of(&boxes);
        assert!(!apart.overlaps());
        // One more overlaps its neighbour by two thirds.
        boxes.push(([0.0, 0.0, 0.001], [0.003, 0.003, 0.0035], false));
        let (mesh, exact) = of(&boxes);
        assert!(mesh.overlaps());
        let volume = 8_000.0 * 2.7e-8 + 9e-6 * 0.5e-3;
        assert!((mesh.volume() / volume - 1.0).abs() < 1e-6);
        let depth = |z: f64| exact.distance(&Vector3::new(0.0015, 0.0015, z));
        // The box between 0 and 3.5 mm, and the gap of half a millimetre to the next one.
        assert!((depth(0.003) + 0.5e-3).abs() < 1e-9, "{}", depth(0.003));
        assert!(
            (depth(0.00375) - 0.25e-3).abs() < 1e-9,
            "{}",
            depth(0.00375)
        );
    }
}
