//! What is grasped: shapes as signed distances, meshes, and the [`Object`] that carries both.

use std::path::PathBuf;

use nalgebra::{Matrix3, Vector3};

use crate::limits::{Beyond, Limit};

mod assembly;
mod cache;
mod capsule;
mod cuboid;
mod cylinder;
mod description;
mod direction;
mod exact;
mod field;
mod file;
mod jet;
mod mesh;
mod named;
#[cfg(feature = "neural")]
pub mod neural;
mod outer;
mod repair;
mod revolved;
mod sphere;
mod spline;
mod symmetric;
mod tessellate;
mod winding;

pub use assembly::Assembly;
pub use capsule::Capsule;
pub use cuboid::Cuboid;
pub use cylinder::Cylinder;
pub use description::{Description, Object, ObjectParts, Primitive};
pub use exact::{DEPTH_TOLERANCE_M, ExactMesh, Nearest, TriangleTree};
pub use field::{Field, FieldReport, FieldSettings};
pub use mesh::{Mesh, SurfaceSample};
pub use named::OBJECT_NAMES;
pub use repair::{Repair, Repaired};
pub use revolved::Revolved;
pub use sphere::Sphere;
pub use symmetric::{FoundSymmetry, find_symmetry};

/// A solid, as its signed distance: metres, negative inside, in the object frame, defined everywhere.
///
/// All three functions give the same bits for the same number, so that it does not matter which was asked.
pub trait Shape: std::fmt::Debug + Send + Sync {
    /// Signed distance at `point`, metres.
    fn distance(&self, point: &Vector3<f64>) -> f64;

    /// Signed distance and its gradient (the outward normal; of unit length up to the accuracy of the shape).
    fn gradient(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>);

    /// Signed distance, gradient and Hessian (1/m).
    fn hessian(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>);

    /// Largest factor by which `distance` changes faster than a point moves outside the solid (1 for an exact distance).
    ///
    /// A point at distance d > 0 that moves by less than d/lipschitz stays outside.
    fn lipschitz(&self) -> f64 {
        1.0
    }
}

/// Refuses numbers beyond their limit; `name` is what errors call the object, `field` where the numbers are.
fn within<'a>(
    limit: Limit,
    values: impl IntoIterator<Item = &'a f64>,
    (name, field): (&str, &'static str),
) -> Result<(), ObjectError> {
    let told = |beyond| ObjectError::Beyond {
        name: name.to_owned(),
        field,
        beyond,
    };
    (values.into_iter()).try_for_each(|value| limit.check(*value).map_err(told))
}

/// A length to four digits: single precision leaves more in a file than are true.
fn rounded(length_m: f64) -> f64 {
    format!("{length_m:.3e}").parse().unwrap_or(length_m)
}

/// Why an object cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjectError {
    /// A file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The name of a file ends otherwise than those of meshes.
    #[error("{} is none of .obj, .stl, .ply, .gltf and .glb: convert the mesh to one of these", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
    },
    /// A TOML file that does not describe shapes.
    #[error("{name}")]
    Shapes {
        /// The file.
        name: String,
        /// What the reader says.
        source: toml::de::Error,
    },
    /// An OBJ, PLY or glTF file that cannot be understood.
    #[error("{name} is not a valid {format} mesh: {problem}")]
    Format {
        /// The file.
        name: String,
        /// Name of the format.
        format: &'static str,
        /// What is wrong with it.
        problem: String,
    },
    /// A mesh without triangles.
    #[error("{name} has no faces: a surface of triangles is needed")]
    NoTriangles {
        /// File or object.
        name: String,
    },
    /// A face names a vertex that does not exist.
    #[error("{name} has a face with vertex index {index}, but only {count} vertices")]
    Index {
        /// File or object.
        name: String,
        /// The index, from zero.
        index: u32,
        /// Number of vertices.
        count: u32,
    },
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} of {name}: {beyond}")]
    Coordinate {
        /// File or object.
        name: String,
        /// Number of the vertex, from zero.
        vertex: usize,
        /// Its coordinate and the limit.
        beyond: Beyond,
    },
    /// The surface has holes.
    #[error(
        "{name} is not closed: {edges} edges border a hole, so it has no inside{missing}; close it in a mesh editor"
    )]
    Open {
        /// File or object.
        name: String,
        /// Edges used by an odd number of triangles.
        edges: usize,
        /// How much is missing, in brackets after a space; empty where that is unknown.
        missing: String,
    },
    /// Neighbouring triangles face opposite sides.
    #[error(
        "{name} is inconsistently oriented at {edges} edges: recalculate its normals in a mesh editor"
    )]
    Orientation {
        /// File or object.
        name: String,
        /// Edges whose two triangles run along them in the same direction.
        edges: usize,
    },
    /// A surface that crosses itself nearly everywhere.
    #[error(
        "{percent:.0} % of the surface of {name} has no inside or no outside next to it (winding number), so it bounds no \
         solid: remesh it"
    )]
    Sides {
        /// File or object.
        name: String,
        /// Share of the surface, percent.
        percent: f64,
    },
    /// A flat mesh.
    #[error("{name} encloses no volume")]
    NoVolume {
        /// File or object.
        name: String,
    },
    /// Its closed pieces meet in more places than can be cut.
    #[error(
        "the pieces of {name} run through each other in millions of places: leave out copies in the same place, or unite them in a modelling program"
    )]
    Entangled {
        /// File or object.
        name: String,
    },
    /// A size that cannot be metres.
    #[error(
        "{name} is {} m across: metres are expected; if it is in {unit}, scale it by {factor} (--scale {factor})",
        rounded(*size_m)
    )]
    Size {
        /// File or object.
        name: String,
        /// Longest edge of its bounding box if it were in metres.
        size_m: f64,
        /// The unit that it may be in.
        unit: &'static str,
        /// What to multiply its coordinates with then.
        factor: f64,
    },
    /// A description is not what it should be.
    #[error("the description of {name} is invalid: {source}")]
    Description {
        /// File or object.
        name: String,
        /// What the reader says.
        source: serde_json::Error,
    },
    /// A description states an impossible value.
    #[error("the description of {name} has an invalid {field}: {problem}")]
    Value {
        /// File or object.
        name: String,
        /// Where the value is.
        field: &'static str,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A number that nobody means.
    #[error("{name}: {field} = {beyond}")]
    Beyond {
        /// File or object.
        name: String,
        /// Where the number is.
        field: &'static str,
        /// The number and its limit.
        beyond: Beyond,
    },
    /// A declared symmetry or primitive does not fit the mesh.
    #[error(
        "{name} is declared {what}, but its surface deviates by {:.2} mm (at most {:.2} mm is accepted)",
        1e3 * deviation_m, 1e3 * tolerance_m
    )]
    Deviation {
        /// File or object.
        name: String,
        /// The claim.
        what: &'static str,
        /// Largest deviation, metres.
        deviation_m: f64,
        /// What would be accepted, metres.
        tolerance_m: f64,
    },
    /// No object of that name comes with this crate.
    #[error("no object is called {name}: known are {known}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// All known names.
        known: String,
    },
}
