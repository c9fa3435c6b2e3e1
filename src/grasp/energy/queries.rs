//! Queries about one pose for filters, pictures and reports.

use nalgebra::Vector3;

use super::GraspEnergy;
use crate::grasp::closure::PointContact;
use crate::grasp::depth::deepest_m;
use crate::grasp::layer::{LayerSettings, LoadCompliance};
use crate::grasp::term::{LayerCompliance, point_contact};
use crate::hand::PosedHand;

/// Depth above which the top of a path passes through the object, metres.
pub const THROUGH_M: f64 = 0.002;

impl GraspEnergy {
    /// The best contact set at pose `x`, as indices of surface points: the active piece of an energy of contact sets. For the
    /// energy of an elastic layer, the set that an energy of contact sets with the same settings would have if only points
    /// within 2 mm of the object could be contacts; of all points if these are too few. Without this limit a hand whose
    /// fingertips have few points would get contacts where it does not touch, since these balance better.
    pub fn contacts(&self, x: &[f64]) -> Vec<u32> {
        #[expect(
            clippy::redundant_closure_for_method_calls,
            reason = "the method alone is not general in its lifetimes"
        )]
        self.at(x, |evaluation| evaluation.best_choice())
    }

    /// The contacts of `choice` at pose `x` in the form of the force-closure tests, with arms divided by the unit.
    pub fn point_contacts(&self, x: &[f64], choice: &[u32]) -> Vec<PointContact> {
        self.at(x, |evaluation| {
            evaluation.measure_contacts(choice);
            let contacts = evaluation.memory.contacts.iter();
            contacts
                .map(|c| point_contact(c, &self.object.centroid, self.unit_m))
                .collect()
        })
    }

    /// Mean compliance of the elastic layer at pose `x`, without its weight; `None` for an energy without a layer.
    pub fn compliance(&self, x: &[f64]) -> Option<f64> {
        let layer = self.settings.layer?;
        let term = LayerCompliance {
            settings: LayerSettings {
                compliance_weight: 1.0,
                ..layer
            },
        };
        Some(self.at(x, |evaluation| evaluation.term(&term)))
    }

    /// How much the elastic layer gives under single loads at pose `x`, as the strict filter judges it
    /// ([`LayerSettings::judging`]); `None` for an energy without a layer.
    pub fn load_compliance(&self, x: &[f64]) -> Option<LoadCompliance> {
        let term = LayerCompliance {
            settings: self.settings.layer?.judging(),
        };
        Some(self.at(x, |evaluation| evaluation.under_loads(&term)))
    }

    /// Whether the elastic layer gives little enough under single loads ([`LayerSettings::holds`]); `None` for an energy without
    /// a layer.
    pub fn withstands_loads(&self, x: &[f64]) -> Option<bool> {
        let found = self.load_compliance(x)?;
        let fingers = self.hand.digits.len().saturating_sub(1);
        Some(self.settings.layer?.holds(&found, fingers))
    }

    /// Greatest depth at pose `x` of hand or object in the other, metres; 0 without overlap ([`deepest_m`]).
    pub fn deepest_m(&self, x: &[f64]) -> f64 {
        let mut posed = PosedHand::default();
        self.hand.pose(x, &mut posed);
        deepest_m(&self.object.exact, &self.hand, &posed)
    }

    /// Least signed distance of the hand's surface points from the object at pose `x`, metres.
    pub fn clearance_m(&self, x: &[f64]) -> f64 {
        self.at(x, |evaluation| {
            let posed = &evaluation.memory.posed;
            let points =
                (0..self.hand.surface.len()).map(|index| self.hand.surface_point(posed, index));
            let distances = points.map(|p| self.object.shape.distance(&p));
            distances.fold(f64::INFINITY, f64::min)
        })
    }

    /// Mean of the contact points of `choice` at pose `x`, object frame, metres.
    pub fn contact_centre(&self, x: &[f64], choice: &[u32]) -> Vector3<f64> {
        self.at(x, |evaluation| {
            let posed = &evaluation.memory.posed;
            let points = choice
                .iter()
                .map(|&index| self.hand.surface_point(posed, index as usize));
            points.sum::<Vector3<f64>>() / choice.len().max(1) as f64
        })
    }
}
