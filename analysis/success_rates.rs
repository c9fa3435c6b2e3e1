//! Figure 5 of Liu et al. (2021): successes against steps → `figures/success_rates.png`, `.md`, `.csv`
//!
//! The runs have 512 chains of 10,000 steps of the printed energy, of the released code, and of the preset
//! `four_points` (*ours*). They compare
//! fingertips with all surface points as candidates, three, five and eight contacts, and ball with bottle. Beside them are
//! chains of the default energy (*closed*), which has no contact set and whose steps are descents. Runs in the .csv
//! are not repeated; delete it to start again. `--quick`: 16 chains of 500 steps, into `target/`.

#[path = "yields/mod.rs"]
mod yields;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use landscape::figure::chart::{Axis, Chart, Corner, Panel, Series};
use landscape::grasp::energy::{Candidates, GraspEnergy};
use landscape::grasp::synthesis::{SynthesisSettings, synthesize_observed};
use landscape::grasp::{EnergySettings, Grasp, Judgement, judge};
use landscape::hand::Hand;
use landscape::optimize::QuenchSettings;
use landscape::sample::State;
use rayon::prelude::*;
use yields::{Run, Table, interval};

const SEED: u64 = 5;
/// Step 0 means the ends after refinement.
const COLUMNS: &str = "step,printed,coded,strict";

/// Indices of columns.
const PRINTED: usize = 1;
const CODED: usize = 2;
const STRICT: usize = 3;

/// A method of running a chain, and its criterion of success.
struct Method {
    name: &'static str,
    energy: EnergySettings,
    synthesis: SynthesisSettings,
    /// The applied reading of Eq. 11: a column.
    reading: usize,
}

/// A line of a panel.
struct Line {
    name: &'static str,
    object: &'static str,
    contacts: usize,
    candidates: Candidates,
}

const fn line(
    name: &'static str,
    object: &'static str,
    contacts: usize,
    candidates: Candidates,
) -> Line {
    Line {
        name,
        object,
        contacts,
        candidates,
    }
}

/// The panels: their titles and lines.
const PANELS: [(&str, &[Line]); 3] = [
    (
        "ball, 3 contacts",
        &[
            line("all surface points", "ball", 3, Candidates::All),
            line("fingertips", "ball", 3, Candidates::Fingertips),
        ],
    ),
    (
        "ball, all surface points",
        &[
            line("3 contacts", "ball", 3, Candidates::All),
            line("5 contacts", "ball", 5, Candidates::All),
            line("8 contacts", "ball", 8, Candidates::All),
        ],
    ),
    (
        "3 contacts, all surface points",
        &[
            line("ball", "ball", 3, Candidates::All),
            line("bottle", "bottle_round", 3, Candidates::All),
        ],
    ),
];

/// Chains of the default energy, which has no contact set: a panel of its own.
const CLOSED: (&str, &[Line]) = (
    "ball and bottle, after rough descents",
    &[
        line("ball", "ball", 3, Candidates::All),
        line("bottle", "bottle_round", 3, Candidates::All),
    ],
);

fn methods() -> [Method; 4] {
    [
        Method {
            name: "as printed",
            energy: EnergySettings::paper(),
            synthesis: SynthesisSettings::paper(),
            reading: PRINTED,
        },
        Method {
            name: "as released",
            energy: EnergySettings::released(),
            synthesis: SynthesisSettings::released(),
            reading: CODED,
        },
        Method {
            name: "ours",
            energy: EnergySettings::four_points(),
            synthesis: SynthesisSettings::four_points(),
            reading: PRINTED,
        },
        Method {
            name: "closed",
            energy: EnergySettings::closed(),
            synthesis: SynthesisSettings::closed(),
            reading: PRINTED,
        },
    ]
}

impl Method {
    fn panels(&self) -> &'static [(&'static str, &'static [Line])] {
        if self.energy.layer.is_some() {
            std::slice::from_ref(&CLOSED)
        } else {
            &PANELS
        }
    }
}

/// Number and length of the chains.
#[derive(Clone, Copy)]
struct Size {
    chains: u64,
    steps: u32,
}

fn main() -> Result<(), Box<dyn Error>> {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let folder = PathBuf::from(if quick { "target" } else { "figures" });
    let csv = folder.join("success_rates.csv");
    let size = if quick {
        Size {
            chains: 16,
            steps: 500,
        }
    } else {
        Size {
            chains: 512,
            steps: 10_000,
        }
    };
    // A line in several panels is one run.
    let mut runs: Vec<(String, Run)> = Vec::new();
    for method in &methods() {
        for line in method.panels().iter().flat_map(|(_, lines)| *lines) {
            let run = run(method, line, size);
            let key = run.key()?;
            if runs.iter().all(|(known, _)| *known != key) {
                runs.push((key, run));
            }
        }
    }
    let keys: Vec<String> = runs.iter().map(|(key, _)| key.clone()).collect();
    let mut table = Table::read(&csv, COLUMNS)?;
    for (key, run) in &runs {
        if table.of(key).is_empty() {
            eprintln!("{key}");
            for row in measure(run)? {
                table.add(key, &row);
            }
            table.write(&csv, &keys)?;
        }
    }
    table.write(&csv, &keys)?;
    fs::write(folder.join("success_rates.md"), text(&runs, &table, size))?;
    let chart = Chart {
        columns: PANELS.len(),
        ..Chart::new(
            "Successes against steps: Eq. 11 (solid) and the strict filter (dashed)",
            panels(&table, size)?,
        )
    };
    chart.draw()?.save(&folder.join("success_rates.png"))?;
    Ok(())
}

fn run(method: &Method, line: &Line, size: Size) -> Run {
    let (mut energy, mut synthesis) = (method.energy, method.synthesis);
    if energy.layer.is_none() {
        (energy.contacts, energy.candidates) = (line.contacts, line.candidates);
        synthesis.steps = size.steps;
    }
    Run {
        name: method.name.to_owned(),
        object: line.object,
        energy,
        synthesis,
        seed: SEED,
        chains: size.chains,
    }
}

fn panels(table: &Table, size: Size) -> Result<Vec<Panel>, Box<dyn Error>> {
    let mut panels = Vec::new();
    for method in &methods() {
        for (title, lines) in method.panels() {
            let mut series = Vec::new();
            for line in *lines {
                let rows = table.of(&run(method, line, size).key()?);
                let curve = |column: usize| {
                    let along = rows.iter().filter(|row| row[0] > 0.0);
                    Series::line(along.map(|row| [row[0], row[column]]).collect()).named(line.name)
                };
                series.push(curve(method.reading));
                series.push(curve(STRICT).dashed());
            }
            let axes = (Axis::logarithmic("step"), Axis::linear("successes"));
            panels.push(Panel {
                legend: Some(Corner::UpperLeft),
                ..Panel::new(&format!("{}: {title}", method.name), axes.0, axes.1, series)
            });
        }
    }
    Ok(panels)
}

fn text(runs: &[(String, Run)], table: &Table, size: Size) -> String {
    let mut text = format!(
        "Successes of {} chains after {} steps (seed {SEED}), with 95 % intervals of the share. *As printed*: the formulae \
         and Algorithm 1 of the paper; *as released*: the energy and sampler of the authors' code; *ours*: the preset `four_points`; \
         *closed*: the default preset, whose energy has no contact set, so that the best set of its minimum is judged, and whose \
         steps are rough descents; refined is the minimum that the last of them leads to. Chains of *ours* and \
         *closed* end with their first grasp. Eq. 11 is read as printed \
         (‖Gc‖ < 0.5) and as coded (‖Gc‖² < 0.5, ten times the penetration). The paper reports 5 of 512 on bottles.\n\n\
         | | | Eq. 11 as printed | as coded | strict | refined: as printed | as coded | strict | first success by step |\n\
         |---|---|---|---|---|---|---|---|---|\n",
        size.chains, size.steps
    );
    for (key, run) in runs {
        row(&mut text, run, &table.of(key));
    }
    text
}

fn row(text: &mut String, run: &Run, rows: &[Vec<f64>]) {
    let [.., last, refined] = rows else { return };
    let share = |count: f64| {
        let [low, high] = interval(count, run.chains as f64);
        format!("{count} ({:.1}–{:.1} %)", 100.0 * low, 100.0 * high)
    };
    let _ = write!(text, "| {} | {}", run.name, run.object);
    if run.energy.layer.is_none() {
        let _ = write!(text, ", {} contacts", run.energy.contacts);
    }
    if run.energy.candidates == Candidates::Fingertips {
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

/// Rows of [`COLUMNS`]: the number of chains that pass each test at each checkpoint. A finished chain counts with its end.
fn measure(run: &Run) -> Result<Vec<[f64; 4]>, Box<dyn Error>> {
    let energy = run.energy(Arc::new(Hand::human()))?;
    let at = checkpoints(run.synthesis.steps);
    let counts = (0..run.chains)
        .into_par_iter()
        .map(|chain| follow(&energy, run, &at, chain))
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
fn follow(energy: &GraspEnergy, run: &Run, at: &[u32], chain: u64) -> Vec<[f64; 3]> {
    let mut seen: Vec<State> = Vec::new();
    let refine = QuenchSettings::default();
    let end = synthesize_observed(
        energy,
        &run.synthesis,
        &refine,
        run.seed,
        chain,
        &mut |n, state| {
            if at.get(seen.len()) == Some(&n) {
                seen.push(state.clone());
            }
        },
    );
    let raw = |state: &State| {
        let grasp = if energy.layer().spheres.is_empty() {
            Grasp::new(state.coordinates.clone(), state.discrete.clone())
        } else {
            Grasp::best(energy, state.coordinates.clone())
        };
        passes(&judge(energy, &grasp))
    };
    let refined = passes(&judge(energy, &end.refined));
    let at_end = if run.synthesis.attempts > 1 {
        refined
    } else {
        raw(seen.last().expect("the last step is a checkpoint"))
    };
    let ended = |step: u32| u64::from(step) >= end.steps;
    let along = at.iter().enumerate().map(|(k, step)| match seen.get(k) {
        Some(state) if !ended(*step) => raw(state),
        _ => at_end,
    });
    along
        .chain([refined])
        .map(|passed| passed.map(|passed| f64::from(u8::from(passed))))
        .collect()
}
