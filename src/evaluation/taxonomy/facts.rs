//! Facts about a grasp that determine its type: numbers from 0 (absent) to 1 (present), named in the rule.

use nalgebra::Vector3;

use super::anatomy::{Anatomy, Bone, PalmPart, Patch};
use super::form::Held;
use super::pose_correction::force_left_over;
use super::table::Opposition;
use super::touch::{TouchingPatch, ramp};
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
/// Part of the opposition that is seen where thumb and fingers touch with their pads but hardly face each other, and where
/// an object lies in the palm and on the first phalanges but the fingers hardly press back.
const HALF_SEEN: f64 = 0.5;
/// Part of a palm opposition that a disk gives which lies on the palm and is held by its rim.
const DISK_ON_PALM: f64 = 0.6;
/// Friction for the balance of forces, and the residuals from which forces begin to fail to balance and cannot balance.
const FRICTION: f64 = 0.6;
const RESIDUALS: [f64; 2] = [0.55, 0.9];
/// A patch takes part in the balance if its contact is at least so large, mm², and its normals are so much alike.
const BALANCED_MM2: f64 = 3.0;
const ALIKE: f64 = 0.3;
/// Names of the facts for the touch of each digit, thumb first.
pub(in crate::evaluation) const DIGITS: [&str; 5] = ["thumb", "index", "middle", "ring", "little"];

/// All facts. A fact that cannot be measured (for example the side of a thumb that does not touch) is missing.
pub(super) const FACTS: [(&str, &str); 36] = [
    ("thumb", "the thumb touches"),
    ("index", "the index finger touches"),
    ("middle", "the middle finger touches"),
    ("ring", "the ring finger touches"),
    ("little", "the little finger touches"),
    (
        "gap between fingers",
        "a finger between two that touch does not touch",
    ),
    ("palm", "the palm touches"),
    ("web", "the edge between thumb and index finger touches"),
    ("palm opposition", "fingers press toward the palm"),
    ("pad opposition", "pads of fingers press against the thumb"),
    (
        "side opposition",
        "sides of fingers press against the thumb or each other",
    ),
    ("disk on palm", "fingers hold a disk that lies on the palm"),
    ("inside", "fingers touch with proximal and middle phalanges"),
    ("proximal", "fingers touch with proximal phalanges"),
    (
        "inner phalanges",
        "fingers touch with more than their last phalanges",
    ),
    (
        "fingertips",
        "fingers touch mostly with their last phalanges",
    ),
    ("backs", "fingers touch with their backs"),
    ("index tip", "the index finger touches with its tip"),
    (
        "index middle phalanx",
        "the middle phalanx of the index finger touches",
    ),
    ("index side", "the thumb side of the index finger touches"),
    ("middle side", "the thumb side of the middle finger touches"),
    ("ring side", "the thumb side of the ring finger touches"),
    ("between", "index and middle finger hold it between them"),
    ("thumb encircled", "it touches the thumb all around"),
    ("thumb abducted", "the thumb stands out from the palm"),
    (
        "thumb along",
        "the thumb lies along the axis of what is held",
    ),
    ("curl", "middle, ring and little finger are curled"),
    (
        "straight",
        "fingers that touch are straight beyond the knuckles",
    ),
    (
        "index straight",
        "the index finger is straight beyond the knuckle",
    ),
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
    ("axis facing", "the axis of what is held stands on the palm"),
    (
        "form",
        "what is held has a form that the type usually holds",
    ),
    (
        "size",
        "what is held has a size that the type usually holds",
    ),
];

/// The facts of one grasp, in the order of [`FACTS`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Facts {
    values: [Option<f64>; FACTS.len()],
}

/// Number of the fact with this name.
pub(super) fn fact(name: &str) -> Option<usize> {
    FACTS.iter().position(|(known, _)| *known == name)
}

/// Contact areas of a grasp by part of the hand, mm².
struct Areas<'a>(&'a [TouchingPatch]);

impl Areas<'_> {
    fn of(&self, test: impl Fn(Patch) -> bool) -> f64 {
        let own = self.0.iter().filter(|touch| test(touch.patch));
        own.map(|touch| touch.weight_mm2).sum()
    }

    fn digit(&self, digit: usize) -> f64 {
        self.of(|patch| matches!(patch, Patch::Digit(d, ..) if d == digit))
    }

    fn bone(&self, digit: usize, bone: Bone) -> f64 {
        self.of(|patch| matches!(patch, Patch::Digit(d, b, _) if (d, b) == (digit, bone)))
    }

    fn side(&self, digit: usize, side: PatchSide) -> f64 {
        self.of(|patch| matches!(patch, Patch::Digit(d, _, s) if (d, s) == (digit, side)))
    }
}

fn enough(mm2: f64) -> f64 {
    (mm2 / TOUCH_MM2).min(1.0)
}

fn share(part: f64, whole: f64) -> Option<f64> {
    (whole > 0.0).then(|| part / whole)
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

impl Facts {
    pub(super) fn value(&self, fact: usize) -> Option<f64> {
        self.values[fact]
    }

    /// The facts that could be measured, with their names.
    pub(super) fn measured(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let names = FACTS.iter().map(|(name, _)| *name);
        names
            .zip(self.values)
            .filter_map(|(name, value)| Some((name, value?)))
    }

    /// The value of a fact; 0 if it could not be measured.
    pub(super) fn named(&self, name: &str) -> f64 {
        fact(name).and_then(|f| self.values[f]).unwrap_or(0.0)
    }

    fn set(&mut self, name: &str, value: impl Into<Option<f64>>) {
        let place = fact(name).expect("only known facts are measured");
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
        let mut facts = Self {
            values: [None; FACTS.len()],
        };
        let areas = Areas(touches);
        facts.touch(&areas);
        facts.phalanges(anatomy, &areas);
        facts.sides(&areas);
        facts.oppose(anatomy, posed, touches);
        facts.pose(anatomy, posed);
        if let Some(held) = held {
            facts.object(anatomy, posed, held);
        }
        facts
    }

    fn touch(&mut self, areas: &Areas<'_>) {
        let touch: Vec<f64> = (1..=5).map(|digit| enough(areas.digit(digit))).collect();
        for (name, touch) in DIGITS.iter().zip(&touch) {
            self.set(name, *touch);
        }
        let most = |of: &[f64]| of.iter().copied().fold(0.0, f64::max);
        let gap = [2, 3].map(|k| most(&touch[1..k]).min(most(&touch[k + 1..])) - touch[k]);
        self.set("gap between fingers", most(&gap));
        let volar = areas.of(|patch| patch == Patch::Palm(PalmPart::Volar));
        self.set("palm", volar / PALM_TOUCH_MM2);
        let web = areas.of(|patch| patch == Patch::Palm(PalmPart::Web));
        self.set("web", enough(web));
    }

    fn phalanges(&mut self, anatomy: &Anatomy, areas: &Areas<'_>) {
        let touch: Vec<f64> = DIGITS.iter().map(|digit| self.named(digit)).collect();
        let fingers: f64 = touch[1..].iter().sum();
        let mean = |of: &dyn Fn(usize) -> f64| {
            let sum: f64 = (2..=5).map(|digit| touch[digit - 1] * of(digit)).sum();
            share(sum, fingers)
        };
        let proximal = |digit| enough(areas.bone(digit, Bone::Proximal));
        let middle = |digit| enough(areas.bone(digit, Bone::Middle));
        let inside = |digit| {
            if anatomy.has_bone(digit, Bone::Middle) {
                0.5 * (proximal(digit) + middle(digit))
            } else {
                proximal(digit)
            }
        };
        self.set("inside", mean(&inside));
        let first = mean(&proximal);
        self.set("proximal", first);
        let ends: f64 = (2..=5).map(|digit| areas.bone(digit, Bone::Distal)).sum();
        let whole: f64 = (2..=5).map(|digit| areas.digit(digit)).sum();
        let tips = share(ends, whole).map(|share| ramp(share, 0.3, 0.65));
        self.set("fingertips", tips);
        self.set(
            "inner phalanges",
            first.zip(tips).map(|(first, tips)| first.max(1.0 - tips)),
        );
        let has_middle = anatomy.has_bone(2, Bone::Middle);
        self.set("index middle phalanx", has_middle.then(|| middle(2)));
    }

    fn sides(&mut self, areas: &Areas<'_>) {
        let whole: f64 = (2..=5).map(|digit| areas.digit(digit)).sum();
        let backs: f64 = (2..=5)
            .map(|digit| areas.side(digit, PatchSide::Back))
            .sum();
        self.set("backs", share(backs, whole));
        self.set(
            "index tip",
            share(areas.side(2, PatchSide::Tip), areas.digit(2)),
        );
        let side = |digit: usize| {
            let radial = share(areas.side(digit, PatchSide::Radial), areas.digit(digit));
            let enough = if digit == 4 { [0.15, 0.4] } else { [0.2, 0.5] };
            ramp(radial.unwrap_or(0.0), enough[0], enough[1]) * self.named(DIGITS[digit - 1])
        };
        let (index, middle, ring) = (side(2), side(3), side(4));
        self.set("index side", index * self.named("thumb"));
        self.set("middle side", middle);
        self.set("ring side", ring);
        let between =
            enough(areas.side(2, PatchSide::Ulnar)).min(enough(areas.side(3, PatchSide::Radial)));
        self.set("between", between);
    }

    /// Measures which parts press against each other.
    fn oppose(&mut self, anatomy: &Anatomy, posed: &PosedHand, touches: &[TouchingPatch]) {
        let sum = |test: &dyn Fn(Patch) -> bool| -> Vector3<f64> {
            let own = touches.iter().filter(|touch| test(touch.patch));
            own.map(|touch| touch.normal * touch.weight_mm2).sum()
        };
        let areas = Areas(touches);
        let whole = areas.of(is_finger);
        let against = |direction: Vector3<f64>, test: &dyn Fn(Patch) -> bool| -> f64 {
            let direction = direction.try_normalize(1e-9).unwrap_or_default();
            let part =
                |touch: &TouchingPatch| touch.weight_mm2 * (-touch.normal.dot(&direction)).max(0.0);
            let parts = (touches.iter()).filter(|t| is_finger(t.patch) && test(t.patch));
            share(parts.map(part).sum::<f64>(), whole).unwrap_or(0.0)
        };
        let fingers = sum(&is_finger);
        let volar = anatomy.palm_axes(posed).volar;
        let seat = self.named("palm").max(0.7 * self.named("proximal"));
        let pressed = seat * ramp(against(volar, &|_| true), 0.08, 0.35);
        let rest = fingers.norm() / whole.max(1e-9);
        let pressed = pressed.max(self.enclosed(anatomy, posed, rest));

        let thumb = sum(&|patch| matches!(patch, Patch::Digit(1, ..)));
        let [side, pad] = [
            against(thumb, &is_side),
            against(thumb, &|patch| !is_side(patch)),
        ];
        let opposed = self.named("thumb") * ramp(side + pad, 0.1, 0.45);
        let side_share = ramp(share(side, side + pad).unwrap_or(0.0), 0.35, 0.75);
        let without_thumb = self.named("between") * (1.0 - self.named("thumb"));
        let beside = (opposed * side_share).max(without_thumb);
        // Thumb against fingers is part of a wrap and does not count as an opposition of its own.
        let facing = opposed * (1.0 - side_share) * (1.0 - 0.8 * pressed);
        let sides = areas.of(|patch| is_finger(patch) && is_side(patch));
        let half = HALF_SEEN
            * self.named("thumb")
            * self.named("index").max(self.named("middle"))
            * (1.0 - share(sides, whole).unwrap_or(0.0))
            * (1.0 - pressed)
            * (1.0 - beside)
            * (1.0 - ramp(left_over(touches), RESIDUALS[0], RESIDUALS[1]));
        self.set("palm opposition", pressed.max(self.in_palm()));
        self.set("pad opposition", facing.max(half));
        self.set("side opposition", beside);

        let encircled = (self.named("thumb") > 0.0).then(|| {
            let all = areas.digit(1);
            ramp(1.0 - thumb.norm() / all.max(1e-9), 0.35, 0.7)
        });
        self.set("thumb encircled", encircled);
    }

    /// Degree to which an object lies in the palm and on the first phalanges of three fingers or more. Fingers around a wide
    /// object are too straight to press back toward the palm.
    fn in_palm(&self) -> f64 {
        let mut fingers: Vec<f64> = DIGITS[1..].iter().map(|digit| self.named(digit)).collect();
        fingers.sort_by(f64::total_cmp);
        HALF_SEEN * self.named("palm") * self.named("proximal") * self.named("index") * fingers[1]
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
        let deep = self.named("inside");
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
        let flexion = |digit: usize| flexion(anatomy, posed, digit);
        let curl = |digit| flexion(digit).map(|[knuckle, beyond]| (knuckle + beyond) / CURLED_RAD);
        let others: Vec<f64> = (3..=5).filter_map(curl).collect();
        let others = mean(&others);
        self.set("curl", others);
        self.set(
            "index straighter",
            curl(2)
                .zip(others)
                .map(|(index, others)| ramp(others - index, 0.1, 0.3)),
        );
        let beyond = flexion(2).map(|[_, beyond]| beyond);
        self.set("index bent", beyond.map(|angle| ramp(angle, 0.3, 1.8)));
        self.set(
            "index straight",
            beyond.map(|angle| 1.0 - ramp(angle, 0.5, 1.1)),
        );
        let touching: Vec<[f64; 2]> = self.touching().filter_map(flexion).collect();
        let [knuckles, beyond]: [Vec<f64>; 2] =
            [0, 1].map(|part| touching.iter().map(|flexion| flexion[part]).collect());
        self.set(
            "knuckles",
            mean(&knuckles).map(|angle| angle / std::f64::consts::FRAC_PI_2),
        );
        self.set(
            "straight",
            mean(&beyond).map(|angle| 1.0 - ramp(angle / BENT_RAD, 0.12, 0.35)),
        );
        let elevation = thumb_elevation(anatomy, posed);
        self.set(
            "thumb abducted",
            elevation.map(|angle| ramp(angle.to_degrees(), 20.0, 45.0)),
        );
    }

    fn object(&mut self, anatomy: &Anatomy, posed: &PosedHand, held: &Held) {
        let axes = anatomy.palm_axes(posed);
        let along = |direction: Vector3<f64>| held.axis.dot(&direction).abs();
        let facing = ramp(along(axes.volar), 0.4, 0.9);
        self.set("axis facing", facing);
        self.set(
            "disk on palm",
            self.named("palm opposition")
                .max(DISK_ON_PALM * facing * self.named("palm")),
        );
        let bone = |digit, bone| anatomy.direction(posed, digit, bone);
        let thumb = bone(1, Bone::Distal).map(|thumb| ramp(along(thumb), 0.5, 0.9));
        self.set("thumb along", thumb);
        let index = bone(2, Bone::Distal).map(|distal| {
            let whole = distal + bone(2, Bone::Middle).unwrap_or_default();
            let whole = whole.try_normalize(1e-9).unwrap_or(distal);
            ramp(along(whole), 0.6, 0.95)
        });
        self.set("index along", index);
    }
}

fn is_finger(patch: Patch) -> bool {
    matches!(patch, Patch::Digit(2.., ..))
}

fn is_side(patch: Patch) -> bool {
    matches!(
        patch,
        Patch::Digit(_, _, PatchSide::Radial | PatchSide::Ulnar)
    )
}

/// The least residual of contact forces: 0 where they can balance, 1 where all press to one side.
fn left_over(touches: &[TouchingPatch]) -> f64 {
    let mut patches: Vec<(Patch, Vector3<f64>, f64)> = Vec::new();
    for touch in touches {
        let inward = -touch.object_normal * touch.weight_mm2;
        match patches.iter_mut().find(|(patch, ..)| *patch == touch.patch) {
            Some((_, sum, area)) => {
                *sum += inward;
                *area += touch.weight_mm2;
            }
            None => patches.push((touch.patch, inward, touch.weight_mm2)),
        }
    }
    let normals: Vec<Vector3<f64>> = patches
        .iter()
        .filter(|(_, sum, area)| *area >= BALANCED_MM2 && sum.norm() >= ALIKE * area)
        .map(|(_, sum, _)| sum.normalize())
        .collect();
    force_left_over(&normals, FRICTION)
}

/// Whether a contact of this area on a digit is a touch, mm².
pub(in crate::evaluation) fn touches_enough(mm2: f64) -> bool {
    enough(mm2) >= TOUCHES
}

/// Angle of the thumb's metacarpal above the plane of the palm, radians.
pub(in crate::evaluation) fn thumb_elevation(anatomy: &Anatomy, posed: &PosedHand) -> Option<f64> {
    let volar = anatomy.palm_axes(posed).volar;
    let bone = anatomy.direction(posed, 1, Bone::Metacarpal)?;
    Some(libm::asin(bone.dot(&volar).clamp(-1.0, 1.0)))
}

/// Flexion of a finger at the knuckle, and at the joints beyond, radians.
pub(in crate::evaluation) fn flexion(
    anatomy: &Anatomy,
    posed: &PosedHand,
    digit: usize,
) -> Option<[f64; 2]> {
    let axes = anatomy.palm_axes(posed);
    let [proximal, middle, distal] = [Bone::Proximal, Bone::Middle, Bone::Distal]
        .map(|bone| anatomy.direction(posed, digit, bone));
    let (proximal, distal) = (proximal?, distal?);
    let knuckle = libm::atan2(proximal.dot(&axes.volar), proximal.dot(&axes.distal));
    let beyond = match middle {
        Some(middle) => proximal.angle(&middle) + middle.angle(&distal),
        None => proximal.angle(&distal),
    };
    Some([knuckle, beyond])
}
