//! Do the minima of the energy of an elastic layer hold? → `figures/closed_hands.md`
//!
//! Chains with the default energy for the human hand on every object that comes with the program and on the scans in the
//! folder `objects` of `LANDSCAPE_TEST_DATA`, if it is set, and for other hands on three objects. What passes the strict
//! filter is dropped in simulation, and those of the human hand are pushed in six directions, too; nothing is closed or
//! chosen afterwards. The seed and the number of chains may be given: `--example closed_hands 7 64`.

mod chains;

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use chains::Chains;
use landscape::agreement::wilson;
use landscape::evaluation::stability::{LoadTest, Protocol};
use landscape::evaluation::taxonomy::{Labeller, Rule, UNLISTED};
use landscape::grasp::closing::capsule_touches;
use landscape::hand::{Hand, PosedHand};
use landscape::object::{OBJECT_NAMES, Object};
use rayon::prelude::*;

/// Other hands, and the objects on which they are tried.
const OTHER_HANDS: [&str; 3] = [
    "human_thumbless",
    "gripper_three_finger",
    "gripper_parallel",
];
const OTHER_OBJECTS: [&str; 3] = ["bottle_round", "box", "ball"];

/// Scans of household objects (Calli et al. 2015).
const SCANS: [&str; 3] = [
    "ycb_003_cracker_box",
    "ycb_006_mustard_bottle",
    "ycb_055_baseball",
];

/// A grasp that passes the strict filter.
struct Kept {
    holds: bool,
    holds_at_once: bool,
    /// Whether it withstands pushes in six directions; `None` if it was not pushed.
    withstands: Option<bool>,
    /// What touches: 0 is the palm.
    digits: BTreeSet<usize>,
    label: String,
    deepest_m: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let seed: u64 = arguments.next().map_or(Ok(0), |text| text.parse())?;
    let count: u64 = arguments.next().map_or(Ok(48), |text| text.parse())?;
    let mut text = format!(
        "# Closed hands\n\nEach row has {count} chains with the default energy and seed {seed}, made by \
         `cargo run --release --example closed_hands {seed} {count}`. Kept are those that pass the strict filter. Of \
         these, the table gives the share that holds in the drop test with its 95 % interval, the share that holds when \
         the object is let go at once, the share of those of the human hand that hold when they squeeze and the object is pushed \
         in six directions, the mean number of digits that touch and the share of palms that touch (not for hands \
         of boxes), the share of no grasp type, and the depth that 95 % stay below. Nothing was closed after the \
         descents.\n\n\
         | hand | object | kept | hold | interval | let go at once | six directions | digits | palm | of no type | depth |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n"
    );
    let scans = match std::env::var_os("LANDSCAPE_TEST_DATA") {
        Some(data) => SCANS
            .map(|name| Path::new(&data).join(format!("objects/{name}.obj")))
            .to_vec(),
        None => Vec::new(),
    };
    let own = OBJECT_NAMES
        .iter()
        .map(|name| ("human", Object::named(name)));
    let scans = scans.iter().map(|path| ("human", Object::load(path)));
    let others = OTHER_HANDS.iter().flat_map(|hand| {
        let objects = OTHER_OBJECTS.into_iter();
        objects.map(move |object| (*hand, Object::named(object)))
    });
    let mut types: BTreeMap<String, usize> = BTreeMap::new();
    for (name, object) in own.chain(scans).chain(others) {
        let (hand, object) = (Arc::new(Hand::named(name)?), Arc::new(object?));
        let kept = measure(&Chains::new(&hand, &object, seed)?, count);
        let line = row(name, &object.name, &kept, count);
        eprintln!("{line}");
        let _ = writeln!(text, "{line}");
        if name == "human" && OBJECT_NAMES.contains(&&*object.name) {
            for grasp in kept {
                *types.entry(grasp.label).or_insert(0) += 1;
            }
        }
    }
    types.remove(UNLISTED);
    let mut named: Vec<(usize, String)> = types.into_iter().map(|(name, n)| (n, name)).collect();
    named.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    let often = named.iter().filter(|(count, _)| *count >= 5).count();
    let list = named.iter().map(|(count, name)| format!("{name} {count}"));
    writeln!(
        text,
        "\nLabels of the human hand's grasps on all objects but the scans together: {} different ones, {often} of them with five grasps or \
         more: {}.",
        named.len(),
        list.collect::<Vec<_>>().join(", ")
    )?;
    fs::write("figures/closed_hands.md", text)?;
    Ok(())
}

fn measure(chains: &Chains, count: u64) -> Vec<Kept> {
    let (hand, object) = (chains.energy.hand(), chains.energy.object());
    let labeller = Labeller::new(hand, object, Rule::standard());
    let keep = |chain: u64| {
        let end = chains.end(chain);
        let judgement = chains.judge(&end);
        if !judgement.passes_strict() {
            return None;
        }
        let mut posed = PosedHand::default();
        hand.pose(&end.refined.pose, &mut posed);
        let touches = capsule_touches(&object.exact, hand, &posed, 0.0);
        // Hands of boxes take minutes for each.
        let pushes = Protocol::Loads(LoadTest::default());
        let withstands = || chains.holds(&end, &pushes);
        Some(Kept {
            holds: chains.holds(&end, &chains::drop()),
            holds_at_once: chains.holds(&end, &chains::drop_at_once()),
            withstands: (hand.name == "human").then(withstands),
            digits: touches.iter().map(|t| hand.links[t.link.0].digit).collect(),
            label: labeller.label(&end.refined.pose).text().to_string(),
            deepest_m: judgement.deepest_m,
        })
    };
    (0..count).into_par_iter().filter_map(keep).collect()
}

/// A row of the table.
fn row(hand: &str, object: &str, kept: &[Kept], chains: u64) -> String {
    let dash = || "–".to_owned();
    let share = |known: Vec<bool>| {
        let part = known.iter().filter(|held| **held).count();
        if known.is_empty() {
            return dash();
        }
        format!("{:.0} %", 100.0 * part as f64 / known.len() as f64)
    };
    let percent = |test: &dyn Fn(&Kept) -> bool| share(kept.iter().map(test).collect());
    let total = kept.len();
    let holds = kept.iter().filter(|grasp| grasp.holds).count();
    let range = if total == 0 {
        dash()
    } else {
        let [low, high] = wilson(holds as f64, total as f64).map(|bound| 100.0 * bound);
        format!("{low:.0} to {high:.0} %")
    };
    // What touches is asked of capsules, which do not fill boxes.
    let (mut digits, mut palm) = (dash(), dash());
    if !hand.starts_with("gripper") && total > 0 {
        let touch = kept.iter().flat_map(|grasp| &grasp.digits);
        let count = touch.filter(|digit| **digit > 0).count();
        digits = format!("{:.1}", count as f64 / total as f64);
        palm = percent(&|grasp| grasp.digits.contains(&0));
    }
    let mut unlisted = dash();
    if hand == "human" {
        unlisted = percent(&|grasp| grasp.label == UNLISTED);
    }
    let depths = kept.iter().map(|grasp| grasp.deepest_m).collect();
    format!(
        "| {hand} | {object} | {total} of {chains} | {} | {range} | {} | {} | {digits} | {palm} | {unlisted} | {} |",
        percent(&|grasp| grasp.holds),
        percent(&|grasp| grasp.holds_at_once),
        share(kept.iter().filter_map(|grasp| grasp.withstands).collect()),
        chains::deep(depths),
    )
}
