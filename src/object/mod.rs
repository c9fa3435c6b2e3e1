//! Objects to be grasped: signed-distance shapes, meshes, and [`Object`], which has both.

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

/// A solid given by its signed distance in metres: negative inside, in the object frame, defined everywhere.
///
/// All three functions return the same bits for the same quantity.
pub trait Shape: std::fmt::Debug + Send + Sync {
    /// Signed distance at `point`, metres.
    fn distance(&self, point: &Vector3<f64>) -> f64;

    /// Signed distance and its gradient, the outward normal. Its length is one up to the accuracy of the shape.
    fn gradient(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>);

    /// Signed distance, gradient and Hessian (1/m).
    fn hessian(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>);

    /// Lipschitz constant of `distance` outside the solid (1 for an exact distance).
    ///
    /// A point at distance d > 0 that moves by less than d/lipschitz stays outside.
    fn lipschitz(&self) -> f64 {
        1.0
    }
}

/// Refuses numbers beyond their limit. `name` is the object and `field` the place of the numbers in errors.
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

/// A length rounded to four digits, because single-precision files have more digits than are accurate.
fn rounded(length_m: f64) -> f64 {
    format!("{length_m:.3e}").parse().unwrap_or(length_m)
}

/// Reasons why an object cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjectError {
    /// A file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
    /// The ending of the file name is not that of a mesh format.
    #[error("{} is none of .obj, .stl, .ply, .gltf and .glb: convert the mesh to one of these", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
    },
    /// A TOML file does not describe shapes.
    #[error("{name}")]
    Shapes {
        /// The file.
        name: String,
        /// The error of the parser.
        source: toml::de::Error,
    },
    /// An OBJ, PLY or glTF file is invalid.
    #[error("{name} is not a valid {format} mesh: {problem}")]
    Format {
        /// The file.
        name: String,
        /// Name of the format.
        format: &'static str,
        /// The problem.
        problem: String,
    },
    /// A mesh has no triangles.
    #[error("{name} has no faces: a surface of triangles is needed")]
    NoTriangles {
        /// File or object.
        name: String,
    },
    /// A face refers to a vertex that does not exist.
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
        /// Size of the missing part, in brackets after a space; empty if unknown.
        missing: String,
    },
    /// Neighbouring triangles have opposite orientations.
    #[error(
        "{name} is inconsistently oriented at {edges} edges: recalculate its normals in a mesh editor"
    )]
    Orientation {
        /// File or object.
        name: String,
        /// Number of edges along which both triangles run in the same direction.
        edges: usize,
    },
    /// A surface crosses itself nearly everywhere.
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
    /// A mesh encloses no volume.
    #[error("{name} encloses no volume")]
    NoVolume {
        /// File or object.
        name: String,
    },
    /// The closed pieces intersect in too many places.
    #[error(
        "the pieces of {name} run through each other in millions of places: leave out copies in the same place, or unite them in a modelling program"
    )]
    Entangled {
        /// File or object.
        name: String,
    },
    /// The size cannot be metres.
    #[error(
        "{name} is {} m across: metres are expected; if it is in {unit}, scale it by {factor} (--scale {factor})",
        rounded(*size_m)
    )]
    Size {
        /// File or object.
        name: String,
        /// Longest edge of its bounding box, read as metres.
        size_m: f64,
        /// The likely unit.
        unit: &'static str,
        /// Factor from that unit to metres.
        factor: f64,
    },
    /// A description is invalid.
    #[error("the description of {name} is invalid: {source}")]
    Description {
        /// File or object.
        name: String,
        /// The error of the parser.
        source: serde_json::Error,
    },
    /// A description states an impossible value.
    #[error("the description of {name} has an invalid {field}: {problem}")]
    Value {
        /// File or object.
        name: String,
        /// The field with the value.
        field: &'static str,
        /// The problem.
        problem: &'static str,
    },
    /// A number is beyond its plausible limit.
    #[error("{name}: {field} = {beyond}")]
    Beyond {
        /// File or object.
        name: String,
        /// The field with the number.
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
        /// The claim in the description.
        what: &'static str,
        /// Largest deviation, metres.
        deviation_m: f64,
        /// Largest accepted deviation, metres.
        tolerance_m: f64,
    },
    /// No built-in object has this name.
    #[error("no object is called {name}: known are {known}")]
    Unknown {
        /// The requested name.
        name: String,
        /// All known names.
        known: String,
    },
}
