//! Where a hand touches the object in a pose, for marks, friction cones and the density painted on the object.

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::pack::Pack;
use crate::grasp::closure::{EpsilonSettings, epsilon};
use crate::grasp::filter::STRICT_FRICTION;
use crate::grasp::{Grasp, GraspEnergy, measure_contacts};
use crate::hand::PosedHand;

/// Spheres that carry less than this, of at most 1, are not shown.
const LEAST_LOAD: f64 = 0.05;

/// A place where the hand touches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    /// On the object, object frame, metres.
    point: Vector3<f64>,
    /// Inward unit normal of the object.
    inward: Vector3<f64>,
    /// How much it carries, 0 to 1.
    load: f64,
}

/// The Ferrari–Canny ε of a contact set, as `grasps.parquet` has it.
pub(super) fn epsilon_of(energy: &GraspEnergy, grasp: &Grasp) -> f64 {
    let measured = measure_contacts(energy, grasp);
    let contacts: Vec<_> = measured.iter().map(|measured| measured.contact).collect();
    let settings = EpsilonSettings {
        friction: STRICT_FRICTION,
        ..EpsilonSettings::default()
    };
    epsilon(&contacts, &settings).value
}

/// At most `most` places where the hand touches, the strongest ones: spheres of the elastic layer that carry.
pub(super) fn touches(energy: &GraspEnergy, grasp: &Grasp, most: usize) -> Vec<Touch> {
    let mut posed = PosedHand::default();
    energy.hand().pose(&grasp.pose, &mut posed);
    let mut touches = of_layer(energy, &posed);
    touches.sort_by(|a, b| b.1.total_cmp(&a.1));
    touches.truncate(most);
    let exact = &energy.object().exact;
    let onto = |(point, load): (Vector3<f64>, f64)| {
        let nearest = exact.nearest(&point);
        let (point, inward) = (nearest.point, -nearest.normal);
        Touch {
            point,
            inward,
            load,
        }
    };
    touches.into_iter().map(onto).collect()
}

fn of_layer(energy: &GraspEnergy, posed: &PosedHand) -> Vec<(Vector3<f64>, f64)> {
    let (layer, object) = (energy.layer(), energy.object());
    let settings = energy.settings().layer;
    let near = layer.near(posed, object.shape.as_ref(), settings.carrying_m());
    let carrying = near.iter().filter_map(|found| {
        let sphere = &layer.spheres[found.sphere as usize];
        let load = sphere.share * settings.carries(found.gap_m).0;
        let normal = found.gradient.try_normalize(0.0)?;
        let carries = sphere.may_touch && load >= LEAST_LOAD;
        carries.then(|| (found.centre - normal * sphere.radius_m, load.min(1.0)))
    });
    carrying.collect()
}

/// The places of all poses, one after the other.
pub(super) fn packed(poses: &[Vec<Touch>], pack: &mut Pack) -> Value {
    let values: Vec<f64> = (poses.iter().flatten())
        .flat_map(
            |Touch {
                 point,
                 inward,
                 load,
             }| {
                [
                    point.x, point.y, point.z, inward.x, inward.y, inward.z, *load,
                ]
            },
        )
        .collect();
    json!({
        "count": pack.bytes(poses.iter().map(|touches| u8::try_from(touches.len()).unwrap_or(u8::MAX))),
        "touch": pack.table(7, &values),
    })
}
