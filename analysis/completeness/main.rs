//! Accuracy of claims of completeness on surfaces with known numbers of minima and saddles → `figures/completeness.md`
//!
//! Each run is a search as in `landscape surface`, with another seed (and another random surface). A run is complete if it
//! found every minimum and every saddle. Its claim is `Coverage::sure`. With names of surfaces (`"lj 7"`, `random`) the
//! program only prints their rows.

use std::error::Error;
use std::fmt::Write;

use rayon::prelude::*;
use surfaces::Counted;

mod surfaces;
mod waves;

/// Named models, their numbers of minima and saddles, and the number of runs. `tests/completeness.rs` has a larger cluster,
/// for which nothing is claimed.
const MODELS: [(&str, [usize; 2], u64); 14] = [
    ("muller-brown", [3, 2], 100),
    ("three-hole", [3, 3], 100),
    ("double-well 1", [2, 1], 100),
    ("double-well 2", [4, 4], 100),
    ("double-well 3", [8, 12], 100),
    ("double-well 3 0.4", [8, 12], 100),
    ("double-well 4", [16, 32], 100),
    ("torsion 0.5 3 1 2 2 1", [6, 18], 100),
    ("torsion 1 3 1 3", [9, 18], 100),
    ("orientation", [4, 12], 100),
    ("lj 4", [1, 1], 100),
    ("lj 5", [1, 2], 100),
    ("lj 6", [2, 3], 100),
    ("lj 7", [4, 12], 100),
];
/// Runs on the six-hump camel with a narrow well.
const NEEDLES: u64 = 100;
/// Random surfaces, one run each.
const RANDOM: u64 = 400;

/// Properties of a run that are kept.
struct Judged {
    complete: bool,
    sure: f64,
    /// Number of missed saddles.
    missed: usize,
    /// The claimed upper bound of the number of missing saddles, if there is one.
    bound: Option<usize>,
}

impl Judged {
    fn new(surface: &Counted, seed: u64) -> Self {
        let run = surface.search(seed);
        Self {
            complete: run.complete,
            sure: run.found.coverage.sure,
            missed: run.missed,
            bound: run.found.coverage.unseen_below,
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut text = String::from(
        "# How often claims of completeness hold\n\nSearches as `landscape surface` makes them, each of another seed. *Complete*: \
         every minimum and every saddle was found. *Says 99 %* (95 %): runs that say they are so sure of all minima and saddles, \
         and how many of these are complete. *Sure*: the mean of what runs are sure of. *Bound holds*: runs that miss no more \
         saddles than the bound they print (95 %). The needle is a seventh minimum of the six-hump camel with a basin so small that \
         no number of hits tells of it; what the summary says of it is the share of the region that descents leave for such basins. Of random waves of two angles the saddles are counted by Morse's theorem from \
         minima and maxima below and above a grid. Written by `cargo run --release --example completeness`.\n\n\
         | surface | minima / saddles | runs | complete | say 99 % | of these complete | say 95 % | of these complete | sure | \
         bound holds |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let chosen: Vec<String> = std::env::args().skip(1).collect();
    let skipped = |name: &str| !chosen.is_empty() && !chosen.iter().any(|words| words == name);
    for (words, known, runs) in MODELS {
        if skipped(words) {
            continue;
        }
        let surface = Counted::named(words, known);
        let judged: Vec<Judged> = (0..runs)
            .into_par_iter()
            .map(|seed| Judged::new(&surface, seed))
            .collect();
        row(
            &mut text,
            words,
            &format!("{} / {}", known[0], known[1]),
            &judged,
        )?;
    }
    if !skipped("needle") {
        let needle: Vec<Judged> = (0..NEEDLES)
            .into_par_iter()
            .map(|seed| Judged::new(&Counted::needle(), seed))
            .collect();
        row(&mut text, "six-hump camel and a needle", "7 / 8", &needle)?;
    }
    if !skipped("random") {
        let random: Vec<Judged> = (0..RANDOM)
            .into_par_iter()
            .map(|id| Judged::new(&Counted::random(id), id))
            .collect();
        row(
            &mut text,
            "random waves of two angles",
            "each its own",
            &random,
        )?;
    }
    if chosen.is_empty() {
        std::fs::write("figures/completeness.md", &text)?;
    }
    print!("{text}");
    Ok(())
}

fn row(text: &mut String, name: &str, known: &str, runs: &[Judged]) -> std::fmt::Result {
    let complete = runs.iter().filter(|run| run.complete).count();
    let sure = runs.iter().map(|run| run.sure).sum::<f64>() / runs.len() as f64;
    let holds = runs
        .iter()
        .filter(|run| run.bound.is_none_or(|bound| run.missed <= bound))
        .count();
    write!(text, "| {name} | {known} | {} | {complete}", runs.len())?;
    for level in [0.99, 0.95] {
        let claims = || runs.iter().filter(|run| run.sure >= level);
        let right = claims().filter(|run| run.complete).count();
        write!(text, " | {} | {right}", claims().count())?;
    }
    writeln!(text, " | {:.1} % | {holds} |", 100.0 * sure)?;
    // Minutes pass between rows.
    eprintln!("{}", text.lines().last().unwrap_or_default());
    Ok(())
}
