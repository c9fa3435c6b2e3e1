//! The derivative of a distance to a point, line or plane: what all primitive shapes share.

use nalgebra::{Matrix3, Vector3};

/// Length of `offset` and its direction; the first axis where there is none (at the centre of a ball).
pub(super) fn outward(offset: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let length = offset.norm();
    if length > 0.0 {
        (length, offset / length)
    } else {
        (0.0, Vector3::x())
    }
}

/// Hessian (P − u uᵀ)/ℓ of the length ℓ of an offset seen through the projection `across` P, with u its direction.
///
/// P is the identity for the distance to a point, I − e eᵀ for a line along e. Zero where ℓ = 0, where none exists.
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
