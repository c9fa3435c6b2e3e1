//! Objects to be grasped: signed-distance shapes, meshes, and [`Object`], which has both.

use std::path::PathBuf;

use nalgebra::{Matrix3, Vector3};

use crate::limits::{Beyond, Limit};
use crate::mesh::MeshError;

mod assembly;
mod cache;
mod capsule;
mod cuboid;
mod cylinder;
mod description;
mod direction;
mod field;
mod jet;
mod named;
#[cfg(feature = "neural")]
pub mod neural;
mod revolved;
mod sphere;
mod spline;
mod symmetric;
mod tessellate;

pub use assembly::Assembly;
pub use capsule::Capsule;
pub use cuboid::Cuboid;
pub use cylinder::Cylinder;
pub use description::{Description, Object, ObjectParts, Primitive};
pub use field::{Field, FieldReport, FieldSettings};
pub use named::OBJECT_NAMES;
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

/// Reasons why an object cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages show the fields")]
pub enum ObjectError {
    /// The mesh is not valid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    /// A TOML file does not describe shapes.
    #[error("{name}")]
    Shapes {
        name: String,
        source: toml::de::Error,
    },
    /// A description is invalid.
    #[error("the description of {name} is invalid: {source}")]
    Description {
        name: String,
        source: serde_json::Error,
    },
    /// A description states an impossible value.
    #[error("the description of {name} has an invalid {field}: {problem}")]
    Value {
        name: String,
        field: &'static str,
        problem: &'static str,
    },
    /// A number is beyond its plausible limit.
    #[error("{name}: {field} = {beyond}")]
    Beyond {
        name: String,
        field: &'static str,
        beyond: Beyond,
    },
    /// A declared symmetry or primitive does not fit the mesh.
    #[error(
        "{name} is declared {what}, but its surface deviates by {:.2} mm (at most {:.2} mm is accepted)",
        1e3 * deviation_m, 1e3 * tolerance_m
    )]
    Deviation {
        name: String,
        what: &'static str,
        /// Largest deviation, metres.
        deviation_m: f64,
        /// Largest accepted deviation, metres.
        tolerance_m: f64,
    },
    /// No built-in object has this name.
    #[error("no object is called {name}: the known objects are {known}")]
    Unknown { name: String, known: String },
}
