//! Penetration of the hand by the object's surface points.

use super::{Forces, Scene, Stage, Term, rounded_hinge};
use crate::hand::Capsule;
use nalgebra::Vector3;

/// Depth of the object's surface samples in the hand's capsules.
///
/// ```text
/// E = w Σ_{s ∈ S(O)} Σ_{capsules} h(r − free − dist(s, axis)) / unit
/// ```
///
/// Depths up to `free` cost nothing. Samples are a centimetre apart, so shallow depths would depend on the positions of the
/// samples, and grasps that differ by a rotation of a round object would differ in energy. The term catches what the hand's
/// own points miss, such as a thin neck or an edge between two surface points. It follows the penetration energy of Wang et
/// al. (`DexGraspNet`, 2023), which also measures the object inside the hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectInHand {
    /// Weight w per unit length.
    pub weight: f64,
    /// Depth that costs nothing, metres.
    pub free_m: f64,
    /// Rounding of the hinge, metres.
    pub rounding_m: f64,
}

/// Calls `visit` with each capsule, each object sample inside it, the vector from the axis to the sample, and the depth.
fn for_each_intruder(
    scene: &Scene<'_>,
    mut visit: impl FnMut(&Capsule, &Vector3<f64>, &Vector3<f64>, f64),
) {
    let samples = &scene.object.surface_samples;
    let capsules = scene.hand.capsules.iter().zip(&scene.posed.capsules);
    for (number, (capsule, &[a, b])) in capsules.enumerate() {
        let near = scene.proximity.intruders(number);
        if near.is_empty() {
            continue;
        }
        let axis = b - a;
        let radius_squared = capsule.radius_m * capsule.radius_m;
        let inverse = 1.0 / axis.norm_squared().max(f64::MIN_POSITIVE);
        for &sample in near {
            let sample = &samples[sample as usize].point;
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

impl Term for ObjectInHand {
    fn name(&self) -> &'static str {
        "intrusion"
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
        for_each_intruder(scene, |capsule, sample, offset, depth| {
            let (value, slope) = rounded_hinge(depth - self.free_m, self.rounding_m);
            energy += scale * value;
            let length = offset.norm();
            if length > 0.0 {
                // If the axis moves toward the sample, the depth increases.
                forces.push(capsule.link, sample, &(offset * (scale * slope / length)));
            }
        });
        energy
    }
}
