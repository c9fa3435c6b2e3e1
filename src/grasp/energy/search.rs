//! The best contact set of a posed hand: choice of candidates and end of the search.

use super::evaluation::Evaluation;
use super::{FIRST_BAND_M, GraspEnergy};
use crate::grasp::closure::PointContact;
use crate::grasp::contact::{Candidate, WrenchCost};
use crate::grasp::filter::MOST_GAP_M;
use crate::grasp::term::NearPoint;
use crate::hand::PosedHand;

impl GraspEnergy {
    pub(super) fn may_touch(&self, near: &NearPoint) -> bool {
        self.may_touch[near.index as usize]
    }

    /// The contact at a surface point near the object; `None` if the object has no normal there.
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

    /// The candidate at a surface point near the object; `None` if the object has no normal there.
    pub(super) fn candidate(&self, near: &NearPoint, posed: &PosedHand) -> Option<Candidate> {
        let contact = self.contact_at(near)?;
        Some(Candidate {
            index: near.index,
            cost: self.own_cost(near, &contact, 1.0, posed),
            wrench: contact.wrench().into(),
        })
    }

    /// Cost of a contact by itself, with its distance times `distance_factor` and its alignment relative to the minimum.
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
    /// Fills `near` with the usual candidates and all points that may violate the clearance.
    pub(super) fn measure_candidates(&mut self) {
        let band_m = FIRST_BAND_M.max(self.energy.clearance_m);
        self.measure(band_m, band_m);
    }

    fn list_candidates(&mut self) {
        self.list_candidates_within(f64::INFINITY);
    }

    /// Lists the measured points that are at most `most_m` from the object's surface, either way.
    fn list_candidates_within(&mut self, most_m: f64) {
        let (energy, memory) = (self.energy, &mut *self.memory);
        let is_within = |near: &&NearPoint| near.distance_m.abs() <= most_m;
        let may_touch = memory.near.iter().filter(|near| energy.may_touch(near));
        let may_touch = may_touch.filter(is_within);
        let candidates = may_touch.filter_map(|near| energy.candidate(near, &memory.posed));
        memory.search.begin(candidates);
    }

    fn widen(&mut self, band_m: f64) {
        self.measure(band_m, band_m);
        self.list_candidates();
    }

    /// Finds the best set of points that touch the object ([`MOST_GAP_M`]) and leaves it in `memory.search`. Returns
    /// `false` if fewer touch than a set has.
    pub(super) fn choose_touching_contacts(&mut self) -> bool {
        self.list_candidates_within(MOST_GAP_M);
        let (size, cost) = (self.energy.settings.contacts, self.energy.wrench_cost());
        let search = &mut self.memory.search;
        if search.len() < size {
            return false;
        }
        search.descend(size, &[], &cost);
        search.prove(size, &cost, f64::INFINITY);
        true
    }

    /// Finds the best contact set of the posed hand, leaves it in `memory.search` and returns its contact energy (or a
    /// lower bound above `cutoff`). The alignment is relative to its minimum, so that no cost is negative.
    ///
    /// With a rank weight the set minimises the other contact terms only. The rank term is added; it is mostly zero.
    pub(super) fn choose_contacts(&mut self, cutoff: f64) -> f64 {
        self.list_candidates();
        self.choose_among_listed(cutoff)
    }

    /// Like [`Evaluation::choose_contacts`], with the listed candidates and others where they could matter.
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
            // A member of a better set costs at most the total minus the others. Outside the band only the distance is
            // certain.
            let outside = energy.distance.cost(band_m, unit_m);
            let others = memory.search.floor_with(size - 1, outside);
            let needed_m = energy.distance.reach_m(total.min(cutoff) - others, unit_m);
            if needed_m > band_m && !everything {
                // This includes a poor total from too few candidates, which the wider list improves.
                self.remember();
                self.widen(needed_m.min(2.0 * band_m));
                continue;
            }
            let least = memory.search.prove(size, &cost, cutoff);
            self.remember();
            return least;
        }
    }

    /// Like [`Evaluation::choose_contacts`], but without proof if a good set costs more than `ceiling`. It ignores the
    /// previous set, so that the result depends only on the pose.
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

    /// Stores the best set as the start of the next search.
    fn remember(&mut self) {
        let memory = &mut *self.memory;
        memory.warm.clear();
        memory.warm.extend_from_slice(memory.search.best());
    }
}
