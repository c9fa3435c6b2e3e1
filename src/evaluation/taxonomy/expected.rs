//! What a grasp type expects of a hand before there is an object: the parts that touch, and the posture.

use nalgebra::Vector3;

use super::anatomy::{Anatomy, Bone, PalmPart, Patch};
use super::decision::fit;
use super::facts::{DIGITS, Facts, fact};
use super::rule::Rule;
use super::table::{Category, GraspType, Opposition};
use super::touch::TouchingPatch;
use crate::hand::{Hand, LinkId, PatchSide, PosedHand};

/// Trust from which a fact is expected so firmly that a start is made for it: that of "should".
const FIRM: f64 = 0.7;
/// Area of an imagined contact, mm²: more than makes a touch certain.
const IMAGINED_MM2: f64 = 60.0;

/// The parts of a hand that a type expects to touch, by what they do.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ExpectedTouch {
    /// What opposes: the palm, the thumb, or the side of a finger.
    pub first: Vec<Patch>,
    /// What presses against it.
    pub second: Vec<Patch>,
    /// What touches besides.
    pub others: Vec<Patch>,
}

impl ExpectedTouch {
    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = Patch> + '_ {
        let lists = [&self.first, &self.second, &self.others];
        lists.into_iter().flatten().copied()
    }
}

impl Rule {
    /// The parts of a hand that a type expects to touch: its virtual fingers in the table of types, with the phalanges and
    /// sides that the cues of this rule name. Parts that a hand does not have are to be left out.
    pub fn expected_touch(&self, entry: &GraspType) -> ExpectedTouch {
        let trust = |name: &str, present: bool| {
            let cues = self.cues(entry).iter();
            let of = cues.filter(|cue| Some(cue.fact) == fact(name) && cue.present == present);
            of.map(|cue| cue.trust).fold(0.0, f64::max)
        };
        let firmly = |name: &str| trust(name, true) > FIRM;
        let takes = |digit: usize| firmly(DIGITS[digit - 1]) || entry.uses(digit);
        let pads = |digit: usize, bones: &[Bone]| -> Vec<Patch> {
            let pad = |bone: &Bone| Patch::Digit(digit, *bone, PatchSide::Pad);
            bones.iter().map(pad).collect()
        };
        let side = |digit: usize, side: PatchSide| {
            [Bone::Distal, Bone::Middle].map(|bone| Patch::Digit(digit, bone, side))
        };
        // The phalanges with which fingers touch that are no sides.
        let deep = match (entry.category, entry.opposition) {
            (Category::Precision, _) | (_, Opposition::Side) => firmly("inside"),
            _ => trust("inside", false) == 0.0,
        };
        let along = firmly("straight") || trust("index middle phalanx", true) > 0.0;
        let bones: &[Bone] = match (deep, along) {
            (true, _) => &[Bone::Proximal, Bone::Middle, Bone::Distal],
            (false, true) => &[Bone::Middle, Bone::Distal],
            (false, false) => &[Bone::Distal],
        };
        let sides: Vec<Patch> = [
            ("index side", 2, PatchSide::Radial),
            ("middle side", 3, PatchSide::Radial),
            ("ring side", 4, PatchSide::Radial),
            ("between", 2, PatchSide::Ulnar),
        ]
        .into_iter()
        .filter(|(name, ..)| firmly(name))
        .flat_map(|(_, digit, of)| side(digit, of))
        .collect();
        let by_side = |digit: usize| {
            (sides.iter()).any(|patch| matches!(patch, Patch::Digit(d, ..) if *d == digit))
        };
        let fingers = |digits: &mut dyn Iterator<Item = usize>| -> Vec<Patch> {
            digits
                .filter(|digit| takes(*digit) && !by_side(*digit))
                .flat_map(|digit| match (digit, firmly("index tip")) {
                    (2, true) => vec![Patch::Digit(2, Bone::Distal, PatchSide::Tip)],
                    _ => pads(digit, bones),
                })
                .collect()
        };
        let thumb = match entry.category {
            _ if !takes(1) && trust("thumb", true) == 0.0 => Vec::new(),
            Category::Power => pads(1, &[Bone::Proximal, Bone::Distal]),
            _ if firmly("index tip") => vec![Patch::Digit(1, Bone::Distal, PatchSide::Tip)],
            _ => pads(1, &[Bone::Distal]),
        };
        let mut palm = Vec::new();
        if firmly("palm") || (entry.vf1.contains(&0) && trust("palm", false) == 0.0) {
            palm.push(Patch::Palm(PalmPart::Volar));
        }
        if firmly("web") {
            palm.push(Patch::Palm(PalmPart::Web));
        }
        let mut touch = ExpectedTouch::default();
        match entry.opposition {
            // Fingers that close about a handle without the palm press against their own first phalanges.
            Opposition::Palm if palm.is_empty() => {
                let all = fingers(&mut (2..=5));
                let is_first = |patch: &Patch| matches!(patch, Patch::Digit(_, Bone::Proximal, _));
                (touch.first, touch.second) = all.into_iter().partition(is_first);
                touch.others = thumb;
            }
            Opposition::Palm => {
                touch.first = palm;
                touch.second = fingers(&mut (2..=5));
                touch.others = thumb.into_iter().chain(sides).collect();
            }
            Opposition::Side if thumb.is_empty() => {
                touch.first = side(3, PatchSide::Radial).to_vec();
                touch.second = sides;
            }
            Opposition::Side => {
                touch.first = thumb;
                touch.second = if sides.is_empty() {
                    fingers(&mut entry.vf2.iter().copied())
                } else {
                    sides.clone()
                };
                let known = touch.second.clone();
                let others = fingers(&mut (2..=5)).into_iter().chain(palm);
                touch.others = others.filter(|patch| !known.contains(patch)).collect();
            }
            Opposition::Pad => {
                touch.first = thumb;
                touch.second = fingers(&mut (2..=5));
                touch.others = palm.into_iter().chain(sides).collect();
            }
        }
        touch
    }

    /// How well a posture suits a type if the hand touched with these patches, 0 to 1: the fit of the type, without what
    /// depends on an object.
    pub fn imagined_fit(
        &self,
        entry: &GraspType,
        anatomy: &Anatomy,
        posed: &PosedHand,
        touch: &[ImaginedTouch],
    ) -> f64 {
        let touches: Vec<TouchingPatch> = touch.iter().map(|touch| touch.at(posed)).collect();
        let facts = Facts::of(anatomy, posed, &touches, None);
        fit(self, entry, &facts, None)
    }
}

/// A patch of a hand that is imagined to touch: its middle on one link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImaginedTouch {
    /// The part of the hand.
    pub patch: Patch,
    /// The link it is on.
    pub link: LinkId,
    /// Its middle, link frame, metres.
    pub point: Vector3<f64>,
    /// Its mean outward unit normal, link frame.
    pub normal: Vector3<f64>,
}

impl ImaginedTouch {
    /// The middles of a patch on each link that has points of it; none if the hand does not have it.
    pub fn of(hand: &Hand, anatomy: &Anatomy, patch: Patch) -> Vec<Self> {
        let points = (0..hand.surface.len()).filter(|&i| anatomy.patch(i) == patch);
        Self::of_points(hand, points, |_| patch)
    }

    /// The middles of surface points on each of their links. `patch` names the part of the first point of each link.
    pub fn of_points(
        hand: &Hand,
        points: impl Iterator<Item = usize>,
        patch: impl Fn(usize) -> Patch,
    ) -> Vec<Self> {
        let points: Vec<usize> = points.collect();
        let mut links: Vec<LinkId> = points.iter().map(|&i| hand.surface[i].link).collect();
        links.sort_unstable();
        links.dedup();
        let middle = |link: LinkId| {
            let own = || {
                points
                    .iter()
                    .filter(move |&&i| hand.surface[i].link == link)
            };
            let sum =
                |of: &dyn Fn(usize) -> Vector3<f64>| own().map(|&i| of(i)).sum::<Vector3<f64>>();
            let normal = sum(&|i| hand.surface[i].normal).try_normalize(1e-6)?;
            Some(Self {
                patch: patch(*own().next()?),
                link,
                point: sum(&|i| hand.surface[i].point) / own().count() as f64,
                normal,
            })
        };
        links.into_iter().filter_map(middle).collect()
    }

    fn at(&self, posed: &PosedHand) -> TouchingPatch {
        let frame = &posed.object_from_link[self.link.0];
        let normal = frame.direction(&self.normal);
        TouchingPatch {
            patch: self.patch,
            link: self.link,
            point: frame.point(&self.point),
            normal,
            object_normal: -normal,
            weight_mm2: IMAGINED_MM2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::taxonomy::Taxonomy;

    fn touch(number: u8) -> ExpectedTouch {
        let entry = Taxonomy::feix().numbered(number).unwrap();
        Rule::standard().expected_touch(entry)
    }

    #[test]
    fn virtual_fingers_become_parts_of_the_hand() {
        let pad = |digit, bone| Patch::Digit(digit, bone, PatchSide::Pad);
        let pinch = touch(9);
        assert_eq!(pinch.first, [pad(1, Bone::Distal)]);
        assert_eq!(pinch.second, [pad(2, Bone::Distal)]);
        assert!(pinch.others.is_empty());
        let lateral = touch(16);
        assert_eq!(
            lateral.second[0],
            Patch::Digit(2, Bone::Distal, PatchSide::Radial)
        );
        let wrap = touch(3);
        assert_eq!(wrap.first, [Patch::Palm(PalmPart::Volar)]);
        assert!(wrap.second.contains(&pad(5, Bone::Proximal)) && !wrap.others.is_empty());
        let adduction = touch(23);
        assert_eq!(
            adduction.first[0],
            Patch::Digit(3, Bone::Distal, PatchSide::Radial)
        );
        assert!(
            adduction
                .all()
                .all(|patch| !matches!(patch, Patch::Digit(1, ..)))
        );
    }

    #[test]
    fn every_type_has_two_sides() {
        for entry in &Taxonomy::feix().types {
            let touch = Rule::standard().expected_touch(entry);
            assert!(
                !touch.first.is_empty() && !touch.second.is_empty(),
                "{}",
                entry.name
            );
        }
    }
}
