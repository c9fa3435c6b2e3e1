//! A value with its first and second derivatives, and the blending of two of them.

use nalgebra::{Matrix3, Vector3};

/// Value, gradient and Hessian of a scalar field at a point. Derivatives that were not requested are zero.
#[derive(Debug, Clone, Copy)]
pub(super) struct Jet {
    pub(super) value: f64,
    pub(super) gradient: Vector3<f64>,
    pub(super) hessian: Matrix3<f64>,
}

impl Jet {
    /// `far + weight·(near − far)` and its derivatives.
    pub(super) fn blend(weight: &Self, near: &Self, far: &Self) -> Self {
        let gap = near.value - far.value;
        let gap_gradient = near.gradient - far.gradient;
        let cross = weight.gradient * gap_gradient.transpose();
        Self {
            value: far.value + weight.value * gap,
            gradient: far.gradient + gap_gradient * weight.value + weight.gradient * gap,
            hessian: far.hessian
                + (near.hessian - far.hessian) * weight.value
                + weight.hessian * gap
                + cross
                + cross.transpose(),
        }
    }
}
