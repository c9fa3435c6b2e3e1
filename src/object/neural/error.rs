//! What can be wrong with a network.

use std::path::PathBuf;

use crate::limits::Beyond;
use crate::object::ObjectError;

/// Why a network cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NeuralError {
    /// A file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A checkpoint of torch.
    #[error(
        "{} is a checkpoint of torch, which is a program in disguise: convert it to .safetensors (docs/neural_objects.md \
         has the ten lines)",
        path.display()
    )]
    Checkpoint {
        /// The file.
        path: PathBuf,
    },
    /// A file is not in the safetensors format.
    #[error("{name} is not a valid .safetensors file: {source}")]
    Safetensors {
        /// The file.
        name: String,
        /// What the reader says.
        source: safetensors::SafeTensorError,
    },
    /// Specs are not what they should be.
    #[error("{name} is not a valid specs file: {source}")]
    Specs {
        /// The file.
        name: String,
        /// What the reader says.
        source: serde_json::Error,
    },
    /// Specs describe something that is not a `DeepSDF` decoder.
    #[error("{name} has an invalid {field}: {problem}")]
    Value {
        /// The specs file.
        name: String,
        /// Where the value is.
        field: &'static str,
        /// What is wrong with it.
        problem: String,
    },
    /// A tensor is missing.
    #[error("{name} has no tensor {tensor}, which the specs ask for")]
    Missing {
        /// The file.
        name: String,
        /// The tensor.
        tensor: String,
    },
    /// A tensor has another shape than the specs say.
    #[error("tensor {tensor} of {name} has shape {found:?}, but the specs ask for {expected:?}")]
    Shape {
        /// The file.
        name: String,
        /// The tensor.
        tensor: String,
        /// Its shape.
        found: Vec<usize>,
        /// The shape that follows from the specs.
        expected: Vec<usize>,
    },
    /// A tensor holds numbers of a kind that is not read.
    #[error("tensor {tensor} of {name} holds {found} numbers: F32 or F64 is needed")]
    Kind {
        /// The file.
        name: String,
        /// The tensor.
        tensor: String,
        /// What it holds.
        found: String,
    },
    /// A number is infinite or not a number.
    #[error("tensor {tensor} of {name} holds the number {beyond}")]
    Beyond {
        /// The file.
        name: String,
        /// The tensor.
        tensor: String,
        /// The number and its limit.
        beyond: Beyond,
    },
    /// A row of a direction is zero, so that it has none.
    #[error(
        "row {row} of tensor {tensor} of {name} is zero: weight normalisation divides by its length"
    )]
    NoDirection {
        /// The file.
        name: String,
        /// The tensor.
        tensor: String,
        /// The row, from zero.
        row: usize,
    },
    /// A file without latent codes.
    #[error(
        "{name} has no tensor latent_codes (one row a shape): name the .safetensors file of the codes as well"
    )]
    NoCodes {
        /// The file.
        name: String,
    },
    /// There is no such code.
    #[error("there is no latent code {index}: {name} has {count}, numbered from 0")]
    Code {
        /// The file.
        name: String,
        /// What was asked for.
        index: usize,
        /// Number of codes.
        count: usize,
    },
    /// A code has the wrong length.
    #[error("the latent code has {found} numbers, but the specs say CodeLength {expected}")]
    CodeLength {
        /// Its length.
        found: usize,
        /// The length that the specs state.
        expected: usize,
    },
    /// A scale that is no length.
    #[error("the scale, metres per unit of the network: {0}")]
    Scale(Beyond),
    /// The function is positive everywhere.
    #[error("{name} has no surface: the network is nowhere negative within its ball of radius 1")]
    NoSurface {
        /// The shape.
        name: String,
    },
    /// The function is negative at the border.
    #[error(
        "{name} is not bounded: the network is negative outside its ball of radius 1; is it negative inside the shape, as \
         it should be?"
    )]
    Unbounded {
        /// The shape.
        name: String,
    },
    /// The surface is no valid mesh.
    #[error(transparent)]
    Mesh(#[from] ObjectError),
}
