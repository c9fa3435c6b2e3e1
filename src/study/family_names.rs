//! Names of families of grasps that a person would give them: type, digits that touch, direction of the thumb, end of the object.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};
use petgraph::graph::NodeIndex;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::tables::Mapped;
use crate::evaluation::regions_within;
use crate::evaluation::taxonomy::{Anatomy, Labeller, Rule, Verdict};
use crate::grasp::GraspEnergy;
use crate::hand::{Hand, PosedHand};
use crate::object::Object;
use crate::store::Manifest;
use crate::topography::Minimum;

/// Share of the grasps of a family that must agree on a direction or a place, so that it becomes part of the name.
const AGREED: f64 = 2.0 / 3.0;
/// Greatest gap of a part that presses, metres. It is less than that of the strict filter, because a palm that lies beside the
/// object would make a grasp of the finger pads one of the whole hand.
const PRESSED_M: f64 = 0.001;
/// How many times as long as wide an object has ends.
const ELONGATED: f64 = 1.3;
/// Sine of the angle of 30° to the cross section of the object within which the thumb lies across it.
const ACROSS: f64 = 0.5;
/// Share of the half length beyond which contacts are at an end.
const END: f64 = 1.0 / 3.0;

/// What a person would call a family of grasps. `landscape.json` has one for each family (`findings.family_names`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FamilyName {
    /// The family.
    pub family: u64,
    /// Number of its minima.
    pub minima: usize,
    /// Number of its grasps.
    pub grasps: usize,
    /// The whole name, such as `Medium Wrap, whole hand, thumb up`. It ends its label with "and others" if less than half of the
    /// grasps have it.
    pub name: String,
    /// The most frequent label; `None` where no grasp has one.
    pub label: Option<String>,
    /// Share of the grasps that have this label.
    pub label_share: f64,
    /// Digits, and the palm, that are at most 1 mm off the object in more than half of the grasps.
    pub digits: Vec<String>,
    /// Where the side of the thumb points, if two thirds of the grasps agree: up, down or across on an object that stands.
    pub thumb: Option<String>,
    /// The end of a long object at which the contacts are, if two thirds of the grasps agree.
    pub place: Option<String>,
}

impl FamilyName {
    /// The names of all families of a finished landscape; empty if it has none, as that of a surface.
    pub fn of_manifest(manifest: &Manifest) -> Vec<Self> {
        let names = manifest.findings.get("family_names");
        let names = names.map(|names| serde_json::from_value(names.clone()));
        names.and_then(Result::ok).unwrap_or_default()
    }
}

/// What is told of one minimum.
struct Told {
    grasps: usize,
    labels: BTreeMap<String, usize>,
    digits: Vec<String>,
    thumb: Option<String>,
    place: Option<String>,
}

/// Names of all families, in their order.
pub(super) fn family_names(mapped: &Mapped<'_>, energy: &GraspEnergy) -> Vec<FamilyName> {
    let (hand, object) = (energy.hand(), energy.object());
    let unlabelled = mapped.inputs.iter().all(|input| input.label.is_none());
    let labeller = unlabelled.then(|| Labeller::new(hand, object, Rule::standard()));
    let anatomy = Anatomy::of(hand).ok();
    let axis = LongAxis::of(object);
    let told = |minimum: &Minimum| {
        let x = &minimum.coordinates;
        let mut labels = BTreeMap::new();
        if let Some(labeller) = &labeller {
            let label = labeller.label(x);
            if !matches!(label.verdict, Verdict::NotApplicable(_)) {
                labels.insert(label.text().to_owned(), minimum.members.len());
            }
        }
        for row in &minimum.members {
            if let Some(label) = &mapped.inputs[*row].label {
                *labels.entry(label.clone()).or_default() += 1;
            }
        }
        let touching = regions_within(hand, object, x, PRESSED_M);
        let centre = energy.contact_centre(x, &energy.contacts(x));
        let thumb = axis.as_ref().zip(anatomy.as_ref()).map(|(axis, anatomy)| {
            let mut posed = PosedHand::default();
            hand.pose(x, &mut posed);
            axis.thumb(&anatomy.palm_axes(&posed).radial)
        });
        Told {
            grasps: minimum.members.len(),
            labels,
            digits: touching.into_iter().map(str::to_owned).collect(),
            thumb,
            place: axis.as_ref().map(|axis| axis.place(&centre)),
        }
    };
    let network = &mapped.landscape.network;
    let minima: Vec<Told> = (0..network.node_count())
        .into_par_iter()
        .map(|id| told(&network[NodeIndex::new(id)]))
        .collect();
    let families = mapped.landscape.families.members.iter().enumerate();
    families
        .map(|(family, members)| {
            let members: Vec<&Told> = members.iter().map(|id| &minima[id.0]).collect();
            name_of(family, &members, hand)
        })
        .collect()
}

fn name_of(family: usize, members: &[&Told], hand: &Hand) -> FamilyName {
    let grasps: usize = members.iter().map(|told| told.grasps).sum();
    let mut labels: BTreeMap<&str, usize> = BTreeMap::new();
    for (label, count) in members.iter().flat_map(|told| &told.labels) {
        *labels.entry(label).or_default() += count;
    }
    let most = labels.iter().map(|(label, count)| (*count, *label));
    let (count, label) = most
        .max_by(|a, b| a.0.cmp(&b.0).then(b.1.cmp(a.1)))
        .map_or((0, None), |(count, label)| (count, Some(label.to_owned())));
    let touching = |digit: &&String| {
        let with = members.iter().filter(|told| told.digits.contains(digit));
        2 * with.map(|told| told.grasps).sum::<usize>() > grasps
    };
    let digits: Vec<String> = hand.digits.iter().filter(touching).cloned().collect();
    let agreed = |value: fn(&Told) -> Option<&String>| {
        let mut counts: BTreeMap<&String, usize> = BTreeMap::new();
        for told in members {
            if let Some(value) = value(told) {
                *counts.entry(value).or_default() += told.grasps;
            }
        }
        let enough = |count: usize| count as f64 >= AGREED * grasps as f64;
        let found = counts.into_iter().find(|(_, count)| enough(*count));
        found.map(|(value, _)| value.clone())
    };
    let thumb = agreed(|told| told.thumb.as_ref());
    let place = agreed(|told| told.place.as_ref());
    let digits_told = spell_digits(&digits, hand);
    let told_label = label.as_ref().map(|label| {
        let others = if 2 * count < grasps {
            " and others"
        } else {
            ""
        };
        format!("{label}{others}")
    });
    let parts = [
        told_label,
        digits_told,
        thumb.as_ref().map(|thumb| format!("thumb {thumb}")),
        place.clone(),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    FamilyName {
        family: family as u64,
        minima: members.len(),
        grasps,
        name: parts.join(", "),
        label,
        label_share: count as f64 / grasps.max(1) as f64,
        digits,
        thumb,
        place,
    }
}

/// The digits that touch, as a person would tell them. The first digit of a hand is its palm.
fn spell_digits(touching: &[String], hand: &Hand) -> Option<String> {
    let (palm, fingers) = hand.digits.split_first()?;
    let with_palm = touching.contains(palm);
    let missing: Vec<&String> = fingers
        .iter()
        .filter(|digit| !touching.contains(digit))
        .collect();
    Some(match (missing.as_slice(), with_palm) {
        _ if touching.is_empty() => return None,
        ([], true) => "whole hand".to_owned(),
        ([], false) => "all digits".to_owned(),
        ([one], true) if fingers.len() > 2 => format!("whole hand but {one}"),
        ([one], false) if fingers.len() > 3 => format!("all digits but {one}"),
        _ => touching.join("+"),
    })
}

/// The long axis of an object that is longer than wide.
struct LongAxis {
    /// Unit vector towards the end of the greater coordinate.
    direction: Vector3<f64>,
    centroid: Vector3<f64>,
    half_length_m: f64,
    /// The coordinate that is nearest to the axis: 0 to 2.
    coordinate: usize,
}

impl LongAxis {
    fn of(object: &Object) -> Option<Self> {
        let centroid = object.centroid;
        let arms = object.surface_samples.iter();
        let arms: Vec<Vector3<f64>> = arms.map(|sample| sample.point - centroid).collect();
        let moments = (arms.iter()).fold(Matrix3::zeros(), |sum, arm| sum + arm * arm.transpose());
        let axes = moments.symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| axes.eigenvalues[*b].total_cmp(&axes.eigenvalues[*a]));
        let [longest, next] = [order[0], order[1]].map(|k| axes.eigenvalues[k].max(0.0).sqrt());
        if longest < ELONGATED * next {
            return None;
        }
        let mut direction: Vector3<f64> = axes.eigenvectors.column(order[0]).into();
        let coordinate = direction.iamax();
        direction *= direction[coordinate].signum();
        let half_length_m =
            (arms.iter()).fold(0.0, |most: f64, arm| most.max(arm.dot(&direction).abs()));
        Some(Self {
            direction,
            centroid,
            half_length_m,
            coordinate,
        })
    }

    /// The name of an end: above or below the middle along the axis.
    fn end(&self, is_greater: bool, [top, bottom]: [&str; 2]) -> String {
        match (self.coordinate, is_greater) {
            (2, true) => top.to_owned(),
            (2, false) => bottom.to_owned(),
            (k, true) => format!("toward +{}", ["x", "y"][k]),
            (k, false) => format!("toward −{}", ["x", "y"][k]),
        }
    }

    /// Where the side of the thumb points.
    fn thumb(&self, radial: &Vector3<f64>) -> String {
        let along = radial.dot(&self.direction);
        if along.abs() < ACROSS {
            return "across".to_owned();
        }
        self.end(along > 0.0, ["up", "down"])
    }

    /// At which end a point lies.
    fn place(&self, point: &Vector3<f64>) -> String {
        let along = (point - self.centroid).dot(&self.direction) / self.half_length_m;
        if along.abs() < END {
            return "in the middle".to_owned();
        }
        self.end(along > 0.0, ["at the top", "at the bottom"])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn object(name: &str) -> Object {
        Object::named(name).unwrap()
    }

    #[test]
    fn ends_of_a_long_object_have_names() {
        let axis = LongAxis::of(&object("bottle_round")).unwrap();
        assert_eq!(axis.thumb(&Vector3::z()), "up");
        assert_eq!(axis.thumb(&-Vector3::z()), "down");
        assert_eq!(axis.thumb(&Vector3::x()), "across");
        let at = |share: f64| {
            axis.place(&(axis.centroid + axis.direction * (share * axis.half_length_m)))
        };
        assert_eq!(at(0.9), "at the top");
        assert_eq!(at(0.1), "in the middle");
        assert_eq!(at(-0.9), "at the bottom");
        assert!(LongAxis::of(&object("ball")).is_none());
    }

    #[test]
    fn a_family_is_named_by_what_most_of_its_grasps_share() {
        let hand = Hand::human();
        let told = |grasps, label: &str, digits: &[&str], thumb: &str| Told {
            grasps,
            labels: BTreeMap::from([(label.to_owned(), grasps)]),
            digits: digits.iter().map(|digit| (*digit).to_owned()).collect(),
            thumb: Some(thumb.to_owned()),
            place: None,
        };
        let palm = hand.digits[0].as_str();
        let wrap = told(
            6,
            "Medium Wrap",
            &[palm, "thumb", "index", "middle", "ring", "little"],
            "up",
        );
        let pinch = told(2, "Tip Pinch", &["thumb", "index"], "up");
        let across = told(4, "Tip Pinch", &["thumb", "index"], "across");
        let named = |members: &[&Told]| name_of(3, members, &hand).name;
        assert_eq!(named(&[&wrap, &pinch]), "Medium Wrap, whole hand, thumb up");
        assert_eq!(named(&[&pinch]), "Tip Pinch, thumb+index, thumb up");
        assert_eq!(named(&[&wrap, &across]), "Medium Wrap, whole hand");
        let found = name_of(3, &[&wrap, &pinch], &hand);
        assert_eq!((found.family, found.minima, found.grasps), (3, 2, 8));
        assert!((found.label_share - 0.75).abs() < 1e-12);
        let third = told(3, "Ring", &["thumb", "index"], "across");
        assert_eq!(
            named(&[&pinch, &third, &across]),
            "Tip Pinch, thumb+index, thumb across"
        );
        assert_eq!(
            named(&[&wrap, &across, &third]),
            "Medium Wrap and others, thumb+index"
        );
        assert_eq!(named(&[]), "");
    }
}
