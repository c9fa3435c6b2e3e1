//! Heat-bath weights for redrawing one contact.

use nalgebra::Vector6;

use super::evaluation::Evaluation;
use super::{FIRST_BAND_M, GraspEnergy};
use crate::grasp::term::point_contact;

impl GraspEnergy {
    /// Costs of surface points as the contact that completes `others` at pose `x`: own cost (distance times
    /// `distance_factor`, alignment relative to its minimum) plus force closure of the whole set, without the rank
    /// condition. All points that cost at most `allowance` more than the cheapest one are listed.
    pub fn heat_bath_costs(
        &self,
        x: &[f64],
        others: &[u32],
        distance_factor: f64,
        allowance: f64,
    ) -> Vec<(u32, f64)> {
        self.at(x, |evaluation| {
            evaluation.measure_contacts(others);
            let rest: Vector6<f64> = evaluation
                .memory
                .contacts
                .iter()
                .map(|c| point_contact(c, &self.object.centroid, self.unit_m).wrench())
                .sum();
            let reach_m = |cost: f64| self.distance.reach_m(cost / distance_factor, self.unit_m);
            // Points up to this distance always count, so their gradients are needed.
            let surely_m = reach_m(allowance);
            evaluation.measure(FIRST_BAND_M, surely_m.min(FIRST_BAND_M));
            let nearest_m = loop {
                let free = evaluation
                    .memory
                    .near
                    .iter()
                    .filter(|near| self.may_touch(near) && !others.contains(&near.index));
                if let Some(least) = free
                    .map(|near| near.distance_m.abs())
                    .min_by(f64::total_cmp)
                {
                    break least;
                }
                if evaluation.memory.near.len() == self.hand.surface.len() {
                    return Vec::new();
                }
                evaluation.measure(2.0 * evaluation.memory.band_m, 0.0);
            };
            // Some point costs no more than the cheapest one here. Only the distance is certain to cost something, so a
            // point is certainly too expensive only beyond the reach of that cost.
            let cheapest = distance_factor * self.distance.cost(nearest_m, self.unit_m);
            let near_m = reach_m(cheapest + allowance);
            evaluation.measure(near_m, near_m);
            let mut options = evaluation.options(others, &rest, distance_factor);
            let needed_m = reach_m(least_of(&options) + allowance);
            if needed_m > near_m {
                evaluation.measure(needed_m, needed_m);
                options = evaluation.options(others, &rest, distance_factor);
            }
            let most = least_of(&options) + allowance;
            options.retain(|(_, cost)| *cost <= most);
            options
        })
    }
}

impl Evaluation<'_> {
    /// Costs of the measured points that may complete `others`, which have the net wrench `rest`.
    fn options(
        &self,
        others: &[u32],
        rest: &Vector6<f64>,
        distance_factor: f64,
    ) -> Vec<(u32, f64)> {
        let (energy, memory) = (self.energy, &*self.memory);
        let wrench_cost = energy.wrench_cost();
        memory
            .near
            .iter()
            .filter(|near| energy.may_touch(near) && !others.contains(&near.index))
            .filter_map(|near| {
                let contact = energy.contact_at(near)?;
                let own = energy.own_cost(near, &contact, distance_factor, &memory.posed);
                let net = rest + contact.wrench();
                Some((near.index, own + wrench_cost.of_squared(net.norm_squared())))
            })
            .collect()
    }
}

fn least_of(options: &[(u32, f64)]) -> f64 {
    let costs = options.iter().map(|(_, cost)| *cost);
    costs.fold(f64::INFINITY, f64::min)
}
