//! Figure 9: valid grasps that no type of the taxonomy fits → `figures/fig09_unlisted.png`, `.svg` and `.md`
//!
//! `cargo run --release --example fig09_unlisted` labels the committed grasps, drops them in simulation, and shows those
//! that hold and are unlisted, one of each kind (up to 15). It also counts special cases named in the paper: some fingers hold while
//! others are free, on the neck (to twist a bottle open) or anywhere, with the palm free (to hold a second object in it).

mod command;

use std::error::Error;
use std::fmt::Write;

use command::landscape;
use landscape::energy::Energy;
use landscape::evaluation::taxonomy::{Labeller, Rule, Taxonomy, UNLISTED};
use landscape::figure::{Scene, contact_sheet};
use landscape::grasp::{EnergySettings, GraspEnergy};
use landscape::hand::Hand;
use landscape::store::{GraspFile, GraspRow, Overrides};
use nalgebra::Vector3;

const GRASPS: &str = "data/grasps.parquet";
const LABELLED: &str = "target/fig09.labelled.parquet";
const DROPPED: &str = "target/fig09.stability.parquet";
const SHOWN: usize = 15;
/// Grasps are alike within this distance of poses, metres.
const ALIKE_M: f64 = 0.005;
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

    let energy = GraspEnergy::new(hand.clone(), object.clone(), EnergySettings::default())?;
    let mut different: Vec<Vec<&GraspRow>> = Vec::new();
    for grasp in &chosen {
        let pose = &grasp.grasp.pose;
        let near = |other: &GraspRow| energy.space().distance(&other.grasp.pose, pose) <= ALIKE_M;
        match different.iter_mut().find(|alike| near(alike[0])) {
            Some(alike) => alike.push(grasp),
            None => different.push(vec![grasp]),
        }
    }

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
            "different ones of these, more than 5 mm apart",
            different.len(),
        ),
        ("shown", different.len().min(SHOWN)),
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
    let images: Vec<_> = (different.iter().take(SHOWN))
        .map(|alike| {
            let scene = Scene::of_grasp(&hand, &skin, &object, &alike[0].grasp);
            scene.render(&scene.closer_camera(Vector3::z()), SIDE, SIDE)
        })
        .collect();
    let captions: Vec<String> = (different.iter().take(SHOWN))
        .map(|alike| {
            let label = labeller.label(&alike[0].grasp.pose);
            let nearest = label
                .best
                .first()
                .and_then(|best| Taxonomy::feix().numbered(best.number));
            let name = nearest.map_or("none", |entry| entry.name.as_str());
            let (id, count) = (alike[0].id, alike.len());
            format!("{id}: {name} fits {:.3} ({count}×)", label.fit)
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
