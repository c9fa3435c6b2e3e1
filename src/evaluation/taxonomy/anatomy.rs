//! The anatomical part of each surface point, for any hand built like a human one.

use nalgebra::Vector3;

use super::facts::DIGITS;
use crate::hand::{Hand, LinkId, PatchSide, PosedHand};

/// Links whose joints lie closer together than this share of the palm's breadth are one bone, for example the hinges of a
/// knuckle.
const SAME_BONE: f64 = 0.08;
/// A palm patch faces the back of the hand or the thumb's side if the component of its normal passes this threshold.
const DORSUM: f64 = -0.35;
const WEB: f64 = 0.7;

/// A bone of a digit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Bone {
    /// First bone of the thumb only.
    Metacarpal,
    /// First phalanx.
    Proximal,
    /// Second phalanx of a finger.
    Middle,
    /// Last phalanx.
    Distal,
}

/// A part of the palm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PalmPart {
    /// The parts that touch in a palm grasp: the ball of the thumb, the ball of the little finger, the hollow between, and
    /// the heads of the metacarpals.
    Volar,
    /// The edge between thumb and index finger.
    Web,
    /// The back of the hand.
    Dorsum,
}

/// The part of the hand at a surface point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Patch {
    /// On the palm.
    Palm(PalmPart),
    /// On a digit: 1 = thumb, 2 = index, 3 = middle, 4 = ring, 5 = little.
    Digit(usize, Bone, PatchSide),
}

impl Patch {
    /// The name of the part, as hands that name their regions spell it: `thumb.distal.pad`, `palm.web`.
    pub fn name(self) -> String {
        match self {
            Self::Palm(PalmPart::Volar) => "palm".to_owned(),
            Self::Palm(PalmPart::Web) => "palm.web".to_owned(),
            Self::Palm(PalmPart::Dorsum) => "palm.dorsum".to_owned(),
            Self::Digit(digit, bone, side) => {
                let bone = match bone {
                    Bone::Metacarpal => "metacarpal",
                    Bone::Proximal => "proximal",
                    Bone::Middle => "middle",
                    Bone::Distal => "distal",
                };
                format!("{}.{bone}.{}", DIGITS[digit - 1], side.name())
            }
        }
    }
}

/// The direction of a bone to the tip, in its link's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BoneAxis {
    pub(super) bone: Bone,
    pub(super) link: LinkId,
    pub(super) distal: Vector3<f64>,
}

/// Directions of the palm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PalmAxes {
    /// Out of the palm.
    pub volar: Vector3<f64>,
    /// To the fingertips.
    pub distal: Vector3<f64>,
    /// To the thumb.
    pub radial: Vector3<f64>,
}

/// Why a hand is not built like a human one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unlike {
    /// No digit stands out as a thumb.
    #[error(
        "no digit stands out as a thumb: a thumb differs in direction and closing from the other digits"
    )]
    NoThumb,
    /// The number of fingers is not three or four.
    #[error("it has a thumb, but {0} fingers instead of three or four")]
    Fingers(usize),
    /// A digit has a single phalanx.
    #[error("digit {0}, counted from the thumb, has fewer than two phalanges")]
    Phalanges(usize),
    /// The direction in which a digit closes is unknown.
    #[error("digit {0}, counted from the thumb, does not bend")]
    Rigid(usize),
    /// There is no palm to which digits are attached.
    #[error("it has no palm to which digits are attached")]
    NoPalm,
}

/// A hand interpreted as a human one.
#[derive(Debug, Clone, PartialEq)]
pub struct Anatomy {
    /// The patch of each surface point.
    pub(super) patches: Vec<Patch>,
    /// Bones of the digits, thumb first, each from the palm to the tip; empty for a digit that is missing.
    pub(super) digits: [Vec<BoneAxis>; 5],
    palm: LinkId,
    /// Directions in the frame of the link `palm`.
    axes: PalmAxes,
}

/// The digit and bone of a link, and three directions in the link's frame: out of the pad, to the radial side and to the
/// tip.
type Sides = (usize, Bone, [Vector3<f64>; 3]);

/// The bones of one digit of a hand, all hinges straight.
struct Chain {
    /// Links of each bone, from the palm to the tip.
    bones: Vec<Vec<usize>>,
    /// Direction of each bone, root frame.
    directions: Vec<Vector3<f64>>,
    /// Origin of the finger: the joint of its proximal phalanx, root frame.
    base: Vector3<f64>,
}

impl Anatomy {
    /// Interprets a hand as a human one.
    ///
    /// The hand must have a thumb, as [`Hand`] finds it. Digits named `thumb` and `index`, `middle`, `ring` or `little` (any
    /// of them) are taken by their names. Any other hand must have three or four fingers, all digits of at least two bones;
    /// the finger nearest to the thumb is the index finger. A finger of two bones has a proximal and a distal one. Bones
    /// follow from the joints between them, and sides from the direction in which the digit closes.
    ///
    /// # Errors
    /// If that would be a guess; the error tells which condition failed.
    pub fn of(hand: &Hand) -> Result<Self, Unlike> {
        let straight = hand.straight();
        let reaches = hand.straight_joints();
        let digits: Vec<usize> = (1..hand.digits.len()).collect();
        let palm_link = palm_link(hand).ok_or(Unlike::NoPalm)?;
        let root = &straight.object_from_link[0];
        let volar = root.direction(&hand.palm.volar);
        let distal = root.direction(&hand.palm.distal);
        let across = distal.cross(&volar);

        let origins: Vec<Vector3<f64>> = digits
            .iter()
            .filter_map(|digit| hand.links.iter().position(|link| link.digit == *digit))
            .map(|link| straight.object_from_link[link].translation)
            .collect();
        let apart = SAME_BONE * breadth(&origins, &across).max(1e-3);
        let chains: Vec<Chain> = digits
            .iter()
            .map(|digit| Chain::of(hand, &straight, *digit, apart))
            .collect();

        let human = human_digits(hand, &chains, &across)?;
        let radial = radial(&chains, &human, &across).ok_or(Unlike::NoPalm)?;
        let chirality = radial.dot(&across).signum();

        let mut axes: [Vec<BoneAxis>; 5] = Default::default();
        let mut of_link: Vec<Option<Sides>> = vec![None; hand.links.len()];
        for (chain, &digit) in chains.iter().zip(&human) {
            let pad = if digit == 1 {
                let closing = chain.closing(hand, &straight, &reaches);
                closing.ok_or(Unlike::Rigid(digit))?
            } else {
                volar
            };
            for (place, links) in chain.bones.iter().enumerate() {
                let Some(bone) = bone_of(digit, place, chain.bones.len()) else {
                    continue;
                };
                let along = chain.directions[place];
                let pad = (pad - along * along.dot(&pad)).try_normalize(1e-6);
                let pad = pad.ok_or(Unlike::Rigid(digit))?;
                let side = along.cross(&pad) * chirality;
                for &link in links {
                    let frame = &straight.object_from_link[link];
                    let local = [pad, side, along].map(|axis| frame.rotation.tr_mul(&axis));
                    of_link[link] = Some((digit, bone, local));
                }
                // All hinges of the bone turn the last link.
                let link = links[links.len() - 1];
                axes[digit - 1].push(BoneAxis {
                    bone,
                    link: LinkId(link),
                    distal: straight.object_from_link[link].rotation.tr_mul(&along),
                });
            }
        }
        let patch = |i: usize| {
            let point = &hand.surface[i];
            let Some((digit, bone, [pad, side, along])) = of_link[point.link.0] else {
                let normal = straight.object_from_link[point.link.0].direction(&point.normal);
                return Patch::Palm(part_of_palm(&normal, &volar, &radial));
            };
            let parts = [pad, side, along].map(|axis| axis.dot(&point.normal));
            Patch::Digit(digit, bone, PatchSide::of(parts, bone == Bone::Distal))
        };
        let patches = (0..hand.surface.len())
            .map(|i| tagged(&hand.regions[hand.surface[i].region]).unwrap_or_else(|| patch(i)))
            .collect();
        let frame = &straight.object_from_link[palm_link];
        let local = |axis: &Vector3<f64>| frame.rotation.tr_mul(axis);
        Ok(Self {
            patches,
            digits: axes,
            palm: LinkId(palm_link),
            axes: PalmAxes {
                volar: local(&volar),
                distal: local(&distal),
                radial: local(&radial),
            },
        })
    }

    /// The part of the hand at a surface point.
    ///
    /// # Panics
    /// If the hand has no such point.
    pub fn patch(&self, surface_point: usize) -> Patch {
        self.patches[surface_point]
    }

    /// Whether the hand has this digit (1 = thumb … 5 = little).
    pub fn has(&self, digit: usize) -> bool {
        !self.bones(digit).is_empty()
    }

    /// Whether the hand has this bone of a digit.
    pub(super) fn has_bone(&self, digit: usize, bone: Bone) -> bool {
        self.bones(digit).iter().any(|axis| axis.bone == bone)
    }

    fn bones(&self, digit: usize) -> &[BoneAxis] {
        digit
            .checked_sub(1)
            .and_then(|place| self.digits.get(place))
            .map_or(&[], Vec::as_slice)
    }

    /// Directions of the palm, object frame.
    pub fn palm_axes(&self, posed: &PosedHand) -> PalmAxes {
        let frame = &posed.object_from_link[self.palm.0];
        PalmAxes {
            volar: frame.direction(&self.axes.volar),
            distal: frame.direction(&self.axes.distal),
            radial: frame.direction(&self.axes.radial),
        }
    }

    /// Direction of a bone to the tip, object frame; `None` if the hand does not have it.
    pub fn direction(&self, posed: &PosedHand, digit: usize, bone: Bone) -> Option<Vector3<f64>> {
        let axis = self.bones(digit).iter().find(|axis| axis.bone == bone)?;
        Some(posed.object_from_link[axis.link.0].direction(&axis.distal))
    }

    /// The patch of a point on a link with this outward normal (link frame). It is taken from the surface point of the link
    /// with the most similar normal, for contacts that are annotated rather than measured.
    pub fn patch_on(&self, hand: &Hand, link: LinkId, normal: &Vector3<f64>) -> Option<Patch> {
        let points = (0..hand.surface.len()).filter(|&i| hand.surface[i].link == link);
        let alike = |i: &usize| hand.surface[*i].normal.dot(normal);
        let nearest = points.max_by(|a, b| alike(a).total_cmp(&alike(b)))?;
        Some(self.patches[nearest])
    }
}

/// Extent of some points along a direction.
fn breadth(points: &[Vector3<f64>], across: &Vector3<f64>) -> f64 {
    let along: Vec<f64> = points.iter().map(|point| across.dot(point)).collect();
    let high = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = along.iter().copied().fold(f64::INFINITY, f64::min);
    high - low
}

/// The direction `across` the palm or its opposite: the one from the last finger to the thumb.
fn radial(chains: &[Chain], human: &[usize], across: &Vector3<f64>) -> Option<Vector3<f64>> {
    let thumb = human.iter().position(|digit| *digit == 1)?;
    let last = (0..human.len()).max_by_key(|d| human[*d])?;
    let toward = chains[thumb].base - chains[last].base;
    Some(across * across.dot(&toward).signum())
}

/// The part of the palm where the skin faces `normal`.
fn part_of_palm(normal: &Vector3<f64>, volar: &Vector3<f64>, radial: &Vector3<f64>) -> PalmPart {
    if volar.dot(normal) < DORSUM {
        PalmPart::Dorsum
    } else if radial.dot(normal) > WEB {
        PalmPart::Web
    } else {
        PalmPart::Volar
    }
}

impl Chain {
    fn of(hand: &Hand, straight: &PosedHand, digit: usize, apart: f64) -> Self {
        let origin = |link: usize| straight.object_from_link[link].translation;
        let touched = |link: usize| hand.surface.iter().any(|point| point.link.0 == link);
        let mut bones: Vec<Vec<usize>> = Vec::new();
        let of_digit = (0..hand.links.len()).filter(|&l| hand.links[l].digit == digit);
        for link in of_digit {
            let fixed = !hand.links[link].moves();
            match bones.last_mut() {
                Some(bone) if fixed || (origin(bone[0]) - origin(link)).norm() < apart => {
                    bone.push(link);
                }
                _ => bones.push(vec![link]),
            }
        }
        bones.retain(|links| links.iter().any(|link| touched(*link)));
        let ends = |links: &[usize]| {
            let capsules = (hand.capsules.iter().zip(&straight.capsules))
                .filter(|(capsule, _)| links.contains(&capsule.link.0));
            let start = origin(links[0]);
            let ends = capsules.flat_map(|(_, ends)| *ends);
            ends.max_by(|a, b| (a - start).norm().total_cmp(&(b - start).norm()))
        };
        let directions = (0..bones.len())
            .map(|place| {
                let start = origin(bones[place][0]);
                let end = match bones.get(place + 1) {
                    Some(next) => origin(next[0]),
                    None => ends(&bones[place]).unwrap_or(start),
                };
                (end - start).try_normalize(1e-9).unwrap_or_default()
            })
            .collect();
        let base = bones
            .get(bones.len().saturating_sub(3))
            .map_or_else(Vector3::zeros, |bone| origin(bone[0]));
        Self {
            bones,
            directions,
            base,
        }
    }

    /// The direction in which the last bone's hinge moves the tip, root frame.
    fn closing(&self, hand: &Hand, straight: &PosedHand, joints: &[f64]) -> Option<Vector3<f64>> {
        let last = self.bones.last()?;
        let link = *last
            .iter()
            .find(|link| hand.links[**link].motion.is_some())?;
        let motion = hand.links[link].motion?;
        let [lower, upper] = hand.joints[motion.joint].limits;
        let sign = (f64::midpoint(lower, upper) - joints[motion.joint]) * motion.ratio;
        let axis = straight.object_from_link[link].direction(&motion.axis) * sign.signum();
        Some(axis.cross(self.directions.last()?))
    }
}

/// The bone of a digit by its place in the chain, where the digit has `count` bones.
fn bone_of(digit: usize, place: usize, count: usize) -> Option<Bone> {
    let bones: &[Bone] = match (digit, count) {
        (1, _) => &[Bone::Distal, Bone::Proximal, Bone::Metacarpal],
        (_, 2) => &[Bone::Distal, Bone::Proximal],
        _ => &[Bone::Distal, Bone::Middle, Bone::Proximal],
    };
    bones.get(count - 1 - place).copied()
}

/// The link to which most digits are attached.
fn palm_link(hand: &Hand) -> Option<usize> {
    let mut carried = vec![0_usize; hand.links.len()];
    for link in &hand.links {
        if let Some(parent) = link.parent
            && link.digit > 0
            && hand.links[parent.0].digit == 0
        {
            carried[parent.0] += 1;
        }
    }
    let most = *carried.iter().max()?;
    carried.iter().position(|count| *count == most)
}

/// The human digit (1 = thumb … 5 = little) of each digit of the hand.
fn human_digits(
    hand: &Hand,
    chains: &[Chain],
    across: &Vector3<f64>,
) -> Result<Vec<usize>, Unlike> {
    const NAMES: [&str; 5] = ["thumb", "index", "middle", "ring", "little"];
    // Fingers that have the names of human ones do not make up for a thumb: nearly all types need it.
    if !hand.has_thumb() {
        return Err(Unlike::NoThumb);
    }
    let named: Option<Vec<usize>> = hand.digits[1..]
        .iter()
        .map(|name| NAMES.iter().position(|known| known == name).map(|d| d + 1))
        .collect();
    if let Some(named) = named.filter(|named| named.len() >= 2) {
        return Ok(named);
    }
    let fingers = chains.len() - 1;
    if !(3..=4).contains(&fingers) {
        return Err(Unlike::Fingers(fingers));
    }
    if let Some(digit) = chains.iter().position(|chain| chain.bones.len() < 2) {
        return Err(Unlike::Phalanges(digit + 1));
    }
    let along = |chain: &Chain| across.dot(&chain.base);
    let mean = chains[1..].iter().map(along).sum::<f64>() / fingers as f64;
    let side = (along(&chains[0]) - mean).signum();
    let mut order: Vec<usize> = (1..chains.len()).collect();
    order.sort_by(|&a, &b| (side * along(&chains[b])).total_cmp(&(side * along(&chains[a]))));
    let mut digits = vec![1; chains.len()];
    for (place, finger) in order.into_iter().enumerate() {
        digits[finger] = place + 2;
    }
    Ok(digits)
}

/// The patch named by a region, see [`Hand::regions`].
fn tagged(region: &str) -> Option<Patch> {
    let mut parts = region.split('.');
    let digit = match parts.next()? {
        "palm" => {
            return Some(Patch::Palm(match parts.next()? {
                "dorsum" => PalmPart::Dorsum,
                "web" => PalmPart::Web,
                _ => PalmPart::Volar,
            }));
        }
        "thumb" => 1,
        "index" => 2,
        "middle" => 3,
        "ring" => 4,
        "little" => 5,
        _ => return None,
    };
    let bone = match parts.next()? {
        "metacarpal" => Bone::Metacarpal,
        "proximal" => Bone::Proximal,
        "middle" => Bone::Middle,
        "distal" => Bone::Distal,
        _ => return None,
    };
    Some(Patch::Digit(digit, bone, PatchSide::named(parts.next()?)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bones_point_where_all_their_hinges_turn_them() {
        let hand = Hand::human();
        let anatomy = Anatomy::of(&hand).unwrap();
        let direction = |flexion_rad: f64| {
            let mut joints = vec![0.0; hand.joints.len()];
            joints[hand.joint("index_mcp_flexion").unwrap()] = flexion_rad;
            let x = crate::space::Pose::at_origin(&joints);
            let mut posed = PosedHand::default();
            hand.pose(&x, &mut posed);
            anatomy.direction(&posed, 2, Bone::Proximal).unwrap()
        };
        let turned = direction(0.0).angle(&direction(1.0));
        assert!((turned - 1.0).abs() < 1e-9, "{turned}");
    }

    #[test]
    fn four_fingers_with_human_names_are_no_human_hand() {
        let thumbless = Hand::named("human_thumbless").unwrap();
        assert_eq!(thumbless.digits[1], "index");
        assert_eq!(Anatomy::of(&thumbless), Err(Unlike::NoThumb));
    }
}
