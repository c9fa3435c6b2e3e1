//! How far an answer can be trusted, in three words.

use super::decision::Answer;
use super::rule::Rule;

/// How often answers of this kind are right. On grasps that people posed and named, at least two thirds of the likely answers
/// are, and at least a third of the open ones (`figures/annotated_grasps.md`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Certainty {
    /// Fewer than a third are right.
    Guess,
    /// Between one and two thirds are.
    Open,
    /// Two thirds or more are.
    Likely,
}

impl Certainty {
    /// All, the most certain first.
    pub const ALL: [Self; 3] = [Self::Likely, Self::Open, Self::Guess];

    /// That of a probability that is what it says.
    pub fn of(probability: f64) -> Self {
        Self::from(probability, [2.0 / 3.0, 1.0 / 3.0])
    }

    /// That of a number with the least numbers of likely and of open answers.
    pub(super) fn from(number: f64, [likely, open]: [f64; 2]) -> Self {
        match () {
            () if number >= likely => Self::Likely,
            () if number >= open => Self::Open,
            () => Self::Guess,
        }
    }

    /// Those of category, cell and type of an answer of the rule.
    pub(super) fn of_rule(rule: &Rule, answer: &Answer) -> [Self; 3] {
        let category = answer.categories.iter();
        let category = category.filter(|(category, _)| Some(*category) == answer.category);
        let kind = answer.best.first().map_or(0.0, |best| best.score);
        let probabilities = [
            category.map(|(_, p)| p).sum(),
            answer.cell_probability,
            kind,
        ];
        [0, 1, 2].map(|k: usize| Self::from(probabilities[k], rule.certain[k]))
    }

    /// The word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Likely => "likely",
            Self::Open => "open",
            Self::Guess => "a guess",
        }
    }
}
