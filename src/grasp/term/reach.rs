//! Free digits that close.

use nalgebra::Vector3;

use super::{Forces, Scene, Stage, Term};
use crate::grasp::layer::LayerSettings;

/// Phalanges near the object are drawn to it.
///
/// ```text
/// E = w Σ_phalanges (1 − mean over points of (1 − u)³ (1 − k u)),    u = (d₊/reach)²
/// ```
///
/// d is the signed distance of points of the phalanx's palmar surface, and the sum is over all phalanges, so that E is 0 if
/// all touch. Beyond the reach nothing is drawn. For k > 1 there is a hump before that: phalanges below it are drawn to
/// the object, and those beyond it rest. With k = 40 the hump is at 0.52 of the reach and 3.8 w high. So a grasp of few digits and one of all are two
/// minima, with the lifting of a digit between them. A hand that has let go pays w for each phalanx. The form is our own and
/// has no physical meaning: it chooses among hands, and the compliance says how well they hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Settings of the layer.
    pub settings: LayerSettings,
}

impl Term for Reach {
    fn name(&self) -> &'static str {
        "reach"
    }

    fn weight(&self) -> f64 {
        self.settings.reach_weight
    }

    fn stage(&self) -> Stage {
        Stage::Depths
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let (weight, reach_m) = (self.weight(), self.settings.reach_m);
        let mut energy = 0.0;
        for phalanx in &scene.layer.phalanges {
            let frame = &scene.posed.object_from_link[phalanx.link.0];
            let share = weight / phalanx.points.len() as f64;
            for point in &phalanx.points {
                energy += share;
                let point = frame.point(point);
                let (distance_m, gradient): (f64, Vector3<f64>) =
                    scene.object.shape.gradient(&point);
                if distance_m >= reach_m {
                    continue;
                }
                let s = distance_m.max(0.0) / reach_m;
                let inner = 1.0 - s * s;
                let hump = 1.0 - self.settings.reach_hump * s * s;
                energy -= share * inner * inner * inner * hump;
                if s > 0.0 {
                    let falls = 3.0 * hump + self.settings.reach_hump * inner;
                    let slope = 2.0 * s * inner * inner * falls / reach_m;
                    forces.push(phalanx.link, &point, &(gradient * (share * slope)));
                }
            }
        }
        energy
    }
}
