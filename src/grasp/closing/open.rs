//! The hand before it closes on an object.

use nalgebra::{DMatrix, DVector};

use crate::grasp::Grasp;
use crate::hand::{Hand, JointKind, LinkId, PosedHand};
use crate::mesh::ExactMesh;

/// Lever arm below which a joint hardly moves a contact, metres: the damping of the least squares.
const DAMPING_M: f64 = 0.01;

/// Joint coordinates at which the contacts of a grasp are about `gap_m` farther from the object, within the limits of the
/// joints (a grasp beyond a limit stays there). The pose of the hand stays.
///
/// ```text
/// q' = q + Jᵀ (J Jᵀ + λ² 1)⁻¹ g
/// ```
///
/// `J`: derivatives of the distances of the contacts from the object by the joints, contacts × joints; `g`: `gap_m` for
/// each contact; `λ`: 10 mm. Contacts on the palm do not move.
///
/// # Panics
/// If the grasp is one of another hand.
pub fn opened(hand: &Hand, object: &ExactMesh, grasp: &Grasp, gap_m: f64) -> Vec<f64> {
    let joints = grasp.pose.joints();
    let mut posed = PosedHand::default();
    hand.pose(&grasp.pose, &mut posed);
    let contacts = &grasp.contacts;
    let mut rates: DMatrix<f64> = DMatrix::zeros(contacts.len(), joints.len());
    for (row, &contact) in contacts.iter().enumerate() {
        let point = posed.points[contact as usize];
        let outward = object.nearest(&point).normal;
        let mut link = Some(hand.surface[contact as usize].link);
        while let Some(LinkId(l)) = link {
            if let Some(motion) = &hand.links[l].motion {
                let placed = &posed.object_from_link[l];
                let axis = placed.direction(&motion.axis);
                // A slide moves the contact by its whole way, but is compared with hinges by its lever.
                let rate = match motion.kind {
                    JointKind::Hinge => axis.dot(&(point - placed.translation).cross(&outward)),
                    JointKind::Slide => axis.dot(&outward),
                };
                rates[(row, motion.joint)] += motion.ratio * rate / motion.kind.radians_per_unit();
            }
            link = hand.links[l].parent;
        }
    }
    let mut square = &rates * rates.transpose();
    for row in 0..contacts.len() {
        square[(row, row)] += DAMPING_M * DAMPING_M;
    }
    let gaps = DVector::from_element(contacts.len(), gap_m);
    let Some(weights) = square.cholesky().map(|square| square.solve(&gaps)) else {
        return joints.to_vec();
    };
    let moves = rates.transpose() * weights;
    let moved = joints.iter().zip(moves.iter()).zip(&hand.joints);
    moved
        .map(|((&q, step), joint)| {
            let target = q + step / joint.kind.radians_per_unit();
            let [lower, upper] = joint.limits;
            if joint.wraps {
                target
            } else {
                target.clamp(lower.min(q), upper.max(q))
            }
        })
        .collect()
}
