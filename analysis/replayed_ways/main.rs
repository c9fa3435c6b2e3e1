//! Are low passes ways that a hand can go? → `figures/replayed_ways.{md,csv,png}`
//!
//! `cargo run --release --example replayed_ways -- FOLDER` builds the landscapes of docs/decisions/replay.md in FOLDER, drives
//! their edges and the controls in simulation, and reports. What is in FOLDER already is kept, so that an interrupted run
//! goes on. With `trial` as second argument the seed is another one, and the report goes to FOLDER.

#[path = "../command.rs"]
mod command;
mod design;
mod film;
mod report;
mod runs;
#[path = "../table.rs"]
mod table;

use std::fs;
use std::path::{Path, PathBuf};

use design::{HANDS, OBJECTS, SEED, TRIAL_SEED};
use runs::{Driven, mapped};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let folder: PathBuf = arguments
        .next()
        .ok_or("name the folder for landscapes and drives")?
        .into();
    fs::create_dir_all(&folder)?;
    let trial = arguments.next().is_some_and(|word| word == "trial");
    let seed = if trial { TRIAL_SEED } else { SEED };
    let pairs = HANDS
        .iter()
        .flat_map(|hand| OBJECTS.map(|object| [*hand, object]));
    let maps = pairs.map(|pair| Ok((pair.join("."), mapped(&folder, pair, seed)?)));
    let maps: Vec<_> = maps.collect::<Result<_, Failure>>()?;
    let driven = maps
        .iter()
        .map(|(set, files)| Driven::new(&folder, set.clone(), files, seed));
    let driven: Vec<Driven<'_>> = driven.collect::<Result<_, Failure>>()?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("figures");
    report::write(&driven, if trial { &folder } else { &root })
}
