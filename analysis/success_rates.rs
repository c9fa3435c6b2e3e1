//! Figure 5 of Liu et al. (2021): successes against steps → `figures/success_rates.png`, `.md`, `.csv`
//!
//! The runs have 512 chains of 10,000 steps, as printed and as released. They compare fingertips with all surface points as
//! candidates, three, five and eight contacts, and ball with bottle. Beside them are chains of the default energy (*closed*),
//! which has no contact set and whose steps are descents. Runs in the .csv are not repeated; delete it to start again.

#[expect(dead_code, reason = "each program uses a part")]
mod method;
mod table;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use landscape::agreement::wilson;
use landscape::figure::chart::{Axis, Chart, Corner, Panel, Series};
use landscape::grasp::paper::PaperSettings;
use landscape::grasp::{Grasp, Judgement};
use landscape::hand::Hand;
use landscape::object::Object;
use method::Method;
use rayon::prelude::*;
use table::Table;

const SEED: u64 = 5;
/// Step 0 means the ends after refinement.
const HEADER: &str = "name,object,contacts,candidates,chains,step,printed,coded,strict";
/// Index of a strict success in a row.
const STRICT: usize = 3;

/// A line of a panel.
struct Line {
    name: &'static str,
    object: &'static str,
    contacts: usize,
    fingertips_only: bool,
}

const fn line(name: &'static str, object: &'static str, contacts: usize) -> Line {
    Line {
        name,
        object,
        contacts,
        fingertips_only: false,
    }
}

const FINGERTIPS: Line = Line {
    fingertips_only: true,
    ..line("fingertips", "ball", 3)
};

/// A panel: the method, its title, its lines, and the index of the reading of Eq. 11 that is drawn.
type Drawn = (&'static str, &'static str, &'static [Line], usize);

const CANDIDATES: &[Line] = &[line("all surface points", "ball", 3), FINGERTIPS];
const CONTACTS: &[Line] = &[
    line("3 contacts", "ball", 3),
    line("5 contacts", "ball", 5),
    line("8 contacts", "ball", 8),
];
const OBJECTS: &[Line] = &[line("ball", "ball", 3), line("bottle", "bottle_round", 3)];

/// The panels, row by row. The default energy has no contact set.
const PANELS: [Drawn; 8] = [
    ("as printed", "ball, 3 contacts", CANDIDATES, 1),
    ("as printed", "ball, all surface points", CONTACTS, 1),
    ("as printed", "3 contacts, all surface points", OBJECTS, 1),
    ("closed", "ball", &[line("ball", "ball", 0)], 1),
    ("as released", "ball, 3 contacts", CANDIDATES, 2),
    ("as released", "ball, all surface points", CONTACTS, 2),
    ("as released", "3 contacts, all surface points", OBJECTS, 2),
    ("closed", "bottle", &[line("bottle", "bottle_round", 0)], 1),
];
const METHODS: [&str; 3] = ["as printed", "as released", "closed"];

/// Number and length of the chains.
const CHAINS: u64 = 512;
const STEPS: u32 = 10_000;

fn main() -> Result<(), Box<dyn Error>> {
    let csv = Path::new("figures/success_rates.csv");
    // A line in several panels is one run.
    let mut runs: Vec<(String, &str, &Line)> = Vec::new();
    for name in METHODS {
        let panels = PANELS.iter().filter(|(method, ..)| *method == name);
        for line in panels.flat_map(|(_, _, lines, _)| *lines) {
            let key = key(name, line);
            if runs.iter().all(|(known, ..)| *known != key) {
                runs.push((key, name, line));
            }
        }
    }
    let keys: Vec<String> = runs.iter().map(|(key, ..)| key.clone()).collect();
    let mut table = Table::read(csv, HEADER)?;
    for (key, name, line) in &runs {
        if table.of(key).is_empty() {
            eprintln!("{key}");
            let rows = measure(name, line)?;
            table.set(key, rows.iter().map(|row| &row[..]));
            table.write(csv, &keys)?;
        }
    }
    table.write(csv, &keys)?;
    fs::write("figures/success_rates.md", text(&runs, &table))?;
    let chart = Chart {
        columns: PANELS.len() / 2,
        ..Chart::new(
            "Successes against steps: Eq. 11 (solid) and the strict filter (dashed)",
            panels(&table),
        )
    };
    chart.draw()?.save("figures/success_rates.png".as_ref())?;
    Ok(())
}

fn key(name: &str, line: &Line) -> String {
    let candidates = if line.fingertips_only {
        "fingertips"
    } else {
        "all"
    };
    format!(
        "{name},{},{},{candidates},{CHAINS}",
        line.object, line.contacts
    )
}

fn method(name: &str, line: &Line) -> Result<Method, Box<dyn Error>> {
    let (hand, object) = (Hand::human(), Object::named(line.object)?);
    let (hand, object) = (Arc::new(hand), Arc::new(object));
    let settings = match name {
        "closed" => return Ok(Method::closed(&hand, &object)?),
        "as printed" => PaperSettings::printed(),
        _ => PaperSettings::released(),
    };
    let settings = PaperSettings {
        contacts: line.contacts,
        fingertips_only: line.fingertips_only,
        steps: STEPS,
        ..settings
    };
    Ok(Method::paper(&hand, &object, settings))
}

fn panels(table: &Table) -> Vec<Panel> {
    let panel = |(name, title, lines, reading): Drawn| {
        let mut series = Vec::new();
        for line in lines {
            let rows = table.of(&key(name, line));
            let curve = |column: usize| {
                let along = rows.iter().filter(|row| row[0] > 0.0);
                Series::line(along.map(|row| [row[0], row[column]]).collect()).named(line.name)
            };
            series.push(curve(reading));
            series.push(curve(STRICT).dashed());
        }
        let axes = (Axis::logarithmic("step"), Axis::linear("successes"));
        Panel {
            legend: Some(Corner::UpperLeft),
            ..Panel::new(&format!("{name}: {title}"), axes.0, axes.1, series)
        }
    };
    PANELS.into_iter().map(panel).collect()
}

fn text(runs: &[(String, &str, &Line)], table: &Table) -> String {
    let mut text = format!(
        "Successes of {CHAINS} chains after {STEPS} steps (seed {SEED}), with 95 % intervals of the share. *As printed*: the formulae \
         and Algorithm 1 of the paper; *as released*: the energy and sampler of the authors' code; *closed*: the default \
         energy, which has no contact set, so that the best set of its minimum is judged, and whose steps are rough descents; \
         refined is the minimum that the last of them leads to. Chains of *closed* end with their first grasp. Eq. 11 is read \
         as printed (‖Gc‖ < 0.5) and as coded (‖Gc‖² < 0.5, ten times the penetration). The paper reports 5 of 512 on bottles.\n\n\
         | | | Eq. 11 as printed | as coded | strict | refined: as printed | as coded | strict | first success by step |\n\
         |---|---|---|---|---|---|---|---|---|\n"
    );
    for (key, name, line) in runs {
        row(&mut text, name, line, &table.of(key));
    }
    text
}

fn row(text: &mut String, name: &str, line: &Line, rows: &[Vec<f64>]) {
    let [.., last, refined] = rows else { return };
    let share = |count: f64| {
        let [low, high] = wilson(count, CHAINS as f64);
        format!("{count} ({:.1}–{:.1} %)", 100.0 * low, 100.0 * high)
    };
    let _ = write!(text, "| {name} | {}", line.object);
    if line.contacts > 0 {
        let _ = write!(text, ", {} contacts", line.contacts);
    }
    if line.fingertips_only {
        text.push_str(", fingertips");
    }
    for count in last[1..].iter().chain(&refined[1..]) {
        let _ = write!(text, " | {}", share(*count));
    }
    let mut successes = rows
        .iter()
        .filter(|row| row[0] > 0.0 && row[1] + row[2] > 0.0);
    let first = successes
        .next()
        .map_or("–".to_owned(), |row| row[0].to_string());
    let _ = writeln!(text, " | {first} |");
}

/// Numbers of steps at which chains are judged, six per decade, from 10, or from 1 for chains of few steps.
fn checkpoints(steps: u32) -> Vec<u32> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a positive number of steps"
    )]
    let step = |k: u32| libm::pow(10f64, f64::from(k) / 6.0).round() as u32;
    let first = if steps < 100 { 0 } else { 6 };
    let mut steps_at: Vec<u32> = (first..54)
        .map(step)
        .take_while(|step| *step < steps)
        .collect();
    steps_at.push(steps);
    steps_at.dedup();
    steps_at
}

/// Whether a grasp passes each test: Eq. 11 as printed, as coded, strict.
fn passes(judgement: &Judgement) -> [bool; 3] {
    [
        judgement.passes_published(),
        judgement.passes_released(),
        judgement.passes_strict(),
    ]
}

/// Rows of the table: the number of chains that pass each test at each checkpoint. A finished chain counts with its end.
fn measure(name: &str, line: &Line) -> Result<Vec<[f64; 4]>, Box<dyn Error>> {
    let method = method(name, line)?;
    let at = checkpoints(match &method {
        Method::Paper(energy) => energy.settings().steps,
        Method::Closed(_, synthesis) => synthesis.steps,
    });
    let counts = (0..CHAINS)
        .into_par_iter()
        .map(|chain| follow(&method, &at, chain))
        .reduce(
            || vec![[0.0; 3]; at.len() + 1],
            |mut sum, one| {
                for (sum, one) in sum.iter_mut().flatten().zip(one.iter().flatten()) {
                    *sum += one;
                }
                sum
            },
        );
    let rows = at.iter().chain([&0]).zip(counts);
    Ok(rows
        .map(|(step, [printed, coded, strict])| [f64::from(*step), printed, coded, strict])
        .collect())
}

/// For one chain, 1 or 0 for each test at each checkpoint and after refinement.
fn follow(method: &Method, at: &[u32], chain: u64) -> Vec<[f64; 3]> {
    let mut seen: Vec<Grasp> = Vec::new();
    let end = method.run(SEED, chain, &mut |n, grasp| {
        if at.get(seen.len()) == Some(&n) {
            seen.push(grasp());
        }
    });
    let raw = |grasp: &Grasp| passes(&method.judge(grasp));
    let refined = passes(&method.judge(&end.refined));
    let at_end = raw(seen.last().expect("the first step is a checkpoint"));
    let ended = |step: u32| u64::from(step) >= end.steps;
    let along = at.iter().enumerate().map(|(k, step)| match seen.get(k) {
        Some(grasp) if !ended(*step) => raw(grasp),
        _ => at_end,
    });
    along
        .chain([refined])
        .map(|passed| passed.map(|passed| f64::from(u8::from(passed))))
        .collect()
}
