//! Settings of the elastic layer.

use serde::{Deserialize, Serialize};

use super::compliance::LoadCompliance;
use crate::limits::{ENERGY_SETTING, LAYER_SETTING, Limit, PATCH_SPACING, SHARE, SKIN};

/// Settings of the energy of an elastic layer. A file sets those that `landscape config synth` prints. Lengths are those of a hand, in metres. The compliance of a hand that has let
/// go is its weight, by default 1; its reach, pose and limits come on top of that.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LayerSettings {
    /// Weight of the compliance under test loads.
    pub compliance_weight: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// Torque of the test loads relative to their force at the object's radius.
    pub torque_share: f64,
    /// Distance between the patches of a link over which the layer is averaged, metres.
    pub patch_spacing_m: f64,
    /// Greatest compliance under a force in any direction of a hand that holds, of 1 for a hand that has let go. The layer is
    /// then [`LayerSettings::judging`].
    pub most_force_compliance: f64,
    /// The same of the mean compliance under torques, for hands with more than two digits.
    pub most_torque_compliance: f64,
    /// Gap at which the layer begins to carry, and the gap (negative: the depth) at which it carries fully, metres.
    pub skin_m: [f64; 2],
    /// Fraction of the farther part of the layer, which draws a hand from outside.
    pub far_share: f64,
    /// Weight of a phalanx that is drawn to the object. A hand that has let go pays it for each phalanx.
    pub reach_weight: f64,
    /// Gap beyond which nothing is drawn, metres.
    pub reach_m: f64,
    /// Height of the hump before the reach that keeps resting digits off; none at 0 to 1. See [`Reach`](crate::grasp::term::Reach).
    pub reach_hump: f64,
    /// Weight of the depth of the layer in the object, 1/m.
    pub pressing_weight_per_m: f64,
}

impl Default for LayerSettings {
    fn default() -> Self {
        Self {
            compliance_weight: 1.0,
            friction: 0.25,
            torque_share: 0.1,
            patch_spacing_m: 0.025,
            most_force_compliance: 0.3,
            most_torque_compliance: 0.4,
            skin_m: [0.003, -0.001],
            far_share: 0.15,
            reach_weight: 0.0075,
            reach_m: 0.012,
            reach_hump: 40.0,
            pressing_weight_per_m: 30.0,
        }
    }
}

/// The quintic step: 1 beyond `high` toward `low`, 0 on the other side, with its derivative by `s`. C² everywhere.
pub(crate) fn step(s: f64, [zero, one]: [f64; 2]) -> (f64, f64) {
    let t = (s - zero) / (one - zero);
    if t <= 0.0 {
        return (0.0, 0.0);
    }
    if t >= 1.0 {
        return (1.0, 0.0);
    }
    let value = t * t * t * (10.0 - t * (15.0 - 6.0 * t));
    let slope = 30.0 * t * t * (1.0 - t) * (1.0 - t);
    (value, slope / (one - zero))
}

/// Gaps at which the farther part of the layer begins to carry and carries fully, metres. It begins at twice the gap of the
/// near part.
const FAR_SKIN_M: [f64; 2] = [0.006, -0.001];
/// Friction with which a hand is judged, as a share of that of the energy.
const JUDGING_FRICTION: f64 = 0.875;
/// Gap at which the near part of the layer begins to carry when a hand is judged, as a share of that of the energy.
const JUDGING_SKIN: f64 = 0.5;

impl LayerSettings {
    /// The layer with which the strict filter judges a hand: with less friction, without the farther part, and with half the
    /// gap of the near part, so that a part of the hand more than 1.5 mm off the object carries nothing. The energy needs a
    /// deep layer, which draws hands to the object, but a hand that holds by it alone holds nothing in a simulation of rigid
    /// bodies.
    #[must_use]
    pub fn judging(&self) -> Self {
        let [begins_m, ends_m] = self.skin_m;
        Self {
            friction: JUDGING_FRICTION * self.friction,
            skin_m: [
                (JUDGING_SKIN * begins_m).max(0.5 * (begins_m + ends_m)),
                ends_m,
            ],
            far_share: 0.0,
            ..*self
        }
    }

    /// Whether a hand with so many digits besides the palm holds if it gives so much. Torques do not count for two digits,
    /// since no pinch resists the torque about the line between its contacts.
    pub fn holds(&self, found: &LoadCompliance, digits: usize) -> bool {
        let turns = digits > 2 && found.torque > self.most_torque_compliance;
        found.force <= self.most_force_compliance && !turns
    }

    /// The numbers by name and their limits.
    pub(crate) fn values(&self) -> Vec<(&'static str, Limit, f64)> {
        let divisor = |name, value| (name, LAYER_SETTING, value);
        let weight = |name, value| (name, ENERGY_SETTING, value);
        vec![
            weight("layer.compliance_weight", self.compliance_weight),
            weight("layer.friction", self.friction),
            divisor("layer.torque_share", self.torque_share),
            ("layer.patch_spacing_m", PATCH_SPACING, self.patch_spacing_m),
            (
                "layer.most_force_compliance",
                SHARE,
                self.most_force_compliance,
            ),
            (
                "layer.most_torque_compliance",
                SHARE,
                self.most_torque_compliance,
            ),
            ("layer.skin_m[0]", SKIN, self.skin_m[0]),
            ("layer.skin_m[1]", SKIN, self.skin_m[1]),
            ("layer.far_share", SHARE, self.far_share),
            weight("layer.reach_weight", self.reach_weight),
            divisor("layer.reach_m", self.reach_m),
            weight("layer.reach_hump", self.reach_hump),
            weight("layer.pressing_weight_per_m", self.pressing_weight_per_m),
            divisor(
                "layer.skin_m[0] - skin_m[1]",
                self.skin_m[0] - self.skin_m[1],
            ),
        ]
    }

    /// Where the energy of [`Reach`](crate::grasp::term::Reach) is highest: u = (d/reach)² = (k + 3)/(4 k) for a hump k > 1,
    /// and 1 without a hump.
    fn peak(&self) -> f64 {
        let hump = self.reach_hump.max(1.0);
        (hump + 3.0) / (4.0 * hump)
    }

    /// Distance from the object of the parts that rest while a chain closes the digits of its grip, metres: half way from the
    /// peak of the hump to the end of the reach. Nearer parts would slide on to the object. Without a hump it is the reach.
    pub fn rest_clearance_m(&self) -> f64 {
        self.reach_m * f64::midpoint(self.peak().sqrt(), 1.0)
    }

    /// Height of the hump, which is what it costs to put a phalanx that rests beyond the reach on the object:
    /// w (1 − u)³ (k u − 1) at the peak. 0 without a hump.
    pub fn hump(&self) -> f64 {
        let u = self.peak();
        self.reach_weight * (1.0 - u).powi(3) * (self.reach_hump * u - 1.0).max(0.0)
    }

    /// Greatest gap at which the layer carries or presses, metres.
    pub fn carrying_m(&self) -> f64 {
        self.skin_m[0].max(FAR_SKIN_M[0])
    }

    /// How much of the layer carries at this gap, from 0 to 1, and the derivative, 1/m.
    pub fn carries(&self, gap_m: f64) -> (f64, f64) {
        let (near, near_slope) = step(gap_m, self.skin_m);
        let (far, far_slope) = step(gap_m, FAR_SKIN_M);
        let share = self.far_share;
        (
            (1.0 - share) * near + share * far,
            (1.0 - share) * near_slope + share * far_slope,
        )
    }
}
