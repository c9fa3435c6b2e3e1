//! A grasp with the type that a person gave it and the label of the rule.

use crate::contact::Contact;
use landscape::evaluation::taxonomy::{Category, GraspType, Label, Opposition, Taxonomy, Verdict};

/// An annotated grasp.
pub(crate) struct Case {
    /// Name of the grasp.
    pub(crate) id: String,
    /// The object; grasps of one object are not independent.
    pub(crate) object: String,
    /// The type that the person gave.
    pub(crate) truth: &'static GraspType,
    /// How near each part of the hand is to the object.
    pub(crate) contact: Contact,
    /// Whether the parts that touch are those that the type needs, see [`crate::contact::agrees`].
    pub(crate) agrees: bool,
    /// The pose of the hand, object frame.
    pub(crate) x: Vec<f64>,
    /// The rule's label.
    pub(crate) label: Label,
}

/// What is compared with the person's type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Measure {
    Category,
    Opposition,
    VirtualFingers,
    Cell,
    Type,
    TopThree,
    Unlisted,
}

impl Measure {
    pub(crate) const ALL: [Self; 7] = [
        Self::Category,
        Self::Opposition,
        Self::VirtualFingers,
        Self::Cell,
        Self::Type,
        Self::TopThree,
        Self::Unlisted,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Category => "category",
            Self::Opposition => "opposition",
            Self::VirtualFingers => "virtual fingers 1 and 2",
            Self::Cell => "cell",
            Self::Type => "type",
            Self::TopThree => "type among best three",
            Self::Unlisted => "unlisted",
        }
    }

    /// The class of a type by which the commonest answer is found; `None` where there is none.
    pub(crate) fn class(self, entry: &GraspType) -> Option<String> {
        match self {
            Self::Category => Some(entry.category.name().to_owned()),
            Self::Opposition => Some(entry.opposition.name().to_owned()),
            Self::VirtualFingers => Some(virtual_fingers(entry)),
            Self::Cell => Some(entry.cell.clone()),
            Self::Type => Some(entry.name.clone()),
            Self::TopThree | Self::Unlisted => None,
        }
    }
}

fn virtual_fingers(entry: &GraspType) -> String {
    format!("{:?}:{:?}", entry.vf1, entry.vf2)
}

impl Case {
    fn found(&self) -> Option<&'static GraspType> {
        Taxonomy::feix().numbered(self.label.best.first()?.number)
    }

    /// The type with the best score, whatever the score.
    pub(crate) fn found_type(&self) -> Option<&'static GraspType> {
        self.found()
    }

    fn found_category(&self) -> Option<Category> {
        self.label.category
    }

    fn found_opposition(&self) -> Option<Opposition> {
        Some(self.found()?.opposition)
    }

    /// Whether the label is right in this respect. The best guess counts, even where the label is less precise; `Unlisted`
    /// is whether no type is given.
    pub(crate) fn right(&self, measure: Measure) -> bool {
        let found = self.found();
        match measure {
            Measure::Category => self.found_category() == Some(self.truth.category),
            Measure::Opposition => self.found_opposition() == Some(self.truth.opposition),
            Measure::VirtualFingers => {
                found.is_some_and(|found| virtual_fingers(found) == virtual_fingers(self.truth))
            }
            Measure::Cell => found.is_some_and(|found| found.cell == self.truth.cell),
            Measure::Type => found.is_some_and(|found| found.number == self.truth.number),
            Measure::TopThree => {
                let best = &self.label.best;
                best.iter().any(|best| best.number == self.truth.number)
            }
            Measure::Unlisted => {
                matches!(
                    self.label.verdict,
                    Verdict::Unlisted | Verdict::NotApplicable(_)
                )
            }
        }
    }
}
