//! Depth of the hand's elastic layer in the object.

use super::{Forces, Scene, Stage, Term};
use crate::grasp::layer::LayerSettings;

/// Depth that costs nothing, metres: what skin gives.
const FREE_M: f64 = 0.0003;
/// Rounding of the depth, metres. With 0.5 mm and a weight of 1000/m no descent converged.
const ROUNDING_M: f64 = 0.002;

/// The layer in the object.
///
/// ```text
/// E = w Σ_spheres share · h(depth − free)
/// ```
///
/// `free` is negative for parts that rest, which are kept off the object. h is a hinge that is rounded so that its second derivative is continuous. Depths up to `free` cost nothing: skin gives.
///
/// It is a penalty of our own on the elastic layer, linear where the energy of an elastic foundation (Johnson 1985, section
/// 4.3) would be quadratic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pressing {
    /// Settings of the layer.
    pub settings: LayerSettings,
}

/// max(0, s), rounded over `rounding` with a slope that is a smooth step, and its derivative.
pub(crate) fn smooth_hinge(s: f64, rounding: f64) -> (f64, f64) {
    if s <= 0.0 {
        return (0.0, 0.0);
    }
    let t = s / rounding;
    if t >= 1.0 {
        return (s - 0.5 * rounding, 1.0);
    }
    let square = t * t;
    (
        rounding * square * t * (1.0 - 0.5 * t),
        square * (3.0 - 2.0 * t),
    )
}

impl Term for Pressing {
    fn name(&self) -> &'static str {
        "pressing"
    }

    fn weight(&self) -> f64 {
        self.settings.pressing_weight_per_m
    }

    fn stage(&self) -> Stage {
        Stage::Depths
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let mut energy = 0.0;
        for near in scene.near_spheres {
            let sphere = &scene.layer.spheres[near.sphere as usize];
            let (free_m, share) = if sphere.rests {
                (-scene.layer.clearance_m, sphere.share)
            } else {
                (FREE_M, sphere.pressed_share)
            };
            let depth_m = -near.gap_m - free_m;
            if depth_m <= 0.0 {
                continue;
            }
            let (value, slope) = smooth_hinge(depth_m, ROUNDING_M);
            let scale = self.weight() * share;
            energy += scale * value;
            forces.push(
                sphere.link,
                &near.centre,
                &(near.gradient * (-scale * slope)),
            );
        }
        energy
    }
}
