//! The rule that tells the types apart, `data/taxonomy/rule.toml`.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use serde::Deserialize;

use super::TaxonomyError;
use super::anatomy::Anatomy;
use super::facts::{DIGITS, FACTS, fact};
use super::pose_correction::PoseCorrection;
use super::table::{Category, GraspType, Opposition, Taxonomy, Thumb};
use super::taught::Taught;

/// The rule as text.
const RULE: &str = include_str!("../../../data/taxonomy/rule.toml");

/// Greatest value of each of the two numbers of a [`Sharpness`].
const SHARPEST: f64 = 5.0;

/// What a type expects of a fact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cue {
    /// Number of the fact.
    pub(super) fact: usize,
    /// A fact that may stand in for it.
    pub(super) or: Option<usize>,
    /// Whether it is to be present or absent.
    pub(super) present: bool,
    /// How much of the fit is lost if it is not so, 0 to 1.
    pub(super) trust: f64,
}

/// The exponent of the fits in the probabilities that are told.
///
/// ```text
/// exponent = least + by_fit · (how well the type that fits best fits, 0 to 1)
/// ```
///
/// Above 1 probabilities are more certain than the fits, below 1 less. On fixtures the answer is mostly right where some type
/// fits well, and often wrong where all types fit badly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sharpness {
    /// The exponent of a grasp that fits no type.
    pub least: f64,
    /// What is added for one that fits a type in all that it expects.
    pub by_fit: f64,
}

impl Sharpness {
    pub(super) fn exponent(self, fit: f64) -> f64 {
        self.least + self.by_fit * fit
    }
}

/// The rule that names grasps: what each type expects, and thresholds.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// A grasp that fits no type better is unlisted.
    pub unlisted_below: f64,
    /// How certain the probabilities are that are told. The label does not depend on it.
    pub sharpness: Sharpness,
    /// Least share of its cell's probability with which a type is the label.
    pub type_share: f64,
    /// Least share of its category's probability with which a cell is the label.
    pub cell_share: f64,
    /// A hash (64-bit FNV-1a) of the rule, the facts, the table of types and the settings of [`PoseCorrection`]; each label
    /// belongs to one.
    pub version: String,
    /// Least probability of the category, cell and type of likely and of open answers.
    pub(super) certain: [[f64; 2]; 3],
    /// A labeller that was taught and names grasps in place of the rule, but for those unlike all that it has seen.
    pub taught: Option<Arc<Taught>>,
    /// Expectations of each type, by number, in the order of the facts.
    pub(super) cues: Vec<Vec<Cue>>,
}

/// How strongly a fact is expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
enum Word {
    #[serde(rename = "must")]
    Must,
    #[serde(rename = "should")]
    Should,
    #[serde(rename = "rather")]
    Rather,
    #[serde(rename = "must not")]
    MustNot,
    #[serde(rename = "should not")]
    ShouldNot,
    #[serde(rename = "rather not")]
    RatherNot,
}

impl Word {
    fn of(present: bool, word: Self) -> Self {
        match word {
            Self::Must if !present => Self::MustNot,
            Self::Should if !present => Self::ShouldNot,
            Self::Rather if !present => Self::RatherNot,
            word => word,
        }
    }

    fn present(self) -> bool {
        matches!(self, Self::Must | Self::Should | Self::Rather)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    must: f64,
    should: f64,
    rather: f64,
    unlisted_below: f64,
    /// Where it is absent, fits are taken as they are.
    #[serde(default = "as_they_are")]
    sharpness: f64,
    #[serde(default)]
    sharpness_by_fit: f64,
    type_share: f64,
    cell_share: f64,
    /// Where it is absent, all answers are guesses.
    #[serde(default)]
    certainty: Certain,
    holding: Vec<Holding>,
    #[serde(rename = "type")]
    types: Vec<Entry>,
}

/// Least probabilities of answers of a certainty.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Certain {
    category: Least,
    cell: Least,
    #[serde(rename = "type")]
    kind: Least,
}

/// Where a probability is absent, no answer has the certainty.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Least {
    likely: Option<f64>,
    open: Option<f64>,
}

/// What the types of one category and opposition have in common.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Holding {
    category: Category,
    opposition: Opposition,
    cues: BTreeMap<String, Word>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    number: u8,
    opposed_by: Option<String>,
    #[serde(default)]
    either: Vec<usize>,
    #[serde(default)]
    cues: BTreeMap<String, Word>,
}

/// The exponent that leaves fits as they are.
fn as_they_are() -> f64 {
    1.0
}

impl File {
    fn trust(&self, word: Word) -> f64 {
        match word {
            Word::Must | Word::MustNot => self.must,
            Word::Should | Word::ShouldNot => self.should,
            Word::Rather | Word::RatherNot => self.rather,
        }
    }

    /// The first number that is not above 0 and at most 1.
    fn outside(&self) -> Option<(&'static str, f64)> {
        let numbers = [
            ("must", self.must),
            ("should", self.should),
            ("rather", self.rather),
            ("unlisted_below", self.unlisted_below),
            ("type_share", self.type_share),
            ("cell_share", self.cell_share),
        ];
        numbers
            .into_iter()
            .find(|(_, value)| !(*value > 0.0 && *value <= 1.0))
    }

    /// What one type expects.
    fn cues(&self, entry: &GraspType) -> Result<Vec<Cue>, String> {
        let mut own = self.types.iter().filter(|own| own.number == entry.number);
        let (Some(own), None) = (own.next(), own.next()) else {
            return Err("exactly one entry is needed".to_owned());
        };
        let known = |name: &str| fact(name).ok_or_else(|| format!("no fact is called \"{name}\""));
        let holding = self.holding.iter().find(|holding| {
            (holding.category, holding.opposition) == (entry.category, entry.opposition)
        });
        let holding = holding.ok_or("no [[holding]] has its category and opposition")?;
        let mut words: BTreeMap<usize, Word> = BTreeMap::new();
        for (name, word) in of_the_table(entry, &own.either) {
            words.insert(known(&name)?, word);
        }
        for (name, word) in holding.cues.iter().chain(&own.cues) {
            words.insert(known(name)?, *word);
        }
        let stand_in = own.opposed_by.as_deref().map(known).transpose()?;
        let opposition = known(&opposition_fact(entry))?;
        let cue = |(fact, word): (usize, Word)| Cue {
            fact,
            or: stand_in.filter(|_| fact == opposition),
            present: word.present(),
            trust: self.trust(word),
        };
        Ok(words.into_iter().map(cue).collect())
    }
}

impl Rule {
    /// The rule that comes with the program.
    ///
    /// # Panics
    /// Never: the rule is part of the program, and a test reads it.
    pub fn standard() -> &'static Self {
        static STANDARD: LazyLock<Rule> =
            LazyLock::new(|| Rule::parse(RULE).expect("the rule that is built in is valid"));
        &STANDARD
    }

    /// Reads a rule from text in the form of `data/taxonomy/rule.toml`.
    ///
    /// # Errors
    /// If the text is not of that form, a number is not between 0 and 1, a type has not exactly one entry, or a cue names no
    /// fact.
    pub fn parse(text: &str) -> Result<Self, TaxonomyError> {
        let file: File = crate::formats::toml_text::parse(text)?;
        let refuse = |name: &str, problem: String| TaxonomyError::Type {
            name: name.to_owned(),
            problem,
        };
        if !(file.sharpness > 0.0 && file.sharpness <= SHARPEST) {
            let problem = format!("{} is not above 0 and at most {SHARPEST}", file.sharpness);
            return Err(refuse("sharpness", problem));
        }
        if !(0.0..=SHARPEST).contains(&file.sharpness_by_fit) {
            let problem = format!("{} is not between 0 and {SHARPEST}", file.sharpness_by_fit);
            return Err(refuse("sharpness_by_fit", problem));
        }
        if let Some((name, value)) = file.outside() {
            let problem = format!("{value} is not above 0 and at most 1");
            return Err(refuse(name, problem));
        }
        let types = Taxonomy::feix().types.iter();
        let cues = types.map(|entry| {
            let own = file.cues(entry);
            own.map_err(|problem| refuse(&entry.name, problem))
        });
        Ok(Self {
            version: version(text),
            cues: cues.collect::<Result<_, _>>()?,
            unlisted_below: file.unlisted_below,
            sharpness: Sharpness {
                least: file.sharpness,
                by_fit: file.sharpness_by_fit,
            },
            type_share: file.type_share,
            cell_share: file.cell_share,
            certain: [
                &file.certainty.category,
                &file.certainty.cell,
                &file.certainty.kind,
            ]
            .map(|least| [least.likely, least.open].map(|p| p.unwrap_or(f64::INFINITY))),
            taught: None,
        })
    }

    /// This rule with a labeller that was taught, which names grasps in its place where it has seen grasps like them.
    #[must_use]
    pub fn with(self, taught: Taught) -> Self {
        Self {
            taught: Some(Arc::new(taught)),
            ..self
        }
    }

    /// What a type expects.
    pub(super) fn cues(&self, entry: &GraspType) -> &[Cue] {
        &self.cues[usize::from(entry.number) - 1]
    }

    /// Whether a hand has all digits that a type needs.
    pub fn can_be_done(&self, anatomy: &Anatomy, entry: &GraspType) -> bool {
        (1..=5).all(|digit| anatomy.has(digit) || self.can_do_without(entry, digit))
    }

    /// Whether a type is possible without a digit (1 = thumb … 5 = little), because it does not expect that digit to touch.
    pub(super) fn can_do_without(&self, entry: &GraspType, digit: usize) -> bool {
        let touch = fact(DIGITS[digit - 1]);
        let expected = (self.cues(entry).iter()).any(|cue| Some(cue.fact) == touch && cue.present);
        !entry.uses(digit) && !expected
    }
}

fn opposition_fact(entry: &GraspType) -> String {
    format!("{} opposition", entry.opposition.name())
}

/// What follows from the table of types; `either`: digits that may touch or not.
fn of_the_table(entry: &GraspType, either: &[usize]) -> Vec<(String, Word)> {
    let mut words = vec![
        (opposition_fact(entry), Word::Must),
        ("gap between fingers".to_owned(), Word::MustNot),
        (
            "thumb abducted".to_owned(),
            Word::of(entry.thumb == Thumb::Abducted, Word::Rather),
        ),
    ];
    let palm = entry.opposition == Opposition::Palm;
    for (place, name) in DIGITS.iter().enumerate() {
        let digit = place + 1;
        let main = entry.vf1.contains(&digit) || entry.vf2.contains(&digit);
        let word = match () {
            () if main && palm => Word::Should,
            () if main => Word::Must,
            () if entry.vf3.contains(&digit) => Word::Rather,
            // In a palm grasp the thumb may help without being a virtual finger.
            () if either.contains(&digit) || (palm && digit == 1) => continue,
            () => Word::ShouldNot,
        };
        words.push(((*name).to_owned(), word));
    }
    if !entry.forms.is_empty() {
        words.push(("form".to_owned(), Word::Should));
    }
    if entry.size_mm.is_some() {
        words.push(("size".to_owned(), Word::Should));
    }
    words
}

fn version(rule: &str) -> String {
    let correction = PoseCorrection::default();
    let known = format!("{:?}{FACTS:?}{correction:?}", Taxonomy::feix());
    let hash = rule
        .bytes()
        .chain(known.bytes())
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
    format!("{hash:016x}")
}

/// The name of a fact.
pub(super) fn name(fact: usize) -> &'static str {
    FACTS[fact].0
}

/// The meaning of a fact, in words.
pub(super) fn meaning(fact: usize) -> &'static str {
    FACTS[fact].1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_expects_what_the_table_says() {
        let rule = Rule::standard();
        for entry in &Taxonomy::feix().types {
            let cues = rule.cues(entry);
            let own = |name: &str| cues.iter().find(|cue| Some(cue.fact) == fact(name));
            let opposition = own(&opposition_fact(entry));
            assert!(
                opposition.is_some_and(|cue| cue.present && cue.trust > 0.9),
                "{}",
                entry.name
            );
            for digit in entry.vf1.iter().chain(&entry.vf2).filter(|d| **d > 0) {
                let touch = own(DIGITS[digit - 1]).unwrap();
                assert!(touch.present && touch.trust >= 0.7, "{}", entry.name);
                assert!(!rule.can_do_without(entry, *digit));
            }
        }
        let hook = Taxonomy::feix().named("Fixed Hook").unwrap();
        assert!(rule.can_do_without(hook, 1) && !rule.can_do_without(hook, 3));
    }

    #[test]
    fn broken_rules_are_refused() {
        let told = |from: &str, to: &str, what: &str| {
            assert!(RULE.contains(from), "{from}");
            let error = Rule::parse(&RULE.replacen(from, to, 1)).unwrap_err();
            assert!(error.to_string().contains(what), "{error}");
        };
        told("number = 7", "number = 8", "exactly one entry");
        told("\"curl\"", "\"curly\"", "no fact is called \"curly\"");
        told("must = 0.95", "must = 1.95", "1.95 is not above 0");
        told("sharpness = 0.6", "sharpness = 0", "0 is not above 0");
        told("by_fit = 1.5", "by_fit = -1", "-1 is not between 0");
        told("= \"must\"", "= \"shall\"", "shall");
        told("either = [5]", "neither = [5]", "neither");
        assert_ne!(
            Rule::parse(&format!("{RULE}\n")).unwrap().version,
            Rule::standard().version
        );
    }
}
