//! One evaluation at a pose: the posed hand, its measured distances, and the energy of the terms.

use std::sync::PoisonError;

use super::GraspEnergy;
use super::near::NearSearch;
use crate::grasp::contact::ContactSearch;
use crate::grasp::layer::{LoadCompliance, NearSphere, NeighbourList};
use crate::grasp::term::{
    Contact, Forces, LayerCompliance, NearPoint, Proximity, Scene, Stage, Term,
};
use crate::hand::PosedHand;
use crate::space::Space;
use crate::space::joints_of;

/// Buffers and caches of an evaluation. They make the next one faster but never change its result.
#[derive(Debug, Clone, Default)]
pub(super) struct Memory {
    x: Vec<f64>,
    pub(super) posed: PosedHand,
    surface: NearSearch,
    /// Points within `band_m` at the current pose, by ascending index.
    pub(super) near: Vec<NearPoint>,
    pub(super) band_m: f64,
    proximity: Proximity,
    neighbours: NeighbourList,
    near_spheres: Vec<NearSphere>,
    forces: Forces,
    /// Energy and forces of the contact-free terms, if already computed at the current pose.
    contact_free: Option<ContactFree>,
    pub(super) contacts: Vec<Contact>,
    pub(super) search: ContactSearch,
    /// Best contact set of the last search.
    pub(super) warm: Vec<u32>,
    ramp: Ramp,
}

#[derive(Debug, Clone, Default)]
struct ContactFree {
    /// The factor on depth weights that was used.
    depth_factor: f64,
    energy: f64,
    forces: Forces,
}

/// Factors on weights during the start of a synthesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ramp {
    /// Factor on the weight of contact distances.
    pub distance: f64,
    /// Factor on the weights of depths: hand in object, object in hand, hand in itself.
    pub depth: f64,
}

impl Default for Ramp {
    /// Full weights.
    fn default() -> Self {
        Self {
            distance: 1.0,
            depth: 1.0,
        }
    }
}

/// An evaluation at a pose. Only the hand is posed at first; everything else is measured when needed.
pub(super) struct Evaluation<'a> {
    pub(super) energy: &'a GraspEnergy,
    x: &'a [f64],
    pub(super) memory: &'a mut Memory,
}

impl GraspEnergy {
    /// Evaluates at `x` with the memory of the nearest pose. Threads that work at different poses use different memories.
    pub(super) fn at<R>(&self, x: &[f64], work: impl FnOnce(&mut Evaluation<'_>) -> R) -> R {
        let pool = || self.memories.lock().unwrap_or_else(PoisonError::into_inner);
        let mut memory = take_nearest(&mut pool(), x).unwrap_or_default();
        let result = work(&mut Evaluation::new(self, x, &mut memory));
        pool().push(memory);
        result
    }

    /// A copy of the memory used last.
    pub(super) fn copy_of_memory(&self) -> Memory {
        let pool = self.memories.lock().unwrap_or_else(PoisonError::into_inner);
        pool.last().cloned().unwrap_or_default()
    }
}

impl<'a> Evaluation<'a> {
    /// Poses the links of the hand, unless the memory already has this pose.
    pub(super) fn new(energy: &'a GraspEnergy, x: &'a [f64], memory: &'a mut Memory) -> Self {
        let coordinates = energy.space.coordinates();
        assert_eq!(x.len(), coordinates, "a pose of another hand");
        let bits = |x: &f64| x.to_bits();
        if !memory.x.iter().map(bits).eq(x.iter().map(bits)) {
            energy.hand.pose_links(x, &mut memory.posed);
            memory.x.clear();
            memory.x.extend_from_slice(x);
            memory.band_m = f64::NAN;
            memory.contact_free = None;
        }
        Self { energy, x, memory }
    }

    /// Fills `near` with all surface points of signed distance at most `band_m`, with gradients up to `graded_m`.
    pub(super) fn measure(&mut self, band_m: f64, graded_m: f64) {
        let memory = &mut *self.memory;
        memory.band_m = band_m;
        memory.surface.find(
            &self.energy.hand,
            &memory.posed,
            &*self.energy.object.shape,
            (band_m, graded_m),
            &mut memory.near,
        );
    }

    /// Measures the object at the contacts of `choice`.
    pub(super) fn measure_contacts(&mut self, choice: &[u32]) {
        let (energy, memory) = (self.energy, &mut *self.memory);
        memory.contacts.clear();
        for &index in choice {
            let point = energy.hand.surface_point(&memory.posed, index as usize);
            let (distance_m, gradient, hessian) = energy.object.shape.hessian(&point);
            memory.contacts.push(Contact {
                index,
                link: energy.hand.surface[index as usize].link,
                point,
                distance_m,
                gradient,
                hessian,
            });
        }
    }

    /// Calls `work` with the weights of `ramp`.
    pub(super) fn ramped<R>(&mut self, ramp: Ramp, work: impl FnOnce(&mut Self) -> R) -> R {
        self.memory.ramp = ramp;
        let result = work(self);
        self.memory.ramp = Ramp::default();
        result
    }

    fn scene(&mut self) -> (Scene<'_>, &mut Forces) {
        let (energy, memory) = (self.energy, &mut *self.memory);
        let scene = Scene {
            hand: &energy.hand,
            posed: &memory.posed,
            joints_rad: joints_of(self.x),
            object: &energy.object,
            near: &memory.near,
            proximity: &memory.proximity,
            contacts: &memory.contacts,
            layer: &energy.layer,
            near_spheres: &memory.near_spheres,
            unit_m: energy.unit_m,
            distance_factor: memory.ramp.distance,
        };
        (scene, &mut memory.forces)
    }

    fn add_terms(&mut self, stage: Stage) -> f64 {
        let terms = self.energy.terms.iter();
        let (scene, forces) = self.scene();
        let terms = terms.filter(|term| term.stage() == stage);
        terms.map(|term| term.add(&scene, forces)).sum()
    }

    /// Updates the lists of parts that may overlap, if a term needs them.
    fn update_proximity(&mut self) {
        let (energy, memory) = (self.energy, &mut *self.memory);
        let (hand, posed) = (&energy.hand, &memory.posed);
        if energy.settings.layer.is_none() && energy.settings.intrusion_weight > 0.0 {
            let object = &energy.object;
            memory.proximity.update_intruders(hand, posed, object);
        }
        if energy.settings.self_penetration_weight > 0.0 {
            memory.proximity.update_pairs(hand, posed);
        }
    }

    pub(super) fn contact_free(&mut self) -> f64 {
        let (hand, clearance_m) = (&self.energy.hand, self.energy.clearance_m);
        let memory = &mut *self.memory;
        let ramp = memory.ramp;
        if let Some(known) = &memory.contact_free
            && known.depth_factor.to_bits() == ramp.depth.to_bits()
        {
            memory.forces.clone_from(&known.forces);
            return known.energy;
        }
        if self.energy.settings.layer.is_some() {
            self.measure_layer();
        } else if memory.band_m.is_nan() || memory.band_m < clearance_m {
            self.measure(clearance_m, clearance_m);
        }
        self.update_proximity();
        self.memory.forces.reset(hand);
        let mut energy = self.add_terms(Stage::Depths);
        if ramp != Ramp::default() {
            energy *= ramp.depth;
            self.memory.forces.scale(ramp.depth);
        }
        energy += self.add_terms(Stage::Pose);
        let memory = &mut *self.memory;
        let known = memory.contact_free.get_or_insert_default();
        known.depth_factor = ramp.depth;
        known.energy = energy;
        known.forces.clone_from(&memory.forces);
        energy
    }

    /// Fills `near_spheres` with the spheres of the layer that may carry.
    fn measure_layer(&mut self) {
        let energy = self.energy;
        if let Some(settings) = &energy.settings.layer {
            let memory = &mut *self.memory;
            let (posed, spheres) = (&memory.posed, &mut memory.near_spheres);
            let shape = &*energy.object.shape;
            let reach_m = settings.carrying_m();
            (memory.neighbours).find(&energy.layer, posed, shape, reach_m, spheres);
        }
    }

    /// The value of one more term.
    pub(super) fn term(&mut self, term: &dyn Term) -> f64 {
        self.measure_layer();
        self.memory.contact_free = None;
        self.memory.forces.reset(&self.energy.hand);
        let (scene, forces) = self.scene();
        term.add(&scene, forces)
    }

    /// How much the elastic layer gives under single loads.
    pub(super) fn under_loads(&mut self, term: &LayerCompliance) -> LoadCompliance {
        self.measure_layer();
        self.memory.contact_free = None;
        self.memory.forces.reset(&self.energy.hand);
        let (scene, _) = self.scene();
        term.under_loads(&scene)
    }

    /// The energy of an elastic layer, which has no contact set.
    fn smooth(&mut self, gradient: &mut [f64]) -> f64 {
        let value = self.contact_free();
        let (energy, memory) = (self.energy, &mut *self.memory);
        energy.hand.pull_back(
            &memory.posed,
            &memory.forces.wrenches,
            &memory.forces.joints,
            &energy.metric,
            gradient,
        );
        value
    }

    /// Adds the terms of `choice` to the contact-free ones and converts all forces to the gradient.
    fn pull_back(&mut self, choice: &[u32], gradient: &mut [f64]) -> f64 {
        self.measure_contacts(choice);
        let contact_energy = self.add_terms(Stage::Contacts);
        let (energy, memory) = (self.energy, &mut *self.memory);
        memory.forces.gather(&energy.hand, &memory.posed);
        energy.hand.pull_back(
            &memory.posed,
            &memory.forces.wrenches,
            &memory.forces.joints,
            &energy.metric,
            gradient,
        );
        contact_energy
    }

    /// The envelope. It returns early above `cutoff`.
    pub(super) fn envelope(&mut self, gradient: &mut [f64], cutoff: f64) -> f64 {
        if self.energy.settings.layer.is_some() {
            return self.smooth(gradient);
        }
        self.measure_candidates();
        let free = self.contact_free();
        // The search counts the alignment relative to its minimum.
        let base = free - self.energy.alignment.weight;
        if base > cutoff {
            return base;
        }
        let rest = cutoff - base;
        let contact_part = self.choose_contacts(rest);
        let best = self.memory.search.best();
        if contact_part > rest || best.len() < self.energy.settings.contacts {
            return (base + contact_part).max(cutoff.next_up());
        }
        let choice = best.to_vec();
        free + self.pull_back(&choice, gradient)
    }

    /// The envelope, or the energy of a good contact set if it exceeds `ceiling`.
    pub(super) fn roughly(&mut self, gradient: &mut [f64], ceiling: f64) -> (f64, Vec<u32>) {
        if self.energy.settings.layer.is_some() {
            return (self.smooth(gradient), Vec::new());
        }
        self.measure_candidates();
        let base = self.contact_free();
        self.choose_contacts_roughly_above(ceiling - base + self.energy.alignment.weight);
        let choice = self.memory.search.best().to_vec();
        let energy = base + self.pull_back(&choice, gradient);
        (energy, choice)
    }

    pub(super) fn best_choice(&mut self) -> Vec<u32> {
        self.measure_candidates();
        let is_layered = self.energy.settings.layer.is_some();
        if !(is_layered && self.choose_touching_contacts()) {
            self.choose_contacts(f64::INFINITY);
        }
        self.memory.search.best().to_vec()
    }

    /// The energy of the fixed contact set `choice`.
    pub(super) fn held(&mut self, choice: &[u32], ramp: Ramp, gradient: &mut [f64]) -> f64 {
        if self.energy.settings.layer.is_some() {
            return self.smooth(gradient);
        }
        self.ramped(ramp, |evaluation| {
            let base = evaluation.contact_free();
            base + evaluation.pull_back(choice, gradient)
        })
    }

    pub(super) fn terms(&mut self, choice: &[u32]) -> Vec<(String, f64)> {
        let energy = self.energy;
        self.contact_free();
        self.measure(energy.clearance_m, energy.clearance_m);
        self.measure_contacts(choice);
        self.memory.forces.reset(&energy.hand);
        let (scene, forces) = self.scene();
        let terms = energy.terms.iter();
        terms
            .map(|term| (term.name().to_owned(), term.add(&scene, forces)))
            .collect()
    }
}

fn take_nearest(pool: &mut Vec<Memory>, x: &[f64]) -> Option<Memory> {
    if pool.len() < 2 {
        return pool.pop();
    }
    // Any metric will do; a radian moves fingers by centimetres.
    let weight = |coordinate: usize| if coordinate < 3 { 1.0 } else { 0.05 };
    let away = |memory: &Memory| -> f64 {
        let steps = memory.x.iter().zip(x).enumerate();
        steps.map(|(k, (a, b))| (weight(k) * (a - b)).powi(2)).sum()
    };
    let nearest = (0..pool.len()).min_by(|a, b| away(&pool[*a]).total_cmp(&away(&pool[*b])))?;
    Some(pool.swap_remove(nearest))
}
