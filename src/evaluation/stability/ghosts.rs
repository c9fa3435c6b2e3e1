//! Contacts that the engine makes up.

use rapier3d_f64::geometry::{Collider, ContactManifold};
use rapier3d_f64::math::Pose;
use rapier3d_f64::parry::query;
use rapier3d_f64::parry::shape::Shape;
use rapier3d_f64::pipeline::{ContactModificationContext, PhysicsHooks};

/// A contact deeper by this than two bodies overlap is none, metres.
const TOLERANCE_M: f64 = 1e-5;
/// Where the nearest points are farther apart than this, no contact takes the place of one that was none, metres.
const REACH_M: f64 = 1e-4;

/// Takes contacts away that cannot be.
///
/// Where a capsule meets an edge between two faces, the engine finds the normal well but takes the points of contact from
/// one of the faces, and where that face is steep against the normal they may lie outside of it: a finger half a millimetre
/// from a bottle then pushes as if it were millimetres or centimetres in it. On firm grasps of a bottle one overlapping
/// contact in five hundred is such a ghost.
///
/// Along a normal n from the first body to the second no two points are nearer than
/// min over the second of n · x − max over the first of n · x. A contact that claims to be is taken out; if no other of its
/// manifold is left, the nearest points of the two take its place where they are close. What is not deeper than the bodies
/// overlap, but in a wrong place, stays, and so do contacts of triangles, which have no inside.
pub(super) struct NoGhosts;

impl PhysicsHooks for NoGhosts {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let [first, second] = [context.collider1, context.collider2].map(|c| &context.colliders[c]);
        let Some(rigid) = context.rigid_mut() else {
            return;
        };
        let contacts = &mut *rigid.solver_contacts;
        // Only what overlaps presses; what is near only limits how fast it comes nearer.
        if contacts.iter().all(|contact| contact.dist >= -TOLERANCE_M) {
            return;
        }
        let manifold: &ContactManifold = rigid.manifold;
        let (first, first_pose) = part(first, manifold.subshape1);
        let (second, second_pose) = part(second, manifold.subshape2);
        let convex = (first.as_support_map(), second.as_support_map());
        let (Some(first_support), Some(second_support)) = convex else {
            return;
        };
        let normal = *rigid.normal;
        let ends = [
            first_support.support_point(&first_pose, normal),
            second_support.support_point(&second_pose, -normal),
        ];
        let gap_m = (ends[1] - ends[0]).dot(normal);
        let is_ghost = |dist: f64| dist < gap_m - TOLERANCE_M;
        let Some(mut ghost) = contacts
            .iter()
            .find(|contact| is_ghost(contact.dist))
            .copied()
        else {
            return;
        };
        contacts.retain(|contact| !is_ghost(contact.dist));
        if !contacts.is_empty() {
            return;
        }
        let nearest = query::contact(&first_pose, first, &second_pose, second, REACH_M);
        if let Ok(Some(nearest)) = nearest {
            ghost.anchor1 = nearest.point1;
            ghost.anchor2 = nearest.point2;
            ghost.dist = nearest.dist;
            *rigid.normal = nearest.normal1;
            contacts.push(ghost);
        }
    }
}

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
