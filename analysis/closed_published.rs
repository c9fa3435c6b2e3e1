//! Do the minima of the energy of an elastic layer hold for published hands, and what do they cost? →
//! `figures/closed_published.md`
//!
//! Chains with the default energy for the human hand, the gripper with three fingers and four published hands in the
//! folder `hands` of `LANDSCAPE_TEST_DATA`, each on four objects. What passes the strict filter is dropped in simulation.
//! The seed and the number of chains may be given: `--example closed_published 7 48`.

#[expect(dead_code, reason = "each program uses a part")]
mod chains;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use chains::Chains;
use landscape::agreement::wilson;
use landscape::grasp::synthesis::Synthesized;
use landscape::hand::{Hand, HandFiles};
use landscape::object::Object;
use rayon::prelude::*;

const NAMED: [&str; 2] = ["human", "gripper_three_finger"];
const PUBLISHED: [&str; 4] = [
    "dex_urdf/shadow_hand/shadow_hand_right.urdf",
    "dex_urdf/allegro_hand/allegro_hand_right.urdf",
    "dex_urdf/inspire_hand/inspire_hand_right.urdf",
    "dex_urdf/barrett_hand/bhand_model.urdf",
];
const OBJECTS: [&str; 4] = ["bottle_round", "box", "ball", "mug"];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let seed: u64 = arguments.next().map_or(Ok(0), |text| text.parse())?;
    let count: u64 = arguments.next().map_or(Ok(48), |text| text.parse())?;
    let mut text = format!(
        "# Closed hands of meshes and boxes\n\nEach row has {count} chains with the default energy and seed {seed}, made by \
         `LANDSCAPE_TEST_DATA=… cargo run --release --example closed_published {seed} {count}`. Kept are those that pass the \
         strict filter. Of these, the table gives the share that holds in the drop test with its 95 % interval, and the depth \
         that 95 % stay below. The price is the processor time of a kept grasp, without judging and dropping it, divided by \
         that of the human hand on the same object. Nothing was closed after the descents.\n\n\
         | hand | capsules | self pairs | object | kept | hold | interval | depth | price |\n|---|---|---|---|---|---|---|---|---|\n"
    );
    let data = std::env::var_os("LANDSCAPE_TEST_DATA").ok_or("set LANDSCAPE_TEST_DATA")?;
    let folder = Path::new(&data).join("hands");
    let named = NAMED.map(|name| (name, HandFiles::named(name)));
    let load = |name| (name, HandFiles::load_within(&folder.join(name), &folder));
    let mut human_s = [None; OBJECTS.len()];
    for (name, files) in named.into_iter().chain(PUBLISHED.map(load)) {
        let hand = Arc::new(Hand::from_files(&files?)?);
        for (object, human_s) in OBJECTS.into_iter().zip(&mut human_s) {
            let chains = Chains::new(&hand, &Arc::new(Object::named(object)?), seed)?;
            let before_s = cpu_s();
            let ends: Vec<Synthesized> = (0..count)
                .into_par_iter()
                .map(|chain| chains.end(chain))
                .collect();
            let spent_s = cpu_s() - before_s;
            let judged = ends.par_iter().filter_map(|end| {
                let judgement = chains.judge(end);
                let holds = || chains.holds(end, &chains::drop());
                (judgement.passes_strict()).then(|| (holds(), judgement.deepest_m))
            });
            let (held, depths): (Vec<bool>, Vec<f64>) = judged.unzip();
            let total = held.len() as f64;
            let mut hold = "– | –".to_owned();
            if total > 0.0 {
                let held = held.iter().filter(|held| **held).count() as f64;
                let [low, high] = wilson(held, total).map(|bound| 100.0 * bound);
                let share = 100.0 * held / total;
                hold = format!("{share:.0} % | {low:.0} to {high:.0} %");
            }
            let price = spent_s / total / *human_s.get_or_insert(spent_s / total);
            let line = format!(
                "| {name} | {} | {} | {object} | {total} of {count} | {hold} | {} | {price:.1} |",
                hand.capsules.len(),
                hand.self_pairs.len(),
                chains::deep(depths),
            );
            eprintln!("{line} {spent_s:.1} s");
            let _ = writeln!(text, "{line}");
        }
    }
    fs::write("figures/closed_published.md", text)?;
    Ok(())
}

/// Processor time of this process, seconds; NaN where `/proc` is missing.
fn cpu_s() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default();
    let ticks = fields.split_whitespace().skip(11).take(2);
    let ticks: Vec<f64> = ticks.filter_map(|field| field.parse().ok()).collect();
    match ticks[..] {
        [user, system] => (user + system) / 100.0,
        _ => f64::NAN,
    }
}
