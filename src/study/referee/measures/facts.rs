//! What is measured of each grasp, once, before any set of grasps is measured.

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;
use serde::Serialize;

use crate::evaluation::diversity::TOUCHING_M;
use crate::evaluation::taxonomy::{Category, Inapplicable, Labeller, Rule};
use crate::grasp::closure::{EpsilonSettings, PointContact, epsilon};
use crate::grasp::depth::{deepest_m, object_inside_hand_m};
use crate::grasp::filter::STRICT_FRICTION;
use crate::grasp::{EnergySettings, GraspEnergy, measure_contacts};
use crate::hand::{Hand, PosedHand};
use crate::mesh::Nearest;
use crate::space::{Pose, PoseSpace};
use crate::store::{GraspFile, GraspRow};
use crate::study::error::StudyError;
use crate::study::{MinimumName, Run};
use crate::topography::{Phase, Tally};

/// Distance beyond which a digit counts as this far, and beyond which a link is not in contact for Q1, metres.
const FARTHEST_M: f64 = 0.01;

/// Depth from which on a valid Q1 is zero, metres.
const DEEP_M: f64 = 0.005;

/// The friction cones of the Q1 of the `DexGraspNet` line; arms are in metres about the object's origin.
const Q1_SETTINGS: EpsilonSettings = EpsilonSettings {
    friction: 1.0,
    cone_edges: 8,
    torque_scale: 10.0,
};

/// The quantities of a grasp from which sets are measured.
///
/// Distances are those of the surface points of the hand that may touch, on the exact mesh of the object; depths are those
/// of the exported hand.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GraspFacts {
    /// Unique in the file.
    pub id: u64,
    /// Pose of the hand in the object's frame.
    pub pose: Pose,
    /// Ferrari–Canny ε of the contact set at friction 0.5, as `landscape inspect` has it: arms from the centroid, divided
    /// by the radius of the object; not positive without force closure.
    pub epsilon: f64,
    /// Q1 of the `DexGraspNet` line, 0 to 1: of each link the point that is nearest to the object or deepest in it, if it is
    /// within 1 cm; friction 1, eight edges, torques ×10 a metre about the object's origin, and the wrench zero.
    pub q1: f64,
    /// Greatest depth of a point of the hand in the object or of the object in the hand, metres.
    pub deepest_m: f64,
    /// Greatest depth of a point of the object's surface in the hand, metres.
    pub object_in_hand_m: f64,
    /// Signed distance of each digit without the palm, metres: negative inside, at most 1 cm.
    pub digit_gaps_m: Vec<f64>,
    /// Number of links whose nearest or deepest point is less than 2 mm from the surface, either way.
    pub links_in_contact: usize,
    /// The [contact regions](crate::evaluation::contact_regions), separated by commas.
    pub regions: String,
    /// The type of the GRASP taxonomy: the word of a human, else that of the rule; `None` if there is none.
    pub type_name: Option<String>,
    /// The cell of the taxonomy's table.
    pub cell: Option<String>,
    /// The category.
    pub category: Option<Category>,
}

impl GraspFacts {
    /// Mean over the digits of the distance, 0 inside, metres; `None` if the hand has no digits.
    pub fn contact_distance_m(&self) -> Option<f64> {
        let gaps = &self.digit_gaps_m;
        let sum: f64 = gaps.iter().map(|gap| gap.max(0.0)).sum();
        (!gaps.is_empty()).then(|| sum / gaps.len() as f64)
    }

    /// Difference between the greatest and the least signed distance of a digit, metres; `None` if the hand has no digits.
    pub fn contact_consistency_m(&self) -> Option<f64> {
        let gaps = || self.digit_gaps_m.iter().copied();
        let most = gaps().max_by(f64::total_cmp)?;
        Some(most - gaps().min_by(f64::total_cmp)?)
    }

    /// Number of digits without the palm that are within 2 mm of the object or in it.
    pub fn digits_that_touch(&self) -> usize {
        let gaps = self.digit_gaps_m.iter();
        gaps.filter(|gap| **gap <= TOUCHING_M).count()
    }

    /// [`GraspFacts::q1`], or 0 if the object is 5 mm deep in the hand.
    pub fn valid_q1(&self) -> f64 {
        if self.object_in_hand_m >= DEEP_M {
            0.0
        } else {
            self.q1
        }
    }
}

/// The grasps of one hand on one object at one scale.
#[derive(Debug, Clone)]
pub struct MeasuredObject {
    /// Name of the object.
    pub name: String,
    /// Factor on its size.
    pub scale: f64,
    /// The hand.
    pub hand: Arc<Hand>,
    /// The metric of poses, modulo the symmetry of the object.
    pub space: PoseSpace,
    /// Why no grasp has a type, if the hand is not built like a human one.
    pub inapplicable: Option<String>,
    /// The grasps, in the order of the file.
    pub grasps: Vec<GraspFacts>,
}

/// A set of grasps that is measured.
#[derive(Debug, Clone)]
pub struct MeasuredSet {
    /// The objects.
    pub objects: Vec<MeasuredObject>,
}

impl MeasuredSet {
    /// Measures each grasp of a file, in parallel. Labels given by a human override the rule.
    ///
    /// # Errors
    /// If a hand or an object cannot be built.
    pub fn of(file: &GraspFile, rule: &Rule, run: &Run<'_>) -> Result<Self, StudyError> {
        let tally = run.tally(Phase::Judge, file.grasps.len());
        let mut objects = Vec::new();
        for population in file.landscapes() {
            let (hand, object) = (population.hand()?, population.object()?);
            let energy = GraspEnergy::new(hand, object, EnergySettings::default())?;
            objects.push(MeasuredObject {
                name: population.object.name.clone(),
                scale: population.scale,
                ..MeasuredObject::of(&energy, &population.grasps, rule, &tally)
            });
        }
        Ok(Self { objects })
    }

    /// Number of grasps.
    pub fn grasps(&self) -> usize {
        self.objects.iter().map(|object| object.grasps.len()).sum()
    }
}

impl MeasuredObject {
    /// Measures grasps of the hand on the object of an energy, whose settings do not matter.
    pub(super) fn of(
        energy: &GraspEnergy,
        rows: &[&GraspRow],
        rule: &Rule,
        tally: &Tally<'_>,
    ) -> Self {
        let labeller = Labeller::new(energy.hand(), energy.object(), rule);
        let facts = |row: &&GraspRow| {
            let facts = facts(energy, &labeller, row);
            tally.tick();
            facts
        };
        Self {
            name: energy.object().name.clone(),
            scale: 1.0,
            hand: energy.hand().clone(),
            space: energy.pose_space().clone(),
            inapplicable: labeller.inapplicable().map(Inapplicable::words),
            grasps: rows.par_iter().map(facts).collect(),
        }
    }
}

fn facts(energy: &GraspEnergy, labeller: &Labeller<'_>, row: &GraspRow) -> GraspFacts {
    let (hand, object) = (energy.hand(), energy.object());
    let mut posed = PosedHand::default();
    hand.pose(&row.grasp.pose, &mut posed);
    let contacts = measure_contacts(energy, &row.grasp);
    let contacts: Vec<PointContact> = contacts.iter().map(|found| found.contact).collect();
    let strict = EpsilonSettings {
        friction: STRICT_FRICTION,
        ..EpsilonSettings::default()
    };
    let nearest = Nearby::of(energy, &posed);
    let name = (labeller.inapplicable().is_none()).then(|| {
        let given = row.label.as_deref().filter(|label| !label.is_empty());
        MinimumName::new(given, labeller.label(&row.grasp.pose))
    });
    GraspFacts {
        id: row.id,
        pose: row.grasp.pose.clone(),
        epsilon: epsilon(&contacts, &strict).value,
        q1: nearest.q1(),
        deepest_m: deepest_m(&object.exact, hand, &posed),
        object_in_hand_m: object_inside_hand_m(&object.exact, hand, &posed),
        digit_gaps_m: nearest.digit_gaps_m[1..]
            .iter()
            .flatten()
            .copied()
            .collect(),
        links_in_contact: nearest.links_in_contact(),
        regions: nearest.regions(hand),
        type_name: (name.as_ref())
            .and_then(|name| Some(name.number.map(|_| name.text())?.to_owned())),
        cell: name.as_ref().and_then(|name| name.cell.clone()),
        category: name.and_then(|name| name.category),
    }
}

/// How near the parts of the hand are to the object.
struct Nearby {
    /// Of each link the nearest or deepest point, if it is within [`FARTHEST_M`] or inside.
    links: Vec<Option<Nearest>>,
    /// Signed distance of each digit, the palm first, at most [`FARTHEST_M`]; `None` if none of its points may touch.
    digit_gaps_m: Vec<Option<f64>>,
}

impl Nearby {
    fn of(energy: &GraspEnergy, posed: &PosedHand) -> Self {
        let (hand, object) = (energy.hand(), energy.object());
        let [low, high] = object.mesh.bounds();
        let mut near = Self {
            links: vec![None; hand.links.len()],
            digit_gaps_m: vec![None; hand.digits.len()],
        };
        let points = posed.points.iter().zip(&hand.surface);
        for (place, point) in points.filter(|(_, point)| hand.may_touch(point)) {
            let digit = &mut near.digit_gaps_m[hand.links[point.link.0].digit];
            let gap = digit.get_or_insert(FARTHEST_M);
            let beside = |axis: usize| {
                place[axis] < low[axis] - FARTHEST_M || place[axis] > high[axis] + FARTHEST_M
            };
            if (0..3).any(beside) {
                continue;
            }
            let found = object.exact.nearest(place);
            *gap = gap.min(found.distance_m);
            let link = &mut near.links[point.link.0];
            let nearest = link.as_ref().map_or(FARTHEST_M, |link| link.distance_m);
            if found.distance_m < nearest {
                *link = Some(found);
            }
        }
        near
    }

    /// As [`GraspFacts::q1`].
    ///
    /// With the wrench zero among the wrenches, a facet of their hull goes through the origin unless the others surround it,
    /// so that the least offset is that of the others or 0.
    fn q1(&self) -> f64 {
        let links = self.links.iter().flatten();
        let contact = |found: &Nearest| PointContact {
            arm: found.point,
            inward_normal: -found.normal,
        };
        let contacts: Vec<PointContact> = links.map(contact).collect();
        epsilon(&contacts, &Q1_SETTINGS).value.clamp(0.0, 1.0)
    }

    fn links_in_contact(&self) -> usize {
        let links = self.links.iter().flatten();
        links
            .filter(|found| found.distance_m.abs() < TOUCHING_M)
            .count()
    }

    fn regions(&self, hand: &Hand) -> String {
        let digits = hand.digits.iter().zip(&self.digit_gaps_m);
        let touching: BTreeSet<&str> = digits
            .filter(|(_, gap)| gap.is_some_and(|gap| gap <= TOUCHING_M))
            .map(|(digit, _)| digit.as_str())
            .collect();
        Vec::from_iter(touching).join(", ")
    }
}
