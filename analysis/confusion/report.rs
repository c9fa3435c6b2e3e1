//! Tables of right labels and of confusions.

use std::collections::BTreeMap;
use std::fmt::Write;

use landscape::evaluation::taxonomy::{Category, GraspType, Rule, Taxonomy, Verdict};

use crate::Condition;
use crate::judge::{Outcome, halves, share};

pub(crate) fn report(conditions: &[Condition], rule: &Rule) -> String {
    let mut text = format!(
        "# Labels of grasps whose type is known\n\n`cargo run --release --example confusion`, rule {}.\n\
         Right: the answer is of the true category, cell, type, however precise the label is. *Accepted*: not unlisted. In brackets: \
         accepted and right.\n\n\
         | grasps | count | category | opposition | cell | type | type among best three | accepted | cell only | others | others accepted |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
        rule.version
    );
    for condition in conditions {
        let [known, others] = halves(&condition.outcomes);
        let told = |of: &[&Outcome], test: &dyn Fn(&Outcome) -> bool| {
            share(of, test).map_or("–".to_owned(), |share| format!("{share:.3}"))
        };
        let right = |within: u8| {
            format!(
                "{} ({})",
                told(&known, &|outcome| outcome.right(within)),
                told(&known, &|outcome| outcome.right(within)
                    && outcome.accepted())
            )
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            condition.name,
            known.len(),
            right(3),
            right(2),
            right(1),
            right(0),
            told(&known, &|outcome| {
                let best = &outcome.label.best;
                best.iter().any(|best| Some(best.number) == outcome.truth)
            }),
            told(&known, &Outcome::accepted),
            told(&known, &|outcome| matches!(
                outcome.label.verdict,
                Verdict::Ambiguous(_)
            )),
            others.len(),
            told(&others, &Outcome::accepted),
        );
    }
    let feix = Taxonomy::feix();
    let types: Vec<String> = feix.types.iter().map(spell).collect();
    let cells: Vec<String> = feix.cells().iter().map(ToString::to_string).collect();
    let names = [Category::Power, Category::Intermediate, Category::Precision]
        .map(|category| category.name().to_owned());
    for condition in conditions {
        let _ = writeln!(text, "\n## {}\n", condition.name);
        let tables = [
            taken_for(condition, "category", &names, &|entry: &GraspType| {
                entry.category.name().to_owned()
            }),
            taken_for(condition, "cell", &cells, &|entry: &GraspType| {
                entry.cell.clone()
            }),
            taken_for(condition, "type", &types, &spell),
        ];
        for table in tables {
            text += &table;
            text.push('\n');
        }
        text += &accepted_others(condition);
    }
    text
}

fn spell(entry: &GraspType) -> String {
    format!("{} {}", entry.number, entry.name)
}

/// Labels given to each class.
fn taken_for(
    condition: &Condition,
    head: &str,
    classes: &[String],
    class: &dyn Fn(&GraspType) -> String,
) -> String {
    let feix = Taxonomy::feix();
    let of = |number: Option<u8>| Some(class(feix.numbered(number?)?));
    let mut text = format!("| {head} | grasps | right | taken for |\n|---|---|---|---|\n");
    for own in classes {
        let mut taken: BTreeMap<String, usize> = BTreeMap::new();
        let mut count = 0;
        for outcome in &condition.outcomes {
            if of(outcome.truth).as_ref() == Some(own) {
                count += 1;
                let found = of(outcome.found()).unwrap_or_else(|| "nothing".to_owned());
                *taken.entry(found).or_default() += 1;
            }
        }
        if count == 0 {
            continue;
        }
        let right = taken.remove(own).unwrap_or(0);
        let mut taken: Vec<(String, usize)> = taken.into_iter().collect();
        taken.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        let taken: Vec<String> = taken
            .iter()
            .map(|(name, count)| format!("{name} ×{count}"))
            .collect();
        let _ = writeln!(text, "| {own} | {count} | {right} | {} |", taken.join(", "));
    }
    text
}

/// Poses outside the taxonomy that are given a type.
fn accepted_others(condition: &Condition) -> String {
    let [_, others] = halves(&condition.outcomes);
    let mut taken: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for outcome in others.iter().filter(|outcome| outcome.accepted()) {
        *taken
            .entry((&outcome.id, outcome.label.text()))
            .or_default() += 1;
    }
    let taken: Vec<String> = taken
        .iter()
        .map(|((id, label), count)| format!("{id} as {label} ×{count}"))
        .collect();
    if taken.is_empty() {
        String::new()
    } else {
        format!(
            "No grasps of the taxonomy, yet accepted: {}.\n",
            taken.join(", ")
        )
    }
}
