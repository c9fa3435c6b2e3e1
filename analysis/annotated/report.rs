//! Tables of agreement, with intervals.

use std::collections::BTreeMap;
use std::fmt::Write;

use landscape::agreement::bootstrap;
use landscape::evaluation::taxonomy::Taxonomy;
use landscape::sample::{Task, stream};
use rand::RngExt;

use crate::case::{Case, Measure};
use crate::reliability::{Bin, calibration_error, reliability as curve};
use crate::{Failure, Set, limits, pairs, targets};

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

/// Cases that are told of together.
pub(crate) struct View<'a> {
    name: String,
    pub(crate) short: &'static str,
    pub(crate) posed_by_people: bool,
    pub(crate) cases: Vec<&'a Case>,
}

impl<'a> View<'a> {
    /// A view of each set and, before the templates, one of all that people posed.
    fn of_all(sets: &'a [Set]) -> Vec<Self> {
        let view = |set: &'a Set| View {
            name: set.name.clone(),
            short: set.short,
            posed_by_people: set.posed_by_people,
            cases: set.cases.iter().collect(),
        };
        let (people, others): (Vec<&Set>, Vec<&Set>) =
            sets.iter().partition(|set| set.posed_by_people);
        let mut views: Vec<Self> = people.iter().map(|set| view(set)).collect();
        if people.len() > 1 {
            views.push(View {
                name: "People's grasps, all".to_owned(),
                short: "all",
                posed_by_people: true,
                cases: people.iter().flat_map(|set| &set.cases).collect(),
            });
        }
        views.extend(others.iter().map(|set| view(set)));
        views
    }

    /// The cases whose label agrees with contact.
    pub(crate) fn agreeing(&self) -> Vec<&'a Case> {
        self.cases
            .iter()
            .copied()
            .filter(|case| case.agrees)
            .collect()
    }
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

/// The mean over these types, as far as they occur, of the share of cases that are right.
pub(crate) fn per_type(cases: &[&Case], measure: Measure, types: &[u8]) -> f64 {
    let shares = types.iter().filter_map(|number| {
        let own: Vec<&Case> = of_type(cases, *number);
        (!own.is_empty()).then(|| per_grasp(&own, measure))
    });
    let shares: Vec<f64> = shares.collect();
    shares.iter().sum::<f64>() / shares.len() as f64
}

/// The cases to which the person gave this type.
fn of_type<'a>(cases: &[&'a Case], number: u8) -> Vec<&'a Case> {
    let own = cases.iter().filter(|case| case.truth.number == number);
    own.copied().collect()
}

/// The types of which there are at least so many grasps.
pub(crate) fn types_of(cases: &[&Case], least: usize) -> Vec<u8> {
    let all = Taxonomy::feix().types.iter().map(|entry| entry.number);
    all.filter(|number| of_type(cases, *number).len() >= least.max(1))
        .collect()
}

/// The share that the commonest answer would get.
pub(crate) fn commonest(cases: &[&Case], measure: Measure) -> Option<f64> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for case in cases {
        *counts.entry(measure.class(case.truth)?).or_default() += 1;
    }
    Some(*counts.values().max()? as f64 / cases.len() as f64)
}

/// A share in percent, or a dash.
pub(crate) fn percent(share: f64) -> String {
    if share.is_nan() {
        "–".to_owned()
    } else {
        format!("{:.1}", 100.0 * share)
    }
}

/// A share in percent with its interval, or a dash.
fn with_interval(Share { value, interval }: Share) -> String {
    if value.is_nan() {
        return percent(value);
    }
    let [low, high] = interval.map(percent);
    format!("{} ({low} to {high})", percent(value))
}

/// How far the scores of each view are from the shares that are right.
fn probabilities(views: &[View<'_>]) -> String {
    let mut text = "\n## Probabilities\n\n\
         The calibration error of the type's score, and what it would be of exact probabilities: on average, and exceeded in one \
         set of twenty.\n\n\
         | grasps | number | objects | types | error | 95 % interval | exact, average | exact, one of twenty |\n\
         |---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for View { short, cases, .. } in views {
        let Share {
            value,
            interval: [low, high],
        } = over_objects(cases, &|cases| calibration_error(&reliability(cases)));
        let [mean, rare] = error_by_chance(cases);
        let _ = writeln!(
            text,
            "| {short} | {} | {} | {} | {value:.3} | {low:.3} to {high:.3} | {mean:.3} | {rare:.3} |",
            cases.len(),
            count_of(cases, |case| case.object.clone()),
            types_of(cases, 1).len(),
        );
    }
    text
}

fn count_of(cases: &[&Case], of: impl Fn(&Case) -> String) -> usize {
    let names: std::collections::BTreeSet<String> = cases.iter().map(|case| of(case)).collect();
    names.len()
}

/// Rows of the CSV: for each type its grasps, how many are named right, how often it is answered and what it is taken for.
fn types(View { short, cases, .. }: &View<'_>) -> String {
    let mut text = String::new();
    for entry in &Taxonomy::feix().types {
        let own = of_type(cases, entry.number);
        let answered = answered(cases, entry.number);
        if own.is_empty() && answered == 0 {
            continue;
        }
        let right = |measure| own.iter().filter(|case| case.right(measure)).count();
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
        let _ = writeln!(
            text,
            "{short},{},{},{},{},{},{answered},{}",
            entry.number,
            entry.name,
            own.len(),
            right(Measure::Cell),
            right(Measure::Type),
            taken.join("; ")
        );
    }
    text
}

/// How often this type is answered.
pub(crate) fn answered(cases: &[&Case], number: u8) -> usize {
    let answered = |case: &&&Case| case.found_type().is_some_and(|f| f.number == number);
    cases.iter().filter(answered).count()
}

/// Bins of the best type's score.
pub(crate) fn reliability(cases: &[&Case]) -> Vec<Bin> {
    let answered = cases.iter().filter_map(|case| {
        let best = case.label.best.first()?;
        Some((best.score, case.right(Measure::Type)))
    });
    curve(answered).to_vec()
}

/// What the calibration error of these scores would be if they were exact, that is, if each answer were right with the
/// probability of its score and independently of the others: the mean, and the value that one of twenty draws exceeds.
fn error_by_chance(cases: &[&Case]) -> [f64; 2] {
    let scores = (cases.iter()).filter_map(|case| Some(case.label.best.first()?.score));
    let scores: Vec<f64> = scores.collect();
    let mut rng = stream(SEED, Task::Start, 0);
    let drawn = (0..DRAWS).map(|_| {
        let answers = scores
            .iter()
            .map(|&score| (score, rng.random_bool(score.min(1.0))));
        calibration_error(&curve(answers))
    });
    let mut errors: Vec<f64> = drawn.collect();
    errors.sort_by(f64::total_cmp);
    [
        errors.iter().sum::<f64>() / DRAWS as f64,
        errors[DRAWS * 19 / 20],
    ]
}

/// Three rows for each view: all, the commonest answer, and those whose label agrees with contact.
fn summary(views: &[View<'_>]) -> String {
    let mut text = "\n## In short\n\n| % of grasps | grasps |".to_owned();
    for measure in Measure::ALL {
        let _ = write!(text, " {} |", measure.name());
    }
    text += "\n|---|---|---|---|---|---|---|---|---|\n";
    let mut row = |name: &str, cases: &[&Case], cell: &dyn Fn(Measure) -> String| {
        let cells = Measure::ALL.map(cell);
        let _ = writeln!(text, "| {name} | {} | {} |", cases.len(), cells.join(" | "));
    };
    for view in views {
        let (all, agree, short) = (&view.cases, view.agreeing(), view.short);
        row(&view.name, all, &|measure| share_right(all, measure));
        row(&format!("always the commonest, {short}"), all, &|measure| {
            percent(commonest(all, measure).unwrap_or(f64::NAN))
        });
        let name = format!("label agrees with contact, {short}");
        row(&name, &agree, &|measure| share_right(&agree, measure));
    }
    text
}

/// The share of cases that are right, in percent with its interval.
fn share_right(cases: &[&Case], measure: Measure) -> String {
    with_interval(over_objects(cases, &|cases| per_grasp(cases, measure)))
}

/// The report and the CSV of the types. With `whole`, the report has the targets and what limits the rule.
pub(crate) fn report(
    sets: &[Set],
    whole: bool,
    version: &str,
) -> Result<(String, String), Failure> {
    let mut text = format!(
        "# Labels of grasps that people posed and named\n\n`LANDSCAPE_TEST_DATA=… cargo run --release --example annotated`, \
         rule {version}. [annotated_grasps.csv](annotated_grasps.csv) has each type.\n\n\
         - *Seen* objects were looked at while the rule was made, *unseen* ones were not.\n\
         - *Right*: the rule's best guess, also where its label is only a cell or a category.\n\
         - *Agrees with contact*: all of both virtual fingers touch, the palm exactly where the type needs it, and no other \
         finger except helping ones of the type.\n\
         - *Always the commonest*: the share that the commonest class of these grasps would get.\n\
         - Intervals: 95 %, from {DRAWS} resamplings of the objects, each with all its grasps.\n"
    );
    let views = View::of_all(sets);
    if whole {
        text += &targets::targets(&views)?;
    }
    text += &summary(&views);
    if whole {
        text += &limits::limits(&views);
        text += &pairs::near_pairs(&views);
    }
    text += &probabilities(&views);
    let mut csv =
        "grasps,number,type,grasps of it,cell right,type right,answered,taken for\n".to_owned();
    csv.extend(views.iter().map(types));
    Ok((text, csv))
}
