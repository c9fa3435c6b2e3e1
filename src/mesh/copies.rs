//! Triangles made ready for [`super::cells`]: each is there once, and neighbours share whole edges.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::formats::Triangles;

/// Two triangles with a common edge are halves of a quadrilateral if the cosine of the angle between their normals exceeds
/// this.
const FLAT_COSINE: f64 = 0.85;
/// Largest number of pairs of an edge and a corner that are compared.
const MOST_PAIRS: usize = 200_000_000;

/// Triangles that differ from each other.
#[derive(Debug, Clone, Default)]
pub(super) struct Faces {
    pub(super) vertices: Vec<Vector3<f64>>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each triangle, how many given triangles have its direction less how many have the opposite one.
    pub(super) votes: Vec<i32>,
    /// Number of triangles that were dropped because they lie on others.
    pub(super) copies: usize,
}

impl Faces {
    /// The triangles of a welded surface, each of its copies in either direction once. Of a quadrilateral that is there
    /// with both diagonals, the first is kept.
    pub(super) fn of(soup: Triangles) -> Self {
        let Triangles {
            vertices,
            triangles,
        } = soup;
        let mut order: Vec<(([u32; 3], bool), usize)> =
            triangles.iter().map(sorted).zip(0..).collect();
        order.sort_unstable_by_key(|((corners, _), index)| (*corners, *index));
        let mut kept: Vec<(usize, i32)> = order
            .chunk_by(|one, next| one.0.0 == next.0.0)
            .map(|same| {
                let ((_, even), first) = same[0];
                let vote = |(_, other): (_, bool)| if other == even { 1 } else { -1 };
                (first, same.iter().map(|(key, _)| vote(*key)).sum())
            })
            .collect();
        kept.sort_unstable();
        let mut faces = Self {
            vertices,
            triangles: kept.iter().map(|(index, _)| triangles[*index]).collect(),
            votes: kept.iter().map(|(_, vote)| *vote).collect(),
            copies: triangles.len() - kept.len(),
        };
        faces.merge_quadrilaterals();
        faces
    }

    /// Drops the second of two pairs of triangles that divide a quadrilateral along different diagonals.
    fn merge_quadrilaterals(&mut self) {
        // Corners of the quadrilateral, the diagonal, and the two triangles at it.
        let mut found: Vec<([u32; 4], [u32; 2], [usize; 2])> = Vec::new();
        for at in self.edges().chunk_by(|one, next| one.0 == next.0) {
            // At an edge of a double surface lie at most a few triangles.
            for (place, &(diagonal, one, _)) in at.iter().enumerate().take(16) {
                for &(_, other, _) in at[place + 1..].iter().take(16) {
                    let cosine = self.normal(one).dot(&self.normal(other));
                    let [c, d] = [one, other].map(|face| self.opposite(face, diagonal));
                    if cosine.abs() > FLAT_COSINE && self.lie_apart(diagonal, [c, d]) {
                        let mut corners = [diagonal[0], diagonal[1], c, d];
                        corners.sort_unstable();
                        found.push((corners, diagonal, [one, other]));
                    }
                }
            }
        }
        found.sort_unstable();
        let mut dropped = vec![false; self.triangles.len()];
        let gone = |dropped: &[bool], pair: [usize; 2]| pair.iter().any(|&face| dropped[face]);
        for pairs in found.chunk_by(|one, next| one.0 == next.0) {
            for (place, &(_, diagonal, keep)) in pairs.iter().enumerate() {
                for &(_, other, drop) in &pairs[place + 1..] {
                    let cross = diagonal.iter().all(|vertex| !other.contains(vertex));
                    if !cross || gone(&dropped, keep) || gone(&dropped, drop) {
                        continue;
                    }
                    let mut votes = 0;
                    for face in drop {
                        dropped[face] = true;
                        let same = self.normal(face).dot(&self.normal(keep[0])) > 0.0;
                        votes += if same {
                            self.votes[face]
                        } else {
                            -self.votes[face]
                        };
                    }
                    // Half of it for each of the two.
                    let turned = self.normal(keep[0]).dot(&self.normal(keep[1])) < 0.0;
                    self.votes[keep[0]] += votes / 2;
                    self.votes[keep[1]] += if turned { -votes / 2 } else { votes / 2 };
                    self.copies += 2;
                }
            }
        }
        let stays = || dropped.iter().map(|dropped| !dropped);
        let (mut of_triangles, mut of_votes) = (stays(), stays());
        self.triangles.retain(|_| of_triangles.next() == Some(true));
        self.votes.retain(|_| of_votes.next() == Some(true));
    }

    /// Divides triangles whose edges have no neighbour where corners of other such triangles lie on these edges.
    pub(super) fn cut_at_corners(&mut self, reach: f64) {
        /// A triangle may have corners on all its edges, and each round divides one of them.
        const ROUNDS: usize = 4;
        for _ in 0..ROUNDS {
            let edges = self.edges();
            let lone: Vec<[u32; 2]> = (edges.chunk_by(|one, next| one.0 == next.0))
                .filter(|at| self.on_one_side(at))
                .map(|at| at[0].0)
                .collect();
            let mut corners: Vec<u32> = lone.iter().flatten().copied().collect();
            corners.sort_by(|&a, &b| {
                let x = |vertex: u32| self.vertices[vertex as usize].x;
                x(a).total_cmp(&x(b)).then(a.cmp(&b))
            });
            corners.dedup();
            if lone.len().saturating_mul(corners.len()) > MOST_PAIRS {
                return;
            }
            let mut cuts: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
            for &edge in &lone {
                let on = self.corners_on(edge, &corners, reach);
                if !on.is_empty() {
                    cuts.insert(edge, on);
                }
            }
            if cuts.is_empty() {
                return;
            }
            self.divide(&cuts);
        }
    }

    /// Whether all triangles at an edge lie on the same side of it.
    fn on_one_side(&self, at: &[([u32; 2], usize, bool)]) -> bool {
        let outward = |&(edge, face, _): &([u32; 2], usize, bool)| {
            let [low, high] = edge.map(|vertex| self.vertices[vertex as usize]);
            let along = (high - low).try_normalize(0.0).unwrap_or_default();
            let offset = self.vertices[self.opposite(face, edge) as usize] - low;
            let outward = offset - along * along.dot(&offset);
            outward.try_normalize(0.0).unwrap_or_default()
        };
        let first = outward(&at[0]);
        at[1..]
            .iter()
            .all(|other| outward(other).dot(&first) > 0.9999)
    }

    /// The corners on an edge between its ends, in order. `corners` are sorted by x.
    fn corners_on(&self, [low, high]: [u32; 2], corners: &[u32], reach: f64) -> Vec<u32> {
        let [from, to] = [low, high].map(|vertex| self.vertices[vertex as usize]);
        let (along, squared) = (to - from, (to - from).norm_squared());
        let first = from.x.min(to.x) - reach;
        let start = corners.partition_point(|&vertex| self.vertices[vertex as usize].x < first);
        let mut on: Vec<(f64, u32)> = corners[start..]
            .iter()
            .take_while(|&&vertex| self.vertices[vertex as usize].x <= from.x.max(to.x) + reach)
            .filter(|&&vertex| vertex != low && vertex != high)
            .filter_map(|&vertex| {
                let offset = self.vertices[vertex as usize] - from;
                let share = along.dot(&offset) / squared;
                let near = (offset - along * share).norm() <= reach;
                (share > 0.0 && share < 1.0 && near).then_some((share, vertex))
            })
            .collect();
        on.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        on.into_iter().map(|(_, vertex)| vertex).collect()
    }

    /// Divides each triangle at the corners on one of its edges.
    fn divide(&mut self, cuts: &BTreeMap<[u32; 2], Vec<u32>>) {
        let (mut triangles, mut votes) = (Vec::new(), Vec::new());
        for (&[a, b, c], &vote) in self.triangles.iter().zip(&self.votes) {
            let turns = [[a, b, c], [b, c, a], [c, a, b]];
            let cut = turns.into_iter().find_map(|turn| {
                let [from, to, tip] = turn;
                let on = cuts.get(&[from.min(to), from.max(to)])?;
                (!on.contains(&tip)).then_some((turn, on))
            });
            let Some(([from, to, tip], on)) = cut else {
                triangles.push([a, b, c]);
                votes.push(vote);
                continue;
            };
            let mut chain = vec![from];
            if from < to {
                chain.extend(on);
            } else {
                chain.extend(on.iter().rev());
            }
            chain.push(to);
            for pair in chain.windows(2) {
                triangles.push([pair[0], pair[1], tip]);
                votes.push(vote);
            }
        }
        (self.triangles, self.votes) = (triangles, votes);
    }

    /// Number of edges of an odd number of triangles.
    pub(super) fn open_edges(&self) -> usize {
        let edges = self.edges();
        let uses = edges.chunk_by(|one, next| one.0 == next.0);
        uses.filter(|at| at.len() % 2 == 1).count()
    }

    /// The edges of the triangles, sorted; `true` if the triangle runs from the lower index to the higher.
    fn edges(&self) -> Vec<([u32; 2], usize, bool)> {
        let mut edges = Vec::with_capacity(3 * self.triangles.len());
        for (face, &[a, b, c]) in self.triangles.iter().enumerate() {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                edges.push(([from.min(to), from.max(to)], face, from < to));
            }
        }
        edges.sort_unstable();
        edges
    }

    /// The corner of a triangle that is not on an edge of it.
    fn opposite(&self, face: usize, edge: [u32; 2]) -> u32 {
        let [a, b, c] = self.triangles[face];
        [a, b, c]
            .into_iter()
            .find(|corner| !edge.contains(corner))
            .unwrap_or(a)
    }

    /// Whether two points lie on different sides of an edge.
    fn lie_apart(&self, edge: [u32; 2], points: [u32; 2]) -> bool {
        let [low, high] = edge.map(|vertex| self.vertices[vertex as usize]);
        let along = high - low;
        let [c, d] = points.map(|vertex| {
            let offset = self.vertices[vertex as usize] - low;
            offset * along.norm_squared() - along * along.dot(&offset)
        });
        c.dot(&d) < 0.0
    }

    fn normal(&self, face: usize) -> Vector3<f64> {
        let [a, b, c] = self.triangles[face].map(|vertex| self.vertices[vertex as usize]);
        let cross = (b - a).cross(&(c - a));
        cross.try_normalize(0.0).unwrap_or_default()
    }

    pub(super) fn area(&self, face: usize) -> f64 {
        let [a, b, c] = self.triangles[face].map(|vertex| self.vertices[vertex as usize]);
        (b - a).cross(&(c - a)).norm() / 2.0
    }
}

/// The corners in ascending order, and whether an even number of exchanges sorts them.
fn sorted(triangle: &[u32; 3]) -> ([u32; 3], bool) {
    let [a, b, c] = *triangle;
    let even = (a < b) == ((b < c) == (a < c));
    let mut corners = *triangle;
    corners.sort_unstable();
    (corners, even)
}
