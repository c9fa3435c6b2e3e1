//! Penetration of the object by the hand's surface points.

use super::{Forces, Scene, Stage, Term, rounded_hinge};

/// Depth of the hand's surface points in the object.
///
/// ```text
/// E = w Σ_{v ∈ S(H)} h(clearance − d(v)) / unit
/// ```
///
/// h is a hinge that is rounded over the first `rounding_m`. Liu et al. (2021), Eq. 9, has a plain hinge. A positive
/// clearance keeps the whole hand off the object, which measures the hovering cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandInObject {
    /// Weight w per unit length.
    pub weight: f64,
    /// Rounding of the hinge, metres.
    pub rounding_m: f64,
    /// Distance that every surface point must keep, metres.
    pub clearance_m: f64,
}

impl Term for HandInObject {
    fn name(&self) -> &'static str {
        "penetration"
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
        for near in scene.near {
            let depth = self.clearance_m - near.distance_m;
            if depth <= 0.0 {
                continue;
            }
            let (value, slope) = rounded_hinge(depth, self.rounding_m);
            energy += scale * value;
            let gradient =
                (near.gradient).unwrap_or_else(|| scene.object.shape.gradient(&near.point).1);
            let link = scene.hand.surface[near.index as usize].link;
            forces.push_surface(
                near.index,
                link,
                &near.point,
                &(gradient * (-scale * slope)),
            );
        }
        energy
    }
}
