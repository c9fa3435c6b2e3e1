//! What a labeller learns from people's labels → `figures/teaching.md`, `figures/teaching.{svg,png}`
//!
//! `LANDSCAPE_TEST_DATA=FOLDER cargo run --release --example teaching`. The folder holds `ycb_affordance`: grasps that people
//! posed and named. The labeller is judged on objects that were left out. Then teaching is simulated: a tenth of the objects is
//! left out, and of the grasps of the others the labels are asked in two orders, ten at a time: what the labeller is least
//! sure of, and at random. Nothing that is taught here is part of the project.

#[expect(
    dead_code,
    reason = "it does not matter here whether a label agrees with contact"
)]
mod people;

use std::fmt::Write;

use landscape::evaluation::taxonomy::{
    Category, Example, Labeller, Regression, Rule, Taught, TaughtWith, Taxonomy, answer,
};
use landscape::figure::chart::{Axis, BandPoint, Chart, Corner, Panel, Series};
use landscape::sample::{Task, stream};
use people::People;
use rand::seq::SliceRandom;
use rayon::prelude::*;

type Failure = Box<dyn std::error::Error + Send + Sync>;

const SEED: u64 = 59;
const FOLDS: usize = 10;
/// Orders of each kind for each tenth.
const REPEATS: usize = 10;
const BATCH: usize = 10;
const MEASURES: [&str; 3] = ["category", "cell", "type"];
const ORDERS: [&str; 2] = ["least sure first", "random order"];

/// Shares of right categories, cells and types after each batch of labels.
type Curve = Vec<[f64; 3]>;

fn main() -> Result<(), Failure> {
    let examples = examples()?;
    let with = TaughtWith {
        file: "ycb_affordance".to_owned(),
        content_hash: String::new(),
        labels: examples.len(),
        hands: Vec::new(),
        objects: Vec::new(),
    };
    let taught = Taught::of(&examples, vec![with], &Rule::standard().version)?;
    let mut objects: Vec<&str> = examples.iter().map(|e| e.group.as_str()).collect();
    objects.sort_unstable();
    objects.dedup();
    objects.shuffle(&mut stream(SEED, Task::Permutation, 0));
    // Each tenth of the objects with each repetition.
    let runs: Vec<(usize, usize)> = (0..FOLDS)
        .flat_map(|fold| (0..REPEATS).map(move |repeat| (fold, repeat)))
        .collect();
    let curves: Vec<[Curve; 2]> = runs
        .par_iter()
        .map(|(fold, repeat)| {
            let own: Vec<&str> = objects.iter().copied().skip(*fold).step_by(FOLDS).collect();
            let is_left_out = |example: &&Example| own.contains(&&*example.group);
            let (test, pool): (Vec<&Example>, Vec<&Example>) =
                examples.iter().partition(is_left_out);
            let id = 1 + (fold * REPEATS + repeat) as u64;
            [true, false].map(|unsure| curve(&pool, &test, unsure, id))
        })
        .collect();
    // Of each tenth as many grasps are right as it has, so that each grasp counts once in each repetition.
    let mean = |order: usize, step: usize, measure: usize| {
        let at = |curves: &[Curve; 2]| curves[order].get(step).map_or(0.0, |right| right[measure]);
        curves.iter().map(at).sum::<f64>() / (REPEATS * examples.len()) as f64
    };
    let steps = curves
        .iter()
        .map(|curves| curves[0].len())
        .min()
        .unwrap_or(0);
    let told: Vec<[[f64; 3]; 2]> = (0..steps)
        .map(|step| [0, 1].map(|order| [0, 1, 2].map(|measure| 100.0 * mean(order, step, measure))))
        .collect();
    std::fs::write("figures/teaching.md", report(&taught, &told)?)?;
    let picture = chart(&taught, &told).draw()?;
    for end in ["svg", "png"] {
        picture.save(format!("figures/teaching.{end}").as_ref())?;
    }
    Ok(())
}

fn examples() -> Result<Vec<Example>, Failure> {
    let people = People::read()?;
    let names: Vec<&String> = people.grasps.keys().collect();
    let of_object = |name: &String| -> Result<Vec<Example>, Failure> {
        let object = people.object(name)?;
        let labeller = Labeller::new(&people.hand, &object, Rule::standard());
        let example = |grasp: &people::Posed| {
            let (features, rule) = labeller.example(&grasp.x, &labeller.label(&grasp.x))?;
            Some(Example {
                group: name.clone(),
                features,
                rule,
                class: usize::from(grasp.label) - 1,
            })
        };
        Ok(people.grasps[name].iter().filter_map(example).collect())
    };
    let all: Vec<Vec<Example>> = names
        .into_par_iter()
        .map(of_object)
        .collect::<Result<_, _>>()?;
    Ok(all.concat())
}

/// Numbers of the test grasps whose category, cell and type are right, after 0, 10, 20, … labels of the pool.
fn curve(pool: &[&Example], test: &[&Example], unsure: bool, id: u64) -> Curve {
    let mut order: Vec<usize> = (0..pool.len()).collect();
    order.shuffle(&mut stream(SEED, Task::Permutation, id));
    let mut curve = vec![right(test, None)];
    let mut asked: Vec<Example> = Vec::new();
    let mut taught: Option<Regression> = None;
    while !order.is_empty() {
        if let (true, Some(taught)) = (unsure, &taught) {
            // The next ones stand last.
            order.sort_by(|a, b| sure(taught, pool[*b]).total_cmp(&sure(taught, pool[*a])));
        }
        let from = order.len().saturating_sub(BATCH);
        asked.extend(order.drain(from..).map(|place| pool[place].clone()));
        let regression = Regression::of(&asked);
        curve.push(right(test, Some(&regression)));
        taught = Some(regression);
    }
    curve
}

fn probabilities(taught: Option<&Regression>, example: &Example) -> Vec<f64> {
    let told =
        taught.and_then(|taught| taught.probabilities(&example.features, &example.rule).ok());
    told.unwrap_or_else(|| example.rule.clone())
}

/// The probability of the answer.
fn sure(taught: &Regression, example: &Example) -> f64 {
    let told = probabilities(Some(taught), example);
    told[answer(&told)]
}

fn right(test: &[&Example], taught: Option<&Regression>) -> [f64; 3] {
    let types = &Taxonomy::feix().types;
    let mut right = [0.0; 3];
    for example in test {
        let answer = match taught {
            Some(_) => answer(&probabilities(taught, example)),
            None => by_rule(&example.rule),
        };
        let (Some(found), Some(truth)) = (types.get(answer), types.get(example.class)) else {
            continue;
        };
        let equal = [
            found.category == truth.category,
            found.cell == truth.cell,
            answer == example.class,
        ];
        for (right, equal) in right.iter_mut().zip(equal) {
            *right += f64::from(u8::from(equal));
        }
    }
    right
}

/// The rule's best guess: it chooses the category first.
fn by_rule(rule: &[f64]) -> usize {
    let types = || Taxonomy::feix().types.iter().zip(rule);
    let of = |category: Category| -> f64 {
        let own = types().filter(|(entry, _)| entry.category == category);
        own.map(|(_, p)| p).sum()
    };
    let categories = [Category::Power, Category::Precision, Category::Intermediate];
    let most = categories
        .into_iter()
        .max_by(|a, b| of(*a).total_cmp(&of(*b)));
    let own = types()
        .enumerate()
        .filter(|(_, (entry, _))| Some(entry.category) == most);
    let best = own.max_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b));
    best.map_or(0, |(class, _)| class)
}

fn report(taught: &Taught, told: &[[[f64; 3]; 2]]) -> Result<String, Failure> {
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    let with = |share: f64, [low, high]: [f64; 2]| {
        format!("{} ({} to {})", percent(share), percent(low), percent(high))
    };
    let mut text = format!(
        "# A labeller that people teach\n\n`LANDSCAPE_TEST_DATA=… cargo run --release --example teaching`. {} grasps that people \
         posed and named. The labeller names each grasp without having seen any of the same object, settings included. Intervals: \
         95 %, from resampled objects. Nothing that is taught here is part of the project.\n\n\
         | % right | labeller | rule | labeller less rule | commonest answer | calibration error |\n|---|---|---|---|---|---|\n",
        taught.count(),
    );
    for judged in &taught.judged {
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {:.3} |",
            judged.name,
            with(judged.labeller_share, judged.labeller_interval_share),
            with(judged.rule_share, judged.rule_interval_share),
            with(judged.gain_share, judged.gain_interval_share),
            percent(judged.commonest_share),
            judged.calibration_error
        )?;
    }
    text += "\n## What its words are worth\n\n| answer | number | % right |\n|---|---|---|\n";
    for of in &taught.certainties {
        writeln!(
            text,
            "| {}, {} | {} | {} |",
            of.name,
            of.certainty,
            of.answers,
            percent(of.right_share)
        )?;
    }
    write!(
        text,
        "\n## Teaching\n\nA tenth of the objects is left out and judged; the labels of the others are asked {BATCH} at a time, in {REPEATS} \
         random orders, or first those of which the labeller that was taught so far is least sure. Each grasp is judged once in \
         each order.\n\n![Shares of right answers against the number of labels](teaching.png)\n\n\
         | labels |"
    )?;
    for measure in MEASURES {
        for order in ORDERS {
            write!(text, " {measure}, {order} |")?;
        }
    }
    text += "\n|---|---|---|---|---|---|---|\n";
    for (step, told) in told.iter().enumerate() {
        write!(text, "| {} |", step * BATCH)?;
        for measure in 0..MEASURES.len() {
            for order in told {
                write!(text, " {:.1} |", order[measure])?;
            }
        }
        text.push('\n');
    }
    Ok(text)
}

fn named(name: &str, series: Series) -> Series {
    Series {
        name: name.to_owned(),
        ..series
    }
}

fn chart(taught: &Taught, told: &[[[f64; 3]; 2]]) -> Chart {
    let most = (told.len().saturating_sub(1) * BATCH) as f64;
    let panel = |(measure, judged): (usize, &landscape::evaluation::taxonomy::Judged)| {
        let mut series = vec![named(
            "all labels, 95 % interval",
            Series::band(
                [0.0, most]
                    .map(|x| BandPoint {
                        x,
                        lower: 100.0 * judged.labeller_interval_share[0],
                        upper: 100.0 * judged.labeller_interval_share[1],
                    })
                    .to_vec(),
            ),
        )];
        for (order, name) in ORDERS.into_iter().enumerate() {
            let points = told.iter().enumerate();
            let points = points.map(|(step, told)| [(step * BATCH) as f64, told[order][measure]]);
            series.push(named(name, Series::line(points.collect())));
        }
        let mut panel = Panel::new(
            MEASURES[measure],
            Axis::linear("labels that were asked").with_range(0.0, most),
            Axis::linear("% right on left-out objects").with_range(0.0, 100.0),
            series,
        );
        panel.legend = (measure == 0).then_some(Corner::LowerRight);
        panel
    };
    let mut chart = Chart::new("", taught.judged.iter().enumerate().map(panel).collect());
    chart.columns = 3;
    chart
}
