//! Boxes with rounded edges.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::Shape;
use super::direction::radial_hessian;

/// A box along the axes of the object frame. Its edges and corners are rounded by balls of radius e.
///
/// ```text
/// d(p) = |max(q, 0)| + min(max qᵢ, 0) − e,   qᵢ = |pᵢ − cᵢ| − (hᵢ − e)
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cuboid {
    /// Centre c, metres.
    pub centre: Vector3<f64>,
    /// Half of the edge lengths h, metres, rounding included.
    pub half_extents: Vector3<f64>,
    /// Edge radius e, metres; at most the smallest half extent.
    #[serde(default)]
    pub edge_radius_m: f64,
}

impl Shape for Cuboid {
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.hessian(point).0
    }

    fn gradient(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let (distance, normal, _) = self.hessian(point);
        (distance, normal)
    }

    fn hessian(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
        let from_centre = point - self.centre;
        let sign = from_centre.map(|x| 1.0_f64.copysign(x));
        let past = from_centre.abs() - self.half_extents.add_scalar(-self.edge_radius_m);
        let outside = past.map(|q| q.max(0.0));
        let length = outside.norm();
        if length > 0.0 {
            let unit = outside / length;
            let active = Matrix3::from_diagonal(&past.map(|q| f64::from(u8::from(q > 0.0))));
            let normal = unit.component_mul(&sign);
            return (
                length - self.edge_radius_m,
                normal,
                radial_hessian(&active, &normal, length),
            );
        }
        let axis = past.imax();
        let mut normal = Vector3::zeros();
        normal[axis] = sign[axis];
        (past[axis] - self.edge_radius_m, normal, Matrix3::zeros())
    }
}
