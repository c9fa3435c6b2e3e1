//! Undoes small errors of a pose before it is named: what is a little inside the object, or a little off it, is put on it.
//!
//! Poses that were measured, retargeted or drawn have joint angles that err by some hundredths of a radian; at a fingertip that
//! is a centimetre, more than what tells contact from none. The grasp that is named is the most probable one that touches.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::grasp::hand::{Hand, PosedHand, Wrench};
use crate::grasp::object::Object;
use crate::grasp::press;

/// How much is undone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settle {
    /// Error to be expected of a joint angle, standard deviation, radians.
    pub joint_rad: f64,
    /// Gap or depth to be expected of a bone that touches, standard deviation, metres.
    pub skin_m: f64,
    /// A bone farther from the object than this does not touch, metres; nearer ones are drawn to it the more, the nearer they
    /// are.
    pub reach_m: f64,
    /// A pose in which nothing is deeper than this and which touches with two parts or more needs no correction, metres.
    pub fair_m: f64,
}

impl Default for Settle {
    fn default() -> Self {
        Self {
            joint_rad: 0.1,
            skin_m: 1e-3,
            reach_m: 0.012,
            fair_m: 2.5e-3,
        }
    }
}

/// Steps of the search.
const STEPS: usize = 6;
/// It has come to rest when no angle changes more, radians.
const REST_RAD: f64 = 2e-3;

/// The pose near `x` that most probably was meant.
///
/// ```text
/// argmin over θ of Σ_b w(r_b) r_b²/skin² + |θ − θ₀|²/joint²,   w = 1 for r < 0, (1 − r²/reach²)² up to reach, else 0
/// ```
///
/// `r_b`: signed distance of each capsule of the hand from the object; θ₀: the joint angles of `x`, whose limits are kept. The
/// place of the palm stays. Gauss and Newton's steps with the weights of the step before (Tukey's biweight).
///
/// # Panics
/// If `x` does not have 7 numbers more than the hand has joints.
pub fn settled(hand: &Hand, object: &Object, x: &[f64], settle: &Settle) -> Vec<f64> {
    let joints = hand.joints.len();
    let no_joint = vec![0.0; joints];
    let metric = hand.pose_metric();
    let mut best = x.to_vec();
    let mut posed = PosedHand::default();
    let mut tangent = vec![0.0; 6 + joints];
    for step in 0..STEPS {
        hand.pose(&best, &mut posed);
        let near = press::touches(&object.exact, hand, &posed, settle.reach_m);
        let deepest = near.iter().map(|touch| touch.gap_m).fold(0.0, f64::min);
        if step == 0 && deepest > -settle.fair_m {
            return best;
        }
        let mut normal = DMatrix::<f64>::identity(joints, joints) / settle.joint_rad.powi(2);
        let mut right = DVector::from_iterator(
            joints,
            (0..joints).map(|j| (x[7 + j] - best[7 + j]) / settle.joint_rad.powi(2)),
        );
        for touch in &near {
            let off = touch.gap_m.max(0.0) / settle.reach_m;
            let weight = (1.0 - off * off).max(0.0).powi(2) / settle.skin_m.powi(2);
            let mut wrenches = vec![Wrench::default(); hand.links.len()];
            let outward: Vector3<f64> = -touch.inward_normal;
            wrenches[touch.link.0].add(&touch.on_hand, &outward);
            hand.pull_back(&posed, &wrenches, &no_joint, metric, &mut tangent);
            let slope = DVector::from_iterator(
                joints,
                (0..joints).map(|j| tangent[6 + j] * metric.joint_levers_m[j]),
            );
            normal += weight * &slope * slope.transpose();
            right -= weight * touch.gap_m * slope;
        }
        let Some(solved) = normal.cholesky().map(|factor| factor.solve(&right)) else {
            return best;
        };
        let mut largest: f64 = 0.0;
        for (j, joint) in hand.joints.iter().enumerate() {
            let [lower, upper] = joint.limits_rad;
            let from = best[7 + j];
            // A pose may be a hair beyond a limit as it comes.
            let to = (from + solved[j]).clamp(lower.min(from), upper.max(from));
            largest = largest.max((to - from).abs());
            best[7 + j] = to;
        }
        if largest < REST_RAD {
            break;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::hand::Hand;

    /// The ball in the bent hand.
    fn around_the_ball(hand: &Hand, ball: &Object) -> Vec<f64> {
        let mut x = hand.rest_coordinates();
        let away = hand.palm.centre + hand.palm.volar * 0.034;
        let root = ball.centroid - away;
        x[..3].copy_from_slice(root.as_slice());
        x[3..7].copy_from_slice(&[1.0, 0.0, 0.0, 0.0]);
        for (j, joint) in hand.joints.iter().enumerate() {
            if joint.name.ends_with("flexion") && !joint.name.starts_with("thumb") {
                x[7 + j] = 1.2_f64.min(joint.limits_rad[1]);
            }
        }
        x
    }

    #[test]
    fn what_is_inside_comes_out_and_what_is_fair_stays() {
        let hand = Hand::human();
        let ball = Object::named("ball").unwrap();
        let settle = Settle::default();
        let deepest = |x: &[f64]| {
            let mut posed = PosedHand::default();
            hand.pose(x, &mut posed);
            let near = press::touches(&ball.exact, &hand, &posed, 0.01);
            near.iter().map(|touch| touch.gap_m).fold(0.0, f64::min)
        };
        let inside = around_the_ball(&hand, &ball);
        assert!(deepest(&inside) < -0.004, "{}", deepest(&inside));
        let put = settled(&hand, &ball, &inside, &settle);
        assert!(
            deepest(&put) > 0.5 * deepest(&inside),
            "{} {}",
            deepest(&inside),
            deepest(&put)
        );
        assert_eq!(put[..7], inside[..7]);
        let mut far = inside;
        far[0] += 1.0;
        assert_eq!(settled(&hand, &ball, &far, &settle), far);
    }
}
