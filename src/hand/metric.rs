//! The metric of the pose space: how far a motion of the hand moves its surface.

use nalgebra::Vector3;

use super::model::within;
use super::{Hand, HandError, JointKind, PosedHand};
use crate::limits::METRIC_LENGTH;
use crate::space::PoseMetric;

/// Least length for a joint, also if it moves almost nothing, metres per radian.
const LEAST_LEVER_M: f64 = 1e-3;

impl Hand {
    /// The metric of this hand's pose space, from its area-weighted surface points in the rest pose.
    ///
    /// ```text
    /// c = Σ A p / Σ A                          r² = Σ A |p − c|² / Σ A
    /// ℓⱼ² = Σ_{moved} A d² / Σ_{all} A         reachⱼ² = Σ_{moved} A d² / Σ_{moved} A
    /// ```
    ///
    /// d: distance of a point from the axis of joint j. The reach of a rotation of the whole hand is the root-mean-square
    /// distance of the digits' points from c, since digits make most contacts. No lever is less than 1 mm.
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

        let (joint_levers_m, joint_reaches_m) = (0..self.joints.len())
            .map(|j| {
                let (mut moved_area, mut moved_second) = (0.0, 0.0);
                for (at, p) in weighted() {
                    if let Some(velocity) = self.velocity(&rest, j, at.link.0, p) {
                        moved_area += at.area_m2;
                        moved_second += at.area_m2 * velocity.norm_squared();
                    }
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
        let mut metric = PoseMetric {
            centroid,
            radius_of_gyration_m,
            joint_levers_m,
            joint_reaches_m,
            rotation_reach_m: rotation_reach_m.max(LEAST_LEVER_M),
            wraps: self.joints.iter().map(|joint| joint.wraps).collect(),
        };
        self.override_metric(&mut metric);
        metric
    }

    /// Velocity of point `p` of link `link` per unit of joint `j`; `None` if the joint does not move it.
    fn velocity(
        &self,
        posed: &PosedHand,
        j: usize,
        link: usize,
        p: &Vector3<f64>,
    ) -> Option<Vector3<f64>> {
        let mut total: Option<Vector3<f64>> = None;
        let mut at = Some(link);
        while let Some(l) = at {
            if let Some(motion) = self.links[l].motion.filter(|motion| motion.joint == j) {
                let frame = &posed.object_from_link[l];
                let axis = frame.direction(&motion.axis);
                let own = match motion.kind {
                    JointKind::Hinge => axis.cross(&(p - frame.translation)),
                    JointKind::Slide => axis,
                } * motion.ratio;
                total = Some(total.map_or(own, |total| total + own));
            }
            let parent = self.links[l].parent;
            if let (Some(blend), Some(ball), Some(parent)) =
                (&self.blend, self.links[l].ball, parent)
            {
                let rate = blend.rate(posed, ball, j);
                let carrier =
                    posed.object_from_link[parent.0].compose(&self.links[l].parent_from_link);
                let own = carrier.direction(&rate).cross(&(p - carrier.translation));
                if rate != Vector3::zeros() {
                    total = Some(total.map_or(own, |total| total + own));
                }
            }
            at = parent.map(|parent| parent.0);
        }
        total
    }

    /// Replaces lengths by those of the side file.
    fn override_metric(&self, metric: &mut PoseMetric) {
        let given = &self.metric;
        if let Some(radius) = given.radius_of_gyration_m {
            metric.radius_of_gyration_m = radius;
        }
        if let Some(reach) = given.rotation_reach_m {
            metric.rotation_reach_m = reach;
        }
        for (j, joint) in self.joints.iter().enumerate() {
            if let Some(&lever) = given.levers_m.get(&joint.name) {
                metric.joint_levers_m[j] = lever;
            }
            if let Some(&reach) = given.reaches_m.get(&joint.name) {
                metric.joint_reaches_m[j] = reach;
            }
        }
    }

    /// Refuses lengths of the side file that are beyond their limit or belong to joints that the hand does not have.
    pub(super) fn check_metric(&self) -> Result<(), HandError> {
        let given = &self.metric;
        let single = [given.radius_of_gyration_m, given.rotation_reach_m];
        let single = single.into_iter().flatten();
        let lists = || given.levers_m.iter().chain(&given.reaches_m);
        if let Some((name, _)) = lists().find(|(name, _)| self.joint(name).is_none()) {
            return Err(HandError::Unknown {
                place: "\"metric\" of the side file".to_owned(),
                kind: "joint",
                name: name.clone(),
            });
        }
        let mut lengths = single.chain(lists().map(|(_, length)| *length));
        let place = || "a length in \"metric\" of the side file".to_owned();
        lengths.try_for_each(|length| within(METRIC_LENGTH, length, place))
    }
}
