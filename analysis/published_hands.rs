//! Published hands and the built-in ones: do they load, how far are they from `MuJoCo`'s kinematics, and how many of their
//! chains end in a grasp? → `figures/published_hands.md`, `.csv`
//!
//! Published hands are sought in the folder `hands` of `LANDSCAPE_TEST_DATA`; paths of other descriptions may be given.
//! Each hand has 32 chains on the round bottle and on the ball with the default settings. Runs in the .csv are not
//! repeated, unless the derived properties of the hand have changed. Times are printed to the terminal.

#[path = "../tests/published/mod.rs"]
mod published;
#[path = "yields/mod.rs"]
mod yields;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use landscape::grasp::synthesis::{SynthesisSettings, synthesize};
use landscape::grasp::{EnergySettings, judge};
use landscape::hand::{HAND_NAMES, Hand, HandError, HandFiles};
use landscape::optimize::QuenchSettings;
use landscape::store::content_hash;
use published::{Difference, ORIGINALS, REFERENCES};
use rayon::prelude::*;
use yields::{Run, Table, interval};

const OBJECTS: [&str; 2] = ["bottle_round", "ball"];
const CHAINS: u64 = 32;
const SEED: u64 = 0;
const COLUMNS: &str = "strict,evaluations";

/// A hand that loads.
struct Loaded {
    name: String,
    hand: Arc<Hand>,
    /// Identifies the derived properties of the hand.
    derived: String,
    difference: Option<Difference>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<PathBuf> = std::env::args().skip(1).map(PathBuf::from).collect();
    let (mut loaded, mut refused) = (Vec::new(), Vec::new());
    let mut take =
        |name: &str, files: Result<HandFiles, HandError>, reference: Option<PathBuf>| match files
            .and_then(|files| load(name, &files, reference.as_deref()))
        {
            Ok(hand) => loaded.push(hand),
            Err(error) => refused.push((name.to_owned(), error.to_string())),
        };
    for path in &given {
        take(&path.to_string_lossy(), HandFiles::load(path), None);
    }
    if given.is_empty() {
        for name in HAND_NAMES {
            take(name, HandFiles::named(name), None);
        }
        let folder = published::folder().ok_or("LANDSCAPE_TEST_DATA is not set: give paths")?;
        for [description, reference] in REFERENCES {
            let path = folder.join(description);
            take(
                description,
                HandFiles::load(&path),
                Some(folder.join(reference)),
            );
        }
        for description in ORIGINALS {
            take(
                description,
                HandFiles::load(&folder.join(description)),
                None,
            );
        }
    }
    let csv = Path::new("figures/published_hands.csv");
    let mut table = Table::read(csv, COLUMNS)?;
    let mut keys = Vec::new();
    for hand in &loaded {
        for object in OBJECTS {
            let key = run(hand, object).key()?;
            if table.of(&key).is_empty() {
                let row = measure(hand, object)?;
                table.add(&key, &row);
            }
            keys.push(key);
            table.write(csv, &keys)?;
        }
    }
    fs::write(
        "figures/published_hands.md",
        text(&loaded, &refused, &table)?,
    )?;
    Ok(())
}

fn load(name: &str, files: &HandFiles, reference: Option<&Path>) -> Result<Loaded, HandError> {
    let started = Instant::now();
    let hand = Hand::from_files(files)?;
    let seconds = started.elapsed().as_secs_f64();
    eprintln!("{name}: derived in {seconds:.2} s");
    let derived = files.derived_side_file()?;
    Ok(Loaded {
        name: name.to_owned(),
        derived: content_hash(&[derived.as_bytes()])[..8].to_owned(),
        difference: reference.map(|path| Difference::of(&hand, &published::reference(path))),
        hand: Arc::new(hand),
    })
}

fn run(loaded: &Loaded, object: &'static str) -> Run {
    Run {
        name: format!("{} {}", loaded.name, loaded.derived),
        object,
        energy: EnergySettings::four_points(),
        synthesis: SynthesisSettings::four_points(),
        seed: SEED,
        chains: CHAINS,
    }
}

/// A row of [`COLUMNS`].
fn measure(loaded: &Loaded, object: &'static str) -> Result<[f64; 2], Box<dyn Error>> {
    let run = run(loaded, object);
    let energy = run.energy(loaded.hand.clone())?;
    let refine = QuenchSettings::default();
    let started = Instant::now();
    let ends: Vec<(bool, u64)> = (0..CHAINS)
        .into_par_iter()
        .map(|chain| {
            let end = synthesize(&energy, &run.synthesis, &refine, SEED, chain);
            let judgement = judge(&energy, &end.refined);
            (judgement.passes_strict(), end.evaluations)
        })
        .collect();
    let strict = ends.iter().filter(|(strict, _)| *strict).count() as f64;
    let evaluations: u64 = ends.iter().map(|(_, evaluations)| evaluations).sum();
    eprintln!(
        "{} on {}: {strict} of {CHAINS}, {evaluations} evaluations, {:.0} s",
        loaded.name,
        run.object,
        started.elapsed().as_secs_f64()
    );
    Ok([strict, evaluations as f64])
}

fn text(
    loaded: &[Loaded],
    refused: &[(String, String)],
    table: &Table,
) -> Result<String, Box<dyn Error>> {
    let mut text = format!(
        "Hands with nothing annotated but what their side files say (only those of our own have one): {CHAINS} chains each \
         (seed {SEED}), default settings, strict filter, with 95 % intervals. The error of the kinematics is the largest over \
         all links at 21 configurations, against MuJoCo 4.0.0. Evaluations of the energy are for each grasp found.\n\n\
         | hand | links | joints | points | capsules | kinematics off by | bottle_round | evaluations | ball | evaluations |\n\
         |---|---|---|---|---|---|---|---|---|---|\n"
    );
    for entry in loaded {
        let hand = &entry.hand;
        let off = entry.difference.as_ref().map_or("–".to_owned(), |off| {
            format!("{:.0e} m, {:.0e} rad", off.metres, off.radians)
        });
        let _ = write!(
            text,
            "| {} | {} | {} | {} | {} | {off}",
            entry.name,
            hand.links.len(),
            hand.joints.len(),
            hand.surface.len(),
            hand.capsules.len()
        );
        for object in OBJECTS {
            let rows = table.of(&run(entry, object).key()?);
            let [strict, evaluations] = rows[0][..] else {
                return Err("a row of the table is broken".into());
            };
            let [low, high] = interval(strict, CHAINS as f64).map(|share| 100.0 * share);
            let _ = write!(
                text,
                " | {strict} of {CHAINS} ({low:.0}–{high:.0} %) | {:.0}",
                evaluations / strict
            );
        }
        text.push_str(" |\n");
    }
    if !refused.is_empty() {
        text.push_str("\nRefused, and what is said then:\n");
        let folder = published::folder().unwrap_or_default();
        for (name, error) in refused {
            let error = error.replace(&*folder.to_string_lossy(), "…");
            let _ = writeln!(text, "- {name}: {error}");
        }
    }
    Ok(text)
}
