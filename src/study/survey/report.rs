//! The summary and the tables of a survey.

use std::collections::BTreeSet;
use std::fmt::Write;

use serde_json::{Value, json};

use super::{HandSurvey, KindCounts, Survey, SurveyedPopulation, effective};
use crate::evaluation::taxonomy::Taxonomy;
use crate::figure::MAKER;
use crate::printable::counted;
use crate::store::exchange::csv_table;
use crate::study::markdown::table;
use crate::topography::{Completeness, LEAST_MEMBERS, Rarefaction};

/// Most rows of a table in the summary. The tables in the CSV files have all rows.
const ROWS: usize = 100;
/// Most rows of the table of shared contacts.
const SHARED_ROWS: usize = 12;

impl Survey {
    /// The summary as Markdown.
    pub fn markdown(&self) -> String {
        let grasps: usize = self.populations.iter().map(|one| one.grasps).sum();
        let mut text = format!(
            "# Survey of {}: {} on {}\n",
            counted(grasps, "grasp"),
            counted(self.hands.len(), "hand"),
            counted(objects(&self.populations), "object")
        );
        text.push('\n');
        let head = [
            "hand",
            "objects",
            "grasps",
            "types",
            "cells",
            "sets of contact regions",
            "families",
            "families with the digits of another object's",
        ];
        let rows = self.hands.iter();
        text += &table(
            &head,
            rows.map(|hand| hand.row(objects(self.of_hand(hand)))),
        );
        for hand in &self.hands {
            self.hand(hand, &mut text);
        }
        text.push_str("\n## How to read this\n\n");
        text.push_str(&Self::explanation());
        for note in &self.notes {
            let _ = write!(text, "\nNote: {note}.\n");
        }
        if !self.failures.is_empty() {
            let _ = write!(
                text,
                "\n## Not surveyed\n\n{} could not be read or built; the numbers above are of the others.\n\n",
                counted(self.failures.len(), "file or population")
            );
            for failure in &self.failures {
                let _ = writeln!(text, "- {failure}");
            }
        }
        text
    }

    fn hand(&self, hand: &HandSurvey, text: &mut String) {
        let _ = write!(
            text,
            "\n## {}: {} on {}\n\n",
            hand.hand,
            counted(hand.grasps, "grasp"),
            counted(objects(self.of_hand(hand)), "object")
        );
        for line in hand.lines() {
            let _ = writeln!(text, "- {line}");
        }
        text.push('\n');
        let head = [
            "object",
            "grasps",
            "held",
            "minima",
            "families",
            "families unseen",
            "next known",
            "types",
            "cells",
            "sets of contact regions",
            "effective types",
            "effective families",
            "usual types that lack",
        ];
        let rows = self.of_hand(hand).map(|one| self.row(one, hand));
        *text += &table(&head, rows.take(ROWS));
        if hand.populations.len() > ROWS {
            let _ = write!(
                text,
                "\nThe first {ROWS} of {}; populations.csv has all.\n",
                hand.populations.len()
            );
        }
        if !hand.shared.is_empty() {
            let _ = write!(
                text,
                "\nFamilies of {} by the digits with which they touch:\n\n",
                hand.hand
            );
            let rows = hand.shared.iter().take(SHARED_ROWS).map(|set| {
                vec![
                    contacts_label(&set.contacts).to_owned(),
                    set.populations.len().to_string(),
                    set.families.to_string(),
                    set.grasps.to_string(),
                ]
            });
            *text += &table(&["touching", "objects", "families", "grasps"], rows);
        }
    }

    /// The populations of a hand.
    pub(super) fn of_hand<'a>(
        &'a self,
        hand: &'a HandSurvey,
    ) -> impl Iterator<Item = &'a SurveyedPopulation> {
        self.populations.iter().filter(|one| one.hand == hand.hand)
    }

    fn row(&self, one: &SurveyedPopulation, hand: &HandSurvey) -> Vec<String> {
        let dash = || "–".to_owned();
        let length = |counts: &Option<KindCounts>| {
            counts.as_ref().map_or_else(dash, |c| c.len().to_string())
        };
        let order_1 = |numbers: Option<[f64; 3]>| {
            numbers.map_or_else(dash, |numbers| format!("{:.1}", numbers[1]))
        };
        let map = one.map.as_ref();
        let complete = one.completeness();
        let types = one
            .types
            .as_ref()
            .and_then(|types| effective(types.values().copied()));
        let families = map.and_then(|map| effective(map.sizes()));
        vec![
            hand.label(one, &self.populations),
            one.grasps.to_string(),
            if one.simulated == 0 {
                dash()
            } else {
                format!("{} of {}", one.held, one.simulated)
            },
            map.map_or_else(dash, |map| map.minima.to_string()),
            map.map_or_else(dash, |map| map.families.len().to_string()),
            complete.map_or_else(dash, |told| {
                let [low, high] = told.unseen_interval;
                format!("{:.0} ({low:.0} to {high:.0})", told.unseen)
            }),
            complete.map_or_else(dash, |told| format!("{:.0} %", 100.0 * told.coverage)),
            length(&one.types),
            length(&one.cells),
            one.contacts.len().to_string(),
            order_1(types),
            order_1(families),
            hand.missing_types
                .get(&one.name)
                .map_or_else(String::new, |types| types.join(", ")),
        ]
    }

    fn explanation() -> String {
        format!(
            "Families are grasps of a landscape between which the hand passes over low barriers. \"Families unseen\" is a \
             lower bound of what the grasps have not shown (Chao1, with its 95 % interval), and \"next known\" the chance that \
             one more grasp falls into a known family (Good and Turing). Types and cells are those of the GRASP taxonomy. \
             Contact regions are the digits (and the palm) that are within 2 mm of the object; a set of them is a kind. A usual \
             type is one that at least half of the other objects have. All of this takes the grasps for independent draws: \
             grasps that were chosen to be spread look more diverse than their source.\n\nTypes, cells, sets of contact \
             regions and families are counted as they were observed: more grasps show more of them. Effective numbers are Hill \
             numbers of order 1 (each kind weighed by its frequency), expected in a sample of {LEAST_MEMBERS} of the grasps that \
             are of some kind. They compare objects with different numbers of grasps, and are left out where fewer were \
             counted.\n"
        )
    }

    /// One row for each population (`populations.csv`). Unknown values are empty.
    pub fn populations_csv(&self) -> Vec<u8> {
        let head = [
            "name",
            "file",
            "hand",
            "object",
            "scale",
            "grasps",
            "simulated",
            "held",
            "minima",
            "families",
            "families_unseen",
            "family_coverage",
            "types",
            "cells",
            "contact_region_sets",
        ];
        let mut head: Vec<String> = head.map(str::to_owned).to_vec();
        for what in ["types", "families", "contact_region_sets"] {
            head.extend((0..3).map(|order| format!("effective_{what}_{order}")));
        }
        let rows = self.populations.iter().map(|one| {
            let shown = |number: Option<usize>| {
                number.map_or_else(String::new, |number| number.to_string())
            };
            let known =
                |number: Option<f64>| number.map_or_else(String::new, |number| number.to_string());
            let (map, complete) = (one.map.as_ref(), one.completeness());
            let mut row = vec![
                one.name.clone(),
                one.file.clone(),
                one.hand.clone(),
                one.object.clone(),
                one.scale.to_string(),
                one.grasps.to_string(),
                one.simulated.to_string(),
                shown((one.simulated > 0).then_some(one.held)),
                shown(map.map(|map| map.minima)),
                shown(map.map(|map| map.families.len())),
                known(complete.map(|told| told.unseen)),
                known(complete.map(|told| told.coverage)),
                shown(one.types.as_ref().map(KindCounts::len)),
                shown(one.cells.as_ref().map(KindCounts::len)),
                one.contacts.len().to_string(),
            ];
            let types = one
                .types
                .as_ref()
                .map(|types| types.values().copied().collect());
            let contacts = Some(one.contacts.values().copied().collect());
            for counts in [types, map.map(super::SurveyedMap::sizes), contacts] {
                let numbers = counts.and_then(effective);
                row.extend((0..3).map(|order| known(numbers.map(|numbers| numbers[order]))));
            }
            row
        });
        csv_table(std::iter::once(head).chain(rows))
    }

    /// One row for each kind of each population (`kinds.csv`), with its number of grasps.
    pub fn kinds_csv(&self) -> Vec<u8> {
        let head = ["name", "hand", "object", "what", "kind", "grasps"].map(str::to_owned);
        let rows = self.populations.iter().flat_map(|one| {
            let kinds = [
                ("type", one.types.as_ref()),
                ("cell", one.cells.as_ref()),
                ("set of contact regions", Some(&one.contacts)),
            ];
            let kinds = kinds
                .into_iter()
                .filter_map(|(what, counts)| Some((what, counts?)));
            kinds
                .flat_map(|(what, counts)| {
                    counts
                        .iter()
                        .map(move |(kind, grasps)| (what, kind.clone(), *grasps))
                })
                .chain(one.map.iter().flat_map(|map| {
                    map.families
                        .iter()
                        .enumerate()
                        .map(|(number, family)| ("family", format!("g{number}"), family.grasps))
                }))
                .map(|(what, kind, grasps)| {
                    vec![
                        one.name.clone(),
                        one.hand.clone(),
                        one.object_label(),
                        what.to_owned(),
                        kind,
                        grasps.to_string(),
                    ]
                })
                .collect::<Vec<_>>()
        });
        csv_table(std::iter::once(head.to_vec()).chain(rows))
    }

    /// The survey as JSON, with all that the summary tells.
    pub fn to_json(&self) -> Value {
        let mut value = crate::study::json(self);
        value["made_by"] = json!(MAKER);
        value["objects"] = json!(objects(&self.populations));
        for (place, one) in self.populations.iter().enumerate() {
            let map = one.map.as_ref();
            let types = one.types.as_ref();
            value["populations"][place]["effective"] = json!({
                "types": types.and_then(|types| effective(types.values().copied())),
                "families": map.and_then(|map| effective(map.sizes())),
                "contacts": effective(one.contacts.values().copied()),
            });
            value["populations"][place]["completeness"] = json!(one.completeness());
        }
        for (place, hand) in self.hands.iter().enumerate() {
            let told = &mut value["hands"][place];
            told["objects"] = json!(objects(self.of_hand(hand)));
            told["shared_families"] = json!(hand.shared_families());
            let complete = |counts: &KindCounts| json!(completeness(counts));
            told["completeness"] = json!({
                "types": hand.types.as_ref().map(complete),
                "contacts": complete(&hand.contacts),
            });
        }
        value
    }
}

/// Number of different objects, each size by itself.
fn objects<'a>(populations: impl IntoIterator<Item = &'a SurveyedPopulation>) -> usize {
    let labels = populations
        .into_iter()
        .map(SurveyedPopulation::object_label);
    labels.collect::<BTreeSet<String>>().len()
}

impl HandSurvey {
    /// The numbers of the hand, for the table of all hands.
    fn row(&self, objects: usize) -> Vec<String> {
        let known = |counts: &Option<KindCounts>, all: usize| {
            let counts = counts.as_ref();
            counts.map_or_else(
                || "–".to_owned(),
                |counts| format!("{} of {all}", counts.len()),
            )
        };
        let taxonomy = Taxonomy::feix();
        let [shared, families] = self.shared_families();
        let [shared, families] = [shared, families].map(|number| match families {
            0 => "–".to_owned(),
            _ => number.to_string(),
        });
        vec![
            self.hand.clone(),
            objects.to_string(),
            self.grasps.to_string(),
            known(&self.types, taxonomy.types.len()),
            known(&self.cells, taxonomy.cells().len()),
            self.contacts.len().to_string(),
            families,
            shared,
        ]
    }

    fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        match (&self.types, &self.cells) {
            (Some(types), Some(cells)) => {
                let all = &Taxonomy::feix().types;
                lines.push(format!(
                    "types of the taxonomy: {} of {}{}",
                    types.len(),
                    all.len(),
                    unseen(types, "type")
                ));
                lines.push(format!(
                    "cells of the taxonomy: {} of {}",
                    cells.len(),
                    Taxonomy::feix().cells().len()
                ));
                let none: Vec<&str> = all
                    .iter()
                    .filter(|entry| !types.contains_key(&entry.name))
                    .map(|entry| entry.name.as_str())
                    .collect();
                if !none.is_empty() {
                    lines.push(format!("types on no object: {}", none.join(", ")));
                }
            }
            _ => lines.push("the taxonomy does not apply to this hand".to_owned()),
        }
        lines.push(format!(
            "sets of contact regions: {} observed{}",
            self.contacts.len(),
            unseen(&self.contacts, "set of contact regions")
        ));
        let [shared, families] = self.shared_families();
        if families > 0 {
            let percent = 100.0 * shared as f64 / families as f64;
            lines.push(format!(
                "families: {families} on all objects; {shared} of them ({percent:.0} %) touch with the same digits as a family of \
                 another object"
            ));
        }
        lines
    }

    /// What distinguishes a population among those of the hand: its object, or its name where another has the same object.
    pub(super) fn label(&self, one: &SurveyedPopulation, all: &[SurveyedPopulation]) -> String {
        let label = one.object_label();
        let same = all
            .iter()
            .filter(|other| other.hand == self.hand && other.object_label() == label);
        if same.count() > 1 {
            one.name.clone()
        } else {
            label
        }
    }
}

/// The completeness of pooled kinds.
fn completeness(counts: &KindCounts) -> Option<Completeness> {
    let sizes: Vec<usize> = counts.values().copied().collect();
    Rarefaction::new(&sizes, 2).estimate
}

/// The completeness of pooled kinds, as the end of a sentence.
fn unseen(counts: &KindCounts, kind: &str) -> String {
    let Some(told) = completeness(counts) else {
        return String::new();
    };
    let [low, high] = told.unseen_interval;
    format!(
        "; about {:.0} more unseen ({low:.0} to {high:.0}), and one more grasp of these objects is of a known {kind} with a chance \
         of {:.0} %",
        told.unseen,
        100.0 * told.coverage
    )
}

/// The text of a set of touching digits.
pub(super) fn contacts_label(contacts: &str) -> &str {
    if contacts.is_empty() {
        "nothing"
    } else {
        contacts
    }
}
