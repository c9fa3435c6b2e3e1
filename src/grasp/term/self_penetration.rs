//! Penetration of the hand by itself.

use nalgebra::Vector3;

use super::{Forces, Scene, Stage, Term, rounded_hinge};
use crate::hand::{Capsule, closest_points};

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

/// Calls `visit` with each overlapping pair: the capsules, the nearest points of their axes, and the depth.
pub(crate) fn for_each_overlap(
    scene: &Scene<'_>,
    mut visit: impl FnMut(&Capsule, &Capsule, &Vector3<f64>, &Vector3<f64>, f64),
) {
    for &pair in scene.proximity.pairs() {
        let [first, second] = scene.hand.self_pairs[pair as usize];
        let (one, two) = (&scene.hand.capsules[first], &scene.hand.capsules[second]);
        let (axis_one, axis_two) = (&scene.posed.capsules[first], &scene.posed.capsules[second]);
        let nearest = closest_points(axis_one, axis_two);
        let reach = one.radius_m + two.radius_m;
        let squared = nearest.offset.norm_squared();
        if squared < reach * reach {
            let a = axis_one[0] + (axis_one[1] - axis_one[0]) * nearest.s;
            visit(one, two, &a, &(a + nearest.offset), reach - squared.sqrt());
        }
    }
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
