//! The answer in one line, the table and the JSON of a comparison.

use std::fmt::Write;

use serde_json::{Value, json};

use super::{Counted, DiversityComparison, Measure};
use crate::agreement::Estimated;
use crate::figure::MAKER;

/// What the intervals of a measure say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Verdict {
    /// At some order, this set is above all others, and at no order another set is.
    Most(usize),
    /// At one order one set is above all others, and at another order another set.
    Orders,
    /// No set is above all others.
    Open,
}

impl Measure {
    /// Whether at least two sets have this measure.
    fn compares(&self) -> bool {
        self.sets.iter().flatten().count() > 1
    }

    fn verdict(&self) -> Verdict {
        let mut found = self.most.into_iter().flatten();
        match found.next() {
            None => Verdict::Open,
            Some(set) if found.all(|other| other == set) => Verdict::Most(set),
            Some(_) => Verdict::Orders,
        }
    }

    /// The name, with the orders if one set is above all others at some of them only.
    fn named(&self) -> String {
        let orders: Vec<String> = (0..3)
            .filter(|order| self.most[*order].is_some())
            .map(|order| order.to_string())
            .collect();
        let name = self.of.name();
        match (self.verdict(), orders.len()) {
            (Verdict::Most(_), 1) => format!("{name} (order {} only)", orders[0]),
            (Verdict::Most(_), 2) => format!("{name} (orders {} only)", orders.join(" and ")),
            _ => name.to_owned(),
        }
    }
}

impl DiversityComparison {
    /// Which set is the most diverse, in one line.
    ///
    /// A set is called the most diverse (of two: the more diverse) where its 95 % interval lies above those of all others. Where intervals overlap,
    /// nothing is called.
    pub fn answer(&self) -> String {
        if self.names.len() == 1 {
            return self.alone();
        }
        let compared: Vec<&Measure> = self.measures.iter().filter(|m| m.compares()).collect();
        if compared.is_empty() {
            return "Nothing can be compared: the notes say why.".to_owned();
        }
        let mut verdicts: Vec<Verdict> = compared.iter().map(|measure| measure.verdict()).collect();
        verdicts.sort_unstable();
        verdicts.dedup();
        let sentence = |verdict: &Verdict| {
            let of = compared
                .iter()
                .filter(|measure| measure.verdict() == *verdict);
            let by = listed(&of.map(|measure| measure.named()).collect::<Vec<_>>());
            match verdict {
                Verdict::Most(set) => {
                    let (most, others) = match self.names.len() {
                        2 => ("more", "the other"),
                        _ => ("most", "all others"),
                    };
                    format!(
                        "{} is the {most} diverse by {by}: its intervals lie above those of {others}.",
                        self.names[*set]
                    )
                }
                Verdict::Orders => format!(
                    "By {by} one set has more kinds and another spreads its grasps more evenly over them: the orders disagree."
                ),
                Verdict::Open if self.names.len() == 2 => {
                    format!("By {by} no difference can be told.")
                }
                Verdict::Open => {
                    format!("By {by} it cannot be told which one is the most diverse.")
                }
            }
        };
        verdicts.iter().map(sentence).collect::<Vec<_>>().join(" ")
    }

    /// The numbers of a single set.
    fn alone(&self) -> String {
        let number = |measure: &Measure| {
            let number = measure.sets[0].map_or(f64::NAN, |orders| orders[1].value);
            format!("{number:.1} effective {}", measure.of.spelled())
        };
        let numbers: Vec<String> = self.measures.iter().map(number).collect();
        format!("{} holds {} (order 1).", self.names[0], listed(&numbers))
    }

    /// The answer, the table and the notes as Markdown.
    pub fn markdown(&self) -> String {
        let sizes: Vec<String> = (self.names.iter().zip(&self.grasps))
            .map(|(name, grasps)| format!("{name} ({grasps} grasps)"))
            .collect();
        let mut text = format!("# Diversity of {}\n\n{}\n\n", listed(&sizes), self.answer());
        let mut rows = vec![["effective number of", "order"].map(str::to_owned).to_vec()];
        rows[0].extend(self.names.iter().cloned());
        for measure in &self.measures {
            for order in 0..3 {
                let what = format!("{}, of {} grasps", measure.of.spelled(), measure.grasps);
                let mut row = vec![what, order.to_string()];
                let numbers = measure.sets.iter().enumerate();
                row.extend(numbers.map(|(set, orders)| {
                    let Some(orders) = orders else {
                        return "–".to_owned();
                    };
                    let highest = measure.most[order] == Some(set);
                    let mark = if highest { "**" } else { "" };
                    format!("{mark}{}{mark}", spelled(&orders[order]))
                }));
                rows.push(row);
            }
        }
        text.push_str(&table(&rows));
        text.push_str(
            "\nOrder 0 counts all kinds alike, order 1 weighs each by its frequency, order 2 shows how many are frequent. All sets \
             are rarefied to the same number of grasps. In brackets: 95 % intervals; bold: above those of all other sets.\n",
        );
        for note in &self.notes {
            let _ = writeln!(text, "\nNote: {note}.");
        }
        text
    }

    /// The comparison as JSON.
    pub fn to_json(&self) -> Value {
        let mut value = crate::study::json(self);
        value["made_by"] = json!(MAKER);
        value["answer"] = json!(self.answer());
        value
    }
}

impl Counted {
    /// Plural noun for one set's kinds.
    fn spelled(self) -> &'static str {
        match self {
            Self::Contacts => "sets of contact regions",
            other => other.name(),
        }
    }
}

fn spelled(number: &Estimated) -> String {
    let [low, high] = number.interval;
    format!("{:.1} [{low:.1}, {high:.1}]", number.value)
}

/// `a, b and c`.
fn listed(names: &[String]) -> String {
    match names.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
        None => String::new(),
    }
}

/// A Markdown table whose columns are aligned as plain text, too.
fn table(rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
    let mut text = String::new();
    for (number, row) in rows.iter().enumerate() {
        for (cell, width) in row.iter().zip(&widths) {
            let _ = write!(text, "| {cell:<width$} ");
        }
        text.push_str("|\n");
        if number == 0 {
            for width in &widths {
                let _ = write!(text, "|{}", "-".repeat(width + 2));
            }
            text.push_str("|\n");
        }
    }
    text
}
