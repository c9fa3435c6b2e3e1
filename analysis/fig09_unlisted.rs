//! Figure 9: valid grasps that no type of the taxonomy fits → `figures/fig09_unlisted.png`, `.svg` and `.md`
//!
//! `cargo run --release --example fig09_unlisted` labels the committed grasps, drops them in simulation, and shows those
//! that hold and are unlisted. It also counts special cases named in the paper: some fingers hold while others are free, on
//! the neck (to twist a bottle open) or anywhere, with the palm free (to hold a second object in it).

mod command;

use std::error::Error;
use std::fmt::Write;

use command::landscape;
use landscape::evaluation::taxonomy::{Labeller, Rule, UNLISTED};
use landscape::figure::{Scene, contact_sheet};
use landscape::hand::Hand;
use landscape::store::{GraspFile, GraspRow, Overrides};
use nalgebra::Vector3;
use rayon::prelude::*;

const GRASPS: &str = "data/grasps.parquet";
const LABELLED: &str = "target/fig09.labelled.parquet";
const DROPPED: &str = "target/fig09.stability.parquet";
const SHOWN: usize = 15;
const COLUMNS: usize = 5;
const SIDE: u32 = 380;
/// Height at which the neck of the bottle begins, as a share of its height.
const NECK: f64 = 0.7;

fn main() -> Result<(), Box<dyn Error>> {
    landscape(&["label", GRASPS, "-q", "-o", LABELLED])?;
    landscape(&["stability", LABELLED, "-q", "--fresh", "-o", DROPPED])?;
    let (file, _) = GraspFile::read(DROPPED.as_ref(), Overrides::default())?;
    let [population] = &file.landscapes()[..] else {
        return Err("grasps of one hand on one object are needed".into());
    };
    let (hand, object) = (population.hand()?, population.object()?);

    let labeller = Labeller::new(&hand, &object, Rule::standard());
    let unlisted = |grasp: &&GraspRow| grasp.label_auto.as_deref() == Some(UNLISTED);
    let held = |grasp: &&GraspRow| grasp.stable == Some(true);
    let chosen: Vec<&GraspRow> = (file.grasps.iter()).filter(unlisted).filter(held).collect();
    let [low, high] = object.mesh.bounds();
    let neck_m = low.z + NECK * (high.z - low.z);
    let fingers_free: Vec<&GraspRow> = (file.grasps.iter())
        .filter(held)
        .filter(|grasp| {
            // The palm, the ring finger and the little finger are not used.
            let digits = labeller.label(&grasp.grasp.pose).virtual_fingers;
            !digits.contains('P') && !digits.contains('4') && !digits.contains('5')
        })
        .collect();
    let on_neck = fingers_free
        .iter()
        .filter(|grasp| middle(&hand, grasp).z > neck_m)
        .count();

    let mut text = format!(
        "# Valid grasps that are of no type\n\n`cargo run --release --example fig09_unlisted`, rule {}, {GRASPS}.\n\n",
        Rule::standard().version
    );
    let counts = [
        ("grasps", file.grasps.len()),
        ("unlisted", file.grasps.iter().filter(unlisted).count()),
        (
            "held in the drop test",
            file.grasps.iter().filter(held).count(),
        ),
        ("unlisted and held", chosen.len()),
        (
            "held without palm, ring and little finger, listed or not",
            fingers_free.len(),
        ),
        ("of these on the neck", on_neck),
    ];
    for (what, count) in counts {
        let _ = writeln!(text, "- {what}: {count}");
    }
    print!("{text}");
    std::fs::write("figures/fig09_unlisted.md", text)?;

    let skin = hand.skin();
    let step = chosen.len().max(1).div_ceil(SHOWN).max(1);
    let shown: Vec<&GraspRow> = chosen.into_iter().step_by(step).collect();
    let images: Vec<_> = shown
        .par_iter()
        .map(|grasp| {
            let scene = Scene::of_grasp(&hand, &skin, &object, &grasp.grasp);
            scene.render(&scene.closer_camera(Vector3::z()), SIDE, SIDE)
        })
        .collect();
    let captions: Vec<String> = shown
        .iter()
        .map(|grasp| {
            let best = grasp.label_best.as_deref().unwrap_or_default();
            let nearest = best.split(',').next().unwrap_or_default();
            format!("{}: nearest {nearest}", grasp.id)
        })
        .collect();
    for ending in ["png", "svg"] {
        let path = format!("figures/fig09_unlisted.{ending}");
        contact_sheet(&images, &captions, COLUMNS, path.as_ref())?;
    }
    Ok(())
}

/// Mean of the contact points, object frame.
fn middle(hand: &Hand, grasp: &GraspRow) -> Vector3<f64> {
    let mut posed = landscape::hand::PosedHand::default();
    hand.pose(&grasp.grasp.pose, &mut posed);
    let points = grasp
        .grasp
        .contacts
        .iter()
        .map(|&i| posed.points[i as usize]);
    points.sum::<Vector3<f64>>() / grasp.grasp.contacts.len().max(1) as f64
}
