//! A world of a few bodies in the physics engine.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Vector3};
use rapier3d_f64::dynamics::{
    CoefficientCombineRule, FrictionModel, IntegrationParameters, LockedAxes, RigidBodyBuilder,
    RigidBodyHandle, SpringCoefficients,
};
use rapier3d_f64::geometry::{
    Collider, ColliderBuilder, Group, InteractionGroups, InteractionTestMode, SharedShape,
};
use rapier3d_f64::parry::query::contact;
use rapier3d_f64::pipeline::{ActiveHooks, PhysicsWorld};

use super::convert::{from_vector, isometry, vector};
use super::ghosts::NoGhosts;
use super::settings::Solver;
use super::solid::{Solid, motion};
use crate::hand::{Hand, LinkId};
use crate::mesh::Mesh;

/// A holding part, of a hand or of a gripper.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// All points within `radius_m` of a segment.
    Capsule {
        /// First end of the axis, metres.
        a: Vector3<f64>,
        /// Second end of the axis, metres.
        b: Vector3<f64>,
        /// Radius, metres.
        radius_m: f64,
    },
    /// A ball.
    Ball {
        /// Centre, metres.
        centre: Vector3<f64>,
        /// Radius, metres.
        radius_m: f64,
    },
    /// A box along the axes.
    Cuboid {
        /// Centre, metres.
        centre: Vector3<f64>,
        /// Half of each side, metres.
        half: Vector3<f64>,
    },
    /// A surface of triangles.
    Mesh(Mesh),
}

/// One object and the parts that hold it.
pub struct World {
    pub(super) physics: PhysicsWorld,
    friction: f64,
    object: RigidBodyHandle,
    centre: Vector3<f64>,
}

impl std::fmt::Debug for World {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("World")
            .field("object", &self.object_pose())
            .finish_non_exhaustive()
    }
}

impl World {
    /// A world with an object at rest in its frame, gravity (m/s²) in that frame, and the friction of all contacts.
    pub fn new(
        solid: &Solid,
        mass_kg: f64,
        gravity_m_s2: [f64; 3],
        friction: f64,
        solver: &Solver,
    ) -> Self {
        let mut physics = PhysicsWorld::new();
        physics.gravity = vector(&gravity_m_s2.into());
        physics.integration_parameters = parameters(solver);
        let body = RigidBodyBuilder::dynamic().can_sleep(false);
        let collider = ColliderBuilder::new(solid.shape.clone())
            .mass_properties(solid.of_mass(mass_kg))
            .friction(friction)
            .friction_combine_rule(CoefficientCombineRule::Max)
            .collision_groups(groups(OBJECT, HOLDER))
            .active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS);
        let (object, _) = physics.insert(body, collider);
        Self {
            physics,
            friction,
            object,
            centre: solid.centre(),
        }
    }

    /// A copy of this world, which can continue differently.
    #[must_use]
    pub fn fork(&self) -> Self {
        let now = &self.physics;
        let mut physics = PhysicsWorld::new();
        physics.gravity = now.gravity;
        physics.integration_parameters = now.integration_parameters;
        physics.islands = now.islands.clone();
        physics.broad_phase = now.broad_phase.clone();
        physics.narrow_phase = now.narrow_phase.clone();
        physics.bodies = now.bodies.clone();
        physics.colliders = now.colliders.clone();
        physics.multibody_joints = now.multibody_joints.clone();
        Self {
            physics,
            friction: self.friction,
            object: self.object,
            centre: self.centre,
        }
    }

    /// Adds a fixed part.
    ///
    /// # Panics
    /// Never: a [`Mesh`] has triangles.
    pub fn fix(&mut self, part: &Part) {
        let collider = self.collider(part);
        self.physics.insert_collider(collider, None);
    }

    /// Adds a part that slides along `force_n` without rotation and is pushed by that force (newtons).
    ///
    /// # Panics
    /// If the force is not along one of the axes.
    pub fn push(&mut self, part: &Part, mass_kg: f64, force_n: Vector3<f64>) {
        let locked = [
            LockedAxes::TRANSLATION_LOCKED_X,
            LockedAxes::TRANSLATION_LOCKED_Y,
            LockedAxes::TRANSLATION_LOCKED_Z,
        ];
        let along = force_n.iamax();
        assert!(
            (force_n.norm() - force_n[along].abs()).abs() < 1e-12,
            "a part is pushed along an axis"
        );
        let axes = (0..3)
            .filter(|&axis| axis != along)
            .fold(LockedAxes::ROTATION_LOCKED, |axes, axis| {
                axes | locked[axis]
            });
        let body = RigidBodyBuilder::dynamic()
            .can_sleep(false)
            .gravity_scale(0.0)
            .locked_axes(axes);
        let collider = self.collider(part).mass(mass_kg);
        let (handle, _) = self.physics.insert(body, collider);
        self.physics.bodies[handle].add_force(vector(&force_n), true);
    }

    pub(super) fn collider(&self, part: &Part) -> ColliderBuilder {
        let builder = match part {
            Part::Capsule { a, b, radius_m } => {
                ColliderBuilder::capsule_from_endpoints(vector(a), vector(b), *radius_m)
            }
            Part::Ball { centre, radius_m } => {
                ColliderBuilder::ball(*radius_m).translation(vector(centre))
            }
            Part::Cuboid { centre, half } => {
                ColliderBuilder::cuboid(half.x, half.y, half.z).translation(vector(centre))
            }
            Part::Mesh(mesh) => ColliderBuilder::new(
                SharedShape::trimesh(
                    mesh.vertices().iter().map(vector).collect(),
                    mesh.triangles().to_vec(),
                )
                .expect("a mesh has triangles"),
            ),
        };
        builder
            .friction(self.friction)
            .friction_combine_rule(CoefficientCombineRule::Max)
            .collision_groups(groups(HOLDER, OBJECT))
    }

    /// A part of a link of a hand, by which [`World::pressing_parts`] knows the digit.
    pub(super) fn holder(&self, part: &Part, hand: &Hand, link: LinkId) -> ColliderBuilder {
        let digit = hand.links[link.0].digit;
        self.collider(part).user_data(digit as u128)
    }

    /// The digits of the hand that pressed on the object in the last step; 0 is the palm, as in
    /// [`Link::digit`](crate::hand::Link::digit).
    pub(super) fn pressing_parts(&self) -> BTreeSet<u128> {
        let pairs = self.physics.narrow_phase.contact_pairs();
        let pressing = pairs.filter(|pair| pair.total_impulse_magnitude() > 0.0);
        let ends = pressing.flat_map(|pair| [pair.collider1, pair.collider2]);
        let colliders = ends.map(|end| &self.physics.colliders[end]);
        let holders = colliders.filter(|collider| collider.parent() != Some(self.object));
        holders.map(|collider| collider.user_data).collect()
    }

    /// Sets gravity, m/s², in the object's frame at the start.
    pub fn set_gravity(&mut self, gravity_m_s2: [f64; 3]) {
        self.physics.gravity = vector(&gravity_m_s2.into());
    }

    /// Sets the damping of the object's velocity and of its angular velocity, 1/s.
    pub fn damp_object(&mut self, linear_per_s: f64, angular_per_s: f64) {
        let body = &mut self.physics.bodies[self.object];
        body.set_linear_damping(linear_per_s);
        body.set_angular_damping(angular_per_s);
    }

    /// Sets the force at the object's centre of mass, newtons.
    pub fn push_object(&mut self, force_n: &Vector3<f64>) {
        let body = &mut self.physics.bodies[self.object];
        body.reset_forces(true);
        body.add_force(vector(force_n), true);
    }

    /// One time step.
    pub fn step(&mut self) {
        self.physics.step_with_events(&NoGhosts, &());
    }

    /// The transform of the object from the start to now.
    pub fn object_pose(&self) -> Isometry3<f64> {
        isometry(self.physics.bodies[self.object].position())
    }

    /// Displacement of the object's centre of mass since the start, metres, and its rotation angle, radians.
    pub fn motion(&self) -> (Vector3<f64>, f64) {
        motion(&self.object_pose(), &self.centre)
    }

    /// Velocity of the object's centre of mass, m/s, and its angular velocity, rad/s.
    pub fn velocity(&self) -> [Vector3<f64>; 2] {
        let body = &self.physics.bodies[self.object];
        [from_vector(body.linvel()), from_vector(body.angvel())]
    }

    /// Deepest overlap of any part with one piece of the object, metres; 0 without overlap. A surface of triangles
    /// ([`Build::Triangles`](super::Build::Triangles)) has no interior, so parts deep in it overlap little or not at all.
    pub fn overlap_m(&self) -> f64 {
        let of_object = |collider: &Collider| collider.parent() == Some(self.object);
        let colliders = || self.physics.colliders.iter().map(|(_, collider)| collider);
        let mut deepest_m = 0.0f64;
        for object in colliders().filter(|collider| of_object(collider)) {
            for holder in colliders().filter(|collider| !of_object(collider)) {
                let nearest = contact(
                    object.position(),
                    object.shape(),
                    holder.position(),
                    holder.shape(),
                    0.0,
                );
                if let Ok(Some(nearest)) = nearest {
                    deepest_m = deepest_m.max(-nearest.dist);
                }
            }
        }
        deepest_m
    }
}

fn parameters(solver: &Solver) -> IntegrationParameters {
    let softness = SpringCoefficients {
        natural_frequency: Solver::CONTACT_FREQUENCY_HZ,
        damping_ratio: Solver::CONTACT_DAMPING,
    };
    IntegrationParameters {
        dt: solver.time_step_s,
        num_solver_iterations: solver.substeps,
        num_internal_pgs_iterations: Solver::SWEEPS,
        contact_softness: softness,
        static_contact_softness: softness,
        normalized_max_corrective_velocity: Solver::RECOVERY_M_S,
        normalized_prediction_distance: Solver::PREDICTION_M,
        // Merged contacts, or friction in only one of the two passes, let squeezed objects creep and shiver: a block held
        // with a tenth more friction than needed sinks by millimetres instead of hundredths of a millimetre.
        contact_clustering: false,
        friction_in_bias_pass: true,
        max_ccd_substeps: 0,
        friction_model: FrictionModel::Coulomb,
        ..IntegrationParameters::default()
    }
}

/// Collision groups of the object and of the parts that hold it; parts do not touch each other.
const OBJECT: Group = Group::GROUP_1;
const HOLDER: Group = Group::GROUP_2;

fn groups(own: Group, other: Group) -> InteractionGroups {
    InteractionGroups::new(own, other, InteractionTestMode::And)
}
