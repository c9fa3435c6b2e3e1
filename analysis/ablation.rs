//! Effect of each setting of the default synthesis with three contacts → `figures/ablation.md`, `figures/ablation.csv`
//!
//! The settings were tuned on `bottle_round`, `bottle_square` and `ball` with seed 1, and confirmed on all bottles and the
//! ball with another seed. Runs in the .csv are not repeated; delete it to start again. `--quick`: 8 chains, into
//! `target/`.

#[path = "yields/mod.rs"]
mod yields;

use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use landscape::evaluation::Diversity;
use landscape::grasp::energy::GraspEnergy;
use landscape::grasp::synthesis::{
    ContactMoves, Start, StepScales, SynthesisSettings, Synthesized, synthesize,
};
use landscape::grasp::{EnergySettings, Judgement, judge};
use landscape::hand::Hand;
use landscape::optimize::QuenchSettings;
use rayon::prelude::*;
use yields::{Run, Table, interval};

const TUNED: (&[&str], u64) = (&["bottle_round", "bottle_square", "ball"], 1);
const FRESH: (&[&str], u64) = (
    &[
        "bottle_round",
        "bottle_water",
        "bottle_medicine",
        "bottle_square",
        "bottle_squeeze",
        "bottle_flask",
        "ball",
    ],
    2001,
);
/// Diversity is compared between this number of grasps of an object.
const DIVERSE: usize = 16;
/// Number of steps after which an early yield is measured.
const EARLY: u64 = 2000;

const COLUMNS: &str = "published,strict,early,median_energy,evaluations,region_sets,first_component,joint_entropy,pose_entropy,height_entropy";

/// Numbers of chains: for the variants reported per object, and for the others.
const CHAINS: [u64; 2] = [64, 24];
/// Those variants. Only they run on the objects used for tuning.
const WHOLE: [&str; 2] = ["default", FOUR];
const ANYWHERE: &str = "start anywhere on the surface";
const FOUR: &str = "default with four contacts";

fn main() -> Result<(), Box<dyn Error>> {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let folder = PathBuf::from(if quick { "target" } else { "figures" });
    let csv = folder.join("ablation.csv");
    let mut table = Table::read(&csv, COLUMNS)?;
    let runs: Vec<Run> = rows(quick);
    let keys: Vec<String> = runs.iter().map(Run::key).collect::<Result<_, _>>()?;
    for (run, key) in runs.iter().zip(&keys) {
        if table.of(key).is_empty() {
            eprintln!("{}, {}, seed {}", run.name, run.object, run.seed);
            let numbers = measure(run)?;
            table.add(key, &numbers);
            table.write(&csv, &keys)?;
        }
    }
    table.write(&csv, &keys)?;
    fs::write(folder.join("ablation.md"), text(&runs, &keys, &table))?;
    Ok(())
}

/// The default, and variants of it with one change each.
fn variants() -> Vec<(&'static str, EnergySettings, SynthesisSettings)> {
    let energy = EnergySettings {
        contacts: 3,
        ..EnergySettings::four_points()
    };
    let synthesis = SynthesisSettings::four_points();
    let change = |name, change: &dyn Fn(&mut SynthesisSettings)| {
        let mut changed = synthesis;
        change(&mut changed);
        (name, energy, changed)
    };
    vec![
        change("default", &|_| ()),
        change(ANYWHERE, &|s| {
            s.start = Start::Surface;
        }),
        change("start of the authors", &|s| s.start = Start::Gaussian),
        change("one start candidate", &|s| s.start_candidates = 1),
        change("20 start candidates", &|s| s.start_candidates = 20),
        change("weights of depths as they are", &|s| s.ramp_depths = false),
        change("no ramp at all", &|s| s.ramp_start = 1.0),
        change("hotter start (0.3)", &|s| s.temperature_start = 0.3),
        change("always cold (0.002)", &|s| s.temperature_start = 0.002),
        change("uniform contact moves", &|s| {
            s.contact_moves = ContactMoves::Uniform;
        }),
        change("noise scaled by the metric", &|s| {
            s.step_scales = StepScales::Metric;
        }),
        change("8 attempts of 1250 steps", &|s| s.attempts = 8),
        change("40 attempts of 250 steps", &|s| s.attempts = 40),
        change("one attempt of 500 steps", &|s| {
            (s.attempts, s.steps) = (1, 500);
        }),
        change("one attempt of 10000 steps", &|s| s.attempts = 1),
        change("as it was before", &|s| {
            *s = SynthesisSettings {
                start: Start::Surface,
                start_candidates: 1,
                attempts: 1,
                temperature_start: 0.3,
                ramp_start: 0.05,
                ramp_depths: false,
                ..*s
            }
        }),
        (FOUR, EnergySettings::four_points(), synthesis),
    ]
}

fn rows(quick: bool) -> Vec<Run> {
    let mut runs = Vec::new();
    for (name, energy, synthesis) in variants() {
        let whole = WHOLE.contains(&name);
        let on: &[(&[&str], u64)] = if whole { &[TUNED, FRESH] } else { &[FRESH] };
        for &(objects, seed) in on {
            runs.extend(objects.iter().map(|object| Run {
                name: name.to_owned(),
                object,
                energy,
                synthesis,
                seed,
                chains: if quick {
                    8
                } else {
                    CHAINS[usize::from(!whole)]
                },
            }));
        }
    }
    runs
}

/// Counts and measures of one run, in the order of [`COLUMNS`].
fn measure(run: &Run) -> Result<[f64; 10], Box<dyn Error>> {
    let energy = run.energy(Arc::new(Hand::human()))?;
    let ends: Vec<(Synthesized, Judgement)> = (0..run.chains)
        .into_par_iter()
        .map(|chain| {
            let refine = QuenchSettings::default();
            let end = synthesize(&energy, &run.synthesis, &refine, run.seed, chain);
            let judgement = judge(&energy, &end.refined);
            (end, judgement)
        })
        .collect();
    let strict: Vec<&Synthesized> = ends
        .iter()
        .filter_map(|(end, judgement)| judgement.passes_strict().then_some(end))
        .collect();
    let published = ends
        .iter()
        .filter(|(_, judgement)| judgement.passes_published());
    let mut energies: Vec<f64> = strict.iter().map(|end| end.energy).collect();
    energies.sort_by(f64::total_cmp);
    let evaluations: u64 = ends.iter().map(|(end, _)| end.evaluations).sum();
    let diverse = diversity(&energy, &strict);
    Ok([
        published.count() as f64,
        strict.len() as f64,
        strict.iter().filter(|end| end.steps <= EARLY).count() as f64,
        energies
            .get(energies.len() / 2)
            .copied()
            .unwrap_or(f64::NAN),
        evaluations as f64 / run.chains as f64,
        region_sets(&energy, &strict).map_or(f64::NAN, |sets| sets as f64),
        diverse
            .as_ref()
            .map_or(f64::NAN, |d| d.explained_variance[0]),
        diverse.as_ref().map_or(f64::NAN, |d| d.joint_entropy),
        diverse.as_ref().map_or(f64::NAN, |d| d.pose_entropy),
        height_entropy(&energy, &strict).unwrap_or(f64::NAN),
    ])
}

/// Diversity of the first [`DIVERSE`] grasps, if there are as many.
fn diversity(energy: &GraspEnergy, strict: &[&Synthesized]) -> Option<Diversity> {
    let first = strict.get(..DIVERSE)?.iter().copied();
    Diversity::of(
        energy.hand(),
        energy.object(),
        first.map(|end| &end.refined),
    )
}

/// Number of distinct sets of hand regions (patches of the skin) of the contact sets of the first [`DIVERSE`] grasps.
fn region_sets(energy: &GraspEnergy, strict: &[&Synthesized]) -> Option<usize> {
    let regions = |end: &&Synthesized| -> BTreeSet<usize> {
        let points = end.refined.contacts.iter();
        points
            .map(|point| energy.hand().surface[*point as usize].region)
            .collect()
    };
    let sets: BTreeSet<BTreeSet<usize>> = strict.get(..DIVERSE)?.iter().map(regions).collect();
    Some(sets.len())
}

/// Entropy of the heights at which the first [`DIVERSE`] grasps hold the object, by tenths of its height, nats.
fn height_entropy(energy: &GraspEnergy, strict: &[&Synthesized]) -> Option<f64> {
    let [low, high] = energy.object().mesh.bounds().map(|corner| corner.z);
    let mut counts = [0.0_f64; 10];
    for end in strict.get(..DIVERSE)? {
        let height = energy
            .contact_centre(&end.refined.pose, &end.refined.contacts)
            .z;
        let above = (1..10)
            .filter(|&tenth| height > low + (high - low) * f64::from(tenth) / 10.0)
            .count();
        counts[above] += 1.0 / DIVERSE as f64;
    }
    let filled = counts.iter().filter(|share| **share > 0.0);
    Some(-filled.map(|share| share * libm::log(*share)).sum::<f64>())
}

fn text(runs: &[Run], keys: &[String], table: &Table) -> String {
    let numbers = |name: &str, seed: u64, object: Option<&str>| -> Vec<(f64, Vec<f64>)> {
        runs.iter()
            .zip(keys)
            .filter(|(run, _)| run.name == name && run.seed == seed)
            .filter(|(run, _)| object.is_none_or(|object| run.object == object))
            .flat_map(|(run, key)| {
                table
                    .of(key)
                    .into_iter()
                    .map(|row| (run.chains as f64, row))
            })
            .collect()
    };
    let mut text = format!(
        "Yields with three contacts (last row: four); {} chains an object for the rows “default” and “{FOUR}”, {} for \
         the others. *Tuned*: bottle_round, bottle_square and ball \
         with seed 1, on which the settings were chosen; *fresh*: all bottles and the ball with seed {}. In brackets 95 % \
         intervals (Wilson). *Early*: strict within the first {EARLY} steps. Diversity: means over the objects of the first \
         {DIVERSE} strict grasps of each (– where one has fewer): distinct sets of hand regions, share of the variance in \
         the first principal component (lower is more diverse), entropies in nats, the last of the height of the contacts by tenths of the object.\n\n\
         | | tuned: Eq. 11 | tuned: strict | fresh: Eq. 11 | fresh: strict | fresh: early | evaluations a chain | median energy | \
         region sets | first component | joint entropy | pose entropy | height entropy |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        CHAINS[0], CHAINS[1], FRESH.1
    );
    for (name, ..) in variants() {
        let _ = write!(text, "| {name}");
        for (seed, columns) in [(TUNED.1, 0..2), (FRESH.1, 0..3)] {
            let rows = numbers(name, seed, None);
            let of: f64 = rows.iter().map(|(chains, _)| chains).sum();
            for column in columns {
                let count: f64 = rows.iter().map(|(_, row)| row[column]).sum();
                let _ = write!(text, " | {}", share(count, of));
            }
        }
        let rows = numbers(name, FRESH.1, None);
        let mean = |column: usize| {
            rows.iter().map(|(_, row)| row[column]).sum::<f64>() / rows.len() as f64
        };
        let shown = |value: f64, digits: usize| {
            if value.is_nan() {
                "–".to_owned()
            } else {
                format!("{value:.digits$}")
            }
        };
        let _ = writeln!(
            text,
            " | {} | {} | {} | {} | {} | {} | {} |",
            shown(mean(4), 0),
            shown(mean(3), 3),
            shown(mean(5), 1),
            shown(mean(6), 2),
            shown(mean(7), 2),
            shown(mean(8), 2),
            shown(mean(9), 2)
        );
    }
    let _ = write!(
        text,
        "\nThe default by object, fresh seed:\n\n| | three contacts: Eq. 11 | strict | early | four contacts: Eq. 11 | strict | early |\n|---|---|---|---|---|---|---|\n"
    );
    for object in FRESH.0 {
        let _ = write!(text, "| {object}");
        for name in ["default", FOUR] {
            for (chains, row) in numbers(name, FRESH.1, Some(object)) {
                for count in &row[..3] {
                    let _ = write!(text, " | {}", share(*count, chains));
                }
            }
        }
        text.push_str(" |\n");
    }
    text
}

fn share(count: f64, of: f64) -> String {
    if of == 0.0 {
        return "–".to_owned();
    }
    let [low, high] = interval(count, of);
    format!(
        "{:.0} % [{:.0}–{:.0}]",
        100.0 * count / of,
        100.0 * low,
        100.0 * high
    )
}
