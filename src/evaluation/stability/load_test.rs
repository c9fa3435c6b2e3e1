//! Settings of tests in which loads act on the object: how the hand closes, what acts, and what must hold.

use serde::{Deserialize, Serialize};

use super::settings::{Checks, ProtocolError, Rest, Solver, count};
use super::solid::Solid;
use crate::limits::{SIMULATION, SIMULATION_OR_ZERO, SIMULATION_STEPS};

/// A hand closes on the object, and loads act on the object then.
///
/// The published ones are data files, see [`NAMED`](super::NAMED).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadTest {
    /// The published test that gives the numbers that a file does not set.
    pub protocol: String,
    /// Mass of the object, kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Density of the object instead of its mass, kg/m³. Without either it has its own mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density_kg_m3: Option<f64>,
    /// Damping of the object's velocity, 1/s: each step of h seconds divides it by 1 + h · damping. None is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub linear_damping_per_s: Option<f64>,
    /// Damping of the object's angular velocity, 1/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angular_damping_per_s: Option<f64>,
    /// Coefficient of Coulomb friction between hand and object.
    pub friction: f64,
    /// The engine.
    pub solver: Solver,
    /// Criterion by which an object at rest withstands a load before its time is over.
    #[serde(default = "Rest::under_load")]
    pub rest: Rest,
    /// How the hand closes and holds the object.
    pub closing: Closing,
    /// What acts on the object.
    pub loads: Loads,
    /// What must hold.
    pub criterion: Criterion,
}

/// Where the hand closes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ClosingRule {
    /// The hand and its joints are rigid.
    #[default]
    None,
    /// The target differs from the grasp's coordinate by Jᵀf/k: the torques of contact forces f that balance each other
    /// (`closure::contact_forces` at the test's friction), divided by the stiffness k. If no forces balance, all contacts
    /// press equally along their inward normals.
    Squeeze,
    /// The squeezed joints of the grasp's file; as [`ClosingRule::Squeeze`] if it has none.
    Given,
    /// Of `DexGraspNet`: on each link the skin point deepest in the object, or nearest to it within 1 mm, is to move along the
    /// object's inward unit normal n: the target is the coordinate moved by Jᵀn (radians).
    Inwards,
    /// Of `GenDexGrasp`: skin within 5 mm of the object is to move along its own outward normal n. The target of every joint
    /// with Jᵀn ≠ 0, summed over this skin, is half a radian farther in that direction.
    Step,
    /// Of `GraspDataGen`: the target of each joint is the limit at which it is closed. Its direction is that of Jᵀn, summed over
    /// the skin point nearest to the object of each link, with n the object's inward normal there. Joints that move these
    /// points more across n than along it keep their coordinate, and so do joints without limits.
    Closed,
}

impl ClosingRule {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Squeeze => "squeeze",
            Self::Given => "given",
            Self::Inwards => "inwards",
            Self::Step => "step",
            Self::Closed => "closed",
        }
    }
}

/// How the hand closes before the loads and holds the object under them: a spring with damping and limited torque drives
/// each joint to the target of a [`ClosingRule`]. The stiffness of a slide is that of a hinge at the lever of
/// [`JointKind::radians_per_unit`](crate::hand::JointKind::radians_per_unit).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Closing {
    /// Where to.
    pub rule: ClosingRule,
    /// Time before the first load, seconds; a rigid hand waits for the same time.
    pub seconds: f64,
    /// Mean contact force of [`ClosingRule::Squeeze`], newtons.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_n: Option<f64>,
    /// Stiffness of the joints, N·m/rad.
    pub stiffness_n_m: f64,
    /// Damping of the joints, N·m·s/rad.
    pub damping_n_m_s: f64,
    /// Largest torque of a joint, N·m.
    pub torque_limit_n_m: f64,
}

impl Closing {
    /// Density of the hand, kg/m³: that of water, and so about that of flesh.
    pub const DENSITY_KG_M3: f64 = 1000.0;
    /// Inertia of each joint itself, kg·m², due to its motor or tendons: that of the Shadow hand in `MuJoCo` Menagerie.
    pub const ARMATURE_KG_M2: f64 = 2e-4;
    /// The mean contact force where a test names none, newtons.
    pub(super) const USUAL_FORCE_N: f64 = 4.0;
}

/// The axes of directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axes {
    /// Those of the object.
    #[default]
    Object,
    /// z is the normal out of the palm, x points to the fingertips, and y = z × x.
    Palm,
}

/// How many trials must hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Needed {
    /// All.
    All,
    /// At least half.
    Half,
    /// At least one.
    Any,
}

impl Needed {
    /// The number that must hold of `trials`.
    pub(super) fn of(self, trials: usize) -> usize {
        match self {
            Self::All => trials,
            Self::Half => trials.div_ceil(2),
            Self::Any => 1,
        }
    }
}

/// Loads on the object. A trial begins with the closed hand and consists of one or more loads that follow each other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Loads {
    /// Directions of any length.
    pub directions: Vec<[f64; 3]>,
    /// The axes of the directions as the grasp is in its file.
    #[serde(default)]
    pub frame: Axes,
    /// Force at the centre of mass over the object's mass, m/s².
    pub acceleration_m_s2: f64,
    /// Duration of each load, seconds.
    pub seconds: f64,
    /// Number of loads that make a trial.
    pub together: usize,
    /// Time without load between the loads of a trial, seconds.
    #[serde(default)]
    pub pause_s: f64,
    /// How many trials must hold.
    pub needed: Needed,
}

/// Where motions of the object are measured from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MeasuredFrom {
    /// Its pose in the file, so that its motion while the hand closes counts.
    File,
    /// Its pose when the hand has closed.
    Closed,
    /// Its pose at the beginning of each load.
    Load,
}

/// What must press on the object at the end of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EndContact {
    /// Nothing.
    None,
    /// Any part of the hand.
    Hand,
    /// At least two digits.
    Digits,
}

/// What a trial must fulfil.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Criterion {
    /// A trial fails if the object's centre of mass moves this far, metres …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displacement_m: Option<f64>,
    /// … or the object turns this much, radians.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn_rad: Option<f64>,
    /// Where from.
    pub measured_from: MeasuredFrom,
    /// What must press at the end.
    pub contact: EndContact,
}

impl LoadTest {
    /// The object's mass in this test, kg; `own_kg` is that of its description.
    pub fn mass_kg(&self, solid: &Solid, own_kg: f64) -> f64 {
        let of_density = self
            .density_kg_m3
            .map(|density| density * solid.volume_m3());
        self.mass_kg.or(of_density).unwrap_or(own_kg)
    }

    pub(super) fn check(&self) -> Result<(), ProtocolError> {
        let Self {
            closing,
            loads,
            criterion,
            ..
        } = self;
        let mut checks = Checks::default();
        for (name, value) in [
            ("mass_kg", self.mass_kg),
            ("density_kg_m3", self.density_kg_m3),
            ("linear_damping_per_s", self.linear_damping_per_s),
            ("angular_damping_per_s", self.angular_damping_per_s),
            ("closing.force_n", closing.force_n),
            ("closing.stiffness_n_m", Some(closing.stiffness_n_m)),
            ("closing.torque_limit_n_m", Some(closing.torque_limit_n_m)),
            ("loads.acceleration_m_s2", Some(loads.acceleration_m_s2)),
            ("loads.seconds", Some(loads.seconds)),
            ("criterion.displacement_m", criterion.displacement_m),
            ("criterion.turn_rad", criterion.turn_rad),
        ] {
            if let Some(value) = value {
                checks.add(name, SIMULATION, value);
            }
        }
        for (name, value) in [
            ("friction", self.friction),
            ("closing.seconds", closing.seconds),
            ("closing.damping_n_m_s", closing.damping_n_m_s),
            ("loads.pause_s", loads.pause_s),
        ] {
            checks.add(name, SIMULATION_OR_ZERO, value);
        }
        for direction in &loads.directions {
            let length = direction.iter().map(|part| part * part).sum::<f64>().sqrt();
            checks.add("the length of each of loads.directions", SIMULATION, length);
        }
        let number = loads.directions.len() as f64;
        checks.add("the number of loads.directions", SIMULATION_STEPS, number);
        checks.add("loads.together", SIMULATION_STEPS, loads.together as f64);
        let time_s = closing.seconds + number * (loads.seconds + loads.pause_s);
        checks.add_steps(&self.solver, time_s / self.solver.time_step_s);
        checks.made()?;
        if self.mass_kg.is_some() && self.density_kg_m3.is_some() {
            return Err(ProtocolError::MassAndDensity);
        }
        if criterion.displacement_m.is_none()
            && criterion.turn_rad.is_none()
            && criterion.contact == EndContact::None
        {
            return Err(ProtocolError::NoCriterion);
        }
        Ok(())
    }

    /// The steps of some seconds.
    pub(super) fn steps(&self, seconds: f64) -> usize {
        count(seconds, self.solver.time_step_s)
    }
}
