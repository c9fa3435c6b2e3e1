//! What each surface point would cost as the last contact of a set: the law that heat-bath moves draw from.

use nalgebra::Vector6;

use super::{FIRST_BAND_M, GraspEnergy};
use crate::grasp::term::point_contact;

impl GraspEnergy {
    /// Costs of every surface point as the contact that completes `others` at pose `x`: own cost plus force closure of
    /// the whole set, for points that cost at most `allowance` more than the cheapest own cost.
    pub fn completions(
        &self,
        x: &[f64],
        others: &[u32],
        distance_factor: f64,
        allowance: f64,
    ) -> Vec<(u32, f64)> {
        self.with_scratch(x, |scratch| {
            self.pose(x, scratch);
            let cost =
                |distance_m: f64| distance_factor * self.distance.cost(distance_m, self.unit_m);
            // At least this far points count, so their gradients will be asked for.
            let surely_m = self
                .distance
                .reach_m(allowance / distance_factor, self.unit_m);
            self.measure(FIRST_BAND_M, surely_m.min(FIRST_BAND_M), scratch);
            while !scratch.near.iter().any(|near| self.may_touch(near)) {
                self.measure(2.0 * scratch.band_m, 0.0, scratch);
            }
            let cheapest = scratch
                .near
                .iter()
                .map(|near| cost(near.distance_m))
                .min_by(f64::total_cmp)
                .unwrap_or(0.0);
            let reach_m = self
                .distance
                .reach_m((cheapest + allowance) / distance_factor, self.unit_m);
            self.measure(reach_m, reach_m, scratch);
            self.measure_contacts(others, scratch);
            let rest: Vector6<f64> = scratch
                .contacts
                .iter()
                .map(|c| point_contact(c, &self.object.centroid, self.unit_m).wrench())
                .sum();
            let wrench_cost = self.wrench_cost();
            scratch
                .near
                .iter()
                .filter(|near| self.may_touch(near) && !others.contains(&near.index))
                .filter_map(|near| {
                    let net = rest + self.contact_at(near)?.wrench();
                    let own = cost(near.distance_m);
                    Some((near.index, own + wrench_cost.of_squared(net.norm_squared())))
                })
                .collect()
        })
    }
}
