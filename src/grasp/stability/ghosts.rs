//! Contacts that the engine makes up.

use rapier3d_f64::geometry::{Collider, ContactManifold};
use rapier3d_f64::math::Pose;
use rapier3d_f64::parry::query;
use rapier3d_f64::parry::shape::Shape;
use rapier3d_f64::pipeline::{ContactModificationContext, PhysicsHooks};

/// A contact deeper than two bodies overlap by more than this is none, metres.
const TOLERANCE_M: f64 = 1e-5;

/// Takes contacts away that cannot be.
///
/// Where a capsule meets an edge between two faces, the engine finds the normal well but takes the points of contact from
/// one of the faces, and where that face is steep against the normal they may lie outside of it: a finger half a millimetre
/// from a bottle then pushes as if it were millimetres or centimetres in it. About one active contact in two hundred is such
/// a ghost, and some hold a grasp that would fall.
///
/// Along a normal n from the first body to the second no two points are nearer than
/// min over the second of n · x − max over the first of n · x. What claims to be is replaced by the one contact that a
/// query for the nearest points finds, or by none.
pub(super) struct NoGhosts;

impl PhysicsHooks for NoGhosts {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let [first, second] = [context.collider1, context.collider2].map(|c| &context.colliders[c]);
        let Some(rigid) = context.rigid_mut() else {
            return;
        };
        if rigid
            .solver_contacts
            .iter()
            .all(|contact| contact.dist >= -TOLERANCE_M)
        {
            return;
        }
        let manifold: &ContactManifold = rigid.manifold;
        let (first, first_pose) = part(first, manifold.subshape1);
        let (second, second_pose) = part(second, manifold.subshape2);
        let (Some(convex), Some(other)) = (first.as_support_map(), second.as_support_map()) else {
            return;
        };
        let normal = *rigid.normal;
        let gap_m = (other.support_point(&second_pose, -normal)
            - convex.support_point(&first_pose, normal))
        .dot(normal);
        let contacts = &mut *rigid.solver_contacts;
        let is_ghost = |dist: f64| dist < gap_m - TOLERANCE_M;
        let Some(ghost) = contacts.iter().position(|contact| is_ghost(contact.dist)) else {
            return;
        };
        let mut replacement = contacts[ghost];
        contacts.retain(|contact| !is_ghost(contact.dist));
        if !contacts.is_empty() {
            return;
        }
        let nearest = query::contact(&first_pose, first, &second_pose, second, REACH_M);
        if let Ok(Some(nearest)) = nearest {
            replacement.anchor1 = nearest.point1;
            replacement.anchor2 = nearest.point2;
            replacement.dist = nearest.dist;
            *rigid.normal = nearest.normal1;
            contacts.push(replacement);
        }
    }
}

/// Contacts farther apart than this are not worth replacing, metres.
const REACH_M: f64 = 1e-4;

/// One convex part of a collider, and where it is.
fn part(collider: &Collider, index: u32) -> (&dyn Shape, Pose) {
    match collider.shape().as_compound() {
        Some(compound) => {
            let (placed, shape) = &compound.shapes()[index as usize];
            (&**shape, *collider.position() * *placed)
        }
        None => (collider.shape(), *collider.position()),
    }
}
