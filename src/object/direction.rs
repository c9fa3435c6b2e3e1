//! Derivatives of the distance to a point, line or plane, shared by all primitives.

use nalgebra::{Matrix3, Vector3};

/// Length and direction of `offset`. The direction of a zero offset (at the centre of a ball) is the first axis.
pub(super) fn outward(offset: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let length = offset.norm();
    if length > 0.0 {
        (length, offset / length)
    } else {
        (0.0, Vector3::x())
    }
}

/// Hessian (P − u uᵀ)/ℓ of the length ℓ of an offset under the projection `across` P, where u is its direction.
///
/// P is the identity for the distance to a point, and I − e eᵀ for a line along e. The result is zero at ℓ = 0, where no
/// Hessian exists.
pub(super) fn radial_hessian(
    across: &Matrix3<f64>,
    unit: &Vector3<f64>,
    length: f64,
) -> Matrix3<f64> {
    if length > 0.0 {
        (across - unit * unit.transpose()) / length
    } else {
        Matrix3::zeros()
    }
}
