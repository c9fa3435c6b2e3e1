//! The answer in one line, the table, the sentence for a paper and the JSON of a comparison.

use std::fmt::Write;

use serde_json::{Value, json};

use super::{Counted, DiversityComparison, Measure};
use crate::agreement::{Estimated, Ratio};
use crate::figure::MAKER;
use crate::study::markdown::table;

/// The order that is told first: each kind by its frequency.
const FIRST: usize = 1;

/// What the ratios of a measure say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Verdict {
    /// At some order, this set is above all others, and at no order another set is.
    Most(usize),
    /// At one order one set is above all others, and at another order another set.
    Orders,
    /// No set is above all others.
    Open,
    /// The numbers stand side by side, but they are not comparable.
    Apart,
}

/// Two sets whose ratio at one order is told.
#[derive(Debug, Clone, Copy)]
struct Pair {
    order: usize,
    /// That of the greater number.
    more: usize,
    less: usize,
    ratio: Ratio,
}

impl Measure {
    /// Whether at least two sets have this measure.
    fn compares(&self) -> bool {
        self.known().count() > 1
    }

    fn verdict(&self) -> Verdict {
        let mut found = self.most.into_iter().flatten();
        match found.next() {
            None if self.ratios.is_empty() => Verdict::Apart,
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

    /// The set that is above all others at this order, otherwise that with the greatest number, beside the next one.
    fn pair(&self, order: usize) -> Option<Pair> {
        let number = |set: &usize| self.sets[*set].map_or(0.0, |orders| orders[order].value);
        let mut sets: Vec<usize> = self.known().collect();
        // At equal numbers the set that was named first.
        sets.sort_by(|a, b| number(b).total_cmp(&number(a)).then(a.cmp(b)));
        if let Some(most) = self.most[order] {
            sets.sort_by_key(|set| *set != most);
        }
        let [more, less, ..] = sets[..] else {
            return None;
        };
        let ratio = self.ratio([more, less])?[order];
        Some(Pair {
            order,
            more,
            less,
            ratio,
        })
    }

    /// The order that is told: the first one, or one at which a set is above all others.
    fn told_order(&self) -> usize {
        let decided = |order: &usize| self.most[*order].is_some();
        [FIRST, 0, 2].into_iter().find(decided).unwrap_or(FIRST)
    }
}

impl DiversityComparison {
    /// Which set is the most diverse and by how much, in one line.
    ///
    /// A set is called the most diverse (of two: the more diverse) where the 95 % interval of its ratio to each other set lies
    /// above 1. Otherwise the line tells the largest ratio, and how many grasps would show one of this size.
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
        let told = |verdict: &Verdict| {
            let of = compared
                .iter()
                .filter(|measure| measure.verdict() == *verdict);
            self.told(*verdict, &of.copied().collect::<Vec<_>>())
        };
        let mut answer = verdicts.iter().map(told).collect::<Vec<_>>().join(" ");
        if verdicts.contains(&Verdict::Open) {
            answer += " That no difference shows does not mean that the sets are equal.";
        }
        answer
    }

    /// One sentence on the measures with this verdict.
    fn told(&self, verdict: Verdict, measures: &[&Measure]) -> String {
        let by = listed(
            &measures
                .iter()
                .map(|measure| measure.named())
                .collect::<Vec<_>>(),
        );
        let two = self.names.len() == 2;
        let pairs =
            |measure: &&Measure| Some(self.spelled(measure, &measure.pair(measure.told_order())?));
        match verdict {
            Verdict::Most(set) => {
                let name = &self.names[set];
                let ratios: Vec<String> = measures.iter().filter_map(pairs).collect();
                format!(
                    "{name} is the {} diverse by {by}: it has {}.",
                    if two { "more" } else { "most" },
                    listed(&ratios)
                )
            }
            Verdict::Orders => {
                let orders = |measure: &&Measure| -> Vec<String> {
                    let decided = (0..3).filter(|order| measure.most[*order].is_some());
                    let pair = |order| {
                        let pair = measure.pair(order)?;
                        Some(format!(
                            "{} has {}",
                            self.names[pair.more],
                            self.spelled(measure, &pair)
                        ))
                    };
                    decided.filter_map(pair).collect()
                };
                let ratios: Vec<String> = measures.iter().flat_map(orders).collect();
                format!(
                    "By {by} the orders disagree, because one set has more kinds and another spreads its grasps more evenly over \
                     them: {}.",
                    listed(&ratios)
                )
            }
            Verdict::Open => {
                let open = |measure: &&Measure| {
                    let pair = measure.pair(FIRST)?;
                    let ratio = self.spelled(measure, &pair);
                    let planned = planned(&pair.ratio);
                    Some(format!("{} has {ratio}{planned}", self.names[pair.more]))
                };
                let ratios: Vec<String> = measures.iter().filter_map(open).collect();
                let shown = if two {
                    format!("These grasps show no difference in {by}")
                } else {
                    format!("These grasps do not show which set is the most diverse by {by}")
                };
                format!("{shown}: {}.", ratios.join("; "))
            }
            Verdict::Apart => format!("The {by} cannot be compared: the notes say why."),
        }
    }

    /// For instance `1.3 times as many effective types as a (order 1, 95 % interval 0.7 to 2.1)`.
    fn spelled(&self, measure: &Measure, pair: &Pair) -> String {
        let [value, low, high] = shown(&pair.ratio);
        let next = if self.names.len() > 2 {
            ", the next"
        } else {
            ""
        };
        format!(
            "{value} times as many effective {} as {}{next} (order {}, 95 % interval {low} to {high})",
            measure.of.name(),
            self.names[pair.less],
            pair.order
        )
    }

    /// Of two sets, the one whose ratio to the other has a column of its own, and the other: that of the answer first.
    fn beside(&self) -> Option<[usize; 2]> {
        let pairs = (self.measures.iter()).filter_map(|measure| measure.pair(measure.told_order()));
        let first = pairs
            .filter(|_| self.names.len() == 2)
            .min_by_key(|pair| !pair.ratio.differs());
        first.map(|pair| [pair.more, pair.less])
    }

    /// A sentence with all numbers of the comparison at order 1, to be copied; `None` if nothing is compared.
    pub fn sentence(&self) -> Option<String> {
        let compared: Vec<&Measure> = self
            .measures
            .iter()
            .filter(|m| !m.ratios.is_empty())
            .collect();
        let part = |measure: &&Measure| {
            let pair = measure.pair(FIRST)?;
            let [value, low, high] = shown(&pair.ratio);
            let numbers: Vec<String> = (measure.known())
                .filter_map(|set| {
                    let [low, high] = measure.sets[set]?[FIRST].interval;
                    let value = measure.sets[set]?[FIRST].value;
                    let name = &self.names[set];
                    Some(format!("{value:.1} [{low:.1}, {high:.1}] in {name}"))
                })
                .collect();
            Some(format!(
                "the effective number of {} is {} in samples of {} grasps, a ratio of {value} [{low}, {high}] ({} to {})",
                measure.of.name(),
                listed(&numbers),
                measure.grasps,
                self.names[pair.more],
                self.names[pair.less],
            ))
        };
        let parts: Vec<String> = compared.iter().filter_map(part).collect();
        if parts.is_empty() {
            return None;
        }
        let sizes = self.names.iter().zip(&self.grasps);
        let sizes: Vec<String> = sizes
            .map(|(name, grasps)| format!("{name} n = {grasps}"))
            .collect();
        let families = if compared
            .iter()
            .any(|measure| measure.of == Counted::Families)
        {
            "; those of families span the intervals at half and at twice their level"
        } else {
            ""
        };
        Some(format!(
            "By Hill numbers of order {FIRST}, rarefied to equal numbers of grasps (Chao et al. 2014; {}), {}; brackets are 95 % \
             intervals from {} bootstrap resamplings of each set, that of a ratio by a normal approximation of its logarithm, \
             and no narrower than chance makes it between samples of one community{families} ({MAKER} {}, seed {}).",
            sizes.join(", "),
            parts.join("; "),
            self.settings.resamplings,
            env!("CARGO_PKG_VERSION"),
            self.settings.seed,
        ))
    }

    /// The numbers of a single set.
    fn alone(&self) -> String {
        let number = |measure: &Measure| {
            let number = measure.sets[0].map_or(f64::NAN, |orders| orders[1].value);
            format!("{number:.1} effective {}", measure.of.name())
        };
        let numbers: Vec<String> = self.measures.iter().map(number).collect();
        format!("{} has {} (order 1).", self.names[0], listed(&numbers))
    }

    /// The answer, the table and the notes as Markdown.
    pub fn markdown(&self) -> String {
        let sizes: Vec<String> = (self.names.iter().zip(&self.grasps))
            .map(|(name, grasps)| format!("{name} ({grasps} grasps)"))
            .collect();
        let mut text = format!("# Diversity of {}\n\n{}\n\n", listed(&sizes), self.answer());
        let beside = self.beside();
        let ratio =
            beside.map(|[one, other]| format!("{} to {}", self.names[one], self.names[other]));
        let mut head = vec!["effective number of", "order"];
        head.extend(self.names.iter().map(String::as_str));
        head.extend(ratio.as_deref());
        let mut rows = Vec::new();
        for measure in &self.measures {
            for order in 0..3 {
                let what = format!("{}, of {} grasps", measure.of.name(), measure.grasps);
                let mut row = vec![what, order.to_string()];
                let numbers = measure.sets.iter().enumerate();
                row.extend(numbers.map(|(set, orders)| {
                    let Some(orders) = orders else {
                        return "–".to_owned();
                    };
                    let highest = measure.most[order] == Some(set);
                    let mark = if highest { "**" } else { "" };
                    format!("{mark}{}{mark}", bracketed(&orders[order]))
                }));
                row.extend(beside.map(|sets| match measure.ratio(sets) {
                    Some(orders) => {
                        let [value, low, high] = shown(&orders[order]);
                        format!("{value} [{low}, {high}]")
                    }
                    None => "–".to_owned(),
                }));
                rows.push(row);
            }
        }
        text += &table(&head, rows);
        text.push_str(
            "\nAn effective number says how many equally frequent kinds would be as diverse. Order 0 counts all kinds alike, order 1 \
             weighs each by its frequency, order 2 shows how many are frequent. All sets are rarefied to the same number of \
             grasps. In brackets: 95 % intervals.",
        );
        if self.names.len() > 1 {
            text.push_str(
                " Bold: more than in every other set, because the interval of the ratio lies above 1. The intervals of two \
                 sets may overlap although their ratio differs from 1, and an interval of a ratio that contains 1 does not \
                 mean equality. Each ratio is judged by itself: of twenty that are 1, one is called different by chance.",
            );
        }
        text.push('\n');
        if let Some(sentence) = self.sentence() {
            let _ = writeln!(text, "\nFor a paper: {sentence}");
        }
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
        value["sentence"] = json!(self.sentence());
        value
    }
}

/// How many grasps would show the ratio, as the end of a sentence.
fn planned(ratio: &Ratio) -> String {
    match ratio.members_needed {
        // Two figures are told, because the estimate is no better.
        Some(needed) => {
            let figures = needed.checked_ilog10().unwrap_or(0);
            let unit = 10_usize.pow(figures.saturating_sub(1));
            let told = needed.div_ceil(unit) * unit;
            format!(
                "; about {told} grasps in each set would show a difference of this size in four of five comparisons"
            )
        }
        None => String::new(),
    }
}

/// A ratio and its bounds with as many digits as tell the bounds from 1.
fn shown(ratio: &Ratio) -> [String; 3] {
    let numbers = [ratio.value, ratio.interval[0], ratio.interval[1]];
    let tells = |digits: &usize| {
        numbers[1..].iter().all(|bound| {
            (bound - 1.0).abs() < 1e-9
                || (bound - 1.0).abs() >= 0.5 * 0.1_f64.powi(i32::try_from(*digits).unwrap_or(4))
        })
    };
    let digits = (1..4).find(tells).unwrap_or(4);
    numbers.map(|number| format!("{number:.digits$}"))
}

fn bracketed(number: &Estimated) -> String {
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
