//! Tables of right labels and of confusions.

use std::collections::BTreeMap;
use std::fmt::Write;

use landscape::evaluation::taxonomy::{Category, GraspType, Rule, Taxonomy, Verdict};

use crate::Condition;
use crate::judge::{Outcome, halves, share};

/// The report, and a CSV of all confusions. The report has those of the conditions that are `shown`.
pub(crate) fn report(conditions: &[Condition], shown: &[Condition], rule: &Rule) -> [String; 2] {
    let mut text = format!(
        "# Labels of grasps whose type is known\n\n`cargo run --release --example confusion`, rule {}. \
         [taxonomy_confusion.csv](taxonomy_confusion.csv) has all confusions.\n\n\
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
    let mut csv = "grasps,what,class,number,right,taken for\n".to_owned();
    for condition in conditions {
        for row in confusions(condition) {
            let Row { what, class, .. } = row;
            let [number, right] = row.counts.map_or([String::new(), String::new()], |counts| {
                counts.map(|count| count.to_string())
            });
            let _ = writeln!(
                csv,
                "\"{}\",{what},{class},{number},{right},{}",
                condition.name,
                row.taken.join("; ")
            );
        }
    }
    for condition in shown {
        let _ = write!(
            text,
            "\n## Wrong answers: {}\n\n| class | grasps | right | taken for |\n|---|---|---|---|\n",
            condition.name
        );
        for row in confusions(condition) {
            if !row.taken.is_empty() {
                let counts = row.counts.map_or("– | –".to_owned(), |[number, right]| {
                    format!("{number} | {right}")
                });
                let _ = writeln!(
                    text,
                    "| {} | {counts} | {} |",
                    row.class,
                    row.taken.join(", ")
                );
            }
        }
    }
    [text, csv]
}

/// What the grasps of one class are taken for.
struct Row {
    /// `category`, `cell`, `type` or `outside` the taxonomy.
    what: &'static str,
    class: String,
    /// Number of grasps, and of right answers; `None` outside the taxonomy.
    counts: Option<[usize; 2]>,
    /// Wrong answers with their numbers, the commonest first.
    taken: Vec<String>,
}

/// Rows of all categories, cells and types, and of poses outside the taxonomy that are given a type.
fn confusions(condition: &Condition) -> Vec<Row> {
    let feix = Taxonomy::feix();
    let categories = [Category::Power, Category::Intermediate, Category::Precision]
        .map(|category| category.name().to_owned());
    let cells: Vec<String> = feix.cells().iter().map(ToString::to_string).collect();
    let types: Vec<String> = feix.types.iter().map(spell).collect();
    let of_category = |entry: &GraspType| entry.category.name().to_owned();
    let mut rows = taken_for(condition, "category", &categories, &of_category);
    rows.extend(taken_for(condition, "cell", &cells, &|entry| {
        entry.cell.clone()
    }));
    rows.extend(taken_for(condition, "type", &types, &spell));
    rows.extend(accepted_others(condition));
    rows
}

fn spell(entry: &GraspType) -> String {
    format!("{} {}", entry.number, entry.name)
}

/// Labels given to each class.
fn taken_for(
    condition: &Condition,
    what: &'static str,
    classes: &[String],
    class: &dyn Fn(&GraspType) -> String,
) -> Vec<Row> {
    let feix = Taxonomy::feix();
    let of = |number: Option<u8>| Some(class(feix.numbered(number?)?));
    let mut rows = Vec::new();
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
        rows.push(Row {
            what,
            class: own.clone(),
            counts: Some([count, right]),
            taken: taken.iter().map(counted).collect(),
        });
    }
    rows
}

fn counted((name, count): &(String, usize)) -> String {
    format!("{name} ×{count}")
}

/// Poses outside the taxonomy that are given a type.
fn accepted_others(condition: &Condition) -> Vec<Row> {
    let [_, others] = halves(&condition.outcomes);
    let mut taken: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for outcome in others.iter().filter(|outcome| outcome.accepted()) {
        *taken
            .entry((&outcome.id, outcome.label.text()))
            .or_default() += 1;
    }
    let row = |((id, label), count): ((&str, &str), usize)| Row {
        what: "outside",
        class: id.to_owned(),
        counts: None,
        taken: vec![counted(&(label.to_owned(), count))],
    };
    taken.into_iter().map(row).collect()
}
