//! Forward kinematics and its transpose.

use nalgebra::{Matrix3, Unit, Vector3};

use super::blend::Blend;
use super::{Frame, Hand, JointKind, Link, PosedHand, Wrench};
use crate::space::{PoseMetric, joints_of, quaternion_of, translation_of};

impl Hand {
    /// Poses the hand at `x = [t, q(wxyz), joints]`: `object_from_hand` of the root frame, metres and radians.
    ///
    /// The quaternion need not be of unit length. Writes link frames, surface points and capsule axes into `posed`,
    /// which is resized on first use and reused from then on.
    ///
    /// # Panics
    /// If `x` does not have 7 numbers more than the hand has joints.
    pub fn pose(&self, x: &[f64], posed: &mut PosedHand) {
        self.pose_links(x, posed);
        posed.points.resize(self.surface.len(), Vector3::zeros());
        if let Some(blend) = &self.blend {
            let mut points = std::mem::take(&mut posed.points);
            for (index, point) in points.iter_mut().enumerate() {
                *point = blend.point(posed, index);
            }
            posed.points = points;
            return;
        }
        for (frame, range) in posed.object_from_link.iter().zip(&self.link_points) {
            for (posed_point, point) in posed.points[range.clone()]
                .iter_mut()
                .zip(&self.surface[range.clone()])
            {
                *posed_point = frame.point(&point.point);
            }
        }
    }

    /// As [`Hand::pose`], but without surface points: [`PosedHand::points`] is left empty. For callers that need only
    /// a few points ([`Hand::surface_point`]).
    ///
    /// # Panics
    /// If `x` does not have 7 numbers more than the hand has joints.
    pub fn pose_links(&self, x: &[f64], posed: &mut PosedHand) {
        assert_eq!(
            x.len(),
            7 + self.joints.len(),
            "coordinates are [t, q(wxyz), joints]"
        );
        posed.points.clear();
        posed
            .object_from_link
            .resize(self.links.len(), Frame::default());
        posed
            .capsules
            .resize(self.capsules.len(), [Vector3::zeros(); 2]);

        if let Some(blend) = &self.blend {
            blend.prepare(joints_of(x), posed);
        }
        for (l, link) in self.links.iter().enumerate() {
            let parent = match link.parent {
                Some(parent) => posed.object_from_link[parent.0],
                None => base_frame(x),
            };
            let mut frame = link.frame_in(&parent, joints_of(x));
            if let Some(ball) = link.ball {
                frame.rotation *= Blend::ball(posed, ball);
            }
            posed.object_from_link[l] = frame;
        }
        for (ends, capsule) in posed.capsules.iter_mut().zip(&self.capsules) {
            let frame = &posed.object_from_link[capsule.link.0];
            *ends = [frame.point(&capsule.a), frame.point(&capsule.b)];
        }
    }

    /// Surface point `index`, object frame, metres.
    ///
    /// # Panics
    /// If there is no such point.
    #[inline]
    pub fn surface_point(&self, posed: &PosedHand, index: usize) -> Vector3<f64> {
        if let Some(blend) = &self.blend {
            return blend.point(posed, index);
        }
        let point = &self.surface[index];
        posed.object_from_link[point.link.0].point(&point.point)
    }

    /// Outward unit normal of surface point `index`, object frame.
    ///
    /// # Panics
    /// If there is no such point.
    #[inline]
    pub fn point_normal(&self, posed: &PosedHand, index: usize) -> Vector3<f64> {
        if let Some(blend) = &self.blend {
            return blend.normal(posed, index);
        }
        let point = &self.surface[index];
        posed.object_from_link[point.link.0].direction(&point.normal)
    }

    /// Pulls gradients on links and joints back to the tangent of the pose space:
    ///
    /// ```text
    /// ∂E/∂θⱼ = aⱼ·(Mⱼ − oⱼ × Fⱼ) + hⱼ        F, M: sums over the links that joint j moves
    /// gradient = [F, Rᵀ(M − c × F)/r, ∂E/∂θⱼ/ℓⱼ]
    /// ```
    ///
    /// `wrenches`: one [`Wrench`] per link, object frame; `joint_gradient`: hⱼ, the gradient with respect to the
    /// coordinates themselves; `aⱼ`, `oⱼ`: axis and origin of joint j (a slide has aⱼ·Fⱼ; joints that follow j add
    /// their share); `c`: the metric's centroid, posed; `r`, `ℓⱼ`: radius of gyration and levers of `metric`. `posed`
    /// must be the hand at the point of the tangent space.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn pull_back(
        &self,
        posed: &PosedHand,
        wrenches: &[Wrench],
        joint_gradient: &[f64],
        metric: &PoseMetric,
        gradient: &mut [f64],
    ) {
        assert_eq!(wrenches.len(), self.links.len(), "one wrench a link");
        assert_eq!(
            joint_gradient.len(),
            self.joints.len(),
            "one number a joint"
        );
        assert_eq!(
            gradient.len(),
            6 + self.joints.len(),
            "one number a tangent"
        );

        let object_from_hand = &posed.object_from_link[0];
        let total = sum(wrenches);
        let centroid = object_from_hand.point(&metric.centroid);
        let moment = object_from_hand
            .rotation
            .tr_mul(&(total.moment - centroid.cross(&total.force)));
        gradient[..3].copy_from_slice(total.force.as_slice());
        gradient[3..6].copy_from_slice((moment / metric.radius_of_gyration_m).as_slice());

        gradient[6..].fill(0.0);
        for (first, link) in self.links.iter().enumerate() {
            if let (Some(blend), Some(ball), Some(parent)) = (&self.blend, link.ball, link.parent) {
                let moved = sum(&wrenches[first..self.subtree_ends[first]]);
                let origin = posed.object_from_link[first].translation;
                let carrier = posed.object_from_link[parent.0].compose(&link.parent_from_link);
                let moment = carrier
                    .rotation
                    .tr_mul(&(moved.moment - origin.cross(&moved.force)));
                blend.pull_back(posed, ball, &moment, &mut gradient[6..]);
            }
            let Some(motion) = &link.motion else { continue };
            let moved = sum(&wrenches[first..self.subtree_ends[first]]);
            let frame = &posed.object_from_link[first];
            let axis = frame.direction(&motion.axis);
            let work = match motion.kind {
                JointKind::Hinge => {
                    axis.dot(&(moved.moment - frame.translation.cross(&moved.force)))
                }
                JointKind::Slide => axis.dot(&moved.force),
            };
            gradient[6 + motion.joint] += motion.ratio * work;
        }
        for (j, slope) in gradient[6..].iter_mut().enumerate() {
            *slope = (*slope + joint_gradient[j]) / metric.joint_levers_m[j];
        }
    }
}

impl Link {
    /// Frame of the link for these joint coordinates, in the frame in which `parent` is that of its parent. A ball joint does
    /// not turn it.
    #[inline]
    pub(super) fn frame_in(&self, parent: &Frame, joints: &[f64]) -> Frame {
        let mut frame = parent.compose(&self.parent_from_link);
        if let Some(motion) = &self.motion {
            let displacement = motion.ratio * joints[motion.joint] + motion.offset;
            moved(&mut frame, motion.kind, &motion.axis, displacement);
        }
        frame
    }
}

/// Moves a frame by the displacement of a joint along or about a unit axis of this frame.
#[inline]
pub(super) fn moved(frame: &mut Frame, kind: JointKind, axis: &Vector3<f64>, displacement: f64) {
    match kind {
        JointKind::Hinge => frame.rotation *= rotation_about(axis, displacement),
        JointKind::Slide => frame.translation += frame.rotation * (axis * displacement),
    }
}

fn base_frame(x: &[f64]) -> Frame {
    let quaternion = quaternion_of(x);
    let (w, v) = (quaternion.w, quaternion.imag());
    let s = 2.0 / (w * w + v.norm_squared());
    let k = Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0);
    Frame {
        rotation: Matrix3::identity() + (k * w + k * k) * s,
        translation: translation_of(x),
    }
}

/// Rodrigues' formula for a unit axis.
#[inline]
fn rotation_about(axis: &Vector3<f64>, angle_rad: f64) -> Matrix3<f64> {
    *nalgebra::Rotation3::from_axis_angle(&Unit::new_unchecked(*axis), angle_rad).matrix()
}

fn sum(wrenches: &[Wrench]) -> Wrench {
    wrenches
        .iter()
        .fold(Wrench::default(), |total, wrench| Wrench {
            force: total.force + wrench.force,
            moment: total.moment + wrench.moment,
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hand::LinkId;
    use crate::space::{PoseSpace, Space, Symmetry};

    /// A quadratic energy of all points, capsule ends and angles against central differences along the tangents of the
    /// pose space, at a pose far from rest.
    #[test]
    fn pull_back_is_the_gradient_along_the_tangents() {
        // Hinges; a slide that another one follows; hinges in links that are boxes.
        for name in ["human", "gripper_parallel", "gripper_three_finger"] {
            check_pull_back(&Hand::named(name).unwrap());
        }
    }

    fn check_pull_back(hand: &Hand) {
        let metric = hand.pose_metric();
        let space = PoseSpace::new(metric.clone(), Symmetry::None);
        let target = Vector3::new(0.05, -0.02, 0.11);
        let angle_energy = |x: &[f64]| 1e-4 * joints_of(x).iter().map(|q| q * q).sum::<f64>();
        let energy = |x: &[f64]| {
            let mut posed = PosedHand::default();
            hand.pose(x, &mut posed);
            let points = posed.points.iter().enumerate();
            points
                .map(|(i, p)| (1.0 + i as f64 / 500.0) * (p - target).norm_squared())
                .sum::<f64>()
                + hand.point_normal(&posed, 700).z * 0.01
                + angle_energy(x)
        };
        let mut x = hand.rest_coordinates();
        let tangent: Vec<f64> = (0..space.tangents())
            .map(|i| 0.02 * libm::sin((i * i) as f64))
            .collect();
        space.exp(&mut x, &tangent);

        let mut posed = PosedHand::default();
        hand.pose(&x, &mut posed);
        let mut wrenches = vec![Wrench::default(); hand.links.len()];
        for (i, (p, at)) in posed.points.iter().zip(&hand.surface).enumerate() {
            wrenches[at.link.0].add(p, &((p - target) * 2.0 * (1.0 + i as f64 / 500.0)));
        }
        // A gradient m with respect to a normal n is a pure moment n × m.
        let normal = hand.point_normal(&posed, 700);
        wrenches[hand.surface[700].link.0].moment += normal.cross(&(Vector3::z() * 0.01));
        let joint_gradient: Vec<f64> = joints_of(&x).iter().map(|q| 2e-4 * q).collect();
        let mut gradient = vec![0.0; space.tangents()];
        hand.pull_back(&posed, &wrenches, &joint_gradient, &metric, &mut gradient);

        for i in 0..space.tangents() {
            let along = |step: f64| {
                let mut tangent = vec![0.0; space.tangents()];
                tangent[i] = step;
                let mut moved = x.clone();
                space.exp(&mut moved, &tangent);
                energy(&moved)
            };
            let step = 1e-6;
            let difference = (along(step) - along(-step)) / (2.0 * step);
            let error = (gradient[i] - difference).abs() / (1.0 + difference.abs());
            assert!(
                error < 1e-6,
                "tangent {i}: {} against {difference}",
                gradient[i]
            );
        }
    }

    #[test]
    fn subtrees_are_contiguous() {
        let hand = Hand::human();
        for (l, link) in hand.links.iter().enumerate() {
            let mut above = link.parent;
            while let Some(LinkId(parent)) = above {
                assert!(parent < l && l < hand.subtree_ends[parent]);
                above = hand.links[parent].parent;
            }
        }
    }
}
