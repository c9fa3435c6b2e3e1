//! What more fitting to fixtures would bring → `figures/fitted_to_fixtures.md`
//!
//! `LANDSCAPE_TEST_DATA=FOLDER cargo run --release --example fitted_to_fixtures -- [--output FILE.md]`
//!
//! A regression on the facts that the rule sees is added to the rule's probabilities and fitted to widened fixtures. It names
//! fixtures that took no part, and people's grasps of the objects that were looked at. Only fixtures on objects of one solid
//! are used, because the others take hours. The third of people's objects that was not looked at stays closed.

#[expect(dead_code, reason = "the learners of `annotated` are not asked")]
#[path = "../annotated/case.rs"]
mod case;
#[expect(dead_code, reason = "the palm is not read differently")]
#[path = "../annotated/contact.rs"]
mod contact;
#[expect(dead_code, reason = "nothing is learned from people here")]
#[path = "../annotated/learner.rs"]
mod learner;
#[expect(dead_code, reason = "the fitted poses are not needed")]
#[path = "../annotated/people.rs"]
mod people;
#[path = "../widened_sets.rs"]
mod widened_sets;

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use landscape::evaluation::taxonomy::{Category, GraspType, Label, Rule, Sharpness, Taxonomy};
use nalgebra::DMatrix;
use rayon::prelude::*;
use widened_sets::judge::judge;
use widened_sets::{conditions, scenes};

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Weights of the squares of the coefficients.
const RIDGES: [f64; 3] = [0.1, 0.01, 0.001];
/// Conditions under which fixtures are labelled for the fit, and those that are judged.
const FITTED: usize = 4;
const JUDGED: [usize; 2] = [0, 2];
/// The scenes are divided into so many parts to choose the ridge.
const PARTS: usize = 5;
/// Errors of the poses of the fixtures that are fitted, and of those that are judged.
const SEEDS: [u64; 2] = [5, 1005];
/// A probability of 0 counts as this one.
const LEAST: f64 = 1e-6;

/// Labels of one origin with the true types.
struct Set {
    name: String,
    labels: Vec<Label>,
    truths: Vec<&'static GraspType>,
    /// The authored scene or the object of each.
    origins: Vec<String>,
}

impl Set {
    fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            labels: Vec::new(),
            truths: Vec::new(),
            origins: Vec::new(),
        }
    }

    fn push(&mut self, label: Label, truth: &'static GraspType, origin: &str) {
        self.labels.push(label);
        self.truths.push(truth);
        self.origins.push(origin.to_owned());
    }
}

/// The labels of the fixtures of a file that have a type, under some of the [`conditions`]. The id of a widened fixture is that
/// of its scene and the name of its hand.
fn of_fixtures(
    file: &str,
    authored: &[&str],
    rule: &Rule,
    wanted: &[usize],
    seed: u64,
) -> Result<Vec<Set>, Failure> {
    let scenes = scenes(file, authored)?;
    let of_condition = |&place: &usize| -> Result<Set, Failure> {
        // No two conditions share their random numbers.
        let (name, noise) = conditions(seed + place as u64)[place];
        let mut set = Set::named(&format!("fixtures that took no part, {name}"));
        for outcome in judge(&scenes, rule, noise)? {
            let truth = outcome
                .truth
                .and_then(|number| Taxonomy::feix().numbered(number));
            if let Some(truth) = truth {
                let scene = outcome.id.rsplit_once('-').map_or("", |(scene, _)| scene);
                set.push(outcome.label, truth, scene);
            }
        }
        Ok(set)
    };
    wanted.iter().map(of_condition).collect()
}

/// People's grasps of the objects that were looked at: all, and those whose label agrees with contact.
fn of_people(data: &Path, rule: &Rule) -> Result<[Set; 2], Failure> {
    let wanted = |object: &str| !people::UNSEEN.contains(&object);
    let folder = data.join("ycb_affordance");
    let cases = people::cases(&folder, people::Model::Mano, rule, wanted)?;
    let mut sets = [
        Set::named("people's grasps, looked at"),
        Set::named("these, label agrees with contact"),
    ];
    for case in cases {
        if case.agrees {
            sets[1].push(case.label.clone(), case.truth, &case.object);
        }
        sets[0].push(case.label, case.truth, &case.object);
    }
    Ok(sets)
}

/// Logarithms of the probabilities of the rule.
fn before(labels: &[&Label]) -> DMatrix<f64> {
    DMatrix::from_fn(labels.len(), Taxonomy::feix().types.len(), |row, kind| {
        let told = labels[row].types.get(kind);
        libm::log(told.map_or(0.0, |told| told.score).max(LEAST))
    })
}

/// Who names grasps.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Who {
    Rule,
    /// The regression decides on everything.
    Fitted,
    /// The rule decides on the category, the regression on the type in it.
    WithinCategory,
}

/// The type that is named: the most probable one of the most probable category, as in the rule. `None` where too little touches
/// for any type.
fn named(who: Who, label: &Label, told: &[f64]) -> Option<&'static GraspType> {
    let best = label.best.first()?;
    if who == Who::Rule {
        return Taxonomy::feix().numbered(best.number);
    }
    let types = || Taxonomy::feix().types.iter().zip(told);
    let sum = |category: Category| -> f64 {
        let own = types().filter(|(entry, _)| entry.category == category);
        own.map(|(_, p)| *p).sum()
    };
    let category = match who {
        Who::WithinCategory => label.category?,
        _ => [Category::Power, Category::Precision, Category::Intermediate]
            .into_iter()
            .max_by(|a, b| sum(*a).total_cmp(&sum(*b)))?,
    };
    let own = types().filter(|(entry, _)| entry.category == category);
    own.max_by(|a, b| a.1.total_cmp(b.1))
        .map(|(entry, _)| entry)
}

/// Whether category, cell and type are right.
fn right(found: Option<&GraspType>, truth: &GraspType) -> [bool; 3] {
    [3, 1, 0].map(|within| found.is_some_and(|found| truth.distance(found) <= within))
}

/// A row: the shares that are right, and how many grasps are gained and lost against the rule.
fn row(set: &Set, who: Who, name: &str, told: &DMatrix<f64>) -> String {
    let mut text = format!("| {} | {} | {name} |", set.name, set.labels.len());
    let answers = set.labels.iter().zip(&set.truths).enumerate();
    let pairs: Vec<[[bool; 3]; 2]> = answers
        .map(|(place, (label, truth))| {
            let told: Vec<f64> = told.row(place).iter().copied().collect();
            [Who::Rule, who].map(|who| right(named(who, label, &told), truth))
        })
        .collect();
    for level in 0..3 {
        let count = |test: &dyn Fn(bool, bool) -> bool| {
            let passing = pairs
                .iter()
                .filter(|[rule, own]| test(rule[level], own[level]));
            passing.count()
        };
        let share = 100.0 * count(&|_, own| own) as f64 / pairs.len().max(1) as f64;
        let _ = write!(text, " {share:.1} |");
        if who == Who::Rule {
            text += " – |";
        } else {
            let (gained, lost) = (
                count(&|rule, own| own && !rule),
                count(&|rule, own| rule && !own),
            );
            let _ = write!(text, " +{gained} −{lost} |");
        }
    }
    text + "\n"
}

/// What the fit rests on: the features, the logarithms of the rule's probabilities, the types and the scenes.
struct Seen {
    rows: DMatrix<f64>,
    before: DMatrix<f64>,
    types: Vec<usize>,
    scenes: Vec<String>,
}

impl Seen {
    /// The labels with these numbers.
    fn only(&self, chosen: &[usize]) -> Self {
        Self {
            rows: self.rows.select_rows(chosen),
            before: self.before.select_rows(chosen),
            types: chosen.iter().map(|&k| self.types[k]).collect(),
            scenes: chosen.iter().map(|&k| self.scenes[k].clone()).collect(),
        }
    }

    fn fit(&self, ridge: f64) -> DMatrix<f64> {
        learner::fit(&self.rows, &self.before, &self.types, ridge)
    }

    /// Mean of −ln of the probability of the true type, for labels of scenes that took no part in the fit.
    fn loss_of_unseen_scenes(&self, ridge: f64) -> f64 {
        let names: BTreeSet<&str> = self.scenes.iter().map(String::as_str).collect();
        let names: Vec<&str> = names.into_iter().collect();
        let part = |scene: &str| names.binary_search(&scene).unwrap_or_default() % PARTS;
        let of_part = |number: usize| -> f64 {
            let (own, others): (Vec<usize>, Vec<usize>) =
                (0..self.types.len()).partition(|&k| part(&self.scenes[k]) == number);
            let coefficients = self.only(&others).fit(ridge);
            let unseen = self.only(&own);
            let told = learner::probabilities(&unseen.rows, &unseen.before, &coefficients);
            let types = unseen.types.iter().enumerate();
            types
                .map(|(row, &kind)| -libm::log(told[(row, kind)].max(LEAST)))
                .sum()
        };
        let losses: Vec<f64> = (0..PARTS).into_par_iter().map(of_part).collect();
        losses.iter().sum::<f64>() / self.types.len() as f64
    }
}

/// The head of the report: what was fitted to what, and the loss of each ridge.
fn head(rule: &Rule, seen: &Seen, losses: &[f64]) -> String {
    let scenes: BTreeSet<&str> = seen.scenes.iter().map(String::as_str).collect();
    let mut text = format!(
        "# What more fitting to fixtures would bring\n\n`LANDSCAPE_TEST_DATA=… cargo run --release --example \
         fitted_to_fixtures`, rule {}.\n\nA multinomial logistic regression on the facts, forms and width that the rule sees, \
         added to the logarithms of the rule's probabilities. Its {} coefficients are fitted to {} labels of widened fixtures of \
         {} scenes, on four hands and with errors of their poses. It is then asked about fixtures of other scenes on the same \
         hands, and about people's grasps. The rule was made with these grasps of people in view; the regression never saw them.\n\n\
         *Ridge*: the weight of the squares of the coefficients; the smaller it is, the more closely the fixtures are followed. The \
         loss is the mean of −ln of the probability of the true type on scenes that were left out, a fifth at a time:\n\n\
         | ridge | loss of scenes that were left out |\n|---|---|\n",
        rule.version,
        seen.rows.ncols() * seen.before.ncols(),
        seen.types.len(),
        scenes.len(),
    );
    for (ridge, loss) in RIDGES.iter().zip(losses) {
        let _ = writeln!(text, "| {ridge} | {loss:.3} |");
    }
    text + "\n*Types only*: the rule decides on the category, the regression on the type in it. *Without coefficients*: the rule's \
            probabilities as they are. Fixtures on which too little touches count as wrong. Right, %, and the grasps that are gained \
            and lost against the rule:\n\n\
            | grasps | number | who | category | against the rule | cell | against the rule | type | against the rule |\n\
            |---|---|---|---|---|---|---|---|---|\n"
}

fn main() -> Result<(), Failure> {
    let mut output = PathBuf::from("figures/fitted_to_fixtures.md");
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--output" => output = arguments.next().ok_or("--output needs a file")?.into(),
            _ => return Err(format!("{argument} is not known").into()),
        }
    }
    let data = std::env::var_os("LANDSCAPE_TEST_DATA").ok_or("LANDSCAPE_TEST_DATA is not set")?;
    // The rule decides by the fits as they are, not by the probabilities that it tells.
    let mut rule = Rule::standard().clone();
    rule.sharpness = Sharpness {
        least: 1.0,
        by_fit: 0.0,
    };
    let all: Vec<usize> = (0..FITTED).collect();
    let authored = ["development", "held_out"];
    let fitted = of_fixtures("widened", &authored, &rule, &all, SEEDS[0])?;
    let authored = ["second_held_out"];
    let mut judged = of_fixtures("widened_held_out", &authored, &rule, &JUDGED, SEEDS[1])?;
    judged.extend(of_people(Path::new(&data), &rule)?);

    // All labels together, so that a column means the same everywhere.
    let sets = || fitted.iter().chain(&judged);
    let labels: Vec<&Label> = sets().flat_map(|set| &set.labels).collect();
    let (features, before) = (learner::features(&labels), before(&labels));
    let truths = fitted.iter().flat_map(|set| &set.truths);
    let types: Vec<usize> = truths.map(|truth| usize::from(truth.number) - 1).collect();
    let with_types: Vec<usize> = (0..types.len())
        .filter(|&k| !labels[k].types.is_empty())
        .collect();
    let [rows, weights] = [&features, &before].map(|all| all.rows(0, types.len()).into_owned());
    let seen = Seen {
        rows,
        before: weights,
        scenes: (fitted.iter().flat_map(|set| set.origins.clone())).collect(),
        types,
    };
    let mut first = seen.types.len();
    let seen = seen.only(&with_types);

    let losses = RIDGES.map(|ridge| seen.loss_of_unseen_scenes(ridge));
    let coefficients = RIDGES.map(|ridge| seen.fit(ridge));
    let none = DMatrix::zeros(features.ncols(), before.ncols());
    let mut text = head(&rule, &seen, &losses);
    for set in &judged {
        let count = set.labels.len();
        let [rows, weights] = [&features, &before].map(|all| all.rows(first, count).into_owned());
        first += count;
        let told = |coefficients| learner::probabilities(&rows, &weights, coefficients);
        text += &row(set, Who::Rule, "rule", &weights);
        text += &row(set, Who::Fitted, "without coefficients", &told(&none));
        for (ridge, coefficients) in RIDGES.iter().zip(&coefficients) {
            let told = told(coefficients);
            text += &row(set, Who::Fitted, &format!("ridge {ridge}"), &told);
            let name = format!("ridge {ridge}, types only");
            text += &row(set, Who::WithinCategory, &name, &told);
        }
    }
    println!("{text}");
    let draft = output.with_extension("md.new");
    std::fs::write(&draft, &text)?;
    std::fs::rename(draft, output)?;
    Ok(())
}
