//! Table I of Liu et al. (2021): how many grasps hold in simulation → `figures/stability.md`, `.png`, `.csv`
//!
//! Every end of every chain is simulated, whether it passes a filter or not, so that each filter and each score can be
//! compared on the same population. Finished objects are kept in the `.csv`; a run goes on after the last of them.
//! `--quick`: few chains, into `target/`.

#[path = "yields/interval.rs"]
mod interval;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use interval::interval;
use landscape::agreement::Roc;
use landscape::figure::chart::{Axis, Chart, Corner, Panel, Series};
use landscape::grasp::filter::AUTHORS_UNIT_M;
use landscape::grasp::hand::Hand;
use landscape::grasp::object::Object;
use landscape::grasp::stability::{Build, Drop, Protocol, SixDirections, Solid, simulate};
use landscape::grasp::synthesis::{SynthesisSettings, synthesize};
use landscape::grasp::{EnergySettings, GraspEnergy, judge, measure_contacts};
use landscape::optimize::QuenchSettings;
use rayon::prelude::*;

const SEED: u64 = 6;
const BOTTLES: [&str; 6] = [
    "bottle_flask",
    "bottle_medicine",
    "bottle_round",
    "bottle_square",
    "bottle_squeeze",
    "bottle_water",
];
/// Simple shapes, as published evaluations have them among their objects.
const SIMPLE: [&str; 3] = ["ball", "box", "can"];
/// Chains of each bottle that go through the six directions, too, which cost twenty times as much as the drop.
const PUSHED: u64 = 30;
/// `drop`, `six` and `rigid`: 1 held, 0 not, −1 not simulated.
const COLUMNS: &str = "object,chain,net_wrench,friction,epsilon,sigma_m,force_closure,published,strict,drop,six,rigid";

/// A chain's end: what is measured, and what became of it.
struct Row {
    object: String,
    chain: u64,
    net_wrench: f64,
    friction: f64,
    epsilon: f64,
    sigma_m: f64,
    force_closure: bool,
    published: bool,
    strict: bool,
    drop: Option<bool>,
    six: Option<bool>,
    rigid: Option<bool>,
}

impl Row {
    fn to_line(&self) -> String {
        let flag = u8::from;
        let outcome = |held: Option<bool>| held.map_or(-1, i8::from);
        format!(
            "{},{},{:.6},{:.6},{:.6},{:.9},{},{},{},{},{},{}",
            self.object,
            self.chain,
            self.net_wrench,
            self.friction,
            self.epsilon,
            self.sigma_m,
            flag(self.force_closure),
            flag(self.published),
            flag(self.strict),
            outcome(self.drop),
            outcome(self.six),
            outcome(self.rigid),
        )
    }

    fn from_line(line: &str) -> Option<Self> {
        let mut cells = line.split(',');
        let object = cells.next()?.to_owned();
        let chain = cells.next()?.parse().ok()?;
        let mut number = || cells.next()?.parse::<f64>().ok();
        let numbers: Vec<f64> = (0..10).map_while(|_| number()).collect();
        let &[net_wrench, friction, epsilon, sigma_m, ref flags @ ..] = numbers.as_slice() else {
            return None;
        };
        let &[force_closure, published, strict, drop, six, rigid] = flags else {
            return None;
        };
        let flag = |number: f64| number > 0.5;
        let outcome = |number: f64| (number >= 0.0).then_some(number > 0.5);
        Some(Self {
            object,
            chain,
            net_wrench,
            friction,
            epsilon,
            sigma_m,
            force_closure: flag(force_closure),
            published: flag(published),
            strict: flag(strict),
            drop: outcome(drop),
            six: outcome(six),
            rigid: outcome(rigid),
        })
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let folder = PathBuf::from(if quick { "target" } else { "figures" });
    let chains = if quick { 4 } else { 100 };
    let csv = folder.join("stability.csv");
    let mut rows = read(&csv)?;
    for name in BOTTLES.iter().chain(&SIMPLE) {
        let known = rows.iter().filter(|row| row.object == *name).count();
        if known as u64 != chains {
            eprintln!("{name}");
            rows.retain(|row| row.object != *name);
            rows.extend(measure(name, chains)?);
            write(&csv, &rows)?;
        }
        // After each object, so that a run that is cut short leaves a report of what it has.
        fs::write(folder.join("stability.md"), text(&rows, chains))?;
        chart(&rows).draw()?.save(&folder.join("stability.png"))?;
    }
    Ok(())
}

fn measure(name: &str, chains: u64) -> Result<Vec<Row>, Box<dyn Error>> {
    let object = Arc::new(Object::named(name)?);
    let solid = Solid::new(&object.mesh, Build::Pieces);
    eprintln!("  {:?}", solid.fit());
    let hand = Arc::new(Hand::human());
    let energy = GraspEnergy::new(hand.clone(), object.clone(), EnergySettings::default())?;
    let pushed = if BOTTLES.contains(&name) { PUSHED } else { 0 };
    let row = |chain| {
        let (synthesis, refine) = (SynthesisSettings::default(), QuenchSettings::default());
        let end = synthesize(&energy, &synthesis, &refine, SEED, chain);
        let judgement = judge(&energy, &end.refined, &end.contacts);
        let contacts = measure_contacts(&energy, &end.refined, &end.contacts);
        let gaps: f64 = contacts
            .iter()
            .map(|contact| contact.distance_m.abs())
            .sum();
        let holds = |protocol| {
            let (x, contacts) = (&end.refined, &end.contacts);
            simulate(&hand, x, contacts, &solid, object.mass_kg, &protocol).is_stable()
        };
        Row {
            object: name.to_owned(),
            chain,
            net_wrench: judgement.net_wrench,
            // No friction suffices: more than any that does.
            friction: judgement.least_friction.unwrap_or(1e3),
            epsilon: judgement.epsilon,
            sigma_m: gaps / contacts.len() as f64,
            force_closure: judgement.force_closure,
            published: judgement.passes_published(),
            strict: judgement.passes_strict(),
            drop: Some(holds(Protocol::Drop(Drop::default()))),
            six: (chain < pushed).then(|| holds(Protocol::SixDirections(SixDirections::default()))),
            rigid: (chain < pushed).then(|| holds(Protocol::SixDirections(SixDirections::rigid()))),
        }
    };
    Ok((0..chains).into_par_iter().map(row).collect())
}

fn read(csv: &Path) -> Result<Vec<Row>, Box<dyn Error>> {
    let text = match fs::read_to_string(csv) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        text => text?,
    };
    let mut lines = text.lines();
    if lines.next() != Some(COLUMNS) {
        return Ok(Vec::new());
    }
    Ok(lines.filter_map(Row::from_line).collect())
}

fn write(csv: &Path, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let lines: Vec<String> = rows.iter().map(Row::to_line).collect();
    let text = format!("{COLUMNS}\n{}\n", lines.join("\n"));
    let partial = csv.with_extension("csv.partial");
    fs::write(&partial, text)?;
    Ok(fs::rename(partial, csv)?)
}

/// `87.0 % [83.9, 89.6] of 531`.
fn share(rows: &[&Row], held: Held) -> String {
    let known: Vec<bool> = rows.iter().filter_map(|row| held(row)).collect();
    if known.is_empty() {
        return "none".to_owned();
    }
    let of = known.len() as f64;
    let count = known.iter().filter(|held| **held).count() as f64;
    let [low, high] = interval(count, of).map(|bound| 100.0 * bound);
    format!("{:.1} % [{low:.1}, {high:.1}] of {of}", 100.0 * count / of)
}

type Test = (&'static str, fn(&Row) -> bool);

const FILTERS: [Test; 4] = [
    ("every chain's end", |_| true),
    ("Eq. 11", |row| row.published),
    ("exact force closure at 0.5", |row| row.force_closure),
    ("strict filter", |row| row.strict),
];
/// Whether a grasp held in one of the tests; none where it was not simulated.
type Held = fn(&Row) -> Option<bool>;

const OUTCOMES: [(&str, Held); 3] = [
    ("drop", |row| row.drop),
    ("six directions, squeezed", |row| row.six),
    ("six directions, rigid", |row| row.rigid),
];
/// Published: Table I, static stability, per cent.
const PUBLISHED: [(&str, f64); 4] = [
    ("union of balls (Liu et al.)", 72.53),
    ("visuo-haptic (Liu et al.)", 85.00),
    ("paper, σ < 0.0015", 76.98),
    ("paper, σ < 0.0005", 85.00),
];

fn text(rows: &[Row], chains: u64) -> String {
    let bottles: Vec<&Row> = rows
        .iter()
        .filter(|row| BOTTLES.contains(&row.object.as_str()))
        .collect();
    let all: Vec<&Row> = rows.iter().collect();
    let mut text = format!(
        "# Stability in simulation\n\n{} chains of the default synthesis (four contacts, seed {SEED}) on each object; every \
         end is dropped, and the first {PUSHED} on each bottle are pushed, too. Bottles: {}. Simple shapes: {}. In brackets: 95 % intervals (Wilson). Protocols: `landscape \
         stability --help`. σ is the mean distance of a grasp's contacts from the exact mesh after refinement.\n\n",
        chains,
        BOTTLES.join(", "),
        SIMPLE.join(", ")
    );
    text.push_str(
        "In the drop test hand and object are rigid and nothing presses but the object's own weight and what they overlap at \
         the start, so what holds is what is wedged; the squeezed test drives the joints.\n\n",
    );
    text.push_str("## Beside Table I\n\n| | drop | six directions, squeezed | six directions, rigid |\n|---|---|---|---|\n");
    for (name, per_cent) in PUBLISHED {
        let _ = writeln!(text, "| {name} | {per_cent:.2} % | | |");
    }
    let units: [(&str, f64); 2] = [("m", 1.0), ("× 120 mm", AUTHORS_UNIT_M)];
    let mut row = |name: &str, of: &[&Row]| {
        let shares = OUTCOMES.map(|(_, holds)| share(of, holds)).join(" | ");
        let _ = writeln!(text, "| {name} | {shares} |");
    };
    let simple = all.len() > bottles.len();
    let places = [("bottles", &bottles), ("bottles and simple shapes", &all)];
    for (place, population) in &places[..if simple { 2 } else { 1 }] {
        let strict: Vec<&Row> = population
            .iter()
            .copied()
            .filter(|row| row.strict)
            .collect();
        for sigma in [0.0015, 0.0005] {
            for (unit, unit_m) in units {
                let close: Vec<&Row> = strict
                    .iter()
                    .copied()
                    .filter(|row| row.sigma_m < sigma * unit_m)
                    .collect();
                row(&format!("strict, σ < {sigma} {unit}, {place}"), &close);
            }
        }
        for (name, passes) in FILTERS {
            let passed: Vec<&Row> = population
                .iter()
                .copied()
                .filter(|row| passes(row))
                .collect();
            row(&format!("{name}, {place}"), &passed);
        }
    }
    text.push_str("\n## By object: strict filter\n\n| | drop | six directions, squeezed | six directions, rigid |\n|---|---|---|---|\n");
    for name in BOTTLES.iter().chain(&SIMPLE) {
        let of: Vec<&Row> = rows
            .iter()
            .filter(|row| row.object == *name && row.strict)
            .collect();
        if of.is_empty() {
            continue;
        }
        let shares = OUTCOMES.map(|(_, holds)| share(&of, holds)).join(" | ");
        let _ = writeln!(text, "| {name} | {shares} |");
    }
    text.push_str("\n## What predicts the outcome\n\nArea under the ROC curve with its 95 % interval (DeLong), bottles; ½ knows nothing.\n\n");
    for (population, keep) in [FILTERS[0], FILTERS[3]] {
        let of: Vec<&Row> = bottles.iter().copied().filter(|row| keep(row)).collect();
        let _ = writeln!(
            text,
            "| {population} | {} |\n|---|---|---|---|",
            OUTCOMES.map(|(name, _)| name).join(" | ")
        );
        for (score, of_row) in SCORES {
            let cells = OUTCOMES.map(|(_, holds)| match roc(&of, of_row, holds) {
                Some(roc) => {
                    let [low, high] = roc.interval(1.96);
                    format!("{:.3} [{low:.3}, {high:.3}]", roc.area)
                }
                None => "one class only".to_owned(),
            });
            let _ = writeln!(text, "| {score} | {} |", cells.join(" | "));
        }
        text.push('\n');
    }
    text
}

type Score = (&'static str, fn(&Row) -> f64);

/// The higher, the likelier to hold.
const SCORES: [Score; 4] = [
    ("−‖Gc‖", |row| -row.net_wrench),
    ("−μ₀", |row| -row.friction),
    ("ε", |row| row.epsilon),
    ("−σ", |row| -row.sigma_m),
];

fn roc(rows: &[&Row], score: fn(&Row) -> f64, held: Held) -> Option<Roc> {
    let (scores, classes): (Vec<f64>, Vec<bool>) = rows
        .iter()
        .filter_map(|row| Some((score(row), held(row)?)))
        .unzip();
    Roc::new(&scores, &classes).ok()
}

fn chart(rows: &[Row]) -> Chart {
    let bottles: Vec<&Row> = rows
        .iter()
        .filter(|row| BOTTLES.contains(&row.object.as_str()))
        .collect();
    let mut panels = Vec::new();
    for (title, holds) in OUTCOMES {
        let mut series = Vec::new();
        for (name, score) in SCORES {
            if let Some(roc) = roc(&bottles, score, holds) {
                let points = roc
                    .points
                    .iter()
                    .map(|point| [point.false_positive_rate, point.true_positive_rate]);
                series.push(Series::line(points.collect()).named(name));
            }
        }
        series.push(Series::line(vec![[0.0, 0.0], [1.0, 1.0]]).dashed());
        panels.push(Panel {
            legend: Some(Corner::LowerRight),
            ..Panel::new(
                title,
                Axis::linear("share of the unstable kept").with_range(0.0, 1.0),
                Axis::linear("share of the stable kept").with_range(0.0, 1.0),
                series,
            )
        });
    }
    Chart {
        columns: OUTCOMES.len(),
        ..Chart::new("What predicts whether a grasp of a bottle holds", panels)
    }
}
