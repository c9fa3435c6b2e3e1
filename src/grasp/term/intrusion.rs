//! Surface points of the object stay out of the hand.

use super::{Forces, Scene, Term, rounded_hinge};
use crate::grasp::hand::Capsule;
use nalgebra::Vector3;

/// Depth of the object's surface samples inside the hand's capsules.
///
/// ```text
/// E = w Σ_{s ∈ S(O)} Σ_{capsules} h(r − free − dist(s, axis)) / unit
/// ```
///
/// Depths up to `free` cost nothing: samples lie a centimetre apart, so what they feel at a shallow depth would depend on
/// where they happen to lie, and grasps that differ by a turn of a round object would differ in energy.
/// Catches what the hand's own points miss: a thin neck or an edge between two surface points. After the penetration
/// energy of Wang et al. (`DexGraspNet`, 2023), which also looks from the object into the hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrusion {
    /// Weight w per unit length.
    pub weight: f64,
    /// Depth that costs nothing, metres.
    pub free_m: f64,
    /// Rounding of the hinge, metres.
    pub rounding_m: f64,
}

/// How many of the object's samples are looked at: on a bottle about one per square centimetre.
const SAMPLES: usize = 384;

/// Calls `visit` with every capsule that may touch the object and each object sample inside it: capsule, sample, the
/// vector from the axis to the sample and the depth.
pub(crate) fn for_each_intruder(
    scene: &Scene<'_>,
    mut visit: impl FnMut(&Capsule, &Vector3<f64>, &Vector3<f64>, f64),
) {
    let lipschitz = scene.object.shape.lipschitz();
    let samples = &scene.object.surface_samples;
    let samples = &samples[..samples.len().min(SAMPLES)];
    for (capsule, &[a, b]) in scene.hand.capsules.iter().zip(&scene.posed.capsules) {
        let axis = b - a;
        let middle = a + axis * 0.5;
        let reach = 0.5 * axis.norm() + capsule.radius_m;
        if scene.object.shape.distance(&middle) > lipschitz * reach {
            continue;
        }
        let reach_squared = reach * reach;
        let radius_squared = capsule.radius_m * capsule.radius_m;
        let inverse = 1.0 / axis.norm_squared().max(f64::MIN_POSITIVE);
        for sample in samples {
            let sample = &sample.point;
            if (sample - middle).norm_squared() > reach_squared {
                continue;
            }
            let from_a = sample - a;
            let along = (from_a.dot(&axis) * inverse).clamp(0.0, 1.0);
            let offset = from_a - axis * along;
            let squared = offset.norm_squared();
            if squared < radius_squared {
                visit(capsule, sample, &offset, capsule.radius_m - squared.sqrt());
            }
        }
    }
}

impl Term for Intrusion {
    fn name(&self) -> &'static str {
        "intrusion"
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let scale = self.weight / scene.unit_m;
        let mut energy = 0.0;
        for_each_intruder(scene, |capsule, sample, offset, depth| {
            let (value, slope) = rounded_hinge(depth - self.free_m, self.rounding_m);
            energy += scale * value;
            let length = offset.norm();
            if length > 0.0 {
                // The axis moves toward the sample: depth grows.
                forces.push(capsule.link, sample, &(offset * (scale * slope / length)));
            }
        });
        energy
    }
}
