//! The terms of the energy. Each returns its value and adds its derivative.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::Reading;
use crate::grasp::closure::{PointContact, RANK_EPSILON};
use crate::hand::{Hand, LinkId, PosePrior, PosedHand, Wrench};

/// Threshold ε of the rank condition in the authors' code.
const RELEASED_RANK_EPSILON: f64 = 0.01;
/// Weight of the penetration in the authors' code.
const RELEASED_PENETRATION: f64 = 10.0;

/// A contact: a surface point of the hand with the object's distance and derivatives there (object frame).
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    /// Index of the surface point.
    pub(super) index: usize,
    pub(super) link: LinkId,
    /// Position, metres.
    pub(super) point: Vector3<f64>,
    /// Signed distance to the object, metres.
    pub(super) distance_m: f64,
    pub(super) gradient: Vector3<f64>,
    /// Hessian of the signed distance, 1/m.
    pub(super) hessian: Matrix3<f64>,
}

/// The contacts of a posed hand, and the units of the energy.
pub(super) struct Scene<'a> {
    pub(super) reading: Reading,
    pub(super) contacts: &'a [Contact],
    /// Centre of torques: the object's centroid.
    pub(super) centroid: Vector3<f64>,
    /// Length unit of arms, distances and depths, metres.
    pub(super) unit_m: f64,
}

/// Derivatives collected from the terms: one wrench for each link, and ∂E/∂θ for each joint.
pub(super) struct Forces {
    pub(super) wrenches: Vec<Wrench>,
    pub(super) joints: Vec<f64>,
}

impl Forces {
    pub(super) fn none(hand: &Hand) -> Self {
        Self {
            wrenches: vec![Wrench::default(); hand.links.len()],
            joints: vec![0.0; hand.joints.len()],
        }
    }

    pub(super) fn push(&mut self, link: LinkId, point: &Vector3<f64>, force: &Vector3<f64>) {
        self.wrenches[link.0].add(point, force);
    }
}

impl Scene<'_> {
    fn point_contact(&self, contact: &Contact) -> PointContact {
        let length = contact.gradient.norm();
        PointContact {
            arm: (contact.point - self.centroid) / self.unit_m,
            inward_normal: if length > 0.0 {
                -contact.gradient / length
            } else {
                Vector3::zeros()
            },
        }
    }

    /// Adds ∂E/∂p of a contact, given the derivatives of E by its normal and its arm.
    fn push(
        &self,
        contact: &Contact,
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
        let force = by_arm / self.unit_m - contact.hessian * tangential / length;
        forces.push(contact.link, &contact.point, &force);
    }

    /// A length s or its square, as the paper and the code have it, and the derivative.
    fn length(&self, s: f64) -> (f64, f64) {
        match self.reading {
            Reading::Printed if s == 0.0 => (0.0, 0.0),
            Reading::Printed => (s.abs(), s.signum()),
            Reading::Released => (s * s, 2.0 * s),
        }
    }

    /// ‖Gc‖ (Eq. 7), or its square: the net wrench when every contact pushes with a unit force along the inward normal.
    pub(super) fn force_closure(&self, forces: &mut Forces) -> f64 {
        let contacts = || self.contacts.iter().map(|c| (c, self.point_contact(c)));
        let net: Vector6<f64> = contacts().map(|(_, contact)| contact.wrench()).sum();
        let norm = net.norm();
        let (value, slope) = self.length(norm);
        if norm > 0.0 {
            let by_wrench = net * (slope / norm);
            let by_force = by_wrench.fixed_rows::<3>(0).into_owned();
            let by_torque = by_wrench.fixed_rows::<3>(3).into_owned();
            for (contact, point) in contacts() {
                let by_normal = by_force + by_torque.cross(&point.arm);
                let by_arm = point.inward_normal.cross(&by_torque);
                self.push(contact, &by_normal, &by_arm, forces);
            }
        }
        value
    }

    /// The rank condition (Eq. 7, first term): max(0, ε − `λ_min(GGᵀ)`), or Σₖ max(0, ε − λₖ)² in the code.
    pub(super) fn rank(&self, forces: &mut Forces) -> f64 {
        let epsilon = match self.reading {
            Reading::Printed => RANK_EPSILON,
            Reading::Released => RELEASED_RANK_EPSILON,
        };
        let arms = || {
            let contacts = self.contacts.iter();
            contacts.map(|c| (c, (c.point - self.centroid) / self.unit_m))
        };
        let mut gram = Matrix6::zeros();
        for (_, arm) in arms() {
            let cross = arm.cross_matrix();
            let mut top = gram.fixed_view_mut::<3, 3>(0, 0);
            top += Matrix3::identity();
            let mut left = gram.fixed_view_mut::<3, 3>(3, 0);
            left += cross;
            let mut right = gram.fixed_view_mut::<3, 3>(0, 3);
            right += cross.transpose();
            let mut bottom = gram.fixed_view_mut::<3, 3>(3, 3);
            bottom += cross * cross.transpose();
        }
        // Cheap usual case: the penalty is zero if GGᵀ − εI is positive definite.
        if (gram - Matrix6::identity() * epsilon).cholesky().is_some() {
            return 0.0;
        }
        let eigen = gram.symmetric_eigen();
        let least = eigen.eigenvalues.imin();
        let mut energy = 0.0;
        for (k, eigenvalue) in eigen.eigenvalues.iter().enumerate() {
            let lack = epsilon - eigenvalue;
            let (value, slope) = match self.reading {
                Reading::Printed if k == least => (lack, 1.0),
                Reading::Released if lack > 0.0 => (lack * lack, 2.0 * lack),
                Reading::Printed | Reading::Released => continue,
            };
            energy += value;
            let vector = eigen.eigenvectors.column(k);
            let by_force = vector.fixed_rows::<3>(0).into_owned();
            let by_torque = vector.fixed_rows::<3>(3).into_owned();
            for (contact, arm) in arms() {
                // λ = Σᵢ ‖u + v×aᵢ‖² for the eigenvector (u, v), so ∂λ/∂aᵢ = 2 (u + v×aᵢ) × v.
                let spread = by_force + by_torque.cross(&arm);
                let force = spread.cross(&by_torque) * (-2.0 * slope / self.unit_m);
                forces.push(contact.link, &contact.point, &force);
            }
        }
        energy
    }

    /// Σᵢ |dᵢ| / unit (Eq. 7, last term), or Σᵢ (dᵢ/unit)².
    pub(super) fn distance(&self, forces: &mut Forces) -> f64 {
        let mut energy = 0.0;
        for contact in self.contacts {
            let (value, slope) = self.length(contact.distance_m / self.unit_m);
            energy += value;
            let force = contact.gradient * (slope / self.unit_m);
            forces.push(contact.link, &contact.point, &force);
        }
        energy
    }

    /// −1/n Σᵢ nᵢ·cᵢ with the hand's outward normals nᵢ and the object's inward normals cᵢ; only in the code.
    pub(super) fn alignment(&self, hand: &Hand, posed: &PosedHand, forces: &mut Forces) -> f64 {
        if self.reading == Reading::Printed {
            return 0.0;
        }
        let scale = -1.0 / self.contacts.len().max(1) as f64;
        let mut energy = 0.0;
        for contact in self.contacts {
            let inward = self.point_contact(contact).inward_normal;
            let outward = hand.point_normal(posed, contact.index);
            energy += scale * outward.dot(&inward);
            self.push(contact, &(outward * scale), &Vector3::zeros(), forces);
            // A rotation of the link by δω changes n by δω × n, and n·c by δω·(n × c).
            forces.wrenches[contact.link.0].moment += outward.cross(&inward) * scale;
        }
        energy
    }

    /// Depths of surface points in the object (Eq. 9), given as link, point, signed distance and its gradient.
    pub(super) fn penetration(
        &self,
        inside: impl Iterator<Item = (LinkId, Vector3<f64>, f64, Vector3<f64>)>,
        forces: &mut Forces,
    ) -> f64 {
        let weight = match self.reading {
            Reading::Printed => 1.0,
            Reading::Released => RELEASED_PENETRATION,
        };
        let scale = weight / self.unit_m;
        let mut energy = 0.0;
        for (link, point, distance_m, gradient) in inside {
            energy += scale * -distance_m;
            forces.push(link, &point, &(gradient * -scale));
        }
        energy
    }

    /// The prior of joint angles z = θ − θ₀: √(zᵀΛz) (Eq. 10), or √Σ (zᵢ/σᵢ)², because the code has no synergies.
    pub(super) fn prior(&self, prior: &PosePrior, joints: &[f64], forces: &mut Forces) -> f64 {
        let offsets: Vec<f64> = (joints.iter().zip(&prior.rest))
            .map(|(q, rest)| q - rest)
            .collect();
        match self.reading {
            Reading::Printed => {
                let count = offsets.len();
                let row = |i: usize| -> f64 {
                    let row = offsets.iter().enumerate();
                    row.map(|(j, z)| prior.precision[j * count + i] * z).sum()
                };
                let products: Vec<f64> = (0..count).map(row).collect();
                let square: f64 = offsets.iter().zip(&products).map(|(z, p)| z * p).sum();
                let norm = square.max(0.0).sqrt();
                let slope = if norm > 0.0 { 1.0 / norm } else { 0.0 };
                for (force, product) in forces.joints.iter_mut().zip(products) {
                    *force += slope * product;
                }
                norm
            }
            Reading::Released => {
                let deviations = &prior.deviations;
                let scores: Vec<f64> = offsets.iter().zip(deviations).map(|(z, d)| z / d).collect();
                let norm = scores.iter().map(|score| score * score).sum::<f64>().sqrt();
                if norm > 0.0 {
                    let each = scores.iter().zip(deviations);
                    for (force, (score, deviation)) in forces.joints.iter_mut().zip(each) {
                        *force += score / (deviation * norm);
                    }
                }
                norm
            }
        }
    }
}
