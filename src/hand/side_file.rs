//! The optional side file, with properties of a hand that a description file cannot state.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{HandError, Link};

/// All entries are optional; missing entries are derived from the description file.
#[derive(Debug, Clone, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct SideFile {
    /// What the file is about; not used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) comment: Option<String>,
    /// Name of the hand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) name: Option<String>,
    /// Whether the hand is the mirror image of what this file describes, for example a left hand of a right one.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(super) mirror: bool,
    /// Settings for a MANO hand.
    #[serde(skip_serializing_if = "ManoEntry::is_empty")]
    pub(super) mano: ManoEntry,
    /// Links that are removed, with all links below them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) without: Vec<String>,
    /// Number of surface points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) surface_points: Option<usize>,
    /// Links that must not make contact.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) no_contact: Vec<String>,
    /// Pairs of links that are never checked for collision.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) apart: Vec<[String; 2]>,
    /// Pairs of links that are checked for collision, in place of the derived ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) self_pairs: Option<Vec<[String; 2]>>,
    /// Lengths of the pose space's metric.
    #[serde(skip_serializing_if = "MetricEntry::is_empty")]
    pub(super) metric: MetricEntry,
    /// Palm frame, root frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) palm: Option<PalmEntry>,
    /// Digits by name, thumb first; links that are not listed belong to the palm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) digits: Option<Vec<DigitEntry>>,
    /// Directions in the listed links' frames, which name the regions of digits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) axes: Option<AxesEntry>,
    /// Regions of the palm; the first rule that holds names the region.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) palm_regions: Vec<PalmRule>,
    /// Capsules that replace the geometry of a link in the description file.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) capsules: BTreeMap<String, Vec<CapsuleEntry>>,
    /// Capsules that fill the meshes, boxes and cylinders of links for collision; contact geometry is unchanged.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) filling: BTreeMap<String, Vec<CapsuleEntry>>,
    /// Rest angles by joint, degrees.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) rest_deg: BTreeMap<String, f64>,
    /// Rest positions of slides by joint, millimetres.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) rest_mm: BTreeMap<String, f64>,
    /// Angles at which the skin is built, by joint, degrees; other joints are at rest.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) cast_deg: BTreeMap<String, f64>,
    /// Standard deviations of the prior by joint, degrees; for other joints a quarter of the range.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) deviation_deg: BTreeMap<String, f64>,
    /// Standard deviations of slides by joint, millimetres.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) deviation_mm: BTreeMap<String, f64>,
    /// Postural synergies.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) synergies: Vec<Synergy>,
    /// Share of the prior's variance that is independent from joint to joint; 1 without synergies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) independent_share: Option<f64>,
}

/// The choice of joint coordinates of a MANO hand, and its shape.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ManoEntry {
    /// Number of principal components whose weights are the coordinates; without it the coordinates are the 45 angles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) components: Option<usize>,
    /// Weights of the shapes; missing weights are 0.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) betas: Vec<f64>,
}

impl ManoEntry {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

#[derive(Debug, Clone, Copy, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PalmEntry {
    pub(super) centre_m: [f64; 3],
    pub(super) volar: [f64; 3],
    pub(super) distal: [f64; 3],
    /// Distance from the centre along `distal` to the point that faces the object at the start of a chain.
    #[serde(default = "under_the_fingers")]
    pub(super) faced_m: f64,
}

/// Value for a human hand, metres.
fn under_the_fingers() -> f64 {
    0.035
}

/// Lengths of the metric; missing lengths are derived.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    clippy::struct_field_names,
    reason = "the unit belongs in the names of the file's entries"
)]
pub(super) struct MetricEntry {
    /// Metres per radian of a rotation of the whole hand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) radius_of_gyration_m: Option<f64>,
    /// How far such a rotation moves the digits, metres per radian.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) rotation_reach_m: Option<f64>,
    /// Metres per unit of each joint, averaged over the hand.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) levers_m: BTreeMap<String, f64>,
    /// Metres per unit of each joint, averaged over the parts that it moves.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) reaches_m: BTreeMap<String, f64>,
}

impl MetricEntry {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DigitEntry {
    pub(super) name: String,
    /// Links of each segment (`proximal`, `distal`, …).
    pub(super) segments: BTreeMap<String, Vec<String>>,
}

#[derive(Debug, Clone, Copy, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AxesEntry {
    /// Out of the pad.
    pub(super) pad: [f64; 3],
    /// To the thumb's side.
    pub(super) radial: [f64; 3],
    /// Along the bone, to the tip.
    pub(super) distal: [f64; 3],
}

/// A rule that holds if `normal`·n ≥ `at_least` and min ≤ p ≤ max, all in the root frame at the rest pose.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PalmRule {
    pub(super) region: String,
    #[serde(default)]
    pub(super) normal: [f64; 3],
    #[serde(default)]
    pub(super) at_least: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) min_m: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) max_m: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Copy, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CapsuleEntry {
    #[serde(rename = "a_m")]
    pub(super) a: [f64; 3],
    #[serde(rename = "b_m")]
    pub(super) b: [f64; 3],
    pub(super) radius_m: f64,
}

/// A direction in which joints move together, in units of their standard deviations.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Synergy {
    pub(super) name: String,
    pub(super) variance: f64,
    pub(super) weights: BTreeMap<String, f64>,
}

pub(super) fn parse(text: Option<&str>) -> Result<SideFile, HandError> {
    text.map_or_else(
        || Ok(SideFile::default()),
        |text| Ok(serde_json::from_str(text)?),
    )
}

/// For each link, whether the side file forbids contacts on it.
pub(super) fn untouching(links: &[Link], side: &SideFile) -> Result<Vec<bool>, HandError> {
    let known = |name: &String| links.iter().any(|link| &link.name == name);
    if let Some(name) = side.no_contact.iter().find(|&name| !known(name)) {
        return Err(HandError::Unknown {
            place: "\"no_contact\" of the side file".to_owned(),
            kind: "link",
            name: name.clone(),
        });
    }
    Ok(links
        .iter()
        .map(|link| side.no_contact.contains(&link.name))
        .collect())
}
