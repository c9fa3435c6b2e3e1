//! Poses the fixtures of the taxonomy in `tests/taxonomy/fixtures`: `authored.json` → `development.json` and
//! `held_out.json`, and `second_authored.json` → `second_held_out.json`; and from these `widened.json` and
//! `widened_held_out.json`: the same scenes with other hands, sizes and forms.
//!
//! `cargo run --release --example pose_fixtures [FOLDER [ID …]]`: with a folder, it also draws the fixtures whose id starts
//! with one of `ID` into it. Files are written when all fixtures are posed. `--widen` in place of FOLDER only makes the
//! widened ones, from the files of posed fixtures; `LANDSCAPE_TEST_DATA` must then name the test data with the other hands.

#[path = "../../tests/taxonomy/fixture.rs"]
mod fixture;
#[path = "../../tests/taxonomy/shape.rs"]
mod shape;
#[path = "../confusion/widened.rs"]
mod widened;

mod authored;
mod closing;
mod picture;
mod widen;

use std::collections::BTreeMap;
use std::path::PathBuf;

use landscape::figure::contact_sheet;
use landscape::hand::Hand;
use landscape::sample::{Task, stream};
use landscape::space::{Pose, pose_coordinates};
use rand::seq::SliceRandom;
use rayon::prelude::*;

use authored::Authored;
use closing::{Closing, Fit};
use fixture::{Fixture, Placement};
use shape::Union;
use widen::{Reader, widen};
use widened::HandName;

const FOLDER: &str = "tests/taxonomy/fixtures";
/// The authored files, first and later, and the files of fixtures made from them: one, or two halves.
const SETS: [(&str, &[&str]); 2] = [
    ("authored", &["development", "held_out"]),
    ("second_authored", &["second_held_out"]),
];
/// Seed of the split into halves, fixed before the first fixture was posed.
const SPLIT_SEED: u64 = 33;
/// Files of widened fixtures of the two sets, and the seed of their sizes and forms.
const WIDENED: [&str; 2] = ["widened", "widened_held_out"];
const WIDEN_SEED: u64 = 25;

/// Which fixtures are for development: the first half of a shuffled list of each type, and of poses outside the taxonomy.
fn development(count: usize, kind: Option<u8>) -> Vec<bool> {
    let mut order: Vec<usize> = (0..count).collect();
    let mut rng = stream(SPLIT_SEED, Task::Resampling, u64::from(kind.unwrap_or(0)));
    order.shuffle(&mut rng);
    let mut chosen = vec![false; count];
    for &i in &order[..count.div_ceil(2)] {
        chosen[i] = true;
    }
    chosen
}

fn pose(
    hand: &Hand,
    id: &str,
    what: &Authored,
    variant: &authored::Variant,
) -> Result<(Fixture, Fit), String> {
    let rough = variant.pose.over(&what.pose);
    let said = |problem: String| format!("{id}: {problem}");
    let parts = rough
        .object
        .as_ref()
        .ok_or_else(|| said("no object".into()))?;
    let shape = Union(parts.iter().flat_map(authored::Part::primitives).collect());
    let joints = rough.joints_rad(hand).map_err(said)?;
    let object_from_hand = rough.hand_from_object(hand).map_err(said)?.inverse();
    let start = pose_coordinates(&object_from_hand, &joints);
    let (touch, free) = (
        rough.touch.clone().unwrap_or_default(),
        rough.free.clone().unwrap_or_default(),
    );
    for region in touch.iter().chain(&free) {
        if shape::points(hand, region).is_empty() {
            return Err(said(format!("no region starts with {region}")));
        }
    }
    let samples = picture::samples(&shape);
    let loose = rough.loose.unwrap_or(1.0);
    let mut closing = Closing::new(
        hand,
        &shape,
        &samples,
        (
            touch
                .iter()
                .map(|region| shape::points(hand, region))
                .collect(),
            free.iter()
                .flat_map(|region| shape::points(hand, region))
                .collect(),
        ),
        start,
        (loose, rough.oppose.unwrap_or(0.0)),
        |digit| {
            !touch
                .iter()
                .any(|region| region.starts_with(&hand.digits[digit]))
        },
    );
    let pose = Pose::from(closing.close());
    let fit = closing.fit(&pose);
    // Millionths are finer than all measured quantities.
    let round = |value: f64| (value * 1e6).round() / 1e6;
    let names = hand.joints.iter().map(|joint| joint.name.clone());
    let fixture = Fixture {
        id: id.to_owned(),
        kind: what.kind,
        name: what.name.clone().unwrap_or_else(|| "none".to_owned()),
        depicts: format!("{} {}", what.depicts, variant.with)
            .trim()
            .to_owned(),
        object: shape.0.clone(),
        object_from_hand: Placement {
            translation_m: std::array::from_fn(|k| round(pose[k])),
            rotation_wxyz: pose.rotation_wxyz(),
        },
        joints_rad: names.zip(pose.joints().iter().map(|&q| round(q))).collect(),
        touching: touch,
    };
    Ok((fixture, fit))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let pictures = arguments.next().map(PathBuf::from);
    if pictures
        .as_ref()
        .is_some_and(|first| first.as_os_str() == "--widen")
    {
        return write_widened();
    }
    let wanted: Vec<String> = arguments.collect();
    let hand = Hand::human();
    let mut authored: Vec<(usize, Authored)> = Vec::new();
    for (set, (name, _)) in SETS.iter().enumerate() {
        let text = std::fs::read_to_string(format!("{FOLDER}/{name}.json"))?;
        let own: Vec<Authored> = serde_json::from_str(&text)?;
        authored.extend(own.into_iter().map(|what| (set, what)));
    }

    let mut tasks = Vec::new();
    let mut counts: BTreeMap<Option<u8>, u8> = BTreeMap::new();
    for (set, what) in &authored {
        for variant in &what.variants {
            let count = counts.entry(what.kind).or_default();
            let id = if let Some(kind) = what.kind {
                format!("{kind}-{}", char::from(b'a' + *count))
            } else {
                format!("none-{}", *count + 1)
            };
            *count += 1;
            if wanted.is_empty()
                || wanted
                    .iter()
                    .any(|start| id.starts_with(&format!("{start}-")) || id == *start)
            {
                tasks.push((id, *set, what, variant));
            }
        }
    }
    let posed: Vec<(Fixture, Fit)> = tasks
        .par_iter()
        .map(|(id, _, what, variant)| pose(&hand, id, what, variant))
        .collect::<Result<_, _>>()?;
    for (fixture, fit) in &posed {
        let gaps: Vec<String> = fixture
            .touching
            .iter()
            .zip(&fit.gaps_m)
            .filter(|(_, gap)| gap.abs() > 1.5e-3)
            .map(|(region, gap)| format!("{region} {:.1}", gap * 1e3))
            .collect();
        let depths = [fit.depth_m, fit.intrusion_m, fit.overlap_m].map(|d| d * 1e3);
        let bad = !gaps.is_empty() || depths.iter().any(|d| *d > 2.5) || fit.beyond_rad > 0.02;
        println!(
            "{}{:8} depth {:.1} intrusion {:.1} overlap {:.1} mm beyond {:.3}  open: {}",
            if bad { "! " } else { "  " },
            fixture.id,
            depths[0],
            depths[1],
            depths[2],
            fit.beyond_rad,
            gaps.join(", ")
        );
    }
    if let Some(folder) = pictures {
        std::fs::create_dir_all(&folder)?;
        let skin = hand.skin();
        for (page, chunk) in posed.chunks(12).enumerate() {
            let images: Vec<_> = chunk
                .par_iter()
                .filter_map(|(fixture, _)| picture::views(&hand, &skin, fixture, 250))
                .flatten_iter()
                .collect();
            let captions: Vec<String> = chunk
                .iter()
                .flat_map(|(fixture, _)| {
                    [format!("{} {}", fixture.id, fixture.name), String::new()]
                })
                .collect();
            contact_sheet(
                &images,
                &captions,
                8,
                &folder.join(format!("fixtures_{page:02}.png")),
            )?;
        }
    }
    if wanted.is_empty() {
        let sets = tasks.iter().map(|(_, set, ..)| *set);
        let fixtures: Vec<(usize, Fixture)> = sets.zip(posed.into_iter().map(|p| p.0)).collect();
        for (set, (_, names)) in SETS.iter().enumerate() {
            let own = fixtures.iter().filter(|(of, _)| *of == set);
            write_set(&own.map(|(_, fixture)| fixture).collect::<Vec<_>>(), names)?;
        }
    }
    Ok(())
}

/// Makes the widened fixtures. Those of the first authored file are for fitting, those of the second one for judging.
fn write_widened() -> Result<(), Box<dyn std::error::Error>> {
    let hands = HandName::ALL.map(|name| (name, name.hand()));
    let mut readers = Vec::new();
    for (name, hand) in &hands {
        let hand = hand
            .as_ref()
            .ok_or_else(|| format!("{name:?} is not at hand"))?;
        readers.push(Reader::new(*name, hand)?);
    }
    for (set, (_, names)) in SETS.iter().enumerate() {
        let mut bases: Vec<Fixture> = Vec::new();
        for name in *names {
            let text = std::fs::read_to_string(format!("{FOLDER}/{name}.json"))?;
            bases.extend(serde_json::from_str::<Vec<Fixture>>(&text)?);
        }
        let made = widen(&bases, &readers, WIDEN_SEED + set as u64)?;
        println!(
            "{} of {} scenes close well",
            made.len(),
            bases.len() * readers.len()
        );
        let lines: Vec<String> = made
            .iter()
            .map(serde_json::to_string)
            .collect::<Result<_, _>>()?;
        let path = format!("{FOLDER}/{}.json", WIDENED[set]);
        std::fs::write(path, format!("[\n{}\n]\n", lines.join(",\n")))?;
    }
    Ok(())
}

/// Writes the fixtures of a set into its files.
fn write_set(fixtures: &[&Fixture], names: &[&str]) -> Result<(), Box<dyn std::error::Error>> {
    let mut files = vec![Vec::new(); names.len()];
    for own in fixtures.chunk_by(|one, next| one.kind == next.kind) {
        for (fixture, first) in own.iter().zip(development(own.len(), own[0].kind)) {
            let file = if first { 0 } else { names.len() - 1 };
            files[file].push(*fixture);
        }
    }
    for (name, file) in names.iter().zip(&files) {
        std::fs::write(
            format!("{FOLDER}/{name}.json"),
            serde_json::to_string_pretty(file)? + "\n",
        )?;
    }
    Ok(())
}
