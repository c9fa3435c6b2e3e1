//! The score by which start poses are chosen, far from any grasp.

use super::evaluation::Evaluation;
use super::{GraspEnergy, Ramp};
use crate::grasp::term::NearPoint;

/// Approximate number of evenly selected surface points, enough to tell whether the hand can enclose the object.
const POINTS: usize = 200;

impl GraspEnergy {
    /// A good contact set at pose `x` with the weights of `ramp`, and its energy. The energy is low if the hand encloses
    /// the object, even if its surface is centimetres away. It is an upper bound of the minimum over contact sets (without
    /// the rank condition), found by coordinate descents over about two hundred surface points.
    pub fn start_score(&self, x: &[f64], ramp: Ramp) -> (f64, Vec<u32>) {
        let size = self.settings.contacts;
        let stride = (self.contact_candidates.len() / POINTS.max(size)).max(1);
        self.at(x, |evaluation| {
            let memory = &mut *evaluation.memory;
            let posed = &memory.posed;
            let indices = self.contact_candidates.iter().step_by(stride);
            let candidates = indices.filter_map(|&index| {
                let point = self.hand.surface_point(posed, index as usize);
                let (distance_m, gradient) = self.object.shape.gradient(&point);
                let near = NearPoint {
                    index,
                    point,
                    distance_m,
                    gradient: Some(gradient),
                };
                let mut candidate = self.candidate(&near, posed)?;
                candidate.cost *= ramp.distance;
                Some(candidate)
            });
            memory.search.begin(candidates);
            let cost = self.wrench_cost();
            let contacts = memory.search.descend_cold(size, &cost, 0.0);
            let set = memory.search.best().to_vec();
            let free = evaluation.ramped(ramp, Evaluation::contact_free);
            (free + contacts, set)
        })
    }
}
