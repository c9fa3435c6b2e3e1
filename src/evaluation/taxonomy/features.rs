//! Features of a grasp that determine its type: numbers from 0 to 1, named in the signatures.

use nalgebra::Vector3;

use super::anatomy::{Anatomy, Bone, PalmPart, Patch};
use super::table::Opposition;
use super::touch::{Held, TouchingPatch, ramp};
use crate::hand::{PatchSide, PosedHand};

/// Contact area that makes a touch certain, mm². It is less than the area of one surface point of a human hand (about 65
/// mm²); the palm is larger and needs more.
const TOUCH_MM2: f64 = 25.0;
const PALM_TOUCH_MM2: f64 = 60.0;
/// A digit touches from this degree on.
pub(super) const TOUCHES: f64 = 0.5;
/// Flexion, radians: of all three joints of a curled finger, and of the last two joints of a bent finger.
const CURLED_RAD: f64 = 4.4;
const BENT_RAD: f64 = 2.8;
/// Names of the features for the touch of each digit, thumb first.
pub(super) const DIGITS: [&str; 5] = ["thumb", "index", "middle", "ring", "little"];

/// All features. A feature that cannot be measured (for example the side of a thumb that does not touch) is missing.
pub(super) const FEATURES: [(&str, &str); 42] = [
    ("thumb", "the thumb touches"),
    ("index", "the index finger touches"),
    ("middle", "the middle finger touches"),
    ("ring", "the ring finger touches"),
    ("little", "the little finger touches"),
    ("palm", "the palm touches"),
    ("web", "the edge between thumb and index finger touches"),
    ("palm opposition", "fingers press toward the palm"),
    ("pad opposition", "pads of fingers press against the thumb"),
    (
        "side opposition",
        "sides of fingers press against the thumb or each other",
    ),
    ("deep", "fingers touch with proximal and middle phalanges"),
    ("proximal", "fingers touch with proximal phalanges"),
    (
        "fingertips",
        "share of the fingers' contact on last phalanges",
    ),
    ("sides", "share of the fingers' contact on their sides"),
    ("backs", "share of the fingers' contact on their backs"),
    (
        "index tip",
        "share of the index finger's contact on its tip",
    ),
    (
        "index middle phalanx",
        "the middle phalanx of the index finger touches",
    ),
    (
        "index radial",
        "share of the index finger's contact on the thumb's side",
    ),
    (
        "middle radial",
        "share of the middle finger's contact on the thumb's side",
    ),
    (
        "ring radial",
        "share of the ring finger's contact on the thumb's side",
    ),
    ("between", "index and middle finger hold it between them"),
    (
        "thumb pad",
        "share of the thumb's contact on its pad and tip",
    ),
    ("thumb tip", "share of the thumb's contact on its tip"),
    ("thumb back", "share of the thumb's contact on its back"),
    ("thumb encircled", "it touches the thumb all around"),
    ("thumb abducted", "the thumb stands out from the palm"),
    ("thumb bent", "the thumb's last joint is bent"),
    (
        "thumb along",
        "the thumb lies along the axis of what is held",
    ),
    ("curl", "middle, ring and little finger are curled"),
    (
        "index straighter",
        "the index finger is straighter than the others",
    ),
    (
        "index bent",
        "the last two joints of the index finger are bent",
    ),
    (
        "index along",
        "the index finger lies along the axis of what is held",
    ),
    ("knuckles", "fingers that touch are flexed at the knuckles"),
    ("bend", "fingers that touch are bent at the last two joints"),
    ("splay", "fingers are spread"),
    ("parallel", "the fingers press in one direction"),
    (
        "axis across",
        "the axis of what is held lies across the palm",
    ),
    ("axis facing", "the axis of what is held stands on the palm"),
    ("form", "what is held has the type's form"),
    ("size", "what is held has the type's size"),
    (
        "ring of thumb and index",
        "thumb and index finger reach around it",
    ),
    ("digits", "share of all digits that touch"),
];

/// The features of one grasp, in the order of [`FEATURES`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Features {
    values: [Option<f64>; FEATURES.len()],
}

/// Number of the feature with this name.
pub(super) fn feature(name: &str) -> Option<usize> {
    FEATURES.iter().position(|(known, _)| *known == name)
}

impl Features {
    pub(super) fn value(&self, feature: usize) -> Option<f64> {
        self.values[feature]
    }

    /// The features that could be measured, with their names.
    pub(super) fn measured(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let names = FEATURES.iter().map(|(name, _)| *name);
        names
            .zip(self.values)
            .filter_map(|(name, value)| Some((name, value?)))
    }

    pub(super) fn named(&self, name: &str) -> f64 {
        feature(name).and_then(|f| self.values[f]).unwrap_or(0.0)
    }

    fn set(&mut self, name: &str, value: impl Into<Option<f64>>) {
        let place = feature(name).expect("only known features are measured");
        self.values[place] = value.into().map(|value| value.clamp(0.0, 1.0) + 0.0);
    }

    /// The degrees of palm, pad and side opposition.
    pub(super) fn oppositions(&self) -> [(Opposition, f64); 3] {
        [Opposition::Palm, Opposition::Pad, Opposition::Side]
            .map(|kind| (kind, self.named(&format!("{} opposition", kind.name()))))
    }

    /// Measures a grasp.
    pub(super) fn of(
        anatomy: &Anatomy,
        posed: &PosedHand,
        touches: &[TouchingPatch],
        held: Option<&Held>,
    ) -> Self {
        let mut features = Self {
            values: [None; FEATURES.len()],
        };
        features.contact(anatomy, touches);
        features.oppose(anatomy, posed, touches);
        features.pose(anatomy, posed);
        if let Some(held) = held {
            features.object(anatomy, posed, held);
        }
        features
    }

    fn contact(&mut self, anatomy: &Anatomy, touches: &[TouchingPatch]) {
        let weight = |test: &dyn Fn(Patch) -> bool| weight(touches, test);
        let enough = |mm2: f64| (mm2 / TOUCH_MM2).min(1.0);
        let of_digit =
            |digit: usize| weight(&move |patch| matches!(patch, Patch::Digit(d, ..) if d == digit));
        let on_bone = |digit: usize, bone: Bone| {
            weight(&move |patch| matches!(patch, Patch::Digit(d, b, _) if (d, b) == (digit, bone)))
        };
        let on_side = |digit: usize, side: PatchSide| {
            weight(&move |patch| matches!(patch, Patch::Digit(d, _, s) if (d, s) == (digit, side)))
        };
        let share = |part: f64, whole: f64| (whole > 0.0).then(|| part / whole);

        let touch: Vec<f64> = (1..=5).map(|digit| enough(of_digit(digit))).collect();
        for (name, touch) in DIGITS.iter().zip(&touch) {
            self.set(name, *touch);
        }
        let present = (1..=5).filter(|digit| anatomy.has(*digit)).count();
        self.set("digits", touch.iter().sum::<f64>() / present.max(1) as f64);
        let volar = weight(&|patch| patch == Patch::Palm(PalmPart::Volar));
        self.set("palm", volar / PALM_TOUCH_MM2);
        self.set("web", enough(weight(&|p| p == Patch::Palm(PalmPart::Web))));

        let fingers: f64 = touch[1..].iter().sum();
        let mean = |of: &dyn Fn(usize) -> f64| {
            let sum: f64 = (2..=5).map(|digit| touch[digit - 1] * of(digit)).sum();
            share(sum, fingers)
        };
        let proximal = |digit| enough(on_bone(digit, Bone::Proximal));
        let middle = |digit| enough(on_bone(digit, Bone::Middle));
        self.set(
            "deep",
            mean(&|digit| {
                if anatomy.has_bone(digit, Bone::Middle) {
                    0.5 * (proximal(digit) + middle(digit))
                } else {
                    proximal(digit)
                }
            }),
        );
        self.set("proximal", mean(&proximal));
        let of_fingers: f64 = (2..=5).map(of_digit).sum();
        let ends: f64 = (2..=5).map(|digit| on_bone(digit, Bone::Distal)).sum();
        self.set("fingertips", share(ends, of_fingers));
        let sides: f64 = (2..=5)
            .map(|digit| on_side(digit, PatchSide::Radial) + on_side(digit, PatchSide::Ulnar))
            .sum();
        self.set("sides", share(sides, of_fingers));
        let backs: f64 = (2..=5).map(|digit| on_side(digit, PatchSide::Back)).sum();
        self.set("backs", share(backs, of_fingers));
        self.set("index tip", share(on_side(2, PatchSide::Tip), of_digit(2)));
        let has_middle = anatomy.has_bone(2, Bone::Middle);
        self.set("index middle phalanx", has_middle.then(|| middle(2)));
        for digit in 2..=4 {
            let radial = share(on_side(digit, PatchSide::Radial), of_digit(digit));
            self.set(&format!("{} radial", DIGITS[digit - 1]), radial);
        }
        let between =
            enough(on_side(2, PatchSide::Ulnar)).min(enough(on_side(3, PatchSide::Radial)));
        self.set("between", between);

        let thumb = of_digit(1);
        let tip = on_side(1, PatchSide::Tip);
        self.set("thumb pad", share(on_side(1, PatchSide::Pad) + tip, thumb));
        self.set("thumb tip", share(tip, thumb));
        self.set("thumb back", share(on_side(1, PatchSide::Back), thumb));
    }

    /// Measures which parts press against each other.
    fn oppose(&mut self, anatomy: &Anatomy, posed: &PosedHand, touches: &[TouchingPatch]) {
        let sum = |test: &dyn Fn(Patch) -> bool| -> Vector3<f64> {
            touches
                .iter()
                .filter(|touch| test(touch.patch))
                .map(|touch| touch.normal * touch.weight_mm2)
                .sum()
        };
        let is_finger = |patch: Patch| matches!(patch, Patch::Digit(2.., ..));
        let is_side = |patch: Patch| {
            matches!(
                patch,
                Patch::Digit(_, _, PatchSide::Radial | PatchSide::Ulnar)
            )
        };
        let whole = weight(touches, &is_finger);
        let against = |direction: Vector3<f64>, test: &dyn Fn(Patch) -> bool| -> f64 {
            let direction = direction.try_normalize(1e-9).unwrap_or_default();
            let part =
                |touch: &TouchingPatch| touch.weight_mm2 * (-touch.normal.dot(&direction)).max(0.0);
            let parts = touches
                .iter()
                .filter(|t| is_finger(t.patch) && test(t.patch));
            if whole > 0.0 {
                parts.map(part).sum::<f64>() / whole
            } else {
                0.0
            }
        };

        let fingers = sum(&is_finger);
        let volar = anatomy.palm_axes(posed).volar;
        let to_palm = against(volar, &|_| true);
        let seat = self.named("palm").max(0.7 * self.named("proximal"));
        let pressed = seat * ramp(to_palm, 0.08, 0.35);
        let palm = pressed.max(self.enclosed(anatomy, posed, fingers.norm() / whole.max(1e-9)));

        let thumb = sum(&|patch| matches!(patch, Patch::Digit(1, ..)));
        let [side, pad] = [
            against(thumb, &is_side),
            against(thumb, &|patch| !is_side(patch)),
        ];
        let opposed = self.named("thumb") * ramp(side + pad, 0.1, 0.45);
        let side_share = if side + pad > 0.0 {
            side / (side + pad)
        } else {
            0.0
        };
        let without_thumb = self.named("between") * (1.0 - self.named("thumb"));
        // Thumb against fingers is part of a wrap and does not count as an opposition of its own.
        let free = 1.0 - 0.8 * palm;
        let side_share = ramp(side_share, 0.35, 0.75);
        self.set("palm opposition", palm);
        self.set("pad opposition", opposed * (1.0 - side_share) * free);
        self.set("side opposition", (opposed * side_share).max(without_thumb));

        let encircled = (self.named("thumb") > 0.0).then(|| {
            let all = weight(touches, &|patch| matches!(patch, Patch::Digit(1, ..)));
            ramp(1.0 - thumb.norm() / all.max(1e-9), 0.35, 0.7)
        });
        self.set("thumb encircled", encircled);
        let parallel = (whole > 0.0).then(|| ramp(fingers.norm() / whole, 0.7, 0.97));
        self.set("parallel", parallel);
    }

    /// Degree to which bent fingers, including the ulnar ones, enclose the object: against the palm, or so far around that
    /// their forces nearly cancel (`rest`, a share), as with a handle that hangs in them. On a thick object the tips hardly
    /// press back toward the palm.
    fn enclosed(&self, anatomy: &Anatomy, posed: &PosedHand, rest: f64) -> f64 {
        let bends: Vec<f64> = self
            .touching()
            .filter_map(|digit| flexion(anatomy, posed, digit))
            .map(|[_, beyond]| beyond / BENT_RAD)
            .collect();
        let bend = bends.iter().sum::<f64>() / bends.len().max(1) as f64;
        let deep = self.named("deep");
        let on_palm = self.named("palm") * ramp(deep, 0.5, 0.9);
        let around = (1.0 - ramp(rest, 0.45, 0.85)) * ramp(deep, 0.45, 0.75);
        let ulnar = self.named("ring").min(self.named("little"));
        ramp(bend, 0.1, 0.3) * ulnar * on_palm.max(around)
    }

    /// The fingers that touch.
    fn touching(&self) -> impl Iterator<Item = usize> {
        (2..=5).filter(|digit| self.named(DIGITS[digit - 1]) >= TOUCHES)
    }

    fn pose(&mut self, anatomy: &Anatomy, posed: &PosedHand) {
        let axes = anatomy.palm_axes(posed);
        let direction = |digit, bone| anatomy.direction(posed, digit, bone);
        let flexion = |digit: usize| flexion(anatomy, posed, digit);
        let curl = |digit| flexion(digit).map(|[knuckle, beyond]| (knuckle + beyond) / CURLED_RAD);
        let mean = |values: &[f64]| {
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };

        let others: Vec<f64> = (3..=5).filter_map(curl).collect();
        let others = mean(&others);
        self.set("curl", others);
        self.set(
            "index straighter",
            curl(2)
                .zip(others)
                .map(|(index, others)| ramp(others - index, 0.1, 0.3)),
        );
        self.set(
            "index bent",
            flexion(2).map(|[_, beyond]| ramp(beyond, 0.3, 1.8)),
        );
        let touching: Vec<[f64; 2]> = self.touching().filter_map(flexion).collect();
        let [knuckles, beyond]: [Vec<f64>; 2] =
            [0, 1].map(|part| touching.iter().map(|flexion| flexion[part]).collect());
        self.set(
            "knuckles",
            mean(&knuckles).map(|angle| angle / std::f64::consts::FRAC_PI_2),
        );
        self.set("bend", mean(&beyond).map(|angle| angle / BENT_RAD));

        let last = (3..=5).rev().find(|digit| anatomy.has(*digit));
        let spread = last.and_then(|last| {
            let in_palm = |v: Vector3<f64>| v - axes.volar * axes.volar.dot(&v);
            let (index, last) = (
                direction(2, Bone::Proximal)?,
                direction(last, Bone::Proximal)?,
            );
            Some(in_palm(index).angle(&in_palm(last)))
        });
        self.set("splay", spread.map(|angle| ramp(angle, 0.2, 0.7)));

        let elevation = direction(1, Bone::Metacarpal).map(|bone| bone.dot(&axes.volar).asin());
        self.set(
            "thumb abducted",
            elevation.map(|angle| ramp(angle.to_degrees(), 20.0, 45.0)),
        );
        let bent = direction(1, Bone::Proximal)
            .zip(direction(1, Bone::Distal))
            .map(|(proximal, distal)| ramp(proximal.angle(&distal), 0.15, 0.8));
        self.set("thumb bent", bent);
        let [thumb, index] = [direction(1, Bone::Distal), direction(2, Bone::Distal)];
        self.set(
            "ring of thumb and index",
            thumb
                .zip(index)
                .map(|(thumb, index)| ramp(-thumb.dot(&index), -0.3, 0.5)),
        );
    }

    fn object(&mut self, anatomy: &Anatomy, posed: &PosedHand, held: &Held) {
        let axes = anatomy.palm_axes(posed);
        let along = |direction: Vector3<f64>| held.axis.dot(&direction).abs();
        self.set("axis across", ramp(along(axes.radial), 0.4, 0.9));
        self.set("axis facing", ramp(along(axes.volar), 0.4, 0.9));
        let bone = |digit, bone| anatomy.direction(posed, digit, bone);
        let thumb = bone(1, Bone::Distal).map(|thumb| ramp(along(thumb), 0.5, 0.9));
        self.set("thumb along", thumb);
        let index = bone(2, Bone::Distal).map(|distal| {
            let whole = distal + bone(2, Bone::Middle).unwrap_or_default();
            ramp(
                along(whole.try_normalize(1e-9).unwrap_or(distal)),
                0.6,
                0.95,
            )
        });
        self.set("index along", index);
    }
}

/// Flexion of a finger at the knuckle, and at the joints beyond, radians.
fn flexion(anatomy: &Anatomy, posed: &PosedHand, digit: usize) -> Option<[f64; 2]> {
    let axes = anatomy.palm_axes(posed);
    let [proximal, middle, distal] = [Bone::Proximal, Bone::Middle, Bone::Distal]
        .map(|bone| anatomy.direction(posed, digit, bone));
    let (proximal, distal) = (proximal?, distal?);
    let knuckle = f64::atan2(proximal.dot(&axes.volar), proximal.dot(&axes.distal));
    let beyond = match middle {
        Some(middle) => proximal.angle(&middle) + middle.angle(&distal),
        None => proximal.angle(&distal),
    };
    Some([knuckle, beyond])
}

fn weight(touches: &[TouchingPatch], test: &dyn Fn(Patch) -> bool) -> f64 {
    touches
        .iter()
        .filter(|touch| test(touch.patch))
        .map(|touch| touch.weight_mm2)
        .sum()
}
