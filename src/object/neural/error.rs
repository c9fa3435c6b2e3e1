//! Errors of neural networks.

use std::path::PathBuf;

use crate::limits::Beyond;
use crate::mesh::MeshError;

/// Reasons why a network cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages show the fields")]
pub enum NeuralError {
    /// A file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The file is a checkpoint of torch.
    #[error(
        "{} is a checkpoint of torch, which can run code when it is loaded: convert it to .safetensors \
         (docs/neural_objects.md has a script of ten lines)",
        .0.display()
    )]
    Checkpoint(PathBuf),
    /// A file is not in the safetensors format.
    #[error("{name} is not a valid .safetensors file: {source}")]
    Safetensors {
        name: String,
        source: safetensors::SafeTensorError,
    },
    /// The specs file is invalid.
    #[error("{name} is not a valid specs file: {source}")]
    Specs {
        name: String,
        source: serde_json::Error,
    },
    /// The specs describe something other than a `DeepSDF` decoder.
    #[error("{name} has an invalid {field}: {problem}")]
    Value {
        name: String,
        field: &'static str,
        problem: String,
    },
    /// A tensor is missing.
    #[error("{name} has no tensor {tensor}, which the specs ask for")]
    Missing { name: String, tensor: String },
    /// A tensor has another shape than in the specs.
    #[error("tensor {tensor} of {name} has shape {found:?}, but the specs ask for {expected:?}")]
    Shape {
        name: String,
        tensor: String,
        found: Vec<usize>,
        expected: Vec<usize>,
    },
    /// A tensor holds numbers of an unsupported type.
    #[error("tensor {tensor} of {name} contains {found} numbers: F32 or F64 is needed")]
    Kind {
        name: String,
        tensor: String,
        found: String,
    },
    /// A number is infinite or not a number.
    #[error("tensor {tensor} of {name} contains a number out of range: {beyond}")]
    Beyond {
        name: String,
        tensor: String,
        beyond: Beyond,
    },
    /// A row of normalised weights is zero and has no direction.
    #[error(
        "row {row} of tensor {tensor} of {name} is zero: weight normalisation divides by its length"
    )]
    NoDirection {
        name: String,
        tensor: String,
        /// The row, from zero.
        row: usize,
    },
    /// The file has no latent codes.
    #[error(
        "{0} has no tensor latent_codes (one row per shape): name the .safetensors file of the codes as well"
    )]
    NoCodes(String),
    /// There is no code with this index.
    #[error("latent code {index} does not exist: {name} has {count}, numbered from 0")]
    Code {
        name: String,
        index: usize,
        count: usize,
    },
    /// A code has the wrong length.
    #[error("the latent code has {found} numbers, but the specs say CodeLength {expected}")]
    CodeLength { found: usize, expected: usize },
    /// The scale is invalid.
    #[error("the scale, metres per unit of the network: {0}")]
    Scale(Beyond),
    /// The network is positive everywhere.
    #[error("{0} has no surface: the network is nowhere negative within its ball of radius 1")]
    NoSurface(String),
    /// The network is negative at the border.
    #[error(
        "{0} is not bounded: the network is negative outside its ball of radius 1; is it negative inside the shape, as \
         it should be?"
    )]
    Unbounded(String),
    /// The surface is not a valid mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}
