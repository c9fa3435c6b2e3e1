//! How far a move of the hand moves its surface.

use nalgebra::Vector3;

use super::{Hand, PosedHand};
use crate::space::PoseMetric;

/// A joint that moves next to nothing still needs a length, metres per radian.
const LEAST_LEVER_M: f64 = 1e-3;

impl Hand {
    /// The metric of this hand's pose space, from its area-weighted surface points in the rest pose.
    ///
    /// ```text
    /// c = Σ A p / Σ A                          r² = Σ A |p − c|² / Σ A
    /// ℓⱼ² = Σ_{moved} A d² / Σ_{all} A         reachⱼ² = Σ_{moved} A d² / Σ_{moved} A
    /// ```
    ///
    /// d: distance of a point from the axis of joint j. The reach of a turn of the whole hand is the root-mean-square
    /// distance of the digits' points from c, since those make most contacts. No lever is less than 1 mm.
    pub fn pose_metric(&self) -> PoseMetric {
        let mut rest = PosedHand::default();
        self.pose(&self.rest_coordinates(), &mut rest);
        let area: f64 = self.surface.iter().map(|point| point.area_m2).sum();
        let weighted = || self.surface.iter().zip(&rest.points);
        let centroid =
            weighted().fold(Vector3::zeros(), |sum, (at, p)| sum + p * at.area_m2) / area;
        let second: f64 = weighted()
            .map(|(at, p)| at.area_m2 * (p - centroid).norm_squared())
            .sum();
        let radius_of_gyration_m = (second / area).sqrt().max(LEAST_LEVER_M);

        let (mut digit_area, mut digit_second) = (0.0, 0.0);
        for (at, p) in weighted().filter(|(at, _)| self.links[at.link.0].digit > 0) {
            digit_area += at.area_m2;
            digit_second += at.area_m2 * (p - centroid).norm_squared();
        }
        let rotation_reach_m = if digit_area > 0.0 {
            (digit_second / digit_area).sqrt()
        } else {
            radius_of_gyration_m
        };

        let (joint_levers_m, joint_reaches_m) = (self.joints.iter())
            .map(|joint| {
                let first = joint.link.0;
                let frame = &rest.object_from_link[first];
                let axis = frame.direction(&joint.axis);
                let (mut moved_area, mut moved_second) = (0.0, 0.0);
                for (at, p) in weighted()
                    .filter(|(at, _)| (first..self.subtree_ends[first]).contains(&at.link.0))
                {
                    moved_area += at.area_m2;
                    moved_second +=
                        at.area_m2 * axis.cross(&(p - frame.translation)).norm_squared();
                }
                let reach = if moved_area > 0.0 {
                    (moved_second / moved_area).sqrt()
                } else {
                    0.0
                };
                (
                    (moved_second / area).sqrt().max(LEAST_LEVER_M),
                    reach.max(LEAST_LEVER_M),
                )
            })
            .unzip();
        PoseMetric {
            centroid,
            radius_of_gyration_m,
            joint_levers_m,
            joint_reaches_m,
            rotation_reach_m: rotation_reach_m.max(LEAST_LEVER_M),
            wraps: self.joints.iter().map(|joint| joint.wraps).collect(),
        }
    }
}
