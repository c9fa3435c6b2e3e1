//! The best contact set of a posed hand: which surface points are candidates, and when the search may end.

use super::evaluation::Evaluation;
use super::{FIRST_BAND_M, GraspEnergy};
use crate::grasp::closure::PointContact;
use crate::grasp::contact::{Candidate, WrenchCost};
use crate::grasp::term::NearPoint;
use crate::hand::PosedHand;

impl GraspEnergy {
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

    pub(super) fn wrench_cost(&self) -> WrenchCost {
        WrenchCost {
            weight: self.settings.force_closure_weight,
            form: self.settings.force_closure_form,
            rounding: self.settings.force_closure_rounding,
        }
    }
}

impl Evaluation<'_> {
    /// Fills `near` with the candidates of most poses and every point that is asked whether it lies inside the object.
    pub(super) fn measure_candidates(&mut self) {
        let band_m = FIRST_BAND_M.max(self.energy.clearance_m);
        self.measure(band_m, band_m);
    }

    fn list_candidates(&mut self) {
        let (energy, memory) = (self.energy, &mut *self.memory);
        let may_touch = memory.near.iter().filter(|near| energy.may_touch(near));
        let candidates = may_touch.filter_map(|near| energy.candidate(near, &memory.posed));
        memory.search.begin(candidates);
    }

    /// Fills `near` and the list of candidates from a wider band.
    fn widen(&mut self, band_m: f64) {
        self.measure(band_m, band_m);
        self.list_candidates();
    }

    /// Leaves the best contact set at the posed hand in `memory.search` and returns its contact energy, or a lower bound of
    /// it above `cutoff`; the alignment counts from its least value, so that no cost is negative.
    ///
    /// With a rank weight the set is the minimum of the other contact terms: the rank term is zero but for degenerate
    /// sets, and its value is added to the energy.
    pub(super) fn choose_contacts(&mut self, cutoff: f64) -> f64 {
        self.list_candidates();
        self.choose_among_listed(cutoff)
    }

    /// [`Evaluation::choose_contacts`] among the candidates listed, and further ones where they could matter.
    fn choose_among_listed(&mut self, cutoff: f64) -> f64 {
        let energy = self.energy;
        let (size, unit_m, cost) = (
            energy.settings.contacts,
            energy.unit_m,
            energy.wrench_cost(),
        );
        loop {
            let memory = &mut *self.memory;
            let band_m = memory.band_m;
            let everything = memory.near.len() == energy.hand.surface.len();
            if memory.search.len() < size && !everything {
                self.widen(2.0 * band_m);
                continue;
            }
            let floor = memory.search.floor(size);
            if floor > cutoff {
                return floor;
            }
            let total = memory.search.descend(size, &memory.warm, &cost);
            // A member of a better set costs at most what the others leave of the total. Of others outside the band nothing
            // but the distance is sure to cost something.
            let outside = energy.distance.cost(band_m, unit_m);
            let others = memory.search.floor_with(size - 1, outside);
            let needed_m = energy.distance.reach_m(total.min(cutoff) - others, unit_m);
            if needed_m > band_m && !everything {
                // Also when few candidates made the first total poor: the wider list has a better one.
                self.remember();
                self.widen(needed_m.min(2.0 * band_m));
                continue;
            }
            let least = memory.search.prove(size, &cost, cutoff);
            self.remember();
            return least;
        }
    }

    /// As [`Evaluation::choose_contacts`], but without proof where a good set costs more than `ceiling`; never looks at what
    /// was remembered, so that the answer depends on the pose alone.
    pub(super) fn choose_contacts_roughly_above(&mut self, ceiling: f64) -> f64 {
        let (size, points) = (
            self.energy.settings.contacts,
            self.energy.hand.surface.len(),
        );
        let cost = self.energy.wrench_cost();
        self.list_candidates();
        while self.memory.search.len() < size && self.memory.near.len() < points {
            self.widen(2.0 * self.memory.band_m);
        }
        let total = self.memory.search.descend_cold(size, &cost, ceiling);
        if total > ceiling {
            return total;
        }
        self.choose_among_listed(f64::INFINITY)
    }

    /// Keeps the best set found as the start of the next search.
    fn remember(&mut self) {
        let memory = &mut *self.memory;
        memory.warm.clear();
        memory.warm.extend_from_slice(memory.search.best());
    }
}
