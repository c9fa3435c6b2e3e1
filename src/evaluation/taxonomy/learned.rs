//! A labeller that is taught by labelled grasps: a ridge regression whose answer is weighed with that of the rule.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::features::Features;
use super::label::{Label, UNLISTED, Verdict};
use super::table::Taxonomy;
use crate::limits::{LABELLER_DEVIATION, LABELLER_EXPONENT, LABELLER_NUMBER, Limit};

/// Number of classes: the 33 types, then `unlisted`.
pub(super) const CLASSES: usize = 34;
/// Class of a grasp of no type.
pub const UNLISTED_CLASS: usize = CLASSES - 1;
/// The rule's probability of `unlisted` where it says so.
const RULE_UNLISTED: f64 = 0.5;
/// Added to scores and to the rule's probabilities, so that neither alone excludes a class.
const LEAST_SCORE: f64 = 0.02;
const LEAST_RULE: f64 = 0.01;
/// What is tried: ridges, exponents of the scores, exponents of the rule's probabilities.
const RIDGES: [f64; 4] = [10.0, 30.0, 100.0, 300.0];
const SHARPNESS: [f64; 3] = [1.0, 1.5, 2.0];
const TRUST: [f64; 4] = [0.0, 0.3, 0.6, 1.0];
/// A feature needs this share of the examples.
const KNOWN: f64 = 0.5;
/// Least deviation of a feature: what is nearly constant is no more than that.
const LEAST_DEVIATION: f64 = 1e-3;
/// A grasp is unlike all that a labeller has seen where more than this share of the features is missing, or lies farther
/// outside the range that was seen than so many deviations.
const MISSING: f64 = 0.1;
const OUTSIDE: f64 = 0.05;
const BEYOND: f64 = 0.5;
/// Greatest numbers of parts into which examples are divided: to judge, and to choose.
const PARTS: usize = 30;
const PARTS_TO_CHOOSE: usize = 10;

/// A grasp with a label.
#[derive(Debug, Clone)]
pub struct Example {
    /// Examples of one group are left out together: those of one object.
    pub group: String,
    /// What can be measured of it.
    pub features: Features,
    /// The rule's probability of each class: the 33 types by number, then `unlisted`.
    pub rule: Vec<f64>,
    /// The class that a person gave it: number of the type − 1, or [`UNLISTED_CLASS`].
    pub class: usize,
}

/// The rule's probability of each class.
pub(super) fn rule_classes(label: &Label) -> Vec<f64> {
    let unlisted = match label.verdict {
        Verdict::Unlisted => RULE_UNLISTED,
        _ => 0.0,
    };
    let mut classes = vec![0.0; CLASSES];
    for candidate in &label.types {
        classes[usize::from(candidate.number) - 1] = (1.0 - unlisted) * candidate.score;
    }
    classes[UNLISTED_CLASS] = unlisted;
    classes
}

/// Category, cell and class of each class, numbered; `unlisted` is a category and a cell of its own.
pub(super) fn respects() -> [Vec<usize>; 3] {
    let types = || Taxonomy::feix().types.iter();
    let numbered = |names: Vec<String>| -> Vec<usize> {
        let place = |name: &String| names.iter().position(|known| known == name);
        let mut places: Vec<usize> = names.iter().filter_map(place).collect();
        places.push(UNLISTED_CLASS);
        places
    };
    [
        numbered(types().map(|e| e.category.name().to_owned()).collect()),
        numbered(types().map(|e| e.cell.clone()).collect()),
        (0..CLASSES).collect(),
    ]
}

/// The answer: the class of the greatest probability in the cell of the greatest probability.
pub fn answer(probabilities: &[f64]) -> usize {
    let [_, cells, _] = respects();
    let cell = answer_among(&sums(probabilities, &cells), |_| true);
    answer_among(probabilities, |class| cells[class] == cell)
}

/// The first of the greatest values among some.
pub(super) fn answer_among(values: &[f64], among: impl Fn(usize) -> bool) -> usize {
    let own = (0..values.len()).filter(|place| among(*place));
    // Of equal values the last one of the reverse, which is the first.
    own.rev()
        .max_by(|a, b| values[*a].total_cmp(&values[*b]))
        .unwrap_or(0)
}

/// Sums of the probabilities of the classes that share a number.
pub(super) fn sums(probabilities: &[f64], numbers: &[usize]) -> Vec<f64> {
    let mut sums = vec![0.0; CLASSES];
    for (p, number) in probabilities.iter().zip(numbers) {
        sums[*number] += p;
    }
    sums
}

/// A feature, and what was seen of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Scale {
    name: String,
    mean: f64,
    deviation: f64,
    low: f64,
    high: f64,
}

/// What the left-out parts chose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Choice {
    /// Weight of the squares of the coefficients.
    ridge: f64,
    /// Exponent of the scores.
    sharpness: f64,
    /// Exponent of the rule's probabilities.
    trust_in_rule: f64,
}

/// Coefficients of one class.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Weights {
    /// The class, in files by its name.
    #[serde(rename = "name", with = "by_name")]
    class: usize,
    /// Share of the examples.
    share: f64,
    /// One for each feature, in their order.
    coefficients: Vec<f64>,
}

/// A class in files.
mod by_name {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    use super::{CLASSES, class_name};

    #[expect(
        clippy::trivially_copy_pass_by_ref,
        reason = "serde passes fields by reference"
    )]
    pub(super) fn serialize<S: Serializer>(class: &usize, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(class_name(*class))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<usize, D::Error> {
        let name = String::deserialize(from)?;
        let class = (0..CLASSES).find(|class| class_name(*class) == name);
        class.ok_or_else(|| D::Error::custom(format!("no grasp type is called `{name}`")))
    }
}

/// The name of a class: that of the type, or `unlisted`.
pub(super) fn class_name(class: usize) -> &'static str {
    let entry = Taxonomy::feix().types.get(class);
    entry.map_or(UNLISTED, |entry| entry.name.as_str())
}

/// A regression on features, weighed with the rule.
///
/// ```text
/// score   = share + W z,   W = argmin ‖Y − share − W Z‖² + ridge ‖W‖²
/// P(class) ∝ (max(score, 0) + 0.02)^sharpness · (P_rule(class) + 0.01)^trust
/// ```
///
/// z: features less their means, divided by their deviations; Y: 1 for the class of an example, else 0. The three settings
/// are those with the least Brier score, summed over category, cell and type, of examples of groups that were left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Regression {
    choice: Choice,
    features: Vec<Scale>,
    classes: Vec<Weights>,
}

/// Why a labeller leaves a grasp to the rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Unseen {
    /// Too many features cannot be measured.
    #[error("more than a tenth of what the labeller learned from cannot be measured here")]
    Missing,
    /// Too many features lie outside what was seen.
    #[error("the grasp is unlike all that the labeller has seen")]
    Far,
}

/// The examples as numbers.
struct Design<'a> {
    examples: &'a [Example],
    scales: Vec<Scale>,
    /// Standardised features.
    rows: Vec<DVector<f64>>,
    /// Classes that occur.
    classes: Vec<usize>,
}

/// Sums over examples, from which a regression follows. They can be added and subtracted.
#[derive(Clone)]
struct Sums {
    count: f64,
    /// Σ z zᵀ, Σ z and Σ z yᵀ.
    gram: DMatrix<f64>,
    features: DVector<f64>,
    cross: DMatrix<f64>,
    /// Number of examples of each class.
    classes: DVector<f64>,
}

impl Scale {
    fn of(name: &str, values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
        Self {
            name: name.to_owned(),
            mean,
            deviation: variance.sqrt().max(LEAST_DEVIATION),
            low: values.iter().copied().fold(f64::INFINITY, f64::min),
            high: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    fn standardised(&self, features: &Features) -> f64 {
        let value = features.get(&self.name);
        value.map_or(0.0, |value| (value - self.mean) / self.deviation)
    }

    fn is_outside(&self, value: f64) -> bool {
        let beyond = BEYOND * self.deviation;
        value < self.low - beyond || value > self.high + beyond
    }
}

impl<'a> Design<'a> {
    fn new(examples: &'a [Example]) -> Self {
        let mut values: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for example in examples {
            for (name, value) in &example.features {
                values.entry(name).or_default().push(*value);
            }
        }
        let least = KNOWN * examples.len() as f64;
        values.retain(|_, values| values.len() as f64 >= least);
        let scales: Vec<Scale> = (values.iter())
            .map(|(name, values)| Scale::of(name, values))
            .collect();
        let row = |example: &Example| {
            let numbers = scales
                .iter()
                .map(|scale| scale.standardised(&example.features));
            DVector::from_iterator(scales.len(), numbers)
        };
        let mut classes: Vec<usize> = examples.iter().map(|example| example.class).collect();
        classes.sort_unstable();
        classes.dedup();
        Self {
            examples,
            rows: examples.iter().map(row).collect(),
            scales,
            classes,
        }
    }

    fn sums(&self, members: impl Iterator<Item = usize>) -> Sums {
        let (features, classes) = (self.scales.len(), self.classes.len());
        let mut sums = Sums {
            count: 0.0,
            gram: DMatrix::zeros(features, features),
            features: DVector::zeros(features),
            cross: DMatrix::zeros(features, classes),
            classes: DVector::zeros(classes),
        };
        for i in members {
            let row = &self.rows[i];
            let class = self
                .classes
                .partition_point(|c| *c < self.examples[i].class);
            sums.count += 1.0;
            // One vector at a time: products of large matrices differ between processors in their last bits.
            sums.gram.ger(1.0, row, row, 1.0);
            sums.features += row;
            sums.classes[class] += 1.0;
            let mut column = sums.cross.column_mut(class);
            column += row;
        }
        sums
    }

    /// Probabilities of all classes for an example by a regression that these sums give.
    fn probabilities(&self, fit: &Fit, example: usize, choice: Choice) -> Vec<f64> {
        let scores = fit.scores(&self.rows[example]);
        let scores = self.classes.iter().copied().zip(scores);
        weighed(scores, &self.examples[example].rule, choice)
    }
}

/// A solved regression.
struct Fit {
    shares: Vec<f64>,
    coefficients: DMatrix<f64>,
}

impl Fit {
    fn scores(&self, row: &DVector<f64>) -> Vec<f64> {
        let columns = self.coefficients.column_iter();
        (self.shares.iter().zip(columns))
            .map(|(share, column)| share + column.dot(row))
            .collect()
    }
}

/// Probabilities of all classes from the scores of some.
fn weighed(scores: impl Iterator<Item = (usize, f64)>, rule: &[f64], choice: Choice) -> Vec<f64> {
    let mut probabilities = vec![0.0; CLASSES];
    for (class, score) in scores {
        probabilities[class] = libm::pow(score.max(0.0) + LEAST_SCORE, choice.sharpness)
            * libm::pow(rule[class] + LEAST_RULE, choice.trust_in_rule);
    }
    let sum: f64 = probabilities.iter().sum();
    for p in &mut probabilities {
        *p /= sum;
    }
    probabilities
}

impl Sums {
    fn less(&self, part: &Self) -> Self {
        Self {
            count: self.count - part.count,
            gram: &self.gram - &part.gram,
            features: &self.features - &part.features,
            cross: &self.cross - &part.cross,
            classes: &self.classes - &part.classes,
        }
    }

    fn solve(&self, ridge: f64) -> Fit {
        let size = self.gram.nrows();
        let shares = &self.classes / self.count.max(1.0);
        let mut cross = self.cross.clone();
        cross.ger(-1.0, &self.features, &shares, 1.0);
        let ridged = &self.gram + DMatrix::identity(size, size) * ridge;
        // A sum of squares and a ridge is positive definite.
        let coefficients = ridged
            .cholesky()
            .map_or(cross.clone() * 0.0, |factor| factor.solve(&cross));
        Fit {
            shares: shares.as_slice().to_vec(),
            coefficients,
        }
    }
}

/// The part of each example: groups are dealt out to parts in their order. Where there are fewer than three groups, single
/// examples are.
pub(super) fn parts(examples: &[Example], most: usize) -> Vec<usize> {
    let mut groups: Vec<&str> = examples.iter().map(|e| e.group.as_str()).collect();
    groups.sort_unstable();
    groups.dedup();
    if by_groups(&groups) {
        let place = |example: &Example| groups.partition_point(|g| *g < example.group.as_str());
        examples.iter().map(|e| place(e) % most).collect()
    } else {
        (0..examples.len()).map(|i| i % most).collect()
    }
}

fn by_groups<T>(groups: &[T]) -> bool {
    groups.len() >= 3
}

/// The members of each part that is not empty.
fn members(parts: &[usize]) -> Vec<Vec<usize>> {
    let count = parts.iter().max().map_or(0, |most| most + 1);
    let mut members = vec![Vec::new(); count];
    for (i, part) in parts.iter().enumerate() {
        members[*part].push(i);
    }
    members.retain(|own| !own.is_empty());
    members
}

/// Sum over category, cell and type of the Brier score (G. W. Brier, Mon. Weather Rev. 78, 1 (1950)).
fn brier(probabilities: &[f64], class: usize, respects: &[Vec<usize>; 3]) -> f64 {
    let score = |numbers: &Vec<usize>| {
        let mut sums = sums(probabilities, numbers);
        sums[numbers[class]] -= 1.0;
        sums.iter().map(|miss| miss * miss).sum::<f64>()
    };
    respects.iter().map(score).sum()
}

/// The settings that name these examples best, each by the regression of the parts to which it does not belong.
fn choose(design: &Design<'_>, own: &[usize], all: &Sums) -> Choice {
    let respects = respects();
    let examples: Vec<Example> = own.iter().map(|i| design.examples[*i].clone()).collect();
    let parts = members(&parts(&examples, PARTS_TO_CHOOSE));
    let settings: Vec<(f64, f64)> = (SHARPNESS.into_iter())
        .flat_map(|sharpness| TRUST.map(|trust| (sharpness, trust)))
        .collect();
    let mut scores = vec![0.0; RIDGES.len() * settings.len()];
    for part in parts {
        let part: Vec<usize> = part.into_iter().map(|place| own[place]).collect();
        let others = all.less(&design.sums(part.iter().copied()));
        for (r, ridge) in RIDGES.into_iter().enumerate() {
            let fit = others.solve(ridge);
            for (s, (sharpness, trust_in_rule)) in settings.iter().copied().enumerate() {
                let choice = Choice {
                    ridge,
                    sharpness,
                    trust_in_rule,
                };
                let miss = part.iter().map(|&i| {
                    let told = design.probabilities(&fit, i, choice);
                    brier(&told, design.examples[i].class, &respects)
                });
                scores[r * settings.len() + s] += miss.sum::<f64>();
            }
        }
    }
    let least = scores.iter().copied().fold(f64::INFINITY, f64::min);
    let best = scores.iter().position(|score| *score <= least).unwrap_or(0);
    let (sharpness, trust_in_rule) = settings[best % settings.len()];
    Choice {
        ridge: RIDGES[best / settings.len()],
        sharpness,
        trust_in_rule,
    }
}

/// Probabilities of each example by a labeller that was taught without its part, settings included, and the class that was
/// the commonest of the other parts.
pub(super) struct LeftOut {
    /// Of each example: the probability of each class.
    pub(super) probabilities: Vec<Vec<f64>>,
    /// Of each example: the commonest class without its part.
    pub(super) commonest: Vec<usize>,
    /// Whether whole groups were left out; else there are fewer than three, and single examples were.
    pub(super) by_groups: bool,
}

/// Judges what would be taught.
pub(super) fn leave_out(examples: &[Example]) -> LeftOut {
    let design = Design::new(examples);
    let all = design.sums(0..examples.len());
    let parts = members(&parts(examples, PARTS));
    let of_part = |part: &Vec<usize>| {
        let others: Vec<usize> = (0..examples.len()).filter(|i| !part.contains(i)).collect();
        let sums = all.less(&design.sums(part.iter().copied()));
        let choice = choose(&design, &others, &sums);
        let fit = sums.solve(choice.ridge);
        let most = sums.classes.max();
        let place = sums.classes.iter().position(|count| *count >= most);
        let commonest = design.classes[place.unwrap_or(0)];
        let told = part.iter();
        told.map(|&i| (i, design.probabilities(&fit, i, choice), commonest))
            .collect::<Vec<_>>()
    };
    let mut told: Vec<_> = (parts.par_iter().map(of_part).collect::<Vec<_>>())
        .into_iter()
        .flatten()
        .collect();
    told.sort_by_key(|(i, ..)| *i);
    let mut groups: Vec<&str> = examples.iter().map(|e| e.group.as_str()).collect();
    groups.sort_unstable();
    groups.dedup();
    let (probabilities, commonest) = told.into_iter().map(|(_, p, c)| (p, c)).unzip();
    LeftOut {
        probabilities,
        commonest,
        by_groups: by_groups(&groups),
    }
}

impl Regression {
    /// Learns from examples.
    pub fn of(examples: &[Example]) -> Self {
        let design = Design::new(examples);
        let sums = design.sums(0..examples.len());
        let everything: Vec<usize> = (0..examples.len()).collect();
        let choice = choose(&design, &everything, &sums);
        let fit = sums.solve(choice.ridge);
        let columns = fit.coefficients.column_iter().zip(&fit.shares);
        let classes = (design.classes.iter().zip(columns))
            .map(|(class, (column, share))| Weights {
                class: *class,
                share: rounded(*share),
                coefficients: column.iter().copied().map(rounded).collect(),
            })
            .collect();
        let mut features = design.scales;
        for scale in &mut features {
            let Scale {
                mean,
                deviation,
                low,
                high,
                ..
            } = scale;
            for number in [mean, deviation, low, high] {
                *number = rounded(*number);
            }
        }
        Self {
            choice,
            features,
            classes,
        }
    }

    /// The probability of each class; `rule`: those of the rule.
    ///
    /// # Errors
    /// If the grasp is unlike all that was seen.
    pub fn probabilities(&self, features: &Features, rule: &[f64]) -> Result<Vec<f64>, Unseen> {
        let count = self.features.len() as f64;
        let known = || {
            let scales = self.features.iter();
            scales.filter_map(|scale| Some((scale, *features.get(&scale.name)?)))
        };
        if count - known().count() as f64 > MISSING * count {
            return Err(Unseen::Missing);
        }
        let outside = known().filter(|(scale, value)| scale.is_outside(*value));
        if outside.count() as f64 > OUTSIDE * count {
            return Err(Unseen::Far);
        }
        let row: Vec<f64> = (self.features.iter())
            .map(|scale| scale.standardised(features))
            .collect();
        let scores = self.classes.iter().map(|of| {
            let products = of.coefficients.iter().zip(&row).map(|(a, b)| a * b);
            (of.class, of.share + products.sum::<f64>())
        });
        Ok(weighed(scores, rule, self.choice))
    }

    /// Refuses what cannot have been taught: every class has a coefficient for each feature, and no probability is NaN.
    ///
    /// # Errors
    /// With what is wrong.
    pub(super) fn check(&self) -> Result<(), String> {
        let within = |limit: Limit, numbers: &[f64]| {
            let found = numbers.iter().try_for_each(|number| limit.check(*number));
            found.map_err(|beyond| beyond.to_string())
        };
        let Choice {
            ridge,
            sharpness,
            trust_in_rule,
        } = self.choice;
        within(LABELLER_NUMBER, &[ridge])?;
        within(LABELLER_EXPONENT, &[sharpness, trust_in_rule])?;
        for scale in &self.features {
            within(LABELLER_NUMBER, &[scale.mean, scale.low, scale.high])?;
            within(LABELLER_DEVIATION, &[scale.deviation])?;
        }
        if self.classes.is_empty() {
            return Err("it has no classes".to_owned());
        }
        for of in &self.classes {
            let (name, count) = (class_name(of.class), of.coefficients.len());
            if count != self.features.len() {
                return Err(format!(
                    "`{name}` has {count} coefficients for {} features",
                    self.features.len()
                ));
            }
            within(LABELLER_NUMBER, &[of.share])?;
            within(LABELLER_NUMBER, &of.coefficients)?;
        }
        Ok(())
    }
}

/// A millionth is enough, and the file is shorter.
fn rounded(number: f64) -> f64 {
    (1e6 * number).round() / 1e6
}

#[cfg(test)]
pub(super) mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Classes of the planted examples.
    const PLANTED: [usize; 3] = [0, 13, UNLISTED_CLASS];

    /// A number from −1 to 1 without a pattern.
    fn noise(i: usize, k: usize) -> f64 {
        let mut mixed = (1000 * i + k + 1) as u64;
        mixed = mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed = (mixed ^ (mixed >> 32)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed ^= mixed >> 29;
        (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// The name of a feature.
    fn name(k: usize) -> String {
        format!("feature {k:02}")
    }

    /// Examples of three classes, ten of each object, with twenty features. Two of these decide the class, or none does. The
    /// rule says nothing.
    pub(in crate::evaluation::taxonomy) fn planted(count: usize, decided: bool) -> Vec<Example> {
        let example = |i: usize| {
            let drawn = noise(i, 99);
            let (place, size) = if decided {
                (i % 3, 3.0)
            } else {
                (usize::from(drawn >= 0.0) + usize::from(drawn >= 0.6), 0.0)
            };
            let angle = TAU / 3.0 * place as f64;
            let centre = [size * libm::cos(angle), size * libm::sin(angle)];
            let value = |k: usize| centre.get(k).unwrap_or(&0.0) + noise(i, k);
            Example {
                group: format!("object {}", i / 10),
                features: (0..20).map(|k| (name(k), value(k))).collect(),
                rule: vec![1.0 / CLASSES as f64; CLASSES],
                class: PLANTED[place],
            }
        };
        (0..count).map(example).collect()
    }

    #[test]
    fn what_features_decide_is_learned_and_noise_is_not() {
        for decided in [true, false] {
            let examples = planted(120, decided);
            let left_out = leave_out(&examples);
            assert!(left_out.by_groups);
            let right = |named: &dyn Fn(usize) -> usize| {
                let right = |i: &usize| named(*i) == examples[*i].class;
                (0..examples.len()).filter(right).count()
            };
            let labeller = right(&|i| answer(&left_out.probabilities[i]));
            let commonest = right(&|i| left_out.commonest[i]);
            if decided {
                assert!(labeller >= 114, "{labeller} of 120");
            } else {
                // As many as a standard deviation of 120 guesses is allowed.
                assert!(labeller <= commonest + 5, "{labeller}, {commonest}");
            }
        }
    }

    #[test]
    fn names_and_order_of_features_change_nothing() {
        let examples = planted(60, true);
        let turned = |example: &Example| Example {
            features: (0..20)
                .map(|k| (name(19 - k), example.features[&name(k)]))
                .collect(),
            ..example.clone()
        };
        let turned: Vec<Example> = examples.iter().map(turned).collect();
        let [one, other] = [&examples, &turned].map(|examples| Regression::of(examples));
        for (a, b) in examples.iter().zip(&turned) {
            let told = |regression: &Regression, example: &Example| {
                let told = regression.probabilities(&example.features, &example.rule);
                told.unwrap()
            };
            for (p, q) in told(&one, a).iter().zip(told(&other, b)) {
                // Sums in another order differ in their last bits, and coefficients are rounded.
                assert!((p - q).abs() < 1e-4, "{p} {q}");
            }
        }
    }

    #[test]
    fn features_of_few_examples_are_passed_over() {
        let mut examples = planted(60, true);
        for example in &mut examples[..31] {
            example.features.remove(&name(5));
        }
        for example in &mut examples[..30] {
            example.features.remove(&name(6));
        }
        let found = Regression::of(&examples).features;
        let found: Vec<&str> = found.iter().map(|scale| scale.name.as_str()).collect();
        assert_eq!(found.len(), 19);
        assert!(!found.contains(&name(5).as_str()));
    }

    #[test]
    fn a_grasp_unlike_all_that_was_seen_is_left_to_the_rule() {
        let examples = planted(60, true);
        let regression = Regression::of(&examples);
        let seen = &examples[7];
        let odd = |outside: usize, missing: usize| {
            let mut features = seen.features.clone();
            for value in features.values_mut().take(outside) {
                *value += 20.0;
            }
            for k in 0..missing {
                features.remove(&name(19 - k));
            }
            regression.probabilities(&features, &seen.rule)
        };
        let told = odd(0, 0).unwrap();
        assert_eq!(answer(&told), seen.class);
        assert!((told.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // Of twenty features, one may lie outside, and two may be missing.
        assert!(odd(1, 2).is_ok());
        assert_eq!(odd(2, 0), Err(Unseen::Far));
        assert_eq!(odd(0, 3), Err(Unseen::Missing));
    }

    #[test]
    fn the_answer_is_in_the_most_probable_cell() {
        // Large Diameter and Small Diameter share a cell, and Tripod is in another one.
        let mut probabilities = vec![0.0; CLASSES];
        (probabilities[0], probabilities[1], probabilities[13]) = (0.25, 0.35, 0.4);
        assert_eq!(answer(&probabilities), 1);
        probabilities[UNLISTED_CLASS] = 0.7;
        assert_eq!(answer(&probabilities), UNLISTED_CLASS);
    }
}
