//! What a labeller can learn from: numbers about a grasp that any hand like a human one has.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::anatomy::{Anatomy, Bone, PalmPart, Patch};
use super::facts::{DIGITS, flexion, thumb_elevation};
use super::form::{Held, Solid};
use super::label::Label;
use super::table::Form;
use crate::hand::{PatchSide, PosedHand};
use crate::object::Object;

/// Distances beyond these say nothing more, millimetres.
const GAPS_MM: [f64; 2] = [-10.0, 20.0];
/// Lengths below this count as this, metres.
const SHORTEST_M: f64 = 1e-4;

/// The features of a grasp by name; what cannot be measured is missing.
///
/// | name | number |
/// |---|---|
/// | `fact …` | a fact of the rule, 0 to 1 |
/// | `gap …` | the least distance of a bone, or of a part of the palm, from the object, −10 to 20 mm |
/// | `bend …`, `spread …` | angles between bones, radians |
/// | `apart …` | distance between the pads of the thumb and of a finger, metres |
/// | `form …`, `solid …` | degree to which the part that is held has a form, 0 to 1 |
/// | `width`, `part …`, `object …` | natural logarithms of metres: between the contacts, extents of the part that is held, standard deviations of the object's surface along its principal axes |
pub type Features = BTreeMap<String, f64>;

/// Measures a grasp whose label by the rule is `label`.
pub(super) fn features(
    label: &Label,
    anatomy: &Anatomy,
    posed: &PosedHand,
    object: &Object,
) -> Features {
    let facts = label.facts.iter();
    let mut features: Features = facts
        .map(|(name, value)| (format!("fact {name}"), *value))
        .collect();
    gaps(&mut features, anatomy, posed, object);
    angles(&mut features, anatomy, posed);
    pads(&mut features, anatomy, posed);
    if let Some(held) = &label.held {
        part(&mut features, held);
    }
    for (place, deviation_m) in deviations_m(object).into_iter().enumerate() {
        features.insert(format!("object {}", place + 1), log(deviation_m));
    }
    features
}

fn log(metres: f64) -> f64 {
    libm::log(metres.max(SHORTEST_M))
}

fn bone_name(bone: Bone) -> &'static str {
    match bone {
        Bone::Metacarpal => "metacarpal",
        Bone::Proximal => "proximal",
        Bone::Middle => "middle",
        Bone::Distal => "distal",
    }
}

fn gaps(features: &mut Features, anatomy: &Anatomy, posed: &PosedHand, object: &Object) {
    let [least, most] = GAPS_MM;
    for (i, point) in posed.points.iter().enumerate() {
        let name = match anatomy.patch(i) {
            Patch::Digit(digit, bone, _) => {
                format!("gap {} {}", DIGITS[digit - 1], bone_name(bone))
            }
            Patch::Palm(PalmPart::Volar) => "gap palm".to_owned(),
            Patch::Palm(PalmPart::Web) => "gap web".to_owned(),
            Patch::Palm(PalmPart::Dorsum) => continue,
        };
        let gap_mm = (1e3 * object.exact.distance(point)).clamp(least, most);
        let known = features.entry(name).or_insert(most);
        *known = known.min(gap_mm);
    }
}

fn angles(features: &mut Features, anatomy: &Anatomy, posed: &PosedHand) {
    let axes = anatomy.palm_axes(posed);
    for (place, name) in DIGITS.iter().enumerate() {
        let digit = place + 1;
        let bones = [Bone::Metacarpal, Bone::Proximal, Bone::Middle, Bone::Distal];
        let direction = |bone| Some((bone, anatomy.direction(posed, digit, bone)?));
        let directions: Vec<(Bone, Vector3<f64>)> =
            bones.into_iter().filter_map(direction).collect();
        for pair in directions.windows(2) {
            let bend = pair[0].1.angle(&pair[1].1);
            features.insert(format!("bend {name} {}", bone_name(pair[1].0)), bend);
        }
        if let Some([knuckle, _]) = flexion(anatomy, posed, digit).filter(|_| digit > 1) {
            features.insert(format!("bend {name} proximal"), knuckle);
        }
        if let Some((_, first)) = directions.first() {
            let spread = libm::asin(first.dot(&axes.radial).clamp(-1.0, 1.0));
            features.insert(format!("spread {name}"), spread);
        }
    }
    if let Some(elevation) = thumb_elevation(anatomy, posed) {
        features.insert("spread thumb from palm".to_owned(), elevation);
    }
}

/// How far the pad of each finger is from that of the thumb.
fn pads(features: &mut Features, anatomy: &Anatomy, posed: &PosedHand) {
    let mut sums = [(Vector3::zeros(), 0.0); 5];
    for (i, point) in posed.points.iter().enumerate() {
        if let Patch::Digit(digit, Bone::Distal, PatchSide::Pad | PatchSide::Tip) = anatomy.patch(i)
        {
            let (sum, count) = &mut sums[digit - 1];
            *sum += point;
            *count += 1.0;
        }
    }
    let [thumb, fingers @ ..] = sums.map(|(sum, count)| (count > 0.0).then(|| sum / count));
    for (finger, name) in fingers.iter().zip(&DIGITS[1..]) {
        if let (Some(thumb), Some(finger)) = (thumb, finger) {
            features.insert(format!("apart thumb {name}"), (thumb - finger).norm());
        }
    }
}

fn part(features: &mut Features, held: &Held) {
    for form in Form::ALL {
        features.insert(format!("form {}", form.name()), held.degree(form));
    }
    for (solid, degree) in Solid::ALL.iter().zip(held.solids) {
        features.insert(format!("solid {}", solid.name()), degree);
    }
    features.insert("width".to_owned(), log(held.width_m));
    for (place, extent_m) in held.extents_m.into_iter().enumerate() {
        features.insert(format!("part {}", place + 1), log(extent_m));
    }
}

/// Standard deviations of the object's surface along its principal axes, smallest first.
fn deviations_m(object: &Object) -> [f64; 3] {
    let samples = &object.surface_samples;
    let count = samples.len().max(1) as f64;
    let middle: Vector3<f64> = samples.iter().map(|s| s.point).sum::<Vector3<f64>>() / count;
    let scatter: Matrix3<f64> = (samples.iter())
        .map(|s| (s.point - middle) * (s.point - middle).transpose())
        .sum();
    let mut variances: [f64; 3] = SymmetricEigen::new(scatter / count).eigenvalues.into();
    variances.sort_by(f64::total_cmp);
    variances.map(|variance| variance.max(0.0).sqrt())
}
