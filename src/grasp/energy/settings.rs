//! Settings of the grasp energy.

use serde::{Deserialize, Serialize};

use crate::grasp::layer::LayerSettings;
use crate::grasp::term::{
    JointLimits, LayerCompliance, Pressing, Prior, Reach, SelfPenetration, Term,
};
use crate::limits::{Beyond, ENERGY_SETTING};

/// Length unit of the authors of Liu et al. (2021), used in Eq. 11.
pub const AUTHORS_UNIT_M: f64 = 0.12;

/// Terms of the grasp energy with their weights: an elastic layer on the palmar side of the hand.
///
/// Its gradient is Lipschitz continuous where the second derivatives of the object's field are ([`LayerCompliance`],
/// [`SelfPenetration`]). Its minima are closed hands that hold. One unit of energy is the compliance of a hand that has let
/// go. Lengths of depths are in units of the object's radius. Experiment files change single values; see
/// `data/experiments/`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EnergySettings {
    /// The elastic layer of the hand.
    pub layer: LayerSettings,
    /// Weight of the hand's overlap with itself per unit length.
    pub self_penetration_weight: f64,
    /// Weight of joint excess per radian.
    pub joint_limits_weight: f64,
    /// Weight of the pose prior.
    pub prior_weight: f64,
}

impl Default for EnergySettings {
    fn default() -> Self {
        Self {
            layer: LayerSettings::default(),
            self_penetration_weight: 3.0,
            joint_limits_weight: 6.0,
            prior_weight: 0.006,
        }
    }
}

impl EnergySettings {
    /// Names of the terms with nonzero weight, in the order of [`GraspEnergy::term_names`](crate::grasp::GraspEnergy::term_names).
    pub fn term_names(&self) -> Vec<String> {
        let terms = self.terms();
        terms.iter().map(|term| term.name().to_owned()).collect()
    }

    /// The terms with nonzero weight, in the order of their [`Stage`](crate::grasp::term::Stage).
    pub(super) fn terms(&self) -> Vec<Box<dyn Term>> {
        let settings = self.layer;
        let mut terms: Vec<Box<dyn Term>> = vec![
            Box::new(LayerCompliance { settings }),
            Box::new(Reach { settings }),
            Box::new(Pressing { settings }),
            Box::new(SelfPenetration {
                weight: self.self_penetration_weight,
            }),
            Box::new(JointLimits {
                weight: self.joint_limits_weight,
            }),
            Box::new(Prior {
                weight: self.prior_weight,
            }),
        ];
        terms.retain(|term| term.weight() > 0.0);
        terms
    }

    /// Describes the first invalid value in one sentence.
    ///
    /// # Errors
    /// If a weight or length is negative, not finite or too large.
    pub fn validate(&self) -> Result<(), EnergySettingsError> {
        let values = [
            ("self_penetration_weight", self.self_penetration_weight),
            ("joint_limits_weight", self.joint_limits_weight),
            ("prior_weight", self.prior_weight),
        ];
        let values = values.map(|(name, value)| (name, ENERGY_SETTING, value));
        let of_layer = self.layer.values();
        for (name, limit, value) in values.into_iter().chain(of_layer) {
            let told = |beyond| EnergySettingsError::Value { name, beyond };
            limit.check(value).map_err(told)?;
        }
        Ok(())
    }
}

/// An invalid setting of the energy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EnergySettingsError {
    /// The hand has fewer surface points that may touch than a contact set has members.
    #[error("only {found} surface points of the hand may be contacts, but {contacts} are needed")]
    Candidates {
        /// Number of candidates.
        found: usize,
        /// Required number of contacts.
        contacts: usize,
    },
    /// A value is negative, NaN or far too large.
    #[error("{name} = {beyond}")]
    Value {
        /// The setting.
        name: &'static str,
        /// Its value and its limit.
        beyond: Beyond,
    },
}
