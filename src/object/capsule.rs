//! Capsules: all points within a radius of a segment.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::Shape;
use super::direction::{outward, radial_hessian};

/// A capsule: distance to the segment a–b, minus r.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Capsule {
    /// First end of the axis, metres.
    pub a: Vector3<f64>,
    /// Second end of the axis, metres.
    pub b: Vector3<f64>,
    /// Radius r, metres.
    pub radius_m: f64,
}

impl Capsule {
    /// Offset of `point` from the nearest point of the axis, and the projection onto the directions in which it changes.
    fn offset(&self, point: &Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
        let axis = self.b - self.a;
        let along = (point - self.a).dot(&axis);
        let squared = axis.norm_squared();
        if along <= 0.0 {
            (point - self.a, Matrix3::identity())
        } else if along >= squared {
            (point - self.b, Matrix3::identity())
        } else {
            let across = Matrix3::identity() - axis * axis.transpose() / squared;
            (point - self.a - axis * (along / squared), across)
        }
    }
}

impl Shape for Capsule {
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.offset(point).0.norm() - self.radius_m
    }

    fn gradient(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let (length, normal) = outward(&self.offset(point).0);
        (length - self.radius_m, normal)
    }

    fn hessian(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
        let (offset, across) = self.offset(point);
        let (length, normal) = outward(&offset);
        (
            length - self.radius_m,
            normal,
            radial_hessian(&across, &normal, length),
        )
    }
}
