//! Do the minima of the energy of an elastic layer hold for published hands, and what do they cost? →
//! `figures/closed_published.md`
//!
//! Chains with the default energy for the human hand, the gripper with three fingers and four published hands in the
//! folder `hands` of `LANDSCAPE_TEST_DATA`, each on four objects. What passes the strict filter is dropped in simulation.
//! The seed and the number of chains may be given, then parts of names of hands or paths, or `all` for every known hand:
//! `--example closed_published 7 48 allegro barrett`. With names nothing is written to files.

#[path = "yields/interval.rs"]
mod interval;

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use interval::interval;
use landscape::evaluation::stability::{Build, Drop, Protocol, Solid, simulate};
use landscape::grasp::layer::{Layer, LayerSettings};
use landscape::grasp::synthesis::{SynthesisSettings, Synthesized, synthesize};
use landscape::grasp::{EnergySettings, GraspEnergy, judge};
use landscape::hand::{Hand, HandError, HandFiles};
use landscape::object::Object;
use landscape::optimize::QuenchSettings;
use rayon::prelude::*;

const NAMED: [&str; 4] = [
    "human",
    "human_thumbless",
    "gripper_parallel",
    "gripper_three_finger",
];
const PUBLISHED: [&str; 12] = [
    "dex_urdf/shadow_hand/shadow_hand_right.urdf",
    "dex_urdf/allegro_hand/allegro_hand_right.urdf",
    "dex_urdf/inspire_hand/inspire_hand_right.urdf",
    "dex_urdf/barrett_hand/bhand_model.urdf",
    "dex_urdf/dclaw_gripper/dclaw_gripper.urdf",
    "shadow_dexonomy/shadow_right.xml",
    "shadow_dexonomy/shadow_right_primitives.xml",
    "shadow_dexgraspnet/shadow_hand_vis.xml",
    "shadow_dexgraspnet/shadow_hand_wrist_free.xml",
    "allegro/allegro_right_nomesh.xml",
    "urdf/shadow_hand_right_nomesh.urdf",
    "mano/mano_right.xml",
];
/// The hands of the figure.
const SHOWN: [&str; 6] = [
    "human",
    "gripper_three_finger",
    "dex_urdf/shadow_hand/shadow_hand_right.urdf",
    "dex_urdf/allegro_hand/allegro_hand_right.urdf",
    "dex_urdf/inspire_hand/inspire_hand_right.urdf",
    "dex_urdf/barrett_hand/bhand_model.urdf",
];
const OBJECTS: [&str; 4] = ["bottle_round", "box", "ball", "mug"];

/// An object and what drops of it.
struct Scene {
    object: Arc<Object>,
    mass_kg: f64,
    /// `None` if nothing is dropped.
    solid: Option<Solid>,
}

/// Whether grasps are dropped: the slowest part, which `NO_DROP=1` leaves out.
fn dropped() -> bool {
    std::env::var_os("NO_DROP").is_none()
}

/// What the chains of a hand on an object gave.
#[derive(Default)]
struct Found {
    chains: usize,
    depths_m: Vec<f64>,
    held: usize,
    cpu_s: f64,
    evaluations: u64,
    objections: BTreeMap<&'static str, usize>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let seed: u64 = arguments.next().map_or(Ok(0), |text| text.parse())?;
    let chains: u64 = arguments.next().map_or(Ok(48), |text| text.parse())?;
    let wanted: Vec<String> = arguments.collect();
    let mut text = format!(
        "# Closed hands of meshes and boxes\n\nEach row has {chains} chains with the default energy and seed {seed}, made by \
         `LANDSCAPE_TEST_DATA=… cargo run --release --example closed_published {seed} {chains}`. Kept are those that pass the \
         strict filter. Of these, the table gives the share that holds in the drop test with its 95 % interval, and the depth \
         that 95 % stay below. The price is the processor time of a kept grasp, without judging and dropping it, divided by \
         that of the human hand on the same object. Nothing was closed after the descents.\n\n\
         | hand | capsules | self pairs | object | kept | hold | interval | depth | price |\n|---|---|---|---|---|---|---|---|---|\n"
    );
    let folder = std::env::var_os("LANDSCAPE_TEST_DATA").map(|data| Path::new(&data).join("hands"));
    let published = folder.iter().flat_map(|folder| {
        PUBLISHED.map(|name| {
            (
                name.to_owned(),
                HandFiles::load_within(&folder.join(name), folder),
            )
        })
    });
    if wanted.is_empty() && folder.is_none() {
        return Err("LANDSCAPE_TEST_DATA is not set".into());
    }
    let named = NAMED.map(|name| (name.to_owned(), HandFiles::named(name)));
    let scenes = OBJECTS.map(|object| -> Result<Scene, Box<dyn Error>> {
        let (mesh, description) = Object::parts_of_named(object)?;
        Ok(Scene {
            object: Arc::new(Object::named(object)?),
            mass_kg: description.mass_of(&mesh),
            solid: dropped().then(|| Solid::new(&mesh, Build::Pieces)),
        })
    });
    let scenes = scenes.into_iter().collect::<Result<Vec<_>, _>>()?;
    // Paths of other descriptions may be given as well.
    let paths = wanted.iter().filter(|name| Path::new(name).is_file());
    let paths: Vec<_> = paths
        .map(|name| (name.clone(), HandFiles::load(Path::new(name))))
        .collect();
    let mut refused = Vec::new();
    let mut prices_s = [f64::NAN; OBJECTS.len()];
    for (name, files) in named.into_iter().chain(published).chain(paths) {
        let is_wanted = if wanted.is_empty() {
            SHOWN.contains(&name.as_str())
        } else {
            (wanted.iter()).any(|part| part == "all" || name.contains(part.as_str()))
        };
        if !is_wanted {
            continue;
        }
        let hand = match files
            .and_then(|files: HandFiles| -> Result<Hand, HandError> { Hand::from_files(&files) })
        {
            Ok(hand) => Arc::new(hand),
            Err(error) => {
                eprintln!("{name}: {error}");
                refused.push((name, error.to_string()));
                continue;
            }
        };
        for (place, object) in OBJECTS.into_iter().enumerate() {
            let found = measure(&hand, &scenes[place], seed, chains)?;
            let price_s = found.cpu_s / found.depths_m.len() as f64;
            if name == "human" {
                prices_s[place] = price_s;
            }
            row(
                &mut text,
                &name,
                &hand,
                object,
                &found,
                price_s / prices_s[place],
            );
        }
    }
    if !refused.is_empty() {
        text.push_str("\nRefused, and what is said then:\n");
        let folder = folder.unwrap_or_default();
        for (name, error) in refused {
            let error = error.replace(&*folder.to_string_lossy(), "…");
            writeln!(text, "- {name}: {error}")?;
        }
    }
    if wanted.is_empty() {
        fs::write("figures/closed_published.md", text)?;
    }
    Ok(())
}

/// Processor time of this process, seconds; NaN where `/proc` is missing.
fn cpu_s() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split_whitespace();
    let ticks: Vec<f64> = fields
        .skip(11)
        .take(2)
        .filter_map(|f| f.parse().ok())
        .collect();
    if ticks.len() == 2 {
        ticks.iter().sum::<f64>() / 100.0
    } else {
        f64::NAN
    }
}

fn measure(
    hand: &Arc<Hand>,
    scene: &Scene,
    seed: u64,
    chains: u64,
) -> Result<Found, Box<dyn Error>> {
    let object = scene.object.clone();
    let started = Instant::now();
    let energy = GraspEnergy::new(hand.clone(), object, EnergySettings::default())?;
    let ready_s = started.elapsed().as_secs_f64();
    let (settings, refine) = (SynthesisSettings::default(), QuenchSettings::default());
    let before_s = cpu_s();
    let ends: Vec<Synthesized> = (0..chains)
        .into_par_iter()
        .map(|chain| synthesize(&energy, &settings, &refine, seed, chain))
        .collect();
    let mut found = Found {
        chains: ends.len(),
        cpu_s: cpu_s() - before_s,
        evaluations: ends.iter().map(|end| end.evaluations).sum(),
        ..Found::default()
    };
    let judged: Vec<_> = ends
        .par_iter()
        .map(|end| {
            let judgement = judge(&energy, &end.refined);
            let objection = judgement.strict_objection();
            let protocol = Protocol::Drop(Drop::default());
            let holds = scene.solid.as_ref().is_some_and(|solid| {
                objection.is_none()
                    && simulate(hand, &end.refined, solid, scene.mass_kg, &protocol).is_stable()
            });
            (objection, holds, judgement.deepest_m)
        })
        .collect();
    for (objection, holds, deepest_m) in judged {
        match objection {
            None => found.depths_m.push(deepest_m),
            Some(objection) => *found.objections.entry(objection).or_default() += 1,
        }
        found.held += usize::from(holds);
    }
    found.depths_m.sort_by(f64::total_cmp);
    if ready_s > 0.1 {
        let layer = Layer::new(hand, LayerSettings::default().patch_spacing_m);
        eprintln!(
            "  {} spheres and {} nodes after {ready_s:.1} s",
            layer.spheres.len(),
            layer.nodes
        );
    }
    Ok(found)
}

fn row(text: &mut String, name: &str, hand: &Hand, object: &str, found: &Found, price: f64) {
    let total = found.depths_m.len();
    let hold = if total == 0 || !dropped() {
        "– | –".to_owned()
    } else {
        let [low, high] = interval(found.held as f64, total as f64);
        let share = found.held as f64 / total as f64;
        format!(
            "{:.0} % | {:.0} to {:.0} %",
            100.0 * share,
            100.0 * low,
            100.0 * high
        )
    };
    let deep = found.depths_m.get(total * 95 / 100);
    let deep = deep.map_or("–".to_owned(), |depth| format!("{:.2} mm", 1e3 * depth));
    let line = format!(
        "| {name} | {} | {} | {object} | {total} of {} | {hold} | {deep} | {price:.1} |",
        hand.capsules.len(),
        hand.self_pairs.len(),
        found.chains,
    );
    let objections: Vec<String> = (found.objections.iter())
        .map(|(objection, count)| format!("{objection} {count}"))
        .collect();
    eprintln!(
        "{line} {:.1} s, {} evaluations of {:.0} µs; {}",
        found.cpu_s,
        found.evaluations,
        1e6 * found.cpu_s / found.evaluations as f64,
        objections.join(", ")
    );
    let _ = writeln!(text, "{line}");
}
