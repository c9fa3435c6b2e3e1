//! Friction cones.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use crate::mesh::ExactMesh;

use super::Scene;

/// Opacity of a cone before a surface. `SHINING` is the opacity of a cone that a surface covers.
pub(super) const COVERING: f64 = 0.62;
pub(super) const SHINING: f64 = 0.42;

/// Number of side faces of a drawn cone.
const FACES: u32 = 48;

/// A translucent cone: the directions in which a contact can push without slipping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Tip, object frame, metres.
    pub tip: Vector3<f64>,
    /// Unit vector from the tip along the axis; the inward normal for a friction cone.
    pub axis: Vector3<f64>,
    /// Angle between axis and side, radians, below π/2.
    pub half_angle_rad: f64,
    /// Length of the side, metres.
    pub side_m: f64,
    /// Red, green, blue.
    pub colour: [u8; 3],
}

impl Cone {
    /// The cone of the forces that a contact at `tip` with inward unit normal `inward_normal` can exert at Coulomb
    /// friction `friction`: half-angle atan μ.
    pub fn of_friction(
        tip: Vector3<f64>,
        inward_normal: Vector3<f64>,
        friction: f64,
        side_m: f64,
        colour: [u8; 3],
    ) -> Self {
        Self {
            tip,
            axis: inward_normal,
            half_angle_rad: libm::atan(friction),
            side_m,
            colour,
        }
    }

    /// Middle and radius of the disk that closes the cone.
    pub(super) fn base(&self) -> (Vector3<f64>, f64) {
        let (sin, cos) = libm::sincos(self.half_angle_rad);
        (
            self.tip + self.axis * (self.side_m * cos),
            self.side_m * sin,
        )
    }

    /// Corners and outward normals of the drawn triangles: first the side, then the base.
    pub(super) fn triangles(&self) -> Vec<[[Vector3<f64>; 3]; 2]> {
        let (sin, cos) = libm::sincos(self.half_angle_rad);
        let (middle, radius) = self.base();
        let mut other = Vector3::zeros();
        other[self.axis.iamin()] = 1.0;
        let first = self.axis.cross(&other).normalize();
        let axes = Matrix3::from_columns(&[first, self.axis.cross(&first), self.axis]);
        let around = |step: f64| {
            let (y, x) = libm::sincos(TAU * step / f64::from(FACES));
            axes * Vector3::new(x, y, 0.0)
        };
        let normal = |step: f64| around(step) * cos - self.axis * sin;
        let side = (0..FACES).map(|face| {
            let (from, to) = (f64::from(face), f64::from(face + 1));
            [
                [
                    self.tip,
                    middle + around(from) * radius,
                    middle + around(to) * radius,
                ],
                [normal(from + 0.5), normal(from), normal(to)],
            ]
        });
        let base = (0..FACES).map(|face| {
            let (from, to) = (f64::from(face), f64::from(face + 1));
            [
                [
                    middle,
                    middle + around(from) * radius,
                    middle + around(to) * radius,
                ],
                [self.axis; 3],
            ]
        });
        side.chain(base).collect()
    }
}

impl Scene {
    /// Adds the friction cone of a contact at each marker, in the marker's colour. Its tip is the nearest point of
    /// `surface`, its axis is the inward normal there, its half-angle is atan `friction`, and its side has length `side_m`.
    /// A side of two or three centimetres looks good beside a hand.
    #[must_use]
    pub fn with_friction_cones(mut self, surface: &ExactMesh, friction: f64, side_m: f64) -> Self {
        self.cones.extend(self.markers.iter().map(|marker| {
            let nearest = surface.nearest(&marker.centre);
            Cone::of_friction(
                nearest.point,
                -nearest.normal,
                friction,
                side_m,
                marker.colour,
            )
        }));
        self
    }
}
