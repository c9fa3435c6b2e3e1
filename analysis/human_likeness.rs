//! How populations of grasps use the hand, beside people's grasps of the same or similar objects →
//! `figures/human_likeness.md`
//!
//! `LANDSCAPE_TEST_DATA=FOLDER cargo run --release --example human_likeness -- [NAME=FILE,FILE… …]`
//!
//! Each FILE holds grasps (Parquet) of a hand that is built like a human one. `data/grasps.parquet` is always compared.
//! FOLDER holds `ycb_affordance`: grasps that people posed. None of these is part of the project.

#[expect(dead_code, reason = "`annotated` reads the labels")]
mod people;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use landscape::agreement::bootstrap;
use landscape::evaluation::HandUse;
use landscape::evaluation::human_likeness::{MEASURES, Measure};
use landscape::evaluation::taxonomy::Anatomy;
use landscape::store::{GraspFile, Overrides};
use people::{People, Posed};
use rayon::prelude::*;

type Failure = Box<dyn std::error::Error + Send + Sync>;
/// The use of the hand in each grasp, by object.
type Uses = BTreeMap<String, Vec<HandUse>>;

const COMMITTED: &str = "data/grasps.parquet";
const DRAWS: usize = 2000;
const SEED: u64 = 8;
/// People's objects that are like an upright bottle: round or square, and as wide as a hand can go around.
const LIKE_BOTTLES: [&str; 5] = [
    "002_master_chef_can",
    "010_potted_meat_can",
    "022_windex_bottle",
    "036_wood_block",
    "065-a_cups",
];

/// A population and the objects of people's grasps that it is compared with.
struct Compared {
    name: String,
    uses: Uses,
    people: Uses,
}

fn main() -> Result<(), Failure> {
    let people = uses_of(&People::read()?)?;
    let only = |names: &[&str]| -> Uses {
        let own = people
            .iter()
            .filter(|(name, _)| names.contains(&name.as_str()));
        own.map(|(name, uses)| (name.clone(), uses.clone()))
            .collect()
    };
    let mut all = vec![Compared {
        name: format!("`{COMMITTED}` (closed hands on a bottle) beside bottles, cans and cups"),
        uses: uses_in(&[COMMITTED])?,
        people: only(&LIKE_BOTTLES),
    }];
    for argument in std::env::args().skip(1) {
        let (name, files) = argument
            .split_once('=')
            .ok_or("a population is NAME=FILE,FILE…")?;
        let uses = uses_in(&files.split(',').collect::<Vec<_>>())?;
        let objects: Vec<&str> = uses.keys().map(String::as_str).collect();
        let people = only(&objects);
        if people.len() != uses.len() {
            return Err(format!("{name}: people have not grasped all of {objects:?}").into());
        }
        all.push(Compared {
            name: format!("{name}, beside people's grasps of the same objects"),
            people,
            uses,
        });
    }
    let text = report(&people, &all);
    std::fs::write("figures/human_likeness.md", text)?;
    Ok(())
}

/// The use of the hand in all grasps that people posed. Their labels are not read.
fn uses_of(people: &People) -> Result<Uses, Failure> {
    let anatomy = Anatomy::of(&people.hand)?;
    let one = |(name, grasps): (&String, &Vec<Posed>)| -> Result<_, Failure> {
        let object = people.object(name)?;
        let of = |grasp: &Posed| HandUse::of(&people.hand, &anatomy, &object, &grasp.x);
        Ok((name.clone(), grasps.iter().filter_map(of).collect()))
    };
    people.grasps.par_iter().map(one).collect()
}

/// The use of the hand in all grasps of some files.
fn uses_in(files: &[&str]) -> Result<Uses, Failure> {
    let mut all = Uses::new();
    for path in files {
        let (file, _) = GraspFile::read(Path::new(path), Overrides::default())?;
        for population in file.landscapes() {
            let hand = population.hand.build()?;
            let object = population.object.build(population.scale)?;
            let anatomy = Anatomy::of(&hand)?;
            let uses = population
                .grasps
                .par_iter()
                .filter_map(|row| HandUse::of(&hand, &anatomy, &object, &row.grasp.pose));
            let uses: Vec<HandUse> = uses.collect();
            all.entry(population.object.name.clone())
                .or_default()
                .extend(uses);
        }
    }
    Ok(all)
}

/// The mean of a measure over the grasps of each object.
fn means(uses: &Uses, measure: &Measure) -> Vec<f64> {
    let mean = |uses: &Vec<HandUse>| {
        let values: Vec<f64> = uses.iter().filter_map(measure.of).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    uses.values().filter_map(mean).collect()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// The mean over objects, with the interval of resampled objects.
fn over_objects(values: &[f64]) -> String {
    let middle = mean(values.iter().copied());
    if values.len() < 2 {
        return format!("{middle:.1}");
    }
    let drawn = bootstrap(&vec![0; values.len()], DRAWS, SEED, |chosen| {
        mean(chosen.iter().map(|&i| values[i]))
    });
    let [low, high] = drawn.interval(0.95);
    format!("{middle:.1} ({low:.1} to {high:.1})")
}

/// The difference of the means: objects are resampled together where both populations have the same, else apart.
fn difference(ours: &Uses, people: &Uses, measure: &Measure) -> String {
    let (own, theirs) = (means(ours, measure), means(people, measure));
    let same = ours.keys().eq(people.keys()) && own.len() == theirs.len();
    let middle = mean(own.iter().copied()) - mean(theirs.iter().copied());
    let drawn = if same {
        bootstrap(&vec![0; own.len()], DRAWS, SEED, |chosen| {
            mean(chosen.iter().map(|&i| own[i] - theirs[i]))
        })
    } else {
        let mut blocks = vec![0; own.len()];
        blocks.extend(vec![1; theirs.len()]);
        bootstrap(&blocks, DRAWS, SEED, |chosen| {
            let [own_part, their_part] = [true, false].map(|first| {
                let part = chosen.iter().filter(|i| (**i < own.len()) == first);
                mean(part.map(|&i| if first { own[i] } else { theirs[i - own.len()] }))
            });
            own_part - their_part
        })
    };
    let [low, high] = drawn.interval(0.95);
    let apart = if low > 0.0 || high < 0.0 { " *" } else { "" };
    format!("{middle:+.1} ({low:+.1} to {high:+.1}){apart}")
}

fn count(uses: &Uses) -> String {
    let grasps: usize = uses.values().map(Vec::len).sum();
    format!("{grasps} grasps of {} objects", uses.len())
}

fn report(people: &Uses, all: &[Compared]) -> String {
    let mut text = format!(
        "# How populations use the hand, beside people's grasps\n\n\
         `LANDSCAPE_TEST_DATA=… cargo run --release --example human_likeness -- NAME=FILE,FILE… …`\n\n\
         Contact is all of the hand's surface within 5 mm of the object, weighted by area and nearness. A measure is the mean \
         over the grasps of an object, then over objects. Intervals: 95 %, from {DRAWS} resamplings of the objects; the same \
         objects are resampled together. A star marks differences whose interval excludes zero. People's hand has another \
         skin (its palm is a convex hull, which makes palm contact look larger), so small differences of shares say little.\n\n\
         ## People, all objects\n\n{}.\n\n| | mean (95 %) |\n|---|---|\n",
        count(people)
    );
    for measure in &MEASURES {
        let _ = writeln!(
            text,
            "| {} | {} |",
            measure.name,
            over_objects(&means(people, measure))
        );
    }
    for compared in all {
        let _ = write!(
            text,
            "\n## {}\n\n{}; people: {}.\n\n| | population | people | difference |\n|---|---|---|---|\n",
            compared.name,
            count(&compared.uses),
            count(&compared.people)
        );
        for measure in &MEASURES {
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} |",
                measure.name,
                over_objects(&means(&compared.uses, measure)),
                over_objects(&means(&compared.people, measure)),
                difference(&compared.uses, &compared.people, measure)
            );
        }
    }
    text
}
