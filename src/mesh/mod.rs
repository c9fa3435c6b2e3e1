//! Triangle meshes: reading, repairing and uniting them, and exact distances to them.
//!
//! A [`Mesh`] is closed and oriented; [`Mesh::repaired`] makes one of triangles that are not. [`ExactMesh`] answers queries
//! of distance and of the side on which a point lies, [`TriangleTree`] those to triangles that may be open.

use std::path::PathBuf;

use crate::limits::Beyond;

mod box_tree;
mod cells;
mod closed;
mod copies;
mod exact;
mod file;
mod mesh_union;
mod repair;
mod shell;
mod surface_sample;
#[cfg(test)]
pub(crate) mod testing;
mod winding;

pub use closed::Mesh;
#[cfg(feature = "neural")]
pub(crate) use exact::signed_volume;
pub use exact::{DEPTH_TOLERANCE_M, ExactMesh, Nearest, TriangleTree};
pub(crate) use file::of_obj;
pub(crate) use mesh_union::SignedDistance;
pub use repair::{Repair, Repaired};
pub use surface_sample::SurfaceSample;

/// A length rounded to four digits, because single-precision files have more digits than are accurate.
fn rounded(length_m: f64) -> f64 {
    format!("{length_m:.3e}").parse().unwrap_or(length_m)
}

/// Reasons why triangles do not make a mesh.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages show the fields")]
pub enum MeshError {
    /// A file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The ending of the file name is not that of a mesh format.
    #[error("{} is not a .obj, .stl, .ply, .gltf or .glb file: convert the mesh to one of these", .0.display())]
    Kind(PathBuf),
    /// An OBJ, PLY or glTF file is invalid.
    #[error("{name} is not a valid {format} mesh: {problem}")]
    Format {
        name: String,
        format: &'static str,
        problem: String,
    },
    /// Git LFS has not fetched a file.
    #[error("{0} is a Git LFS pointer, not the mesh: run `git lfs pull` in its folder")]
    Pointer(String),
    /// A mesh has no triangles.
    #[error("{0} has no faces: a surface of triangles is needed")]
    NoTriangles(String),
    /// A face refers to a vertex that does not exist.
    #[error("{name} has a face with vertex index {index}, but only {count} vertices")]
    Index {
        name: String,
        /// The index, from zero.
        index: u32,
        count: u32,
    },
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} of {name}: {beyond}")]
    Coordinate {
        name: String,
        /// Number of the vertex, from zero.
        vertex: usize,
        beyond: Beyond,
    },
    /// A coordinate is not a number, or infinite.
    #[error(
        "vertex {vertex} of {name} has the coordinate {value}: write a number there, or delete the vertex and its faces"
    )]
    NotANumber {
        name: String,
        /// Number of the vertex, from zero.
        vertex: usize,
        value: f64,
    },
    /// The surface has holes.
    #[error(
        "{name} is not closed: {edges} edges border a hole, so it has no inside{missing}; close it in a mesh editor, or make \
         its surface a wall 2 mm thick with --thickness 2"
    )]
    Open {
        name: String,
        /// Edges used by an odd number of triangles.
        edges: usize,
        /// Size of the missing part, in brackets after a space; empty if unknown.
        missing: String,
    },
    /// Parts of the surface are open.
    #[error(
        "{name} is partly open: {percent:.1} % of its surface encloses nothing; close or delete these faces in a mesh \
         editor, or make them walls 2 mm thick with --thickness 2"
    )]
    Sheets {
        name: String,
        /// Share of the surface in open parts, percent.
        percent: f64,
    },
    /// The surface is to become a wall, but encloses a volume already.
    #[error("{0} is closed, so it has no open surface to make a wall of: leave out --thickness")]
    Closed(String),
    /// Triangles lie on each other in a way that is not resolved.
    #[error(
        "{name} has faces that lie on each other but do not share their corners, at {edges} edges: delete doubled faces in a \
         mesh editor"
    )]
    Overlaid {
        name: String,
        /// Number of edges where the surface without copies is not closed.
        edges: usize,
    },
    /// Neighbouring triangles have opposite orientations.
    #[error(
        "{name} is inconsistently oriented at {edges} edges: recalculate its normals in a mesh editor"
    )]
    Orientation {
        name: String,
        /// Number of edges along which both triangles run in the same direction.
        edges: usize,
    },
    /// A surface crosses itself nearly everywhere.
    #[error(
        "{percent:.0} % of the surface of {name} has no inside or no outside next to it (winding number), so it does not bound \
         a solid: remesh it"
    )]
    Sides { name: String, percent: f64 },
    /// A mesh encloses no volume.
    #[error("{0} encloses no volume: its faces are a film; give it a volume in a mesh editor")]
    NoVolume(String),
    /// The closed pieces intersect in too many places.
    #[error(
        "the pieces of {0} intersect in millions of places: remove copies in the same place, or unite the \
         pieces in a modelling program"
    )]
    Entangled(String),
    /// A size beyond its limit.
    #[error("{name}: its longest side = {beyond}")]
    Longest { name: String, beyond: Beyond },
    /// The size cannot be metres.
    #[error(
        "{name} is {} m across: metres are expected; if it is in {unit}, scale it by {factor} (--scale {factor})",
        rounded(*size_m)
    )]
    Size {
        name: String,
        /// Longest edge of its bounding box, read as metres.
        size_m: f64,
        /// The likely unit.
        unit: &'static str,
        /// Factor from that unit to metres.
        factor: f64,
    },
}
