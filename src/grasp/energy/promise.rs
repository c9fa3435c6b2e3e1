//! What a pose promises before it is anywhere near a grasp: the measure by which starts are chosen.

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
    pub fn promise(&self, x: &[f64], ramp: Ramp) -> (f64, Vec<u32>) {
        let size = self.settings.contacts;
        let stride = (self.contact_candidates.len() / POINTS.max(size)).max(1);
        self.with_scratch(x, |scratch| {
            self.pose(x, scratch);
            let posed = &scratch.posed;
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
            scratch.search.begin(candidates);
            let cost = self.wrench_cost();
            let contacts = scratch.search.descend_cold(size, &cost, 0.0);
            let set = scratch.search.best().to_vec();
            scratch.ramp = ramp;
            let free = self.contact_free(x, scratch);
            scratch.ramp = Ramp::default();
            (free + contacts, set)
        })
    }
}
