//! Shapes as neural networks: the decoder of `DeepSDF`.
//!
//! [`Tensors`] and [`Specs`] are what files hold, a [`Decoder`] is the two together, a [`Network`] a decoder for one latent
//! code, without a unit; a [`NeuralField`] is a network in metres, a [`Shape`](super::Shape). Its surface can be taken as
//! a mesh ([`NeuralField::surface`]), whose baked field has the curvature that the network lacks.

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
