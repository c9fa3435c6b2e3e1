//! Repair of surfaces that are not closed or not oriented, if it is safe, with a note of each change.

use std::collections::BTreeMap;
use std::fmt;

use nalgebra::Vector3;

use super::winding::Winding;
use super::{Mesh, MeshError};
use crate::formats::Triangles;

/// Vertices closer than this share of the object's size are merged if the surface is not closed otherwise.
const WELD: f64 = 1e-5;
/// Largest share of the surface that patches may have.
const LARGEST_PATCHES: f64 = 0.1;
/// Number of surface samples whose sides are checked.
const SAMPLES: usize = 400;
/// A mesh is refused if at least this share of the samples lacks an inside or an outside.
const AMBIGUOUS: f64 = 0.2;

/// A mesh and the changes made to its triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Repaired {
    /// The mesh.
    pub mesh: Mesh,
    /// The changes, in order.
    pub repairs: Vec<Repair>,
}

/// A change to a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Repair {
    /// Vertices almost in the same place were merged.
    Joined {
        /// Number of dropped vertices.
        vertices: usize,
    },
    /// Triangles with the opposite orientation to their neighbours were turned.
    Turned {
        /// Their number.
        triangles: usize,
    },
    /// Holes were closed with triangles about their centres.
    Closed {
        /// Number of holes.
        holes: usize,
        /// Area of the new triangles over that of the whole surface.
        share: f64,
    },
    /// Pieces that were inside out were turned.
    InsideOut {
        /// Number of pieces.
        pieces: usize,
    },
    /// Nothing was changed, but parts of the surface lack an inside or an outside: the surface crosses itself.
    Crosses {
        /// Share of the surface.
        share: f64,
    },
}

impl fmt::Display for Repair {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Joined { vertices } => {
                write!(
                    formatter,
                    "{vertices} vertices next to others were joined with them"
                )
            }
            Self::Turned { triangles } => write!(
                formatter,
                "{triangles} triangles that faced the other way than their neighbours were turned"
            ),
            Self::Closed { holes, share } => write!(
                formatter,
                "{holes} hole{} closed ({:.1} % of the surface)",
                if *holes == 1 { " was" } else { "s were" },
                100.0 * share
            ),
            Self::InsideOut { pieces } => write!(
                formatter,
                "{pieces} piece{} inside out and turned",
                if *pieces == 1 { " was" } else { "s were" }
            ),
            Self::Crosses { share } => write!(
                formatter,
                "the surface crosses itself: {:.1} % of it has no inside or no outside beside it",
                100.0 * share
            ),
        }
    }
}

impl Mesh {
    /// A mesh of triangles that need not be closed or oriented. `name` is its name in errors.
    ///
    /// If the surface is not closed, vertices that lie together are merged, triangles are turned to agree with their
    /// neighbours, and holes that make up at most a tenth of the surface are closed. Pieces that are inside out are turned
    /// unless they lie within another piece, because they are then the walls of a cavity. Finally the winding number tests
    /// whether the surface has an inside on one side and an outside on the other nearly everywhere.
    ///
    /// # Errors
    /// If this does not suffice; the message says what is missing.
    pub fn repaired(
        name: &str,
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Repaired, MeshError> {
        let mut repairs = Vec::new();
        let strict = Self::closed(name, vertices.clone(), triangles.clone());
        let mesh = match strict {
            Err(MeshError::Open { .. } | MeshError::Orientation { .. }) => {
                let mut soup = Triangles {
                    vertices,
                    triangles,
                };
                soup.weld(&mut repairs);
                soup.turn(&mut repairs);
                soup.close(name, &mut repairs)?;
                Self::closed(name, soup.vertices, soup.triangles)?
            }
            other => other?,
        };
        let mesh = turn_pieces(name, &mesh, &mut repairs)?;
        let share = ambiguous(&mesh);
        if share > AMBIGUOUS {
            return Err(MeshError::Sides {
                name: name.to_owned(),
                percent: 100.0 * share,
            });
        }
        if share > 0.01 {
            repairs.push(Repair::Crosses { share });
        }
        Ok(Repaired { mesh, repairs })
    }
}

/// Turns pieces that are inside out and do not lie in another one.
fn turn_pieces(name: &str, mesh: &Mesh, repairs: &mut Vec<Repair>) -> Result<Mesh, MeshError> {
    let mut pieces = mesh.pieces();
    let flipped: Vec<bool> = pieces
        .iter()
        .map(|piece| super::exact::signed_volume(mesh, piece) < 0.0)
        .collect();
    let whole = || {
        let (vertices, triangles) = (mesh.vertices().to_vec(), mesh.triangles().to_vec());
        Mesh::new(name, vertices, triangles)
    };
    if repairs.is_empty() && flipped == [true] {
        // `Mesh::new` turns a mesh that is sound otherwise.
        repairs.push(Repair::InsideOut { pieces: 1 });
    }
    if pieces.len() < 2 || !flipped.contains(&true) {
        return whole();
    }
    let mut turned = 0;
    let others: Vec<[u32; 3]> = (pieces.iter().zip(&flipped))
        .filter(|(_, flipped)| !**flipped)
        .flat_map(|(piece, _)| piece.iter().copied())
        .collect();
    let others = Winding::new(mesh.vertices(), &others);
    for piece in 0..pieces.len() {
        if !flipped[piece] {
            continue;
        }
        let corner = mesh.vertices()[pieces[piece][0][0] as usize];
        if !others.surrounds(&corner) {
            turned += 1;
            for triangle in &mut pieces[piece] {
                triangle.swap(1, 2);
            }
        }
    }
    if turned == 0 {
        return whole();
    }
    repairs.push(Repair::InsideOut { pieces: turned });
    let triangles = pieces.into_iter().flatten().collect();
    Mesh::new(name, mesh.vertices().to_vec(), triangles)
}

/// Share of the surface that lacks the solid behind it or free space in front of it.
fn ambiguous(mesh: &Mesh) -> f64 {
    const BESIDE: f64 = 1e-4;
    let (vertices, triangles) = mesh.boundary();
    let winding = Winding::new(vertices, triangles);
    let beside = BESIDE * mesh.size_m();
    let samples = mesh.sample_surface(SAMPLES, 0);
    let unclear = samples.iter().filter(|sample| {
        let step = sample.normal * beside;
        let [within, without] = [sample.point - step, sample.point + step];
        !winding.surrounds(&within) || winding.surrounds(&without)
    });
    unclear.count() as f64 / SAMPLES as f64
}

impl Triangles {
    fn size(&self) -> f64 {
        let first = self.vertices.first().copied().unwrap_or_default();
        let (low, high) = self
            .vertices
            .iter()
            .fold((first, first), |(low, high), v| (low.inf(v), high.sup(v)));
        (high - low).max()
    }

    /// Merges vertices that lie together.
    fn weld(&mut self, repairs: &mut Vec<Repair>) {
        let reach = WELD * self.size();
        let mut order: Vec<usize> = (0..self.vertices.len()).collect();
        order.sort_by(|&a, &b| {
            let (p, q) = (self.vertices[a], self.vertices[b]);
            p.x.total_cmp(&q.x).then(a.cmp(&b))
        });
        let mut kept: Vec<u32> = (0..).take(self.vertices.len()).collect();
        let mut joined = 0;
        for (place, &a) in order.iter().enumerate() {
            for &b in order[..place].iter().rev() {
                let gap = self.vertices[a] - self.vertices[b];
                if gap.x > reach {
                    break;
                }
                if gap.norm() <= reach {
                    kept[a] = kept[b];
                    joined += usize::from(gap.norm() > 0.0);
                    break;
                }
            }
        }
        for triangle in &mut self.triangles {
            *triangle = triangle.map(|vertex| kept[vertex as usize]);
        }
        self.triangles
            .retain(|&[a, b, c]| a != b && b != c && c != a);
        if joined > 0 {
            repairs.push(Repair::Joined { vertices: joined });
        }
    }

    /// The triangles at each edge; `true` if the triangle runs along it from the lower index to the higher.
    fn edges(&self) -> BTreeMap<[u32; 2], Vec<(usize, bool)>> {
        let mut edges: BTreeMap<[u32; 2], Vec<(usize, bool)>> = BTreeMap::new();
        for (index, &[a, b, c]) in self.triangles.iter().enumerate() {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let edge = [from.min(to), from.max(to)];
                edges.entry(edge).or_default().push((index, from < to));
            }
        }
        edges
    }

    /// Turns triangles until all neighbours agree, starting with the first of each sheet. The smaller part of a sheet is
    /// turned.
    fn turn(&mut self, repairs: &mut Vec<Repair>) {
        let edges = self.edges();
        let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); self.triangles.len()];
        for at in edges.values() {
            if let [(a, up), (b, also_up)] = at[..] {
                neighbours[a].push((b, up == also_up));
                neighbours[b].push((a, up == also_up));
            }
        }
        let mut turned: Vec<Option<bool>> = vec![None; self.triangles.len()];
        let mut count = 0;
        for start in 0..self.triangles.len() {
            if turned[start].is_some() {
                continue;
            }
            turned[start] = Some(false);
            let (mut sheet, mut next) = (vec![start], 0);
            while let Some(&here) = sheet.get(next) {
                next += 1;
                let own = turned[here] == Some(true);
                for &(other, disagrees) in &neighbours[here] {
                    if turned[other].is_none() {
                        turned[other] = Some(own != disagrees);
                        sheet.push(other);
                    }
                }
            }
            let backward = sheet.iter().filter(|&&t| turned[t] == Some(true)).count();
            let most = 2 * backward > sheet.len();
            for &triangle in &sheet {
                if (turned[triangle] == Some(true)) != most {
                    self.triangles[triangle].swap(1, 2);
                    count += 1;
                }
            }
        }
        if count > 0 {
            repairs.push(Repair::Turned { triangles: count });
        }
    }

    /// Closes holes with triangles about the centre of their edge.
    fn close(&mut self, name: &str, repairs: &mut Vec<Repair>) -> Result<(), MeshError> {
        // If a triangle runs from a to b and none runs back, a patch must run back.
        let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut open = 0;
        for ([low, high], at) in self.edges() {
            let upward = at.iter().filter(|(_, up)| *up).count();
            let downward = at.len() - upward;
            open += at.len() % 2;
            let (from, to) = if upward > downward {
                (high, low)
            } else {
                (low, high)
            };
            next.entry(from)
                .or_default()
                .extend(std::iter::repeat_n(to, upward.abs_diff(downward)));
        }
        if open == 0 {
            return Ok(());
        }
        let refused = |percent: Option<f64>| MeshError::Open {
            name: name.to_owned(),
            edges: open,
            missing: percent.map_or(String::new(), |percent| {
                // Rounded up, so that a refused share is printed as more than 10 %.
                let percent = (10.0 * percent).ceil() / 10.0;
                format!(
                    " (about {percent:.1} % of its surface is missing; up to 10 % would be closed)"
                )
            }),
        };
        let mut area = 0.0;
        let mut holes = 0;
        let whole: f64 = self.triangles.iter().map(|t| self.area(t)).sum();
        while let Some((&start, _)) = next.iter().find(|(_, ends)| !ends.is_empty()) {
            let mut ring = vec![start];
            let mut here = start;
            loop {
                let Some(to) = next.get_mut(&here).and_then(Vec::pop) else {
                    return Err(refused(None));
                };
                if let Some(place) = ring.iter().position(|&vertex| vertex == to) {
                    area += self.patch(&ring[place..]);
                    holes += 1;
                    ring.truncate(place + 1);
                    if place == 0 {
                        break;
                    }
                } else {
                    ring.push(to);
                }
                here = to;
            }
        }
        let share = area / (area + whole);
        if share > LARGEST_PATCHES {
            return Err(refused(Some(100.0 * share)));
        }
        repairs.push(Repair::Closed { holes, share });
        Ok(())
    }

    fn area(&self, triangle: &[u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|vertex| self.vertices[vertex as usize]);
        (b - a).cross(&(c - a)).norm() / 2.0
    }

    /// Closes a ring of vertices and returns the area of the patch.
    fn patch(&mut self, ring: &[u32]) -> f64 {
        let corners = ring.iter().map(|&vertex| self.vertices[vertex as usize]);
        let middle = corners.sum::<Vector3<f64>>() / ring.len() as f64;
        let first = self.triangles.len();
        if let [a, b, c] = *ring {
            self.triangles.push([a, b, c]);
        } else {
            let centre = u32::try_from(self.vertices.len()).unwrap_or(u32::MAX);
            self.vertices.push(middle);
            for (place, &from) in ring.iter().enumerate() {
                self.triangles
                    .push([from, ring[(place + 1) % ring.len()], centre]);
            }
        }
        self.triangles[first..].iter().map(|t| self.area(t)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::Object;

    type Parts = (Vec<Vector3<f64>>, Vec<[u32; 3]>);

    fn mug() -> Parts {
        let (mesh, _) = Object::parts_of_named("mug").unwrap();
        (mesh.vertices().to_vec(), mesh.triangles().to_vec())
    }

    fn repaired((vertices, triangles): Parts) -> Repaired {
        Mesh::repaired("mug", vertices, triangles).unwrap()
    }

    #[test]
    fn a_sound_mesh_is_left_alone() {
        let (mesh, _) = Object::parts_of_named("mug").unwrap();
        let same = repaired(mug());
        assert_eq!(same.mesh, mesh);
        assert_eq!(same.repairs, []);
    }

    #[test]
    fn holes_and_flipped_triangles_are_repaired() {
        let (vertices, mut triangles) = mug();
        let whole = repaired(mug()).mesh.volume();
        for flipped in [3, 500, 501, 900] {
            triangles[flipped].swap(0, 1);
        }
        triangles.drain(100..130);
        triangles.remove(60);
        let fixed = repaired((vertices, triangles));
        assert!(
            matches!(fixed.repairs[0], Repair::Turned { triangles: 4 }),
            "{:?}",
            fixed.repairs
        );
        let Some(Repair::Closed { holes, share }) = fixed.repairs.get(1) else {
            panic!("{:?}", fixed.repairs);
        };
        assert!(*holes >= 2 && *share < 0.05, "{holes} {share}");
        assert!((fixed.mesh.volume() / whole - 1.0).abs() < 0.02);
    }

    #[test]
    fn corners_a_micrometre_apart_are_joined() {
        let (vertices, triangles) = mug();
        let mut apart = Vec::new();
        for (index, corner) in (0..).zip(triangles.iter().flatten()) {
            let jitter = 1e-7 * f64::from(index % 5);
            apart.push(vertices[*corner as usize].add_scalar(jitter));
        }
        let count = u32::try_from(triangles.len()).unwrap();
        let fixed = repaired((
            apart,
            (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ));
        assert!(
            matches!(fixed.repairs[..], [Repair::Joined { .. }]),
            "{:?}",
            fixed.repairs
        );
        assert_eq!(fixed.mesh.triangles().len(), triangles.len());
    }

    #[test]
    fn a_piece_inside_out_is_turned_but_a_cavity_is_not() {
        let (ball, _) = Object::parts_of_named("ball").unwrap();
        let count = u32::try_from(ball.vertices().len()).unwrap();
        let with = |offset: f64, factor: f64| -> Parts {
            let middle = ball.centroid();
            let second = ball
                .vertices()
                .iter()
                .map(|v| middle + (v - middle) * factor + Vector3::x() * offset);
            let vertices = ball.vertices().iter().copied().chain(second).collect();
            let turned = ball
                .triangles()
                .iter()
                .map(|&[a, b, c]| [a + count, c + count, b + count]);
            (
                vertices,
                ball.triangles().iter().copied().chain(turned).collect(),
            )
        };
        let beside = repaired(with(0.05, 1.0));
        assert_eq!(beside.repairs, [Repair::InsideOut { pieces: 1 }]);
        assert!(
            beside.mesh.volume() > 1.2 * ball.volume()
                && beside.mesh.volume() < 2.0 * ball.volume()
        );
        let hollow = repaired(with(0.0, 0.5));
        assert_eq!(hollow.repairs, []);
        assert!((hollow.mesh.volume() / ball.volume() - 0.875).abs() < 1e-6);
    }

    #[test]
    fn a_sheet_is_refused_with_what_is_missing() {
        let (vertices, triangles) = mug();
        let half = triangles.len() / 2;
        let error = Mesh::repaired("mug", vertices, triangles[..half].to_vec()).unwrap_err();
        let said = error.to_string();
        assert!(
            said.contains("mug is not closed") && said.contains("% of its surface"),
            "{said}"
        );
    }
}
