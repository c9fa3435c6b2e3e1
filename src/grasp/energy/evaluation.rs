//! One evaluation at a pose: the posed hand, the layer near the object, and the energy of the terms.

use std::sync::PoisonError;

use super::GraspEnergy;
use crate::grasp::layer::{LoadCompliance, NearSphere, NeighbourList};
use crate::grasp::term::{Forces, LayerCompliance, Proximity, Scene, Stage, Term};
use crate::hand::PosedHand;
use crate::space::Space;
use crate::space::joints_of;

/// Buffers and lists of an evaluation. They make the next one faster but never change its result.
#[derive(Debug, Clone, Default)]
pub(super) struct Memory {
    x: Vec<f64>,
    pub(super) posed: PosedHand,
    proximity: Proximity,
    neighbours: NeighbourList,
    near_spheres: Vec<NearSphere>,
    forces: Forces,
}

/// An evaluation at a pose. Only the hand is posed at first; everything else is measured when needed.
pub(super) struct Evaluation<'a> {
    energy: &'a GraspEnergy,
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
}

impl<'a> Evaluation<'a> {
    /// Poses the links of the hand, unless the memory already has this pose.
    fn new(energy: &'a GraspEnergy, x: &'a [f64], memory: &'a mut Memory) -> Self {
        let coordinates = energy.space.coordinates();
        assert_eq!(x.len(), coordinates, "a pose of another hand");
        let bits = |x: &f64| x.to_bits();
        if !memory.x.iter().map(bits).eq(x.iter().map(bits)) {
            energy.hand.pose_links(x, &mut memory.posed);
            memory.x.clear();
            memory.x.extend_from_slice(x);
        }
        Self { energy, x, memory }
    }

    fn scene(&mut self) -> (Scene<'_>, &mut Forces) {
        let (energy, memory) = (self.energy, &mut *self.memory);
        let scene = Scene {
            hand: &energy.hand,
            posed: &memory.posed,
            joints: joints_of(self.x),
            object: &energy.object,
            proximity: &memory.proximity,
            layer: &energy.layer,
            near_spheres: &memory.near_spheres,
            unit_m: energy.unit_m(),
        };
        (scene, &mut memory.forces)
    }

    fn add_terms(&mut self, stage: Stage) -> f64 {
        let terms = self.energy.terms.iter();
        let (scene, forces) = self.scene();
        let terms = terms.filter(|term| term.stage() == stage);
        terms.map(|term| term.add(&scene, forces)).sum()
    }

    /// Measures what terms need, and sets all forces to zero.
    fn begin(&mut self) {
        self.measure_layer();
        let (energy, memory) = (self.energy, &mut *self.memory);
        if energy.settings.self_penetration_weight > 0.0 {
            memory.proximity.update_pairs(&energy.hand, &memory.posed);
        }
        memory.forces.reset(&energy.hand);
    }

    /// Fills `near_spheres` with the spheres of the layer that may carry.
    fn measure_layer(&mut self) {
        let (energy, memory) = (self.energy, &mut *self.memory);
        let (posed, spheres) = (&memory.posed, &mut memory.near_spheres);
        let shape = &*energy.object.shape;
        let reach_m = energy.settings.layer.carrying_m();
        (memory.neighbours).find(&energy.layer, posed, shape, reach_m, spheres);
    }

    /// The value of one more term.
    pub(super) fn term(&mut self, term: &dyn Term) -> f64 {
        self.measure_layer();
        self.memory.forces.reset(&self.energy.hand);
        let (scene, forces) = self.scene();
        term.add(&scene, forces)
    }

    /// How much the elastic layer gives under single loads.
    pub(super) fn under_loads(&mut self, term: &LayerCompliance) -> LoadCompliance {
        self.measure_layer();
        let (scene, _) = self.scene();
        term.under_loads(&scene)
    }

    /// The energy; writes its derivative into `gradient`.
    pub(super) fn evaluate(&mut self, gradient: &mut [f64]) -> f64 {
        self.begin();
        let mut value = self.add_terms(Stage::Depths);
        value += self.add_terms(Stage::Pose);
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

    pub(super) fn terms(&mut self) -> Vec<(String, f64)> {
        self.begin();
        let terms = self.energy.terms.iter();
        let (scene, forces) = self.scene();
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
