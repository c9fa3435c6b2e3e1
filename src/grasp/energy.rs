//! The grasp energy E(H, x, O) of a pose and a contact set, and its envelope E(H, O) = min over x.

use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::closure::PointContact;
use super::contact::{Candidate, ContactSearch, WrenchCost};
use super::hand::{Hand, PosedHand};
use super::object::Object;
use super::term::{
    Contact, Distance, ForceClosure, Forces, Intrusion, JointLimits, Penetration, Prior, PriorForm,
    Rank, Scene, SelfPenetration, Term, for_each_intruder, point_contact,
};
use crate::energy::Energy;
use crate::space::{PoseMetric, PoseSpace, Space};

/// The length that divides arms, distances and depths, and so makes the energy dimensionless.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// Largest distance of a vertex of the object from its centroid of volume.
    ObjectRadius,
    /// A fixed length in metres (the authors of Liu et al. 2021 use 0.12).
    Metres(f64),
}

/// Which terms make the grasp energy, with weights and roundings. Read from a TOML file; see `data/experiments/`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EnergySettings {
    /// Number of contacts n. Three equal unit forces balance only at 120°, so pinches need four.
    pub contacts: usize,
    /// The length that makes the energy dimensionless.
    pub unit: Unit,
    /// Weight of the left-over wrench.
    pub force_closure_weight: f64,
    /// Rounding of its norm, dimensionless.
    pub force_closure_rounding: f64,
    /// Weight of the rank condition.
    pub rank_weight: f64,
    /// Its threshold ε.
    pub rank_epsilon: f64,
    /// Weight of contact distances per unit length.
    pub distance_weight: f64,
    /// Their rounding, metres.
    pub distance_rounding_m: f64,
    /// Weight of hand points inside the object per unit length.
    pub penetration_weight: f64,
    /// Weight of object points inside the hand per unit length.
    pub intrusion_weight: f64,
    /// Weight of the hand inside itself per unit length.
    pub self_penetration_weight: f64,
    /// Rounding of the three depths, metres.
    pub depth_rounding_m: f64,
    /// Weight of joint excess per radian.
    pub joint_limits_weight: f64,
    /// Its rounding, radians.
    pub joint_limits_rounding_rad: f64,
    /// Weight of the pose prior.
    pub prior_weight: f64,
    /// Its form.
    pub prior_form: PriorForm,
}

impl Default for EnergySettings {
    /// Ours: smooth, scale-free, possible hands. The distance weight makes a hand that hovers pay more than one that
    /// loses force closure, so that barriers mean force closure.
    fn default() -> Self {
        Self {
            contacts: 4,
            unit: Unit::ObjectRadius,
            force_closure_weight: 1.0,
            force_closure_rounding: 0.05,
            rank_weight: 0.0,
            rank_epsilon: 1e-4,
            distance_weight: 10.0,
            distance_rounding_m: 0.002,
            penetration_weight: 10.0,
            intrusion_weight: 10.0,
            self_penetration_weight: 10.0,
            depth_rounding_m: 0.0005,
            joint_limits_weight: 20.0,
            joint_limits_rounding_rad: 0.02,
            prior_weight: 0.02,
            prior_form: PriorForm::Quadratic,
        }
    }
}

impl EnergySettings {
    /// The formulae printed in Liu et al. (2021), Eqs. 7–10, with their w = 1.
    pub fn paper() -> Self {
        Self {
            contacts: 3,
            unit: Unit::ObjectRadius,
            force_closure_weight: 1.0,
            force_closure_rounding: 0.0,
            rank_weight: 1.0,
            rank_epsilon: 1e-4,
            distance_weight: 1.0,
            distance_rounding_m: 0.0,
            penetration_weight: 1.0,
            intrusion_weight: 0.0,
            self_penetration_weight: 0.0,
            depth_rounding_m: 0.0,
            joint_limits_weight: 0.0,
            joint_limits_rounding_rad: 0.02,
            prior_weight: 1.0,
            prior_form: PriorForm::Norm,
        }
    }

    /// One clear sentence on the first value that makes no sense.
    ///
    /// # Errors
    /// If a weight or rounding is negative or not finite, or the number of contacts is outside 2..=8.
    pub fn validate(&self) -> Result<(), EnergySettingsError> {
        if !(2..=8).contains(&self.contacts) {
            return Err(EnergySettingsError::Contacts(self.contacts));
        }
        if let Unit::Metres(unit) = self.unit
            && !(unit > 0.0 && unit.is_finite())
        {
            return Err(EnergySettingsError::Value {
                name: "unit",
                value: unit,
            });
        }
        let values = [
            ("force_closure_weight", self.force_closure_weight),
            ("force_closure_rounding", self.force_closure_rounding),
            ("rank_weight", self.rank_weight),
            ("rank_epsilon", self.rank_epsilon),
            ("distance_weight", self.distance_weight),
            ("distance_rounding_m", self.distance_rounding_m),
            ("penetration_weight", self.penetration_weight),
            ("intrusion_weight", self.intrusion_weight),
            ("self_penetration_weight", self.self_penetration_weight),
            ("depth_rounding_m", self.depth_rounding_m),
            ("joint_limits_weight", self.joint_limits_weight),
            ("joint_limits_rounding_rad", self.joint_limits_rounding_rad),
            ("prior_weight", self.prior_weight),
        ];
        for (name, value) in values {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(EnergySettingsError::Value { name, value });
            }
        }
        Ok(())
    }
}

/// A setting of the energy that makes no sense.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EnergySettingsError {
    /// Outside 2..=8.
    #[error("contacts = {0}: between 2 and 8 contacts make a grasp")]
    Contacts(usize),
    /// Negative, NaN or infinite.
    #[error("{name} = {value}: must be finite and not negative")]
    Value {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: f64,
    },
}

/// Buffers of one evaluation, and what is remembered to make the next one cheaper (never to change its result).
#[derive(Debug, Default)]
struct Scratch {
    posed: PosedHand,
    /// Where each surface point's distance was last measured, and that distance.
    measured: Vec<(Vector3<f64>, f64)>,
    /// Points within `band_m` at the current pose: index and signed distance.
    near: Vec<(u32, f64)>,
    band_m: f64,
    forces: Forces,
    contacts: Vec<Contact>,
    search: ContactSearch,
    warm: Vec<u32>,
    distance_factor: f64,
}

impl Scratch {
    fn new() -> Self {
        Self {
            distance_factor: 1.0,
            ..Self::default()
        }
    }
}

/// E(H, O): the energy of a hand pose on an object, minimised exactly over the contact sets of n surface points.
///
/// ```text
/// E(H, O) = min over x ⊂ S(H), |x| = n  of  E_fc(H, x, O) + E_dist(H, x, O) + E_pen + E_prior + …
/// ```
///
/// Continuous and piecewise C¹: the best contact set changes on seams. Every term is C¹ for a fixed set
/// ([`Energy::evaluate_choice`]).
#[derive(Debug)]
pub struct GraspEnergy {
    hand: Arc<Hand>,
    object: Arc<Object>,
    space: PoseSpace,
    metric: PoseMetric,
    settings: EnergySettings,
    unit_m: f64,
    force_closure: ForceClosure,
    rank: Rank,
    distance: Distance,
    penetration: Penetration,
    intrusion: Intrusion,
    pose_terms: Vec<Box<dyn Term>>,
    scratch: Mutex<Vec<Scratch>>,
}

/// Surface points within this distance are candidates at first; the search widens the band by itself where needed.
const FIRST_BAND_M: f64 = 0.006;

/// Contact energy above which no contact set is any good, and the best one is only looked for where it is asked for.
const HOPELESS: f64 = 1.0;

/// A path whose top buries hand or object deeper than this passes through the object.
pub const THROUGH_M: f64 = 0.002;

impl GraspEnergy {
    /// The energy of `hand` on `object`.
    ///
    /// # Errors
    /// If the settings make no sense.
    pub fn new(
        hand: Arc<Hand>,
        object: Arc<Object>,
        settings: EnergySettings,
    ) -> Result<Self, EnergySettingsError> {
        settings.validate()?;
        let unit_m = match settings.unit {
            Unit::ObjectRadius => object.radius_m,
            Unit::Metres(unit) => unit,
        };
        let metric = hand.pose_metric();
        let space = PoseSpace::new(metric.clone(), object.symmetry.clone());
        let pose_terms: Vec<Box<dyn Term>> = vec![
            Box::new(SelfPenetration {
                weight: settings.self_penetration_weight,
                rounding_m: settings.depth_rounding_m,
            }),
            Box::new(JointLimits {
                weight: settings.joint_limits_weight,
                rounding_rad: settings.joint_limits_rounding_rad,
            }),
            Box::new(Prior {
                weight: settings.prior_weight,
                form: settings.prior_form,
            }),
        ];
        Ok(Self {
            space,
            metric,
            settings,
            unit_m,
            force_closure: ForceClosure {
                weight: settings.force_closure_weight,
                rounding: settings.force_closure_rounding,
            },
            rank: Rank {
                weight: settings.rank_weight,
                epsilon: settings.rank_epsilon,
            },
            distance: Distance {
                weight: settings.distance_weight,
                rounding_m: settings.distance_rounding_m,
            },
            penetration: Penetration {
                weight: settings.penetration_weight,
                rounding_m: settings.depth_rounding_m,
                clearance_m: 0.0,
            },
            intrusion: Intrusion {
                weight: settings.intrusion_weight,
                rounding_m: settings.depth_rounding_m,
            },
            pose_terms,
            hand,
            object,
            scratch: Mutex::new(Vec::new()),
        })
    }

    /// The same energy with every surface point of the hand kept `clearance_m` off the object by a stiff penalty: its
    /// minima tell what hovering costs.
    #[must_use]
    pub fn with_clearance(mut self, clearance_m: f64, weight: f64) -> Self {
        self.penetration.clearance_m = clearance_m;
        self.penetration.weight = weight;
        self
    }

    /// The hand.
    pub fn hand(&self) -> &Arc<Hand> {
        &self.hand
    }

    /// The object.
    pub fn object(&self) -> &Arc<Object> {
        &self.object
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &EnergySettings {
        &self.settings
    }

    /// The pose space, as a concrete type.
    pub fn pose_space(&self) -> &PoseSpace {
        &self.space
    }

    /// The length that divides arms, distances and depths, metres.
    pub fn unit_m(&self) -> f64 {
        self.unit_m
    }

    /// The contacts of `choice` at pose `x` as the force-closure tests see them, arms divided by the unit.
    pub fn point_contacts(&self, x: &[f64], choice: &[u32]) -> Vec<PointContact> {
        self.with_scratch(|scratch| {
            self.pose(x, scratch);
            self.measure_contacts(choice, scratch);
            scratch
                .contacts
                .iter()
                .map(|c| point_contact(c, &self.object.centroid, self.unit_m))
                .collect()
        })
    }

    fn with_scratch<R>(&self, work: impl FnOnce(&mut Scratch) -> R) -> R {
        let pool = || self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = pool().pop().unwrap_or_else(Scratch::new);
        let result = work(&mut scratch);
        pool().push(scratch);
        result
    }

    fn pose(&self, x: &[f64], scratch: &mut Scratch) {
        assert_eq!(x.len(), self.space.coordinates(), "a pose of another hand");
        self.hand.pose(x, &mut scratch.posed);
    }

    /// Fills `near` with every surface point whose signed distance is at most `band_m`. Points whose last measurement
    /// rules that out are not measured again.
    fn measure(&self, band_m: f64, scratch: &mut Scratch) {
        let points = &scratch.posed.points;
        let unknown = (Vector3::zeros(), f64::NEG_INFINITY);
        scratch.measured.resize(points.len(), unknown);
        scratch.near.clear();
        scratch.band_m = band_m;
        let shape = &*self.object.shape;
        let lipschitz = shape.lipschitz();
        for ((index, point), known) in (0u32..).zip(points).zip(&mut scratch.measured) {
            if known.1 - lipschitz * (point - known.0).norm() > band_m {
                continue;
            }
            if known.0 != *point || known.1 == f64::NEG_INFINITY {
                *known = (*point, shape.distance(point));
            }
            if known.1 <= band_m {
                scratch.near.push((index, known.1));
            }
        }
    }

    fn measure_contacts(&self, choice: &[u32], scratch: &mut Scratch) {
        scratch.contacts.clear();
        for &index in choice {
            let point = scratch.posed.points[index as usize];
            let (distance_m, gradient, hessian) = self.object.shape.hessian(&point);
            scratch.contacts.push(Contact {
                index,
                link: self.hand.surface[index as usize].link,
                point,
                distance_m,
                gradient,
                hessian,
            });
        }
    }

    fn scene<'a>(&'a self, x: &'a [f64], scratch: &'a Scratch) -> Scene<'a> {
        Scene {
            hand: &self.hand,
            posed: &scratch.posed,
            joints_rad: &x[7..],
            object: &self.object,
            near: &scratch.near,
            contacts: &scratch.contacts,
            unit_m: self.unit_m,
            distance_factor: scratch.distance_factor,
        }
    }

    /// The terms that need no contacts, in a fixed order.
    fn contact_free_terms(&self) -> impl Iterator<Item = &dyn Term> {
        let depth: [(&dyn Term, f64); 2] = [
            (&self.penetration, self.penetration.weight),
            (&self.intrusion, self.intrusion.weight),
        ];
        let pose = [
            self.settings.self_penetration_weight,
            self.settings.joint_limits_weight,
            self.settings.prior_weight,
        ];
        depth
            .into_iter()
            .chain(self.pose_terms.iter().map(|t| &**t).zip(pose))
            .filter(|(_, weight)| *weight > 0.0)
            .map(|(term, _)| term)
    }

    /// The terms of a contact set.
    fn contact_terms(&self) -> impl Iterator<Item = &dyn Term> {
        let terms: [(&dyn Term, f64); 3] = [
            (&self.force_closure, self.force_closure.weight),
            (&self.rank, self.rank.weight),
            (&self.distance, self.distance.weight),
        ];
        terms
            .into_iter()
            .filter(|(_, weight)| *weight > 0.0)
            .map(|(term, _)| term)
    }

    fn add_terms<'a>(
        &'a self,
        terms: impl Iterator<Item = &'a dyn Term>,
        x: &[f64],
        scratch: &mut Scratch,
    ) -> f64 {
        let mut forces = std::mem::take(&mut scratch.forces);
        let scene = self.scene(x, scratch);
        let energy = terms.map(|term| term.add(&scene, &mut forces)).sum();
        scratch.forces = forces;
        energy
    }

    fn contact_free(&self, x: &[f64], scratch: &mut Scratch) -> f64 {
        scratch
            .forces
            .reset(self.hand.links.len(), self.hand.joints.len());
        self.add_terms(self.contact_free_terms(), x, scratch)
    }

    /// Adds the terms of `choice` and writes the gradient; `scratch` holds the posed hand and the contact-free forces.
    fn finish(
        &self,
        x: &[f64],
        choice: &[u32],
        scratch: &mut Scratch,
        gradient: &mut [f64],
    ) -> f64 {
        self.measure_contacts(choice, scratch);
        let energy = self.add_terms(self.contact_terms(), x, scratch);
        self.hand.pull_back(
            &scratch.posed,
            &scratch.forces.wrenches,
            &scratch.forces.joints,
            &self.metric,
            gradient,
        );
        energy
    }

    fn candidates(&self, scratch: &mut Scratch) {
        let list = scratch.search.candidates_mut();
        list.clear();
        for &(index, distance_m) in &scratch.near {
            let point = scratch.posed.points[index as usize];
            let (_, gradient) = self.object.shape.gradient(&point);
            let length = gradient.norm();
            if length == 0.0 {
                continue;
            }
            let contact = PointContact {
                arm: (point - self.object.centroid) / self.unit_m,
                inward_normal: -gradient / length,
            };
            list.push(Candidate {
                index,
                cost: self.distance.cost(distance_m, self.unit_m),
                wrench: contact.wrench().into(),
            });
        }
    }

    fn wrench_cost(&self) -> WrenchCost {
        WrenchCost {
            weight: self.force_closure.weight,
            rounding: self.force_closure.rounding,
        }
    }

    /// Leaves the best contact set at the posed hand in `scratch.search` and returns its contact energy, or a lower
    /// bound of it above `cutoff`.
    ///
    /// With a rank weight the set is the minimum of the other contact terms: the rank term is zero but for degenerate
    /// sets, and its value is added to the energy.
    fn search(&self, cutoff: f64, scratch: &mut Scratch) -> f64 {
        let size = self.settings.contacts;
        let cost = self.wrench_cost();
        loop {
            let band_m = scratch.band_m;
            let everything = scratch.near.len() == self.hand.surface.len();
            if scratch.near.len() < size && !everything {
                self.measure(2.0 * band_m, scratch);
                continue;
            }
            self.candidates(scratch);
            let total = scratch.search.descend(size, &scratch.warm, &cost);
            let floor = scratch.search.floor(size);
            if floor > cutoff {
                return floor;
            }
            // A member of a better set costs at most what the others leave of the total.
            let needed_m = self
                .distance
                .reach_m(total - scratch.search.floor(size - 1), self.unit_m);
            if needed_m > band_m && !everything {
                // Also when few candidates made the first total poor: the wider list has a better one.
                self.measure(needed_m.min(2.0 * band_m), scratch);
                continue;
            }
            return scratch.search.prove(size, &cost);
        }
    }

    /// As [`GraspEnergy::search`], but without proof where a good set costs more than `ceiling`; never looks at what was
    /// remembered, so that the answer depends on the pose alone.
    fn search_roughly_above(&self, ceiling: f64, scratch: &mut Scratch) -> f64 {
        let size = self.settings.contacts;
        let cost = self.wrench_cost();
        while scratch.near.len() < size.min(self.hand.surface.len()) {
            self.measure(2.0 * scratch.band_m, scratch);
        }
        self.candidates(scratch);
        let total = scratch.search.descend_cold(size, &cost);
        if total > ceiling {
            return total;
        }
        // The proof may begin with this set; it ends with the minimum in any case.
        let mut warm = std::mem::take(&mut scratch.warm);
        warm.clear();
        warm.extend_from_slice(scratch.search.best());
        scratch.warm = warm;
        self.search(f64::INFINITY, scratch)
    }

    /// Band that holds the candidates of most poses and every point the penetration term asks about.
    fn first_band_m(&self) -> f64 {
        FIRST_BAND_M.max(self.penetration.clearance_m)
    }

    /// The envelope at `x`, leaving early above `cutoff`.
    fn envelope(&self, x: &[f64], gradient: &mut [f64], cutoff: f64) -> f64 {
        self.with_scratch(|scratch| {
            self.pose(x, scratch);
            self.measure(self.first_band_m(), scratch);
            let base = self.contact_free(x, scratch);
            if base > cutoff {
                return base;
            }
            let contact_part = self.search(cutoff - base, scratch);
            if base + contact_part > cutoff || scratch.search.best().len() < self.settings.contacts
            {
                return base + contact_part;
            }
            let mut choice = std::mem::take(&mut scratch.warm);
            choice.clear();
            choice.extend_from_slice(scratch.search.best());
            let energy = base + self.finish(x, &choice, scratch, gradient);
            scratch.warm = choice;
            energy
        })
    }

    /// Deepest point at pose `x`: of the hand's surface inside the object or of the object's samples inside the hand,
    /// metres, 0 where nothing overlaps. Measured on the smooth shape.
    pub fn deepest_m(&self, x: &[f64]) -> f64 {
        self.with_scratch(|scratch| {
            self.pose(x, scratch);
            self.measure(0.0, scratch);
            let mut deepest = scratch.near.iter().fold(0.0f64, |d, (_, s)| d.max(-s));
            for_each_intruder(&self.scene(x, scratch), |_, _, _, depth| {
                deepest = deepest.max(depth);
            });
            deepest
        })
    }

    /// Least signed distance of a surface point of the hand from the object at pose `x`, metres.
    pub fn clearance_m(&self, x: &[f64]) -> f64 {
        self.with_scratch(|scratch| {
            self.pose(x, scratch);
            let distances = scratch
                .posed
                .points
                .iter()
                .map(|p| self.object.shape.distance(p));
            distances.fold(f64::INFINITY, f64::min)
        })
    }

    /// Mean of the contact points of `choice` at pose `x`, object frame, metres.
    pub fn contact_centre(&self, x: &[f64], choice: &[u32]) -> Vector3<f64> {
        self.with_scratch(|scratch| {
            self.pose(x, scratch);
            let points = choice
                .iter()
                .map(|&index| scratch.posed.points[index as usize]);
            points.sum::<Vector3<f64>>() / choice.len().max(1) as f64
        })
    }
}

impl Energy for GraspEnergy {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.envelope(x, gradient, f64::INFINITY)
    }

    fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], cutoff: f64) -> f64 {
        self.envelope(x, gradient, cutoff)
    }

    fn evaluate_roughly_above(&self, x: &[f64], gradient: &mut [f64], ceiling: f64) -> f64 {
        self.with_scratch(|scratch| {
            self.pose(x, scratch);
            self.measure(self.first_band_m(), scratch);
            let base = self.contact_free(x, scratch);
            self.search_roughly_above(ceiling - base, scratch);
            let choice = scratch.search.best().to_vec();
            base + self.finish(x, &choice, scratch, gradient)
        })
    }

    fn choice(&self, x: &[f64]) -> Vec<u32> {
        self.with_scratch(|scratch| {
            self.pose(x, scratch);
            self.measure(self.first_band_m(), scratch);
            self.search(f64::INFINITY, scratch);
            scratch.search.best().to_vec()
        })
    }

    fn evaluate_choice(&self, x: &[f64], choice: &[u32], gradient: &mut [f64]) -> f64 {
        self.evaluate_ramped(x, choice, 1.0, gradient)
    }

    /// At the best contact set, or at a good one where even that costs so much that none is worth finding.
    fn terms(&self, x: &[f64]) -> Vec<(String, f64)> {
        let choice = self.with_scratch(|scratch| {
            self.pose(x, scratch);
            self.measure(self.first_band_m(), scratch);
            self.search_roughly_above(HOPELESS, scratch);
            scratch.search.best().to_vec()
        });
        self.terms_of(x, &choice)
    }

    fn objection(&self, x: &[f64]) -> Option<String> {
        let deepest_m = self.deepest_m(x);
        (deepest_m > THROUGH_M)
            .then(|| format!("hand and object overlap by {:.1} mm", deepest_m * 1e3))
    }
}

impl GraspEnergy {
    /// E(H, x, O) with the weight of the contact distances multiplied by `distance_factor`, as synthesis ramps it.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn evaluate_ramped(
        &self,
        x: &[f64],
        choice: &[u32],
        distance_factor: f64,
        gradient: &mut [f64],
    ) -> f64 {
        self.with_scratch(|scratch| {
            self.pose(x, scratch);
            self.measure(self.penetration.clearance_m, scratch);
            let base = self.contact_free(x, scratch);
            scratch.distance_factor = distance_factor;
            let energy = base + self.finish(x, choice, scratch, gradient);
            scratch.distance_factor = 1.0;
            energy
        })
    }

    /// Costs of every surface point as the contact that completes `others` at pose `x`: own cost plus force closure of
    /// the whole set, for points that cost at most `allowance` more than the cheapest own cost.
    pub fn completions(
        &self,
        x: &[f64],
        others: &[u32],
        distance_factor: f64,
        allowance: f64,
    ) -> Vec<(u32, f64)> {
        self.with_scratch(|scratch| {
            self.pose(x, scratch);
            let cost =
                |distance_m: f64| distance_factor * self.distance.cost(distance_m, self.unit_m);
            self.measure(FIRST_BAND_M, scratch);
            while scratch.near.is_empty() {
                self.measure(2.0 * scratch.band_m, scratch);
            }
            let cheapest = scratch
                .near
                .iter()
                .map(|(_, d)| cost(*d))
                .min_by(f64::total_cmp)
                .unwrap_or(0.0);
            let reach_m = self
                .distance
                .reach_m((cheapest + allowance) / distance_factor, self.unit_m);
            self.measure(reach_m, scratch);
            self.measure_contacts(others, scratch);
            let rest: nalgebra::Vector6<f64> = scratch
                .contacts
                .iter()
                .map(|c| point_contact(c, &self.object.centroid, self.unit_m).wrench())
                .sum();
            let wrench_cost = self.wrench_cost();
            self.candidates(scratch);
            scratch
                .search
                .candidates_mut()
                .iter()
                .filter(|c| !others.contains(&c.index))
                .map(|c| {
                    let net = rest + nalgebra::Vector6::from(c.wrench);
                    let own = distance_factor * c.cost;
                    (c.index, own + wrench_cost.of_squared(net.norm_squared()))
                })
                .collect()
        })
    }

    /// The named, weighted terms of E(H, x, O), in a fixed order.
    pub fn terms_of(&self, x: &[f64], choice: &[u32]) -> Vec<(String, f64)> {
        self.with_scratch(|scratch| {
            self.pose(x, scratch);
            self.measure(self.penetration.clearance_m, scratch);
            self.measure_contacts(choice, scratch);
            scratch
                .forces
                .reset(self.hand.links.len(), self.hand.joints.len());
            let mut forces = std::mem::take(&mut scratch.forces);
            let scene = self.scene(x, scratch);
            let terms = self
                .contact_terms()
                .chain(self.contact_free_terms())
                .map(|term| (term.name().to_owned(), term.add(&scene, &mut forces)))
                .collect();
            scratch.forces = forces;
            terms
        })
    }

    /// Names of the terms, in the order of [`Energy::terms`].
    pub fn term_names(&self) -> Vec<String> {
        self.contact_terms()
            .chain(self.contact_free_terms())
            .map(|term| term.name().to_owned())
            .collect()
    }
}
