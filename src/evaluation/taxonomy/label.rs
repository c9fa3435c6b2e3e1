//! Names the type of a grasp.

use super::anatomy::{Anatomy, Patch, Unlike};
use super::certainty::Certainty;
use super::decision::{Answer, Evidence, Fits, evidence};
use super::facts::{DIGITS, Facts, TOUCHES};
use super::features::{Features, features};
use super::form::{Held, held, held_by_contacts};
use super::learned::{self, UNLISTED_CLASS, Unseen, rule_classes};
use super::pose_correction::{PoseCorrection, readings};
use super::rule::Rule;
use super::table::{Category, GraspType, Opposition, Taxonomy, spell_digits};
use super::touch::{TouchingPatch, touches};
use crate::hand::{Hand, PatchSide, PosedHand};
use crate::object::Object;

/// Result of the rule for a grasp.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// It is of this type.
    Listed(u8),
    /// Types of one cell fit nearly as well. The number is that of the best type, whose cell is the result.
    Ambiguous(u8),
    /// Cells of one category fit nearly as well. The number is that of the best type, whose category is the result.
    Broad(u8),
    /// Contact contradicts every type.
    Unlisted,
    /// The rule cannot be applied.
    NotApplicable(Inapplicable),
}

/// Why the taxonomy does not apply to a grasp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inapplicable {
    /// The hand is not built like a human one, see [`Anatomy::of`].
    Hand(Unlike),
    /// Fewer than two parts of the hand touch the object.
    Touch,
}

impl Inapplicable {
    /// The reason as a clause.
    pub fn words(self) -> String {
        match self {
            Self::Hand(why) => format!("the hand is not built like a human one: {why}"),
            Self::Touch => {
                "fewer than two parts of the hand (a digit, the palm, the edge between thumb and index finger) touch the \
                 object"
                    .to_owned()
            }
        }
    }
}

/// A type and its probability.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Number of the type.
    pub number: u8,
    /// Its probability among all types, 0 to 1.
    pub score: f64,
}

/// A label and the evidence for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// The outcome.
    pub verdict: Verdict,
    /// Three types: the answer, then those that fit best of the others; fewer if the hand allows fewer types.
    pub best: Vec<Candidate>,
    /// The probability of every type, by number; 0 for those that the hand cannot do.
    pub types: Vec<Candidate>,
    /// How well the type that fits best fits, 0 to 1.
    pub fit: f64,
    /// The degree of each opposition, 0 to 1.
    pub oppositions: Vec<(Opposition, f64)>,
    /// The probability of each category.
    pub categories: Vec<(Category, f64)>,
    /// The most probable category.
    pub category: Option<Category>,
    /// The probability of the answer's cell.
    pub cell_probability: f64,
    /// How far category, cell and type of the answer can be trusted.
    pub certainty: [Certainty; 3],
    /// Virtual fingers in contact, `1:2-4:5`; P is the palm.
    pub virtual_fingers: String,
    /// The part of the object that is held.
    pub held: Option<Held>,
    /// Measured facts by name; form and size depend on the type.
    pub facts: Vec<(&'static str, f64)>,
    /// What the answer expects and finds, most important first.
    pub support: Vec<Evidence>,
    /// What the answer expects and does not find.
    pub objections: Vec<Evidence>,
    /// What the next type of the answer's category expects and does not find.
    pub against_next: Vec<Evidence>,
    /// Whether a labeller that was taught named the grasp. What was measured, and the reasons, are the rule's all the same.
    pub by: By,
}

/// What named a grasp.
#[derive(Debug, Clone, PartialEq)]
pub enum By {
    /// The rule.
    Rule,
    /// A labeller that was taught; the rule would have named the grasp like this.
    Taught(Box<Label>),
    /// The rule, because the grasp is unlike all that the labeller has seen.
    Instead(Unseen),
}

impl Label {
    fn not_applicable(why: Inapplicable) -> Self {
        Self {
            verdict: Verdict::NotApplicable(why),
            best: Vec::new(),
            types: Vec::new(),
            fit: 0.0,
            oppositions: Vec::new(),
            categories: Vec::new(),
            category: None,
            cell_probability: 0.0,
            certainty: [Certainty::Guess; 3],
            virtual_fingers: String::new(),
            held: None,
            facts: Vec::new(),
            support: Vec::new(),
            objections: Vec::new(),
            against_next: Vec::new(),
            by: By::Rule,
        }
    }

    /// The same grasp as a labeller that was taught names it, with these probabilities of the classes. As by the rule, the
    /// label is the cell or the category where types or cells are close.
    fn taught(self, classes: &[f64], rule: &Rule) -> Self {
        let answer = learned::answer(classes);
        let number = |class: usize| u8::try_from(class + 1).unwrap_or_default();
        let types: Vec<Candidate> = (0..UNLISTED_CLASS)
            .map(|class| Candidate {
                number: number(class),
                score: classes[class],
            })
            .collect();
        let sum = |test: &dyn Fn(&GraspType) -> bool| -> f64 {
            let own = Taxonomy::feix().types.iter().zip(classes);
            own.filter(|(entry, _)| test(entry)).map(|(_, p)| p).sum()
        };
        let categories: Vec<(Category, f64)> = self
            .categories
            .iter()
            .map(|(category, _)| (*category, sum(&|entry| entry.category == *category)))
            .collect();
        let mut ranked = types.clone();
        ranked.sort_by(|a, b| b.score.total_cmp(&a.score));
        let entry = Taxonomy::feix().types.get(answer);
        let most = categories.iter().rev().max_by(|a, b| a.1.total_cmp(&b.1));
        let category = match entry {
            Some(entry) => Some(entry.category),
            None => most.map(|(category, _)| *category),
        };
        let of_category = sum(&|other| Some(other.category) == category);
        let of_cell = entry.map_or(0.0, |entry| sum(&|other| other.cell == entry.cell));
        if entry.is_some() {
            ranked.sort_by_key(|candidate| candidate.number != number(answer));
        }
        ranked.truncate(self.best.len().max(3));
        let verdict = match () {
            () if entry.is_none() => Verdict::Unlisted,
            () if of_cell < rule.cell_share * of_category => Verdict::Broad(number(answer)),
            () if classes[answer] < rule.type_share * of_cell => Verdict::Ambiguous(number(answer)),
            () => Verdict::Listed(number(answer)),
        };
        let told = [of_category, of_cell, classes[answer]];
        Self {
            verdict,
            best: ranked,
            types,
            categories,
            category,
            cell_probability: of_cell,
            certainty: told.map(Certainty::of),
            by: By::Taught(Box::new(self.clone())),
            ..self
        }
    }

    /// The type, if there is one.
    pub fn grasp_type(&self) -> Option<&'static GraspType> {
        match self.verdict {
            Verdict::Listed(number) => Taxonomy::feix().numbered(number),
            _ => None,
        }
    }

    /// The cell, if the label is a type or a cell.
    pub fn listed_cell(&self) -> Option<&'static str> {
        match self.verdict {
            Verdict::Listed(number) | Verdict::Ambiguous(number) => {
                Some(Taxonomy::feix().numbered(number)?.cell.as_str())
            }
            _ => None,
        }
    }

    /// The category, if the label is a type, a cell or a category.
    pub fn listed_category(&self) -> Option<Category> {
        match self.verdict {
            Verdict::Listed(number) | Verdict::Ambiguous(number) | Verdict::Broad(number) => {
                Some(Taxonomy::feix().numbered(number)?.category)
            }
            Verdict::Unlisted | Verdict::NotApplicable(_) => None,
        }
    }

    /// The label in files: name of the type, the cell or the category if it is no more certain, `unlisted` or
    /// `not_applicable`.
    pub fn text(&self) -> &'static str {
        let entry = |number| Taxonomy::feix().numbered(number);
        match self.verdict {
            Verdict::Listed(number) => entry(number).map_or("", |entry| entry.name.as_str()),
            Verdict::Ambiguous(number) => entry(number).map_or("", |entry| entry.cell.as_str()),
            Verdict::Broad(number) => entry(number).map_or("", |entry| entry.category.name()),
            Verdict::Unlisted => UNLISTED,
            Verdict::NotApplicable(_) => NOT_APPLICABLE,
        }
    }

    /// The answer and the two most probable other types of its category, most probable first. The rule chooses the category
    /// before the type, so that a type of another category may be more probable than the answer ([`Label::rival`]).
    pub fn of_category(&self) -> Vec<Candidate> {
        let mut own: Vec<Candidate> = self.types_where(|category| Some(category) == self.category);
        // The answer stands first among equals.
        let answer = self.best.first().map(|best| best.number);
        own.sort_by_key(|candidate| Some(candidate.number) != answer);
        own.sort_by(|a, b| b.score.total_cmp(&a.score));
        own.truncate(3);
        own
    }

    /// The most probable type of the other categories.
    pub fn rival(&self) -> Option<Candidate> {
        let others = self.types_where(|category| Some(category) != self.category);
        others
            .into_iter()
            .rev()
            .max_by(|a, b| a.score.total_cmp(&b.score))
    }

    /// The types with a probability whose category is chosen, by number.
    fn types_where(&self, chosen: impl Fn(Category) -> bool) -> Vec<Candidate> {
        let types = self.types.iter().copied();
        let is_chosen = |candidate: &Candidate| {
            let entry = Taxonomy::feix().numbered(candidate.number);
            candidate.score > 0.0 && entry.is_some_and(|entry| chosen(entry.category))
        };
        types.filter(is_chosen).collect()
    }

    /// [`Label::of_category`] in words: `Medium Wrap (open), Large Diameter, Power Sphere`. The first is the answer, with its
    /// certainty.
    pub fn best_text(&self) -> String {
        let spell = |(place, candidate): (usize, &Candidate)| {
            let entry = Taxonomy::feix().numbered(candidate.number);
            let name = entry.map_or("", |entry| &entry.name);
            match place {
                0 => format!("{name} ({})", self.certainty[2].name()),
                _ => name.to_owned(),
            }
        };
        let own = self.of_category();
        own.iter()
            .enumerate()
            .map(spell)
            .collect::<Vec<_>>()
            .join(", ")
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
    anatomy: Result<Anatomy, Unlike>,
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
        self.anatomy.is_ok()
    }

    /// Why the taxonomy does not apply to the hand, if so.
    pub fn inapplicable(&self) -> Option<Inapplicable> {
        self.anatomy.as_ref().err().copied().map(Inapplicable::Hand)
    }

    /// Labels the hand at pose `x = [t, q(wxyz), joints]`, object frame. The probability of a type is half that of the pose
    /// as it is and half the mean over its [`readings`].
    ///
    /// # Panics
    /// If `x` does not have 7 numbers more than the hand has joints.
    pub fn label(&self, x: &[f64]) -> Label {
        let anatomy = match &self.anatomy {
            Ok(anatomy) => anatomy,
            Err(why) => return Label::not_applicable(Inapplicable::Hand(*why)),
        };
        let read = |x: &Vec<f64>| {
            let mut posed = PosedHand::default();
            self.hand.pose(x, &mut posed);
            let touches = touches(self.hand, anatomy, &posed, self.object);
            let held = held(self.object, &touches, &anatomy.palm_axes(&posed).volar);
            Reading::of(self.rule, anatomy, &posed, &touches, held)
        };
        let asked = x.to_vec();
        let mut poses = readings(self.hand, self.object, x, &PoseCorrection::default());
        poses.retain(|pose| *pose != asked);
        let as_posed = read(&asked);
        let corrected: Vec<Reading> = poses.iter().filter_map(read).collect();
        let label = named(self.rule, as_posed.as_ref(), &corrected);
        let Some(taught) = &self.rule.taught else {
            return label;
        };
        let Some((features, classes)) = self.example(x, &label) else {
            return label;
        };
        match taught.probabilities(&features, &classes) {
            Ok(told) => label.taught(&told, self.rule),
            Err(unseen) => Label {
                by: By::Instead(unseen),
                ..label
            },
        }
    }

    /// What a labeller can learn from the grasp at pose `x`, whose label by the rule is `label`: its features, and the rule's
    /// probabilities of the 33 types and of `unlisted`. `None` where the taxonomy does not apply.
    ///
    /// # Panics
    /// If `x` does not have 7 numbers more than the hand has joints.
    pub fn example(&self, x: &[f64], label: &Label) -> Option<(Features, Vec<f64>)> {
        let anatomy = self.anatomy.as_ref().ok()?;
        if let Verdict::NotApplicable(_) = label.verdict {
            return None;
        }
        let mut posed = PosedHand::default();
        self.hand.pose(x, &mut posed);
        let features = features(label, anatomy, &posed, self.object);
        Some((features, rule_classes(label)))
    }
}

/// Labels a grasp from its contacts; `held` is the form of the object there. If that is not known, the contacts tell it as far
/// as they can.
pub fn label_contacts(
    rule: &Rule,
    anatomy: &Anatomy,
    posed: &PosedHand,
    touches: &[TouchingPatch],
    held: Option<Held>,
) -> Label {
    let volar = anatomy.palm_axes(posed).volar;
    let held = held.or_else(|| held_by_contacts(touches, &volar));
    let reading = Reading::of(rule, anatomy, posed, touches, held);
    named(rule, reading.as_ref(), &[])
}

/// A pose that is measured and compared with all types.
struct Reading {
    facts: Facts,
    held: Option<Held>,
    virtual_fingers: String,
    fits: Fits,
}

impl Reading {
    /// `None` if fewer than two parts of the hand touch.
    fn of(
        rule: &Rule,
        anatomy: &Anatomy,
        posed: &PosedHand,
        touches: &[TouchingPatch],
        held: Option<Held>,
    ) -> Option<Self> {
        let facts = Facts::of(anatomy, posed, touches, held.as_ref());
        let parts = DIGITS.iter().chain(["palm", "web"].iter());
        parts.filter(|part| facts.named(part) >= TOUCHES).nth(1)?;
        let opposition = strongest(&facts.oppositions());
        Some(Self {
            fits: Fits::of(rule, anatomy, &facts, held.as_ref()),
            virtual_fingers: virtual_fingers(opposition, &facts, touches),
            facts,
            held,
        })
    }
}

/// The label of a pose and its readings.
fn named(rule: &Rule, as_posed: Option<&Reading>, corrected: &[Reading]) -> Label {
    let posed = as_posed.map(|reading| &reading.fits);
    let fits: Vec<&Fits> = corrected.iter().map(|reading| &reading.fits).collect();
    let Some(answer) = Answer::of(posed, &fits, rule.sharpness) else {
        return Label::not_applicable(Inapplicable::Touch);
    };
    let shown = as_posed.into_iter().chain(corrected).reduce(|best, other| {
        if other.fits.best() > best.fits.best() {
            other
        } else {
            best
        }
    });
    let Some(shown) = shown else {
        return Label::not_applicable(Inapplicable::Touch);
    };
    let told = |candidate: Option<&Candidate>, found: bool| {
        let entry = candidate.and_then(|c| Taxonomy::feix().numbered(c.number));
        entry.map_or_else(Vec::new, |entry| {
            evidence(rule, entry, &shown.facts, shown.held.as_ref(), found)
        })
    };
    let mut label = Label {
        verdict: answer.verdict(rule),
        certainty: Certainty::of_rule(rule, &answer),
        by: By::Rule,
        support: told(answer.best.first(), true),
        objections: told(answer.best.first(), false),
        against_next: Vec::new(),
        best: answer.best,
        types: answer.types,
        fit: answer.fit,
        oppositions: shown.facts.oppositions().to_vec(),
        category: answer.category,
        categories: answer.categories,
        cell_probability: answer.cell_probability,
        facts: shown.facts.measured().collect(),
        virtual_fingers: shown.virtual_fingers.clone(),
        held: shown.held.clone(),
    };
    label.against_next = told(label.of_category().get(1), false);
    label
}

fn strongest(oppositions: &[(Opposition, f64)]) -> Opposition {
    let most = oppositions.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    most.map_or(Opposition::Palm, |(kind, _)| *kind)
}

fn virtual_fingers(opposition: Opposition, facts: &Facts, touches: &[TouchingPatch]) -> String {
    let touching = |digit: &usize| facts.named(DIGITS[digit - 1]) >= TOUCHES;
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
