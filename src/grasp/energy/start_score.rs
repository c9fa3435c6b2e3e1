//! The score by which starts are chosen: what a pose promises before it is anywhere near a grasp.

use super::evaluation::Evaluation;
use super::{GraspEnergy, Ramp};
use crate::grasp::term::NearPoint;

/// About so many surface points are looked at, evenly taken: enough to tell whether the hand can enclose the object.
const POINTS: usize = 200;

impl GraspEnergy {
    /// A good contact set at pose `x` with weights softened by `ramp`, and the energy with it: low where the hand encloses
    /// the object, though its surface may be centimetres away.
    ///
    /// An upper bound of the softened energy's minimum over contact sets (without the rank condition), found by coordinate
    /// descents among some two hundred surface points.
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
