//! Corrects small errors of a pose before its type is named: surfaces slightly inside or off the object are put on it.
//!
//! Poses that were measured, retargeted or drawn have joint angles with errors of some hundredths of a radian. At a
//! fingertip that is a centimetre, more than the difference between contact and none. The intended pose may be any grasp
//! nearby that could hold: the contact forces must be able to balance, otherwise the digit nearest to the object is
//! missing, and hovering digits may or may not touch.

use std::cell::OnceCell;
use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, Vector3};

use crate::hand::{Hand, LinkId, PosedHand, Wrench};
use crate::object::Object;
use crate::space::{PoseMetric, joints_of_mut};

/// Size of the corrections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseCorrection {
    /// Expected error of a joint angle, standard deviation, radians.
    pub joint_rad: f64,
    /// Expected gap or depth of a bone that touches, standard deviation, metres.
    pub skin_m: f64,
    /// A bone farther from the object than this does not touch, metres; a nearer one is drawn to it more strongly.
    pub reach_m: f64,
    /// A pose in which nothing is deeper than this needs no correction of depths, metres.
    pub fair_m: f64,
    /// Surfaces nearer than this take part in the balance of forces, metres.
    pub touching_m: f64,
    /// If forces cannot balance, digits up to this far from the object are closed, metres: three errors of a joint at the
    /// length of a finger.
    pub missing_m: f64,
    /// If the original pose could not hold, digits up to this far from the object may have been meant to touch too, metres:
    /// half of `missing_m`.
    pub hovering_m: f64,
    /// Friction at which forces must balance.
    pub friction: f64,
}

impl Default for PoseCorrection {
    fn default() -> Self {
        Self {
            joint_rad: 0.1,
            skin_m: 1e-3,
            reach_m: 0.008,
            fair_m: 2.5e-3,
            touching_m: 3e-3,
            missing_m: 0.03,
            hovering_m: 0.015,
            friction: 0.6,
        }
    }
}

/// Largest number of steps of a search.
const STEPS: usize = 6;
/// A search ends when no angle changes by more than this, radians.
const REST_RAD: f64 = 2e-3;
/// Gap below which a closed digit touches, and gap at which the search for it may stop, metres.
const CLOSED_M: f64 = 2e-3;
const NEAR_ENOUGH_M: f64 = 5e-4;
/// Edges of a friction cone, steps of the search for balance, and the residual force that counts as zero, as a share.
const EDGES: u32 = 6;
const BALANCING: usize = 400;
const BALANCED: f64 = 0.15;

/// Number of places along the axis of a capsule where its distance is evaluated.
const PLACES: u32 = 8;

/// A capsule near the object. Its distance comes from the object's field at a few places, a hundred times cheaper than from
/// the mesh.
struct NearbyCapsule {
    link: LinkId,
    /// Signed distance of the capsule, metres.
    gap_m: f64,
    /// Its point nearest to the object, object frame.
    on_hand: Vector3<f64>,
    /// Unit normal into the object at that point.
    inward_normal: Vector3<f64>,
}

/// A hand near an object.
struct Near<'a> {
    hand: &'a Hand,
    object: &'a Object,
    correction: &'a PoseCorrection,
    /// Metric of the hand, computed when first needed.
    metric: OnceCell<PoseMetric>,
}

/// The poses that `x` may mean, at least one.
///
/// ```text
/// argmin over θ of Σ_b w(r_b) r_b²/skin² + |θ − θ₀|²/joint²,   w = 1 for r < 0, (1 − r²/reach²)² up to reach, else 0
/// ```
///
/// `r_b`: signed distance of each capsule of the hand from the object; θ₀: the joint angles of `x`, whose limits are kept.
/// The palm does not move. The solver is Gauss–Newton with weights from the previous step (Tukey's biweight). Then, while
/// the contact forces cannot sum to zero, the nearest digit that does not touch but can be closed is closed, by the
/// smallest change of its angles. The result is the first reading. Each further reading has one more of the hovering digits
/// closed. A pose with nothing inside and with balanced forces is its own only reading.
///
/// # Panics
/// If `x` does not have 7 numbers more than the hand has joints.
pub fn readings(
    hand: &Hand,
    object: &Object,
    x: &[f64],
    correction: &PoseCorrection,
) -> Vec<Vec<f64>> {
    let near = Near {
        hand,
        object,
        correction,
        metric: OnceCell::new(),
    };
    let mut posed = PosedHand::default();
    if near.could_hold(x, &mut posed) {
        return vec![x.to_vec()];
    }
    let mut readings = vec![near.put_on(x)];
    for _ in 1..hand.digits.len() {
        let last = &readings[readings.len() - 1];
        let balanced = near.balanced(last, &mut posed);
        let reach_m = if balanced {
            correction.hovering_m
        } else {
            correction.missing_m
        };
        let Some(completed) = near.completed(last, reach_m) else {
            break;
        };
        if !balanced {
            readings.clear();
        }
        readings.push(completed);
    }
    readings
}

impl Near<'_> {
    /// The capsules nearer than `reach_m`.
    fn touches(&self, x: &[f64], reach_m: f64, posed: &mut PosedHand) -> Vec<NearbyCapsule> {
        self.hand.pose(x, posed);
        let shape = &self.object.shape;
        let capsules = self.hand.capsules.iter().zip(&posed.capsules);
        let near = capsules.filter_map(|(capsule, [a, b])| {
            let places = (0..=PLACES).map(|k| a + (b - a) * (f64::from(k) / f64::from(PLACES)));
            let (distance, place) = places
                .map(|place| (shape.distance(&place), place))
                .min_by(|one, other| one.0.total_cmp(&other.0))?;
            let gap_m = distance - capsule.radius_m;
            if gap_m >= reach_m {
                return None;
            }
            let outward = shape.gradient(&place).1.try_normalize(1e-9)?;
            Some(NearbyCapsule {
                link: capsule.link,
                gap_m,
                on_hand: place - outward * capsule.radius_m,
                inward_normal: -outward,
            })
        });
        near.collect()
    }

    /// Derivative of the distance of a touch with respect to each joint angle, metres per radian.
    fn slope(&self, posed: &PosedHand, touch: &NearbyCapsule) -> DVector<f64> {
        let joints = self.hand.joints.len();
        let metric = self.metric.get_or_init(|| self.hand.pose_metric());
        let mut wrenches = vec![Wrench::default(); self.hand.links.len()];
        wrenches[touch.link.0].add(&touch.on_hand, &-touch.inward_normal);
        let mut tangent = vec![0.0; 6 + joints];
        let none = vec![0.0; joints];
        self.hand
            .pull_back(posed, &wrenches, &none, metric, &mut tangent);
        let slopes = tangent[6..].iter().zip(&metric.joint_levers_m);
        DVector::from_iterator(joints, slopes.map(|(slope, lever)| slope * lever))
    }

    /// Changes the joints within their limits, or within their present value if it is beyond; returns the largest change.
    fn shift(&self, x: &mut [f64], change: &DVector<f64>) -> f64 {
        let mut largest: f64 = 0.0;
        for ((angle, joint), change) in joints_of_mut(x)
            .iter_mut()
            .zip(&self.hand.joints)
            .zip(change)
        {
            let [lower, upper] = joint.limits;
            let to = (*angle + change).clamp(lower.min(*angle), upper.max(*angle));
            largest = largest.max((to - *angle).abs());
            *angle = to;
        }
        largest
    }

    /// Moves capsules out of the object, and capsules near its surface onto it.
    fn put_on(&self, x: &[f64]) -> Vec<f64> {
        let joints = self.hand.joints.len();
        let correction = self.correction;
        let prior = correction.joint_rad.powi(-2);
        let mut best = x.to_vec();
        let mut posed = PosedHand::default();
        for step in 0..STEPS {
            let near = self.touches(&best, correction.reach_m, &mut posed);
            if step == 0 && self.fair(&near) {
                break;
            }
            let mut normal = DMatrix::<f64>::identity(joints, joints) * prior;
            let mut right =
                DVector::from_iterator(joints, (7..x.len()).map(|j| prior * (x[j] - best[j])));
            for touch in &near {
                let off = touch.gap_m.max(0.0) / correction.reach_m;
                let weight = ((1.0 - off * off).max(0.0) / correction.skin_m).powi(2);
                let slope = self.slope(&posed, touch);
                normal += weight * &slope * slope.transpose();
                right -= weight * touch.gap_m * slope;
            }
            let Some(change) = normal.cholesky().map(|factor| factor.solve(&right)) else {
                break;
            };
            if self.shift(&mut best, &change) < REST_RAD {
                break;
            }
        }
        best
    }

    /// Whether nothing is deep inside.
    fn fair(&self, near: &[NearbyCapsule]) -> bool {
        near.iter()
            .all(|touch| touch.gap_m > -self.correction.fair_m)
    }

    /// Whether the contact forces can sum to zero.
    fn balanced(&self, x: &[f64], posed: &mut PosedHand) -> bool {
        let near = self.touches(x, self.correction.touching_m, posed);
        let normals: Vec<Vector3<f64>> = near.iter().map(|touch| touch.inward_normal).collect();
        force_left_over(&normals, self.correction.friction) < BALANCED
    }

    fn could_hold(&self, x: &[f64], posed: &mut PosedHand) -> bool {
        self.fair(&self.touches(x, 0.0, posed)) && self.balanced(x, posed)
    }

    /// The pose with one more digit on the object: the nearest of the digits up to `reach_m` away that can be closed.
    /// `None` if there is none.
    fn completed(&self, x: &[f64], reach_m: f64) -> Option<Vec<f64>> {
        let mut posed = PosedHand::default();
        let near = self.touches(x, reach_m, &mut posed);
        let digits = 1..self.hand.digits.len();
        let mut gaps: Vec<(f64, usize)> = digits
            .filter_map(|digit| {
                let own = near.iter().filter(|touch| self.digit(touch) == digit);
                Some((own.map(|touch| touch.gap_m).min_by(f64::total_cmp)?, digit))
            })
            .filter(|(gap_m, _)| *gap_m >= self.correction.touching_m)
            .collect();
        gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
        gaps.iter()
            .find_map(|(_, digit)| self.closed(x, *digit, &mut posed))
    }

    fn digit(&self, touch: &NearbyCapsule) -> usize {
        self.hand.links[touch.link.0].digit
    }

    /// The pose with this digit closed until it touches; `None` if it cannot reach the object.
    fn closed(&self, x: &[f64], digit: usize, posed: &mut PosedHand) -> Option<Vec<f64>> {
        let mut closed = x.to_vec();
        for _ in 0..=STEPS {
            let near = self.touches(&closed, 2.0 * self.correction.missing_m, posed);
            let own = near.iter().filter(|touch| self.digit(touch) == digit);
            let nearest = own.min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))?;
            if nearest.gap_m.abs() < NEAR_ENOUGH_M {
                return Some(closed);
            }
            let slope = self.slope(posed, nearest);
            let change = &slope * (-nearest.gap_m / slope.norm_squared().max(1e-9));
            if self.shift(&mut closed, &change) < REST_RAD {
                return (nearest.gap_m.abs() < CLOSED_M).then_some(closed);
            }
        }
        None
    }
}

/// The least residual of forces inside the friction cones about these normals, as a share of all normal forces: the
/// distance of the origin from the hull of the cones' edges, by pairwise Frank–Wolfe steps. 1 if there are no normals.
pub(super) fn force_left_over(normals: &[Vector3<f64>], friction: f64) -> f64 {
    if normals.is_empty() {
        return 1.0;
    }
    let edges: Vec<Vector3<f64>> = normals
        .iter()
        .flat_map(|normal| {
            let mut other = Vector3::zeros();
            other[normal.iamin()] = 1.0;
            let across = normal.cross(&other).normalize();
            let along = normal.cross(&across);
            (0..EDGES).map(move |edge| {
                let (sin, cos) = libm::sincos(TAU * f64::from(edge) / f64::from(EDGES));
                normal + friction * (across * cos + along * sin)
            })
        })
        .collect();
    let mut shares = vec![1.0 / edges.len() as f64; edges.len()];
    let sum = |shares: &[f64]| -> Vector3<f64> {
        edges
            .iter()
            .zip(shares)
            .map(|(edge, share)| edge * *share)
            .sum()
    };
    let mut force = sum(&shares);
    for _ in 0..BALANCING {
        let work: Vec<f64> = edges.iter().map(|edge| edge.dot(&force)).collect();
        let all = || 0..edges.len();
        let used = all().filter(|&i| shares[i] > 1e-12);
        let (Some(to), Some(from)) = (
            all().min_by(|&a, &b| work[a].total_cmp(&work[b])),
            used.max_by(|&a, &b| work[a].total_cmp(&work[b])),
        ) else {
            break;
        };
        let gain = work[from] - work[to];
        if gain <= 1e-9 {
            break;
        }
        let step = (gain / (edges[to] - edges[from]).norm_squared().max(1e-12)).min(shares[from]);
        shares[to] += step;
        shares[from] -= step;
        force = sum(&shares);
    }
    force.norm()
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::grasp::closing::capsule_touches;
    use crate::space::put_root;

    #[test]
    fn forces_balance_between_two_sides_and_not_on_one() {
        let [x, y] = [Vector3::x(), Vector3::y()];
        assert!(force_left_over(&[x, -x], 0.3) < 1e-6);
        assert!((force_left_over(&[x], 0.0) - 1.0).abs() < 1e-9);
        // Between normals at right angles the cones meet the balance only from friction 1 on.
        assert!(force_left_over(&[x, y], 0.6) > 0.2);
        let third = (-x - y).normalize();
        assert!(force_left_over(&[x, y, third], 0.1) < 1e-3);
    }

    /// The ball in the bent hand.
    fn around_the_ball(hand: &Hand, ball: &Object) -> Vec<f64> {
        let mut x = hand.rest_coordinates();
        let away = hand.palm.centre + hand.palm.volar * 0.034;
        let root = ball.centroid - away;
        put_root(&mut x, &root, &UnitQuaternion::identity());
        for (j, joint) in hand.joints.iter().enumerate() {
            if joint.name.ends_with("flexion") && !joint.name.starts_with("thumb") {
                joints_of_mut(&mut x)[j] = 1.2_f64.min(joint.limits[1]);
            }
        }
        x
    }

    #[test]
    fn what_is_inside_comes_out_and_what_is_fair_stays() {
        let hand = Hand::human();
        let ball = Object::named("ball").unwrap();
        let correction = PoseCorrection::default();
        let deepest = |x: &[f64]| {
            let mut posed = PosedHand::default();
            hand.pose(x, &mut posed);
            let near = capsule_touches(&ball.exact, &hand, &posed, 0.01);
            near.iter().map(|touch| touch.gap_m).fold(0.0, f64::min)
        };
        let inside = around_the_ball(&hand, &ball);
        assert!(deepest(&inside) < -0.004, "{}", deepest(&inside));
        let put = readings(&hand, &ball, &inside, &correction).remove(0);
        assert!(
            deepest(&put) > 0.5 * deepest(&inside),
            "{} {}",
            deepest(&inside),
            deepest(&put)
        );
        assert_eq!(put[..7], inside[..7]);
        let mut far = inside;
        far[0] += 1.0;
        assert_eq!(readings(&hand, &ball, &far, &correction), [far]);
    }

    #[test]
    fn each_further_reading_has_one_digit_more_on_the_object() {
        let hand = Hand::human();
        let ball = Object::named("ball").unwrap();
        let correction = PoseCorrection::default();
        let near = Near {
            hand: &hand,
            object: &ball,
            correction: &correction,
            metric: OnceCell::new(),
        };
        // All fingers bent a little less: they hover.
        let mut x = around_the_ball(&hand, &ball);
        for (j, joint) in hand.joints.iter().enumerate() {
            if joint.name.ends_with("flexion") && !joint.name.starts_with("thumb") {
                joints_of_mut(&mut x)[j] -= 0.35;
            }
        }
        let mut posed = PosedHand::default();
        assert!(!near.could_hold(&x, &mut posed));
        let mut on_object = |x: &[f64]| -> Vec<usize> {
            let touches = near.touches(x, CLOSED_M, &mut posed);
            (1..hand.digits.len())
                .filter(|digit| touches.iter().any(|touch| near.digit(touch) == *digit))
                .collect()
        };
        let readings = readings(&hand, &ball, &x, &correction);
        let digits: Vec<Vec<usize>> = readings.iter().map(|x| on_object(x)).collect();
        assert!(digits.len() > 1, "{digits:?}");
        for pair in digits.windows(2) {
            assert!(
                pair[0].iter().all(|digit| pair[1].contains(digit)),
                "{digits:?}"
            );
            assert_eq!(pair[1].len(), pair[0].len() + 1, "{digits:?}");
        }
        // Each could hold, and only joints were moved.
        for reading in &readings {
            assert!(near.balanced(reading, &mut PosedHand::default()));
            assert_eq!(reading[..7], x[..7]);
        }
    }
}
