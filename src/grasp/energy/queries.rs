//! Queries about one pose for filters, pictures and reports.

use nalgebra::Vector3;

use super::GraspEnergy;
use crate::grasp::contact::best_contacts;
use crate::grasp::depth::deepest_m;
use crate::grasp::layer::{LayerSettings, LoadCompliance};
use crate::grasp::term::LayerCompliance;
use crate::hand::PosedHand;

/// Depth above which the top of a path passes through the object, metres.
pub const THROUGH_M: f64 = 0.002;

impl GraspEnergy {
    /// The contact set at pose `x`, as indices of surface points ([`best_contacts`]). It is no part of the energy; filters
    /// and files name it.
    pub fn contacts(&self, x: &[f64]) -> Vec<u32> {
        self.at(x, |evaluation| {
            best_contacts(&self.hand, &self.object, &evaluation.memory.posed)
        })
    }

    /// Mean compliance of the elastic layer at pose `x`, without its weight.
    pub fn compliance(&self, x: &[f64]) -> f64 {
        let term = LayerCompliance {
            settings: LayerSettings {
                compliance_weight: 1.0,
                ..self.settings.layer
            },
        };
        self.at(x, |evaluation| evaluation.term(&term))
    }

    /// How much the elastic layer gives under single loads at pose `x`, as the strict filter judges it
    /// ([`LayerSettings::judging`]).
    pub fn load_compliance(&self, x: &[f64]) -> LoadCompliance {
        let term = LayerCompliance {
            settings: self.settings.layer.judging(),
        };
        self.at(x, |evaluation| evaluation.under_loads(&term))
    }

    /// Whether the elastic layer gives little enough under single loads ([`LayerSettings::holds`]).
    pub fn withstands_loads(&self, x: &[f64]) -> bool {
        let found = self.load_compliance(x);
        let fingers = self.hand.digits.len().saturating_sub(1);
        self.settings.layer.holds(&found, fingers)
    }

    /// Greatest depth at pose `x` of hand or object in the other, metres; 0 without overlap ([`deepest_m`]).
    pub fn deepest_m(&self, x: &[f64]) -> f64 {
        let mut posed = PosedHand::default();
        self.hand.pose(x, &mut posed);
        deepest_m(&self.object.exact, &self.hand, &posed)
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
