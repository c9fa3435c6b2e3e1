//! The optional side file: what a description file cannot say about a hand.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::HandError;

/// Everything in it is optional; what is missing is derived from the description file.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct SideFile {
    /// Says what the file is about; not read.
    #[serde(rename = "comment")]
    pub(super) _comment: Option<String>,
    /// Name of the hand.
    pub(super) name: Option<String>,
    /// Palm frame, root frame.
    pub(super) palm: Option<PalmEntry>,
    /// Digits by name, thumb first; links that are not listed belong to the palm.
    pub(super) digits: Option<Vec<DigitEntry>>,
    /// Directions of the listed links' frames, for naming the regions of digits.
    pub(super) axes: Option<AxesEntry>,
    /// Regions of the palm: the first rule that holds names the region.
    pub(super) palm_regions: Vec<PalmRule>,
    /// Geometry of links, in place of what the description file says.
    pub(super) capsules: BTreeMap<String, Vec<CapsuleEntry>>,
    /// Angles of the rest pose, degrees, by joint; the others rest in the middle of their range.
    pub(super) rest_deg: BTreeMap<String, f64>,
    /// Angles at which the skin is cast, degrees, by joint; the others as in the rest pose.
    pub(super) cast_deg: BTreeMap<String, f64>,
    /// Postural synergies.
    pub(super) synergies: Vec<Synergy>,
    /// Share of the prior's variance that is independent from joint to joint; 1 without synergies.
    pub(super) independent_share: Option<f64>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PalmEntry {
    pub(super) centre_m: [f64; 3],
    pub(super) volar: [f64; 3],
    pub(super) distal: [f64; 3],
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DigitEntry {
    pub(super) name: String,
    /// Segment (`proximal`, `distal`, …) → links.
    pub(super) segments: BTreeMap<String, Vec<String>>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AxesEntry {
    /// Out of the pad.
    pub(super) pad: [f64; 3],
    /// To the thumb's side.
    pub(super) radial: [f64; 3],
    /// Along the bone, to the tip.
    pub(super) distal: [f64; 3],
}

/// Holds where `normal`·n ≥ `at_least` and min ≤ p ≤ max, all in the root frame at the rest pose.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PalmRule {
    pub(super) region: String,
    #[serde(default)]
    pub(super) normal: [f64; 3],
    #[serde(default)]
    pub(super) at_least: f64,
    #[serde(default)]
    pub(super) min_m: Option<[f64; 3]>,
    #[serde(default)]
    pub(super) max_m: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CapsuleEntry {
    #[serde(rename = "a_m")]
    pub(super) a: [f64; 3],
    #[serde(rename = "b_m")]
    pub(super) b: [f64; 3],
    pub(super) radius_m: f64,
}

/// A direction in which joints move together, in units of their standard deviations.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Synergy {
    #[serde(rename = "name")]
    pub(super) _name: String,
    pub(super) variance: f64,
    pub(super) weights: BTreeMap<String, f64>,
}

pub(super) fn parse(text: Option<&str>) -> Result<SideFile, HandError> {
    text.map_or_else(
        || Ok(SideFile::default()),
        |text| Ok(serde_json::from_str(text)?),
    )
}
