//! The object in the simulation: convex pieces, or the mesh itself.

use nalgebra::{Isometry3, Matrix3, Vector3};
use rapier3d_f64::geometry::SharedShape;
use rapier3d_f64::math::{Pose, Vector};
use rapier3d_f64::parry::mass_properties::MassProperties;
use rapier3d_f64::parry::shape::TriMeshFlags;
use rapier3d_f64::parry::transformation::try_convex_hull;
use rapier3d_f64::parry::transformation::vhacd::{VHACD, VHACDParameters};
use serde::Serialize;

use super::convert::{from_vector, vector};
use super::inertia::uniform;
use crate::cache::{Cache, Key, Kind, Reader};
use crate::caught::caught;
use crate::mesh::{ExactMesh, Mesh};

/// Version of what is kept of a cut. Raise it whenever cutting, the comparison with the mesh or the format changes, also by
/// another version of the library that cuts.
const VERSION: u32 = 2;

/// A mesh that its hull fills by no more than this, metres, is one convex piece. Cutting would leave gaps between the pieces
/// of a thin body.
const CONVEX_M: f64 = 1e-4;
/// Cells along the longest side of the grid in which a mesh is cut, and those of the grids that are tried in its place: on
/// some sets of cells the hulls of the library panic.
const RESOLUTION: u32 = 128;
const OTHER_RESOLUTIONS: [u32; 8] = [125, 122, 119, 116, 113, 110, 107, 104];
/// A piece is cut again while the volume of its hull exceeds its own by this share of the volume of the whole hull.
const CONCAVITY: f64 = 0.002;
/// Grids to which the corners of a piece are rounded where the engine refuses its hull, metres.
const ROUNDINGS_M: [f64; 4] = [1e-7, 1e-6, 1e-5, 1e-4];
/// Largest number of pieces.
const PIECES: u32 = 64;
/// Number of surface points for comparing pieces with the mesh.
const SAMPLES: usize = 4_000;

/// A convex piece: the hull of a part of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Vertices, metres.
    pub vertices: Vec<Vector3<f64>>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Representation of an object in the simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Build {
    /// Convex pieces (VHACD; Mamou 2016), with the exact surface where it is convex.
    Pieces,
    /// The triangles of the mesh, one-sided: exact, but a surface without an interior.
    Triangles,
}

/// How well the pieces fit the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fit {
    /// Number of pieces.
    pub pieces: usize,
    /// Sum of the pieces' volumes over the mesh's volume, less 1.
    pub volume_error: f64,
    /// Deepest point of the mesh's surface inside the pieces, metres: a cavity that they fill.
    pub filled_m: f64,
    /// Farthest point of the mesh's surface outside the pieces, metres: a part that they cut off.
    pub cut_m: f64,
}

/// A solid with the mass distribution of a uniform body. Cheap to clone.
#[derive(Clone)]
pub struct Solid {
    exact: ExactMesh,
    pub(super) shape: SharedShape,
    pub(super) unit: MassProperties,
    pieces: Vec<Piece>,
    fit: Fit,
    reach_m: f64,
    volume_m3: f64,
}

impl std::fmt::Debug for Solid {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Solid")
            .field("fit", &self.fit)
            .finish_non_exhaustive()
    }
}

impl Solid {
    /// The solid of a mesh: its hull if it is convex to 0.1 mm, otherwise convex pieces. Nothing is random.
    ///
    /// Cutting takes seconds to a minute. The pieces are kept in the user's cache folder, so that a mesh is cut once.
    ///
    /// # Panics
    /// Never: a [`Mesh`] has triangles.
    pub fn new(mesh: &Mesh, build: Build) -> Self {
        Self::announced(mesh, build, &|| ())
    }

    /// As [`Solid::new`]; `cutting` is called before the mesh is cut, if it is.
    ///
    /// # Panics
    /// Never: a [`Mesh`] has triangles.
    pub fn announced(mesh: &Mesh, build: Build, cutting: &dyn Fn()) -> Self {
        Self::kept_in(&Cache::of_user(), mesh, build, cutting)
    }

    /// As [`Solid::announced`], with another cache.
    fn kept_in(cache: &Cache, mesh: &Mesh, build: Build, cutting: &dyn Fn()) -> Self {
        let vertices: Vec<_> = mesh.vertices().iter().map(vector).collect();
        let unit = uniform(mesh);
        let centre = from_vector(unit.local_com);
        let reach_m = mesh
            .vertices()
            .iter()
            .map(|vertex| (vertex - centre).norm())
            .fold(0.0, f64::max);
        let volume_m3 = mesh.volume();
        if build == Build::Triangles {
            let shape = surface(mesh, vertices);
            let fit = Fit {
                pieces: 1,
                volume_error: 0.0,
                filled_m: 0.0,
                cut_m: 0.0,
            };
            return Self {
                exact: ExactMesh::new(mesh),
                shape,
                unit,
                pieces: Vec::new(),
                fit,
                reach_m,
                volume_m3,
            };
        }
        let key = key(mesh);
        let kept = cache.find(Kind::Pieces, key);
        let (pieces, fit) = kept
            .and_then(|content| decode(&content))
            .unwrap_or_else(|| {
                let cut = cut(mesh, &vertices, cutting);
                cache.keep(Kind::Pieces, key, &encode(&cut.0, &cut.1));
                cut
            });
        let parts = shapes(&pieces);
        let shape = if parts.is_empty() {
            surface(mesh, vertices)
        } else {
            SharedShape::compound(parts)
        };
        Self {
            exact: ExactMesh::new(mesh),
            shape,
            unit,
            pieces,
            fit,
            reach_m,
            volume_m3,
        }
    }

    /// The convex pieces; empty for [`Build::Triangles`].
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// How well the pieces fit the mesh.
    pub fn fit(&self) -> &Fit {
        &self.fit
    }

    /// Centre of mass of the uniform body, metres.
    pub fn centre(&self) -> Vector3<f64> {
        from_vector(self.unit.local_com)
    }

    /// Distance of the farthest point of the surface from the centre of mass, metres.
    pub(super) fn reach_m(&self) -> f64 {
        self.reach_m
    }

    /// Volume of the mesh, m³; what overlaps counts once.
    pub fn volume_m3(&self) -> f64 {
        self.volume_m3
    }

    /// Moments of inertia of the uniform body of 1 kg about its centre of mass, in the axes of the object's frame, m².
    pub fn unit_inertia(&self) -> Matrix3<f64> {
        let matrix = self.unit.reconstruct_inertia_matrix();
        Matrix3::from_columns(&[
            from_vector(matrix.x_axis),
            from_vector(matrix.y_axis),
            from_vector(matrix.z_axis),
        ])
    }

    /// Unit normal into the object at the point of its surface nearest to `point`.
    pub(super) fn inward_normal(&self, point: &Vector3<f64>) -> Vector3<f64> {
        -self.exact.nearest(point).normal
    }

    /// Signed distance of a point from the surface, metres; negative inside.
    pub(super) fn distance_m(&self, point: &Vector3<f64>) -> f64 {
        self.exact.distance(point)
    }

    pub(super) fn of_mass(&self, mass_kg: f64) -> MassProperties {
        let mut properties = self.unit;
        properties.set_mass(mass_kg, true);
        properties
    }
}

/// The triangles of a mesh.
fn surface(mesh: &Mesh, vertices: Vec<rapier3d_f64::math::Vector>) -> SharedShape {
    let flags = TriMeshFlags::FIX_INTERNAL_EDGES;
    SharedShape::trimesh_with_flags(vertices, mesh.triangles().to_vec(), flags)
        .expect("a mesh has triangles")
}

/// The hull of a mesh if it is convex, otherwise its convex pieces; and how well they fit.
fn cut(mesh: &Mesh, vertices: &[Vector], cutting: &dyn Fn()) -> (Vec<Piece>, Fit) {
    let whole: Vec<Piece> = hull(vertices).into_iter().collect();
    let one = shapes(&whole);
    let one_fit = fit(mesh, &whole, &one);
    if !one.is_empty() && one_fit.filled_m <= CONVEX_M {
        return (whole, one_fit);
    }
    cutting();
    let grids = [RESOLUTION].into_iter().chain(OTHER_RESOLUTIONS);
    let Some(pieces) = first_cut(grids, |grid| decomposed(mesh, vertices, grid)) else {
        return (whole, one_fit);
    };
    let fit = fit(mesh, &pieces, &shapes(&pieces));
    (pieces, fit)
}

/// What `cut` makes in the first of these grids in which it does not panic.
fn first_cut(
    grids: impl IntoIterator<Item = u32>,
    cut: impl Fn(u32) -> Vec<Piece>,
) -> Option<Vec<Piece>> {
    let pieces = |grid| caught(|| cut(grid)).filter(|pieces| !pieces.is_empty());
    grids.into_iter().find_map(pieces)
}

/// Hash of everything that a cut and its fit depend on.
fn key(mesh: &Mesh) -> Key {
    let mut key = Key::default();
    key.feed(&VERSION.to_le_bytes());
    for number in [RESOLUTION, PIECES] {
        key.feed(&number.to_le_bytes());
    }
    for number in [CONVEX_M, CONCAVITY] {
        key.feed(&number.to_le_bytes());
    }
    key.feed(&(SAMPLES as u64).to_le_bytes());
    // The pieces are those of the triangles, and the fit is that to the surface of their union.
    let own = (mesh.vertices(), mesh.triangles());
    for (vertices, triangles) in [own, mesh.boundary()] {
        key.feed(&(vertices.len() as u64).to_le_bytes());
        for coordinate in vertices.iter().flatten() {
            key.feed(&coordinate.to_le_bytes());
        }
        for index in triangles.iter().flatten() {
            key.feed(&index.to_le_bytes());
        }
    }
    key
}

/// The numbers of a cut.
fn encode(pieces: &[Piece], fit: &Fit) -> Vec<u8> {
    let mut bytes = Vec::new();
    for number in [fit.volume_error, fit.filled_m, fit.cut_m] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend((pieces.len() as u64).to_le_bytes());
    for piece in pieces {
        bytes.extend((piece.vertices.len() as u64).to_le_bytes());
        bytes.extend((piece.triangles.len() as u64).to_le_bytes());
        for coordinate in piece.vertices.iter().flatten() {
            bytes.extend(coordinate.to_le_bytes());
        }
        for index in piece.triangles.iter().flatten() {
            bytes.extend(index.to_le_bytes());
        }
    }
    bytes
}

/// The cut of these numbers.
fn decode(content: &[u8]) -> Option<(Vec<Piece>, Fit)> {
    let mut reader = Reader(content);
    let [volume_error, filled_m, cut_m] = [reader.number()?, reader.number()?, reader.number()?];
    let mut pieces = Vec::new();
    for _ in 0..reader.count()? {
        let [corners, faces] = [reader.count()?, reader.count()?];
        let mut vertices = Vec::new();
        for _ in 0..corners {
            vertices.push(reader.vector()?);
        }
        let mut triangles = Vec::new();
        for _ in 0..faces {
            let triangle = [reader.index()?, reader.index()?, reader.index()?];
            if triangle.iter().any(|&index| index as usize >= corners) {
                return None;
            }
            triangles.push(triangle);
        }
        pieces.push(Piece {
            vertices,
            triangles,
        });
    }
    let fit = Fit {
        pieces: pieces.len(),
        volume_error,
        filled_m,
        cut_m,
    };
    (reader.0.is_empty() && !pieces.is_empty()).then_some((pieces, fit))
}

/// Cuts a mesh into convex pieces in a grid with this number of cells along its longest side.
fn decomposed(mesh: &Mesh, vertices: &[Vector], resolution: u32) -> Vec<Piece> {
    let settings = VHACDParameters {
        resolution,
        concavity: CONCAVITY,
        plane_downsampling: 2,
        convex_hull_downsampling: 2,
        max_convex_hulls: PIECES,
        ..VHACDParameters::default()
    };
    let parts = VHACD::decompose(&settings, vertices, mesh.triangles(), true);
    let surfaces = parts.compute_primitive_intersections(vertices, mesh.triangles());
    surfaces
        .into_iter()
        .zip(parts.voxel_parts())
        .map(|(mut points, part)| {
            // Where cuts cross inside, a piece has corners that are not on the surface.
            let inside = part.voxels().iter().filter(|voxel| !voxel.is_on_surface);
            points.extend(inside.map(|voxel| part.get_voxel_point(voxel)));
            points
        })
        .filter(|points| points.len() > 3)
        .filter_map(|points| hull(&points))
        .collect()
}

/// The hull of points. Hulls of nearly coplanar points are sometimes not closed, and the engine refuses them: then the points
/// are rounded, more and more, until it takes one. `None` for points of a plane.
fn hull(points: &[Vector]) -> Option<Piece> {
    let is_taken = |vertices: &[Vector], triangles: &[[u32; 3]]| {
        SharedShape::convex_mesh(vertices.to_vec(), triangles).is_some()
    };
    taken_hull(points, is_taken)
}

/// The first hull of the points as they are, or rounded, that is taken.
fn taken_hull(
    points: &[Vector],
    is_taken: impl Fn(&[Vector], &[[u32; 3]]) -> bool,
) -> Option<Piece> {
    let of = |points: &[Vector]| {
        let (vertices, triangles) = try_convex_hull(points).ok()?;
        is_taken(&vertices, &triangles).then(|| Piece {
            vertices: vertices.into_iter().map(from_vector).collect(),
            triangles,
        })
    };
    let rounded = |grid_m: f64| {
        let round = |point: &Vector| (*point / grid_m).round() * grid_m;
        of(&points.iter().map(round).collect::<Vec<_>>())
    };
    of(points).or_else(|| ROUNDINGS_M.into_iter().find_map(rounded))
}

fn shapes(pieces: &[Piece]) -> Vec<(Pose, SharedShape)> {
    let shape = |piece: &Piece| {
        let points = piece.vertices.iter().map(vector).collect();
        let shape = SharedShape::convex_mesh(points, &piece.triangles)?;
        Some((Pose::IDENTITY, shape))
    };
    pieces.iter().filter_map(shape).collect()
}

/// Compares pieces with the mesh they were cut from.
fn fit(mesh: &Mesh, pieces: &[Piece], shapes: &[(Pose, SharedShape)]) -> Fit {
    let volume: f64 = pieces
        .iter()
        .map(|piece| {
            let corner = |index: u32| piece.vertices[index as usize] - piece.vertices[0];
            let six: f64 = piece
                .triangles
                .iter()
                .map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))))
                .sum();
            six / 6.0
        })
        .sum();
    let (mut filled_m, mut cut_m) = (0.0f64, 0.0f64);
    for sample in mesh.sample_surface(SAMPLES, 0) {
        let point = vector(&sample.point);
        let distance = |(_, shape): &(Pose, SharedShape)| {
            let projection = shape.project_local_point(point, false);
            let length = (projection.point - point).length();
            if projection.is_inside {
                -length
            } else {
                length
            }
        };
        let nearest = shapes.iter().map(distance).fold(f64::INFINITY, f64::min);
        filled_m = filled_m.max(-nearest);
        cut_m = cut_m.max(nearest);
    }
    Fit {
        pieces: pieces.len(),
        volume_error: volume / mesh.volume() - 1.0,
        filled_m,
        cut_m,
    }
}

/// A pose as a displacement of `centre` (metres) and a rotation angle (radians).
pub(super) fn motion(from_start: &Isometry3<f64>, centre: &Vector3<f64>) -> (Vector3<f64>, f64) {
    let moved = from_start.transform_point(&(*centre).into()).coords - centre;
    (moved, from_start.rotation.angle())
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use rand::RngExt;

    use super::*;
    use crate::mesh::Mesh;
    use crate::object::Object;
    use crate::sample::{Task, stream};

    /// Two boxes that form an L.
    fn corner() -> Mesh {
        let boxes = "\
            [[parts]]\ncuboid = { centre = [0, 0, 0], half_extents = [0.03, 0.01, 0.01] }\n\
            [[parts]]\ncuboid = { centre = [0.02, 0, 0.02], half_extents = [0.01, 0.01, 0.02] }\n";
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("corner.toml");
        std::fs::write(&path, boxes).unwrap();
        Object::parts_of_file(&path, None).unwrap().mesh
    }

    #[test]
    fn a_hull_that_is_refused_is_made_of_rounded_points() {
        let mut rng = stream(7, Task::Permutation, 0);
        let mut coordinate = || rng.random_range(-0.02..0.02);
        let points: Vec<Vector> = (0..60)
            .map(|_| vector(&Vector3::from([(); 3].map(|()| coordinate()))))
            .collect();
        let refusals = Cell::new(0);
        let after = |count: usize| {
            refusals.set(0);
            taken_hull(&points, |_, _| {
                refusals.set(refusals.get() + 1);
                refusals.get() > count
            })
        };
        let plain = after(0).unwrap();
        assert_eq!(Some(&plain), hull(&points).as_ref());
        for (count, grid_m) in ROUNDINGS_M.into_iter().enumerate() {
            let rounded = after(count + 1).unwrap();
            let units = rounded.vertices.iter().flatten().map(|x| x / grid_m);
            assert!(
                units
                    .into_iter()
                    .all(|units| (units - units.round()).abs() < 1e-6)
            );
            let far = rounded.vertices.iter().map(|vertex| {
                let known = points
                    .iter()
                    .map(|point| (from_vector(*point) - vertex).norm());
                known.fold(f64::INFINITY, f64::min)
            });
            assert!(far.into_iter().all(|far| far <= grid_m));
        }
        assert_eq!(after(ROUNDINGS_M.len() + 1), None);
    }

    #[test]
    fn a_kept_cut_is_the_one_that_was_made() {
        let folder = tempfile::tempdir().unwrap();
        let kept = Cache {
            folder: Some(folder.path().to_path_buf()),
            ..Cache::of_user()
        };
        let none = Cache {
            folder: None,
            ..Cache::of_user()
        };
        let cuts = Cell::new(0);
        let mesh = corner();
        let solid = |cache: &Cache| {
            let announced = || cuts.set(cuts.get() + 1);
            Solid::kept_in(cache, &mesh, Build::Pieces, &announced)
        };
        let without = solid(&none);
        assert!(without.pieces().len() > 1);
        let same = |solid: &Solid| {
            // Bit by bit, as encoded numbers.
            let bytes = |solid: &Solid| encode(&solid.pieces, &solid.fit);
            assert!(bytes(solid) == bytes(&without));
            assert_eq!(solid.unit, without.unit);
        };
        same(&solid(&kept));
        assert_eq!(cuts.get(), 2);
        same(&solid(&kept));
        assert_eq!(cuts.get(), 2, "the second time it is read");

        // Sound as a file of the cache, but not a cut.
        let key = key(&mesh);
        let content = kept.find(Kind::Pieces, key).unwrap();
        kept.keep(Kind::Pieces, key, &content[..content.len() - 1]);
        same(&solid(&kept));
        assert_eq!(cuts.get(), 3);
        assert_eq!(kept.find(Kind::Pieces, key).unwrap(), content);
    }

    #[test]
    fn another_grid_replaces_one_that_panics() {
        let mesh = corner();
        let vertices: Vec<_> = mesh.vertices().iter().map(vector).collect();
        let cut = |grid| {
            assert!(grid < RESOLUTION, "as the library does");
            decomposed(&mesh, &vertices, grid)
        };
        let pieces = first_cut([RESOLUTION, OTHER_RESOLUTIONS[0]], cut).unwrap();
        let fit = fit(&mesh, &pieces, &shapes(&pieces));
        assert!(fit.filled_m < 1e-3 && fit.cut_m < 1e-3, "{fit:?}");
        assert_eq!(first_cut([RESOLUTION], cut), None);
    }

    #[test]
    fn other_numbers_are_no_cut() {
        let piece = hull(
            &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|[x, y, z]| rapier3d_f64::math::Vector::new(x, y, z)),
        )
        .unwrap();
        let fit = Fit {
            pieces: 1,
            volume_error: 0.1,
            filled_m: 0.2,
            cut_m: 0.3,
        };
        let content = encode(std::slice::from_ref(&piece), &fit);
        assert_eq!(decode(&content), Some((vec![piece], fit)));
        for length in 0..content.len() {
            assert_eq!(decode(&content[..length]), None, "{length} bytes");
        }
        let mut beyond = content.clone();
        let last = beyond.len() - 4;
        beyond[last..].copy_from_slice(&4_u32.to_le_bytes());
        assert_eq!(decode(&beyond), None, "a corner that is not there");
        assert_eq!(decode(&encode(&[], &fit)), None);
    }
}
