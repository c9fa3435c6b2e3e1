//! The energy E(H, x, O) of a pose and a contact set.

use std::sync::Arc;

use super::term::{Contact, Forces, Scene};
use super::{PaperSettings, Reading};
use crate::energy::Energy;
use crate::grasp::energy::AUTHORS_UNIT_M;
use crate::grasp::filter::Scale;
use crate::grasp::{Grasp, Judgement, MeasuredContact};
use crate::hand::{Hand, PosedHand};
use crate::object::Object;
use crate::space::{PoseMetric, PoseSpace, Space, joints_of};

/// The energy of a hand and an object.
///
/// ```text
/// E(H, x, O) = FC(x, O) + E_pen(H, O) + E_prior(H)
/// FC = max(0, ε − λ_min(GGᵀ)) + ‖Gc‖ + Σᵢ |d(xᵢ)|
/// ```
///
/// Liu et al. (2021), Eqs. 7 to 10. [`Reading::Released`] has the forms of the authors' code.
#[derive(Debug)]
pub struct PaperEnergy {
    hand: Arc<Hand>,
    object: Arc<Object>,
    space: PoseSpace,
    metric: PoseMetric,
    settings: PaperSettings,
    unit_m: f64,
    candidates: Vec<u32>,
}

impl PaperEnergy {
    /// The energy of `hand` on `object`.
    ///
    /// # Panics
    /// If the hand has fewer candidates than contacts, or if its surface points depend on several links.
    pub fn new(hand: Arc<Hand>, object: Arc<Object>, settings: PaperSettings) -> Self {
        assert!(!hand.bends(), "a surface point belongs to one link");
        let candidates: Vec<u32> = (0u32..)
            .zip(&hand.surface)
            .filter(|(_, point)| {
                hand.may_touch(point) && (!settings.fingertips_only || hand.is_fingertip(point))
            })
            .map(|(index, _)| index)
            .collect();
        assert!(
            candidates.len() >= settings.contacts,
            "there are fewer candidates than contacts"
        );
        let metric = hand.pose_metric();
        Self {
            space: PoseSpace::new(metric.clone(), object.symmetry.clone()),
            metric,
            unit_m: match settings.reading {
                Reading::Printed => object.radius_m,
                Reading::Released => AUTHORS_UNIT_M,
            },
            candidates,
            settings,
            hand,
            object,
        }
    }

    /// The hand.
    pub fn hand(&self) -> &Arc<Hand> {
        &self.hand
    }

    /// The object.
    pub fn object(&self) -> &Arc<Object> {
        &self.object
    }

    /// The settings.
    pub fn settings(&self) -> &PaperSettings {
        &self.settings
    }

    /// The space of poses.
    pub fn space(&self) -> &PoseSpace {
        &self.space
    }

    /// Indices of the surface points that may be contacts.
    pub fn candidates(&self) -> &[u32] {
        &self.candidates
    }

    /// The energy at pose `x` with the contact set `contacts`; writes the derivative along each tangent into `gradient`.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn evaluate(&self, x: &[f64], contacts: &[u32], gradient: &mut [f64]) -> f64 {
        let mut posed = PosedHand::default();
        self.hand.pose_links(x, &mut posed);
        let mut forces = Forces::none(&self.hand);
        let parts = self.parts(x, &posed, contacts, &mut forces);
        let [penetration, prior, closure, rank, distance, alignment] = parts;
        self.hand.pull_back(
            &posed,
            &forces.wrenches,
            &forces.joints,
            &self.metric,
            gradient,
        );
        (penetration + prior) + (closure + rank + distance + alignment)
    }

    /// The terms: penetration, prior, force closure, rank, distance and alignment.
    fn parts(
        &self,
        x: &[f64],
        posed: &PosedHand,
        contacts: &[u32],
        forces: &mut Forces,
    ) -> [f64; 6] {
        let shape = &*self.object.shape;
        let contacts: Vec<Contact> = contacts
            .iter()
            .map(|&index| {
                let index = index as usize;
                let point = self.hand.surface_point(posed, index);
                let (distance_m, gradient, hessian) = shape.hessian(&point);
                Contact {
                    index,
                    link: self.hand.surface[index].link,
                    point,
                    distance_m,
                    gradient,
                    hessian,
                }
            })
            .collect();
        let inside = self
            .hand
            .surface
            .iter()
            .enumerate()
            .filter_map(|(index, at)| {
                let point = self.hand.surface_point(posed, index);
                if shape.distance(&point) >= 0.0 {
                    return None;
                }
                let (distance_m, gradient) = shape.gradient(&point);
                Some((at.link, point, distance_m, gradient))
            });
        let scene = Scene {
            reading: self.settings.reading,
            contacts: &contacts,
            centroid: self.object.centroid,
            unit_m: self.unit_m,
        };
        [
            scene.penetration(inside, forces),
            scene.prior(&self.hand.prior, joints_of(x), forces),
            scene.force_closure(forces),
            scene.rank(forces),
            scene.distance(forces),
            scene.alignment(&self.hand, posed, forces),
        ]
    }

    /// The energy as a function of the pose alone, with the contact set held.
    pub fn held<'a>(&'a self, contacts: &'a [u32]) -> Held<'a> {
        Held {
            energy: self,
            contacts,
        }
    }

    fn scale(&self) -> Scale<'_> {
        Scale {
            hand: &self.hand,
            object: &self.object,
            unit_m: self.unit_m,
        }
    }

    /// Judges a grasp on the exact mesh, without an elastic layer.
    ///
    /// # Panics
    /// If the grasp belongs to another hand.
    pub fn judge(&self, grasp: &Grasp) -> Judgement {
        self.scale().judge(grasp)
    }

    /// The contacts of a grasp on the exact mesh.
    ///
    /// # Panics
    /// If the grasp belongs to another hand.
    pub fn measure_contacts(&self, grasp: &Grasp) -> Vec<MeasuredContact> {
        self.scale().measure(grasp)
    }
}

/// The energy of a pose with a fixed contact set, which the refinement of the text minimises.
#[derive(Debug, Clone, Copy)]
pub struct Held<'a> {
    energy: &'a PaperEnergy,
    contacts: &'a [u32],
}

impl Energy for Held<'_> {
    fn space(&self) -> &dyn Space {
        &self.energy.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.energy.evaluate(x, self.contacts, gradient)
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::grasp::start::start_pose_facing;
    use crate::sample::{Task, stream};

    /// All terms together, with the curvature of the object that turns the normals, for text and code.
    #[test]
    fn gradients_are_central_differences() {
        let hand = Arc::new(Hand::human());
        for name in ["ball", "bottle_round"] {
            let object = Arc::new(Object::named(name).unwrap());
            for settings in [PaperSettings::printed(), PaperSettings::released()] {
                let energy = PaperEnergy::new(hand.clone(), object.clone(), settings);
                let mut rng = stream(1, Task::Start, 0);
                for sample in object.surface_samples.iter().take(6) {
                    let x = start_pose_facing(&hand, sample, &mut rng);
                    let mut contacts = Vec::new();
                    while contacts.len() < settings.contacts {
                        contacts
                            .push(energy.candidates[rng.random_range(0..energy.candidates.len())]);
                    }
                    compare(&energy, &x, &contacts);
                }
            }
        }
    }

    fn compare(energy: &PaperEnergy, x: &[f64], contacts: &[u32]) {
        let space = energy.space();
        let scales = space.step_scales();
        let mut gradient = vec![f64::NAN; space.tangents()];
        let mut unused = gradient.clone();
        let value = energy.evaluate(x, contacts, &mut gradient);
        let size = (gradient.iter()).fold(1.0 + value.abs(), |size, g| size.max(g.abs()));
        for k in 0..gradient.len() {
            let step = 1e-7 * scales[k];
            let mut at = |length: f64| {
                let mut tangent = vec![0.0; space.tangents()];
                tangent[k] = length;
                let mut moved = x.to_vec();
                space.exp(&mut moved, &tangent);
                energy.evaluate(&moved, contacts, &mut unused)
            };
            let estimate = (at(step) - at(-step)) / (2.0 * step);
            // Rounding is 1e-16 of the energy over the step. A point that enters the object within it adds less.
            let tolerance = 2e-4 * size / scales[k].min(1.0);
            assert!(
                (estimate - gradient[k]).abs() < tolerance,
                "{:?}: ∂E/∂τ_{k} = {}, difference {estimate}",
                energy.settings.reading,
                gradient[k]
            );
        }
    }
}
