//! A hand with driven joints: fingers that close on the object and yield.

use nalgebra::Vector3;
use rapier3d_f64::dynamics::{
    GenericJointBuilder, JointAxesMask, JointAxis, MotorModel, MultibodyJointHandle,
    RigidBodyBuilder, RigidBodyHandle,
};
use rapier3d_f64::geometry::{ColliderBuilder, InteractionGroups};
use rapier3d_f64::math::{Pose, Rotation};
use rapier3d_f64::parry::mass_properties::MassProperties;

use super::convert::{frame, vector};
use super::hand_parts::{balls, capsules};
use super::load_test::Closing;
use super::solid::Solid;
use super::world::World;
use crate::hand::{Hand, JointKind, LinkId, Motion, PosedHand};

/// Mass and inertia added to each link, since a link may have no geometry (a joint of two axes is two links).
const LEAST_MASS_KG: f64 = 1e-3;
const LEAST_INERTIA_KG_M2: f64 = 1e-7;

/// The joints of a hand that [`add_hand`] added.
pub(super) struct DrivenHand(Vec<DrivenLink>);

/// A link that a motor moves.
struct DrivenLink {
    handle: MultibodyJointHandle,
    /// Index of the joint in [`Hand::joints`], and the displacement of the link per displacement of the joint.
    joint: usize,
    ratio: f64,
    kind: JointKind,
    /// Σ ratio² of the joint, see [`springs_of_joints`].
    shared: f64,
}

impl DrivenHand {
    /// Sets the targets of all joints relative to the pose at the start, radians or metres.
    pub(super) fn aim(&self, world: &mut World, targets: &[f64], springs: &Closing) {
        for link in &self.0 {
            let found = world.physics.multibody_joints.get_mut(link.handle);
            let Some(moved) = found.and_then(|(multibody, id)| multibody.link_mut(id)) else {
                continue;
            };
            let target = link.ratio * targets[link.joint];
            let [stiffness, damping] = gains(link.kind, (springs, link.shared));
            let data = &mut moved.joint.data;
            data.set_motor_position(moved_axis(link.kind), target, stiffness, damping);
        }
    }

    /// Adds the displacements of the joints since the start to their coordinates there.
    pub(super) fn joints(&self, world: &World, start: &[f64]) -> Vec<f64> {
        let mut joints = start.to_vec();
        // The last link of a joint is written first, so that the joint's own link counts.
        for link in self.0.iter().rev() {
            let found = world.physics.multibody_joints.get(link.handle);
            if let Some(moved) = found.and_then(|(multibody, id)| multibody.link(id)) {
                let displacement = moved.joint().coords()[moved_axis(link.kind) as usize];
                joints[link.joint] = start[link.joint] + displacement / link.ratio;
            }
        }
        joints
    }
}

/// Adds `hand` as chains of bodies on a fixed root. Joint coordinates are relative to `posed`, and so are their `targets`,
/// radians or metres. `near_m` is that of [`balls`].
///
/// Each chain that begins at the root is a multibody of its own, because the root does not move: the engine's work grows
/// with the square and the cube of the joints of a multibody. Links that move with one joint have a spring each and share
/// its stiffness, damping and torque limit ([`springs_of_joints`]), because no coupling joins them.
pub(super) fn add_hand(
    world: &mut World,
    hand: &Hand,
    posed: &PosedHand,
    (solid, near_m): (&Solid, f64),
    targets: &[f64],
    springs: &Closing,
) -> DrivenHand {
    let shared = springs_of_joints(hand);
    let mut joints = Vec::new();
    let mut bodies: Vec<RigidBodyHandle> = Vec::with_capacity(hand.links.len());
    for (l, link) in hand.links.iter().enumerate() {
        let placed = frame(&posed.object_from_link[l]);
        let handle = match (link.parent, &link.motion) {
            (Some(parent), None) => bodies[parent.0],
            (None, _) => world
                .physics
                .insert_body(RigidBodyBuilder::fixed().pose(placed)),
            (Some(parent), Some(motion)) => {
                let inertia = vector(&Vector3::repeat(LEAST_INERTIA_KG_M2));
                let least = MassProperties::new(vector(&Vector3::zeros()), LEAST_MASS_KG, inertia);
                let body = RigidBodyBuilder::dynamic()
                    .pose(placed)
                    .can_sleep(false)
                    .additional_mass_properties(least);
                let handle = world.physics.insert_body(body);
                let of_parent = &world.physics.bodies[bodies[parent.0]];
                let (parent_pose, at_root) = (*of_parent.position(), of_parent.is_fixed());
                // Chains that share a body would be one multibody.
                let parent = if at_root {
                    let root = RigidBodyBuilder::fixed().pose(parent_pose);
                    world.physics.insert_body(root)
                } else {
                    bodies[parent.0]
                };
                let joined = join(
                    world,
                    [parent, handle],
                    parent_pose.inv_mul(&placed),
                    motion,
                    motion.ratio * targets[motion.joint],
                    (springs, shared[motion.joint]),
                );
                joints.push(DrivenLink {
                    handle: joined,
                    joint: motion.joint,
                    ratio: motion.ratio,
                    shared: shared[motion.joint],
                    kind: motion.kind,
                });
                handle
            }
        };
        bodies.push(handle);
    }
    let fix = |world: &mut World, link: LinkId, collider: ColliderBuilder| {
        let handle = bodies[link.0];
        let pose = *world.physics.bodies[handle].position();
        // The builder has placed the part in the object's frame, but its body needs it in its own frame.
        let placed = collider.position;
        let collider = collider.position(pose.inv_mul(&placed));
        world.physics.insert_collider(collider, Some(handle));
    };
    for (link, part, fills) in capsules(hand, posed) {
        let collider = world
            .holder(&part, hand, link)
            .density(Closing::DENSITY_KG_M3);
        // A capsule that fills a mesh has its mass; the balls of the mesh touch.
        let collider = if fills {
            collider.collision_groups(InteractionGroups::none())
        } else {
            collider
        };
        fix(world, link, collider);
    }
    for (link, part) in balls(hand, posed, solid, near_m) {
        let collider = world.holder(&part, hand, link).density(0.0);
        fix(world, link, collider);
    }
    // The only damping is that of the motors.
    for joint in &joints {
        if let Some((multibody, _)) = world.physics.multibody_joints.get_mut(joint.handle) {
            multibody.damping_mut().fill(0.0);
            multibody.armature_mut().fill(Closing::ARMATURE_KG_M2);
        }
    }
    DrivenHand(joints)
}

fn moved_axis(kind: JointKind) -> JointAxis {
    match kind {
        JointKind::Hinge => JointAxis::AngX,
        JointKind::Slide => JointAxis::LinX,
    }
}

/// Stiffness and damping of the spring of a link, which shares those of its joint ([`springs_of_joints`]).
fn gains(kind: JointKind, (springs, shared): (&Closing, f64)) -> [f64; 2] {
    let share = kind.radians_per_unit().powi(2) / shared;
    [springs.stiffness_n_m, springs.damping_n_m_s].map(|gain| gain * share)
}

/// Σ ratio² over the links that move with each joint: 1 where no other link follows. With stiffness k / Σ ratio² each, the
/// springs of these links together resist a displacement of the joint with the stiffness k, as one motor does.
fn springs_of_joints(hand: &Hand) -> Vec<f64> {
    let mut shared = vec![0.0; hand.joints.len()];
    for motion in hand.links.iter().filter_map(|link| link.motion.as_ref()) {
        shared[motion.joint] += motion.ratio.powi(2);
    }
    shared
}

fn join(
    world: &mut World,
    [parent, child]: [RigidBodyHandle; 2],
    parent_from_child: Pose,
    motion: &Motion,
    target: f64,
    (springs, shared): (&Closing, f64),
) -> MultibodyJointHandle {
    let turned = Pose::from_rotation(Rotation::from_rotation_arc(
        vector(&Vector3::x()),
        vector(&motion.axis),
    ));
    let locked = match motion.kind {
        JointKind::Hinge => JointAxesMask::LOCKED_REVOLUTE_AXES,
        JointKind::Slide => JointAxesMask::LOCKED_PRISMATIC_AXES,
    };
    let moved = moved_axis(motion.kind);
    let [stiffness, damping] = gains(motion.kind, (springs, shared));
    let joint = GenericJointBuilder::new(locked)
        .local_frame1(parent_from_child * turned)
        .local_frame2(turned)
        .motor_model(moved, MotorModel::ForceBased)
        .motor_position(moved, target, stiffness, damping)
        .motor_max_force(
            moved,
            springs.torque_limit_n_m * motion.kind.radians_per_unit() / shared,
        );
    world
        .physics
        .insert_multibody_joint(parent, child, joint)
        .expect("the links of a hand form a tree")
}
