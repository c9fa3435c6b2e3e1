//! Thumb, fingers and the direction of the palm, derived from the shape of the hand.

use nalgebra::Vector3;

use crate::space::Pose;

use super::{Hand, JointKind, LinkId, PalmFrame, PosedHand};

/// Least difference from the other digits in direction and closing for a thumb: 0 is alike, 4 is opposite in both.
const OPPOSED: f64 = 0.5;
/// The thumb's difference must exceed that of any other digit by this factor.
const MORE: f64 = 1.3;
/// Digits close to one side, as fingers do toward a palm, if the sum of their closing vectors has at least this share of
/// the sum of the vectors' lengths.
const ONE_SIDED: f64 = 0.5;
/// A thumb points away from the fingers, as the jaws of a gripper do, if the cosine between their directions is below this.
const AWAY: f64 = -0.5;
/// Points farther out than this share of a digit's reach form its tip.
const TIP: f64 = 0.97;
/// Distance from the palm's centre to the point that faces the object, as a share of the fingers' length: as on a human
/// hand.
const FACED: f64 = 0.4;

/// Direction and closing of a digit, root frame.
struct Reach {
    /// Origin of its first link.
    root: Vector3<f64>,
    /// From the origin of its first link to its tip, straight.
    out: Vector3<f64>,
    /// Displacement of its tip from straight to the middle of all ranges.
    closing: Vector3<f64>,
}

/// Two sets of coordinates. Straight: hinges at zero or the limit nearest to zero, slides in the middle. Closed: hinges in
/// the middle of their ranges, slides at the lower limit. Joints that move the palm are at rest in both.
fn straight_and_closed(hand: &Hand) -> [Vec<f64>; 2] {
    let of_arm = |link: LinkId| hand.is_arm(link) || link == hand.palm_link;
    let joints = || hand.joints.iter().zip(&hand.prior.rest);
    let straight = joints().map(|(joint, rest)| {
        let [lower, upper] = joint.limits;
        match joint.kind {
            _ if of_arm(joint.link) => *rest,
            JointKind::Hinge => 0.0f64.clamp(lower, upper),
            JointKind::Slide => f64::midpoint(lower, upper),
        }
    });
    let closed = joints().map(|(joint, rest)| {
        let [lower, upper] = joint.limits;
        match joint.kind {
            _ if of_arm(joint.link) => *rest,
            JointKind::Hinge => f64::midpoint(lower, upper),
            JointKind::Slide => lower,
        }
    });
    [straight.collect::<Vec<_>>(), closed.collect()].map(|joints| Pose::at_origin(&joints).into())
}

impl Hand {
    /// Joint coordinates of the straight hand: hinges at zero or the limit nearest to zero, slides half open.
    pub fn straight_joints(&self) -> Vec<f64> {
        straight_and_closed(self)[0].split_off(7)
    }

    /// Joint coordinates of the closed hand: hinges in the middle of their ranges, slides at the lower limit.
    pub(crate) fn closed_joints(&self) -> Vec<f64> {
        let [_, mut closed] = straight_and_closed(self);
        closed.split_off(7)
    }

    /// The straight hand with its root frame at the origin, without surface points.
    pub fn straight(&self) -> PosedHand {
        let mut posed = PosedHand::default();
        self.pose_links(&Pose::at_origin(&self.straight_joints()), &mut posed);
        posed
    }
}

/// The reach of each digit, without the palm.
fn reaches(hand: &Hand) -> Vec<Reach> {
    let [straight, closed] = straight_and_closed(hand).map(|x| {
        let mut posed = PosedHand::default();
        hand.pose_links(&x, &mut posed);
        posed
    });
    (1..hand.digits.len())
        .map(|digit| {
            let first = hand.links.iter().position(|link| link.digit == digit);
            let root =
                first.map_or_else(Vector3::zeros, |l| straight.object_from_link[l].translation);
            // Link origins count too, because a fingertip may be a link without geometry.
            let capsules: Vec<usize> = (0..hand.capsules.len())
                .filter(|&c| hand.links[hand.capsules[c].link.0].digit == digit)
                .collect();
            let links: Vec<usize> = (0..hand.links.len())
                .filter(|&l| hand.links[l].digit == digit)
                .collect();
            let places = |posed: &PosedHand| -> Vec<Vector3<f64>> {
                let ends = capsules.iter().flat_map(|&c| posed.capsules[c]);
                let origins = links.iter().map(|&l| posed.object_from_link[l].translation);
                ends.chain(origins).collect()
            };
            let distances: Vec<f64> = (places(&straight).iter())
                .map(|place| (place - root).norm())
                .collect();
            let farthest = distances.iter().copied().fold(0.0, f64::max);
            // The tip is the mean of all points that are nearly as far out as the farthest one.
            let tip = |(_, distance): &(Vector3<f64>, &f64)| **distance >= TIP * farthest;
            let middle = |posed: &PosedHand| {
                let places = places(posed);
                let of_tip: Vec<Vector3<f64>> = (places.into_iter().zip(&distances))
                    .filter(tip)
                    .map(|(place, _)| place)
                    .collect();
                of_tip.iter().sum::<Vector3<f64>>() / of_tip.len().max(1) as f64
            };
            let out = middle(&straight);
            Reach {
                root,
                out: out - root,
                closing: middle(&closed) - out,
            }
        })
        .collect()
}

fn unit(v: &Vector3<f64>) -> Vector3<f64> {
    v.try_normalize(1e-6).unwrap_or_default()
}

/// The only digit, of three or more, with a link that the description calls a thumb: a thumb beside the fingers of a flat hand
/// does not stand out.
fn called_thumb(hand: &Hand, count: usize) -> Option<usize> {
    let called = |digit: &usize| {
        let own = hand.links.iter().filter(|link| link.digit == digit + 1);
        own.map(|link| link.name.to_lowercase())
            .any(|name| name.contains("thumb"))
    };
    let mut thumbs = (0..count).filter(called);
    match (thumbs.next(), thumbs.next()) {
        (Some(thumb), None) if count >= 3 => Some(thumb),
        _ => None,
    }
}

/// Puts the thumb first, if there is one, and names the digits: `thumb`, `finger 1`, …
///
/// The thumb is the digit, of three or more, whose direction and closing differ most from the others, if it stands out, or
/// else the one that the description calls so.
/// With a thumb the fingers are numbered across the palm from the thumb's side; otherwise they keep their order in the
/// description.
pub(super) fn name_digits(hand: &mut Hand) {
    let reaches = reaches(hand);
    let count = reaches.len();
    let mean = |own: usize, of: &dyn Fn(&Reach) -> Vector3<f64>| {
        let others = reaches.iter().enumerate().filter(|(d, _)| *d != own);
        let sum: Vector3<f64> = others.map(|(_, reach)| unit(&of(reach))).sum();
        sum / (count.max(2) - 1) as f64
    };
    let unlike = |d: usize| {
        let (out, closing) = (unit(&reaches[d].out), unit(&reaches[d].closing));
        2.0 - out.dot(&mean(d, &|reach| reach.out)) - closing.dot(&mean(d, &|reach| reach.closing))
    };
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| unlike(b).total_cmp(&unlike(a)));
    let thumb = (count >= 3)
        .then(|| (order[0], unlike(order[0]), unlike(order[1])))
        .filter(|(_, most, next)| *most > OPPOSED && *most > MORE * next)
        .map(|(digit, ..)| digit)
        .or_else(|| called_thumb(hand, count));

    let mut others: Vec<usize> = (0..count).filter(|d| Some(*d) != thumb).collect();
    if let Some(thumb) = thumb {
        let sum = |of: &dyn Fn(&Reach) -> Vector3<f64>| -> Vector3<f64> {
            others.iter().map(|&d| unit(&of(&reaches[d]))).sum()
        };
        let across = unit(&sum(&|reach| reach.out).cross(&sum(&|reach| reach.closing)));
        let along = |d: usize| across.dot(&reaches[d].root);
        let mean = others.iter().map(|&d| along(d)).sum::<f64>() / others.len() as f64;
        let side = (along(thumb) - mean).signum();
        others.sort_by(|&a, &b| (side * along(b)).total_cmp(&(side * along(a))));
    }
    let order: Vec<usize> = thumb.into_iter().chain(others).collect();
    for link in hand.links.iter_mut().filter(|link| link.digit > 0) {
        let place = order.iter().position(|d| d + 1 == link.digit);
        link.digit = place.map_or(0, |place| place + 1);
    }
    let fingers = count - usize::from(thumb.is_some());
    let names = thumb.map(|_| "thumb".to_owned()).into_iter();
    let names = names.chain((1..=fingers).map(|n| format!("finger {n}")));
    hand.digits = std::iter::once("palm".to_owned()).chain(names).collect();
}

/// The palm's frame.
///
/// If the digits close to one side, the palm faces that side and `distal` is the direction in which they point. In a
/// gripper the digits close on each other or spread out from the palm on opposite sides, and the palm faces between the
/// directions in which they point.
pub(super) fn palm_frame(hand: &Hand) -> PalmFrame {
    let mut rest = PosedHand::default();
    hand.pose(&hand.rest_coordinates(), &mut rest);
    let mean = |keep: &dyn Fn(usize) -> bool| {
        let kept = hand.surface.iter().zip(&rest.points);
        let kept = kept.filter(|(at, _)| keep(at.link.0));
        let (sum, area) = kept.fold((Vector3::zeros(), 0.0), |(sum, area), (at, p)| {
            (sum + p * at.area_m2, area + at.area_m2)
        });
        (area > 0.0).then(|| sum / area)
    };
    let all = mean(&|_| true).unwrap_or_default();
    let palm = mean(&|l| hand.links[l].digit == 0).unwrap_or(all);

    let reaches = reaches(hand);
    let thumb = usize::from(hand.digits.get(1).is_some_and(|name| name == "thumb"));
    let fingers = &reaches[thumb.min(reaches.len())..];
    let out: Vector3<f64> = fingers.iter().map(|reach| reach.out).sum();
    let tips = mean(&|l| hand.links[l].digit > 0 && hand.subtree_ends[l] == l + 1).unwrap_or(all);
    let distal = out
        .try_normalize(1e-6)
        .or_else(|| (tips - palm).try_normalize(1e-6))
        .unwrap_or_else(Vector3::z);
    let across = |v: &Vector3<f64>| v - distal * distal.dot(v);
    let closings = || reaches.iter().map(|reach| across(&reach.closing));
    let closing: Vector3<f64> = closings().sum();
    let lengths: f64 = closings().map(|closing| closing.norm()).sum();
    let length = out.norm() / fingers.len().max(1) as f64;

    let away = thumb == 1 && unit(&reaches[0].out).dot(&distal) < AWAY;
    let one_sided = closing.norm() > ONE_SIDED * lengths && lengths > 1e-6;
    let (volar, distal, faced_m) = if one_sided && !away {
        (closing.normalize(), distal, FACED * length)
    } else {
        // The palm faces between the thumb and the fingers; `distal` is the direction in which the first digit closes.
        let opposite = if thumb == 1 {
            reaches[0].out
        } else {
            Vector3::zeros()
        };
        // A thumb of fewer links is shorter than fingers that spread out to the other side.
        let between = if away {
            distal + unit(&opposite)
        } else {
            out / fingers.len().max(1) as f64 + opposite
        };
        let volar = between.try_normalize(1e-6).unwrap_or(distal);
        let first = reaches
            .first()
            .map_or_else(Vector3::zeros, |reach| reach.closing);
        let helper = volar.cross(&Vector3::ith(volar.iamin(), 1.0));
        let other = (first - volar * volar.dot(&first)).try_normalize(1e-6);
        (volar, other.unwrap_or_else(|| helper.normalize()), 0.0)
    };
    let of_palm = hand.surface.iter().zip(&rest.points);
    let of_palm = of_palm.filter(|(at, _)| hand.links[at.link.0].digit == 0);
    let height = of_palm
        .map(|(_, p)| volar.dot(&(p - palm)))
        .fold(0.0, f64::max);
    PalmFrame {
        centre: palm + volar * height,
        volar,
        distal,
        faced_m,
    }
}
