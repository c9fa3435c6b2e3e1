//! Fingers do not pass through each other.

use nalgebra::Vector3;

use super::{Forces, Scene, Term, rounded_hinge};
use crate::grasp::hand::Capsule;

/// Overlap of the hand's capsules.
///
/// ```text
/// E = w Σ_{pairs} h(r₁ + r₂ − dist(axis₁, axis₂)) / unit
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfPenetration {
    /// Weight w per unit length.
    pub weight: f64,
    /// Rounding of the hinge, metres.
    pub rounding_m: f64,
}

/// Nearest points of two segments.
fn nearest(a: &[Vector3<f64>; 2], b: &[Vector3<f64>; 2]) -> (Vector3<f64>, Vector3<f64>) {
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (uu, uv, vv) = (u.norm_squared(), u.dot(&v), v.norm_squared());
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let determinant = uu * vv - uv * uv;
    // Parallel segments have a whole line of nearest pairs; the first end will do.
    let mut s = if determinant > 1e-12 * uu * vv {
        ((uv * vw - vv * uw) / determinant).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let mut t = if vv > 0.0 { (uv * s + vw) / vv } else { 0.0 };
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = if uu > 0.0 {
            ((uv * t - uw) / uu).clamp(0.0, 1.0)
        } else {
            0.0
        };
    }
    (a[0] + u * s, b[0] + v * t)
}

/// Calls `visit` with each overlapping pair: the capsules, the nearest points of their axes, and the depth.
pub(crate) fn for_each_overlap(
    scene: &Scene<'_>,
    mut visit: impl FnMut(&Capsule, &Capsule, &Vector3<f64>, &Vector3<f64>, f64),
) {
    for &[first, second] in &scene.hand.self_pairs {
        let (one, two) = (&scene.hand.capsules[first], &scene.hand.capsules[second]);
        let (a, b) = nearest(&scene.axes[first], &scene.axes[second]);
        let reach = one.radius_m + two.radius_m;
        let squared = (a - b).norm_squared();
        if squared < reach * reach {
            visit(one, two, &a, &b, reach - squared.sqrt());
        }
    }
}

impl Term for SelfPenetration {
    fn name(&self) -> &'static str {
        "self_penetration"
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let scale = self.weight / scene.unit_m;
        let mut energy = 0.0;
        for_each_overlap(scene, |one, two, a, b, depth| {
            let (value, slope) = rounded_hinge(depth, self.rounding_m);
            energy += scale * value;
            let apart = a - b;
            let length = apart.norm();
            if length > 0.0 {
                let force = apart * (scale * slope / length);
                forces.push(one.link, a, &-force);
                forces.push(two.link, b, &force);
            }
        });
        energy
    }
}
