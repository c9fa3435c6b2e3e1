//! A hand whose joints are driven: fingers that close on the object and give way.

use nalgebra::Vector3;
use rapier3d_f64::dynamics::{
    GenericJointBuilder, JointAxesMask, JointAxis, MotorModel, MultibodyJointHandle,
    RigidBodyBuilder, RigidBodyHandle,
};
use rapier3d_f64::math::{Pose, Rotation};
use rapier3d_f64::parry::mass_properties::MassProperties;

use super::convert::{frame, vector};
use super::settings::Squeeze;
use super::solid::Solid;
use super::world::{Part, World};
use crate::grasp::hand::{Hand, LinkId, PosedHand};

/// Mass and inertia of a link on top of what its geometry has, so that none is without: a joint of two axes is two links.
const LEAST_MASS_KG: f64 = 1e-3;
const LEAST_INERTIA_KG_M2: f64 = 1e-7;

/// How far the targets of the joints lie from the grasp's angles, radians: Jᵀf/k, see [`Squeeze`].
pub(super) fn closing(
    hand: &Hand,
    posed: &PosedHand,
    contacts: &[u32],
    solid: &Solid,
    squeeze: &Squeeze,
) -> Vec<f64> {
    let mut torques = vec![0.0; hand.joints.len()];
    for &contact in contacts {
        let point = posed.points[contact as usize];
        let force = solid.inward_normal(&point) * squeeze.force_n;
        let mut link = Some(hand.surface[contact as usize].link);
        while let Some(LinkId(l)) = link {
            if let Some(joint) = hand.links[l].joint {
                let placed = &posed.object_from_link[l];
                let axis = placed.direction(&hand.joints[joint].axis);
                torques[joint] += axis.dot(&(point - placed.translation).cross(&force));
            }
            link = hand.links[l].parent;
        }
    }
    torques
        .iter()
        .map(|torque| torque / squeeze.stiffness_n_m)
        .collect()
}

/// Adds `hand` as a chain of bodies on a root that does not move. Joint coordinates count from the grasp; their targets are
/// `closing_rad` away.
pub(super) fn add_hand(
    world: &mut World,
    hand: &Hand,
    posed: &PosedHand,
    closing_rad: &[f64],
    squeeze: &Squeeze,
) {
    let mut last_joint = None;
    let mut bodies: Vec<RigidBodyHandle> = Vec::with_capacity(hand.links.len());
    for (l, link) in hand.links.iter().enumerate() {
        let placed = frame(&posed.object_from_link[l]);
        let handle = match (link.parent, link.joint) {
            (Some(parent), None) => bodies[parent.0],
            (None, _) => world
                .physics
                .insert_body(RigidBodyBuilder::fixed().pose(placed)),
            (Some(parent), Some(joint)) => {
                let inertia = vector(&Vector3::repeat(LEAST_INERTIA_KG_M2));
                let least = MassProperties::new(vector(&Vector3::zeros()), LEAST_MASS_KG, inertia);
                let body = RigidBodyBuilder::dynamic()
                    .pose(placed)
                    .can_sleep(false)
                    .additional_mass_properties(least);
                let handle = world.physics.insert_body(body);
                let parent = bodies[parent.0];
                let parent_pose = *world.physics.bodies[parent].position();
                last_joint = Some(join(
                    world,
                    [parent, handle],
                    parent_pose.inv_mul(&placed),
                    &hand.joints[joint].axis,
                    closing_rad[joint],
                    squeeze,
                ));
                handle
            }
        };
        bodies.push(handle);
    }
    for (capsule, [a, b]) in hand.capsules.iter().zip(&posed.capsules) {
        let handle = bodies[capsule.link.0];
        let pose = *world.physics.bodies[handle].position();
        let part = Part::Capsule {
            a: *a,
            b: *b,
            radius_m: capsule.radius_m,
        };
        let collider = world.collider(&part).density(squeeze.density_kg_m3);
        // The builder has placed the capsule in the object's frame; its body wants it in its own.
        let placed = collider.position;
        let collider = collider.position(pose.inv_mul(&placed));
        world.physics.insert_collider(collider, Some(handle));
    }
    // All joints are of one tree, which any of them finds. Its damping is that of the motors only.
    let tree = last_joint.and_then(|joint| world.physics.multibody_joints.get_mut(joint));
    if let Some((multibody, _)) = tree {
        multibody.damping_mut().fill(0.0);
        multibody.armature_mut().fill(squeeze.armature_kg_m2);
    }
}

fn join(
    world: &mut World,
    [parent, child]: [RigidBodyHandle; 2],
    parent_from_child: Pose,
    axis: &Vector3<f64>,
    closing_rad: f64,
    squeeze: &Squeeze,
) -> MultibodyJointHandle {
    let turned = Pose::from_rotation(Rotation::from_rotation_arc(
        vector(&Vector3::x()),
        vector(axis),
    ));
    let joint = GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
        .local_frame1(parent_from_child * turned)
        .local_frame2(turned)
        .motor_model(JointAxis::AngX, MotorModel::ForceBased)
        .motor_position(
            JointAxis::AngX,
            closing_rad,
            squeeze.stiffness_n_m,
            squeeze.damping_n_m_s,
        )
        .motor_max_force(JointAxis::AngX, squeeze.torque_limit_n_m);
    world
        .physics
        .insert_multibody_joint(parent, child, joint)
        .expect("the links of a hand form a tree")
}
