//! Contacts without a hand, and a judgement of them.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::grasp::closure::{
    EpsilonSettings, LARGEST_FRICTION, PointContact, contact_forces, epsilon,
    grasp_matrix_rank_margin, is_force_closure, least_friction, net_wrench,
};
use crate::grasp::filter::STRICT_FRICTION;
use crate::limits::MOST_CONTACTS;

/// Longer arms, in units of the length, indicate a mistake in units. Their torques would swamp the forces by rounding.
const LONGEST_ARM: f64 = 1e4;

/// Contacts as a file gives them; `landscape inspect --help` describes the format (JSON). Lengths are in any one unit.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GivenContacts {
    /// The contacts.
    pub contacts: Vec<GivenContact>,
    /// Point about which torques are taken; by default the mean of the positions.
    pub centre: Option<[f64; 3]>,
    /// Length by which arms are divided; by default the longest arm.
    pub length: Option<f64>,
    /// Friction coefficient; by default 0.5.
    pub friction: Option<f64>,
}

/// One contact.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename = "FileContact")]
pub struct GivenContact {
    /// Its position.
    pub position: [f64; 3],
    /// Direction into the object, of any length.
    pub inward_normal: [f64; 3],
}

/// Reason why contacts cannot be judged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ContactsError {
    /// There are none.
    #[error("it has no contacts")]
    None,
    /// There are more than a grasp has.
    #[error(
        "it has {0} contacts, but at most {MOST_CONTACTS} are allowed: give those of one grasp"
    )]
    TooMany(usize),
    /// A distance overflows.
    #[error("positions and centre are too far apart to compute with")]
    TooFar,
    /// The length is not positive.
    #[error("\"length\" is {0}: a positive number is needed")]
    Length(f64),
    /// No length is given, and all arms are zero.
    #[error("all contacts lie in the centre: give a \"length\"")]
    NoLength,
    /// An arm is much longer than the length.
    #[error(
        "\"length\" is {length:e}, and contact {index} lies more than {LONGEST_ARM} lengths from the centre: are \
         they in the same unit?"
    )]
    Unit {
        /// The length.
        length: f64,
        /// Index of the contact.
        index: usize,
    },
    /// The friction coefficient is out of its range.
    #[error("\"friction\" is {0:?}: a number from 0 to {LARGEST_FRICTION} is needed")]
    Friction(f64),
    /// A normal is zero.
    #[error("contacts[{0}].inward_normal is zero: a direction is needed")]
    Normal(usize),
}

/// Judgement of contacts. Arms are divided by the length, so wrenches are dimensionless.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ContactsReport {
    /// Number of contacts.
    pub contacts: usize,
    /// Point about which torques are taken.
    pub centre: [f64; 3],
    /// Length by which arms are divided.
    pub length: f64,
    /// Friction coefficient of force closure, forces and ε.
    pub friction: f64,
    /// Wrench that remains when all contacts push equally along their normals, `|Gc|`.
    pub net_wrench: f64,
    /// Least eigenvalue of `GGᵀ`.
    pub rank_margin: f64,
    /// Least friction coefficient at which forces balance; absent if none suffices.
    pub least_friction: Option<f64>,
    /// Whether the contacts resist any wrench.
    pub force_closure: bool,
    /// Ferrari–Canny ε.
    pub epsilon: f64,
    /// Direction of the wrench that the contacts resist least.
    pub weakest_wrench: [f64; 6],
    /// Absent if no forces balance at this friction.
    pub forces: Option<BalancingForces>,
}

/// Forces that balance, as far inside the cones of friction as possible.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BalancingForces {
    /// One force for each contact. The normal components add up to one.
    #[serde(rename = "forces")]
    pub vectors: Vec<[f64; 3]>,
    /// Their normal components.
    pub normal: Vec<f64>,
    /// Sizes of their tangential components.
    pub tangential: Vec<f64>,
    /// Wrench that remains.
    pub residual: f64,
    /// Greatest violation of a cone.
    pub violation: f64,
}

/// Valid contacts.
struct Contacts {
    points: Vec<PointContact>,
    centre: Vector3<f64>,
    length: f64,
    friction: f64,
}

impl GivenContacts {
    /// Judges the contacts.
    ///
    /// # Errors
    /// If there are none or too many, or a number is out of its range.
    pub fn judge(&self) -> Result<ContactsReport, ContactsError> {
        Ok(self.check()?.judge())
    }

    fn check(&self) -> Result<Contacts, ContactsError> {
        let count = self.contacts.len();
        match count {
            0 => return Err(ContactsError::None),
            1..=MOST_CONTACTS => {}
            _ => return Err(ContactsError::TooMany(count)),
        }
        let positions = || self.contacts.iter().map(|c| Vector3::from(c.position));
        let centre = match self.centre {
            Some(centre) => Vector3::from(centre),
            None => positions().sum::<Vector3<f64>>() / count as f64,
        };
        let distances = || positions().map(|position| (position - centre).norm());
        let longest = distances().fold(0.0, f64::max);
        if !longest.is_finite() {
            return Err(ContactsError::TooFar);
        }
        let length = self.length.unwrap_or(longest);
        if length.is_nan() || length <= 0.0 {
            return Err(self
                .length
                .map_or(ContactsError::NoLength, ContactsError::Length));
        }
        if let Some(index) = distances().position(|distance| distance > LONGEST_ARM * length) {
            return Err(ContactsError::Unit { length, index });
        }
        let friction = self.friction.unwrap_or(STRICT_FRICTION);
        if !(0.0..=LARGEST_FRICTION).contains(&friction) {
            return Err(ContactsError::Friction(friction));
        }
        let contact = |(index, contact): (usize, &GivenContact)| {
            let normal = Vector3::from(contact.inward_normal);
            // Dividing by the largest component first keeps the squares from overflowing or vanishing.
            let largest = normal.amax();
            let inward_normal = (normal / largest).normalize();
            let arm = (Vector3::from(contact.position) - centre) / length;
            (largest > 0.0)
                .then_some(PointContact { arm, inward_normal })
                .ok_or(ContactsError::Normal(index))
        };
        let contacts = self.contacts.iter().enumerate().map(contact);
        Ok(Contacts {
            points: contacts.collect::<Result<_, _>>()?,
            centre,
            length,
            friction,
        })
    }
}

impl Contacts {
    fn judge(&self) -> ContactsReport {
        let (contacts, friction) = (&self.points, self.friction);
        let least = least_friction(contacts);
        let resisted = epsilon(
            contacts,
            &EpsilonSettings {
                friction,
                ..EpsilonSettings::default()
            },
        );
        let forces = contact_forces(contacts, friction).map(|found| {
            let normal: Vec<f64> = contacts
                .iter()
                .zip(&found.forces)
                .map(|(contact, force)| contact.inward_normal.dot(force))
                .collect();
            let tangential = contacts
                .iter()
                .zip(&found.forces)
                .map(|(contact, force)| contact.inward_normal.cross(force).norm());
            BalancingForces {
                tangential: tangential.collect(),
                normal,
                vectors: found.forces.iter().map(|force| (*force).into()).collect(),
                residual: found.residual,
                violation: found.violation,
            }
        });
        ContactsReport {
            contacts: contacts.len(),
            centre: self.centre.into(),
            length: self.length,
            friction,
            net_wrench: net_wrench(contacts),
            rank_margin: grasp_matrix_rank_margin(contacts),
            least_friction: least.is_finite().then_some(least),
            force_closure: is_force_closure(contacts, friction),
            epsilon: resisted.value,
            weakest_wrench: resisted.weakest.into(),
            forces,
        }
    }
}
