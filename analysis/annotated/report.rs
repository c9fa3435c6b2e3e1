//! Tables of agreement, with intervals.

use std::collections::BTreeMap;
use std::fmt::Write;

use landscape::agreement::bootstrap;
use landscape::evaluation::taxonomy::Taxonomy;

use crate::Set;
use crate::case::{Case, Measure};
use crate::learner::Learned;
use crate::reliability::{Bin, calibration_error, reliability as curve, table};

const DRAWS: usize = 2000;
const SEED: u64 = 25;
/// A type with as many grasps (or answers) counts as frequent.
pub(crate) const FREQUENT: usize = 10;

/// A share with the interval that resampling of the objects gives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Share {
    pub(crate) value: f64,
    pub(crate) interval: [f64; 2],
}

/// A mean over cases (or over types), NaN without any.
type Statistic<'a> = &'a (dyn Fn(&[&Case]) -> f64 + Sync);

/// A statistic and its 95 % interval; objects are drawn with replacement, each with all its grasps.
pub(crate) fn over_objects(cases: &[&Case], statistic: Statistic<'_>) -> Share {
    let mut of_object: BTreeMap<&str, Vec<&Case>> = BTreeMap::new();
    for case in cases {
        of_object.entry(&case.object).or_default().push(case);
    }
    let objects: Vec<Vec<&Case>> = of_object.into_values().collect();
    let drawn = bootstrap(&vec![0; objects.len()], DRAWS, SEED, |chosen| {
        let cases: Vec<&Case> = (chosen.iter())
            .flat_map(|object| objects[*object].iter().copied())
            .collect();
        statistic(&cases)
    });
    Share {
        value: statistic(cases),
        interval: drawn.interval(0.95),
    }
}

/// The share of cases that are right.
pub(crate) fn per_grasp(cases: &[&Case], measure: Measure) -> f64 {
    let right = cases.iter().filter(|case| case.right(measure)).count();
    right as f64 / cases.len() as f64
}

/// The mean over the types that occur of the share that is right.
fn per_type(cases: &[&Case], measure: Measure, least: usize) -> f64 {
    let mut of_type: BTreeMap<u8, Vec<&Case>> = BTreeMap::new();
    for case in cases {
        of_type.entry(case.truth.number).or_default().push(case);
    }
    of_type.retain(|_, own| own.len() >= least);
    let shares = of_type.values().map(|own| per_grasp(own, measure));
    shares.sum::<f64>() / of_type.len() as f64
}

/// The share that the commonest answer would get.
pub(crate) fn commonest(cases: &[&Case], measure: Measure) -> Option<f64> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for case in cases {
        *counts.entry(measure.class(case.truth)?).or_default() += 1;
    }
    Some(*counts.values().max()? as f64 / cases.len() as f64)
}

fn percent(share: Share) -> String {
    let Share {
        value,
        interval: [low, high],
    } = share;
    if value.is_nan() {
        return "–".to_owned();
    }
    format!(
        "{:.1} ({:.1} to {:.1})",
        100.0 * value,
        100.0 * low,
        100.0 * high
    )
}

/// Rows of one set of cases.
fn rows(name: &str, cases: &[&Case]) -> String {
    let mut text = format!(
        "\n## {name}\n\n{} grasps of {} objects, {} types.\n\n\
         | % | per grasp (95 % interval) | mean over types | always the commonest |\n|---|---|---|---|\n",
        cases.len(),
        count_of(cases, |case| case.object.clone()),
        count_of(cases, |case| case.truth.name.clone()),
    );
    for measure in Measure::ALL {
        let common = commonest(cases, measure);
        let _ = writeln!(
            text,
            "| {} | {} | {:.1} | {} |",
            measure.name(),
            percent(over_objects(cases, &|cases| per_grasp(cases, measure))),
            100.0 * per_type(cases, measure, 1),
            common.map_or("–".to_owned(), |share| format!("{:.1}", 100.0 * share)),
        );
    }
    let frequent = over_objects(cases, &|cases| per_type(cases, Measure::Type, FREQUENT));
    let _ = writeln!(
        text,
        "| type, mean over types of at least {FREQUENT} grasps | {} | | |",
        percent(frequent)
    );
    text
}

fn count_of(cases: &[&Case], of: impl Fn(&Case) -> String) -> usize {
    let names: std::collections::BTreeSet<String> = cases.iter().map(|case| of(case)).collect();
    names.len()
}

/// For each type: its grasps, how many are named right, what it is taken for, and how precise the answer is.
fn types(cases: &[&Case]) -> String {
    let mut text =
        "\n| type | grasps | cell right | type right | answered | precision | taken for |\n|---|---|---|---|---|---|---|\n"
            .to_owned();
    for entry in &Taxonomy::feix().types {
        let own: Vec<&&Case> = (cases.iter())
            .filter(|case| case.truth.number == entry.number)
            .collect();
        let answered = cases
            .iter()
            .filter(|case| case.found_type().is_some_and(|f| f.number == entry.number))
            .count();
        if own.is_empty() && answered == 0 {
            continue;
        }
        let right = own.iter().filter(|case| case.right(Measure::Type)).count();
        let cell = own.iter().filter(|case| case.right(Measure::Cell)).count();
        let mut taken: BTreeMap<&str, usize> = BTreeMap::new();
        for case in own.iter().filter(|case| !case.right(Measure::Type)) {
            let found = case.found_type().map_or("nothing", |found| &found.name);
            *taken.entry(found).or_default() += 1;
        }
        let mut taken: Vec<(&str, usize)> = taken.into_iter().collect();
        taken.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
        let taken: Vec<String> = (taken.iter())
            .map(|(name, count)| format!("{name} ×{count}"))
            .collect();
        let precision = if answered == 0 {
            "–".to_owned()
        } else {
            format!("{:.0} %", 100.0 * right as f64 / answered as f64)
        };
        let _ = writeln!(
            text,
            "| {} {} | {} | {cell} | {right} | {answered} | {precision} | {} |",
            entry.number,
            entry.name,
            own.len(),
            taken.join(", ")
        );
    }
    text
}

/// Bins of the best type's score.
pub(crate) fn reliability(cases: &[&Case]) -> Vec<Bin> {
    let answered = cases.iter().filter_map(|case| {
        let best = case.label.best.first()?;
        Some((best.score, case.right(Measure::Type)))
    });
    curve(answered).to_vec()
}

fn calibration(cases: &[&Case]) -> String {
    let bins = reliability(cases);
    format!(
        "\nExpected calibration error of the type's score: {:.3}.\n\n{}",
        calibration_error(&bins),
        table("score", "grasps", &bins)
    )
}

/// One row for each set, and one for the commonest answer.
fn summary(sets: &[Set], learned: &Learned) -> String {
    let mut text = "\n| % of grasps | grasps |".to_owned();
    for measure in Measure::ALL {
        let _ = write!(text, " {} |", measure.name());
    }
    text += "\n|---|---|---|---|---|---|---|---|---|\n";
    let mut row = |name: &str, cases: &[&Case], share: &dyn Fn(Measure) -> Option<f64>| {
        let _ = write!(text, "| {name} | {} |", cases.len());
        for measure in Measure::ALL {
            let told =
                share(measure).map_or("–".to_owned(), |share| format!("{:.1}", 100.0 * share));
            let _ = write!(text, " {told} |");
        }
        text.push('\n');
    };
    let mut first = 0;
    for set in sets {
        let all: Vec<&Case> = set.cases.iter().collect();
        let start = first;
        first += all.len();
        row(&set.name, &all, &|measure| Some(per_grasp(&all, measure)));
        row(
            &format!("always the commonest, {}", set.short),
            &all,
            &|measure| commonest(&all, measure),
        );
        if set.posed_by_people {
            let told = |keep: &dyn Fn(&Case) -> bool, measure: Measure| {
                let kept = all.iter().enumerate().filter(|(_, case)| keep(case));
                let right = kept.map(|(i, case)| learned.right(start + i, case.truth, measure));
                let right: Vec<bool> = right.collect::<Option<_>>()?;
                let count = right.iter().filter(|right| **right).count();
                Some(count as f64 / right.len() as f64)
            };
            row(&format!("learner, {}", set.short), &all, &|measure| {
                told(&|_| true, measure)
            });
            let agree: Vec<&Case> = all.iter().copied().filter(|case| case.agrees).collect();
            row(
                &format!("learner, label agrees with contact, {}", set.short),
                &agree,
                &|measure| told(&|case| case.agrees, measure),
            );
            row(
                &format!("label agrees with contact, {}", set.short),
                &agree,
                &|measure| Some(per_grasp(&agree, measure)),
            );
        }
    }
    text
}

/// The whole report.
pub(crate) fn report(sets: &[Set], learned: &Learned, version: &str) -> String {
    let mut text = format!(
        "# Labels of grasps that people posed and named\n\n`LANDSCAPE_TEST_DATA=… cargo run --release --example annotated`, \
         rule {version}.\n\nRight: the rule's best guess, also where its label is only a cell or a category. Intervals: 95 %, \
         from {DRAWS} resamplings of the objects, each with all its grasps. *Agrees with contact*: all of both virtual fingers \
         touch, the palm exactly where the type needs it, and no other finger. *Always the commonest*: the share that the \
         commonest class of these very grasps would get. *Learner*: multinomial logistic regression on the same facts, each grasp \
         named by a model of people's grasps of all other objects; it learns the habits of the annotators, too.\n"
    );
    text += &summary(sets, learned);
    for set in sets {
        let all: Vec<&Case> = set.cases.iter().collect();
        text += &rows(&set.name, &all);
        if set.posed_by_people {
            let agree: Vec<&Case> = all.iter().copied().filter(|case| case.agrees).collect();
            text += &rows(&format!("{}, label agrees with contact", set.name), &agree);
        }
        text += &calibration(&all);
        text += &types(&all);
    }
    text
}
