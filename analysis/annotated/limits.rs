//! What limits the rule on people's grasps: labels that contradict contact, the palm, or the rule itself.

use std::fmt::Write;

use crate::case::{Case, Measure};
use crate::contact::{NEAR_MM, agrees_but_for_the_palm};
use crate::report::{View, per_grasp};

/// An answer of at least this probability is one of the most certain.
const CERTAIN: f64 = 0.8;

/// Whose mistake a wrong label can be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cause {
    /// The person's label names digits that do not touch, or omits some that do.
    Digits,
    /// It would agree if the palm were read differently.
    Palm,
    /// It agrees with contact.
    Rule,
}

impl Cause {
    const ALL: [Self; 3] = [Self::Digits, Self::Palm, Self::Rule];

    fn of(case: &Case) -> Self {
        let touching = case.contact.touching(NEAR_MM);
        if case.agrees {
            Self::Rule
        } else if agrees_but_for_the_palm(case.truth, &touching) {
            Self::Palm
        } else {
            Self::Digits
        }
    }
}

fn causes(views: &[View<'_>]) -> String {
    let mut text = "\n### Whose mistake\n\n\
         *Digits contradict*: the person's label names digits that do not touch, or omits some that do. *Only the palm*: it would \
         agree if the palm were read differently; the palm of this hand is a convex hull, which touches too much. *The rule*: the \
         label agrees with contact.\n\n\
         | what is wrong | grasps | number | wrong | digits contradict | only the palm | the rule |\n|---|---|---|---|---|---|---|\n"
        .to_owned();
    for (measure, name) in [
        (Measure::Category, "category"),
        (Measure::Cell, "cell"),
        (Measure::Unlisted, "unlisted"),
    ] {
        for view in views {
            let wrong: Vec<&&Case> = (view.cases.iter())
                .filter(|case| case.right(measure) == (measure == Measure::Unlisted))
                .collect();
            let of = |cause: Cause| wrong.iter().filter(|case| Cause::of(case) == cause).count();
            let [digits, palm, rule] = Cause::ALL.map(of);
            let _ = writeln!(
                text,
                "| {name} | {} | {} | {} | {digits} | {palm} | {rule} |",
                view.short,
                view.cases.len(),
                wrong.len(),
            );
        }
    }
    text
}

/// The probabilities of the answers where labels agree with contact and where they do not.
fn certainty(people: &[&View<'_>]) -> String {
    let mut text = format!(
        "\n### Certainty\n\n\
         The most certain answers have a probability of at least {CERTAIN}.\n\n\
         | grasps | label agrees with contact | number | mean probability | right | most certain | of these right |\n\
         |---|---|---|---|---|---|---|\n"
    );
    for view in people {
        for agrees in [true, false] {
            let own = view.cases.iter().filter(|case| case.agrees == agrees);
            let own: Vec<&Case> = own.copied().collect();
            let score = |case: &Case| case.label.best.first().map_or(0.0, |best| best.score);
            let certain = || own.iter().filter(|case| score(case) >= CERTAIN);
            let scores: f64 = own.iter().map(|case| score(case)).sum();
            let _ = writeln!(
                text,
                "| {} | {} | {} | {:.2} | {:.2} | {} | {} |",
                view.short,
                if agrees { "yes" } else { "no" },
                own.len(),
                scores / own.len().max(1) as f64,
                per_grasp(&own, Measure::Type),
                certain().count(),
                certain().filter(|case| case.right(Measure::Type)).count(),
            );
        }
    }
    text
}

/// The section on what limits the rule.
pub(crate) fn limits(views: &[View<'_>]) -> String {
    let people: Vec<&View<'_>> = views.iter().filter(|view| view.posed_by_people).collect();
    format!(
        "\n## What limits it\n{}{}",
        causes(views),
        certainty(&people)
    )
}
