//! Table I of Liu et al. (2021): how many grasps hold in simulation → `figures/stability.md`, `.png`, `.csv`
//!
//! There are four populations: `closed`, the default synthesis, whose energy has closed hands as its minima; and three of
//! the energy of four points: `weak`, the nearly unfiltered ends of single short attempts, for comparing filters and scores;
//! `strict`, its usual chains; `firm`, hands that close at the end until they press. Every end is simulated. Finished work is
//! kept in the `.csv`, and a run continues after it. `--quick`: few chains, into `target/`.

#[path = "../yields/interval.rs"]
mod interval;
mod report;
#[path = "../roc.rs"]
mod roc;
mod row;

use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use landscape::evaluation::stability::{Build, Drop, Protocol, SixDirections, Solid, simulate};
use landscape::grasp::closing::preload;
use landscape::grasp::synthesis::{Refinement, SynthesisSettings, synthesize};
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
/// Populations: name, chains on each bottle, chains on each simple shape. Those whose name ends with `PUSHED` use the six
/// directions instead of the drop, which cost twenty times as much.
const POPULATIONS: [(&str, u64, u64); 7] = [
    ("closed", 100, 50),
    ("firm", 320, 50),
    ("strict", 100, 50),
    ("weak", 100, 0),
    ("closed pushed", 20, 0),
    ("firm pushed", 20, 0),
    ("strict pushed", 20, 0),
];
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
            let picture = report::chart(&rows).draw()?;
            picture.save(&folder.join("stability.png"))?;
        }
    }
    Ok(())
}

fn settings(population: &str) -> (EnergySettings, SynthesisSettings) {
    let settings = SynthesisSettings::four_points();
    let settings = match population.trim_end_matches(PUSHED) {
        "closed" => return (EnergySettings::closed(), SynthesisSettings::closed()),
        "weak" => SynthesisSettings {
            steps: settings.steps / settings.attempts / 2,
            attempts: 1,
            ..settings
        },
        "firm" => SynthesisSettings {
            refinement: Refinement::Pressed,
            ..settings
        },
        _ => settings,
    };
    (EnergySettings::four_points(), settings)
}

fn measure(population: &str, name: &str, chains: u64) -> Result<Vec<Row>, Box<dyn Error>> {
    let object = Arc::new(Object::named(name)?);
    let solid = Solid::new(&object.mesh, Build::Pieces);
    eprintln!("  {:?}", solid.fit());
    let hand = Arc::new(Hand::human());
    let (settings, synthesis) = settings(population);
    let energy = GraspEnergy::new(hand.clone(), object.clone(), settings)?;
    let refine = QuenchSettings::default();
    let pushed = population.ends_with(PUSHED);
    let row = |chain| {
        let end = synthesize(&energy, &synthesis, &refine, SEED, chain);
        let judgement = judge(&energy, &end.refined);
        let preload = preload(&energy, &end.refined.pose);
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
            net_wrench: judgement.net_wrench,
            // No friction suffices, so a greater value than any that does.
            friction: judgement.least_friction.unwrap_or(1e3),
            epsilon: judgement.epsilon,
            sigma_m: gaps / contacts.len() as f64,
            force_closure: judgement.force_closure,
            published: judgement.passes_published(),
            strict: judgement.passes_strict(),
            firm: judgement.passes_strict() && preload.is_sufficient(),
            touch_friction: preload.least_friction.unwrap_or(1e3),
            touch_epsilon: preload.epsilon,
            drop: (!pushed).then(|| holds(Protocol::Drop(Drop::default()))),
            at_once: (!pushed).then(|| holds(Protocol::Drop(at_once))),
            six: pushed.then(|| holds(Protocol::SixDirections(SixDirections::default()))),
            rigid: pushed.then(|| holds(Protocol::SixDirections(SixDirections::rigid()))),
        }
    };
    Ok((0..chains).into_par_iter().map(row).collect())
}
