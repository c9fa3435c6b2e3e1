//! Prior of natural hand poses.

use serde::{Deserialize, Serialize};

use super::{Forces, Scene, Stage, Term};
use crate::hand::PosePrior;

/// Form of the energy of the prior.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PriorForm {
    /// ½ zᵀΛz: the negative logarithm of the Gaussian.
    Quadratic,
    /// √(zᵀΛz): the norm of the whitened pose, as in Liu et al. (2021), Eq. 10.
    Norm,
    /// √Σ (zᵢ/σᵢ)² with the standard deviation σᵢ of each joint, as in their code, which has no synergies.
    StandardScores,
}

/// Distance of the joint angles from the rest pose in the hand's Gaussian prior, z = θ − θ₀.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Weight.
    pub weight: f64,
    /// Form of the energy.
    pub form: PriorForm,
}

impl Term for Prior {
    fn name(&self) -> &'static str {
        "prior"
    }

    fn weight(&self) -> f64 {
        self.weight
    }

    fn stage(&self) -> Stage {
        Stage::Pose
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        if self.form == PriorForm::StandardScores {
            return self.add_standard_scores(scene, forces);
        }
        let prior = &scene.hand.prior;
        let mut square = 0.0;
        for_each_product(prior, scene.joints_rad, |i, product| {
            square += (scene.joints_rad[i] - prior.rest_rad[i]) * product;
        });
        let (value, slope) = match self.form {
            PriorForm::Quadratic => (0.5 * square, 1.0),
            PriorForm::Norm | PriorForm::StandardScores => {
                let norm = square.max(0.0).sqrt();
                (norm, if norm > 0.0 { 1.0 / norm } else { 0.0 })
            }
        };
        for_each_product(prior, scene.joints_rad, |i, product| {
            forces.joints[i] += self.weight * slope * product;
        });
        self.weight * value
    }
}

/// Number of rows of the precision that are multiplied together.
const ROWS: usize = 8;

/// Calls `visit` with every joint and its component of Λz. Λ is symmetric, so a column gives contiguous entries of several
/// rows. Many rows are summed at a time, each in the order of its columns.
fn for_each_product(prior: &PosePrior, joints_rad: &[f64], mut visit: impl FnMut(usize, f64)) {
    let k = prior.rest_rad.len();
    for first in (0..k).step_by(ROWS) {
        let mut products = [0.0; ROWS];
        let rows = ROWS.min(k - first);
        for (j, (angle, rest)) in joints_rad.iter().zip(&prior.rest_rad).enumerate() {
            let z = angle - rest;
            let column = &prior.precision[j * k + first..j * k + first + rows];
            if let Ok(column) = <&[f64; ROWS]>::try_from(column) {
                for (product, p) in products.iter_mut().zip(column) {
                    *product += p * z;
                }
            } else {
                for (product, p) in products.iter_mut().zip(column) {
                    *product += p * z;
                }
            }
        }
        for (i, product) in products[..rows].iter().enumerate() {
            visit(first + i, *product);
        }
    }
}

impl Prior {
    fn add_standard_scores(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let prior = &scene.hand.prior;
        let scores = || {
            let angles = scene.joints_rad.iter().zip(&prior.rest_rad);
            angles
                .zip(&prior.deviations_rad)
                .map(|((q, rest), deviation)| ((q - rest) / deviation, deviation))
        };
        let norm = scores().map(|(score, _)| score * score).sum::<f64>().sqrt();
        if norm > 0.0 {
            for ((score, deviation), force) in scores().zip(&mut forces.joints) {
                *force += self.weight * score / (deviation * norm);
            }
        }
        self.weight * norm
    }
}
