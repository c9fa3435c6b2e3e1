//! Capped cylinders with rounded rims.

use nalgebra::{Matrix3, Unit, Vector3};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use super::Shape;
use super::direction::{outward, radial_hessian};
use crate::limits::DIRECTION;

/// A capped cylinder about an axis through its centre. Its rims are rounded with radius e.
///
/// With ρ the distance from the axis and z the height above the centre,
///
/// ```text
/// d(p) = |max(q, 0)| + min(max(q₁, q₂), 0) − e,   q = (ρ − (r − e), |z| − (h − e))
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Centre, metres.
    pub centre: Vector3<f64>,
    /// Direction of the axis. In files it may have any length.
    #[serde(deserialize_with = "direction")]
    pub axis: Unit<Vector3<f64>>,
    /// Radius r, metres, rounding included.
    pub radius_m: f64,
    /// Half of the height h, metres, rounding included.
    pub half_height_m: f64,
    /// Rim radius e, metres; at most the radius and half of the height.
    #[serde(default)]
    pub edge_radius_m: f64,
}

/// Reads a direction of any nonzero length. A unit vector keeps every bit.
fn direction<'de, D: Deserializer<'de>>(reader: D) -> Result<Unit<Vector3<f64>>, D::Error> {
    /// Largest rounding error of the length of a unit vector.
    const ROUNDING: f64 = 1e-12;
    let axis = Vector3::deserialize(reader)?;
    let length = axis.norm();
    DIRECTION.check(length).map_err(D::Error::custom)?;
    Ok(if (length - 1.0).abs() < ROUNDING {
        Unit::new_unchecked(axis)
    } else {
        Unit::new_unchecked(axis / length)
    })
}

impl Shape for Cylinder {
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.hessian(point).0
    }

    fn gradient(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let (distance, normal, _) = self.hessian(point);
        (distance, normal)
    }

    fn hessian(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
        let axis = self.axis.into_inner();
        let from_centre = point - self.centre;
        let height = from_centre.dot(&axis);
        let up = axis * 1.0_f64.copysign(height);
        let (from_axis, radial) = outward(&(from_centre - axis * height));
        let past_side = from_axis - (self.radius_m - self.edge_radius_m);
        let past_cap = height.abs() - (self.half_height_m - self.edge_radius_m);

        // A step around the axis turns the radial part of the normal, at rate 1/ρ.
        let plane = Matrix3::identity() - axis * axis.transpose();
        let turning = radial_hessian(&plane, &radial, from_axis);
        if past_side > 0.0 && past_cap > 0.0 {
            let length = libm::hypot(past_side, past_cap);
            let normal = (radial * past_side + up * past_cap) / length;
            let meridian = axis * axis.transpose() + radial * radial.transpose();
            let hessian =
                radial_hessian(&meridian, &normal, length) + turning * (past_side / length);
            (length - self.edge_radius_m, normal, hessian)
        } else if past_side > past_cap {
            (past_side - self.edge_radius_m, radial, turning)
        } else {
            (past_cap - self.edge_radius_m, up, Matrix3::zeros())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files were read as they stood, and the formula then was of no cylinder.
    #[test]
    fn axes_of_any_length_are_read_as_directions() {
        let read = |axis: &str| {
            let text = format!(
                r#"{{"centre": [0, 0, 0], "axis": {axis}, "radius_m": 0.01, "half_height_m": 0.05}}"#
            );
            serde_json::from_str::<Cylinder>(&text).map_err(|error| error.to_string())
        };
        let axis = read("[0, 0, 2.5]").unwrap().axis;
        assert_eq!(axis.into_inner(), Vector3::z());
        let printed = [0.6, 0.0, 0.8];
        let kept = read("[0.6, 0, 0.8]").unwrap().axis.into_inner();
        assert_eq!(kept, Vector3::from(printed));
        for lost in ["[0, 0, 0]", "[0, 1e155, 0]", "[1e-300, 0, 0]"] {
            let error = read(lost).unwrap_err();
            assert!(error.contains("a direction of length one"), "{error}");
        }
    }
}
