//! Contacts without a hand, from a JSON file.

use std::fmt::Write;

use anyhow::{Context, bail, ensure};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{number, table, yes};
use crate::grasp::closure::{
    EpsilonSettings, LARGEST_FRICTION, PointContact, RANK_EPSILON, contact_forces, epsilon,
    grasp_matrix_rank_margin, is_force_closure, least_friction, net_wrench,
};
use crate::grasp::filter::STRICT_FRICTION;
use crate::limits::MOST_CONTACTS;

/// Longer arms, in units of the length, indicate a mistake in units. Their torques would swamp the forces by rounding.
const LONGEST_ARM: f64 = 1e4;

/// Content of the file. `landscape inspect --help` describes the format.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    contacts: Vec<FileContact>,
    centre: Option<[f64; 3]>,
    length: Option<f64>,
    friction: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileContact {
    position: [f64; 3],
    inward_normal: [f64; 3],
}

/// Valid contacts.
#[derive(Debug)]
pub(super) struct Contacts {
    points: Vec<PointContact>,
    centre: Vector3<f64>,
    length: f64,
    friction: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct Report {
    contacts: usize,
    centre: [f64; 3],
    length: f64,
    friction: f64,
    net_wrench: f64,
    rank_margin: f64,
    /// Absent if no friction suffices.
    least_friction: Option<f64>,
    force_closure: bool,
    epsilon: f64,
    weakest_wrench: [f64; 6],
    /// Absent if no forces balance at this friction.
    forces: Option<Forces>,
}

#[derive(Debug, Serialize)]
struct Forces {
    /// The normal components add up to one.
    #[serde(rename = "forces")]
    vectors: Vec<[f64; 3]>,
    normal: Vec<f64>,
    tangential: Vec<f64>,
    residual: f64,
    violation: f64,
}

/// Parses the file; an error names the wrong field.
fn parse(bytes: &[u8]) -> anyhow::Result<File> {
    const NO_CONTACTS: &str = "these are no contacts (see `landscape inspect --help`)";
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let file = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let place = error.path().to_string();
        let cause = anyhow::Error::new(error.into_inner());
        if place == "." {
            cause.context(NO_CONTACTS)
        } else {
            cause.context(place).context(NO_CONTACTS)
        }
    })?;
    json.end().context(NO_CONTACTS)?;
    Ok(file)
}

impl Contacts {
    pub(super) fn read(bytes: &[u8]) -> anyhow::Result<Self> {
        let file = parse(bytes)?;
        ensure!(!file.contacts.is_empty(), "there are no contacts in it");
        ensure!(
            file.contacts.len() <= MOST_CONTACTS,
            "there are {} contacts in it, but at most {MOST_CONTACTS} are allowed: give those of one grasp",
            file.contacts.len()
        );
        let count = file.contacts.len() as f64;
        let positions = || file.contacts.iter().map(|c| Vector3::from(c.position));
        let centre = match file.centre {
            Some(centre) => Vector3::from(centre),
            None => positions().sum::<Vector3<f64>>() / count,
        };
        let distances = || positions().map(|position| (position - centre).norm());
        let longest = distances().fold(0.0, f64::max);
        ensure!(
            longest.is_finite(),
            "positions and centre are too far apart to compute with"
        );
        let length = file.length.unwrap_or(longest);
        ensure!(
            length > 0.0,
            match file.length {
                Some(length) => format!("\"length\" is {length}: a positive number is needed"),
                None => "all contacts lie in the centre: give a \"length\"".to_owned(),
            }
        );
        if let Some(index) = distances().position(|distance| distance > LONGEST_ARM * length) {
            bail!(
                "\"length\" is {length:e}, and contact {index} lies more than {LONGEST_ARM} lengths from the centre: are \
                 they in the same unit?"
            );
        }
        let friction = file.friction.unwrap_or(STRICT_FRICTION);
        ensure!(
            (0.0..=LARGEST_FRICTION).contains(&friction),
            "\"friction\" is {friction:?}: a number from 0 to {LARGEST_FRICTION} is needed"
        );
        let contact = |(index, contact): (usize, &FileContact)| {
            let normal = Vector3::from(contact.inward_normal);
            // Dividing by the largest component first keeps the squares from overflowing or vanishing.
            let largest = normal.amax();
            ensure!(
                largest > 0.0,
                "contacts[{index}].inward_normal is zero: a direction is needed"
            );
            let inward_normal = (normal / largest).normalize();
            Ok(PointContact {
                arm: (Vector3::from(contact.position) - centre) / length,
                inward_normal,
            })
        };
        let contacts = file.contacts.iter().enumerate().map(contact);
        Ok(Self {
            points: contacts.collect::<anyhow::Result<_>>()?,
            centre,
            length,
            friction,
        })
    }

    pub(super) fn judge(&self) -> Report {
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
            Forces {
                tangential: tangential.collect(),
                normal,
                vectors: found.forces.iter().map(|force| (*force).into()).collect(),
                residual: found.residual,
                violation: found.violation,
            }
        });
        Report {
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

impl Report {
    pub(super) fn text(&self) -> String {
        let friction = self.friction;
        let vector = |values: &[f64]| {
            values
                .iter()
                .map(|v| number(*v))
                .collect::<Vec<_>>()
                .join("  ")
        };
        let net_wrench = format!(
            "{}   {} 0.5 of the relaxed test",
            number(self.net_wrench),
            if self.net_wrench < 0.5 {
                "below the"
            } else {
                "not below the"
            }
        );
        let rank = format!(
            "{}   {}",
            number(self.rank_margin),
            if self.rank_margin > RANK_EPSILON {
                "all wrenches are spanned"
            } else {
                "some wrench is out of reach, whatever the friction"
            }
        );
        let lines = [
            ("contacts", self.contacts.to_string()),
            ("centre of torques", vector(&self.centre)),
            ("length of arms", number(self.length)),
            ("", String::new()),
            ("|Gc|", net_wrench),
            ("least eigenvalue of GGᵀ", rank),
            (
                "least friction",
                number(self.least_friction.unwrap_or(f64::INFINITY)),
            ),
            ("", String::new()),
            ("at friction", number(friction)),
            ("  force closure", yes(self.force_closure).to_owned()),
            ("  epsilon", number(self.epsilon)),
            ("  weakest against force", vector(&self.weakest_wrench[..3])),
            (
                "              and torque",
                vector(&self.weakest_wrench[3..]),
            ),
        ];
        let mut text = String::new();
        for (what, value) in lines {
            let _ = writeln!(text, "{}", format!("{what:<26} {value}").trim_end());
        }
        text.push('\n');
        let Some(forces) = &self.forces else {
            let _ = writeln!(text, "no forces balance at friction {}", number(friction));
            return text;
        };
        let header = [
            "contact",
            "normal",
            "sideways",
            "share of limit",
            "force x",
            "y",
            "z",
        ];
        let mut rows = vec![header.map(str::to_owned).to_vec()];
        for (index, force) in forces.vectors.iter().enumerate() {
            let (normal, tangential) = (forces.normal[index], forces.tangential[index]);
            let limit = friction * normal;
            let share = if limit > 0.0 {
                format!("{:.0} %", 100.0 * tangential / limit)
            } else {
                "-".to_owned()
            };
            let mut row = vec![index.to_string(), number(normal), number(tangential), share];
            row.extend(force.map(number));
            rows.push(row);
        }
        let _ = writeln!(
            text,
            "forces that balance, as far inside the cones as possible (normal forces add up to one)"
        );
        text.push_str(&table(&rows));
        text
    }
}
