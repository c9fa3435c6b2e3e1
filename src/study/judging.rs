//! The grasps of a file, judged anew on the exact mesh.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use serde::Serialize;

use crate::evaluation::HandUse;
use crate::evaluation::taxonomy::{Anatomy, Inapplicable};
use crate::grasp::closure::{PointContact, contact_forces};
use crate::grasp::filter::{MOST_GAP_M, STRICT_FRICTION};
use crate::grasp::{GraspEnergy, Judgement, MeasuredContact, judge, measure_contacts};
use crate::hand::Hand;
use crate::store::{GraspRow, Population};

/// A row of a file and its judgement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedGrasp {
    /// Unique in the file.
    pub id: u64,
    /// Name of the hand.
    pub hand: String,
    /// Name of the object.
    pub object: String,
    /// Factor on the object's size.
    pub scale: f64,
    /// The word of a human, else that of the rule.
    pub label: Option<String>,
    /// Energy that the file tells.
    pub energy: f64,
    /// Terms that the file tells, by name.
    pub terms: BTreeMap<String, f64>,
    /// The judgement.
    #[serde(flatten)]
    pub judgement: Judgement,
    /// Whether it passes Eq. 11 as printed.
    pub passes_published: bool,
    /// Whether it passes Eq. 11 as the authors' code has it.
    pub passes_released: bool,
    /// First reason why the strict filter refuses it.
    pub objection: Option<&'static str>,
    /// How it uses the hand; unknown if the hand is not built like a human one or does not touch.
    pub hand_use: Option<HandUse>,
    /// Contacts on the exact mesh.
    pub contacts: Vec<JudgedContact>,
}

/// A contact on the exact mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedContact {
    /// Index of the hand's surface point.
    pub surface_point: u32,
    /// Name of its link.
    pub link: String,
    /// Name of its digit.
    pub digit: String,
    /// Signed distance from the mesh, metres; negative inside.
    pub distance_m: f64,
    /// Its share of the normal force where forces balance as far inside the cones of friction 0.5 as possible; `None` if none do.
    pub force: Option<f64>,
}

/// Judges the given rows of a population, whose energy is given; `judged` is called after each, from any thread.
///
/// # Panics
/// If a grasp is one of another hand.
pub fn judge_all(
    energy: &GraspEnergy,
    population: &Population<'_>,
    rows: &[&GraspRow],
    judged: impl Fn() + Sync,
) -> Vec<JudgedGrasp> {
    let anatomy = Anatomy::of(energy.hand()).ok();
    rows.par_iter()
        .map(|row| {
            let found = JudgedGrasp::new(energy, anatomy.as_ref(), population.terms(), row);
            judged();
            found
        })
        .collect()
}

impl JudgedGrasp {
    fn new(
        energy: &GraspEnergy,
        anatomy: Option<&Anatomy>,
        terms: &[String],
        row: &GraspRow,
    ) -> Self {
        let hand = energy.hand();
        let judgement = judge(energy, &row.grasp);
        let measured = measure_contacts(energy, &row.grasp);
        let bare: Vec<PointContact> = measured.iter().map(|found| found.contact).collect();
        let forces = contact_forces(&bare, STRICT_FRICTION);
        let contact = |(index, measured): (usize, &MeasuredContact)| {
            let link = &hand.links[measured.link.0];
            JudgedContact {
                surface_point: measured.surface_point,
                link: link.name.clone(),
                digit: hand.digits[link.digit].clone(),
                distance_m: measured.distance_m,
                force: forces
                    .as_ref()
                    .map(|found| found.forces[index].dot(&bare[index].inward_normal)),
            }
        };
        Self {
            id: row.id,
            hand: row.hand.clone(),
            object: row.object.clone(),
            scale: row.scale,
            label: row.label.clone().or_else(|| row.label_auto.clone()),
            energy: row.energy,
            terms: terms
                .iter()
                .cloned()
                .zip(row.terms.iter().copied())
                .collect(),
            passes_published: judgement.passes_published(),
            passes_released: judgement.passes_released(),
            objection: judgement.strict_objection(),
            judgement,
            hand_use: anatomy
                .and_then(|anatomy| HandUse::of(hand, anatomy, energy.object(), &row.grasp.pose)),
            contacts: measured.iter().enumerate().map(contact).collect(),
        }
    }
}

/// Numbers of the grasps of a hand on an object that pass the filters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedPopulation {
    /// Name of the hand.
    pub hand: String,
    /// Name of the object.
    pub object: String,
    /// Factor on the object's size.
    pub scale: f64,
    /// Number of grasps.
    pub grasps: usize,
    /// Number that pass the strict filter.
    pub passes_strict: usize,
    /// Number that pass Eq. 11 as printed.
    pub passes_published: usize,
    /// Number that pass Eq. 11 as the authors' code has it.
    pub passes_released: usize,
    /// Counts of the first failed conditions of the strict filter.
    pub objections: BTreeMap<&'static str, usize>,
    /// By link, number of grasps whose contact set has a point on it that is within [`MOST_GAP_M`] of the mesh.
    pub links_in_contact: BTreeMap<String, usize>,
    /// Why the hand is not measured as a human one, if so.
    pub not_human: Option<String>,
}

impl JudgedPopulation {
    /// Counts the judged grasps of a population; `hand` is its hand.
    pub fn of(population: &Population<'_>, hand: &Hand, judged: &[JudgedGrasp]) -> Self {
        let count =
            |test: fn(&JudgedGrasp) -> bool| judged.iter().filter(|grasp| test(grasp)).count();
        let mut objections = BTreeMap::new();
        let mut links_in_contact = BTreeMap::new();
        for grasp in judged {
            if let Some(reason) = grasp.objection {
                *objections.entry(reason).or_default() += 1;
            }
            let near = |contact: &&JudgedContact| contact.distance_m.abs() <= MOST_GAP_M;
            let contacts = grasp.contacts.iter().filter(near);
            let links: BTreeSet<&String> = contacts.map(|contact| &contact.link).collect();
            for link in links {
                *links_in_contact.entry(link.clone()).or_default() += 1;
            }
        }
        Self {
            hand: population.hand.name.clone(),
            object: population.object.name.clone(),
            scale: population.scale,
            grasps: judged.len(),
            passes_strict: count(|grasp| grasp.objection.is_none()),
            passes_published: count(|grasp| grasp.passes_published),
            passes_released: count(|grasp| grasp.passes_released),
            objections,
            links_in_contact,
            not_human: Anatomy::of(hand)
                .err()
                .map(|why| Inapplicable::Hand(why).words()),
        }
    }
}
