//! Balls.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::Shape;
use super::direction::{outward, radial_hessian};

/// A ball: distance |p − c| − r.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Centre c, metres.
    pub centre: Vector3<f64>,
    /// Radius r, metres.
    pub radius_m: f64,
}

impl Shape for Sphere {
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        (point - self.centre).norm() - self.radius_m
    }

    fn gradient(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let (length, normal) = outward(&(point - self.centre));
        (length - self.radius_m, normal)
    }

    fn hessian(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
        let (length, normal) = outward(&(point - self.centre));
        let hessian = radial_hessian(&Matrix3::identity(), &normal, length);
        (length - self.radius_m, normal, hessian)
    }
}
