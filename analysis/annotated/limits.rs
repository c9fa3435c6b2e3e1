//! What limits the rule on people's grasps: labels that contradict contact, the palm, or the rule itself.

use std::collections::BTreeMap;
use std::fmt::Write;

use landscape::evaluation::taxonomy::{GraspType, Taxonomy};

use crate::case::{Case, Measure};
use crate::contact::{NEAR_MM, agrees, agrees_but_for_the_palm};
use crate::report::{View, per_grasp, percent};

/// The share of right cells that is the target.
const CELLS: f64 = 0.55;
/// Distances from which the palm may count as touching, mm.
const PALM_MM: [f64; 3] = [NEAR_MM, 0.0, -4.0];
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
         agree if the palm were read differently; whether then the label or the model of the hand is at fault is open, because \
         the palm of this hand is a convex hull, which touches too much. *The rule*: the \
         label agrees with contact, and the rule is wrong all the same.\n\n\
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

/// Whether some type that agrees with contact has this in common with the person's type.
fn within_reach(case: &Case, same: &dyn Fn(&GraspType, &GraspType) -> bool) -> bool {
    let touching = case.contact.touching(NEAR_MM);
    let mut types = Taxonomy::feix().types.iter();
    types.any(|entry| agrees(entry, &touching) && same(entry, case.truth))
}

fn reachable(cases: &[&Case], measure: Measure) -> usize {
    let same = |a: &GraspType, b: &GraspType| measure.class(a) == measure.class(b);
    let within = cases.iter().filter(|case| within_reach(case, &same));
    within.count()
}

fn ceiling(people: &[&View<'_>]) -> String {
    let mut text = "\n### The ceiling of contact\n\n\
         A decision that may name only types that agree with what touches can be right in no more than this, even if it always \
         chose the best of them. The rule is not bound so strictly: it weighs contact.\n\n\
         | grasps | number | category at most, % | the rule, % | cell at most, % | the rule, % | type at most, % | the rule, % | no type agrees, % |\n\
         |---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for view in people {
        let count = view.cases.len() as f64;
        let _ = write!(text, "| {} | {count} |", view.short);
        for measure in [Measure::Category, Measure::Cell, Measure::Type] {
            let _ = write!(
                text,
                " {} | {} |",
                percent(reachable(&view.cases, measure) as f64 / count),
                percent(per_grasp(&view.cases, measure))
            );
        }
        let none = view
            .cases
            .iter()
            .filter(|case| !within_reach(case, &|_, _| true));
        let _ = writeln!(text, " {} |", percent(none.count() as f64 / count));
    }
    let short = people.iter().filter(|view| {
        (reachable(&view.cases, Measure::Cell) as f64) < CELLS * view.cases.len() as f64
    });
    let short: Vec<&str> = short.map(|view| view.short).collect();
    if !short.is_empty() {
        let _ = writeln!(
            text,
            "\nWhere the ceiling of the cell lies below the target of {:.0} %, no decision that is bound to contact can meet it: {}.",
            100.0 * CELLS,
            short.join(", ")
        );
    }
    text
}

/// Who is to blame for the cells that are missing on the third.
fn missing(third: &View<'_>) -> String {
    let count = third.cases.len();
    let right = third
        .cases
        .iter()
        .filter(|case| case.right(Measure::Cell))
        .count();
    let asked = (0..=count)
        .find(|n| *n as f64 >= CELLS * count as f64)
        .unwrap_or(count);
    let most = reachable(&third.cases, Measure::Cell);
    let own = |case: &&&Case| !case.right(Measure::Cell) && Cause::of(case) == Cause::Rule;
    let own = third.cases.iter().filter(own).count();
    let mut text = format!(
        "\nOn the third, {:.0} % of the cells are {asked} of {count} grasps. The rule names {right} right. A decision that is \
         bound to contact could name {most} right, and {own} of the {} wrong ones have a label that agrees with contact.",
        100.0 * CELLS,
        count - right,
    );
    if right < asked && asked <= most && own >= asked - right {
        let _ = write!(
            text,
            " So on the third it is the rule, not the labels, that misses the last {}.",
            match asked - right {
                1 => "grasp".to_owned(),
                2 => "two grasps".to_owned(),
                more => format!("{more} grasps"),
            }
        );
    }
    text.push('\n');
    text
}

fn other_hand(people: &[&View<'_>], converted: &[Case]) -> String {
    let of_id: BTreeMap<&str, &Case> = converted.iter().map(|case| (&*case.id, case)).collect();
    let mut text = "\n### The hand\n\n\
         The same rule on the same grasps, converted to our human hand. These poses were fitted; finger bones are turned by 19° \
         and the thumb by 26°. Counted in pairs:\n\n\
         | right | grasps | on both hands | on the MANO-like hand only | on the human hand only | on neither |\n|---|---|---|---|---|---|\n"
        .to_owned();
    for measure in [Measure::Category, Measure::Cell, Measure::Type] {
        for view in people {
            let pairs = view.cases.iter().filter_map(|case| {
                let other = of_id.get(&*case.id)?;
                Some((case.right(measure), other.right(measure)))
            });
            let pairs: Vec<(bool, bool)> = pairs.collect();
            let count = |pair: (bool, bool)| pairs.iter().filter(|own| **own == pair).count();
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} | {} |",
                measure.name(),
                view.short,
                count((true, true)),
                count((true, false)),
                count((false, true)),
                count((false, false)),
            );
        }
    }
    text += "\nThe fitted hand loses many more grasps than it gains. Conversion of the hand costs, so figures of the fitted hand \
             say little of the rule; and it does not explain what is wrong on the MANO-like hand, which has the annotators' own \
             poses.\n";
    text
}

fn palm_threshold(people: &[&View<'_>]) -> String {
    let mut text = "\n### Where the palm begins to touch\n\n\
         Whether a label agrees depends on the distance at which the palm counts as touching, because the palm of the model sticks \
         out. The labels of the rule are the same in all rows; only the division of the grasps changes.\n\n\
         | palm nearer than | grasps | labels that agree | cell right in these, % | cell right in the others, % |\n|---|---|---|---|---|\n"
        .to_owned();
    for palm_mm in PALM_MM {
        for view in people {
            let (agreeing, rest): (Vec<&Case>, Vec<&Case>) = view
                .cases
                .iter()
                .partition(|case| agrees(case.truth, &case.contact.touching(palm_mm)));
            let _ = writeln!(
                text,
                "| {} mm | {} | {} | {} | {} |",
                format!("{palm_mm:.0}").replace('-', "−"),
                view.short,
                agreeing.len(),
                percent(per_grasp(&agreeing, Measure::Cell)),
                percent(per_grasp(&rest, Measure::Cell)),
            );
        }
    }
    text += "\nThe further inside the palm must be, the smaller is the difference between the grasps whose label agrees and the \
             others. What the rule gets right on labels that agree must be read with this choice in mind; 5 mm is that of the data.\n";
    text
}

/// The probabilities of the answers where labels agree with contact and where they do not.
fn certainty(people: &[&View<'_>]) -> String {
    let mut text = format!(
        "\n### Certainty\n\n\
         The mean probability of the answers and the share that is right, and the most certain answers, which have a probability \
         of at least {CERTAIN}. Whether a label agrees with contact depends on the label itself, so exact probabilities, too, would \
         be too low in the one half and too high in the other; only the last two columns tell something of the rule.\n\n\
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
pub(crate) fn limits(views: &[View<'_>], converted: &[Case]) -> String {
    let people: Vec<&View<'_>> = views.iter().filter(|view| view.posed_by_people).collect();
    let mut text = "\n## What limits it\n".to_owned();
    text += &causes(views);
    text += &ceiling(&people);
    if let Some(third) = people.iter().find(|view| view.short == "third") {
        text += &missing(third);
    }
    text += &other_hand(&people, converted);
    text += &palm_threshold(&people);
    text += &certainty(&people);
    text
}
