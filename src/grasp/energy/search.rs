//! The best contact set of a posed hand: which surface points are candidates, and when the search may end.

use super::GraspEnergy;
use super::scratch::Scratch;
use crate::grasp::closure::PointContact;
use crate::grasp::contact::{Candidate, WrenchCost};

impl GraspEnergy {
    pub(super) fn candidates(&self, scratch: &mut Scratch) {
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

    pub(super) fn wrench_cost(&self) -> WrenchCost {
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
    pub(super) fn search(&self, cutoff: f64, scratch: &mut Scratch) -> f64 {
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
    pub(super) fn search_roughly_above(&self, ceiling: f64, scratch: &mut Scratch) -> f64 {
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
}
