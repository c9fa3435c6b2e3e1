//! Whether a hand can span an object at all, told before a search.

use crate::doubt::Doubt;
use crate::grasp::filter::STRICT_FRICTION;
use crate::hand::{Hand, PosedHand};
use crate::object::Object;

/// Largest number of rounds over all joints in the search for the widest span of a hand.
const ROUNDS: usize = 8;
/// Values of a joint that are tried, as shares of its range.
const TRIED: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// A size that hardly fits the hand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SizeDoubt {
    /// The reason.
    pub doubt: Doubt,
    /// Whether no grasp can exist.
    pub sure: bool,
}

/// A doubt if the object is too large or too small for the hand. `scale` is the scale that the object was built at.
///
/// The width of the object at a point of its surface is the length of the straight line from there along the normal, inward or
/// outward, to the next point of the surface; the least over all samples of the surface counts, so that an edge, a handle or a
/// hole that can be grasped is enough. The span of the hand is the largest distance between two surface points of different
/// digits, or of a digit and the palm.
///
/// Contacts on a ball of width w that balance with friction μ include three of which two are at least √3 w / (2 √(1 + μ²))
/// apart. A hand whose span is less than this surely cannot hold it.
pub fn doubted_size(hand: &Hand, object: &Object, scale: f64) -> Option<SizeDoubt> {
    too_small(hand, object, scale).or_else(|| too_large(hand, object, scale))
}

fn too_large(hand: &Hand, object: &Object, scale: f64) -> Option<SizeDoubt> {
    let mut posed = PosedHand::default();
    hand.pose(&hand.rest_coordinates(), &mut posed);
    let at_rest_m = (0..hand.digits.len())
        .flat_map(|one| (0..one).map(move |other| [one, other]))
        .map(|digits| apart_m(hand, &posed, digits))
        .fold(0.0, f64::max);
    let width_m = least_width_m(object, at_rest_m)?;
    let span_m = span_m(hand).max(at_rest_m);
    // Without two parts that can touch there is no span to compare with.
    if span_m == 0.0 || width_m <= span_m {
        return None;
    }
    let needed = 3.0_f64.sqrt() / 2.0 / (1.0 + STRICT_FRICTION * STRICT_FRICTION).sqrt();
    // The power of ten that makes it as wide as a hand is.
    let mut factor = 0.1;
    while factor * width_m > span_m {
        factor /= 10.0;
    }
    let millimetres = |length_m: f64| 1e3 * length_m;
    Some(SizeDoubt {
        sure: span_m < needed * width_m,
        doubt: Doubt {
            subject: object.name.clone(),
            finding: format!(
                "it is {:.0} mm wide where it is narrowest, but the {} hand spans at most {:.0} mm",
                millimetres(width_m),
                hand.name,
                millimetres(span_m)
            ),
            cause: "probably its size is in another unit, or it is made for a larger hand"
                .to_owned(),
            remedy: format!(
                "scale it (--scale {} makes it {:.0} mm wide there), or name a larger hand (--hand)",
                shortened(scale * factor),
                millimetres(width_m * factor)
            ),
        },
    })
}

fn too_small(hand: &Hand, object: &Object, scale: f64) -> Option<SizeDoubt> {
    let of_digits = |link: usize| hand.links[link].digit > 0;
    let capsules = hand
        .capsules
        .iter()
        .filter(|capsule| of_digits(capsule.link.0));
    let mut radii_m: Vec<f64> = capsules.map(|capsule| capsule.radius_m).collect();
    radii_m.sort_by(f64::total_cmp);
    let radius_m = *radii_m.get(radii_m.len() / 2)?;
    let size_m = object.mesh.size_m();
    if size_m >= radius_m {
        return None;
    }
    Some(SizeDoubt {
        sure: false,
        doubt: Doubt {
            subject: object.name.clone(),
            finding: format!(
                "its longest side is {:.1} mm, less than the radius of the fingers of the {} hand ({:.1} mm)",
                1e3 * size_m,
                hand.name,
                1e3 * radius_m
            ),
            cause: "probably its size is in another unit".to_owned(),
            remedy: format!(
                "scale it (--scale {} makes it ten times as large)",
                shortened(10.0 * scale)
            ),
        },
    })
}

/// A factor with four digits.
fn shortened(factor: f64) -> f64 {
    format!("{factor:.3e}").parse().unwrap_or(factor)
}

/// The least width of the object; `None` if some width is at most `enough_m`.
fn least_width_m(object: &Object, enough_m: f64) -> Option<f64> {
    let mut least_m = f64::INFINITY;
    for sample in &object.surface_samples {
        for direction in [-sample.normal, sample.normal] {
            if let Some(width_m) = object.exact.next_along(&sample.point, &direction) {
                least_m = least_m.min(width_m);
            }
        }
        if least_m <= enough_m {
            return None;
        }
    }
    Some(least_m).filter(|width_m| width_m.is_finite())
}

/// Largest distance between surface points of two digits in a pose, metres.
fn apart_m(hand: &Hand, posed: &PosedHand, [one, other]: [usize; 2]) -> f64 {
    let of = |digit: usize| {
        let points = hand.surface.iter().zip(&posed.points);
        points.filter(move |(point, _)| hand.links[point.link.0].digit == digit)
    };
    let mut widest = 0.0_f64;
    for (_, a) in of(one) {
        for (_, b) in of(other) {
            widest = widest.max((a - b).norm_squared());
        }
    }
    widest.sqrt()
}

/// Largest distance between surface points of two digits, or of a digit and the palm, in any pose: for each two of them, each
/// joint in turn takes the value with the largest distance, until no joint gains.
fn span_m(hand: &Hand) -> f64 {
    let mut posed = PosedHand::default();
    let mut span_m = 0.0_f64;
    for one in 0..hand.digits.len() {
        for other in 0..one {
            let mut pose = hand.rest_coordinates();
            let first = pose.len() - hand.joints.len();
            let mut widest_m = 0.0;
            for _ in 0..ROUNDS {
                let before_m = widest_m;
                for (number, joint) in hand.joints.iter().enumerate() {
                    let [low, high] = joint.limits;
                    let mut best = pose[first + number];
                    for share in TRIED {
                        pose[first + number] = low + share * (high - low);
                        hand.pose(&pose, &mut posed);
                        let apart_m = apart_m(hand, &posed, [one, other]);
                        if apart_m > widest_m {
                            (widest_m, best) = (apart_m, pose[first + number]);
                        }
                    }
                    pose[first + number] = best;
                }
                if widest_m <= before_m {
                    break;
                }
            }
            span_m = span_m.max(widest_m);
        }
    }
    span_m
}
