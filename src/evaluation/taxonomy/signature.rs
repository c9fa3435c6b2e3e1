//! The signatures that distinguish the types, `data/taxonomy/signatures.toml`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::TaxonomyError;
use super::features::{DIGITS, FEATURES, feature};
use super::pose_correction::PoseCorrection;
use super::table::{Category, GraspType, Opposition, Taxonomy, Thumb};

/// The signatures as text.
const SIGNATURES: &str = include_str!("../../../data/taxonomy/signatures.toml");

/// Value of a feature that a type expects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cue {
    /// Number of the feature.
    pub(super) feature: usize,
    /// Value on a perfect grasp of the type.
    pub(super) target: f64,
    /// Weight of the feature.
    pub(super) weight: f64,
    /// Whether a miss also lowers the total score.
    pub(super) key: bool,
}

/// The rule that names grasps: cues of all types, and thresholds.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// A grasp with a lower best score is unlisted.
    pub unlisted_below: f64,
    /// A grasp whose two best scores differ by less is ambiguous.
    pub ambiguous_within: f64,
    /// A hash (64-bit FNV-1a) of signatures, features, the table of types and the settings of [`PoseCorrection`]; each label
    /// belongs to one.
    pub version: String,
    /// Weight with which a missed key feature lowers the score.
    pub(super) gate: f64,
    /// Cues of each type, by number, in the order of the features.
    pub(super) cues: Vec<Vec<Cue>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    unlisted_below: f64,
    ambiguous_within: f64,
    gate: f64,
    key_weight: f64,
    base: Base,
    category: BTreeMap<Category, BTreeMap<String, [f64; 2]>>,
    #[serde(rename = "type")]
    types: Vec<Entry>,
}

/// Weights of the cues that follow from the table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Base {
    digit: f64,
    opposition: f64,
    other_opposition: f64,
    thumb: f64,
    form: f64,
    size: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    number: u8,
    cues: BTreeMap<String, [f64; 2]>,
}

impl Rule {
    /// The rule that comes with the program.
    ///
    /// # Panics
    /// Never: the signatures are part of the program, and a test reads them.
    pub fn standard() -> &'static Self {
        static STANDARD: LazyLock<Rule> = LazyLock::new(|| {
            Rule::parse(SIGNATURES).expect("the signatures that are built in are valid")
        });
        &STANDARD
    }

    /// Reads a rule from the text of signatures, in the form of `data/taxonomy/signatures.toml`.
    ///
    /// # Errors
    /// If the text is not of that form, a type has not exactly one signature, or a cue names no feature.
    pub fn parse(text: &str) -> Result<Self, TaxonomyError> {
        let taxonomy = Taxonomy::feix();
        let file: File = crate::formats::toml_text::parse(text)?;
        let mut cues = Vec::new();
        for entry in &taxonomy.types {
            let refuse = |problem: String| TaxonomyError::Type {
                name: entry.name.clone(),
                problem,
            };
            let mut own = file.types.iter().filter(|own| own.number == entry.number);
            let (Some(own), None) = (own.next(), own.next()) else {
                return Err(refuse("exactly one signature is needed".to_owned()));
            };
            let mut of_type: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
            base(entry, &file.base, &mut of_type);
            let of_category = file.category.get(&entry.category).into_iter().flatten();
            for (name, [target, weight]) in of_category.chain(&own.cues) {
                let known = feature(name)
                    .ok_or_else(|| refuse(format!("no feature is called \"{name}\"")))?;
                if !(0.0..=1.0).contains(target) || !(0.0..=f64::MAX).contains(weight) {
                    let problem = format!(
                        "\"{name}\" = [{target}, {weight}] is not a target from 0 to 1 and a weight of 0 or more"
                    );
                    return Err(refuse(problem));
                }
                of_type.insert(known, [*target, *weight]);
            }
            let cue = |(feature, [target, weight]): (usize, [f64; 2])| Cue {
                feature,
                target,
                weight,
                key: weight >= file.key_weight && (target <= 0.0 || target >= 1.0),
            };
            cues.push(
                of_type
                    .into_iter()
                    .map(cue)
                    .filter(|cue| cue.weight > 0.0)
                    .collect(),
            );
        }
        Ok(Self {
            version: version(text),
            unlisted_below: file.unlisted_below,
            ambiguous_within: file.ambiguous_within,
            gate: file.gate,
            cues,
        })
    }

    /// Whether a type is possible without a digit (1 = thumb … 5 = little), because it does not expect that digit to touch.
    pub(super) fn can_do_without(&self, entry: &GraspType, digit: usize) -> bool {
        let touch = feature(DIGITS[digit - 1]);
        let cues = &self.cues[usize::from(entry.number) - 1];
        let expected = (cues.iter()).any(|cue| Some(cue.feature) == touch && cue.target > 0.5);
        !entry.uses(digit) && !expected
    }
}

fn version(signatures: &str) -> String {
    // `Settle` was the name of the correction when the published versions of the rule were hashed.
    let correction = format!("{:?}", PoseCorrection::default());
    let correction = correction.replacen("PoseCorrection", "Settle", 1);
    let known = format!("{:?}{FEATURES:?}{correction}", Taxonomy::feix());
    let hash = signatures
        .bytes()
        .chain(known.bytes())
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
    format!("{hash:016x}")
}

/// The cues that follow from the table.
fn base(entry: &GraspType, base: &Base, cues: &mut BTreeMap<usize, [f64; 2]>) {
    let mut expect = |name: &str, target: f64, weight: f64| {
        if let Some(feature) = feature(name) {
            cues.insert(feature, [target, weight]);
        }
    };
    for (place, name) in DIGITS.iter().enumerate() {
        let used = entry.uses(place + 1);
        // In a palm grasp the thumb may help without being a virtual finger.
        let open = place == 0 && !used && entry.opposition == Opposition::Palm;
        if !open {
            expect(name, f64::from(u8::from(used)), base.digit);
        }
    }
    for kind in [Opposition::Palm, Opposition::Pad, Opposition::Side] {
        let own = kind == entry.opposition;
        let weight = if own {
            base.opposition
        } else {
            base.other_opposition
        };
        expect(
            &format!("{} opposition", kind.name()),
            f64::from(u8::from(own)),
            weight,
        );
    }
    let abducted = f64::from(u8::from(entry.thumb == Thumb::Abducted));
    expect("thumb abducted", abducted, base.thumb);
    if !entry.forms.is_empty() {
        expect("form", 1.0, base.form);
    }
    if entry.size_mm.is_some() {
        expect("size", 1.0, base.size);
    }
}

/// The name of a feature.
pub(super) fn name(feature: usize) -> &'static str {
    FEATURES[feature].0
}

/// The meaning of a feature, in words.
pub(super) fn meaning(feature: usize) -> &'static str {
    FEATURES[feature].1
}
