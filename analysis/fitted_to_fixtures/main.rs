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
#[path = "../../tests/taxonomy/fixture.rs"]
mod fixture;
#[expect(dead_code, reason = "tests need shares")]
#[path = "../../tests/taxonomy/judge.rs"]
mod judge;
#[expect(dead_code, reason = "nothing is learned from people here")]
#[path = "../annotated/learner.rs"]
mod learner;
#[expect(dead_code, reason = "the fitted poses are not needed")]
#[path = "../annotated/people.rs"]
mod people;
#[expect(
    dead_code,
    reason = "what only `pose_fixtures` calls makes widened fixtures"
)]
#[path = "../../tests/taxonomy/widened.rs"]
mod widened;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use judge::{Case as Scene, Error, Noise, judge, read, widened_cases};
use landscape::evaluation::taxonomy::{Category, GraspType, Label, Rule, Taxonomy};
use nalgebra::DMatrix;

type Failure = Box<dyn std::error::Error + Send + Sync>;

const FOLDER: &str = "tests/taxonomy/fixtures";
/// Weights of the squares of the coefficients.
const RIDGES: [f64; 3] = [0.1, 0.03, 0.01];
const SEED: u64 = 5;
/// A probability of 0 counts as this one.
const LEAST: f64 = 1e-6;

/// Labels of one origin, and the true types.
struct Set {
    name: String,
    labels: Vec<Label>,
    truths: Vec<&'static GraspType>,
}

/// The errors of the poses under which fixtures are labelled.
fn conditions() -> [(&'static str, Noise); 4] {
    let of = |joints_rad, place_m| Noise {
        error: Error::Moved,
        joints_rad,
        place_m,
        copies: 1,
        seed: SEED,
    };
    [
        ("as posed", of(0.0, 0.0)),
        ("joints moved by 0.1 rad", of(0.1, 0.0)),
        ("moved by 3 mm and 0.05 rad", of(0.05, 0.003)),
        ("moved by 5 mm and 0.15 rad", of(0.15, 0.005)),
    ]
}

/// The widened fixtures of a file that belong to these authored ones.
fn scenes(file: &str, names: &[&str]) -> Result<Vec<Scene>, Failure> {
    let mut authored = Vec::new();
    for name in names {
        authored.extend(read(Path::new(&format!("{FOLDER}/{name}.json")))?);
    }
    authored.retain(|fixture| fixture.object.len() == 1);
    widened_cases(Path::new(&format!("{FOLDER}/{file}.json")), authored)
}

/// The labels of the fixtures that have a type, under each condition. Those on which too little touches have none.
fn of_fixtures(scenes: &[Scene], rule: &Rule) -> Result<Vec<Set>, Failure> {
    let of_condition = |(name, noise): (&str, Noise)| -> Result<Set, Failure> {
        let (mut labels, mut truths) = (Vec::new(), Vec::new());
        for outcome in judge(scenes, rule, noise)? {
            let truth = outcome
                .truth
                .and_then(|number| Taxonomy::feix().numbered(number));
            if let (Some(truth), false) = (truth, outcome.label.types.is_empty()) {
                labels.push(outcome.label);
                truths.push(truth);
            }
        }
        Ok(Set {
            name: format!("fixtures that took no part, {name}"),
            labels,
            truths,
        })
    };
    conditions().into_iter().map(of_condition).collect()
}

/// People's grasps of the objects that were looked at: all, and those whose label agrees with contact.
fn of_people(data: &Path, rule: &Rule) -> Result<[Set; 2], Failure> {
    let wanted = |object: &str| !people::UNSEEN.contains(&object);
    let cases = people::cases(
        &data.join("ycb_affordance"),
        people::Model::Mano,
        rule,
        wanted,
    )?;
    let of = |name: &str, all: bool| {
        let own = cases.iter().filter(|case| all || case.agrees);
        let (labels, truths) = own.map(|case| (case.label.clone(), case.truth)).unzip();
        Set {
            name: name.to_owned(),
            labels,
            truths,
        }
    };
    Ok([
        of("people's grasps, looked at", true),
        of("these, label agrees with contact", false),
    ])
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

/// The type that is named: the most probable one of the most probable category, as in the rule.
fn named(who: Who, label: &Label, told: &[f64]) -> Option<&'static GraspType> {
    if who == Who::Rule {
        return Taxonomy::feix().numbered(label.best.first()?.number);
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
    let rule = Rule::standard();
    let fitted = of_fixtures(&scenes("widened", &["development", "held_out"])?, rule)?;
    let mut judged = of_fixtures(&scenes("widened_held_out", &["second_held_out"])?, rule)?;
    judged.extend(of_people(Path::new(&data), rule)?);

    // All labels together, so that a column means the same everywhere.
    let all = || fitted.iter().chain(&judged);
    let labels: Vec<&Label> = all().flat_map(|set| &set.labels).collect();
    let (features, before) = (learner::features(&labels), before(&labels));
    let seen: Vec<usize> = (fitted.iter().flat_map(|set| &set.truths))
        .map(|truth| usize::from(truth.number) - 1)
        .collect();
    let [rows, weights] = [&features, &before].map(|all| all.rows(0, seen.len()).into_owned());
    let coefficients = RIDGES.map(|ridge| learner::fit(&rows, &weights, &seen, ridge));

    let mut text = format!(
        "# What more fitting to fixtures would bring\n\n`LANDSCAPE_TEST_DATA=… cargo run --release --example \
         fitted_to_fixtures`, rule {}.\n\nA multinomial logistic regression on the facts, forms and width that the rule sees, \
         added to the logarithms of the rule's probabilities. It is fitted to {} labels of widened fixtures under {} conditions \
         and asked about fixtures that took no part and about people's grasps. *Ridge*: the weight of the squares of its \
         coefficients; a smaller one follows the fixtures more closely. *Types only*: the rule decides on the category, the \
         regression on the type in it. Right, %, and the grasps that are gained and lost against the rule:\n\n\
         | grasps | number | who | category | against the rule | cell | against the rule | type | against the rule |\n\
         |---|---|---|---|---|---|---|---|---|\n",
        rule.version,
        seen.len(),
        fitted.len()
    );
    let mut first = seen.len();
    for set in &judged {
        let count = set.labels.len();
        let [rows, weights] = [&features, &before].map(|all| all.rows(first, count).into_owned());
        first += count;
        text += &row(set, Who::Rule, "rule", &weights);
        for (ridge, coefficients) in RIDGES.iter().zip(&coefficients) {
            let told = learner::probabilities(&rows, &weights, coefficients);
            text += &row(set, Who::Fitted, &format!("ridge {ridge}"), &told);
            text += &row(
                set,
                Who::WithinCategory,
                &format!("ridge {ridge}, types only"),
                &told,
            );
        }
    }
    println!("{text}");
    let draft = output.with_extension("md.new");
    std::fs::write(&draft, &text)?;
    std::fs::rename(draft, output)?;
    Ok(())
}
