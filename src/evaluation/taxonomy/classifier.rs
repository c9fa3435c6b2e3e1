//! Names the type of a grasp and explains the name.

use std::fmt::Write;

use super::anatomy::{Anatomy, Patch};
use super::features::{DIGITS, Features, TOUCHES};
use super::pose_correction::{PoseCorrection, readings};
use super::signature::{Rule, meaning, name};
use super::table::{Category, Form, GraspType, Opposition, Taxonomy, spell_digits};
use super::touch::{Held, TouchingPatch, held, ramp, touches};
use crate::hand::{Hand, PatchSide, PosedHand};
use crate::object::Object;

/// Number of features that an explanation lists on each side.
const LISTED: usize = 5;
/// Factor by which a size outside its range loses its whole score.
const SIZE_FACTOR: f64 = 1.8;

/// Result of the rule for a grasp.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// It is of this type.
    Listed(u8),
    /// Two types fit nearly as well. The number is that of the best type, whose cell is the result.
    Ambiguous(u8),
    /// No type fits well enough.
    Unlisted,
    /// The rule cannot be applied.
    NotApplicable(Inapplicable),
}

/// Why the taxonomy does not apply to a grasp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inapplicable {
    /// The hand is not built like a human one, see [`Anatomy::of`].
    Hand,
    /// Fewer than two parts of the hand touch the object.
    Touch,
}

impl Inapplicable {
    /// The reason as a clause.
    pub fn words(self) -> &'static str {
        match self {
            Self::Hand => {
                "the hand is not built like a human one: that takes a thumb, and three or four fingers, of at least two \
                 phalanges each"
            }
            Self::Touch => {
                "fewer than two parts of the hand (a digit, the palm, the edge between thumb and index finger) touch the object"
            }
        }
    }
}

/// A type and its score, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Number of the type.
    pub number: u8,
    /// Its score.
    pub score: f64,
}

/// A feature that supports or contradicts a type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Name of the feature.
    pub feature: &'static str,
    /// Meaning of the feature.
    pub meaning: &'static str,
    /// Measured value, 0 to 1.
    pub value: f64,
    /// Value that the type expects.
    pub target: f64,
    /// Weight in favour of (w(1 − |x − t|)) or against (w|x − t|) the type.
    pub pull: f64,
}

/// A label and the evidence for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// The outcome.
    pub verdict: Verdict,
    /// The three types that fit best, best first; fewer if the hand allows fewer types.
    pub best: Vec<Candidate>,
    /// The degree of each opposition, 0 to 1.
    pub oppositions: Vec<(Opposition, f64)>,
    /// Category that follows from the oppositions and the depth of contact.
    pub category: Option<Category>,
    /// Virtual fingers in contact, `1:2-4:5`; P is the palm.
    pub virtual_fingers: String,
    /// The form of the object where it is held.
    pub held: Option<Held>,
    /// Measured features by name; form and size depend on the type.
    pub features: Vec<(&'static str, f64)>,
    /// Evidence for the best type, most important first.
    pub support: Vec<Evidence>,
    /// Evidence against it.
    pub objections: Vec<Evidence>,
}

impl Label {
    fn not_applicable(why: Inapplicable) -> Self {
        Self {
            verdict: Verdict::NotApplicable(why),
            best: Vec::new(),
            oppositions: Vec::new(),
            category: None,
            virtual_fingers: String::new(),
            held: None,
            features: Vec::new(),
            support: Vec::new(),
            objections: Vec::new(),
        }
    }

    /// The type, if there is one.
    pub fn grasp_type(&self) -> Option<&'static GraspType> {
        match self.verdict {
            Verdict::Listed(number) => Taxonomy::feix().numbered(number),
            _ => None,
        }
    }

    /// The category of the type, or of the cell if the label is ambiguous.
    pub fn listed_category(&self) -> Option<Category> {
        match self.verdict {
            Verdict::Listed(number) | Verdict::Ambiguous(number) => {
                Some(Taxonomy::feix().numbered(number)?.category)
            }
            Verdict::Unlisted | Verdict::NotApplicable(_) => None,
        }
    }

    /// The label in files: name of the type, the cell if it is ambiguous, `unlisted` or `not_applicable`.
    pub fn text(&self) -> &'static str {
        let entry = |number| Taxonomy::feix().numbered(number);
        match self.verdict {
            Verdict::Listed(number) => entry(number).map_or("", |entry| entry.name.as_str()),
            Verdict::Ambiguous(number) => entry(number).map_or("", |entry| entry.cell.as_str()),
            Verdict::Unlisted => UNLISTED,
            Verdict::NotApplicable(_) => NOT_APPLICABLE,
        }
    }

    /// Score of the best type; 0 if no type can fit.
    fn score(&self) -> f64 {
        self.best.first().map_or(0.0, |best| best.score)
    }

    /// The best types with their scores: `Medium Wrap 0.912, Large Diameter 0.874, Power Sphere 0.803`.
    pub fn best_text(&self) -> String {
        let spell = |candidate: &Candidate| {
            let entry = Taxonomy::feix().numbered(candidate.number);
            format!(
                "{} {:.3}",
                entry.map_or("", |entry| &entry.name),
                candidate.score
            )
        };
        self.best.iter().map(spell).collect::<Vec<_>>().join(", ")
    }
}

/// Label in files of a grasp that no type fits.
pub const UNLISTED: &str = "unlisted";
/// Label in files of a grasp to which the taxonomy does not apply.
pub const NOT_APPLICABLE: &str = "not_applicable";

/// Labels the grasps of one hand on one object.
#[derive(Debug, Clone)]
pub struct Labeller<'a> {
    hand: &'a Hand,
    anatomy: Option<Anatomy>,
    object: &'a Object,
    rule: &'a Rule,
}

impl<'a> Labeller<'a> {
    /// Interprets the hand as a human one, if possible.
    pub fn new(hand: &'a Hand, object: &'a Object, rule: &'a Rule) -> Self {
        Self {
            hand,
            anatomy: Anatomy::of(hand),
            object,
            rule,
        }
    }

    /// Whether the taxonomy applies to the hand.
    pub fn applies(&self) -> bool {
        self.anatomy.is_some()
    }

    /// Labels the hand at pose `x = [t, q(wxyz), joints]`, object frame. Of its [`readings`] it uses the one that fits a
    /// type best.
    ///
    /// # Panics
    /// If `x` does not have 7 numbers more than the hand has joints.
    pub fn label(&self, x: &[f64]) -> Label {
        let Some(anatomy) = &self.anatomy else {
            return Label::not_applicable(Inapplicable::Hand);
        };
        let read = |x: Vec<f64>| {
            let mut posed = PosedHand::default();
            self.hand.pose(&x, &mut posed);
            let near = touches(self.hand, anatomy, &posed, self.object);
            let held = held(self.object, &near);
            let touches: Vec<TouchingPatch> = near.into_iter().map(|(touch, _)| touch).collect();
            label_contacts(self.rule, anatomy, &posed, &touches, held)
        };
        readings(self.hand, self.object, x, &PoseCorrection::default())
            .into_iter()
            .map(read)
            .max_by(|one, other| one.score().total_cmp(&other.score()))
            .unwrap_or_else(|| Label::not_applicable(Inapplicable::Touch))
    }
}

/// Labels a grasp from its contacts; `held` is the form of the object there, if known.
pub fn label_contacts(
    rule: &Rule,
    anatomy: &Anatomy,
    posed: &PosedHand,
    touches: &[TouchingPatch],
    held: Option<Held>,
) -> Label {
    let features = Features::of(anatomy, posed, touches, held.as_ref());
    let parts = DIGITS.iter().chain(["palm", "web"].iter());
    if parts.filter(|part| features.named(part) >= TOUCHES).count() < 2 {
        return Label::not_applicable(Inapplicable::Touch);
    }
    let taxonomy = Taxonomy::feix();
    let can = |entry: &&GraspType| {
        (1..=5).all(|digit| anatomy.has(digit) || rule.can_do_without(entry, digit))
    };
    let mut best: Vec<Candidate> = (taxonomy.types.iter())
        .filter(can)
        .map(|entry| Candidate {
            number: entry.number,
            score: score(rule, entry, &features, held.as_ref()),
        })
        .collect();
    best.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.number.cmp(&b.number)));
    best.truncate(3);
    let verdict = match best.as_slice() {
        [first, ..] if first.score < rule.unlisted_below => Verdict::Unlisted,
        [] => Verdict::Unlisted,
        [first, second, ..] if first.score - second.score < rule.ambiguous_within => {
            Verdict::Ambiguous(first.number)
        }
        [first, ..] => Verdict::Listed(first.number),
    };
    let first = best
        .first()
        .and_then(|first| taxonomy.numbered(first.number));
    let [support, objections] = first.map_or_else(Default::default, |entry| {
        evidence(rule, entry, &features, held.as_ref())
    });
    let oppositions = features.oppositions().to_vec();
    let opposition = strongest(&oppositions);
    Label {
        verdict,
        best,
        category: Some(category(opposition, &features)),
        virtual_fingers: virtual_fingers(opposition, &features, touches),
        oppositions,
        held,
        features: features.measured().collect(),
        support,
        objections,
    }
}

fn strongest(oppositions: &[(Opposition, f64)]) -> Opposition {
    let most = oppositions.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    most.map_or(Opposition::Palm, |(kind, _)| *kind)
}

/// The category that follows from the opposition and the depth of contact, for any type.
fn category(opposition: Opposition, features: &Features) -> Category {
    let web = features.named("web") >= TOUCHES && features.named("middle radial") >= TOUCHES;
    match opposition {
        Opposition::Side if web => Category::Precision,
        Opposition::Side => Category::Intermediate,
        Opposition::Pad if features.named("deep").max(features.named("palm")) < TOUCHES => {
            Category::Precision
        }
        Opposition::Palm | Opposition::Pad => Category::Power,
    }
}

fn virtual_fingers(
    opposition: Opposition,
    features: &Features,
    touches: &[TouchingPatch],
) -> String {
    let touching = |digit: &usize| features.named(DIGITS[digit - 1]) >= TOUCHES;
    let fingers: Vec<usize> = (2..=5).filter(touching).collect();
    let on_side = |digit: usize| {
        let share = |test: &dyn Fn(PatchSide) -> bool| -> f64 {
            let of_digit = touches.iter().filter(
                |touch| matches!(touch.patch, Patch::Digit(d, _, side) if d == digit && test(side)),
            );
            of_digit.map(|touch| touch.weight_mm2).sum()
        };
        share(&|side| matches!(side, PatchSide::Radial | PatchSide::Ulnar)) > 0.5 * share(&|_| true)
    };
    let thumb = touching(&1);
    let (first, second): (String, Vec<usize>) = match opposition {
        Opposition::Palm => ("P".to_owned(), fingers.clone()),
        Opposition::Pad => ("1".to_owned(), fingers.clone()),
        Opposition::Side if thumb => {
            let sides: Vec<usize> = fingers.iter().copied().filter(|d| on_side(*d)).collect();
            ("1".to_owned(), sides)
        }
        Opposition::Side => ("3".to_owned(), vec![2]),
    };
    let mut third: Vec<usize> = fingers;
    third.retain(|digit| !second.contains(digit) && first != digit.to_string());
    if thumb && first != "1" {
        third.insert(0, 1);
    }
    let spell = |digits: &[usize]| match digits {
        [] => "-".to_owned(),
        digits => spell_digits(digits),
    };
    format!("{first}:{}:{}", spell(&second), spell(&third))
}

/// The value of a feature for a type; form and size are compared with those that the type usually holds.
fn value(
    feature: usize,
    entry: &GraspType,
    features: &Features,
    held: Option<&Held>,
) -> Option<f64> {
    match name(feature) {
        "form" => held.map(|held| {
            let of = |form: &Form| held.forms[*form as usize];
            entry.forms.iter().map(of).sum::<f64>().min(1.0)
        }),
        "size" => {
            let ([low, high], held) = (entry.size_mm?, held?);
            let size = 1e3 * held.width_m;
            let miss = (low / size).max(size / high).max(1.0);
            Some(1.0 - ramp(miss.ln(), 0.0, SIZE_FACTOR.ln()))
        }
        _ => features.value(feature),
    }
}

/// s = (1 − Σ w|x − t| / Σ w) · Π over key features (1 − g|x − t|).
fn score(rule: &Rule, entry: &GraspType, features: &Features, held: Option<&Held>) -> f64 {
    let (mut missed, mut total, mut gates) = (0.0, 0.0, 1.0);
    for cue in &rule.cues[usize::from(entry.number) - 1] {
        let Some(value) = value(cue.feature, entry, features, held) else {
            continue;
        };
        let miss = (value - cue.target).abs();
        missed += cue.weight * miss;
        total += cue.weight;
        if cue.key {
            gates *= 1.0 - rule.gate * miss;
        }
    }
    if total > 0.0 {
        (1.0 - missed / total) * gates
    } else {
        0.0
    }
}

/// Evidence for and against a type, most important first.
fn evidence(
    rule: &Rule,
    entry: &GraspType,
    features: &Features,
    held: Option<&Held>,
) -> [Vec<Evidence>; 2] {
    [true, false].map(|for_it| {
        let cues = &rule.cues[usize::from(entry.number) - 1];
        let told = cues.iter().filter_map(|cue| {
            let value = value(cue.feature, entry, features, held)?;
            let miss = (value - cue.target).abs();
            Some(Evidence {
                feature: name(cue.feature),
                meaning: meaning(cue.feature),
                value,
                target: cue.target,
                pull: cue.weight * if for_it { 1.0 - miss } else { miss },
            })
        });
        let mut told: Vec<Evidence> = told.filter(|evidence| evidence.pull >= 0.005).collect();
        told.sort_by(|a, b| b.pull.total_cmp(&a.pull));
        told.truncate(LISTED);
        told
    })
}

/// The explanation of a label, in lines of text.
pub fn explain(label: &Label, rule: &Rule) -> String {
    let mut text = format!("label            {}\n", label.text());
    if let Verdict::NotApplicable(why) = label.verdict {
        let _ = writeln!(
            text,
            "                 the taxonomy does not apply: {}",
            why.words()
        );
        return text;
    }
    for (place, candidate) in label.best.iter().enumerate() {
        let entry = Taxonomy::feix().numbered(candidate.number);
        let (type_name, cell) = entry.map_or(("", ""), |entry| (&entry.name, &entry.cell));
        let head = if place == 0 { "best types" } else { "" };
        let _ = writeln!(
            text,
            "{head:<16} {:.3}  {:>2} {type_name} ({cell})",
            candidate.score, candidate.number
        );
    }
    let oppositions: Vec<String> = (label.oppositions.iter())
        .map(|(kind, degree)| format!("{} {degree:.2}", kind.name()))
        .collect();
    let _ = writeln!(text, "opposition       {}", oppositions.join(", "));
    let _ = writeln!(
        text,
        "category         {}",
        label.category.map_or("", Category::name)
    );
    let _ = writeln!(text, "virtual fingers  {}", label.virtual_fingers);
    if let Some(held) = &label.held {
        let forms = Form::ALL
            .iter()
            .zip(held.forms)
            .filter(|(_, share)| *share >= 0.05);
        let forms: Vec<String> = forms
            .map(|(form, share)| format!("{} {share:.2}", form.name()))
            .collect();
        let _ = writeln!(
            text,
            "held             {}, {:.1} mm wide",
            forms.join(", "),
            1e3 * held.width_m
        );
    }
    for (head, list) in [("for", &label.support), ("against", &label.objections)] {
        for (place, evidence) in list.iter().enumerate() {
            let head = if place == 0 { head } else { "" };
            let _ = writeln!(
                text,
                "{head:<16} {:.2}  {}: {:.2}, expected {:.2} ({})",
                evidence.pull, evidence.feature, evidence.value, evidence.target, evidence.meaning
            );
        }
    }
    let _ = writeln!(
        text,
        "rule             {}, unlisted below {}, ambiguous within {}",
        rule.version, rule.unlisted_below, rule.ambiguous_within
    );
    text
}
