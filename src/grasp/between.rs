//! Starts with the object between two sides of a hand.

use nalgebra::{Isometry3, Rotation3, Unit, UnitQuaternion, Vector3};
use rand::RngExt;

use super::start::frame;
use crate::hand::{Hand, LinkId, PosedHand};
use crate::mesh::SurfaceSample;
use crate::object::Object;
use crate::sample::{Rng, standard_normal};
use crate::space::{Pose, pose_coordinates};

/// A place of a hand that is to touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The link it is on.
    pub link: LinkId,
    /// Position, link frame, metres.
    pub point: Vector3<f64>,
    /// Outward unit normal, link frame.
    pub normal: Vector3<f64>,
}

/// The two sides of a hand that press against each other; neither is empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Opposed {
    /// The thumb, or the palm.
    pub first: Vec<Place>,
    /// What presses against it.
    pub second: Vec<Place>,
}

/// Postures and places of the object that a start is chosen from, and turns of the hand about the line between its sides.
const POSTURES: usize = 160;
const PLACES: usize = 8;
const TURNS: usize = 24;
/// Gap between the object and each of the two sides, metres.
const OPEN_M: f64 = 0.006;
/// Difference between the distance of the two sides and what the object needs that costs as much as a wrong direction,
/// metres.
const MISFIT_M: f64 = 0.012;
/// A larger misfit costs no more than this.
const MOST_MISFIT: f64 = 9.0;
/// Closure of digits: 0 straight, 1 in the middle of their ranges.
const CLOSURES: std::ops::Range<f64> = -0.1..1.7;
/// Standard deviations of a joint from the closure of its digit, relative to its range: of fingers and of a thumb, whose
/// joints turn it in different directions.
const FINGER_SHARE: f64 = 0.06;
const THUMB_SHARE: f64 = 0.25;
/// Standard deviation of the closure of a finger from that of all fingers, where they close together.
const TOGETHER: f64 = 0.1;
/// Every so many surface points of the hand are looked at where a turn is chosen.
const STRIDE: usize = 4;

/// A random pose in which the object lies between two sides of the hand, which are open by a few millimetres, as coordinates
/// of [`PoseSpace`](crate::space::PoseSpace).
///
/// Of random postures and random places of the object, the first of which is `sample`, those are chosen that suit each other
/// best: the sides face each other, their distance is the thickness of the object at the place, and `fit` of the posture (0
/// to 1) is large. Of random turns of the hand about the line between its sides, that counts in which the hand is least in
/// the object.
///
/// # Panics
/// If a side has no places, or they belong to another hand.
pub fn start_between(
    hand: &Hand,
    object: &Object,
    sides: &Opposed,
    fit: &dyn Fn(&PosedHand) -> f64,
    sample: &SurfaceSample,
    rng: &mut Rng,
) -> Vec<f64> {
    let postures: Vec<Posture> = (0..POSTURES)
        .map(|_| Posture::new(hand, random_joints(hand, rng), sides, fit))
        .collect();
    let samples = &object.surface_samples;
    let crossings: Vec<Crossing> = (0..PLACES)
        .map(|place| match place {
            0 => *sample,
            _ => samples[rng.random_range(0..samples.len())],
        })
        .filter_map(|sample| Crossing::of(object, &sample))
        .collect();
    let pairs = postures
        .iter()
        .flat_map(|posture| crossings.iter().map(move |crossing| (posture, crossing)));
    let best = pairs.max_by(|a, b| value(a).total_cmp(&value(b)));
    let Some((posture, crossing)) = best else {
        return super::start::start_pose_facing(hand, sample, rng);
    };
    let turns = (0..TURNS).map(|_| {
        let x = placed(
            posture,
            crossing,
            rng.random_range(0.0..std::f64::consts::TAU),
        );
        (overlap_m(hand, object, &x), x)
    });
    let best = turns.min_by(|a, b| a.0.total_cmp(&b.0));
    best.expect("there is at least one turn").1
}

/// A random pose with the palm facing `faced`, in the one of random postures whose `fit` (0 to 1) and whose sides suit best.
///
/// # Panics
/// As [`start_between`].
pub fn start_facing(
    hand: &Hand,
    sides: &Opposed,
    fit: &dyn Fn(&PosedHand) -> f64,
    faced: &SurfaceSample,
    rng: &mut Rng,
) -> Vec<f64> {
    let postures = (0..POSTURES).map(|_| Posture::new(hand, random_joints(hand, rng), sides, fit));
    let best = postures.max_by(|a, b| a.value.total_cmp(&b.value));
    let best = best.expect("there is at least one posture");
    super::start::start_pose_with(hand, &best.joints, faced, rng)
}

/// A random posture: fingers close alike or each on its own, and the last two joints of a digit apart from those before.
fn random_joints(hand: &Hand, rng: &mut Rng) -> Vec<f64> {
    let (straight, closed) = (hand.straight_joints(), hand.closed_joints());
    let together: bool = rng.random();
    let common: [f64; 2] = std::array::from_fn(|_| rng.random_range(CLOSURES));
    let closures: Vec<[f64; 2]> = (0..hand.digits.len())
        .map(|_| {
            if together {
                common.map(|closure| closure + TOGETHER * standard_normal(rng))
            } else {
                std::array::from_fn(|_| rng.random_range(CLOSURES))
            }
        })
        .collect();
    let digit_of = |joint: usize| hand.links[hand.joints[joint].link.0].digit;
    let mut joints = hand.prior.rest.clone();
    for (number, joint) in hand.joints.iter().enumerate() {
        let digit = digit_of(number);
        let noise: f64 = standard_normal(rng);
        if digit == 0 {
            continue;
        }
        let after = (number + 1..joints.len()).filter(|other| digit_of(*other) == digit);
        let closure = closures[digit][usize::from(after.count() < 2)];
        let [lower, upper] = joint.limits;
        let share = match digit {
            1 if hand.has_thumb() => THUMB_SHARE,
            _ => FINGER_SHARE,
        };
        let middle = straight[number] + closure * (closed[number] - straight[number]);
        joints[number] = (middle + share * (upper - lower) * noise).clamp(lower, upper);
    }
    joints
}

/// A posture and the line between its two sides, root frame.
struct Posture {
    joints: Vec<f64>,
    /// Middle between the two sides, metres.
    middle: Vector3<f64>,
    /// From the first side to the second.
    across: Unit<Vector3<f64>>,
    distance_m: f64,
    /// How well it suits what is asked for.
    value: f64,
}

impl Posture {
    fn new(
        hand: &Hand,
        joints: Vec<f64>,
        sides: &Opposed,
        fit: &dyn Fn(&PosedHand) -> f64,
    ) -> Self {
        let mut posed = PosedHand::default();
        hand.pose_links(&Pose::at_origin(&joints), &mut posed);
        let mean = |places: &[Place]| -> (Vector3<f64>, Vector3<f64>) {
            let sums = places.iter().map(|place| {
                let frame = &posed.object_from_link[place.link.0];
                (frame.point(&place.point), frame.direction(&place.normal))
            });
            let zero = (Vector3::zeros(), Vector3::zeros());
            let (point, normal) = sums.fold(zero, |sum, place| (sum.0 + place.0, sum.1 + place.1));
            let count = places.len() as f64;
            (point / count, normal / count)
        };
        let ((first, outward), (second, back)) = (mean(&sides.first), mean(&sides.second));
        let line = second - first;
        let across = Unit::try_new(line, 1e-6).unwrap_or_else(Vector3::z_axis);
        let facing = outward.dot(&across) - back.dot(&across);
        Self {
            joints,
            middle: (first + second) / 2.0,
            across,
            distance_m: line.norm(),
            value: facing + libm::log(fit(&posed).max(1e-9)),
        }
    }
}

/// A line through the object, from one point of its surface to the opposite one.
struct Crossing {
    middle: Vector3<f64>,
    /// Into the object at the first point.
    inward: Unit<Vector3<f64>>,
    thickness_m: f64,
    /// Cosine between the line and the outward normal at its end.
    opposite: f64,
}

impl Crossing {
    fn of(object: &Object, sample: &SurfaceSample) -> Option<Self> {
        let inward = Unit::new_normalize(-sample.normal);
        let thickness_m = object.exact.next_along(&sample.point, &inward)?;
        let end = sample.point + inward.into_inner() * thickness_m;
        Some(Self {
            middle: (sample.point + end) / 2.0,
            inward,
            thickness_m,
            opposite: object.exact.nearest(&end).normal.dot(&inward),
        })
    }
}

fn value((posture, crossing): &(&Posture, &Crossing)) -> f64 {
    let misfit = (posture.distance_m - crossing.thickness_m - 2.0 * OPEN_M) / MISFIT_M;
    posture.value + crossing.opposite - (misfit * misfit).min(MOST_MISFIT)
}

/// The posture with the crossing between its sides, turned about the line between them.
fn placed(posture: &Posture, crossing: &Crossing, turn_rad: f64) -> Vec<f64> {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), turn_rad);
    let rotation = frame(&crossing.inward) * turn * frame(&posture.across).inverse();
    let rotation = UnitQuaternion::from_rotation_matrix(&rotation);
    let translation = crossing.middle - rotation * posture.middle;
    pose_coordinates(
        &Isometry3::from_parts(translation.into(), rotation),
        &posture.joints,
    )
}

/// Sum of the depths of some surface points of the hand in the object, metres.
fn overlap_m(hand: &Hand, object: &Object, x: &[f64]) -> f64 {
    let mut posed = PosedHand::default();
    hand.pose(x, &mut posed);
    let depths = posed.points.iter().step_by(STRIDE);
    depths
        .map(|point| (-object.shape.distance(point)).max(0.0))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Task, stream};

    /// The places of the pads of two last links.
    fn pinch(hand: &Hand) -> Opposed {
        let side = |region: &str| {
            let own = hand.surface.iter();
            own.filter(|point| hand.regions[point.region] == region)
                .map(|point| Place {
                    link: point.link,
                    point: point.point,
                    normal: point.normal,
                })
                .collect()
        };
        Opposed {
            first: side("thumb.distal.pad"),
            second: side("index.distal.pad"),
        }
    }

    #[test]
    fn the_object_lies_between_the_sides() {
        let (hand, ball) = (Hand::human(), Object::named("ball").unwrap());
        let sides = pinch(&hand);
        let mut near = 0;
        for seed in 0..20 {
            let mut rng = stream(seed, Task::Start, 0);
            let sample = &ball.surface_samples[0];
            let x = start_between(&hand, &ball, &sides, &|_| 1.0, sample, &mut rng);
            let mut posed = PosedHand::default();
            hand.pose_links(&x, &mut posed);
            let gap = |places: &[Place]| {
                let points = places
                    .iter()
                    .map(|place| posed.object_from_link[place.link.0].point(&place.point));
                points
                    .map(|point| ball.exact.distance(&point))
                    .fold(f64::INFINITY, f64::min)
            };
            let gaps = [gap(&sides.first), gap(&sides.second)];
            near += usize::from(gaps.iter().all(|gap| gap.abs() < 0.015));
        }
        assert!(
            near >= 16,
            "{near} of 20 starts have both pads near the ball"
        );
    }
}
