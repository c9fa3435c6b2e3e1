//! Shapes given by neural networks: the decoder of `DeepSDF`.
//!
//! [`Tensors`] and [`Specs`] are the contents of files, and a [`Decoder`] combines them. A [`Network`] is a decoder for one
//! latent code, without a unit. A [`NeuralField`] is a network in metres and a [`Shape`](super::Shape). Its surface can be
//! meshed ([`NeuralField::surface`]), and the baked field of that mesh has the curvature that the network lacks.

mod decoder;
mod error;
mod field;
mod network;
mod specs;
mod surface;

pub use decoder::{Decoder, Tensor, Tensors};
pub use error::NeuralError;
pub use field::NeuralField;
pub use network::{Answer, Network, Real};
pub use specs::{NetworkSpecs, Specs};
pub use surface::{Surface, SurfaceSettings};
