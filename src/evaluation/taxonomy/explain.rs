//! The explanation of a label in plain words, in the order in which the rule decides.

use std::fmt::Write;

use super::decision::Evidence;
use super::form::{Held, Solid};
use super::label::{By, Label, Verdict};
use super::rule::Rule;
use super::table::{Form, Opposition, Taxonomy};

/// Shares below this are not told.
const TOLD: f64 = 0.05;

/// The explanation of a label, in lines of text. That of a labeller that was taught stands before that of the rule.
pub fn explain(label: &Label, rule: &Rule) -> String {
    if let (By::Taught(by_rule), Some(taught)) = (&label.by, &rule.taught) {
        return format!(
            "label               {}\nlabeller            taught with {} labels: {}; {}\n\nby the rule\n{}",
            label.text(),
            taught.count(),
            category(label),
            types(label).join(", "),
            explain(by_rule, rule)
        );
    }
    let mut text = format!("label               {}\n", label.text());
    if let By::Instead(unseen) = label.by {
        let _ = writeln!(text, "labeller            the rule answers: {unseen}");
    }
    if let Verdict::NotApplicable(why) = label.verdict {
        let _ = writeln!(
            text,
            "                    the taxonomy does not apply: {}",
            why.words()
        );
        return text;
    }
    let _ = writeln!(text, "1 opposition        {}", oppositions(label));
    let _ = writeln!(text, "2 category          {}", category(label));
    let cell = label.best.first().and_then(|best| {
        let entry = Taxonomy::feix().numbered(best.number)?;
        Some(entry.cell.as_str())
    });
    let _ = writeln!(
        text,
        "3 virtual fingers   {} touch (P palm, 1 thumb, 2 index … 5 little); best cell {} ({})",
        label.virtual_fingers,
        cell.unwrap_or("none"),
        label.certainty[1].name()
    );
    if let Some(held) = &label.held {
        let _ = writeln!(text, "4 what is held      {}", part(held));
    }
    for (place, line) in types(label).into_iter().enumerate() {
        let head = if place == 0 { "5 type" } else { "" };
        let _ = writeln!(text, "{head:<20}{line}");
    }
    if let Some(rival) = label
        .rival()
        .and_then(|rival| Taxonomy::feix().numbered(rival.number))
    {
        let _ = writeln!(text, "of another category {} ({})", rival.name, rival.cell);
    }
    text += &listed("for it", &label.support);
    text += &listed("against it", &label.objections);
    text += &listed("against the next", &label.against_next);
    text += &outcome(label, rule);
    text
}

/// The categories, the most probable first, and how far the first can be trusted.
fn category(label: &Label) -> String {
    let mut categories = label.categories.clone();
    categories.sort_by_key(|(category, _)| Some(*category) != label.category);
    let mut rest: Vec<_> = categories.split_off(1.min(categories.len()));
    rest.retain(|(_, p)| *p >= TOLD);
    rest.sort_by(|a, b| b.1.total_cmp(&a.1));
    let first = categories
        .first()
        .map_or("none", |(category, _)| category.name());
    let mut text = format!("{first} ({})", label.certainty[0].name());
    for (category, _) in rest {
        let _ = write!(text, ", then {}", category.name());
    }
    text
}

/// The answer and the next types of its category, with cells.
fn types(label: &Label) -> Vec<String> {
    let own = label.of_category().into_iter().enumerate();
    let spelled = own.filter_map(|(place, candidate)| {
        let entry = Taxonomy::feix().numbered(candidate.number)?;
        let text = format!("{} ({})", entry.name, entry.cell);
        Some(match place {
            0 => format!("{text}, {}", label.certainty[2].name()),
            _ => text,
        })
    });
    spelled.collect()
}

fn oppositions(label: &Label) -> String {
    let degrees = label.oppositions.iter().map(|(kind, p)| (kind.name(), *p));
    let most = (label.oppositions.iter()).max_by(|a, b| a.1.total_cmp(&b.1));
    let words = match most {
        Some((_, degree)) if *degree < TOLD => "nothing presses against anything",
        Some((Opposition::Palm, _)) => "fingers press toward the palm",
        Some((Opposition::Pad, _)) => "pads of fingers press against the thumb",
        Some((Opposition::Side, _)) => "sides of fingers press against the thumb or each other",
        None => "",
    };
    format!("{}: {words}", shares(degrees))
}

fn part(held: &Held) -> String {
    let solids = Solid::ALL.iter().zip(held.solids);
    let forms = Form::ALL.iter().zip(held.forms);
    let [short, middle, long] = held.extents_m.map(|extent| 1e3 * extent);
    format!(
        "like a {}; for the hand a {}; {short:.0} x {middle:.0} x {long:.0} mm, {:.0} mm between the contacts",
        shares(
            solids
                .map(|(solid, p)| (solid.name(), p))
                .filter(|(_, p)| *p >= TOLD)
        ),
        shares(
            forms
                .map(|(form, p)| (form.name(), p))
                .filter(|(_, p)| *p >= TOLD)
        ),
        1e3 * held.width_m
    )
}

fn shares<'a>(shares: impl Iterator<Item = (&'a str, f64)>) -> String {
    let spelled = shares.map(|(name, share)| format!("{name} {share:.2}"));
    spelled.collect::<Vec<_>>().join(", ")
}

fn listed(head: &str, list: &[Evidence]) -> String {
    let mut text = String::new();
    for (place, evidence) in list.iter().enumerate() {
        let head = if place == 0 { head } else { "" };
        let expected = if evidence.present {
            "expected"
        } else {
            "not expected"
        };
        let _ = writeln!(
            text,
            "{head:<20}{}: {:.2}, {expected} (fit times {:.2})",
            evidence.meaning, evidence.value, evidence.factor
        );
    }
    text
}

/// Why the label is as precise as it is.
fn outcome(label: &Label, rule: &Rule) -> String {
    let why = match label.verdict {
        Verdict::Listed(_) => "one type stands out",
        Verdict::Ambiguous(_) => "types of one cell are close, so the label is the cell",
        Verdict::Broad(_) => "cells of one category are close, so the label is the category",
        Verdict::Unlisted => "contact contradicts every type",
        Verdict::NotApplicable(_) => "the taxonomy does not apply",
    };
    format!(
        "outcome             {why}; best fit {:.3} (unlisted below {})\nrule                {}\n",
        label.fit, rule.unlisted_below, rule.version
    )
}
