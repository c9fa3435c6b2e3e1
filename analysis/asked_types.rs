//! How often chains find each grasp type, asked for it or not → `figures/asked_types.md`, `.csv`
//!
//! The human hand on the fifteen objects that come with the program: chains of the usual sampler, whose grasps are labelled,
//! and chains that are asked for each type; further chains for types that none of these found. Beside it the Shadow and
//! Allegro hands of `LANDSCAPE_TEST_DATA`, if it is set, asked only, on four of the objects. What is found is dropped in
//! simulation. Finished objects are kept in the table, so that a stopped run goes on: `--example asked_types 4 0` (chains for
//! each type and object, seed).

#[path = "table.rs"]
mod table;

use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use landscape::evaluation::stability::{Drop, Protocol};
use landscape::evaluation::taxonomy::{Rule, Taxonomy};
use landscape::object::OBJECT_NAMES;
use landscape::store::GraspFile;
use landscape::study::{
    Asked, Origin, PopulationSettings, Run, hand_abilities, hand_files, hand_metadata, label_all,
    simulate_all, synthesize_population,
};
use table::Table;

const TABLE: &str = "figures/asked_types.csv";
const HEADER: &str = "set,object,asked,number,chains,found,held";

/// Hands of the test data and their files.
const HANDS: [(&str, &str); 2] = [
    (
        "shadow",
        "hands/shadow_dexgraspnet/shadow_hand_wrist_free.xml",
    ),
    ("allegro", "hands/allegro/allegro_right_nomesh.xml"),
];

/// Objects for these hands.
const OBJECTS_OF_OTHERS: [&str; 4] = ["ball", "bottle_round", "box", "mug"];

/// Chains on each object that are not asked for anything: 420 on fifteen.
const USUAL_CHAINS: u64 = 28;

/// Further chains on each object that are asked for a type which no chain found, and their seed.
const MORE_CHAINS: u64 = 12;
const MORE_SEED: u64 = 1;

/// Number of a type, chains, those that found it, and those whose grasp holds.
type Counts = [f64; 4];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let chains: u64 = arguments.next().map_or(Ok(4), |text| text.parse())?;
    let seed: u64 = arguments.next().map_or(Ok(0), |text| text.parse())?;
    let mut table = Table::read(Path::new(TABLE), HEADER)?;
    let mut hands = vec![("human", None)];
    if let Some(data) = std::env::var_os("LANDSCAPE_TEST_DATA") {
        hands.extend(HANDS.map(|(name, file)| (name, Some(Path::new(&data).join(file)))));
    }
    let mut keys = Vec::new();
    let mut done = |key: String,
                    table: &mut Table,
                    measured: &dyn Fn() -> Result<Vec<Counts>, Box<dyn Error>>|
     -> Result<(), Box<dyn Error>> {
        if table.of(&key).is_empty() {
            let counts = measured()?;
            table.set(&key, counts.iter().map(<[f64; 4]>::as_slice));
            eprintln!("{key}");
        }
        keys.push(key);
        Ok(table.write(Path::new(TABLE), &keys)?)
    };
    for (hand, file) in &hands {
        let objects = if file.is_some() {
            OBJECTS_OF_OTHERS.as_slice()
        } else {
            OBJECT_NAMES.as_slice()
        };
        for object in objects {
            let origin = origin(hand, file.as_ref(), object)?;
            if file.is_none() {
                let usual = || measure(&origin, &[], USUAL_CHAINS, seed);
                done(key(hand, object, "no"), &mut table, &usual)?;
            }
            let asked = || abilities(&origin, chains, seed);
            done(key(hand, object, "yes"), &mut table, &asked)?;
        }
    }
    let rare: Vec<u8> = (1..=33)
        .filter(|number| sum(&table, "human", *number, "yes")[1] < 0.5)
        .collect();
    let wishes: Vec<Asked> = rare.iter().map(|number| Asked::Type(*number)).collect();
    for object in OBJECT_NAMES {
        let origin = Origin::named("human", object)?;
        let more = || {
            let mut counts = measure(&origin, &wishes, MORE_CHAINS, MORE_SEED)?;
            counts.retain(|count| rare.iter().any(|number| is_of(count, *number)));
            Ok(counts)
        };
        done(key("human", object, "more"), &mut table, &more)?;
    }
    fs::write("figures/asked_types.md", report(&table))?;
    Ok(())
}

fn key(hand: &str, object: &str, asked: &str) -> String {
    format!("{hand},{object},{asked}")
}

fn is_of(row: &[f64], number: u8) -> bool {
    (row[0] - f64::from(number)).abs() < 0.5
}

/// Chains, found and held of a type on all objects together.
fn sum(table: &Table, hand: &str, number: u8, asked: &str) -> [f64; 3] {
    let objects = OBJECT_NAMES.iter();
    let rows = objects.flat_map(|object| table.of(&key(hand, object, asked)));
    rows.filter(|row| is_of(row, number))
        .fold([0.0; 3], |sum, row| {
            std::array::from_fn(|k| sum[k] + row[k + 1])
        })
}

fn origin(hand: &str, file: Option<&PathBuf>, object: &str) -> Result<Origin, Box<dyn Error>> {
    let mut origin = Origin::named("human", object)?;
    if let Some(file) = file {
        let flag = file.display().to_string();
        let files = hand_files(&flag, None, false)?;
        origin.hand = hand_metadata(&flag, &files, false)?;
        hand.clone_into(&mut origin.hand.name);
    }
    Ok(origin)
}

/// The counts of each type on an object, of chains that are asked for each.
fn abilities(origin: &Origin, chains: u64, seed: u64) -> Result<Vec<Counts>, Box<dyn Error>> {
    let found = hand_abilities(std::slice::from_ref(origin), chains, seed, &Run::default())?;
    let counts = found.abilities.iter().map(|own| {
        let [chains, found, held] = [own.chains, own.found, own.held].map(|n| n as f64);
        [f64::from(own.number), chains, found, held]
    });
    Ok(counts.collect())
}

/// The counts of each type on an object, of chains that are asked for some (`chains` for each) or for none.
fn measure(
    origin: &Origin,
    asked: &[Asked],
    chains: u64,
    seed: u64,
) -> Result<Vec<Counts>, Box<dyn Error>> {
    let run = Run::default();
    let settings = PopulationSettings {
        chains: chains * asked.len().max(1) as u64,
        seed,
        asked: asked.to_vec(),
        ..PopulationSettings::default()
    };
    let energy = origin.energy(&settings)?;
    let grasps = synthesize_population(&energy, origin, &settings, &run)?.grasps;
    let file = GraspFile {
        metadata: origin.metadata(&energy, &settings)?,
        grasps,
    };
    let labels = label_all(&file, Rule::standard(), |_| true, &run)?;
    let outcomes = simulate_all(&file, &Protocol::Drop(Drop::default()), &run)?.outcomes;
    let mut counts: Vec<Counts> = (1..=33)
        .map(|number| [f64::from(number), chains as f64, 0.0, 0.0])
        .collect();
    for (id, outcome) in outcomes {
        if let Some(entry) = labels[&id].grasp_type() {
            let count = &mut counts[usize::from(entry.number) - 1];
            count[2] += 1.0;
            count[3] += f64::from(u8::from(outcome.is_stable()));
        }
    }
    Ok(counts)
}

/// The table of types: yields on all objects together.
fn report(table: &Table) -> String {
    let told = |[chains, found, held]: [f64; 3]| match found {
        _ if chains == 0.0 => "–".to_owned(),
        0.0 => format!("0 of {chains}"),
        _ => format!("{found} of {chains}, {held} hold"),
    };
    let mut text = "# Asked for a type\n\nChains of the human hand on fifteen objects, not asked and \
                    asked for each type. Found are ends that pass the strict filter and that \
                    the rule names so; all were dropped in simulation. Gain: share with asking over share without, where half \
                    a grasp counts if nothing was found without. Types that need digits which a hand lacks are not asked for (–). \
                    Made by `cargo run --release --example asked_types`.\n\n\
                    | type | not asked | asked | gain | asked, Shadow | asked, Allegro |\n|---|---|---|---|---|---|\n"
        .to_owned();
    let mut gains = Vec::new();
    let mut reached: BTreeSet<u8> = BTreeSet::new();
    let mut reached_by = HANDS.map(|_| BTreeSet::new());
    for entry in &Taxonomy::feix().types {
        let [usual, asked] = ["no", "yes"].map(|asked| sum(table, "human", entry.number, asked));
        let gain = (asked[1] / asked[0].max(1.0)) / (usual[1].max(0.5) / usual[0].max(1.0));
        if asked[1] > 0.0 {
            reached.insert(entry.number);
        }
        if usual[1] / usual[0].max(1.0) < 5.0 / 420.0 {
            gains.push(gain);
        }
        let others = HANDS.map(|(hand, _)| sum(table, hand, entry.number, "yes"));
        for (own, [_, found, _]) in reached_by.iter_mut().zip(others) {
            if found > 0.0 {
                own.insert(entry.number);
            }
        }
        let others = others.map(told);
        let _ = writeln!(
            text,
            "| {} {} | {} | {} | {gain:.1} | {} | {} |",
            entry.number,
            entry.name,
            told(usual),
            told(asked),
            others[0],
            others[1]
        );
    }
    gains.sort_by(f64::total_cmp);
    let _ = writeln!(
        text,
        "\nThe human hand reached {} of 33 types when asked. Of the {} types that chains give in fewer than 5 of 420 \
         without asking, the median gain is {:.1}.",
        reached.len(),
        gains.len(),
        gains.get(gains.len() / 2).copied().unwrap_or(f64::NAN)
    );
    let mut again = Vec::new();
    for entry in &Taxonomy::feix().types {
        let [chains, found, held] = sum(table, "human", entry.number, "more");
        if chains > 0.0 {
            let found_again = told([chains, found, held]);
            again.push(format!("{} ({found_again})", entry.name));
            if found > 0.0 {
                reached.insert(entry.number);
            }
        }
    }
    let _ = writeln!(
        text,
        "\nThe other types were asked for again, with {MORE_CHAINS} chains on each object and another seed: {}. With these, \
         {} types were reached.",
        again.join(", "),
        reached.len()
    );
    let [shadow, allegro] = &reached_by;
    let all: BTreeSet<&u8> = reached.iter().chain(shadow).chain(allegro).collect();
    if !(shadow.is_empty() && allegro.is_empty()) {
        let _ = writeln!(
            text,
            "\nOn {} of the objects the Shadow hand reached {} types and the Allegro hand {}. All three hands together reached {}.",
            OBJECTS_OF_OTHERS.len(),
            shadow.len(),
            allegro.len(),
            all.len()
        );
    }
    text
}
