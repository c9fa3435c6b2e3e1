//! Widened fixtures: posed fixtures are carried over to other hands and to objects of other sizes and forms, and closed.

use landscape::evaluation::taxonomy::{Anatomy, Bone, PalmPart, Patch};
use landscape::hand::{Hand, PatchSide, PosedHand};
use landscape::sample::{Task, stream};
use landscape::space::{Pose, object_from_hand, pose_coordinates};
use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3,
};
use rand::RngExt;
use rayon::prelude::*;

use crate::closing::{Closing, Fit};
use crate::fixture::Fixture;
use crate::picture;
use crate::shape::Union;
use crate::widened::{HandName, Widened, can_be_reshaped, object};

/// Range of the factor on the object's size, and how often a new one is tried until a hand closes well.
const SCALES: [f64; 2] = [0.82, 1.22];
const TRIES: usize = 2;
/// The first hands share the numbers of their random streams; each later hand has numbers of its own, so that a new hand
/// changes no fixture of the others.
const TOGETHER: usize = 3;
/// A scene is kept if its contacts are no farther than this and nothing is deeper, metres.
const OPEN_M: f64 = 2.5e-3;
const DEEP_M: f64 = 3e-3;
/// The start is a closed hand already, so fewer and stricter stages do than for an authored posture, and fewer points of the
/// object.
const STAGES: [(f64, f64, usize); 2] = [(2.0, 3.0, 250), (20.0, 60.0, 450)];
const SPARSE: usize = 4;
/// Cost of a thumb that does not oppose the fingers of a precision grasp.
const OPPOSE: f64 = 30.0;
const NAMES: [&str; 6] = ["palm", "thumb", "index", "middle", "ring", "little"];
const BONES: [(&str, Bone); 4] = [
    ("metacarpal", Bone::Metacarpal),
    ("proximal", Bone::Proximal),
    ("middle", Bone::Middle),
    ("distal", Bone::Distal),
];

/// A hand with its anatomy and a measure of its size.
pub(crate) struct Reader<'a> {
    name: HandName,
    hand: &'a Hand,
    anatomy: Anatomy,
    length_m: f64,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(name: HandName, hand: &'a Hand) -> Result<Self, String> {
        let anatomy = Anatomy::of(hand).map_err(|why| why.to_string())?;
        let straight = hand.straight();
        // The middle finger from its knuckle to its tip.
        let own = |l: &usize| hand.links[*l].digit == 3;
        let first = (0..hand.links.len()).find(own).ok_or("no middle finger")?;
        let base = straight.object_from_link[first].translation;
        let ends = hand.capsules.iter().zip(&straight.capsules);
        let ends = ends.filter(|(capsule, _)| hand.links[capsule.link.0].digit == 3);
        let length_m = ends
            .flat_map(|(_, ends)| *ends)
            .map(|end| (end - base).norm())
            .fold(0.0, f64::max);
        Ok(Self {
            name,
            hand,
            anatomy,
            length_m,
        })
    }

    /// The surface points of a region named as on the human hand.
    fn points(&self, region: &str) -> Vec<usize> {
        if self.name == HandName::Human {
            return crate::shape::points(self.hand, region);
        }
        let parts: Vec<&str> = region.split('.').collect();
        let digit = NAMES.iter().position(|name| *name == parts[0]);
        let bone = parts
            .get(1)
            .and_then(|name| BONES.iter().find(|(known, _)| known == name));
        let side = parts.get(2).and_then(|name| PatchSide::named(name));
        let of = |patch: Patch| match patch {
            Patch::Palm(part) => {
                digit == Some(0)
                    && match parts.get(1) {
                        Some(&"web") => part == PalmPart::Web,
                        Some(&"dorsum") => part == PalmPart::Dorsum,
                        _ => part == PalmPart::Volar,
                    }
            }
            Patch::Digit(own, of_bone, of_side) => {
                digit == Some(own)
                    && bone.is_none_or(|(_, bone)| *bone == of_bone)
                    && side.is_none_or(|side| side == of_side)
            }
        };
        (0..self.hand.surface.len())
            .filter(|&i| of(self.anatomy.patch(i)))
            .collect()
    }

    /// The frame of the palm in the frame of the root, at these joints: radial, distal, volar; its origin is the palm's
    /// centre.
    fn palm(&self, joints: &[f64]) -> Isometry3<f64> {
        let mut posed = PosedHand::default();
        self.hand.pose_links(&Pose::at_origin(joints), &mut posed);
        let axes = self.anatomy.palm_axes(&posed);
        let distal = (axes.distal - axes.volar * axes.volar.dot(&axes.distal)).normalize();
        let rotation = Matrix3::from_columns(&[distal.cross(&axes.volar), distal, axes.volar]);
        Isometry3::from_parts(
            Translation3::from(self.hand.palm_at(joints).centre),
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation)),
        )
    }

    /// Directions of all bones in the palm's frame, at these joints.
    fn directions(&self, joints: &[f64]) -> Vec<Option<Vector3<f64>>> {
        let palm = self.palm(joints);
        let mut posed = PosedHand::default();
        self.hand.pose_links(&Pose::at_origin(joints), &mut posed);
        let bones = (1..NAMES.len()).flat_map(|digit| BONES.map(|(_, bone)| (digit, bone)));
        bones
            .map(|(digit, bone)| {
                let direction = self.anatomy.direction(&posed, digit, bone)?;
                Some(palm.rotation.inverse() * direction)
            })
            .collect()
    }

    /// Joint angles at which the bones have these directions, as nearly as they can: Gauss–Newton from the rest pose.
    fn joints_for(&self, wanted: &[Option<Vector3<f64>>]) -> Vec<f64> {
        const STEPS: usize = 30;
        const STEP_RAD: f64 = 1e-4;
        /// A radian away from rest costs as much as this difference of directions.
        const REST: f64 = 0.05;
        let hand = self.hand;
        let rest = &hand.prior.rest_rad;
        let residual = |joints: &[f64]| -> DVector<f64> {
            let found = self.directions(joints);
            let mut all = Vec::new();
            for (found, wanted) in found.iter().zip(wanted) {
                if let (Some(found), Some(wanted)) = (found, wanted) {
                    all.extend((found - wanted).iter());
                }
            }
            all.extend(joints.iter().zip(rest).map(|(q, rest)| REST * (q - rest)));
            DVector::from_vec(all)
        };
        let mut joints = rest.clone();
        for _ in 0..STEPS {
            let here = residual(&joints);
            let mut slopes = DMatrix::zeros(here.len(), joints.len());
            for j in 0..joints.len() {
                let mut moved = joints.clone();
                moved[j] += STEP_RAD;
                slopes.set_column(j, &((residual(&moved) - &here) / STEP_RAD));
            }
            let normal =
                slopes.tr_mul(&slopes) + DMatrix::identity(joints.len(), joints.len()) * 1e-4;
            let Some(change) = normal
                .cholesky()
                .map(|factor| factor.solve(&slopes.tr_mul(&here)))
            else {
                break;
            };
            for ((angle, joint), change) in joints.iter_mut().zip(&hand.joints).zip(&change) {
                let [low, high] = joint.limits_rad;
                *angle = (*angle - change.clamp(-0.3, 0.3)).clamp(low, high);
            }
        }
        joints
    }
}

/// Widened fixtures of these posed ones: one for each fixture and hand whose hand closes well. `seed` decides sizes and
/// forms.
pub(crate) fn widen(
    bases: &[Fixture],
    hands: &[Reader<'_>],
    seed: u64,
) -> Result<Vec<Widened>, String> {
    let human = hands.first().ok_or("no hand")?;
    let number = |base: usize, hand: usize| {
        if hand < TOGETHER {
            base * TOGETHER + hand
        } else {
            hand * bases.len() + base
        }
    };
    let tasks: Vec<(usize, &Fixture, &Reader<'_>)> = (bases.iter().enumerate())
        .flat_map(|(b, base)| {
            let hands = hands.iter().enumerate();
            hands.map(move |(h, hand)| (number(b, h), base, hand))
        })
        .collect();
    let made: Vec<Option<Widened>> = tasks
        .par_iter()
        .map(|(task, base, hand)| {
            let mut rng = stream(seed, Task::Start, *task as u64);
            for _ in 0..TRIES {
                let [low, high] = SCALES.map(libm::log);
                let factor = libm::exp(rng.random_range(low..high));
                let reshaped = rng.random_bool(0.5) && can_be_reshaped(base);
                let scale = factor * hand.length_m / human.length_m;
                let (x, fit) = carried(base, human, hand, scale, reshaped)?;
                let open = fit.gaps_m.iter().map(|gap| gap.abs()).fold(0.0, f64::max);
                let deep = fit.depth_m.max(fit.intrusion_m);
                if open < OPEN_M && deep < DEEP_M && fit.beyond_rad < 0.02 {
                    let round = |value: &f64| (value * 1e5).round() / 1e5;
                    return Some(Widened {
                        of: base.id.clone(),
                        hand: hand.name,
                        scale: (scale * 1e4).round() / 1e4,
                        reshaped,
                        x: x.iter().map(round).collect(),
                    });
                }
            }
            None
        })
        .collect();
    Ok(made.into_iter().flatten().collect())
}

/// The pose of a hand that closes on the object of a fixture with another size.
fn carried(
    base: &Fixture,
    human: &Reader<'_>,
    reader: &Reader<'_>,
    scale: f64,
    reshaped: bool,
) -> Option<(Vec<f64>, Fit)> {
    let x = base.coordinates(human.hand)?;
    let scale = (scale * 1e4).round() / 1e4;
    let shape = Union(object(base, scale, reshaped));
    let joints = reader.joints_for(&human.directions(&x[7..]));
    // The object stands to the palm as before, farther away as it and the hand are larger.
    let object_from_palm = object_from_hand(&x) * human.palm(&x[7..]);
    let mut palm_from_object = object_from_palm.inverse();
    palm_from_object.translation.vector *= scale;
    let object_from_root = (reader.palm(&joints) * palm_from_object).inverse();
    let start = pose_coordinates(&object_from_root, &joints);
    let touched = |part: &str| base.touching.iter().any(|region| region.starts_with(part));
    let mut free: Vec<String> = NAMES[2..].iter().map(ToString::to_string).collect();
    free.retain(|digit| !touched(digit));
    if !touched("thumb") {
        free.push("thumb".to_owned());
    }
    let precise = !touched("palm") && touched("thumb") && !free.contains(&"index".to_owned());
    if !touched("palm") {
        free.push("palm".to_owned());
    }
    let samples = picture::samples(&shape);
    let samples: Vec<Vector3<f64>> = samples.into_iter().step_by(SPARSE).collect();
    let points = |region: &String| reader.points(region);
    let touching: Vec<Vec<usize>> = base.touching.iter().map(points).collect();
    if touching.iter().any(Vec::is_empty) {
        return None;
    }
    let oppose = if precise { OPPOSE } else { 0.0 };
    let idle = |digit: usize| !touched(NAMES[digit.min(5)]);
    let mut closing = Closing::new(
        reader.hand,
        &shape,
        &samples,
        (touching, free.iter().flat_map(points).collect()),
        start,
        (1.5, oppose),
        idle,
    );
    closing.centre = reader.hand.palm_at(&joints).centre;
    let x = closing.close_in(&STAGES, 2);
    let fit = closing.fit(&x);
    Some((x, fit))
}
