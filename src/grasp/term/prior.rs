//! Natural hand poses.

use serde::{Deserialize, Serialize};

use super::{Forces, Scene, Term};

/// How the prior's quadratic form becomes an energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PriorForm {
    /// ½ zᵀΛz: the negative logarithm of the Gaussian.
    Quadratic,
    /// √(zᵀΛz): the norm of the whitened pose, as in Liu et al. (2021), Eq. 10.
    Norm,
}

/// Distance of the joint angles from the rest pose in the hand's Gaussian prior, z = θ − θ₀.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Weight.
    pub weight: f64,
    /// Which form.
    pub form: PriorForm,
}

impl Term for Prior {
    fn name(&self) -> &'static str {
        "prior"
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let prior = &scene.hand.prior;
        let k = prior.rest_rad.len();
        let row_product = |i: usize| {
            let row = &prior.precision[i * k..(i + 1) * k];
            row.iter()
                .zip(scene.joints_rad.iter().zip(&prior.rest_rad))
                .map(|(p, (q, rest))| p * (q - rest))
                .sum::<f64>()
        };
        let square: f64 = (0..k)
            .map(|i| (scene.joints_rad[i] - prior.rest_rad[i]) * row_product(i))
            .sum();
        let (value, slope) = match self.form {
            PriorForm::Quadratic => (0.5 * square, 1.0),
            PriorForm::Norm => {
                let norm = square.max(0.0).sqrt();
                (norm, if norm > 0.0 { 1.0 / norm } else { 0.0 })
            }
        };
        for (i, force) in forces.joints.iter_mut().enumerate().take(k) {
            *force += self.weight * slope * row_product(i);
        }
        self.weight * value
    }
}
