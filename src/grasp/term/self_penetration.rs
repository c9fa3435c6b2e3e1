//! Penetration of the hand by itself.

use nalgebra::Vector3;

use super::{Forces, Scene, Stage, Term, rounded_hinge};
use crate::hand::{Capsule, closest_points, rounded_closest_points};

/// Overlap of the hand's capsules.
///
/// ```text
/// E = w Σ_{pairs} h(r₁ + r₂ − dist(axis₁, axis₂)) / unit
/// ```
///
/// Where two axes are parallel their nearest points jump, where they cross the direction between these flips, and the
/// gradient jumps with them. With a rounding ε > 0 of the nearest points ([`rounded_closest_points`]) another measure of the
/// overlap takes its place, whose gradient is Lipschitz continuous if the hinge is rounded, too. For capsules that just touch
/// at their middles the two are the same. Where the axes cross, the new one is half as large and no longer pushes them apart.
///
/// ```text
/// E = w Σ_{pairs} h((R² − D²) / 2R) / unit,    R = r₁ + r₂
/// D² = min over s, t of |p(s) − q(t)|² + ε (|u|² (s − ½)² + |v|² (t − ½)²)
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfPenetration {
    /// Weight w per unit length.
    pub weight: f64,
    /// Rounding of the hinge, metres.
    pub rounding_m: f64,
    /// Rounding ε of the nearest points, a share of the squared lengths of the axes; 0 for none.
    pub nearest_points_rounding: f64,
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

/// Calls `visit` with each overlapping pair: the capsules, the nearest points of their axes, and the depth.
pub(crate) fn for_each_overlap(
    scene: &Scene<'_>,
    mut visit: impl FnMut(&Capsule, &Capsule, &Vector3<f64>, &Vector3<f64>, f64),
) {
    for_each_pair(scene, |[one, two], [axis_one, axis_two]| {
        let nearest = closest_points(axis_one, axis_two);
        let reach = one.radius_m + two.radius_m;
        let squared = nearest.offset.norm_squared();
        if squared < reach * reach {
            let a = axis_one[0] + (axis_one[1] - axis_one[0]) * nearest.s;
            visit(one, two, &a, &(a + nearest.offset), reach - squared.sqrt());
        }
    });
}

impl SelfPenetration {
    /// The sum with exact nearest points.
    fn add_exact(&self, scale: f64, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
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

    /// The sum with rounded nearest points.
    fn add_rounded(&self, scale: f64, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let rounding = self.nearest_points_rounding;
        let mut energy = 0.0;
        for_each_pair(scene, |[one, two], [axis_one, axis_two]| {
            let nearest = rounded_closest_points(axis_one, axis_two, rounding);
            let [u, v] = [axis_one, axis_two].map(|axis| axis[1] - axis[0]);
            let [s, t] = [nearest.s - 0.5, nearest.t - 0.5];
            let off_middle = u.norm_squared() * s * s + v.norm_squared() * t * t;
            let squared = nearest.offset.norm_squared() + rounding * off_middle;
            let reach = one.radius_m + two.radius_m;
            if squared < reach * reach {
                let overlap = (reach * reach - squared) / (2.0 * reach);
                let (value, slope) = rounded_hinge(overlap, self.rounding_m);
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
        if self.nearest_points_rounding > 0.0 {
            self.add_rounded(scale, scene, forces)
        } else {
            self.add_exact(scale, scene, forces)
        }
    }
}
