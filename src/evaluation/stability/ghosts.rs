//! Removal of false contacts of the engine.

use rapier3d_f64::geometry::{Collider, ContactManifold};
use rapier3d_f64::math::Pose;
use rapier3d_f64::parry::query;
use rapier3d_f64::parry::shape::Shape;
use rapier3d_f64::pipeline::{ContactModificationContext, PhysicsHooks};

/// A contact that is deeper than the overlap of its bodies by more than this is false, metres.
const TOLERANCE_M: f64 = 1e-5;
/// A false contact is not replaced if the nearest points are farther apart than this, metres.
const REACH_M: f64 = 1e-4;

/// Removes impossible contacts.
///
/// If a capsule touches an edge between two faces, the engine finds a good normal but takes the contact points from one of
/// the faces. If that face is steep relative to the normal, the points may lie outside of it: a finger half a millimetre
/// from a bottle then pushes as if it were millimetres or centimetres inside. On firm grasps of a bottle one overlapping
/// contact in five hundred is false.
///
/// Along a normal n from the first body to the second, no two points are nearer than min over the second of n · x − max
/// over the first of n · x. A contact below this bound is removed. If its manifold has no other contact, the nearest points
/// of the two bodies replace it if they are close. A misplaced contact that is not deeper than the overlap stays, and so do
/// contacts of triangles, which have no interior.
pub(super) struct NoGhosts;

impl PhysicsHooks for NoGhosts {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let [first, second] = [context.collider1, context.collider2].map(|c| &context.colliders[c]);
        let Some(rigid) = context.rigid_mut() else {
            return;
        };
        let contacts = &mut *rigid.solver_contacts;
        // Only overlapping contacts press; near ones only limit the approach speed.
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

/// One convex part of a collider, and its pose.
fn part(collider: &Collider, index: u32) -> (&dyn Shape, Pose) {
    match collider.shape().as_compound() {
        Some(compound) => {
            let (placed, shape) = &compound.shapes()[index as usize];
            (&**shape, *collider.position() * *placed)
        }
        None => (collider.shape(), *collider.position()),
    }
}
