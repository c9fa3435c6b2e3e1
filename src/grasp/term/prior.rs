//! Prior of natural hand poses.

use super::{Forces, Scene, Stage, Term};
use crate::hand::PosePrior;

/// Distance of the joint angles from the rest pose in the hand's Gaussian prior, z = θ − θ₀.
///
/// ```text
/// E = w ½ zᵀΛz
/// ```
///
/// It is the negative logarithm of the Gaussian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Weight w.
    pub weight: f64,
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
        let prior = &scene.hand.prior;
        let mut square = 0.0;
        for_each_product(prior, scene.joints, |i, product| {
            square += (scene.joints[i] - prior.rest[i]) * product;
        });
        for_each_product(prior, scene.joints, |i, product| {
            forces.joints[i] += self.weight * product;
        });
        self.weight * (0.5 * square)
    }
}

/// Number of rows of the precision that are multiplied together.
const ROWS: usize = 8;

/// Calls `visit` with every joint and its component of Λz. Λ is symmetric, so a column gives contiguous entries of several
/// rows. Many rows are summed at a time, each in the order of its columns.
fn for_each_product(prior: &PosePrior, joints: &[f64], mut visit: impl FnMut(usize, f64)) {
    let k = prior.rest.len();
    for first in (0..k).step_by(ROWS) {
        let mut products = [0.0; ROWS];
        let rows = ROWS.min(k - first);
        for (j, (angle, rest)) in joints.iter().zip(&prior.rest).enumerate() {
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
