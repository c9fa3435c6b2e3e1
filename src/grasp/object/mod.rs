//! What is grasped: shapes as signed distances, meshes, and the [`Object`] that carries both.

use nalgebra::{Matrix3, Vector3};

/// A solid, as its signed distance: metres, negative inside, in the object frame, defined everywhere.
pub trait Shape: std::fmt::Debug + Send + Sync {
    /// Signed distance at `point`, metres.
    fn distance(&self, point: &Vector3<f64>) -> f64;

    /// Signed distance and its gradient (the outward normal; of unit length up to the accuracy of the shape).
    fn gradient(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>);

    /// Signed distance, gradient and Hessian (1/m).
    fn hessian(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>);

    /// Largest factor by which `distance` may change faster than the distance moved (1 for an exact distance).
    fn lipschitz(&self) -> f64 {
        1.0
    }
}
