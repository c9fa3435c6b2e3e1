//! Table I of Liu et al. (2021): how many grasps hold in simulation → `figures/stability.md`, `.csv`
//!
//! Every end of the default synthesis is simulated. Finished work is kept in the `.csv`, and a run continues after it.
//! `--quick`: few chains, into `target/`.

#[path = "../yields/interval.rs"]
mod interval;
mod report;
mod row;

use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use landscape::evaluation::stability::{Build, Drop, Protocol, SixDirections, Solid, simulate};
use landscape::grasp::synthesis::{SynthesisSettings, synthesize};
use landscape::grasp::{EnergySettings, GraspEnergy, judge, measure_contacts};
use landscape::hand::Hand;
use landscape::object::Object;
use landscape::optimize::QuenchSettings;
use rayon::prelude::*;
use row::Row;

const SEED: u64 = 7;
const BOTTLES: [&str; 6] = [
    "bottle_flask",
    "bottle_medicine",
    "bottle_round",
    "bottle_square",
    "bottle_squeeze",
    "bottle_water",
];
/// Simple shapes, which are common in published evaluations.
const SIMPLE: [&str; 3] = ["ball", "box", "can"];
/// Populations: name, chains on each bottle, chains on each simple shape. The second uses the six directions instead of the
/// drop, which cost twenty times as much.
const POPULATIONS: [(&str, u64, u64); 2] = [("closed", 100, 50), ("closed pushed", 20, 0)];
const PUSHED: &str = " pushed";

fn main() -> Result<(), Box<dyn Error>> {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let folder = PathBuf::from(if quick { "target" } else { "figures" });
    let csv = folder.join("stability.csv");
    let mut rows = row::read(&csv)?;
    for (population, of_bottles, of_shapes) in POPULATIONS {
        let bottles = BOTTLES.iter().map(|name| (*name, of_bottles));
        for (name, chains) in bottles.chain(SIMPLE.iter().map(|name| (*name, of_shapes))) {
            let chains = if quick { chains.min(4) } else { chains };
            let is_this = |row: &Row| row.object == name && row.population == population;
            let known = rows.iter().filter(|row| is_this(row)).count();
            if known as u64 != chains {
                eprintln!("{population} on {name}");
                rows.retain(|row| !is_this(row));
                rows.extend(measure(population, name, chains)?);
                row::write(&csv, &rows)?;
            }
            // Written after each object, so that an interrupted run leaves a report.
            fs::write(folder.join("stability.md"), report::text(&rows))?;
        }
    }
    Ok(())
}

fn measure(population: &str, name: &str, chains: u64) -> Result<Vec<Row>, Box<dyn Error>> {
    let object = Arc::new(Object::named(name)?);
    let solid = Solid::new(&object.mesh, Build::Pieces);
    eprintln!("  {:?}", solid.fit());
    let hand = Arc::new(Hand::human());
    let synthesis = SynthesisSettings::default();
    let energy = GraspEnergy::new(hand.clone(), object.clone(), EnergySettings::default())?;
    let refine = QuenchSettings::default();
    let pushed = population.ends_with(PUSHED);
    let row = |chain| {
        let end = synthesize(&energy, &synthesis, &refine, SEED, chain);
        let judgement = judge(&energy, &end.refined);
        let contacts = measure_contacts(&energy, &end.refined);
        let gaps: f64 = contacts
            .iter()
            .map(|contact| contact.distance_m.abs())
            .sum();
        let holds =
            |protocol| simulate(&hand, &end.refined, &solid, object.mass_kg, &protocol).is_stable();
        let at_once = Drop {
            settle_s: 0.0,
            ..Drop::default()
        };
        Row {
            population: population.to_owned(),
            object: name.to_owned(),
            chain,
            sigma_m: gaps / contacts.len() as f64,
            strict: judgement.passes_strict(),
            drop: (!pushed).then(|| holds(Protocol::Drop(Drop::default()))),
            at_once: (!pushed).then(|| holds(Protocol::Drop(at_once))),
            six: pushed.then(|| holds(Protocol::SixDirections(SixDirections::default()))),
            rigid: pushed.then(|| holds(Protocol::SixDirections(SixDirections::rigid()))),
        }
    };
    Ok((0..chains).into_par_iter().map(row).collect())
}
