//! Penetration of the hand by itself.

use nalgebra::Vector3;

use super::{Forces, Scene, Stage, Term, rounded_hinge};
use crate::hand::{Capsule, closest_points, rounded_closest_points};

/// Rounding of the hinge, metres: it makes the gradient Lipschitz continuous, and overlaps of some millimetres still cost.
const ROUNDING_M: f64 = 0.002;
/// Rounding ε of the nearest points, a share of the squared lengths of the axes. With a large one, parts of a hand would pass
/// through each other.
const NEAREST_ROUNDING: f64 = 0.01;

/// Overlap of the hand's capsules.
///
/// ```text
/// E = w Σ_{pairs} h((R² − D²) / 2R) / unit,    R = r₁ + r₂
/// D² = min over s, t of |p(s) − q(t)|² + ε (|u|² (s − ½)² + |v|² (t − ½)²)
/// ```
///
/// Where two axes are parallel their nearest points jump, where they cross the direction between these flips, and the
/// gradient of the depth r₁ + r₂ − dist(axis₁, axis₂) jumps with them. This measure of the overlap has nearest points that
/// are rounded ([`rounded_closest_points`]), so that its gradient is Lipschitz continuous. For capsules that just touch at
/// their middles it is that depth. Where the axes cross, it is half as large and does not push them apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfPenetration {
    /// Weight w per unit length.
    pub weight: f64,
}

/// Calls `visit` with each pair that may overlap: the capsules, and their axes at the pose.
fn for_each_pair<'a>(
    scene: &Scene<'a>,
    mut visit: impl FnMut([&'a Capsule; 2], [&'a [Vector3<f64>; 2]; 2]),
) {
    for &pair in scene.proximity.pairs() {
        let pair = scene.hand.self_pairs[pair as usize];
        visit(
            pair.map(|capsule| &scene.hand.capsules[capsule]),
            pair.map(|capsule| &scene.posed.capsules[capsule]),
        );
    }
}

/// Calls `visit` with the depth of each overlapping pair.
pub(crate) fn for_each_overlap(scene: &Scene<'_>, mut visit: impl FnMut(f64)) {
    for_each_pair(scene, |[one, two], [axis_one, axis_two]| {
        let squared = closest_points(axis_one, axis_two).offset.norm_squared();
        let reach = one.radius_m + two.radius_m;
        if squared < reach * reach {
            visit(reach - squared.sqrt());
        }
    });
}

impl Term for SelfPenetration {
    fn name(&self) -> &'static str {
        "self_penetration"
    }

    fn weight(&self) -> f64 {
        self.weight
    }

    fn stage(&self) -> Stage {
        Stage::Depths
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let scale = self.weight / scene.unit_m;
        let mut energy = 0.0;
        for_each_pair(scene, |[one, two], [axis_one, axis_two]| {
            let nearest = rounded_closest_points(axis_one, axis_two, NEAREST_ROUNDING);
            let [u, v] = [axis_one, axis_two].map(|axis| axis[1] - axis[0]);
            let [s, t] = [nearest.s - 0.5, nearest.t - 0.5];
            let off_middle = u.norm_squared() * s * s + v.norm_squared() * t * t;
            let squared = nearest.offset.norm_squared() + NEAREST_ROUNDING * off_middle;
            let reach = one.radius_m + two.radius_m;
            if squared < reach * reach {
                let overlap = (reach * reach - squared) / (2.0 * reach);
                let (value, slope) = rounded_hinge(overlap, ROUNDING_M);
                energy += scale * value;
                // s and t are at a minimum, so only the points themselves count.
                let force = nearest.offset * (scale * slope / reach);
                let a = axis_one[0] + u * nearest.s;
                forces.push(one.link, &a, &force);
                forces.push(two.link, &(a + nearest.offset), &-force);
            }
        });
        energy
    }
}
