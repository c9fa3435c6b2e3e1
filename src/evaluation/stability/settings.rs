//! Assumptions of a simulation and criteria of stability. Every value is written into the files of judged grasps.

use serde::{Deserialize, Serialize};

use crate::limits::{Beyond, Limit, SIMULATION, SIMULATION_OR_ZERO, SIMULATION_STEPS};

/// Overlap of hand and object at the start above which a grasp fails without simulation, metres. It would push the object
/// out of the hand.
pub(super) const OVERLAP_M: f64 = 0.01;

/// Settings of the engine (Rapier). Contacts are springs of very high damping, solved implicitly in substeps; friction is
/// Coulomb's, per contact point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Solver {
    /// Time step, seconds.
    pub time_step_s: f64,
    /// Substeps of each step; contacts are found or updated once a step.
    pub substeps: usize,
}

impl Solver {
    /// Natural frequency of a contact, Hz. Its spring gives 0.07 mm under the object's weight, far less than an object moves
    /// that slips.
    pub const CONTACT_FREQUENCY_HZ: f64 = 60.0;
    /// Damping ratio of a contact.
    pub const CONTACT_DAMPING: f64 = 10.0;
    /// Sweeps over all contacts in each substep. A hand that encloses an object has dozens of contacts that press against
    /// each other, and with one sweep the object creeps out.
    pub(super) const SWEEPS: usize = 4;
    /// Largest speed at which overlaps are resolved, m/s.
    pub(super) const RECOVERY_M_S: f64 = 3.0;
    /// Surfaces closer than this are checked for contact during a step, metres.
    pub(super) const PREDICTION_M: f64 = 0.0005;
}

impl Default for Solver {
    fn default() -> Self {
        Self {
            time_step_s: 1.0 / 60.0,
            substeps: 4,
        }
    }
}

/// Criterion of rest. The steps after it are not simulated, because an object at rest stays in a hand that does not move.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Rest {
    /// No point of the object has moved farther than this, metres …
    pub way_m: f64,
    /// … within this time, seconds. If this is longer than the test, every step is simulated.
    pub time_s: f64,
}

impl Default for Rest {
    /// 10 µm in a quarter of a second: at that speed an object would creep by 0.7 mm in the whole drop. When 400 grasps on
    /// a bottle were simulated to the last step, none changed its outcome, and the largest further motion was 1.4 mm.
    fn default() -> Self {
        Self {
            way_m: 1e-5,
            time_s: 0.25,
        }
    }
}

/// Gravity acts on the object in a rigid, fixed hand: the test of Liu et al. (2021), Table I.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Drop {
    /// Gravity in the object's frame, m/s².
    pub gravity_m_s2: [f64; 3],
    /// Time in which the object comes to rest in the hand before gravity acts, seconds; with 0 gravity acts at once. An
    /// overlap presses like a spring, but the engine needs about 0.15 s to find the forces, in which an object falls by a
    /// hand's breadth.
    pub settle_s: f64,
    /// Number of time steps under gravity.
    pub steps: usize,
    /// Distance by which the centre of mass of a fallen object has sunk, metres.
    pub fall_m: f64,
    /// Criterion by which an object at rest is held before the last step.
    pub rest: Rest,
    /// Coefficient of Coulomb friction between hand and object.
    pub friction: f64,
    /// The engine.
    pub solver: Solver,
}

impl Default for Drop {
    /// Gravity 10 m/s² down the object's z axis, 1000 steps of 1/60 s, a fall of 0.3 m, and `PyBullet`'s default friction:
    /// 0.5 for each body, which Bullet multiplies to 0.25. The publication does not say how the object is put into the hand; here
    /// it comes to rest within a second without gravity.
    fn default() -> Self {
        Self {
            gravity_m_s2: [0.0, 0.0, -10.0],
            settle_s: 1.0,
            steps: 1000,
            fall_m: 0.3,
            rest: Rest::default(),
            friction: 0.25,
            solver: Solver::default(),
        }
    }
}

/// How the hand closes before the test and holds the object during it.
///
/// A spring with damping and limited torque drives each joint to a target. The target differs from the grasp's angle by
/// Jᵀf/k: the torques of contact forces f that balance each other (`closure::contact_forces` at the protocol's friction),
/// divided by the stiffness k. If no forces balance, all contacts press equally along their inward normals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Squeeze {
    /// Mean contact force, newtons.
    pub force_n: f64,
    /// Stiffness of the joints, N·m/rad.
    pub stiffness_n_m: f64,
    /// Damping of the joints, N·m·s/rad.
    pub damping_n_m_s: f64,
    /// Largest torque of a joint, N·m.
    pub torque_limit_n_m: f64,
}

impl Squeeze {
    /// Time in which the targets move and the hand comes to rest, seconds; a rigid hand waits for the same time. As in
    /// `DexGraspBench`.
    pub const TIME_S: f64 = 0.4;
    /// Density of the hand, kg/m³: that of water, and so about that of flesh.
    pub const DENSITY_KG_M3: f64 = 1000.0;
    /// Inertia of each joint itself, kg·m², due to its motor or tendons: that of the Shadow hand in `MuJoCo` Menagerie.
    pub const ARMATURE_KG_M2: f64 = 2e-4;
}

impl Default for Squeeze {
    /// Gains of `DexGraspBench`: kp = 5 with limits of ±3. The force is ours, because there the grasps include their squeezed
    /// poses.
    fn default() -> Self {
        Self {
            force_n: 4.0,
            stiffness_n_m: 5.0,
            damping_n_m_s: 0.1,
            torque_limit_n_m: 3.0,
        }
    }
}

/// The object is pushed along ±x, ±y and ±z in turn, without gravity; after `DexGraspBench` (Chen et al. 2025).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SixDirections {
    /// Mass of the object, kg.
    pub mass_kg: f64,
    /// Force at the centre of mass, newtons.
    pub force_n: f64,
    /// Duration of each push, seconds.
    pub push_s: f64,
    /// The grasp fails if the object's centre of mass moves this far, metres …
    pub displacement_m: f64,
    /// … or the object turns this much, radians.
    pub turn_rad: f64,
    /// Criterion by which an object at rest withstands a push before its time is over.
    pub rest: Rest,
    /// Whether the hand and its joints are rigid instead of squeezing.
    pub rigid: bool,
    /// How the hand closes and holds the object, unless it is rigid.
    pub squeeze: Squeeze,
    /// Coefficient of Coulomb friction between hand and object.
    pub friction: f64,
    /// The engine.
    pub solver: Solver,
}

impl Default for SixDirections {
    /// 0.1 kg, 1 N for 2 s each, limits of 5 cm and 15°, friction 0.6.
    fn default() -> Self {
        Self {
            mass_kg: 0.1,
            force_n: 1.0,
            push_s: 2.0,
            displacement_m: 0.05,
            turn_rad: 15.0_f64.to_radians(),
            rest: Rest::default(),
            rigid: false,
            squeeze: Squeeze::default(),
            friction: 0.6,
            solver: Solver {
                time_step_s: 0.004,
                substeps: 2,
            },
        }
    }
}

impl SixDirections {
    /// The same without the squeeze: the hand and its joints are rigid.
    pub fn rigid() -> Self {
        Self {
            rigid: true,
            ..Self::default()
        }
    }
}

/// A test of stability with all its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "protocol", rename_all = "kebab-case")]
pub enum Protocol {
    /// Gravity on an object in a rigid hand.
    Drop(Drop),
    /// Pushes along six directions.
    SixDirections(SixDirections),
}

impl Protocol {
    /// Checks all values; the error is one clear sentence on the first invalid value.
    ///
    /// # Errors
    /// If a size, time or coefficient is out of its range.
    pub fn validate(&self) -> Result<(), ProtocolError> {
        let mut positive: Vec<(&'static str, f64)> = Vec::new();
        let mut others: Vec<(&'static str, Limit, f64)> = Vec::new();
        let (friction, solver, steps) = match self {
            Self::Drop(drop) => {
                positive.push(("fall_m", drop.fall_m));
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
                    ("force_n", six.force_n),
                ]);
                let squeeze = &six.squeeze;
                positive.extend([
                    ("squeeze.force_n", squeeze.force_n),
                    ("squeeze.stiffness_n_m", squeeze.stiffness_n_m),
                    ("squeeze.damping_n_m_s", squeeze.damping_n_m_s),
                    ("squeeze.torque_limit_n_m", squeeze.torque_limit_n_m),
                ]);
                let time_s = Squeeze::TIME_S + 6.0 * six.push_s;
                (six.friction, six.solver, time_s / six.solver.time_step_s)
            }
        };
        let divided = solver.substeps as f64 * Solver::SWEEPS as f64;
        others.extend([
            ("friction", SIMULATION_OR_ZERO, friction),
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
}

/// A value of a protocol out of its range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} = {beyond}")]
pub struct ProtocolError {
    name: &'static str,
    beyond: Beyond,
}

/// How many steps a time takes.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a time over a time step, both checked to be positive"
)]
pub(super) fn count(time_s: f64, step_s: f64) -> usize {
    (time_s / step_s).round() as usize
}
