//! Relaxed force closure and the rank condition.

use nalgebra::{Matrix6, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use super::{Contact, Forces, NormForm, Scene, Stage, Term};
use crate::grasp::closure::PointContact;

/// The net wrench when every contact pushes with a unit force along the object's inward normal.
///
/// ```text
/// E = w (√(‖Gc‖² + r²) − r),   Gc = Σᵢ (cᵢ, aᵢ × cᵢ),   cᵢ = −∇d/‖∇d‖ at pᵢ,   aᵢ = (pᵢ − centroid) / unit
/// ```
///
/// Normals turn as contacts move, so the derivative contains the shape's curvature. Liu et al. (2021), Eq. 7, has r = 0. A
/// positive r makes the term smooth where the contacts balance. Their code has w ‖Gc‖².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceClosure {
    /// Weight w.
    pub weight: f64,
    /// Norm or square.
    pub form: NormForm,
    /// Rounding r of the norm.
    pub rounding: f64,
}

/// The contact in the form of the force-closure tests.
pub(crate) fn point_contact(
    contact: &Contact,
    centroid: &Vector3<f64>,
    unit_m: f64,
) -> PointContact {
    let length = contact.gradient.norm();
    PointContact {
        arm: (contact.point - centroid) / unit_m,
        inward_normal: if length > 0.0 {
            -contact.gradient / length
        } else {
            Vector3::zeros()
        },
    }
}

/// Adds ∂E/∂pᵢ, given the derivatives of E with respect to the contact's normal and arm.
pub(super) fn push(
    contact: &Contact,
    unit_m: f64,
    by_normal: &Vector3<f64>,
    by_arm: &Vector3<f64>,
    forces: &mut Forces,
) {
    let length = contact.gradient.norm();
    if length == 0.0 {
        return;
    }
    // c = −g/‖g‖, so dc = −(I − ĝĝᵀ) H dp / ‖g‖.
    let unit = contact.gradient / length;
    let tangential = by_normal - unit * unit.dot(by_normal);
    let force = by_arm / unit_m - contact.hessian * tangential / length;
    forces.push_surface(contact.index, contact.link, &contact.point, &force);
}

impl Term for ForceClosure {
    fn name(&self) -> &'static str {
        "force_closure"
    }

    fn weight(&self) -> f64 {
        self.weight
    }

    fn stage(&self) -> Stage {
        Stage::Contacts
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let contacts = || {
            scene
                .contacts
                .iter()
                .map(|c| (c, point_contact(c, &scene.object.centroid, scene.unit_m)))
        };
        let net: Vector6<f64> = contacts().map(|(_, c)| c.wrench()).sum();
        let norm = net.norm();
        let (value, slope) = self.form.apply(norm, self.rounding);
        if norm > 0.0 {
            let by_wrench = net * (self.weight * slope / norm);
            let by_force = by_wrench.fixed_rows::<3>(0).into_owned();
            let by_torque = by_wrench.fixed_rows::<3>(3).into_owned();
            for (contact, point) in contacts() {
                push(
                    contact,
                    scene.unit_m,
                    &(by_force + by_torque.cross(&point.arm)),
                    &point.inward_normal.cross(&by_torque),
                    forces,
                );
            }
        }
        self.weight * value
    }
}

/// Eigenvalues of `GGᵀ` in the rank condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RankForm {
    /// The least: max(0, ε − λₘᵢₙ), as printed.
    Least,
    /// All: Σₖ max(0, ε − λₖ)², as coded.
    Sum,
}

/// The rank condition of force closure as a penalty.
///
/// ```text
/// E = w max(0, ε − λ_min(GGᵀ))    or    w Σₖ max(0, ε − λₖ(GGᵀ))²
/// ```
///
/// Liu et al. (2021), Eq. 7, first term; the sum is from their code.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rank {
    /// Weight w.
    pub weight: f64,
    /// Least eigenvalue or all.
    pub form: RankForm,
    /// Threshold ε.
    pub epsilon: f64,
}

impl Term for Rank {
    fn name(&self) -> &'static str {
        "rank"
    }

    fn weight(&self) -> f64 {
        self.weight
    }

    fn stage(&self) -> Stage {
        Stage::Contacts
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let arms = || {
            scene
                .contacts
                .iter()
                .map(|c| (c, (c.point - scene.object.centroid) / scene.unit_m))
        };
        let mut gram = Matrix6::zeros();
        for (_, arm) in arms() {
            let cross = arm.cross_matrix();
            let mut top = gram.fixed_view_mut::<3, 3>(0, 0);
            top += nalgebra::Matrix3::identity();
            let mut left = gram.fixed_view_mut::<3, 3>(3, 0);
            left += cross;
            let mut right = gram.fixed_view_mut::<3, 3>(0, 3);
            right += cross.transpose();
            let mut bottom = gram.fixed_view_mut::<3, 3>(3, 3);
            bottom += cross * cross.transpose();
        }
        // Cheap usual case: the penalty is zero if GGᵀ − εI is positive definite.
        if (gram - Matrix6::identity() * self.epsilon)
            .cholesky()
            .is_some()
        {
            return 0.0;
        }
        let eigen = gram.symmetric_eigen();
        let least = eigen.eigenvalues.imin();
        let mut energy = 0.0;
        for (k, eigenvalue) in eigen.eigenvalues.iter().enumerate() {
            let lack = self.epsilon - eigenvalue;
            let (value, slope) = match self.form {
                RankForm::Least if k == least => (lack, 1.0),
                RankForm::Sum if lack > 0.0 => (lack * lack, 2.0 * lack),
                RankForm::Least | RankForm::Sum => continue,
            };
            energy += self.weight * value;
            let vector = eigen.eigenvectors.column(k);
            let by_force = vector.fixed_rows::<3>(0).into_owned();
            let by_torque = vector.fixed_rows::<3>(3).into_owned();
            for (contact, arm) in arms() {
                // λ = Σᵢ ‖u + tᵢ‖² with u the force part and tᵢ = [aᵢ]ₓᵀ v = v × aᵢ, so ∂λ/∂aᵢ = 2 (u + v×aᵢ) × v.
                let spread = by_force + by_torque.cross(&arm);
                let factor = -2.0 * self.weight * slope / scene.unit_m;
                forces.push_surface(
                    contact.index,
                    contact.link,
                    &contact.point,
                    &(spread.cross(&by_torque) * factor),
                );
            }
        }
        energy
    }
}
