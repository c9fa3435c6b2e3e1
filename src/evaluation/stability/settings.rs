//! What a simulation assumes, and when a grasp counts as stable. Everything here is written into the file it judged.

use serde::{Deserialize, Serialize};

use crate::limits::{Beyond, Limit, SIMULATION, SIMULATION_OR_ZERO, SIMULATION_STEPS};

/// How two friction coefficients make one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Combine {
    /// μ₁ μ₂, as Bullet.
    Multiply,
    /// max(μ₁, μ₂), as `MuJoCo`.
    Maximum,
    /// min(μ₁, μ₂).
    Minimum,
    /// (μ₁ + μ₂)/2, as `PhysX`.
    Average,
    /// √(μ₁ μ₂), as `Box2D`.
    GeometricMean,
}

/// Coulomb friction between hand and object.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Coefficient of the hand.
    pub hand: f64,
    /// Coefficient of the object.
    pub object: f64,
    /// The coefficient in contact, of these two.
    pub combine: Combine,
}

impl Friction {
    /// The coefficient in contact.
    pub fn effective(&self) -> f64 {
        match self.combine {
            Combine::Multiply => self.hand * self.object,
            Combine::Maximum => self.hand.max(self.object),
            Combine::Minimum => self.hand.min(self.object),
            Combine::Average => 0.5 * (self.hand + self.object),
            Combine::GeometricMean => (self.hand * self.object).sqrt(),
        }
    }
}

/// How the engine (Rapier) steps. Contacts are springs of very high damping, solved implicitly in substeps; friction is
/// Coulomb's, per contact point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// Time step, seconds.
    pub time_step_s: f64,
    /// Substeps of each step; contacts are found or updated once a step.
    pub substeps: usize,
    /// Sweeps over all contacts in each substep: a hand that encloses an object has dozens that press against each other, and
    /// with one sweep the object creeps out.
    pub sweeps: usize,
    /// Natural frequency of a contact, Hz.
    pub contact_frequency_hz: f64,
    /// Damping ratio of a contact.
    pub contact_damping: f64,
    /// Largest speed at which overlaps are pushed apart, m/s.
    pub recovery_m_s: f64,
    /// Surfaces closer than this are watched for contact during a step, metres.
    pub prediction_m: f64,
}

impl Default for Solver {
    fn default() -> Self {
        Self {
            time_step_s: 1.0 / 60.0,
            substeps: 4,
            sweeps: 4,
            contact_frequency_hz: 60.0,
            contact_damping: 10.0,
            recovery_m_s: 3.0,
            prediction_m: 0.0005,
        }
    }
}

/// When an object counts as at rest, so that the steps that are left are not simulated: it stays where it has come to rest in
/// a hand that holds still.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Rest {
    /// No point of the object has moved farther than this, metres …
    pub way_m: f64,
    /// … within this time, seconds. With more than the test takes every step is simulated.
    pub time_s: f64,
}

impl Default for Rest {
    /// 10 µm in a quarter of a second: at that speed an object would creep by 0.7 mm in the whole drop. Of 400 grasps on
    /// a bottle none had another outcome to the last step, and the farthest would have moved on by 1.4 mm.
    fn default() -> Self {
        Self {
            way_m: 1e-5,
            time_s: 0.25,
        }
    }
}

/// Gravity acts on the object in a rigid hand that does not move: the test of Liu et al. (2021), Table I.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Drop {
    /// Gravity in the object's frame, m/s².
    pub gravity_m_s2: [f64; 3],
    /// Time in which the object comes to rest in the hand before gravity acts, seconds; 0 lets go of it at once. What
    /// overlaps presses like a spring, but the engine needs about 0.15 s to find the forces, in which an object falls by
    /// a hand's breadth.
    pub settle_s: f64,
    /// Number of time steps under gravity.
    pub steps: usize,
    /// The object has fallen once its centre of mass is this much lower, metres.
    pub fall_m: f64,
    /// When the object holds before the last step.
    pub rest: Rest,
    /// Overlap of hand and object at the start that is not simulated any more but failed, metres.
    pub overlap_m: f64,
    /// Friction.
    pub friction: Friction,
    /// The engine.
    pub solver: Solver,
}

impl Default for Drop {
    /// Gravity 10 m/s² down the object's z axis, 1000 steps of 1/60 s, a fall of 0.3 m, and `PyBullet`'s default friction:
    /// 0.5 for each body, which Bullet multiplies. The publication does not say how the object comes into the hand; here it
    /// comes to rest within a second without gravity.
    fn default() -> Self {
        Self {
            gravity_m_s2: [0.0, 0.0, -10.0],
            settle_s: 1.0,
            steps: 1000,
            fall_m: 0.3,
            rest: Rest::default(),
            overlap_m: 0.01,
            friction: Friction {
                hand: 0.5,
                object: 0.5,
                combine: Combine::Multiply,
            },
            solver: Solver::default(),
        }
    }
}

/// How the hand closes before it is tested, and holds while it is.
///
/// Each joint is driven to a target by a spring with damping and limited torque. The targets are moved from the grasp's
/// angles by Jᵀf/k: the torques of contact forces f that balance each other (`closure::contact_forces` at the protocol's
/// friction), over the stiffness k. Where none balance, all press alike along their inward normals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Squeeze {
    /// Mean force with which the contacts press, newtons.
    pub force_n: f64,
    /// Stiffness of the joints, N·m/rad.
    pub stiffness_n_m: f64,
    /// Damping of the joints, N·m·s/rad.
    pub damping_n_m_s: f64,
    /// Largest torque of a joint, N·m.
    pub torque_limit_n_m: f64,
    /// Time in which the targets move and the hand comes to rest, seconds; a rigid hand waits as long.
    pub time_s: f64,
    /// Density of the hand, kg/m³.
    pub density_kg_m3: f64,
    /// Inertia that each joint has of its own, kg·m²: that of its motor or tendons.
    pub armature_kg_m2: f64,
}

impl Default for Squeeze {
    /// Gains and times of `DexGraspBench`: kp = 5 with limits of ±3, 0.4 s to the squeeze pose; the armature of the Shadow
    /// hand in `MuJoCo` Menagerie, which it uses. The force is ours: there, squeezed poses come with the grasps.
    fn default() -> Self {
        Self {
            force_n: 4.0,
            stiffness_n_m: 5.0,
            damping_n_m_s: 0.1,
            torque_limit_n_m: 3.0,
            time_s: 0.4,
            density_kg_m3: 1000.0,
            armature_kg_m2: 2e-4,
        }
    }
}

/// The object is pushed along ±x, ±y and ±z in turn, without gravity; after `DexGraspBench` (Chen et al. 2025).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SixDirections {
    /// Mass that the object is given, kg.
    pub mass_kg: f64,
    /// Push at the centre of mass, newtons.
    pub force_n: f64,
    /// Time of each push, seconds.
    pub push_s: f64,
    /// The grasp fails where the object's centre of mass moves this far, metres …
    pub displacement_m: f64,
    /// … or it turns this much, radians.
    pub turn_rad: f64,
    /// When the object holds against a push before its time is over.
    pub rest: Rest,
    /// Overlap of hand and object at the start that is not simulated any more but failed, metres.
    pub overlap_m: f64,
    /// Whether hand and joints are rigid instead of squeezing.
    pub rigid: bool,
    /// How the hand closes and holds, unless it is rigid.
    pub squeeze: Squeeze,
    /// Friction.
    pub friction: Friction,
    /// The engine.
    pub solver: Solver,
}

impl Default for SixDirections {
    /// 0.1 kg, 1 N for 2 s each, less than 5 cm and 15°, friction 0.6.
    fn default() -> Self {
        Self {
            mass_kg: 0.1,
            force_n: 1.0,
            push_s: 2.0,
            displacement_m: 0.05,
            turn_rad: 15.0_f64.to_radians(),
            rest: Rest::default(),
            overlap_m: 0.01,
            rigid: false,
            squeeze: Squeeze::default(),
            friction: Friction {
                hand: 0.6,
                object: 0.6,
                combine: Combine::Maximum,
            },
            solver: Solver {
                time_step_s: 0.004,
                substeps: 2,
                ..Solver::default()
            },
        }
    }
}

impl SixDirections {
    /// The same without the squeeze: hand and joints are rigid.
    pub fn rigid() -> Self {
        Self {
            rigid: true,
            ..Self::default()
        }
    }
}

/// A test of stability with all its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "protocol", rename_all = "kebab-case")]
pub enum Protocol {
    /// Gravity on an object in a rigid hand.
    Drop(Drop),
    /// Pushes along six directions.
    SixDirections(SixDirections),
}

impl Protocol {
    /// One clear sentence on the first value that makes no sense.
    ///
    /// # Errors
    /// If a size, time or coefficient is out of its range.
    pub fn validate(&self) -> Result<(), ProtocolError> {
        let mut positive: Vec<(&'static str, f64)> = Vec::new();
        let mut others: Vec<(&'static str, Limit, f64)> = Vec::new();
        let (friction, solver, steps) = match self {
            Self::Drop(drop) => {
                positive.push(("fall_m", drop.fall_m));
                positive.push(("overlap_m", drop.overlap_m));
                positive.push(("rest.way_m", drop.rest.way_m));
                positive.push(("rest.time_s", drop.rest.time_s));
                for gravity in drop.gravity_m_s2 {
                    others.push(("gravity_m_s2", SIMULATION_OR_ZERO, gravity.abs()));
                }
                others.push(("settle_s", SIMULATION_OR_ZERO, drop.settle_s));
                let squared: f64 = drop.gravity_m_s2.iter().map(|g| g * g).sum();
                positive.push(("the square of gravity_m_s2", squared));
                let settling = drop.settle_s / drop.solver.time_step_s;
                (drop.friction, drop.solver, settling + drop.steps as f64)
            }
            Self::SixDirections(six) => {
                positive.extend([
                    ("mass_kg", six.mass_kg),
                    ("push_s", six.push_s),
                    ("displacement_m", six.displacement_m),
                    ("turn_rad", six.turn_rad),
                    ("rest.way_m", six.rest.way_m),
                    ("rest.time_s", six.rest.time_s),
                    ("overlap_m", six.overlap_m),
                    ("force_n", six.force_n),
                ]);
                let squeeze = &six.squeeze;
                positive.extend([
                    ("squeeze.force_n", squeeze.force_n),
                    ("squeeze.stiffness_n_m", squeeze.stiffness_n_m),
                    ("squeeze.damping_n_m_s", squeeze.damping_n_m_s),
                    ("squeeze.torque_limit_n_m", squeeze.torque_limit_n_m),
                    ("squeeze.time_s", squeeze.time_s),
                    ("squeeze.density_kg_m3", squeeze.density_kg_m3),
                    ("squeeze.armature_kg_m2", squeeze.armature_kg_m2),
                ]);
                let time_s = squeeze.time_s + 6.0 * six.push_s;
                (six.friction, six.solver, time_s / six.solver.time_step_s)
            }
        };
        positive.extend([
            ("solver.time_step_s", solver.time_step_s),
            ("solver.contact_frequency_hz", solver.contact_frequency_hz),
            ("solver.contact_damping", solver.contact_damping),
            ("solver.recovery_m_s", solver.recovery_m_s),
            ("solver.prediction_m", solver.prediction_m),
            ("solver.substeps", solver.substeps as f64),
            ("solver.sweeps", solver.sweeps as f64),
        ]);
        let divided = solver.substeps as f64 * solver.sweeps as f64;
        others.extend([
            ("friction.hand", SIMULATION_OR_ZERO, friction.hand),
            ("friction.object", SIMULATION_OR_ZERO, friction.object),
            (
                "steps, substeps and sweeps",
                SIMULATION_STEPS,
                steps * divided,
            ),
        ]);
        let positive = positive.into_iter();
        let positive = positive.map(|(name, value)| (name, SIMULATION, value));
        for (name, limit, value) in positive.chain(others) {
            let told = |beyond| ProtocolError { name, beyond };
            limit.check(value).map_err(told)?;
        }
        Ok(())
    }

    /// Whether hand and joints are rigid.
    pub fn is_rigid(&self) -> bool {
        match self {
            Self::Drop(_) => true,
            Self::SixDirections(six) => six.rigid,
        }
    }
}

/// A value of a protocol out of its range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} = {beyond}")]
pub struct ProtocolError {
    name: &'static str,
    beyond: Beyond,
}
