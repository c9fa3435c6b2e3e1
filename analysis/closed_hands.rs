//! Do the minima of the energy of an elastic layer hold? → `figures/closed_hands.md`
//!
//! Chains with the default energy for the human hand on every object that comes with the program and on the scans in the
//! folder `objects` of `LANDSCAPE_TEST_DATA`, if it is set, and for other hands on three objects. What passes the strict
//! filter is dropped in simulation, and those of the human hand are pushed in six directions, too; nothing is closed or
//! chosen afterwards. The seed and the number of chains may be given: `--example closed_hands 7 64`. Times are printed to
//! the terminal.

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
use landscape::evaluation::stability::{Build, Drop, Protocol, SixDirections, Solid, simulate};
use landscape::evaluation::taxonomy::{Labeller, Rule, UNLISTED};
use landscape::grasp::closing::capsule_touches;
use landscape::grasp::synthesis::{SynthesisSettings, Synthesized, synthesize};
use landscape::grasp::{EnergySettings, GraspEnergy, judge};
use landscape::hand::{Hand, PosedHand};
use landscape::mesh::Mesh;
use landscape::object::{Description, OBJECT_NAMES, Object, ObjectError};
use landscape::optimize::QuenchSettings;
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
#[expect(clippy::struct_excessive_bools, reason = "independent findings")]
struct Kept {
    holds: bool,
    holds_at_once: bool,
    /// Whether it withstands pushes in six directions; `None` if it was not pushed.
    withstands: Option<bool>,
    digits: usize,
    palm: bool,
    label: String,
    unlisted: bool,
    deepest_m: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let seed: u64 = arguments.next().map_or(Ok(0), |text| text.parse())?;
    let chains: u64 = arguments.next().map_or(Ok(48), |text| text.parse())?;
    let mut text = format!(
        "# Closed hands\n\nEach row has {chains} chains with the default energy and seed {seed}, made by \
         `cargo run --release --example closed_hands {seed} {chains}`. Kept are those that pass the strict filter. Of \
         these, the table gives the share that holds in the drop test with its 95 % interval, the share that holds when \
         the object is let go at once, the share of those of the human hand that hold when they squeeze and the object is pushed \
         in six directions, the mean number of digits that touch and the share of palms that touch (not for hands \
         of boxes), the share of no grasp type, and the depth that 95 % stay below. Nothing was closed after the \
         descents.\n\n\
         | hand | object | kept | hold | interval | let go at once | six directions | digits | palm | of no type | depth |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n"
    );
    let named = |name: &&'static str| (*name, Object::parts_of_named(name));
    let data = std::env::var_os("LANDSCAPE_TEST_DATA");
    if data.is_none() {
        eprintln!("LANDSCAPE_TEST_DATA is not set, so there are no rows of scans");
    }
    let scans = data.iter().flat_map(|data| {
        let folder = Path::new(data).join("objects");
        SCANS.map(|name| (name, scan(&folder, name)))
    });
    let pairs = (OBJECT_NAMES.iter().map(named).chain(scans)).map(|object| ("human", object));
    let others = OTHER_HANDS.iter().flat_map(|hand| {
        OTHER_OBJECTS
            .iter()
            .map(move |object| (*hand, named(object)))
    });
    let mut types: BTreeMap<String, usize> = BTreeMap::new();
    for (hand, (object, parts)) in pairs.chain(others) {
        let started = Instant::now();
        let (mesh, description) = parts?;
        let (kept, evaluations) = measure(hand, object, &mesh, &description, seed, chains)?;
        let seconds = started.elapsed().as_secs_f64();
        row(&mut text, [hand, object], &kept, chains);
        if hand == "human" && !SCANS.contains(&object) {
            for grasp in &kept {
                *types.entry(grasp.label.clone()).or_insert(0) += 1;
            }
        }
        eprintln!(
            "{hand} on {object}: {} of {chains} kept, {} hold, {seconds:.0} s, {evaluations} evaluations",
            kept.len(),
            kept.iter().filter(|grasp| grasp.holds).count()
        );
    }
    types.remove(UNLISTED);
    let mut named: Vec<(usize, String)> = types.into_iter().map(|(name, n)| (n, name)).collect();
    named.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    let often = named.iter().filter(|(count, _)| *count >= 5).count();
    let list: Vec<String> = (named.iter())
        .map(|(count, name)| format!("{name} {count}"))
        .collect();
    writeln!(
        text,
        "\nLabels of the human hand's grasps on all objects but the scans together: {} different ones, {often} of them with five grasps or \
         more: {}.",
        named.len(),
        list.join(", ")
    )?;
    fs::write("figures/closed_hands.md", text)?;
    Ok(())
}

fn scan(folder: &Path, name: &str) -> Result<(Mesh, Description), ObjectError> {
    let parts = Object::parts_of_file(&folder.join(name).with_extension("obj"), None)?;
    Ok((parts.mesh, parts.description))
}

fn measure(
    hand: &str,
    object: &str,
    mesh: &Mesh,
    description: &Description,
    seed: u64,
    chains: u64,
) -> Result<(Vec<Kept>, u64), Box<dyn Error>> {
    let hand = Arc::new(Hand::named(hand)?);
    let mass_kg = description.mass_of(mesh);
    let solid = Solid::new(mesh, Build::Pieces);
    let object = Arc::new(Object::from_mesh(object, mesh.clone(), description)?);
    let energy = GraspEnergy::new(hand.clone(), object.clone(), EnergySettings::default())?;
    let (settings, refine) = (SynthesisSettings::default(), QuenchSettings::default());
    let labeller = Labeller::new(&hand, &object, Rule::standard());
    let at_once = Drop {
        settle_s: 0.0,
        ..Drop::default()
    };
    let withstands = |end: &Synthesized, protocol: Protocol| {
        simulate(&hand, &end.refined, &solid, mass_kg, &protocol).is_stable()
    };
    let keep = |end: &Synthesized| {
        let judgement = judge(&energy, &end.refined);
        if !judgement.passes_strict() {
            return None;
        }
        let mut posed = PosedHand::default();
        hand.pose(&end.refined.pose, &mut posed);
        let touches = capsule_touches(&object.exact, &hand, &posed, 0.0);
        let mut digits: Vec<usize> = touches.iter().map(|t| hand.links[t.link.0].digit).collect();
        digits.sort_unstable();
        digits.dedup();
        let label = labeller.label(&end.refined.pose).text().to_string();
        Some(Kept {
            holds: withstands(end, Protocol::Drop(Drop::default())),
            holds_at_once: withstands(end, Protocol::Drop(at_once)),
            withstands: None,
            digits: digits.iter().filter(|digit| **digit > 0).count(),
            palm: digits.contains(&0),
            unlisted: label == UNLISTED,
            label,
            deepest_m: judgement.deepest_m,
        })
    };
    let ends: Vec<(Option<Kept>, Synthesized)> = (0..chains)
        .into_par_iter()
        .map(|chain| {
            let end = synthesize(&energy, &settings, &refine, seed, chain);
            (keep(&end), end)
        })
        .collect();
    let evaluations = ends.iter().map(|(_, end)| end.evaluations).sum();
    let mut kept: Vec<(Kept, Synthesized)> = (ends.into_iter())
        .filter_map(|(kept, end)| Some((kept?, end)))
        .collect();
    // Hands of boxes take minutes for each.
    let pushed = if hand.name == "human" { kept.len() } else { 0 };
    kept.par_iter_mut().take(pushed).for_each(|(kept, end)| {
        let pushes = Protocol::SixDirections(SixDirections::default());
        kept.withstands = Some(withstands(end, pushes));
    });
    Ok((
        kept.into_iter().map(|(kept, _)| kept).collect(),
        evaluations,
    ))
}

fn row(text: &mut String, [hand, object]: [&str; 2], kept: &[Kept], chains: u64) {
    let count = |test: &dyn Fn(&Kept) -> bool| kept.iter().filter(|grasp| test(grasp)).count();
    let total = kept.len();
    let share = |part: usize, of: usize| {
        if of == 0 {
            "–".to_owned()
        } else {
            format!("{:.0} %", 100.0 * part as f64 / of as f64)
        }
    };
    let percent = |part: usize| share(part, total);
    let pushed: Vec<bool> = kept.iter().filter_map(|grasp| grasp.withstands).collect();
    let withstand = pushed.iter().filter(|withstands| **withstands).count();
    let holds = count(&|grasp| grasp.holds);
    let range = if total == 0 {
        "–".to_owned()
    } else {
        let [low, high] = interval(holds as f64, total as f64);
        format!("{:.0} to {:.0} %", 100.0 * low, 100.0 * high)
    };
    let digits: usize = kept.iter().map(|grasp| grasp.digits).sum();
    let digits = if total == 0 {
        "–".to_owned()
    } else {
        format!("{:.1}", digits as f64 / total as f64)
    };
    let mut depths: Vec<f64> = kept.iter().map(|grasp| grasp.deepest_m).collect();
    depths.sort_by(f64::total_cmp);
    let deep = depths.get(total * 95 / 100).copied();
    let deep = deep.map_or("–".to_owned(), |depth| format!("{:.2} mm", 1e3 * depth));
    // What touches is asked of capsules, which do not fill boxes.
    let (digits, palm) = if hand.starts_with("gripper") {
        ("–".to_owned(), "–".to_owned())
    } else {
        (digits, percent(count(&|grasp| grasp.palm)))
    };
    let unlisted = if hand == "human" {
        percent(count(&|grasp| grasp.unlisted))
    } else {
        "–".to_owned()
    };
    let _ = writeln!(
        text,
        "| {hand} | {object} | {total} of {chains} | {} | {range} | {} | {} | {digits} | {palm} | {unlisted} | {deep} |",
        percent(holds),
        percent(count(&|grasp| grasp.holds_at_once)),
        share(withstand, pushed.len()),
    );
}
