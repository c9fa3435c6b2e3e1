//! Assumptions of a simulation and criteria of stability. Every value is written into the files of judged grasps.

use serde::{Deserialize, Serialize};

use super::load_test::LoadTest;
use super::named::named;
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

impl Rest {
    /// That of an object under a load in a hand of springs, which creeps longer: 0.1 mm in a tenth of a second. At that speed
    /// it would move by 2 mm in a push of 2 s. When 164 grasps of 14 random objects, of which 21 fail at friction 0.25 or
    /// 0.3, were simulated to the last step, none changed its outcome, and the largest further motion was 0.7 mm; a fifth
    /// to a half of the time is enough.
    pub(super) fn under_load() -> Self {
        Self {
            way_m: 1e-4,
            time_s: 0.1,
        }
    }
}

/// Gravity acts on the object in a rigid, fixed hand: the test of Liu et al. (2021), Table I.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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
    #[serde(default)]
    pub rest: Rest,
    /// Coefficient of Coulomb friction between hand and object.
    pub friction: f64,
    /// The engine.
    pub solver: Solver,
}

impl Default for Drop {
    /// The published test, as [`named`] has it.
    fn default() -> Self {
        match named("drop") {
            Some(Protocol::Drop(drop)) => drop,
            _ => unreachable!("`drop` is a drop test"),
        }
    }
}

impl Default for LoadTest {
    /// The test in use today: `dexgraspbench`, as [`named`] has it.
    fn default() -> Self {
        match named("dexgraspbench") {
            Some(Protocol::Loads(test)) => test,
            _ => unreachable!("`dexgraspbench` has loads"),
        }
    }
}

/// A test of stability with all its settings. What is read may leave out numbers: they are those of the published test that
/// it names (`protocol = "…"`).
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "protocol")]
pub enum Protocol {
    /// Gravity on an object in a rigid hand.
    #[serde(rename = "drop")]
    Drop(Drop),
    /// Loads on an object in a hand that closes.
    #[serde(untagged)]
    Loads(LoadTest),
}

impl Protocol {
    /// Checks all values; the error is one clear sentence on the first invalid value.
    ///
    /// # Errors
    /// If a size, time or coefficient is out of its range, or two settings contradict each other.
    pub fn validate(&self) -> Result<(), ProtocolError> {
        let drop = match self {
            Self::Drop(drop) => drop,
            Self::Loads(test) => return test.check(),
        };
        let mut checks = Checks::default();
        checks.add("fall_m", SIMULATION, drop.fall_m);
        for gravity in drop.gravity_m_s2 {
            checks.add("gravity_m_s2", SIMULATION_OR_ZERO, gravity.abs());
        }
        checks.add("settle_s", SIMULATION_OR_ZERO, drop.settle_s);
        let squared: f64 = drop.gravity_m_s2.iter().map(|g| g * g).sum();
        checks.add("the square of gravity_m_s2", SIMULATION, squared);
        checks.add("friction", SIMULATION_OR_ZERO, drop.friction);
        let settling = drop.settle_s / drop.solver.time_step_s;
        checks.add_steps(&drop.solver, settling + drop.steps as f64);
        checks.made()
    }
}

/// Values with their ranges.
#[derive(Debug, Default)]
pub(super) struct Checks(Vec<(&'static str, Limit, f64)>);

impl Checks {
    pub(super) fn add(&mut self, name: &'static str, limit: Limit, value: f64) {
        self.0.push((name, limit, value));
    }

    pub(super) fn add_steps(&mut self, solver: &Solver, steps: f64) {
        let divided = solver.substeps as f64 * Solver::SWEEPS as f64;
        let name = "steps, substeps and sweeps";
        self.add(name, SIMULATION_STEPS, steps * divided);
    }

    /// The first value that is out of its range.
    pub(super) fn made(self) -> Result<(), ProtocolError> {
        self.0.into_iter().try_for_each(|(name, limit, value)| {
            let out = |beyond| ProtocolError::Range { name, beyond };
            limit.check(value).map_err(out)
        })
    }
}

/// Reason why a protocol cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProtocolError {
    /// A value is out of its range.
    #[error("{name} = {beyond}")]
    Range {
        /// The value.
        name: &'static str,
        /// Its range.
        beyond: Beyond,
    },
    /// The mass is given twice.
    #[error("mass_kg and density_kg_m3 both give the mass of the object: leave one of them out")]
    MassAndDensity,
    /// Every grasp would hold.
    #[error(
        "nothing can fail: set criterion.displacement_m or criterion.turn_rad, or set criterion.contact to \"hand\" or \"digits\""
    )]
    NoCriterion,
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
