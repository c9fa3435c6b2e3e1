//! Detects when an object has come to rest.

use nalgebra::{Isometry3, Point3};

use super::settings::Rest;
use super::settings::count;
use super::solid::Solid;

/// Watches the poses of an object step by step. Speeds are no criterion, because a wedged object shivers in place.
pub(super) struct Watch<'a> {
    solid: &'a Solid,
    way_m: f64,
    /// Number of steps within `way_m` that count as rest.
    steps: usize,
    /// A reference pose; `near` counts the steps for which the object has stayed near it.
    anchor: Isometry3<f64>,
    near: usize,
}

impl<'a> Watch<'a> {
    pub(super) fn new(solid: &'a Solid, rest: &Rest, time_step_s: f64) -> Self {
        Self {
            solid,
            way_m: rest.way_m,
            steps: count(rest.time_s, time_step_s).max(1),
            anchor: Isometry3::identity(),
            near: 0,
        }
    }

    /// Whether the object, now at `pose`, is at rest.
    pub(super) fn rests(&mut self, pose: Isometry3<f64>) -> bool {
        let centre = Point3::from(self.solid.centre());
        let way_m = (pose * centre - self.anchor * centre).norm();
        let turn_rad = self.anchor.rotation.angle_to(&pose.rotation);
        if way_m + turn_rad * self.solid.reach_m() > self.way_m {
            self.anchor = pose;
            self.near = 0;
        } else {
            self.near += 1;
        }
        self.near >= self.steps
    }
}
