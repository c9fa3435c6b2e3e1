//! What a way between two grasps is: sliding, rolling, regrasping finger by finger, or letting go.

use std::fmt;

use nalgebra::Vector3;

use super::level::letting_go;
use crate::grasp::GraspEnergy;
use crate::grasp::layer::Layer;
use crate::hand::{Frame, PosedHand};
use crate::topography::Path;

/// A part of the hand (the palm or a digit) touches if its spheres carry at least this much together. One sphere that
/// carries fully counts 1; a fingertip that presses counts 3 or more.
const TOUCHES: f64 = 0.5;
/// A part that carries no more than this has lifted. Between both limits nothing changes.
const LIFTED: f64 = 0.05;
/// Contacts roll if the hand's surface moves over the object by less than this share of the way of the contacts.
const SLIPS: f64 = 0.5;

/// What happens to the contacts of a hand along a path between two grasps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// All contacts stay, and the hand slides over the object.
    Sliding,
    /// All contacts stay, and the hand rolls over the object.
    Rolling,
    /// Parts of the hand (digits, the palm) lift or land while others hold.
    Regrasping,
    /// At some point nothing touches, or the energy reaches the cost of letting go.
    LettingGo,
}

impl Way {
    /// The name in files and texts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sliding => "sliding",
            Self::Rolling => "rolling",
            Self::Regrasping => "regrasping",
            Self::LettingGo => "letting go",
        }
    }

    /// What a path is; `None` if the compliance has no weight, so that there is no cost of letting go.
    pub fn of(energy: &GraspEnergy, path: &Path) -> Option<Self> {
        let cost = letting_go(energy.settings())?;
        let at = |x: &Vec<f64>| Touch::at(energy, energy.layer(), x);
        let steps: Vec<Touch> = path.images.iter().map(at).collect();
        if path.images.is_empty() || path.height() >= cost {
            return Some(Self::LettingGo);
        }
        Some(Self::between(&steps))
    }

    fn between(steps: &[Touch]) -> Self {
        if steps.iter().any(Touch::nothing_touches) {
            return Self::LettingGo;
        }
        let parts = steps.first().map_or(0, |step| step.parts.len());
        let changes = |part: usize| {
            let loads = || steps.iter().map(|step| step.parts[part].load);
            loads().any(|load| load >= TOUCHES) && loads().any(|load| load <= LIFTED)
        };
        if (0..parts).any(changes) {
            return Self::Regrasping;
        }
        let [travel_m, slip_m] = travel_and_slip(steps);
        if slip_m < SLIPS * travel_m {
            Self::Rolling
        } else {
            Self::Sliding
        }
    }
}

/// How far the surface of the hand moves over the object along a path, at contacts that carry, summed over the palm and the
/// digits, metres: no slip if all contacts stick or roll.
pub(super) fn slip_m(energy: &GraspEnergy, points: &[&[f64]]) -> f64 {
    let at = |x: &&[f64]| Touch::at(energy, energy.layer(), x);
    let steps: Vec<Touch> = points.iter().map(at).collect();
    travel_and_slip(&steps)[1]
}

/// How far contacts move on the object, and how far the hand's surface moves over it there, metres.
fn travel_and_slip(steps: &[Touch]) -> [f64; 2] {
    let (mut travel_m, mut slip_m) = (0.0, 0.0);
    for pair in steps.windows(2) {
        for (before, after) in pair[0].parts.iter().zip(&pair[1].parts) {
            if before.load >= TOUCHES && after.load >= TOUCHES {
                travel_m += (after.on_object - before.on_object).norm();
                slip_m += after.moved_from(before).norm();
            }
        }
    }
    [travel_m, slip_m]
}

impl fmt::Display for Way {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// What touches in one pose.
struct Touch {
    /// The palm and the digits.
    parts: Vec<Part>,
}

/// How a part of the hand touches.
#[derive(Clone, Default)]
struct Part {
    load: f64,
    /// Mean place of its contact, object frame, metres.
    on_object: Vector3<f64>,
    /// Its spheres that carry.
    spheres: Vec<Carrying>,
}

/// A sphere that carries.
#[derive(Clone)]
struct Carrying {
    sphere: u32,
    /// Frame of its link.
    object_from_link: Frame,
    /// Its contact, object frame, metres.
    contact: Vector3<f64>,
    load: f64,
}

impl Part {
    /// The mean motion over the object of the points of the hand that were at the contacts before.
    fn moved_from(&self, before: &Self) -> Vector3<f64> {
        let (mut sum, mut total) = (Vector3::zeros(), 0.0);
        for here in &self.spheres {
            let same = |known: &&Carrying| known.sphere == here.sphere;
            if let Some(earlier) = before.spheres.iter().find(same) {
                let point = earlier.object_from_link.inverse_point(&earlier.contact);
                let weight = here.load.min(earlier.load);
                sum += (here.object_from_link.point(&point) - earlier.contact) * weight;
                total += weight;
            }
        }
        if total > 0.0 { sum / total } else { sum }
    }
}

impl Touch {
    fn at(energy: &GraspEnergy, layer: &Layer, x: &[f64]) -> Self {
        let settings = energy.settings().layer;
        let (hand, object) = (energy.hand(), energy.object());
        let mut posed = PosedHand::default();
        hand.pose(x, &mut posed);
        let near = layer.near(&posed, object.shape.as_ref(), settings.carrying_m());
        let mut parts = vec![Part::default(); hand.digits.len()];
        for found in near {
            let sphere = &layer.spheres[found.sphere as usize];
            let load = sphere.share * settings.carries(found.gap_m).0;
            // Where the distance has no slope, as on an axis, there is no contact, as in the energy.
            let normal = found.gradient.try_normalize(0.0);
            let Some(normal) = normal.filter(|_| sphere.may_touch && load > 0.0) else {
                continue;
            };
            let part = &mut parts[hand.links[sphere.link.0].digit];
            let contact = found.centre - normal * sphere.radius_m;
            part.load += load;
            part.on_object += contact * load;
            part.spheres.push(Carrying {
                sphere: found.sphere,
                object_from_link: posed.object_from_link[sphere.link.0],
                contact,
                load,
            });
        }
        for part in &mut parts {
            part.on_object /= part.load.max(f64::MIN_POSITIVE);
        }
        Self { parts }
    }

    fn nothing_touches(&self) -> bool {
        self.parts.iter().all(|part| part.load <= LIFTED)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    fn touch(loads: [f64; 2], place_m: f64, hand_m: f64) -> Touch {
        let part = |load: f64| Part {
            load,
            on_object: Vector3::x() * place_m,
            spheres: vec![Carrying {
                sphere: 0,
                object_from_link: Frame {
                    rotation: Matrix3::identity(),
                    translation: Vector3::x() * hand_m,
                },
                contact: Vector3::x() * place_m,
                load,
            }],
        };
        Touch {
            parts: loads.map(part).to_vec(),
        }
    }

    #[test]
    fn ways_are_told_by_what_touches() {
        let held = |place_m, hand_m| touch([1.0, 1.0], place_m, hand_m);
        let slid = [held(0.0, 0.0), held(0.01, 0.01)];
        assert_eq!(Way::between(&slid), Way::Sliding);
        let rolled = [held(0.0, 0.0), held(0.01, 0.001)];
        assert_eq!(Way::between(&rolled), Way::Rolling);
        // Two parts, each 1 mm.
        let [travel_m, slip_m] = travel_and_slip(&rolled);
        assert!((travel_m - 0.02).abs() < 1e-12 && (slip_m - 0.002).abs() < 1e-12);
        let lifted = [held(0.0, 0.0), touch([1.0, 0.0], 0.0, 0.0), held(0.0, 0.0)];
        assert_eq!(Way::between(&lifted), Way::Regrasping);
        let light = [held(0.0, 0.0), touch([1.0, 0.2], 0.01, 0.01)];
        assert_eq!(Way::between(&light), Way::Sliding, "it has not lifted");
        let gone = [held(0.0, 0.0), touch([0.0, 0.0], 0.0, 0.0)];
        assert_eq!(Way::between(&gone), Way::LettingGo);
        assert_eq!(Way::LettingGo.to_string(), "letting go");
    }
}
