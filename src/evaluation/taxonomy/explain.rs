//! The explanation of a label in plain words, in the order in which the rule decides.

use std::fmt::Write;

use super::decision::Evidence;
use super::form::{Held, Solid};
use super::label::{Label, Verdict};
use super::rule::Rule;
use super::table::{Form, Opposition, Taxonomy};

/// Shares below this are not told.
const TOLD: f64 = 0.05;

/// The explanation of a label, in lines of text.
pub fn explain(label: &Label, rule: &Rule) -> String {
    let mut text = format!("label               {}\n", label.text());
    if let Verdict::NotApplicable(why) = label.verdict {
        let _ = writeln!(
            text,
            "                    the taxonomy does not apply: {}",
            why.words()
        );
        return text;
    }
    let _ = writeln!(text, "1 opposition        {}", oppositions(label));
    let categories = (label.categories.iter()).map(|(category, p)| (category.name(), *p));
    let _ = writeln!(text, "2 category          {}", shares(categories));
    let cell = label.best.first().and_then(|best| {
        let entry = Taxonomy::feix().numbered(best.number)?;
        Some(entry.cell.as_str())
    });
    let _ = writeln!(
        text,
        "3 virtual fingers   {} touch (P palm, 1 thumb, 2 index … 5 little); best cell {} {:.2}",
        label.virtual_fingers,
        cell.unwrap_or("none"),
        label.cell_probability
    );
    if let Some(held) = &label.held {
        let _ = writeln!(text, "4 what is held      {}", part(held));
    }
    let own = label.of_category().into_iter();
    let own = own.enumerate().map(|(place, candidate)| {
        let head = if place == 0 { "5 type" } else { "" };
        (head, candidate)
    });
    let rival = label.rival().map(|rival| ("other category", rival));
    let answer = label.best.first().map_or(0.0, |best| best.score);
    for (head, candidate) in own.chain(rival) {
        let entry = Taxonomy::feix().numbered(candidate.number);
        let (type_name, cell) = entry.map_or(("", ""), |entry| (&entry.name, &entry.cell));
        // Only the type of another category can be more probable than the answer.
        let note = if candidate.score > answer {
            ": more probable than the answer, but its category is less probable"
        } else {
            ""
        };
        let _ = writeln!(
            text,
            "{head:<20}{:.3}  {:>2} {type_name} ({cell}){note}",
            candidate.score, candidate.number
        );
    }
    text += &listed("for it", &label.support);
    text += &listed("against it", &label.objections);
    text += &listed("against the next", &label.against_next);
    text += &outcome(label, rule);
    text
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

#[cfg(test)]
mod tests {
    use super::super::label::Candidate;
    use super::super::table::Category;
    use super::*;

    /// A label by probabilities of types; the first is the answer.
    fn label(types: &[(u8, f64)]) -> Label {
        let candidate = |&(number, score): &(u8, f64)| Candidate { number, score };
        Label {
            verdict: Verdict::Listed(types[0].0),
            best: types.iter().map(candidate).collect(),
            types: types.iter().map(candidate).collect(),
            fit: 0.5,
            oppositions: Vec::new(),
            categories: Vec::new(),
            category: Some(Category::Power),
            cell_probability: 0.6,
            virtual_fingers: "P:2-5:1".to_owned(),
            held: None,
            facts: Vec::new(),
            support: Vec::new(),
            objections: Vec::new(),
            against_next: Vec::new(),
        }
    }

    /// Types 3 and 1 are power grasps, 14 is a precision grasp.
    #[test]
    fn a_type_more_probable_than_the_answer_is_explained() {
        let note = |types: &[(u8, f64)]| {
            let text = explain(&label(types), Rule::standard());
            let of_tripod = text.lines().find(|line| line.contains("14 Tripod"));
            let of_others = text.lines().filter(|line| !line.contains("14 Tripod"));
            assert!(
                of_others
                    .into_iter()
                    .all(|line| !line.contains("more probable"))
            );
            of_tripod.is_some_and(|line| line.contains("its category is less probable"))
        };
        assert!(note(&[(3, 0.35), (1, 0.25), (14, 0.4)]));
        assert!(!note(&[(3, 0.4), (1, 0.25), (14, 0.35)]));
    }
}
