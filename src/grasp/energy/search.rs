//! The best contact set of a posed hand: which surface points are candidates, and when the search may end.

use super::scratch::Scratch;
use super::{FIRST_BAND_M, GraspEnergy};
use crate::grasp::closure::PointContact;
use crate::grasp::contact::{Candidate, WrenchCost};
use crate::grasp::term::NearPoint;
use crate::hand::PosedHand;

impl GraspEnergy {
    /// Fills `near` with the candidates of most poses and every point the penetration term asks about.
    pub(super) fn measure_candidates(&self, scratch: &mut Scratch) {
        let band_m = FIRST_BAND_M.max(self.penetration.clearance_m);
        self.measure(band_m, band_m, scratch);
    }

    /// Whether a surface point may be a contact.
    pub(super) fn may_touch(&self, near: &NearPoint) -> bool {
        self.may_touch[near.index as usize]
    }

    /// The contact that a surface point near the object would make; `None` where the object has no normal.
    pub(super) fn contact_at(&self, near: &NearPoint) -> Option<PointContact> {
        let gradient = near
            .gradient
            .unwrap_or_else(|| self.object.shape.gradient(&near.point).1);
        let length = gradient.norm();
        (length > 0.0).then(|| PointContact {
            arm: (near.point - self.object.centroid) / self.unit_m,
            inward_normal: -gradient / length,
        })
    }

    /// The candidate that a surface point near the object is; `None` where the object has no normal.
    pub(super) fn candidate(&self, near: &NearPoint, posed: &PosedHand) -> Option<Candidate> {
        let contact = self.contact_at(near)?;
        Some(Candidate {
            index: near.index,
            cost: self.own_cost(near, &contact, 1.0, posed),
            wrench: contact.wrench().into(),
        })
    }

    /// Cost of a contact that does not depend on the others, its distance weighted by `distance_factor`; the alignment
    /// counts from its least value.
    pub(super) fn own_cost(
        &self,
        near: &NearPoint,
        contact: &PointContact,
        distance_factor: f64,
        posed: &PosedHand,
    ) -> f64 {
        let distance = distance_factor * self.distance.cost(near.distance_m, self.unit_m);
        if self.alignment.weight == 0.0 {
            return distance;
        }
        let outward = self.hand.point_normal(posed, near.index as usize);
        let size = self.settings.contacts;
        distance + self.alignment.cost(&outward, &contact.inward_normal, size)
    }

    fn list_candidates(&self, scratch: &mut Scratch) {
        let may_touch = scratch.near.iter().filter(|near| self.may_touch(near));
        let candidates = may_touch.filter_map(|near| self.candidate(near, &scratch.posed));
        scratch.search.begin(candidates);
    }

    /// Fills `near` and the list of candidates from a wider band.
    fn widen(&self, band_m: f64, scratch: &mut Scratch) {
        self.measure(band_m, band_m, scratch);
        self.list_candidates(scratch);
    }

    pub(super) fn wrench_cost(&self) -> WrenchCost {
        WrenchCost {
            weight: self.force_closure.weight,
            form: self.force_closure.form,
            rounding: self.force_closure.rounding,
        }
    }

    /// Leaves the best contact set at the posed hand in `scratch.search` and returns its contact energy, or a lower
    /// bound of it above `cutoff`; the alignment counts from its least value, so that no cost is negative.
    ///
    /// With a rank weight the set is the minimum of the other contact terms: the rank term is zero but for degenerate
    /// sets, and its value is added to the energy.
    pub(super) fn search(&self, cutoff: f64, scratch: &mut Scratch) -> f64 {
        self.list_candidates(scratch);
        self.search_listed(cutoff, scratch)
    }

    /// [`GraspEnergy::search`] among the candidates listed, and further ones where they could matter.
    fn search_listed(&self, cutoff: f64, scratch: &mut Scratch) -> f64 {
        let size = self.settings.contacts;
        let cost = self.wrench_cost();
        loop {
            let band_m = scratch.band_m;
            let everything = scratch.near.len() == self.hand.surface.len();
            if scratch.search.len() < size && !everything {
                self.widen(2.0 * band_m, scratch);
                continue;
            }
            let floor = scratch.search.floor(size);
            if floor > cutoff {
                return floor;
            }
            let total = scratch.search.descend(size, &scratch.warm, &cost);
            // A member of a better set costs at most what the others leave of the total. Of others outside the band nothing
            // but the distance is sure to cost something.
            let outside = self.distance.cost(band_m, self.unit_m);
            let others = scratch.search.floor_with(size - 1, outside);
            let needed_m = self
                .distance
                .reach_m(total.min(cutoff) - others, self.unit_m);
            if needed_m > band_m && !everything {
                // Also when few candidates made the first total poor: the wider list has a better one.
                remember(scratch);
                self.widen(needed_m.min(2.0 * band_m), scratch);
                continue;
            }
            let least = scratch.search.prove(size, &cost, cutoff);
            remember(scratch);
            return least;
        }
    }

    /// As [`GraspEnergy::search`], but without proof where a good set costs more than `ceiling`; never looks at what was
    /// remembered, so that the answer depends on the pose alone.
    pub(super) fn search_roughly_above(&self, ceiling: f64, scratch: &mut Scratch) -> f64 {
        let size = self.settings.contacts;
        let cost = self.wrench_cost();
        self.list_candidates(scratch);
        while scratch.search.len() < size && scratch.near.len() < self.hand.surface.len() {
            self.widen(2.0 * scratch.band_m, scratch);
        }
        let total = scratch.search.descend_cold(size, &cost, ceiling);
        if total > ceiling {
            return total;
        }
        self.search_listed(f64::INFINITY, scratch)
    }
}

/// Keeps the best set found as the start of the next search.
fn remember(scratch: &mut Scratch) {
    scratch.warm.clear();
    scratch.warm.extend_from_slice(scratch.search.best());
}
