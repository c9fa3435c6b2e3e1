//! Labels of the rule for grasps that people posed and named → `figures/annotated_grasps.md`, `.png` and `.csv`
//!
//! `LANDSCAPE_TEST_DATA=FOLDER cargo run --release --example annotated`. The folder holds `ycb_affordance`: grasps, objects
//! and the hand. None of this is part of the project, and no number of the rule is fitted to it. One third of the objects is
//! *unseen*: nobody looked at its grasps before the rule was final, and three of its types changed after that
//! (`data/taxonomy/README.md`).

#[path = "../people.rs"]
mod people;
mod picture;
mod report;

use landscape::evaluation::taxonomy::{GraspType, Label, Labeller, Rule, Taxonomy, Verdict};
use people::People;
use rayon::prelude::*;

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// A grasp with the type that a person gave it and the label of the rule.
pub(crate) struct Case {
    /// The object; grasps of one object are not independent.
    object: String,
    /// The type that the person gave.
    truth: &'static GraspType,
    /// Whether the digits and the palm that touch are those of this type.
    agrees: bool,
    label: Label,
}

/// What is compared with the person's type.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    const ALL: [(Self, &str); 7] = [
        (Self::Category, "category"),
        (Self::Opposition, "opposition"),
        (Self::VirtualFingers, "virtual fingers 1 and 2"),
        (Self::Cell, "cell"),
        (Self::Type, "type"),
        (Self::TopThree, "type among best three"),
        (Self::Unlisted, "unlisted"),
    ];

    /// The class of a type; `None` where the measure has no classes.
    fn class(self, entry: &GraspType) -> Option<String> {
        match self {
            Self::Category => Some(entry.category.name().to_owned()),
            Self::Opposition => Some(entry.opposition.name().to_owned()),
            Self::VirtualFingers => Some(format!("{:?}:{:?}", entry.vf1, entry.vf2)),
            Self::Cell => Some(entry.cell.clone()),
            Self::Type => Some(entry.name.clone()),
            Self::TopThree | Self::Unlisted => None,
        }
    }
}

impl Case {
    /// The type with the best score, whatever the score.
    fn found(&self) -> Option<&'static GraspType> {
        Taxonomy::feix().numbered(self.label.best.first()?.number)
    }

    /// Whether the label is right in this respect. The best guess counts, even where the label is less precise; `Unlisted`
    /// is whether no type is given.
    fn right(&self, measure: Measure) -> bool {
        let Label { best, verdict, .. } = &self.label;
        match measure {
            Measure::Category => self.label.category == Some(self.truth.category),
            Measure::TopThree => best.iter().any(|best| best.number == self.truth.number),
            Measure::Unlisted => {
                matches!(verdict, Verdict::Unlisted | Verdict::NotApplicable(_))
            }
            _ => (self.found())
                .is_some_and(|found| measure.class(found) == measure.class(self.truth)),
        }
    }
}

/// The unseen objects: the third of the objects with the smallest 64-bit FNV-1a hash of "25 NAME". Number 25 is the seed,
/// chosen on 24 November 2026 before any of their labels, pictures or results was opened.
fn unseen<'a>(objects: impl Iterator<Item = &'a String>) -> Vec<String> {
    let hash = |name: &String| {
        let bytes = b"25 ".iter().copied().chain(name.bytes());
        bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        })
    };
    let mut order: Vec<String> = objects.cloned().collect();
    order.sort_by_key(hash);
    order.truncate(order.len().div_ceil(3));
    order
}

fn main() -> Result<(), Failure> {
    let people = People::read()?;
    let rule = Rule::standard();
    let of_object = |name: &String| -> Result<Vec<Case>, Failure> {
        let object = people.object(name)?;
        let labeller = Labeller::new(&people.hand, &object, rule);
        let case = |grasp: &people::Posed| {
            let truth = Taxonomy::feix().numbered(grasp.label);
            Ok(Case {
                object: name.clone(),
                truth: truth.ok_or_else(|| format!("no type {}", grasp.label))?,
                agrees: grasp.agrees,
                label: labeller.label(&grasp.x),
            })
        };
        people.grasps[name].iter().map(case).collect()
    };
    let names: Vec<&String> = people.grasps.keys().collect();
    let cases: Vec<Vec<Case>> = names
        .into_par_iter()
        .map(of_object)
        .collect::<Result<_, _>>()?;
    let unseen = unseen(people.grasps.keys());
    let (unseen, seen): (Vec<Case>, Vec<Case>) =
        (cases.into_iter().flatten()).partition(|case| unseen.contains(&case.object));
    let sets = [("seen", &seen), ("unseen", &unseen)];
    let sets = sets.map(|(name, cases)| report::Set {
        name,
        cases: cases.iter().collect(),
    });
    let (text, types) = report::report(&sets, &rule.version);
    std::fs::write("figures/annotated_grasps.md", text)?;
    std::fs::write("figures/annotated_grasps.csv", types)?;
    picture::picture(&sets).save("figures/annotated_grasps.png".as_ref())?;
    Ok(())
}
