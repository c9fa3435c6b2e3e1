//! Whether a hand that can be read can also be meant: units, scales and signs that were probably confused.
//!
//! Each check is one entry of a table. A check that is nearly certain refuses the hand, and the others note what they found.
//! All numbers lie well outside those of published hands.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::model::{Model, ModelJoint};
use super::{Frame, Hand, HandError, JointKind, LinkId, PosedHand};
use crate::doubt::Doubt;

/// What a check found.
enum Finding {
    /// It may be right.
    Note(Doubt),
    /// It cannot be right.
    Refusal(Doubt),
}

/// The checks of joints, which need no geometry.
const OF_JOINTS: [fn(&Model) -> Vec<Finding>; 3] =
    [limits_in_degrees, limits_in_radians, long_slides];
/// The checks of shapes, on the hand at rest without surface points. A later one may rest on the earlier ones.
const OF_SHAPE: [fn(&Hand, &PosedHand) -> Vec<Finding>; 5] = [
    huge_part,
    tiny_part,
    whole_size,
    distant_root,
    reversed_joint,
];

/// Notes what is doubtful about the joints.
///
/// # Errors
/// If something cannot be meant.
pub(super) fn judge_joints(model: &mut Model) -> Result<(), HandError> {
    let found = OF_JOINTS.iter().flat_map(|check| check(model));
    let notes = taken(found)?;
    model.notes.extend(notes);
    Ok(())
}

/// Notes what is doubtful about the sizes and places of a hand's parts.
///
/// # Errors
/// If something cannot be meant.
pub(super) fn judge_shape(hand: &mut Hand, rest: &PosedHand) -> Result<(), HandError> {
    let found = OF_SHAPE.iter().flat_map(|check| check(hand, rest));
    let notes = taken(found)?;
    hand.notes.extend(notes);
    Ok(())
}

/// The notes, unless there is a refusal.
fn taken(found: impl Iterator<Item = Finding>) -> Result<Vec<String>, HandError> {
    found
        .map(|finding| match finding {
            Finding::Note(doubt) => Ok(doubt.to_string()),
            Finding::Refusal(doubt) => Err(HandError::Implausible(doubt)),
        })
        .collect()
}

fn doubt(subject: String, finding: String, cause: &str, remedy: &str) -> Doubt {
    Doubt {
        subject,
        finding,
        cause: format!("probably {cause}"),
        remedy: remedy.to_owned(),
    }
}

fn limited(model: &Model, kind: JointKind) -> impl Iterator<Item = (&ModelJoint, [f64; 2])> {
    let of_kind = model.joints.iter().filter(move |joint| joint.kind == kind);
    of_kind.filter_map(|joint| Some((joint, joint.limits?)))
}

/// A hinge of a limb makes no whole turn. Two turns are refused. Beyond 720, which is no usual angle in degrees either, the
/// table of all numbers refuses the file.
fn limits_in_degrees(model: &Model) -> Vec<Finding> {
    let finding = |(joint, limits): (&ModelJoint, [f64; 2])| {
        let most = limits[0].abs().max(limits[1].abs());
        if !(most > TAU * 1.001 && most <= 720.0) {
            return None;
        }
        let degrees = limits.map(f64::to_degrees);
        let doubt = doubt(
            format!("joint \"{}\"", joint.name),
            format!("its range is {:.0}° to {:.0}°", degrees[0], degrees[1]),
            "its limits are in degrees",
            "give them in radians (MJCF: or set <compiler angle=\"degree\"/>)",
        );
        Some(if most > 2.0 * TAU {
            Finding::Refusal(doubt)
        } else {
            Finding::Note(doubt)
        })
    };
    // A joint that follows another may be a gear or a spool with many turns.
    limited(model, JointKind::Hinge)
        .filter(|(joint, _)| joint.follows.is_none())
        .filter_map(finding)
        .collect()
}

/// Half a turn, π, is this angle in radians if it was taken for degrees.
const HALF_TURN_TWICE_CONVERTED: f64 = PI * PI / 180.0;

/// In a hand with hinges only, some hinge turns by more than a few degrees.
fn limits_in_radians(model: &Model) -> Vec<Finding> {
    let widest = limited(model, JointKind::Hinge)
        .filter(|(joint, _)| joint.follows.is_none())
        .map(|(joint, [low, high])| (high - low, joint))
        .max_by(|(a, _), (b, _)| a.total_cmp(b));
    let other = |joint: &ModelJoint| joint.kind == JointKind::Slide || joint.limits.is_none();
    let Some((range, joint)) = widest.filter(|_| !model.joints.iter().any(other)) else {
        return Vec::new();
    };
    if !(range > 0.0 && range <= 1.01 * HALF_TURN_TWICE_CONVERTED) {
        return Vec::new();
    }
    vec![Finding::Refusal(doubt(
        format!("joint \"{}\"", joint.name),
        format!(
            "its range of {:.2}° is the widest of all joints, so the hand can hardly move",
            range.to_degrees()
        ),
        "its limits are in radians where degrees are expected",
        "set <compiler angle=\"radian\"/> (MJCF), or give wider limits",
    ))]
}

/// Longest slide of a hand, metres.
const LONG_SLIDE_M: f64 = 1.0;

fn long_slides(model: &Model) -> Vec<Finding> {
    let finding = |(joint, [low, high]): (&ModelJoint, [f64; 2])| {
        (high - low > LONG_SLIDE_M).then(|| {
            Finding::Note(doubt(
                format!("joint \"{}\"", joint.name),
                format!("it slides by {:.2} m", high - low),
                "its limits are in millimetres or centimetres",
                "give them in metres",
            ))
        })
    };
    limited(model, JointKind::Slide)
        .filter_map(finding)
        .collect()
}

/// A box around points, along the axes of their frame.
#[derive(Clone, Copy)]
struct Extent {
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Extent {
    fn around(points: impl Iterator<Item = Vector3<f64>>) -> Option<Self> {
        points.fold(None, |all: Option<Self>, point| {
            Some(all.map_or(
                Self {
                    low: point,
                    high: point,
                },
                |all| Self {
                    low: all.low.inf(&point),
                    high: all.high.sup(&point),
                },
            ))
        })
    }

    /// The longest side, metres.
    fn longest_m(&self) -> f64 {
        (self.high - self.low).max()
    }
}

/// Corners of the geometry of a link that is posed at `frame`.
fn corners<'a>(
    hand: &'a Hand,
    link: LinkId,
    frame: &'a Frame,
) -> impl Iterator<Item = Vector3<f64>> + 'a {
    let capsules = hand.capsules.iter().filter(move |c| c.link == link);
    let round = capsules.flat_map(|capsule| {
        let reach = Vector3::repeat(capsule.radius_m);
        let ends = [capsule.a, capsule.b].map(|end| frame.point(&end));
        ends.into_iter()
            .flat_map(move |end| [end - reach, end + reach])
    });
    let meshes = hand.meshes.iter().filter(move |mesh| mesh.link == link);
    let vertices = meshes.flat_map(|mesh| &mesh.vertices);
    round.chain(vertices.map(|vertex| frame.point(vertex)))
}

/// Longest sides of the geometry of all links that have any, metres, with the median of all sides.
fn sizes(hand: &Hand) -> Option<(Vec<(LinkId, f64)>, f64)> {
    let none = Frame::default();
    let sizes: Vec<(LinkId, f64)> = (0..hand.links.len())
        .map(LinkId)
        .filter_map(|link| {
            Some((
                link,
                Extent::around(corners(hand, link, &none))?.longest_m(),
            ))
        })
        .collect();
    let mut sorted: Vec<f64> = sizes.iter().map(|(_, size)| *size).collect();
    sorted.sort_by(f64::total_cmp);
    // Of an even number the smaller one, so that one of two links can be too large.
    let median = *sorted.get(sorted.len().saturating_sub(1) / 2)?;
    Some((sizes, median))
}

/// A link is too large if it exceeds both this multiple of the median and this length. The forearm of a hand of small links is
/// ten times as long as these.
const MANY_TIMES: f64 = 20.0;
const HUGE_M: f64 = 0.5;

fn huge_part(hand: &Hand, _: &PosedHand) -> Vec<Finding> {
    let Some((sizes, median)) = sizes(hand) else {
        return Vec::new();
    };
    // The link of an arm may be that long.
    let huge = sizes
        .into_iter()
        .filter(|&(link, size)| size >= MANY_TIMES * median && size > HUGE_M && !hand.is_arm(link));
    huge.map(|(link, size)| {
        Finding::Refusal(doubt(
            format!("link \"{}\"", hand.links[link.0].name),
            format!(
                "its geometry is {size:.2} m long, {:.0} times as long as that of the median link ({:.0} mm)",
                size / median,
                1e3 * median
            ),
            "it is in millimetres or centimetres",
            "give it in metres (a mesh in millimetres: scale=\"0.001 0.001 0.001\")",
        ))
    })
    .collect()
}

/// No link of a hand is smaller, metres.
const TINY_M: f64 = 0.5e-3;

fn tiny_part(hand: &Hand, _: &PosedHand) -> Vec<Finding> {
    let (sizes, _) = sizes(hand).unwrap_or_default();
    let tiny = sizes.into_iter().filter(|(_, size)| *size < TINY_M);
    tiny.map(|(link, size)| {
        Finding::Note(doubt(
            format!("link \"{}\"", hand.links[link.0].name),
            format!("its geometry is only {:.3} mm long", 1e3 * size),
            "a mesh in metres is scaled to millimetres",
            "leave out its scale",
        ))
    })
    .collect()
}

/// Longest sides that a hand without its arm may have at rest: noted and refused below and above, metres.
const SMALL_M: [f64; 2] = [0.02, 0.005];
const LARGE_M: [f64; 2] = [1.0, 2.0];

fn whole_size(hand: &Hand, rest: &PosedHand) -> Vec<Finding> {
    let own = (0..hand.links.len())
        .map(LinkId)
        .filter(|&link| !hand.is_arm(link));
    let own = own.flat_map(|link| corners(hand, link, &rest.object_from_link[link.0]));
    let Some(size) = Extent::around(own).map(|extent| extent.longest_m()) else {
        return Vec::new();
    };
    let found = |sure: bool, cause: &str, remedy: &str| {
        let doubt = doubt(
            format!("hand \"{}\"", hand.name),
            format!("it measures {:.0} mm at rest", 1e3 * size),
            cause,
            remedy,
        );
        vec![if sure {
            Finding::Refusal(doubt)
        } else {
            Finding::Note(doubt)
        }]
    };
    if size > LARGE_M[0] {
        return found(
            size > LARGE_M[1],
            "its lengths are in millimetres or centimetres",
            "give them in metres (meshes in millimetres: scale=\"0.001 0.001 0.001\")",
        );
    }
    if size < SMALL_M[0] {
        return found(
            size < SMALL_M[1],
            "its lengths were scaled twice",
            "give them in metres",
        );
    }
    Vec::new()
}

/// The root of a description lies in or near the hand, metres.
const DISTANT_M: f64 = 0.3;

fn distant_root(hand: &Hand, rest: &PosedHand) -> Vec<Finding> {
    let gaps = hand
        .capsules
        .iter()
        .zip(&rest.capsules)
        .map(|(capsule, ends)| super::axis_distance(&Vector3::zeros(), ends) - capsule.radius_m);
    let gap = gaps.fold(f64::INFINITY, f64::min);
    if gap < DISTANT_M {
        return Vec::new();
    }
    vec![Finding::Note(doubt(
        format!("hand \"{}\"", hand.name),
        format!(
            "its nearest part is {:.0} mm from the origin of its root link \"{}\", about which poses turn it",
            1e3 * gap,
            hand.links[0].name
        ),
        "it is still on the mount or arm that it was described with",
        "describe the hand alone, or check the origins of the joints in front of it",
    ))]
}

/// Joints of different digits are alike if their axes and the directions to their tips differ by less: the cosine of 18°.
const ALIKE: f64 = 0.95;
/// A digit stands opposite others if these lie in the direction in which it closes: the cosine of 60°.
const OPPOSITE: f64 = 0.5;
/// A range is one-sided if at most this share of it is on the other side of zero.
const ONE_SIDED: f64 = 0.2;

/// A hinge that turns only to one side where the alike hinges of at least two other digits, and of most, turn only to the other.
///
/// A thumb that closes against the fingers turns to the other side as well, but toward them.
fn reversed_joint(hand: &Hand, _: &PosedHand) -> Vec<Finding> {
    let straight = hand.straight();
    let hinges: Vec<Hinge> = (0..hand.joints.len())
        .filter_map(|joint| Hinge::of(hand, &straight, joint))
        .collect();
    let reversed = hinges.iter().filter(|own| {
        let alike = hinges.iter().filter(|other| own.is_alike(other));
        let (others, same): (Vec<&Hinge>, Vec<&Hinge>) =
            alike.partition(|other| other.side * own.side < 0.0);
        let mean = others.iter().map(|other| other.root).sum::<Vector3<f64>>()
            / others.len().max(1) as f64;
        let toward = (mean - own.root).try_normalize(1e-6).unwrap_or_default();
        others.len() >= 2 && others.len() > same.len() && own.closing().dot(&toward) < OPPOSITE
    });
    reversed
        .map(|own| {
            let joint = &hand.joints[own.joint];
            let [low, high] = joint.limits.map(f64::to_degrees);
            Finding::Note(doubt(
                format!("joint \"{}\"", joint.name),
                format!(
                    "its range is {low:.0}° to {high:.0}°, while the same joints of the other digits turn to the other side"
                ),
                "the signs of its limits or of its axis are reversed",
                "compare it with the other digits",
            ))
        })
        .collect()
}

/// A hinge of a straight digit that turns to one side only.
struct Hinge {
    joint: usize,
    digit: usize,
    /// Its place among the joints of the digit.
    place: usize,
    /// Where the digit begins.
    root: Vector3<f64>,
    axis: Vector3<f64>,
    /// Unit vector from the hinge to the tip of the digit.
    out: Vector3<f64>,
    /// The sign of its range.
    side: f64,
}

impl Hinge {
    fn of(hand: &Hand, straight: &PosedHand, j: usize) -> Option<Self> {
        let joint = &hand.joints[j];
        let link = &hand.links[joint.link.0];
        let motion = link
            .motion
            .filter(|motion| motion.kind == JointKind::Hinge)?;
        if link.digit == 0 || joint.wraps {
            return None;
        }
        let [low, high] = joint.limits;
        let [below, above] = [(-low).max(0.0), high.max(0.0)];
        let side = if below <= ONE_SIDED * above {
            1.0
        } else if above <= ONE_SIDED * below {
            -1.0
        } else {
            return None;
        };
        let of_digit = |l: &LinkId| hand.links[l.0].digit == link.digit;
        let first = (0..hand.links.len()).map(LinkId).find(of_digit)?;
        let place = (hand.joints.iter())
            .filter(|other| of_digit(&other.link) && other.link.0 < joint.link.0)
            .count();
        let frame = &straight.object_from_link[joint.link.0];
        let below = joint.link.0..hand.subtree_ends[joint.link.0];
        let capsules = hand.capsules.iter().zip(&straight.capsules);
        let ends = capsules
            .filter(|(capsule, _)| below.contains(&capsule.link.0))
            .flat_map(|(_, ends)| *ends);
        let tip = ends
            .map(|end| end - frame.translation)
            .max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
        Some(Self {
            joint: j,
            digit: link.digit,
            place,
            root: straight.object_from_link[first.0].translation,
            axis: frame.direction(&motion.axis),
            out: tip.try_normalize(1e-6)?,
            side,
        })
    }

    fn is_alike(&self, other: &Self) -> bool {
        self.digit != other.digit
            && self.place == other.place
            && self.axis.dot(&other.axis) > ALIKE
            && self.out.dot(&other.out) > ALIKE
    }

    /// Direction in which its tip moves.
    fn closing(&self) -> Vector3<f64> {
        (self.axis * self.side).cross(&self.out)
    }
}
