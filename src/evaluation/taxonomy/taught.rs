//! The file of a labeller that was taught: its regression, what it was taught with, and how well it does.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::certainty::Certainty;
use super::learned::{
    Example, LeftOut, Regression, UNLISTED_CLASS, Unseen, answer, answer_among, class_name,
    leave_out, respects, sums,
};
use super::{Features, TaxonomyError};
use crate::agreement::bootstrap;

/// The first entry of a file.
const FORMAT: &str = "landscape labeller 1";
/// Fewer labels teach nothing that could be judged.
pub const LEAST_LABELS: usize = 30;
const DRAWS: usize = 2000;
const SEED: u64 = 59;
/// Bins of probabilities for the calibration error.
const BINS: usize = 5;
/// Category, cell and type.
const RESPECTS: [&str; 3] = ["category", "cell", "type"];

/// Grasps of one file that were learned from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaughtWith {
    /// Name of the file.
    pub file: String,
    /// Hash of its bytes, as in files of grasps.
    pub content_hash: String,
    /// Number of its grasps with a label that a person gave.
    pub labels: usize,
    /// Names of their hands.
    pub hands: Vec<String>,
    /// Names of their objects.
    pub objects: Vec<String>,
}

/// How often the labeller, the rule and the commonest answer are right about labels of a group that the labeller has not seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Judged {
    /// `category`, `cell` or `type`.
    pub name: String,
    /// Share that the labeller names right.
    pub labeller_share: f64,
    /// Its 95 % interval, by resampling of the groups.
    pub labeller_interval_share: [f64; 2],
    /// The same of the rule.
    pub rule_share: f64,
    /// Its 95 % interval.
    pub rule_interval_share: [f64; 2],
    /// The same of the class that is the commonest among the labels that were seen.
    pub commonest_share: f64,
    /// Share of the labeller less that of the rule.
    pub gain_share: f64,
    /// Its 95 % interval.
    pub gain_interval_share: [f64; 2],
    /// Expected calibration error of the labeller's probability (C. Guo et al., ICML 2017), five bins.
    pub calibration_error: f64,
}

/// Answers of one certainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OfCertainty {
    /// `category`, `cell` or `type`.
    pub name: String,
    /// `likely`, `open` or `a guess`.
    pub certainty: String,
    /// Number of answers.
    pub answers: usize,
    /// Share of them that is right.
    pub right_share: f64,
}

/// A labeller that was taught by labelled grasps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Taught {
    format: String,
    /// Version of the program that taught it.
    pub program_version: String,
    /// Version of the rule whose answers it weighs.
    pub rule: String,
    /// What it was taught with.
    pub taught_with: Vec<TaughtWith>,
    /// Number of labels of each type.
    pub labels: BTreeMap<String, usize>,
    /// What was left out at a time to judge it: `objects`, or `grasps` where there are fewer than three objects.
    pub tested_on_left_out: String,
    /// How well it does.
    pub judged: Vec<Judged>,
    /// What its certainties are worth.
    pub certainties: Vec<OfCertainty>,
    regression: Regression,
}

/// What every format has.
#[derive(Deserialize)]
struct Head {
    format: String,
}

/// Why nothing can be taught.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TeachError {
    /// There are too few labels.
    #[error(
        "{0} grasps of human-like hands have a label that a person gave; at least {LEAST_LABELS} are needed"
    )]
    TooFew(usize),
    /// All labels are the same.
    #[error("all labels are `{0}`; at least two types are needed")]
    OneClass(&'static str),
}

impl Taught {
    /// Teaches a labeller; `rule` is the version of the rule.
    ///
    /// # Errors
    /// If there are fewer than 30 examples, or all have one class.
    pub fn of(
        examples: &[Example],
        taught_with: Vec<TaughtWith>,
        rule: &str,
    ) -> Result<Self, TeachError> {
        if examples.len() < LEAST_LABELS {
            return Err(TeachError::TooFew(examples.len()));
        }
        let first = examples[0].class;
        if examples.iter().all(|example| example.class == first) {
            return Err(TeachError::OneClass(class_name(first)));
        }
        let mut labels = BTreeMap::new();
        for example in examples {
            *labels
                .entry(class_name(example.class).to_owned())
                .or_default() += 1;
        }
        let left_out = leave_out(examples);
        let answers = Answers::of(examples, &left_out);
        Ok(Self {
            format: FORMAT.to_owned(),
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            rule: rule.to_owned(),
            taught_with,
            labels,
            tested_on_left_out: if left_out.by_groups {
                "objects"
            } else {
                "grasps"
            }
            .to_owned(),
            judged: judged(&answers),
            certainties: certainties(&answers),
            regression: Regression::of(examples),
        })
    }

    /// Reads a labeller.
    ///
    /// # Errors
    /// If the text is not one.
    pub fn parse(text: &str) -> Result<Self, TaxonomyError> {
        let refuse = TaxonomyError::Labeller;
        let unread = |error: serde_json::Error| refuse(error.to_string());
        // First, because another format may have other fields.
        let Head { format } = serde_json::from_str(text).map_err(unread)?;
        if format != FORMAT {
            return Err(refuse(format!(
                "its format is `{format}`, but `{FORMAT}` is needed"
            )));
        }
        let read: Self = serde_json::from_str(text).map_err(unread)?;
        read.regression.check().map_err(refuse)?;
        Ok(read)
    }

    /// The text of its file.
    pub fn text(&self) -> String {
        // A list of numbers on one line each: short, and differences can be read.
        let value = serde_json::to_value(self).unwrap_or_default();
        let mut text = String::new();
        lines(&mut text, &value, 0);
        text.push('\n');
        text
    }

    /// Number of labels that it has seen.
    pub fn count(&self) -> usize {
        self.labels.values().sum()
    }

    /// The probability of each class: the 33 types, then `unlisted`.
    ///
    /// # Errors
    /// If the grasp is unlike all that was seen.
    pub fn probabilities(&self, features: &Features, rule: &[f64]) -> Result<Vec<f64>, Unseen> {
        self.regression.probabilities(features, rule)
    }
}

/// JSON in which lists of numbers, and objects without lists, stand on one line.
fn lines(text: &mut String, value: &serde_json::Value, indent: usize) {
    use serde_json::Value;
    let deep = |value: &Value| value.is_array() || value.is_object();
    let (items, [open, close]): (Vec<(String, &Value)>, [char; 2]) = match value {
        Value::Array(items) if items.iter().any(deep) => (
            items.iter().map(|item| (String::new(), item)).collect(),
            ['[', ']'],
        ),
        Value::Object(entries) if entries.values().any(deep) => (
            (entries.iter())
                .map(|(name, item)| (format!("{}: ", Value::from(name.as_str())), item))
                .collect(),
            ['{', '}'],
        ),
        value => return *text += &value.to_string(),
    };
    text.push(open);
    for (place, (name, item)) in items.into_iter().enumerate() {
        *text += if place == 0 { "\n" } else { ",\n" };
        *text += &" ".repeat(indent + 1);
        *text += &name;
        lines(text, item, indent + 1);
    }
    text.push('\n');
    *text += &" ".repeat(indent);
    text.push(close);
}

/// Shares of right answers, and probabilities of them, in all three respects.
struct Answers {
    /// Of each respect, whether each example is named right: by the labeller, by the rule, by the commonest class.
    right: Vec<[Vec<bool>; 3]>,
    /// Of each respect, the labeller's probability of its answer.
    certain: Vec<Vec<f64>>,
    /// Examples that are left out, and drawn, together.
    groups: Vec<Vec<usize>>,
}

impl Answers {
    fn of(examples: &[Example], left_out: &LeftOut) -> Self {
        let mut groups: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (i, example) in examples.iter().enumerate() {
            let group = if left_out.by_groups {
                example.group.clone()
            } else {
                i.to_string()
            };
            groups.entry(group).or_default().push(i);
        }
        let labeller: Vec<usize> = (left_out.probabilities.iter())
            .map(|told| answer(told))
            .collect();
        // Where nobody says `unlisted`, the rule's best guess counts.
        let may_be_unlisted = examples.iter().any(|e| e.class == UNLISTED_CLASS);
        let rule: Vec<usize> = (examples.iter())
            .map(|example| rule_answer(&example.rule, may_be_unlisted))
            .collect();
        let (mut right, mut certain) = (Vec::new(), Vec::new());
        for numbers in respects() {
            let is_right = |answers: &[usize]| -> Vec<bool> {
                let own = answers.iter().zip(examples);
                own.map(|(answer, e)| numbers[*answer] == numbers[e.class])
                    .collect()
            };
            right.push([&labeller, &rule, &left_out.commonest].map(|answers| is_right(answers)));
            let own = labeller.iter().zip(&left_out.probabilities);
            certain.push(
                own.map(|(answer, told)| sums(told, &numbers)[numbers[*answer]])
                    .collect(),
            );
        }
        Self {
            right,
            certain,
            groups: groups.into_values().collect(),
        }
    }

    /// The mean of a number of each example, and its 95 % interval by resampling of the groups.
    fn mean(&self, of: impl Fn(usize) -> f64 + Sync) -> (f64, [f64; 2]) {
        let over = |groups: &[usize]| {
            let members = || groups.iter().flat_map(|group| &self.groups[*group]);
            members().map(|i| of(*i)).sum::<f64>() / members().count() as f64
        };
        let all: Vec<usize> = (0..self.groups.len()).collect();
        let drawn = bootstrap(&vec![0; all.len()], DRAWS, SEED, over);
        (over(&all), drawn.interval(0.95))
    }
}

/// The rule's answer: it chooses the category first, then the type.
fn rule_answer(rule: &[f64], may_be_unlisted: bool) -> usize {
    let [categories, ..] = respects();
    let can = |category| may_be_unlisted || category != UNLISTED_CLASS;
    let category = answer_among(&sums(rule, &categories), can);
    answer_among(rule, |class| categories[class] == category)
}

fn judged(answers: &Answers) -> Vec<Judged> {
    let number = |is: bool| f64::from(u8::from(is));
    let judged = |(place, name): (usize, &str)| {
        let [labeller, rule, commonest] = &answers.right[place];
        let (labeller_share, labeller_interval_share) = answers.mean(|i| number(labeller[i]));
        let (rule_share, rule_interval_share) = answers.mean(|i| number(rule[i]));
        let (gain_share, gain_interval_share) =
            answers.mean(|i| number(labeller[i]) - number(rule[i]));
        Judged {
            name: name.to_owned(),
            labeller_share,
            labeller_interval_share,
            rule_share,
            rule_interval_share,
            commonest_share: answers.mean(|i| number(commonest[i])).0,
            gain_share,
            gain_interval_share,
            calibration_error: calibration_error(&answers.certain[place], labeller),
        }
    };
    RESPECTS.into_iter().enumerate().map(judged).collect()
}

/// The mean over answers of |mean probability − share right| of their bin.
fn calibration_error(certain: &[f64], right: &[bool]) -> f64 {
    let mut bins = [(0.0_f64, 0.0_f64); BINS];
    for (p, right) in certain.iter().zip(right) {
        let above = (1..BINS).filter(|k| p * BINS as f64 >= *k as f64).count();
        bins[above].0 += p;
        bins[above].1 += f64::from(u8::from(*right));
    }
    bins.iter().map(|(p, right)| (p - right).abs()).sum::<f64>() / certain.len() as f64
}

fn certainties(answers: &Answers) -> Vec<OfCertainty> {
    let mut certainties = Vec::new();
    for (place, name) in RESPECTS.into_iter().enumerate() {
        for certainty in Certainty::ALL {
            let own = answers.certain[place].iter().zip(&answers.right[place][0]);
            let own = own.filter(|(p, _)| Certainty::of(**p) == certainty);
            let right: Vec<bool> = own.map(|(_, right)| *right).collect();
            if !right.is_empty() {
                certainties.push(OfCertainty {
                    name: name.to_owned(),
                    certainty: certainty.name().to_owned(),
                    answers: right.len(),
                    right_share: right.iter().filter(|right| **right).count() as f64
                        / right.len() as f64,
                });
            }
        }
    }
    certainties
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::evaluation::taxonomy::learned::tests::planted;

    fn taught() -> Taught {
        let with = TaughtWith {
            file: "grasps.parquet".to_owned(),
            content_hash: "c0de".to_owned(),
            labels: 60,
            hands: vec!["human".to_owned()],
            objects: Vec::new(),
        };
        Taught::of(&planted(60, true), vec![with], "a rule").unwrap()
    }

    #[test]
    fn a_labeller_is_judged_on_objects_that_it_has_not_seen() {
        let taught = taught();
        assert_eq!(taught.tested_on_left_out, "objects");
        let labels = [("Large Diameter", 20), ("Tripod", 20), ("unlisted", 20)];
        let labels = labels.map(|(name, count)| (name.to_owned(), count));
        assert_eq!(taught.labels, BTreeMap::from(labels));
        let names: Vec<&str> = taught.judged.iter().map(|own| own.name.as_str()).collect();
        assert_eq!(names, RESPECTS);
        for judged in &taught.judged {
            assert!(judged.labeller_share >= 0.95, "{judged:?}");
            assert!(judged.gain_interval_share[0] > 0.3, "{judged:?}");
            let own = (taught.certainties.iter()).filter(|own| own.name == judged.name);
            assert_eq!(own.map(|own| own.answers).sum::<usize>(), 60);
        }
        // Of noise it is not shown that the labeller is better.
        let taught = Taught::of(&planted(120, false), Vec::new(), "a rule").unwrap();
        for judged in &taught.judged {
            assert!(judged.gain_interval_share[0] <= 0.0, "{judged:?}");
        }
    }

    #[test]
    fn single_grasps_are_left_out_where_there_are_fewer_than_three_objects() {
        let mut examples = planted(40, true);
        for (i, example) in examples.iter_mut().enumerate() {
            example.group = format!("object {}", i % 2);
        }
        let taught = Taught::of(&examples, Vec::new(), "a rule").unwrap();
        assert_eq!(taught.tested_on_left_out, "grasps");
    }

    #[test]
    fn too_little_to_learn_from_is_refused() {
        let refused = |examples: &[Example]| Taught::of(examples, Vec::new(), "").unwrap_err();
        let mut examples = planted(LEAST_LABELS, true);
        assert_eq!(refused(&examples[1..]), TeachError::TooFew(29));
        assert!(Taught::of(&examples, Vec::new(), "").is_ok());
        for example in &mut examples {
            example.class = 13;
        }
        assert_eq!(refused(&examples), TeachError::OneClass("Tripod"));
    }

    #[test]
    fn files_are_read_as_they_were_written() {
        let taught = taught();
        let text = taught.text();
        let read = Taught::parse(&text).unwrap();
        assert_eq!(read, taught);
        assert_eq!(read.text(), text);
        let coefficients = |line: &&str| line.contains("\"coefficients\": [");
        let line = text.lines().find(coefficients).unwrap();
        assert!(line.matches(',').count() >= 19, "in one line: {line}");
    }

    #[test]
    fn broken_files_are_refused() {
        let refused = |text: &str| {
            let said = Taught::parse(text).unwrap_err().to_string();
            let start = "this is not a labeller that `landscape label --learn` wrote: ";
            said.strip_prefix(start).expect(&said).to_owned()
        };
        let text = taught().text();
        for (text, words) in [
            ("", "EOF"),
            ("{}", "missing field `format`"),
            (&text[..text.len() / 2], "at line"),
            (
                &text.replace("\"ridge\":", "\"ridge\":NaN,\"a\":"),
                "expected",
            ),
            (
                &text.replace("labeller 1", "labeller 2"),
                "`landscape labeller 2`",
            ),
        ] {
            let said = refused(text);
            assert!(said.contains(words), "{words}: {said}");
        }
        let edits: [(&[&str], Value, &str); 8] = [
            (&["more"], json!(1), "unknown field `more`"),
            (&["regression", "classes"], json!([]), "it has no classes"),
            (
                &["regression", "classes", "0", "name"],
                json!("Grab"),
                "no grasp type is called `Grab`",
            ),
            (
                &["regression", "classes", "0", "coefficients"],
                json!([0.5]),
                "`Large Diameter` has 1 coefficients for 20 features",
            ),
            (
                &["regression", "classes", "1", "coefficients", "3"],
                json!(1e155),
                "1e155 is not from -1e9 to 1e9",
            ),
            (
                &["regression", "classes", "1", "share"],
                Value::Null,
                "null",
            ),
            (
                &["regression", "choice", "sharpness"],
                json!(40.0),
                "40 is not from 0 to 10",
            ),
            (
                &["regression", "features", "3", "deviation"],
                json!(0.0),
                "0 is not from 0.001 to 1e9",
            ),
        ];
        for (path, value, words) in edits {
            let mut edited: Value = serde_json::from_str(&text).unwrap();
            let mut place = &mut edited;
            for part in path {
                place = match part.parse::<usize>() {
                    Ok(row) => &mut place[row],
                    Err(_) => &mut place[*part],
                };
            }
            *place = value;
            let said = refused(&edited.to_string());
            assert!(said.contains(words), "{words}: {said}");
        }
    }
}
