//! Questions about one pose that filters, pictures and reports ask.

use nalgebra::Vector3;

use super::GraspEnergy;
use crate::grasp::closure::PointContact;
use crate::grasp::term::{NearPoint, for_each_intruder, point_contact};

/// A path whose top buries hand or object deeper than this passes through the object.
pub const THROUGH_M: f64 = 0.002;

impl GraspEnergy {
    /// The contacts of `choice` at pose `x` as the force-closure tests see them, arms divided by the unit.
    pub fn point_contacts(&self, x: &[f64], choice: &[u32]) -> Vec<PointContact> {
        self.with_scratch(x, |scratch| {
            self.pose(x, scratch);
            self.measure_contacts(choice, scratch);
            scratch
                .contacts
                .iter()
                .map(|c| point_contact(c, &self.object.centroid, self.unit_m))
                .collect()
        })
    }

    /// Deepest point at pose `x`: of the hand's surface inside the object or of the object's samples inside the hand,
    /// metres, 0 where nothing overlaps. Measured on the smooth shape.
    pub fn deepest_m(&self, x: &[f64]) -> f64 {
        self.with_scratch(x, |scratch| {
            self.pose(x, scratch);
            self.measure(0.0, 0.0, scratch);
            scratch
                .proximity
                .update_intruders(&self.hand, &scratch.posed, &self.object);
            let deepest = |d: f64, near: &NearPoint| d.max(-near.distance_m);
            let mut deepest = scratch.near.iter().fold(0.0, deepest);
            for_each_intruder(&self.scene(x, scratch), |_, _, _, depth| {
                deepest = deepest.max(depth);
            });
            deepest
        })
    }

    /// Least signed distance of a surface point of the hand from the object at pose `x`, metres.
    pub fn clearance_m(&self, x: &[f64]) -> f64 {
        self.with_scratch(x, |scratch| {
            self.pose(x, scratch);
            let points = (0..self.hand.surface.len())
                .map(|index| self.hand.surface_point(&scratch.posed, index));
            let distances = points.map(|p| self.object.shape.distance(&p));
            distances.fold(f64::INFINITY, f64::min)
        })
    }

    /// Mean of the contact points of `choice` at pose `x`, object frame, metres.
    pub fn contact_centre(&self, x: &[f64], choice: &[u32]) -> Vector3<f64> {
        self.with_scratch(x, |scratch| {
            self.pose(x, scratch);
            let points = choice
                .iter()
                .map(|&index| self.hand.surface_point(&scratch.posed, index as usize));
            points.sum::<Vector3<f64>>() / choice.len().max(1) as f64
        })
    }
}
