//! Pairs of parts checked for self-collision, and the nearest points of two capsules.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::model::Model;
use super::sampling::joint_samples;
use super::side_file::SideFile;
use super::{Hand, HandError, LinkId, PosedHand};
use crate::space::Pose;

/// Parts nearer than this touch, metres.
const TOUCHING_M: f64 = 1e-3;
/// Poses in which parts that touch at rest are looked at, besides the ends of all ranges.
const POSES: usize = 256;
/// A description with very many parts that touch is looked at in fewer poses.
const MOST_COMPARISONS: usize = 20_000_000;
const FEWEST_POSES: usize = 16;

/// Nearest points of two segments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentPair {
    /// Position on the first segment: 0 = first end, 1 = second end.
    pub s: f64,
    /// Position on the second segment.
    pub t: f64,
    /// From the point on the first segment to the point on the second, metres.
    pub offset: Vector3<f64>,
}

/// Nearest points of two segments, each given by its ends.
///
/// If the segments are parallel and many pairs are equally near, gives the pair with the least `s` on the overlap.
/// After Ericson (2005), *Real-Time Collision Detection*, §5.1.9.
pub fn closest_points(first: &[Vector3<f64>; 2], second: &[Vector3<f64>; 2]) -> SegmentPair {
    rounded_closest_points(first, second, 0.0)
}

/// Points of two segments that are nearly the nearest and move continuously with the segments.
///
/// ```text
/// (s, t) = argmin |p(s) − q(t)|² + ε (|u|² (s − ½)² + |v|² (t − ½)²),    s and t from 0 to 1
/// ```
///
/// u and v are the segments and ε is `rounding`. The nearest points of two segments jump when these become parallel. The
/// curvature of the function to minimise is at least 2ε times the smaller squared length, so for segments that are no points
/// the minimum moves at a bounded speed if ε > 0. With ε = 0 these are the nearest points.
pub fn rounded_closest_points(
    first: &[Vector3<f64>; 2],
    second: &[Vector3<f64>; 2],
    rounding: f64,
) -> SegmentPair {
    let (u, v) = (first[1] - first[0], second[1] - second[0]);
    let w = first[0] - second[0];
    let [first_squared, second_squared] = [u.norm_squared(), v.norm_squared()];
    let [a, e] = [first_squared, second_squared].map(|squared| squared * (1.0 + rounding));
    let f = v.dot(&w) + 0.5 * rounding * second_squared;
    let point = 1e-18;
    let (s, t) = if a <= point {
        (
            0.0,
            if e <= point {
                0.0
            } else {
                (f / e).clamp(0.0, 1.0)
            },
        )
    } else {
        let c = u.dot(&w) - 0.5 * rounding * first_squared;
        if e <= point {
            ((-c / a).clamp(0.0, 1.0), 0.0)
        } else {
            let b = u.dot(&v);
            let denominator = a * e - b * b;
            let s = if denominator > 1e-12 * a * e {
                ((b * f - c * e) / denominator).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let t = (b * s + f) / e;
            if t < 0.0 {
                ((-c / a).clamp(0.0, 1.0), 0.0)
            } else if t > 1.0 {
                (((b - c) / a).clamp(0.0, 1.0), 1.0)
            } else {
                (s, t)
            }
        }
    };
    SegmentPair {
        s,
        t,
        offset: second[0] + v * t - first[0] - u * s,
    }
}

/// Distance of a point from the segment between two ends, metres.
#[inline]
pub fn axis_distance(point: &Vector3<f64>, ends: &[Vector3<f64>; 2]) -> f64 {
    let (along, from) = (ends[1] - ends[0], point - ends[0]);
    let length = along.norm_squared();
    let t = if length > 0.0 {
        (from.dot(&along) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (from - along * t).norm()
}

/// Restrictions on the pairs of links that are checked.
pub(super) struct Apart {
    /// Pairs that are never checked.
    never: BTreeSet<[usize; 2]>,
    /// If given, the only pairs that are checked.
    only: Option<BTreeSet<[usize; 2]>>,
}

/// The restrictions stated by the description and the side file.
pub(super) fn apart(hand: &Hand, model: &Model, side: &SideFile) -> Result<Apart, HandError> {
    let find = |place: &str, pairs: &[[String; 2]]| -> Result<BTreeSet<[usize; 2]>, HandError> {
        let link = |name: &String| {
            hand.link(name)
                .map(|link| link.0)
                .ok_or_else(|| HandError::Unknown {
                    place: place.to_owned(),
                    kind: "link",
                    name: name.clone(),
                })
        };
        let pair = |[a, b]: &[String; 2]| {
            let (a, b) = (link(a)?, link(b)?);
            Ok([a.min(b), a.max(b)])
        };
        pairs.iter().map(pair).collect()
    };
    // A description may name bodies that are not part of the hand.
    let known = |pair: &&[String; 2]| pair.iter().all(|name| hand.link(name).is_some());
    let described: Vec<_> = model.apart.iter().filter(known).cloned().collect();
    let mut never = find("the description", &described)?;
    never.extend(find("\"apart\" of the side file", &side.apart)?);
    let only = side
        .self_pairs
        .as_ref()
        .map(|pairs| find("\"self_pairs\" of the side file", pairs))
        .transpose()?;
    Ok(Apart { never, only })
}

/// Pairs of capsules that can be apart and whose links are not neighbours in the tree.
///
/// Links without geometry and fixed joints are skipped: two links are neighbours if only such links lie between them. Parts
/// that touch at rest are left out if they touch in all poses of a sample. If only one link joins them, in a digit or between
/// a digit and the palm, more than half of the poses are enough: such parts are made to overlap at knuckles and bases. Parts
/// of a hand that [bends](Hand::bends) are soft and are left out if they touch at rest.
pub(super) fn derive(hand: &Hand, rest: &PosedHand, apart: &Apart) -> Vec<[usize; 2]> {
    let solid: Vec<LinkId> = (0..hand.links.len())
        .map(|l| body(hand, LinkId(l)))
        .collect();
    let mut has_geometry = vec![false; hand.links.len()];
    for capsule in &hand.capsules {
        has_geometry[solid[capsule.link.0].0] = true;
    }
    let neighbour_above = |link: LinkId| {
        let mut above = hand.links[link.0].parent.map(|parent| solid[parent.0]);
        while let Some(l) = above.filter(|l| !has_geometry[l.0]) {
            above = hand.links[l.0].parent.map(|parent| solid[parent.0]);
        }
        above
    };
    let joined_by_one_link = |a: LinkId, b: LinkId| {
        let [above_a, above_b] = [a, b].map(neighbour_above);
        let two_above = [above_a, above_b].map(|above| above.and_then(neighbour_above));
        let in_one_line = two_above[0] == Some(b) || two_above[1] == Some(a);
        in_one_line || (above_a.is_some() && above_a == above_b)
    };
    let mut pairs = Vec::new();
    // Pairs that touch at rest; whether more than half of the poses are enough.
    let mut doubtful: Vec<([usize; 2], bool)> = Vec::new();
    for (i, first) in hand.capsules.iter().enumerate() {
        let a = solid[first.link.0];
        for (j, second) in hand.capsules.iter().enumerate().skip(i + 1) {
            let b = solid[second.link.0];
            let links = [first.link.0, second.link.0];
            if apart.never.contains(&links) {
                continue;
            }
            let listed = apart.only.as_ref().map(|only| only.contains(&links));
            if listed == Some(false) {
                continue;
            }
            let neighbours =
                a == b || neighbour_above(a) == Some(b) || neighbour_above(b) == Some(a);
            if neighbours && listed.is_none() {
                continue;
            }
            if !touch(hand, &rest.capsules, [i, j]) {
                pairs.push([i, j]);
            } else if !hand.bends() {
                let digits = links.map(|l| hand.links[l].digit);
                let of_two_digits = digits[0] != digits[1] && !digits.contains(&0);
                doubtful.push(([i, j], joined_by_one_link(a, b) && !of_two_digits));
            }
        }
    }
    pairs.extend(sometimes_apart(hand, &doubtful));
    pairs.sort_unstable();
    pairs
}

fn touch(hand: &Hand, posed: &[[Vector3<f64>; 2]], [i, j]: [usize; 2]) -> bool {
    let offset = closest_points(&posed[i], &posed[j]).offset;
    offset.norm() <= hand.capsules[i].radius_m + hand.capsules[j].radius_m + TOUCHING_M
}

/// The pairs that are apart in some pose of a sample, or in half of them if more than half are enough to leave a pair out.
fn sometimes_apart(hand: &Hand, pairs: &[([usize; 2], bool)]) -> Vec<[usize; 2]> {
    if pairs.is_empty() {
        return Vec::new();
    }
    let mut samples = joint_samples(&hand.joints, POSES);
    samples.truncate((MOST_COMPARISONS / pairs.len()).max(FEWEST_POSES));
    let mut apart = vec![0; pairs.len()];
    let mut posed = PosedHand::default();
    for joints in &samples {
        hand.pose_links(&Pose::at_origin(joints), &mut posed);
        for (count, &(pair, mostly)) in apart.iter_mut().zip(pairs) {
            // One such pose decides.
            if (mostly || *count == 0) && !touch(hand, &posed.capsules, pair) {
                *count += 1;
            }
        }
    }
    let kept = pairs.iter().zip(&apart).filter(|((_, mostly), count)| {
        let least = if *mostly {
            samples.len().div_ceil(2)
        } else {
            1
        };
        **count >= least
    });
    kept.map(|((pair, _), _)| *pair).collect()
}

/// The first link of the rigid body that a link belongs to, found through fixed joints.
fn body(hand: &Hand, mut link: LinkId) -> LinkId {
    while let (false, Some(parent)) = (hand.links[link.0].moves(), hand.links[link.0].parent) {
        link = parent;
    }
    link
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::sample::{Task, stream};

    /// Rounded nearest points minimise their function, and they move continuously through parallel segments, where the
    /// nearest points jump from end to end.
    #[test]
    fn rounded_closest_points_do_not_jump() {
        const ROUNDING: f64 = 0.01;
        let mut rng = stream(1, Task::Start, 0);
        for _ in 0..40 {
            let mut vector = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0_f64));
            let (first, second) = ([vector(), vector()], [vector(), vector()]);
            let [u, v] = [&first, &second].map(|axis| axis[1] - axis[0]);
            let cost = |s: f64, t: f64| {
                let offset = second[0] + v * t - first[0] - u * s;
                let off_middle =
                    |axis: &Vector3<f64>, s: f64| axis.norm_squared() * (s - 0.5).powi(2);
                offset.norm_squared() + ROUNDING * (off_middle(&u, s) + off_middle(&v, t))
            };
            let found = rounded_closest_points(&first, &second, ROUNDING);
            let steps = || (0..=100).map(|i| f64::from(i) / 100.0);
            let costs = steps().flat_map(|s| steps().map(move |t| cost(s, t)));
            assert!(cost(found.s, found.t) <= costs.fold(f64::INFINITY, f64::min) + 1e-12);
        }
        let first = [Vector3::zeros(), Vector3::x()];
        let tilted = |angle: f64| {
            // Tilted towards the first segment.
            let half = Vector3::new(libm::cos(angle), 0.0, libm::sin(angle)) * 0.5;
            let middle = Vector3::new(0.5, 0.0, 0.3);
            [middle - half, middle + half]
        };
        let places = |rounding: f64| {
            [-1e-5, 1e-5].map(|angle| {
                let found = rounded_closest_points(&first, &tilted(angle), rounding);
                [found.s, found.t]
            })
        };
        let [before, after] = places(0.0);
        assert!((before[1] - after[1]).abs() > 0.9, "{before:?} {after:?}");
        let [before, after] = places(ROUNDING);
        let moved = (before[0] - after[0])
            .abs()
            .max((before[1] - after[1]).abs());
        assert!(moved < 1e-3, "{before:?} {after:?}");
    }

    /// Against a fine search over both parameters, for crossing, skew, parallel and pointlike segments.
    #[test]
    fn closest_points_beat_every_sampled_pair() {
        let p = Vector3::new;
        let cases = [
            [
                [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0)],
                [p(0.5, -1.0, 0.2), p(0.5, 1.0, 0.2)],
            ],
            [
                [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0)],
                [p(0.2, 1.0, 0.0), p(0.7, 1.0, 0.0)],
            ],
            [
                [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0)],
                [p(1.5, 0.3, 0.1), p(3.0, 1.0, 0.0)],
            ],
            [
                [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0)],
                [p(-1.5, 0.3, 0.1), p(-0.5, 1.0, 0.0)],
            ],
            [
                [p(0.0, 0.0, 0.0), p(0.0, 0.0, 0.0)],
                [p(-1.0, 0.3, 0.1), p(1.0, 0.5, 0.0)],
            ],
            [
                [p(0.0, 0.0, 0.0), p(1.0, 0.2, 0.0)],
                [p(0.4, 0.3, 0.1), p(0.4, 0.3, 0.1)],
            ],
        ];
        for [first, second] in cases {
            let found = closest_points(&first, &second);
            let at = |s: f64, t: f64| {
                second[0] + (second[1] - second[0]) * t - first[0] - (first[1] - first[0]) * s
            };
            assert!((found.offset - at(found.s, found.t)).norm() < 1e-15);
            let point = first[0];
            let alone = closest_points(&[point; 2], &second).offset.norm();
            assert!((axis_distance(&point, &second) - alone).abs() < 1e-15);
            let steps = || (0..=200).map(|i| f64::from(i) / 200.0);
            let best = steps()
                .flat_map(|s| steps().map(move |t| at(s, t).norm()))
                .fold(f64::INFINITY, f64::min);
            assert!(
                found.offset.norm() <= best + 1e-12,
                "{} > {best}",
                found.offset.norm()
            );
            assert!(
                found.offset.norm() >= best - 0.02,
                "{} < {best}",
                found.offset.norm()
            );
        }
    }

    #[test]
    fn neighbours_are_no_pairs_and_far_parts_are() {
        let hand = Hand::human();
        let link = |capsule: usize| hand.links[hand.capsules[capsule].link.0].name.as_str();
        let has = |a: &str, b: &str| {
            hand.self_pairs
                .iter()
                .any(|&[i, j]| (link(i), link(j)) == (a, b) || (link(i), link(j)) == (b, a))
        };
        assert!(
            has("thumb_distal", "index_distal")
                && has("index_middle", "middle_middle")
                && has("palm", "ring_distal")
        );
        assert!(!has("index_middle", "index_distal") && !has("palm", "index_proximal"));
        assert!(!has("palm", "palm") && !has("palm", "thumb_metacarpal"));
    }
}
