//! The object in the simulation: convex pieces, or the mesh itself.

use nalgebra::{Isometry3, Matrix3, Vector3};
use rapier3d_f64::geometry::SharedShape;
use rapier3d_f64::math::Pose;
use rapier3d_f64::parry::mass_properties::MassProperties;
use rapier3d_f64::parry::shape::TriMeshFlags;
use rapier3d_f64::parry::transformation::convex_hull;
use rapier3d_f64::parry::transformation::vhacd::{VHACD, VHACDParameters};
use serde::Serialize;

use super::convert::{from_vector, vector};
use super::inertia::uniform;
use crate::mesh::{ExactMesh, Mesh};

/// A mesh that its hull fills by no more than this, metres, is one convex piece. Cutting would leave gaps between the pieces
/// of a thin body.
const CONVEX_M: f64 = 1e-4;
/// Cells along the longest side of the grid in which a mesh is cut.
const RESOLUTION: u32 = 128;
/// A piece is cut again while the volume of its hull exceeds its own by this share of the volume of the whole hull.
const CONCAVITY: f64 = 0.002;
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
    /// The solid of a mesh: its hull if it is convex to 0.1 mm, otherwise convex pieces, which take seconds. Nothing is random.
    ///
    /// # Panics
    /// Never: a [`Mesh`] has triangles.
    pub fn new(mesh: &Mesh, build: Build) -> Self {
        let vertices: Vec<_> = mesh.vertices().iter().map(vector).collect();
        let unit = uniform(mesh);
        let centre = from_vector(unit.local_com);
        let reach_m = mesh
            .vertices()
            .iter()
            .map(|vertex| (vertex - centre).norm())
            .fold(0.0, f64::max);
        if build == Build::Triangles {
            let flags = TriMeshFlags::FIX_INTERNAL_EDGES;
            let shape = SharedShape::trimesh_with_flags(vertices, mesh.triangles().to_vec(), flags)
                .expect("a mesh has triangles");
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
            };
        }
        let whole = vec![hull(&vertices)];
        let one = shapes(&whole);
        let one_fit = fit(mesh, &whole, &one);
        let convex = !one.is_empty() && one_fit.filled_m <= CONVEX_M;
        let (pieces, shapes, fit) = if convex {
            (whole, one, one_fit)
        } else {
            let pieces = decomposed(mesh, &vertices);
            let shapes = shapes(&pieces);
            let fit = fit(mesh, &pieces, &shapes);
            (pieces, shapes, fit)
        };
        Self {
            exact: ExactMesh::new(mesh),
            shape: SharedShape::compound(shapes),
            unit,
            pieces,
            fit,
            reach_m,
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

    pub(super) fn of_mass(&self, mass_kg: f64) -> MassProperties {
        let mut properties = self.unit;
        properties.set_mass(mass_kg, true);
        properties
    }
}

/// Cuts a mesh into convex pieces.
fn decomposed(mesh: &Mesh, vertices: &[rapier3d_f64::math::Vector]) -> Vec<Piece> {
    let settings = VHACDParameters {
        resolution: RESOLUTION,
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
        .map(|points| hull(&points))
        .collect()
}

fn hull(points: &[rapier3d_f64::math::Vector]) -> Piece {
    let (vertices, triangles) = convex_hull(points);
    Piece {
        vertices: vertices.into_iter().map(from_vector).collect(),
        triangles,
    }
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
