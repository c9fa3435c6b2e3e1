//! Poses the fixtures of the taxonomy in `tests/taxonomy/fixtures`: `authored.json` → `development.json` and
//! `held_out.json`, and `second_authored.json` → `second_held_out.json`.
//!
//! `cargo run --release --example pose_fixtures` prints how well each hand closes, with `!` before those that do not, and
//! writes the files when all fixtures are posed.

#[expect(dead_code, reason = "tests read what this program writes")]
#[path = "../../tests/taxonomy/fixture.rs"]
mod fixture;
#[expect(dead_code, reason = "tests use all of it")]
#[path = "../../tests/taxonomy/shape.rs"]
mod shape;

mod authored;
mod closing;
mod samples;

use std::collections::BTreeMap;

use landscape::hand::Hand;
use landscape::sample::{Task, stream};
use landscape::space::{Pose, PoseSpace, Symmetry, pose_coordinates};
use rand::seq::SliceRandom;
use rayon::prelude::*;

use authored::Authored;
use closing::{Closing, Fit};
use fixture::{Fixture, Placement};
use shape::Union;

const FOLDER: &str = "tests/taxonomy/fixtures";
/// The authored files, first and later, and the files of fixtures made from them: one, or two halves.
const SETS: [(&str, &[&str]); 2] = [
    ("authored", &["development", "held_out"]),
    ("second_authored", &["second_held_out"]),
];
/// Seed of the split into halves, fixed before the first fixture was posed.
const SPLIT_SEED: u64 = 33;
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
    let joints = rough.joints(hand).map_err(said)?;
    let object_from_hand = rough.hand_from_object(hand).map_err(said)?.inverse();
    let start = pose_coordinates(&object_from_hand, &joints);
    let touch = rough.touch.clone().unwrap_or_default();
    let points = |regions: &[String]| -> Result<Vec<Vec<usize>>, String> {
        let of = |region: &String| match shape::points(hand, region) {
            points if points.is_empty() => Err(said(format!("no region starts with {region}"))),
            points => Ok(points),
        };
        regions.iter().map(of).collect()
    };
    let idle = |digit: usize| !(touch.iter()).any(|region| region.starts_with(&hand.digits[digit]));
    let digits = (hand.joints.iter()).map(|joint| hand.links[joint.link.0].digit);
    let mut closing = Closing {
        hand,
        shape: &shape,
        samples: &samples::of(&shape),
        touching: points(&touch)?,
        free: points(rough.free.as_deref().unwrap_or_default())?.concat(),
        idle: digits.map(idle).collect(),
        rough: start,
        looseness: rough.loose.unwrap_or(1.0),
        oppose: rough.oppose.unwrap_or(0.0),
        pull: 1.0,
        push: 1.0,
        space: PoseSpace::new(hand.pose_metric(), Symmetry::None),
    };
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
        joints: names.zip(pose.joints().iter().map(|&q| round(q))).collect(),
        touching: touch,
    };
    Ok((fixture, fit))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let hand = Hand::human();
    let mut counts: BTreeMap<Option<u8>, u8> = BTreeMap::new();
    let sets = SETS.map(|(name, names)| -> Result<_, Box<dyn std::error::Error>> {
        let text = std::fs::read_to_string(format!("{FOLDER}/{name}.json"))?;
        let authored: Vec<Authored> = serde_json::from_str(&text)?;
        let mut tasks = Vec::new();
        for what in &authored {
            for variant in &what.variants {
                let count = counts.entry(what.kind).or_default();
                let id = if let Some(kind) = what.kind {
                    format!("{kind}-{}", char::from(b'a' + *count))
                } else {
                    format!("none-{}", *count + 1)
                };
                *count += 1;
                tasks.push((id, what, variant));
            }
        }
        let posed = (tasks.par_iter()).map(|(id, what, variant)| pose(&hand, id, what, variant));
        let posed: Vec<(Fixture, Fit)> = posed.collect::<Result<_, _>>()?;
        for (fixture, fit) in &posed {
            print(fixture, fit);
        }
        let fixtures = posed.into_iter().map(|(fixture, _)| fixture);
        Ok((fixtures.collect::<Vec<Fixture>>(), names))
    });
    for set in sets.into_iter().collect::<Result<Vec<_>, _>>()? {
        write_set(&set.0, set.1)?;
    }
    Ok(())
}

/// Prints how well a hand closes.
fn print(fixture: &Fixture, fit: &Fit) {
    let gaps = fixture.touching.iter().zip(&fit.gaps_m);
    let open = gaps.filter(|(_, gap)| gap.abs() > 1.5e-3);
    let open: Vec<String> = open
        .map(|(region, gap)| format!("{region} {:.1}", gap * 1e3))
        .collect();
    let depths = [fit.depth_m, fit.intrusion_m, fit.overlap_m].map(|d| d * 1e3);
    let bad = !open.is_empty() || depths.iter().any(|d| *d > 2.5) || fit.beyond_rad > 0.02;
    println!(
        "{}{:8} depth {:.1} intrusion {:.1} overlap {:.1} mm beyond {:.3}  open: {}",
        if bad { "! " } else { "  " },
        fixture.id,
        depths[0],
        depths[1],
        depths[2],
        fit.beyond_rad,
        open.join(", ")
    );
}

/// Writes the fixtures of a set into its files.
fn write_set(fixtures: &[Fixture], names: &[&str]) -> Result<(), Box<dyn std::error::Error>> {
    let mut files = vec![Vec::new(); names.len()];
    for own in fixtures.chunk_by(|one, next| one.kind == next.kind) {
        for (fixture, first) in own.iter().zip(development(own.len(), own[0].kind)) {
            let file = if first { 0 } else { names.len() - 1 };
            files[file].push(fixture);
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
