//! The grasp energy E(H, x, O) of a pose and a contact set, and its envelope E(H, O) = min over x.

mod completions;
mod local;
mod near;
mod probe;
mod promise;
mod scratch;
mod search;
mod settings;

use std::sync::{Arc, Mutex};

pub use probe::THROUGH_M;
pub use scratch::Ramp;
use scratch::Scratch;
pub use settings::{AUTHORS_UNIT_M, Candidates, EnergySettings, EnergySettingsError, Unit};

use super::term::{
    Alignment, Distance, ForceClosure, Intrusion, JointLimits, Penetration, Prior, Rank,
    SelfPenetration, Term,
};
use crate::energy::{Energy, Explain, Piecewise};
use crate::hand::Hand;
use crate::object::Object;
use crate::space::{PoseMetric, PoseSpace, Space};

/// E(H, O): the energy of a hand pose on an object, minimised exactly over the contact sets of n surface points.
///
/// ```text
/// E(H, O) = min over x ⊂ S(H), |x| = n  of  E_fc(H, x, O) + E_dist(H, x, O) + E_pen + E_prior + …
/// ```
///
/// Continuous and piecewise C¹: the best contact set changes on seams. Every term is C¹ for a fixed set
/// ([`Piecewise::evaluate_piece`]).
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
    alignment: Alignment,
    penetration: Penetration,
    intrusion: Intrusion,
    self_penetration: SelfPenetration,
    pose_terms: Vec<Box<dyn Term>>,
    /// Whether each surface point may be a contact, and the list of those that may.
    may_touch: Vec<bool>,
    contact_candidates: Vec<u32>,
    scratch: Mutex<Vec<Scratch>>,
}

/// Surface points within this distance are candidates at first; the search widens the band by itself where needed.
const FIRST_BAND_M: f64 = 0.006;

/// Contact energy above which no contact set is any good, and the best one is only looked for where it is asked for.
const HOPELESS: f64 = 1.0;

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
        let may_touch = settings.candidates.of(&hand);
        let contact_candidates: Vec<u32> = (0u32..)
            .zip(&may_touch)
            .filter_map(|(index, may)| may.then_some(index))
            .collect();
        if contact_candidates.len() < settings.contacts {
            return Err(EnergySettingsError::Candidates {
                found: contact_candidates.len(),
                contacts: settings.contacts,
            });
        }
        let pose_terms: Vec<Box<dyn Term>> = vec![
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
                form: settings.force_closure_form,
                rounding: settings.force_closure_rounding,
            },
            rank: Rank {
                weight: settings.rank_weight,
                form: settings.rank_form,
                epsilon: settings.rank_epsilon,
            },
            distance: Distance {
                weight: settings.distance_weight,
                form: settings.distance_form,
                rounding_m: settings.distance_rounding_m,
            },
            alignment: Alignment {
                weight: settings.alignment_weight,
            },
            penetration: Penetration {
                weight: settings.penetration_weight,
                rounding_m: settings.depth_rounding_m,
                clearance_m: 0.0,
            },
            intrusion: Intrusion {
                weight: settings.intrusion_weight,
                free_m: settings.intrusion_free_m,
                rounding_m: settings.depth_rounding_m,
            },
            self_penetration: SelfPenetration {
                weight: settings.self_penetration_weight,
                rounding_m: settings.depth_rounding_m,
            },
            pose_terms,
            may_touch,
            contact_candidates,
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

    /// Surface points that may be contacts, by index.
    pub fn contact_candidates(&self) -> &[u32] {
        &self.contact_candidates
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

    /// The terms about depths, in a fixed order.
    fn depth_terms(&self) -> impl Iterator<Item = &dyn Term> {
        let terms: [(&dyn Term, f64); 3] = [
            (&self.penetration, self.penetration.weight),
            (&self.intrusion, self.intrusion.weight),
            (&self.self_penetration, self.self_penetration.weight),
        ];
        active(terms)
    }

    /// The terms of the hand alone.
    fn pose_terms(&self) -> impl Iterator<Item = &dyn Term> {
        let weights = [
            self.settings.joint_limits_weight,
            self.settings.prior_weight,
        ];
        active(self.pose_terms.iter().map(|t| &**t).zip(weights))
    }

    /// The terms of a contact set.
    fn contact_terms(&self) -> impl Iterator<Item = &dyn Term> {
        let terms: [(&dyn Term, f64); 4] = [
            (&self.force_closure, self.force_closure.weight),
            (&self.rank, self.rank.weight),
            (&self.distance, self.distance.weight),
            (&self.alignment, self.alignment.weight),
        ];
        active(terms)
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

    /// Energy and forces of the terms that need no contacts, into `scratch.forces`.
    fn contact_free(&self, x: &[f64], scratch: &mut Scratch) -> f64 {
        if let Some(known) = &scratch.contact_free
            && known.depth_factor.to_bits() == scratch.ramp.depth.to_bits()
        {
            scratch.forces.clone_from(&known.forces);
            return known.energy;
        }
        let clearance_m = self.penetration.clearance_m;
        if scratch.band_m.is_nan() || scratch.band_m < clearance_m {
            self.measure(clearance_m, clearance_m, scratch);
        }
        self.update_proximity(scratch);
        scratch.forces.reset(&self.hand);
        let mut energy = self.add_terms(self.depth_terms(), x, scratch);
        let factor = scratch.ramp.depth;
        if scratch.ramp != Ramp::default() {
            energy *= factor;
            scratch.forces.scale(factor);
        }
        energy += self.add_terms(self.pose_terms(), x, scratch);
        let known = scratch.contact_free.get_or_insert_default();
        known.depth_factor = factor;
        known.energy = energy;
        known.forces.clone_from(&scratch.forces);
        energy
    }

    /// What may overlap, as far as a term asks.
    fn update_proximity(&self, scratch: &mut Scratch) {
        let (hand, posed) = (&self.hand, &scratch.posed);
        if self.intrusion.weight > 0.0 {
            scratch
                .proximity
                .update_intruders(hand, posed, &self.object);
        }
        if self.self_penetration.weight > 0.0 {
            scratch.proximity.update_pairs(hand, posed);
        }
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
        scratch.forces.gather(&self.hand, &scratch.posed);
        self.hand.pull_back(
            &scratch.posed,
            &scratch.forces.wrenches,
            &scratch.forces.joints,
            &self.metric,
            gradient,
        );
        energy
    }

    /// The envelope at `x`, leaving early above `cutoff`.
    fn envelope(&self, x: &[f64], gradient: &mut [f64], cutoff: f64, scratch: &mut Scratch) -> f64 {
        self.pose(x, scratch);
        self.measure_candidates(scratch);
        let free = self.contact_free(x, scratch);
        // The search counts the alignment from its least value.
        let base = free - self.alignment.weight;
        if base > cutoff {
            return base;
        }
        let rest = cutoff - base;
        let contact_part = self.search(rest, scratch);
        if contact_part > rest || scratch.search.best().len() < self.settings.contacts {
            return (base + contact_part).max(cutoff.next_up());
        }
        let choice = scratch.search.best().to_vec();
        free + self.finish(x, &choice, scratch, gradient)
    }

    /// The envelope at `x`, or the energy of a good contact set above `ceiling`.
    fn roughly(
        &self,
        x: &[f64],
        gradient: &mut [f64],
        ceiling: f64,
        scratch: &mut Scratch,
    ) -> (f64, Vec<u32>) {
        self.pose(x, scratch);
        self.measure_candidates(scratch);
        let base = self.contact_free(x, scratch);
        self.search_roughly_above(ceiling - base + self.alignment.weight, scratch);
        let choice = scratch.search.best().to_vec();
        let energy = base + self.finish(x, &choice, scratch, gradient);
        (energy, choice)
    }

    fn best_choice(&self, x: &[f64], scratch: &mut Scratch) -> Vec<u32> {
        self.pose(x, scratch);
        self.measure_candidates(scratch);
        self.search(f64::INFINITY, scratch);
        scratch.search.best().to_vec()
    }

    fn held(
        &self,
        x: &[f64],
        choice: &[u32],
        ramp: Ramp,
        gradient: &mut [f64],
        scratch: &mut Scratch,
    ) -> f64 {
        self.pose(x, scratch);
        scratch.ramp = ramp;
        let base = self.contact_free(x, scratch);
        let energy = base + self.finish(x, choice, scratch, gradient);
        scratch.ramp = Ramp::default();
        energy
    }
}

impl Energy for GraspEnergy {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.evaluate_below(x, gradient, f64::INFINITY)
    }

    fn piecewise(&self) -> Option<&dyn Piecewise> {
        Some(self)
    }

    fn explain(&self) -> Option<&dyn Explain> {
        Some(self)
    }
}

impl Piecewise for GraspEnergy {
    fn active_piece(&self, x: &[f64]) -> Vec<u32> {
        self.with_scratch(x, |scratch| self.best_choice(x, scratch))
    }

    fn evaluate_piece(&self, x: &[f64], piece: &[u32], gradient: &mut [f64]) -> f64 {
        self.evaluate_ramped(x, piece, Ramp::default(), gradient)
    }

    fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], cutoff: f64) -> f64 {
        self.with_scratch(x, |scratch| self.envelope(x, gradient, cutoff, scratch))
    }

    fn evaluate_roughly_above(
        &self,
        x: &[f64],
        gradient: &mut [f64],
        ceiling: f64,
    ) -> (f64, Vec<u32>) {
        self.with_scratch(x, |scratch| self.roughly(x, gradient, ceiling, scratch))
    }

    fn with_cache(&self) -> Option<Box<dyn Energy + '_>> {
        Some(Box::new(self.with_own_memory()))
    }
}

impl Explain for GraspEnergy {
    /// At the best contact set, or at a good one where even that costs so much that none is worth finding.
    fn terms(&self, x: &[f64]) -> Vec<(String, f64)> {
        let choice = self.with_scratch(x, |scratch| {
            self.pose(x, scratch);
            self.measure_candidates(scratch);
            self.search_roughly_above(HOPELESS, scratch);
            scratch.search.best().to_vec()
        });
        self.terms_of(x, &choice)
    }

    fn invalid_reason(&self, x: &[f64]) -> Option<String> {
        let deepest_m = self.deepest_m(x);
        (deepest_m > THROUGH_M)
            .then(|| format!("hand and object overlap by {:.1} mm", deepest_m * 1e3))
    }
}

impl GraspEnergy {
    /// E(H, x, O) with the weights of contact distances and depths multiplied by `ramp`, as synthesis ramps them.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn evaluate_ramped(
        &self,
        x: &[f64],
        choice: &[u32],
        ramp: Ramp,
        gradient: &mut [f64],
    ) -> f64 {
        self.with_scratch(x, |scratch| self.held(x, choice, ramp, gradient, scratch))
    }

    /// The named, weighted terms of E(H, x, O), in a fixed order.
    pub fn terms_of(&self, x: &[f64], choice: &[u32]) -> Vec<(String, f64)> {
        self.with_scratch(x, |scratch| {
            self.pose(x, scratch);
            let clearance_m = self.penetration.clearance_m;
            self.measure(clearance_m, clearance_m, scratch);
            self.update_proximity(scratch);
            self.measure_contacts(choice, scratch);
            let mut forces = std::mem::take(&mut scratch.forces);
            forces.reset(&self.hand);
            let scene = self.scene(x, scratch);
            let terms = self
                .contact_terms()
                .chain(self.depth_terms())
                .chain(self.pose_terms())
                .map(|term| (term.name().to_owned(), term.add(&scene, &mut forces)))
                .collect();
            scratch.forces = forces;
            terms
        })
    }

    /// Names of the terms, in the order of [`Explain::terms`].
    pub fn term_names(&self) -> Vec<String> {
        self.contact_terms()
            .chain(self.depth_terms())
            .chain(self.pose_terms())
            .map(|term| term.name().to_owned())
            .collect()
    }
}

/// The terms whose weight is not zero.
fn active<'a>(
    terms: impl IntoIterator<Item = (&'a dyn Term, f64)>,
) -> impl Iterator<Item = &'a dyn Term> {
    terms
        .into_iter()
        .filter(|(_, weight)| *weight > 0.0)
        .map(|(term, _)| term)
}
