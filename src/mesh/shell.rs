//! Walls of a given thickness in place of open surfaces.

use nalgebra::{Matrix3, Vector3};

use super::cells::Sets;
use crate::formats::Triangles;

/// Weight of the mean normal against the normals of single triangles when a corner is moved.
const MEAN_WEIGHT: f64 = 1e-3;
/// A corner moves at most this many half thicknesses, also at a sharp bend.
const LONGEST_MITRE: f64 = 3.0;

/// Walls about open surfaces.
#[derive(Debug, Default)]
pub(super) struct Shells {
    /// Closed pieces that face outward.
    pub(super) soup: Triangles,
    /// Their number.
    pub(super) count: usize,
}

/// The walls of the given thickness about sheets of triangles. Half of a wall lies on each side of its sheet.
///
/// A corner of a sheet is moved to both sides so that its triangles are moved along their normals by half the thickness, as
/// far as possible; where a sheet bends more sharply than the thickness, its wall is thinner or overlaps itself. Borders get a
/// flat rim. Sheets that meet along an edge with three or more triangles become separate walls that overlap.
pub(super) fn walls(
    vertices: &[Vector3<f64>],
    mut triangles: Vec<[u32; 3]>,
    thickness: f64,
) -> Shells {
    let Sheets { count, joined } = orient(&mut triangles);
    let joins = |face: usize, side: usize| joined[face][side];
    // Corners of triangles that are one corner of a sheet.
    let mut corners = Sets::new(3 * triangles.len());
    for (face, triangle) in triangles.iter().enumerate() {
        for side in 0..3 {
            let Some(other) = joins(face, side) else {
                continue;
            };
            for corner in [side, (side + 1) % 3] {
                let vertex = triangle[corner];
                if let Some(place) = triangles[other].iter().position(|&v| v == vertex) {
                    corners.join(3 * face + corner, 3 * other + place);
                }
            }
        }
    }
    let moved = offsets(vertices, &triangles, &mut corners, thickness / 2.0);
    let mut shells = Shells {
        count,
        ..Shells::default()
    };
    // The two places of each corner.
    let mut placed: Vec<Option<u32>> = vec![None; 3 * triangles.len()];
    let mut place = |corner: usize, soup: &mut Triangles| -> [u32; 2] {
        let root = corners.of(corner);
        let first = *placed[root].get_or_insert_with(|| {
            let first = u32::try_from(soup.vertices.len()).unwrap_or(u32::MAX);
            let at = vertices[triangles[root / 3][root % 3] as usize];
            soup.vertices.extend([at + moved[root], at - moved[root]]);
            first
        });
        [first, first.saturating_add(1)]
    };
    for face in 0..triangles.len() {
        let soup = &mut shells.soup;
        let [a, b, c] = [0, 1, 2].map(|corner| place(3 * face + corner, soup));
        soup.triangles.push([a[0], b[0], c[0]]);
        soup.triangles.push([a[1], c[1], b[1]]);
        for (side, [from, to]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
            if joins(face, side).is_none() {
                soup.triangles.push([to[0], from[0], from[1]]);
                soup.triangles.push([to[0], from[1], to[1]]);
            }
        }
    }
    shells
}

/// How triangles join to sheets.
struct Sheets {
    count: usize,
    /// For each triangle, the neighbour at each edge; `None` at a border.
    joined: Vec<[Option<usize>; 3]>,
}

/// Turns triangles so that those of a sheet agree. At an edge with more than two triangles, or where this is impossible, sheets
/// end.
fn orient(triangles: &mut [[u32; 3]]) -> Sheets {
    let mut uses: Vec<([u32; 2], usize, usize)> = Vec::new();
    for (face, &[a, b, c]) in triangles.iter().enumerate() {
        for (side, [from, to]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
            uses.push(([from.min(to), from.max(to)], face, side));
        }
    }
    uses.sort_unstable();
    // By the number of the edge among those of the triangle as it was given: the neighbour there.
    let mut across = vec![[None; 3]; triangles.len()];
    for at in uses.chunk_by(|one, next| one.0 == next.0) {
        if let [(_, one, side), (_, other, facing)] = *at {
            across[one][side] = Some((other, facing));
            across[other][facing] = Some((one, side));
        }
    }
    let runs_up = |face: usize, side: usize| {
        let triangle = triangles[face];
        triangle[side] < triangle[(side + 1) % 3]
    };
    let mut turned: Vec<Option<bool>> = vec![None; triangles.len()];
    let mut count = 0;
    for start in 0..triangles.len() {
        if turned[start].is_some() {
            continue;
        }
        count += 1;
        turned[start] = Some(false);
        let mut waiting = vec![start];
        while let Some(here) = waiting.pop() {
            for side in 0..3 {
                if let Some((other, facing)) = across[here][side] {
                    let disagrees = runs_up(here, side) == runs_up(other, facing);
                    let wanted = (turned[here] == Some(true)) != disagrees;
                    if turned[other].is_none() {
                        turned[other] = Some(wanted);
                        waiting.push(other);
                    } else if turned[other] != Some(wanted) {
                        across[here][side] = None;
                        across[other][facing] = None;
                    }
                }
            }
        }
    }
    let mut joined: Vec<[Option<usize>; 3]> = across
        .iter()
        .map(|sides| sides.map(|at| at.map(|(other, _)| other)))
        .collect();
    for ((triangle, sides), turned) in triangles.iter_mut().zip(&mut joined).zip(turned) {
        if turned == Some(true) {
            // The edges a b, b c and c a become a c, c b and b a.
            triangle.swap(1, 2);
            sides.swap(0, 2);
        }
    }
    Sheets { count, joined }
}

/// How far the corners move to the front: for the number that stands for a corner, p with n·p = `half` for the normals n of
/// its triangles, in the least squares weighted by their angles.
fn offsets(
    vertices: &[Vector3<f64>],
    triangles: &[[u32; 3]],
    corners: &mut Sets,
    half: f64,
) -> Vec<Vector3<f64>> {
    let mut sums = vec![(Matrix3::zeros(), Vector3::zeros()); 3 * triangles.len()];
    for (face, triangle) in triangles.iter().enumerate() {
        let at = triangle.map(|vertex| vertices[vertex as usize]);
        let normal = (at[1] - at[0]).cross(&(at[2] - at[0]));
        let Some(normal) = normal.try_normalize(0.0) else {
            continue;
        };
        for corner in 0..3 {
            let [one, other] = [1, 2].map(|step| at[(corner + step) % 3] - at[corner]);
            let weight = libm::atan2(one.cross(&other).norm(), one.dot(&other));
            let (matrix, mean) = &mut sums[corners.of(3 * face + corner)];
            *matrix += normal * normal.transpose() * weight;
            *mean += normal * weight;
        }
    }
    sums.into_iter()
        .map(|(matrix, mean)| {
            let Some(direction) = mean.try_normalize(0.0) else {
                return Vector3::zeros();
            };
            let weight = MEAN_WEIGHT * matrix.trace();
            let matrix = matrix + Matrix3::identity() * weight;
            let wanted = (mean + direction * weight) * half;
            let moved = matrix.lu().solve(&wanted).unwrap_or(direction * half);
            moved.cap_magnitude(LONGEST_MITRE * half)
        })
        .collect()
}
