//! Limits of the joints.

use super::{Forces, Scene, Stage, Term, rounded_hinge};

/// Excess of joint angles over their limits.
///
/// ```text
/// E = w Σⱼ h(θⱼ − upperⱼ + rounding) + h(lowerⱼ − θⱼ + rounding)
/// ```
///
/// Slides count as angles of a lever of 100 mm. The hinge is rounded *before* the limit, so minima lie within limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimits {
    /// Weight w per radian.
    pub weight: f64,
}

impl JointLimits {
    /// Rounding of the hinge, radians: about a degree, so that minima may come near a limit.
    pub const ROUNDING_RAD: f64 = 0.02;
}

impl Term for JointLimits {
    fn name(&self) -> &'static str {
        "joint_limits"
    }

    fn weight(&self) -> f64 {
        self.weight
    }

    fn stage(&self) -> Stage {
        Stage::Pose
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let mut energy = 0.0;
        let joints = scene.hand.joints.iter().zip(scene.joints);
        for ((joint, &angle), force) in joints.zip(&mut forces.joints) {
            let [lower, upper] = joint.limits;
            let scale = joint.kind.radians_per_unit();
            let (above, above_slope) = rounded_hinge(
                scale * (angle - upper) + Self::ROUNDING_RAD,
                Self::ROUNDING_RAD,
            );
            let (below, below_slope) = rounded_hinge(
                scale * (lower - angle) + Self::ROUNDING_RAD,
                Self::ROUNDING_RAD,
            );
            energy += self.weight * (above + below);
            *force += self.weight * scale * (above_slope - below_slope);
        }
        energy
    }
}
