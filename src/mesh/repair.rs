//! Repair of surfaces that do not bound a solid as they are, if it is safe, with a note of each change.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use nalgebra::Vector3;

use super::cells::{Cells, Role};
use super::copies::Faces;
use super::exact::TriangleTree;
use super::shell::walls;
use super::winding::Winding;
use super::{Mesh, MeshError};
use crate::formats::Triangles;

/// Vertices closer than this share of the object's size are merged if the surface is not closed otherwise.
const WELD: f64 = 1e-5;
/// Largest share of a part of the surface that patches may have.
const LARGEST_PATCHES: f64 = 0.1;
/// Patches may be up to half as large as their part if all together have at most this share of the whole surface: the open end
/// of a knob or spout that stands against a body.
const SMALL_PATCHES: f64 = 0.01;
/// Largest share of the surface that may be left out because it encloses nothing.
const LARGEST_SCRAPS: f64 = 0.01;
/// The direction of a piece is known if at least this share of its surface, less what says the opposite, has it.
const CLEAR: f64 = 0.25;
/// Number of triangles of a piece that are tested for lying inside others.
const TESTED: usize = 16;
/// Number of surface samples whose sides are checked.
const SAMPLES: usize = 400;
/// Distance of points beside the surface, as a share of the size of the mesh.
const BESIDE: f64 = 1e-4;
/// A mesh is refused if at least this share of the samples lacks an inside or an outside.
const AMBIGUOUS: f64 = 0.2;
/// Largest such share of a solid that is told by the directions of the faces alone.
const MOSTLY_SURE: f64 = 0.05;
/// A smaller share is noted if it is larger than this.
const CROSSES: f64 = 0.01;

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
#[non_exhaustive]
pub enum Repair {
    /// Vertices almost in the same place were merged.
    Joined {
        /// Number of dropped vertices.
        vertices: usize,
    },
    /// Triangles that lie on others were dropped.
    Single {
        /// Their number.
        triangles: usize,
        /// The number of all triangles.
        of: usize,
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
    /// Open surfaces became walls.
    Thickened {
        /// Number of open surfaces.
        sheets: usize,
    },
    /// Triangles inside the solid were left out.
    Walls {
        /// Their number.
        triangles: usize,
    },
    /// A small part of the surface that encloses nothing was left out.
    LeftOut {
        /// Number of triangles.
        triangles: usize,
        /// Share of the surface.
        share: f64,
    },
    /// Pieces that were inside out were turned.
    InsideOut {
        /// Number of pieces.
        pieces: usize,
    },
    /// Pieces without a direction lie inside others and count as solid, although they could be the walls of cavities.
    Nested {
        /// Number of pieces.
        pieces: usize,
        /// Their volume over that of the whole mesh.
        share: f64,
    },
    /// Nothing was changed, but parts of the surface lack an inside or an outside: the surface crosses itself.
    Crosses {
        /// Share of the surface.
        share: f64,
    },
}

impl fmt::Display for Repair {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let were = |count: usize, one: &'static str, more: &'static str| {
            if count == 1 { one } else { more }
        };
        match self {
            Self::Joined { vertices } => {
                write!(
                    formatter,
                    "{vertices} vertices next to others were joined with them"
                )
            }
            Self::Single { triangles: 1, of } => {
                write!(formatter, "1 of {of} faces is there twice; one was kept")
            }
            Self::Single { triangles, of } => write!(
                formatter,
                "{triangles} of {of} faces lie on others, in the same or the opposite direction; one of each was kept"
            ),
            Self::Turned { triangles } => write!(
                formatter,
                "{triangles} triangles that faced the other way than their neighbours were turned"
            ),
            Self::Closed { holes, share } => write!(
                formatter,
                "{holes} hole{} closed ({:.1} % of the surface)",
                were(*holes, " was", "s were"),
                100.0 * share
            ),
            Self::Thickened { sheets } => write!(
                formatter,
                "{sheets} open surface{}",
                were(*sheets, " became a wall", "s became walls")
            ),
            Self::Walls { triangles } => write!(
                formatter,
                "{triangles} face{} inside the solid {} left out",
                were(*triangles, "", "s"),
                were(*triangles, "was", "were")
            ),
            Self::LeftOut { triangles, share } => write!(
                formatter,
                "{triangles} face{} enclosed nothing and {} left out ({:.1} % of the surface)",
                were(*triangles, "", "s"),
                were(*triangles, "was", "were"),
                100.0 * share
            ),
            Self::InsideOut { pieces } => write!(
                formatter,
                "{pieces} piece{} inside out and turned",
                were(*pieces, " was", "s were")
            ),
            Self::Nested { pieces, share } => write!(
                formatter,
                "{pieces} piece{} inside others {} as solid ({:.1} % of the volume), because cavities cannot be recognised \
                 where faces point both ways: to make a cavity, keep only the faces that point into it",
                were(*pieces, "", "s"),
                were(*pieces, "counts", "count"),
                100.0 * share
            ),
            Self::Crosses { share } => write!(
                formatter,
                "the surface crosses itself: {:.1} % of it has no inside or no outside next to it",
                100.0 * share
            ),
        }
    }
}

impl Mesh {
    /// A mesh of triangles that need not be closed or oriented. `name` is its name in errors.
    ///
    /// A surface that bounds a solid as it is stays the same, but for pieces that are inside out: these are turned unless they
    /// lie within another piece, because they are then the walls of a cavity.
    ///
    /// In any other surface, vertices that lie together are merged, triangles that lie on each other are kept once, and
    /// triangles are divided where corners of others lie on their edges. What the triangles then enclose is solid, whatever
    /// their directions are, and walls within it are left out. Parts that enclose nothing are closed if their holes make up at
    /// most a tenth of them. Other such parts are refused, but for scraps of at most a hundredth of the surface.
    ///
    /// Finally the winding number tests whether the surface has an inside on one side and an outside on the other nearly
    /// everywhere.
    ///
    /// # Errors
    /// If this does not suffice; the message says what is missing.
    pub fn repaired(
        name: &str,
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Repaired, MeshError> {
        Self::mended(name, vertices, triangles, None)
    }

    /// As [`Mesh::repaired`], but parts that enclose nothing become walls of the given thickness, half of it on each side, and
    /// no hole is closed.
    ///
    /// # Errors
    /// As [`Mesh::repaired`], or if there is no such part.
    pub fn thickened(
        name: &str,
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
        thickness: f64,
    ) -> Result<Repaired, MeshError> {
        Self::mended(name, vertices, triangles, Some(thickness))
    }

    fn mended(
        name: &str,
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
        thickness: Option<f64>,
    ) -> Result<Repaired, MeshError> {
        let strict = Self::closed(name, vertices.clone(), triangles.clone());
        let closed = match strict {
            Ok(mesh) => Some(mesh),
            Err(MeshError::Open { .. } | MeshError::Orientation { .. }) => None,
            Err(error) => return Err(error),
        };
        let plain = closed.as_ref().is_some_and(Self::is_plain);
        if plain && thickness.is_some() {
            return Err(MeshError::Closed(name.to_owned()));
        }
        let mut repairs = Vec::new();
        let mended = if plain {
            None
        } else {
            let mut soup = Triangles {
                vertices,
                triangles,
            };
            soup.drop_unused();
            match mend(name, soup.clone(), thickness, &mut repairs) {
                Ok(mended) => Some(mended),
                Err(error) if thickness.is_some() => return Err(error),
                // Where pieces cross at a common edge, cells leak. The directions of the faces may still tell the solid.
                Err(error) => {
                    repairs.clear();
                    let by_direction = match &closed {
                        Some(closed) => turn_pieces(name, closed, &mut repairs).ok(),
                        None => mend_by_direction(name, soup, &mut repairs),
                    };
                    let sure = by_direction.filter(|mesh| ambiguous(mesh) <= MOSTLY_SURE);
                    Some(sure.ok_or(error)?)
                }
            }
        };
        let mesh = match (mended, closed) {
            (Some(mended), None) => mended,
            (Some(mended), Some(_)) if !repairs.is_empty() => mended,
            (_, Some(closed)) => turn_pieces(name, &closed, &mut repairs)?,
            (None, None) => return Err(MeshError::NoTriangles(name.to_owned())),
        };
        let share = ambiguous(&mesh);
        if share > AMBIGUOUS {
            return Err(MeshError::Sides {
                name: name.to_owned(),
                percent: 100.0 * share,
            });
        }
        if share > CROSSES {
            repairs.push(Repair::Crosses { share });
        }
        Ok(Repaired { mesh, repairs })
    }
}

/// The solid that triangles enclose, with notes of the changes that this takes.
fn mend(
    name: &str,
    mut soup: Triangles,
    thickness: Option<f64>,
    repairs: &mut Vec<Repair>,
) -> Result<Mesh, MeshError> {
    let reach = WELD * extent(&soup.vertices);
    soup.weld(reach, repairs);
    let of = soup.triangles.len();
    if of == 0 {
        return Err(MeshError::NoVolume(name.to_owned()));
    }
    let mut faces = Faces::of(soup);
    faces.cut_at_corners(reach);
    let given = faces.triangles.len();
    let mut cells = Cells::new(&faces.vertices, &faces.triangles, given);
    let mut closing = Closing::default();
    if thickness.is_none() {
        closing.close_parts(&mut faces, &cells);
        if closing.holes > 0 {
            cells = Cells::new(&faces.vertices, &faces.triangles, given);
        }
    }
    let (vertices, triangles) = (&faces.vertices, &faces.triangles);
    let kept = cells.one_layer(vertices, triangles, |role| {
        matches!(role, Role::Boundary { .. })
    });
    let sheets = cells.one_layer(vertices, triangles, |role| role == Role::Sheet);
    let count = |test: &dyn Fn(usize) -> bool| (0..triangles.len()).filter(|&t| test(t)).count();
    let mut walls_inside = count(&|face| cells.roles[face] == Role::Wall);
    let hidden = count(&|face| {
        !kept[face] && cells.is_boundary(face) || !sheets[face] && cells.roles[face] == Role::Sheet
    });
    let covered = covers(&faces, &kept, &|face| cells.is_boundary(face))
        && covers(&faces, &sheets, &|face| cells.roles[face] == Role::Sheet);
    if !covered {
        return Err(overlaid(name, hidden));
    }
    if faces.copies + hidden > 0 {
        repairs.push(Repair::Single {
            triangles: faces.copies + hidden,
            of,
        });
    }
    let mut pieces = Pieces::of(&faces, &cells, &kept);
    let thin = pieces.drop_films(&faces, &cells);
    let (turned, turns) = pieces.turn(vertices);
    if turned > 0 {
        repairs.push(Repair::Turned { triangles: turned });
    }
    closing.report(&faces, repairs);
    let mut solid = pieces.joined(vertices);
    let mut scraps: Vec<usize> = (0..triangles.len())
        .filter(|&face| sheets[face] || thin.contains(&cells.parts[face]))
        .collect();
    let count = scraps.len();
    drop_inside(&solid, &faces, &mut scraps);
    walls_inside += count - scraps.len();
    let whole: f64 = (0..triangles.len()).map(|face| faces.area(face)).sum();
    let share = scraps.iter().map(|&face| faces.area(face)).sum::<f64>() / whole;
    if let Some(thickness) = thickness {
        if scraps.is_empty() {
            return Err(MeshError::Closed(name.to_owned()));
        }
        if !thin.is_empty() {
            return Err(MeshError::NoVolume(name.to_owned()));
        }
        let scraps = scraps.iter().map(|&face| triangles[face]).collect();
        let walls = walls(vertices, scraps, thickness);
        repairs.push(Repair::Thickened {
            sheets: walls.count,
        });
        solid.append(walls.soup);
    } else if solid.triangles.is_empty() {
        return Err(closing.refusal(name, &faces));
    } else if share > LARGEST_SCRAPS {
        return Err(MeshError::Sheets {
            name: name.to_owned(),
            percent: 100.0 * share,
        });
    }
    if walls_inside > 0 {
        repairs.push(Repair::Walls {
            triangles: walls_inside,
        });
    }
    if thickness.is_none() && !scraps.is_empty() {
        repairs.push(Repair::LeftOut {
            triangles: scraps.len(),
            share,
        });
    }
    if turns > 0 {
        repairs.push(Repair::InsideOut { pieces: turns });
    }
    if let Some(nested) = pieces.nested(vertices) {
        repairs.push(nested);
    }
    united(name, solid)
}

/// The solid of faces without copies, told by their directions: neighbours are made to agree, and holes are closed if that
/// takes small patches only. `None` if faces lie on each other or this gives no closed surface.
fn mend_by_direction(name: &str, mut soup: Triangles, repairs: &mut Vec<Repair>) -> Option<Mesh> {
    soup.weld(WELD * extent(&soup.vertices), repairs);
    if Faces::of(soup.clone()).copies > 0 {
        return None;
    }
    let before = soup.triangles.clone();
    soup.turn();
    let turned = soup
        .triangles
        .iter()
        .zip(&before)
        .filter(|(a, b)| a != b)
        .count();
    if turned > 0 {
        repairs.push(Repair::Turned { triangles: turned });
    }
    let area: f64 = soup
        .triangles
        .iter()
        .map(|triangle| soup.area(triangle))
        .sum();
    let patches = soup.patches()?;
    if patches.area > LARGEST_PATCHES * (area + patches.area) {
        return None;
    }
    if patches.holes > 0 {
        repairs.push(Repair::Closed {
            holes: patches.holes,
            share: patches.area / (area + patches.area),
        });
    }
    soup.triangles.extend(patches.triangles);
    let closed = Mesh::closed(name, soup.vertices, soup.triangles).ok()?;
    turn_pieces(name, &closed, repairs).ok()
}

/// Whether each face of a role that is not in the layer that is kept of it lies on that layer. Where pieces share an edge and
/// lie on each other only there, the choice of a layer would drop a whole piece.
fn covers(faces: &Faces, layer: &[bool], of_role: &dyn Fn(usize) -> bool) -> bool {
    let mut dropped = (0..layer.len())
        .filter(|&face| !layer[face] && of_role(face))
        .peekable();
    if dropped.peek().is_none() {
        return true;
    }
    let kept = (faces.triangles.iter().zip(layer)).filter(|(_, kept)| **kept);
    let kept: Vec<[u32; 3]> = kept.map(|(triangle, _)| *triangle).collect();
    let Some(kept) = TriangleTree::new(&faces.vertices, &kept) else {
        return false;
    };
    let reach = depth(&faces.vertices);
    dropped.all(|face| {
        let corners = faces.triangles[face].map(|vertex| faces.vertices[vertex as usize]);
        let middle = corners.iter().sum::<Vector3<f64>>() / 3.0;
        (kept.foot(&middle) - middle).norm() <= reach
    })
}

/// The mesh of pieces that are closed unless faces lie on each other in a way that is not resolved.
fn united(name: &str, solid: Triangles) -> Result<Mesh, MeshError> {
    let mesh = Mesh::new(name, solid.vertices, solid.triangles);
    mesh.map_err(|error| match error {
        MeshError::Open { edges, .. } | MeshError::Orientation { edges, .. } => {
            overlaid(name, edges)
        }
        error => error,
    })
}

fn overlaid(name: &str, edges: usize) -> MeshError {
    MeshError::Overlaid {
        name: name.to_owned(),
        edges,
    }
}

/// Drops the triangles among `scraps` that lie in a solid.
fn drop_inside(solid: &Triangles, faces: &Faces, scraps: &mut Vec<usize>) {
    if scraps.is_empty() || solid.triangles.is_empty() {
        return;
    }
    let inside = Winding::new(&solid.vertices, &solid.triangles);
    scraps.retain(|&face| {
        let corners = faces.triangles[face].map(|vertex| faces.vertices[vertex as usize]);
        !lies_inside(&corners, &inside)
    });
}

/// Whether a triangle lies in a solid, except perhaps for its corners.
fn lies_inside(corners: &[Vector3<f64>; 3], solid: &Winding) -> bool {
    let middle = corners.iter().sum::<Vector3<f64>>() / 3.0;
    let near = |corner: &Vector3<f64>| middle.lerp(corner, 0.95);
    solid.surrounds(&middle) && corners.iter().all(|corner| solid.surrounds(&near(corner)))
}

/// A closed piece of the surface. Its triangles face outward unless it is the wall of a cavity.
#[derive(Debug, Default)]
struct Piece {
    triangles: Vec<[u32; 3]>,
    /// Area of the given triangles that face outward, less that of those that face inward.
    outward: f64,
    area: f64,
    /// Numbers of kept triangles that were given outward and inward.
    outward_faces: usize,
    inward_faces: usize,
    /// The part of the surface that it belongs to.
    part: usize,
    /// Whether it bounds a cavity.
    cavity: bool,
}

impl Piece {
    /// Its direction as given: 1 if all faces point outward, −1 if all point inward, 0 if they tell nothing.
    fn direction(&self) -> f64 {
        self.outward / self.area.max(f64::MIN_POSITIVE)
    }

    /// Points just inside some of its triangles.
    fn inner_points(&self, vertices: &[Vector3<f64>], depth: f64) -> Vec<Vector3<f64>> {
        let step = self.triangles.len().div_ceil(TESTED).max(1);
        let point = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0);
            (a + b + c) / 3.0 - normal.unwrap_or_default() * depth
        };
        self.triangles.iter().step_by(step).map(point).collect()
    }

    /// Six times its volume.
    fn volume(&self, vertices: &[Vector3<f64>]) -> f64 {
        let Some(first) = self.triangles.first() else {
            return 0.0;
        };
        let origin = vertices[first[0] as usize];
        let volume = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize] - origin);
            a.dot(&b.cross(&c))
        };
        self.triangles.iter().map(volume).sum()
    }
}

/// The pieces of a surface.
struct Pieces(Vec<Piece>);

impl Pieces {
    /// The pieces that bound what `cells` enclose, of the triangles that are kept.
    fn of(faces: &Faces, cells: &Cells, kept: &[bool]) -> Self {
        let mut pieces: BTreeMap<usize, Piece> = BTreeMap::new();
        for (face, &[a, b, c]) in faces.triangles.iter().enumerate() {
            let Role::Boundary { turned } = cells.roles[face] else {
                continue;
            };
            let piece = pieces.entry(cells.solids[face]).or_default();
            piece.part = cells.parts[face];
            let vote = faces.votes[face].signum() * if turned { -1 } else { 1 };
            piece.area += faces.area(face);
            piece.outward += f64::from(vote) * faces.area(face);
            if kept[face] {
                piece.inward_faces += usize::from(vote < 0);
                piece.outward_faces += usize::from(vote > 0);
                let outward = if turned { [a, c, b] } else { [a, b, c] };
                piece.triangles.push(outward);
            }
        }
        Self(pieces.into_values().collect())
    }

    /// Drops the pieces of parts whose mean thickness is almost nothing, and returns these parts: sheets that are there twice
    /// with little space between.
    fn drop_films(&mut self, faces: &Faces, cells: &Cells) -> BTreeSet<usize> {
        /// Mean thickness, as a share of the square root of the area.
        const FILM: f64 = 2e-4;
        let mut parts: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        for face in (0..faces.triangles.len()).filter(|&face| cells.is_boundary(face)) {
            parts.entry(cells.parts[face]).or_default()[0] += faces.area(face);
        }
        for piece in &self.0 {
            parts.entry(piece.part).or_default()[1] += piece.volume(&faces.vertices) / 6.0;
        }
        let thin = parts
            .into_iter()
            .filter(|(_, [area, volume])| 2.0 * volume < FILM * area * area.sqrt());
        let thin: BTreeSet<usize> = thin.map(|(part, _)| part).collect();
        self.0.retain(|piece| !thin.contains(&piece.part));
        thin
    }

    /// The triangles of all pieces but the cavities, or of all of them.
    fn triangles(&self, with_cavities: bool) -> Vec<[u32; 3]> {
        let pieces = self.0.iter().filter(|piece| with_cavities || !piece.cavity);
        pieces
            .flat_map(|piece| piece.triangles.iter().copied())
            .collect()
    }

    /// Turns pieces that were given inward and lie in others, because they are the walls of cavities. Returns the number of
    /// triangles that disagree with their piece, and of pieces that were inside out.
    fn turn(&mut self, vertices: &[Vector3<f64>]) -> (usize, usize) {
        let mut against = 0;
        for piece in &mut self.0 {
            piece.cavity = piece.direction() <= -CLEAR;
            against += if piece.direction() < 0.0 {
                piece.outward_faces
            } else {
                piece.inward_faces
            };
        }
        if !self.0.iter().any(|piece| piece.cavity) {
            return (against, 0);
        }
        let mut inside_out = 0;
        let others = Winding::new(vertices, &self.triangles(false));
        let depth = depth(vertices);
        for piece in self.0.iter_mut().filter(|piece| piece.cavity) {
            let mut points = piece.inner_points(vertices, depth).into_iter();
            piece.cavity = points.all(|point| others.surrounds(&point));
            if piece.cavity {
                for triangle in &mut piece.triangles {
                    triangle.swap(1, 2);
                }
            } else {
                inside_out += 1;
            }
        }
        (against, inside_out)
    }

    /// A note of the pieces that lie in others and whose faces do not tell their direction.
    fn nested(&self, vertices: &[Vector3<f64>]) -> Option<Repair> {
        let unclear = |piece: &&Piece| piece.direction().abs() < CLEAR;
        if self.0.len() < 2 || !self.0.iter().any(|piece| unclear(&piece)) {
            return None;
        }
        let all = Winding::new(vertices, &self.triangles(true));
        let depth = depth(vertices);
        let (mut pieces, mut volume) = (0, 0.0);
        for piece in self.0.iter().filter(unclear) {
            let points = piece.inner_points(vertices, depth);
            // The piece itself surrounds them once.
            if points.iter().all(|point| all.at(point) > 1.5) {
                pieces += 1;
                volume += piece.volume(vertices);
            }
        }
        let of: f64 = self.0.iter().map(|piece| piece.volume(vertices)).sum();
        (pieces > 0).then_some(Repair::Nested {
            pieces,
            share: volume / (of - volume),
        })
    }

    /// The pieces as one mesh, in which they share no vertices.
    fn joined(&self, vertices: &[Vector3<f64>]) -> Triangles {
        let mut joined = Triangles::default();
        let mut places: Vec<Option<(usize, u32)>> = vec![None; vertices.len()];
        for (number, piece) in self.0.iter().enumerate() {
            for triangle in &piece.triangles {
                let triangle = triangle.map(|vertex| match places[vertex as usize] {
                    Some((owner, place)) if owner == number => place,
                    _ => {
                        let place = u32::try_from(joined.vertices.len()).unwrap_or(u32::MAX);
                        joined.vertices.push(vertices[vertex as usize]);
                        places[vertex as usize] = Some((number, place));
                        place
                    }
                });
                joined.triangles.push(triangle);
            }
        }
        joined
    }
}

/// How far inside a piece its place is tested.
fn depth(vertices: &[Vector3<f64>]) -> f64 {
    BESIDE * extent(vertices)
}

/// Longest side of the bounding box.
fn extent(vertices: &[Vector3<f64>]) -> f64 {
    let first = vertices.first().copied().unwrap_or_default();
    let (low, high) = vertices
        .iter()
        .fold((first, first), |(low, high), v| (low.inf(v), high.sup(v)));
    (high - low).max()
}

/// What was closed, and what is open.
#[derive(Debug, Default)]
struct Closing {
    holes: usize,
    /// Area of the patches.
    patched: f64,
    /// Area of the parts that stay open because of their holes, and of the patches that would close them.
    open: f64,
    missing: f64,
}

impl Closing {
    /// Closes the holes of parts that enclose nothing, if that takes small patches only.
    fn close_parts(&mut self, faces: &mut Faces, cells: &Cells) {
        let mut open: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for face in (0..faces.triangles.len()).filter(|&face| cells.roles[face] == Role::Sheet) {
            open.entry(cells.parts[face]).or_default().push(face);
        }
        let whole: f64 = (0..faces.triangles.len())
            .map(|face| faces.area(face))
            .sum();
        for part in open.into_values() {
            let area: f64 = part.iter().map(|&face| faces.area(face)).sum();
            let mut soup = Triangles {
                vertices: std::mem::take(&mut faces.vertices),
                triangles: part.iter().map(|&face| faces.triangles[face]).collect(),
            };
            soup.turn();
            let corners = soup.vertices.len();
            let patches = soup.patches();
            faces.vertices = soup.vertices;
            let Some(patches) = patches else {
                continue;
            };
            let small = patches.area <= LARGEST_PATCHES * (patches.area + area)
                || patches.area < 0.5 * area
                    && self.patched + patches.area <= SMALL_PATCHES * whole;
            if !small {
                faces.vertices.truncate(corners);
                self.open += area;
                self.missing += patches.area;
                continue;
            }
            self.holes += patches.holes;
            self.patched += patches.area;
            faces.votes.extend(vec![0; patches.triangles.len()]);
            faces.triangles.extend(patches.triangles);
        }
    }

    fn report(&self, faces: &Faces, repairs: &mut Vec<Repair>) {
        if self.holes > 0 {
            let whole: f64 = (0..faces.triangles.len())
                .map(|face| faces.area(face))
                .sum();
            repairs.push(Repair::Closed {
                holes: self.holes,
                share: self.patched / whole,
            });
        }
    }

    /// The error if nothing is enclosed.
    fn refusal(&self, name: &str, faces: &Faces) -> MeshError {
        let edges = faces.open_edges();
        if edges == 0 {
            return MeshError::NoVolume(name.to_owned());
        }
        let missing = if self.missing > 0.0 {
            let percent = 100.0 * self.missing / (self.missing + self.open);
            // Rounded up, so that a refused share is printed as more than 10 %.
            let percent = (10.0 * percent).ceil() / 10.0;
            format!(" (about {percent:.1} % of its surface is missing; up to 10 % would be closed)")
        } else {
            String::new()
        };
        MeshError::Open {
            name: name.to_owned(),
            edges,
            missing,
        }
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
    /// Drops the vertices of no triangle, which would count in the size.
    fn drop_unused(&mut self) {
        let mut places = vec![None; self.vertices.len()];
        let mut kept = Vec::new();
        for corner in self.triangles.iter_mut().flatten() {
            let Some(place) = places.get_mut(*corner as usize) else {
                continue;
            };
            *corner = *place.get_or_insert_with(|| {
                kept.push(self.vertices[*corner as usize]);
                u32::try_from(kept.len() - 1).unwrap_or(u32::MAX)
            });
        }
        self.vertices = kept;
    }

    /// Merges vertices that lie together, and drops triangles without width.
    fn weld(&mut self, reach: f64, repairs: &mut Vec<Repair>) {
        /// Side of the cells in which vertices are looked up, in reaches.
        const CELL: f64 = 64.0;
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a cell is a millionth of the size or larger"
        )]
        let cell = |x: f64| (x / (CELL * reach)).floor() as i64;
        let first = self.vertices.first().copied().unwrap_or_default();
        let mut cells: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
        let mut kept: Vec<u32> = (0..).take(self.vertices.len()).collect();
        let mut joined = 0;
        let used: BTreeSet<u32> = self.triangles.iter().flatten().copied().collect();
        for &index in &used {
            let vertex = self.vertices[index as usize];
            let low = (vertex - first).add_scalar(-reach).map(cell);
            let high = (vertex - first).add_scalar(reach).map(cell);
            let near = (low.x..=high.x)
                .flat_map(|x| (low.y..=high.y).map(move |y| (x, y)))
                .flat_map(|(x, y)| (low.z..=high.z).map(move |z| [x, y, z]))
                .filter_map(|key| cells.get(&key))
                .flatten()
                .find(|&&other| (self.vertices[other as usize] - vertex).norm() <= reach);
            if let Some(&other) = near {
                kept[index as usize] = other;
                joined += usize::from(self.vertices[other as usize] != vertex);
            } else {
                let key = (vertex - first).map(cell);
                cells.entry([key.x, key.y, key.z]).or_default().push(index);
            }
        }
        for triangle in &mut self.triangles {
            *triangle = triangle.map(|vertex| kept[vertex as usize]);
        }
        let vertices = &self.vertices;
        let wide = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            (b - a).cross(&(c - a)).norm() > 0.5 * reach * longest
        };
        self.triangles.retain(wide);
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
    fn turn(&mut self) {
        let edges = self.edges();
        let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); self.triangles.len()];
        for at in edges.values() {
            if let [(a, up), (b, also_up)] = at[..] {
                neighbours[a].push((b, up == also_up));
                neighbours[b].push((a, up == also_up));
            }
        }
        let mut turned: Vec<Option<bool>> = vec![None; self.triangles.len()];
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
                }
            }
        }
    }

    /// Triangles about the centres of all holes, with new vertices at these centres; `None` if the edges of the holes do not
    /// form rings.
    fn patches(&mut self) -> Option<Patches> {
        // If a triangle runs from a to b and none runs back, a patch must run back.
        let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for ([low, high], at) in self.edges() {
            let upward = at.iter().filter(|(_, up)| *up).count();
            let downward = at.len() - upward;
            let (from, to) = if upward > downward {
                (high, low)
            } else {
                (low, high)
            };
            next.entry(from)
                .or_default()
                .extend(std::iter::repeat_n(to, upward.abs_diff(downward)));
        }
        let corners = self.vertices.len();
        let mut patches = Patches::default();
        let starts: Vec<u32> = next.keys().copied().collect();
        for start in starts {
            while next.get(&start).is_some_and(|ends| !ends.is_empty()) {
                let mut ring = vec![start];
                let mut here = start;
                loop {
                    let Some(to) = next.get_mut(&here).and_then(Vec::pop) else {
                        self.vertices.truncate(corners);
                        return None;
                    };
                    if let Some(place) = ring.iter().position(|&vertex| vertex == to) {
                        self.patch(&ring[place..], &mut patches);
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
        }
        Some(patches)
    }

    fn area(&self, triangle: &[u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|vertex| self.vertices[vertex as usize]);
        (b - a).cross(&(c - a)).norm() / 2.0
    }

    /// Closes a ring of vertices.
    fn patch(&mut self, ring: &[u32], patches: &mut Patches) {
        let corners = ring.iter().map(|&vertex| self.vertices[vertex as usize]);
        let middle = corners.sum::<Vector3<f64>>() / ring.len() as f64;
        let first = patches.triangles.len();
        if let [a, b, c] = *ring {
            patches.triangles.push([a, b, c]);
        } else {
            let centre = u32::try_from(self.vertices.len()).unwrap_or(u32::MAX);
            self.vertices.push(middle);
            for (place, &from) in ring.iter().enumerate() {
                let to = ring[(place + 1) % ring.len()];
                patches.triangles.push([from, to, centre]);
            }
        }
        let new = &patches.triangles[first..];
        patches.area += new.iter().map(|t| self.area(t)).sum::<f64>();
        patches.holes += 1;
    }

    /// Adds other triangles.
    fn append(&mut self, other: Self) {
        let first = u32::try_from(self.vertices.len()).unwrap_or(u32::MAX);
        self.vertices.extend(other.vertices);
        let moved = |triangle: [u32; 3]| triangle.map(|vertex| vertex.saturating_add(first));
        self.triangles
            .extend(other.triangles.into_iter().map(moved));
    }
}

/// Triangles that close holes.
#[derive(Debug, Default)]
struct Patches {
    triangles: Vec<[u32; 3]>,
    holes: usize,
    area: f64,
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
