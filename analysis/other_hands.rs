//! Nine strict grasps of each of two other hands → `figures/other_hands.png`
//!
//! The thumbless human hand (first row) and the gripper with three fingers (second row) grasp the round bottle with the
//! default settings: the first nine chains of seed 0 whose ends pass the strict filter. The chain and its energy are below
//! each picture. The program prints the number of chains.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use landscape::figure::{Image, Scene, contact_sheet};
use landscape::grasp::synthesis::{SynthesisSettings, Synthesized, synthesize};
use landscape::grasp::{EnergySettings, GraspEnergy, judge};
use landscape::hand::Hand;
use landscape::object::Object;
use landscape::optimize::QuenchSettings;
use nalgebra::Vector3;
use rayon::prelude::*;

const HANDS: [&str; 2] = ["human_thumbless", "gripper_three_finger"];
const OBJECT: &str = "bottle_round";
const GRASPS: usize = 9;
/// Number of chains at a time. `MOST` is the limit.
const BATCH: u64 = 8;
const MOST: u64 = 256;
const SIDE: u32 = 240;

fn main() -> Result<(), Box<dyn Error>> {
    let object = Arc::new(Object::named(OBJECT)?);
    let (mut images, mut captions) = (Vec::new(), Vec::new());
    for name in HANDS {
        let hand = Arc::new(Hand::named(name)?);
        let energy = GraspEnergy::new(hand, object.clone(), EnergySettings::default())?;
        let (passed, chains) = grasps(&energy);
        println!(
            "{name} on {OBJECT}: {} of {chains} chains pass the strict filter",
            passed.len()
        );
        if passed.len() < GRASPS {
            return Err(format!("{name}: only {} grasps in {chains} chains", passed.len()).into());
        }
        let shown = &passed[..GRASPS];
        images.extend(pictures(&energy, shown));
        captions.extend(
            shown
                .iter()
                .map(|end| format!("{}   E {:.3}", end.chain, end.energy)),
        );
    }
    contact_sheet(
        &images,
        &captions,
        GRASPS,
        Path::new("figures/other_hands.png"),
    )?;
    Ok(())
}

/// Strict grasps in the order of chains, until there are enough, and the number of chains.
fn grasps(energy: &GraspEnergy) -> (Vec<Synthesized>, u64) {
    let (settings, refine) = (SynthesisSettings::default(), QuenchSettings::default());
    let (mut passed, mut chains) = (Vec::new(), 0);
    while passed.len() < GRASPS && chains < MOST {
        let batch: Vec<Synthesized> = (chains..chains + BATCH)
            .into_par_iter()
            .map(|chain| synthesize(energy, &settings, &refine, 0, chain))
            .collect();
        let strict = batch
            .into_iter()
            .filter(|end| judge(energy, &end.refined).passes_strict());
        passed.extend(strict);
        chains += BATCH;
    }
    (passed, chains)
}

fn pictures(energy: &GraspEnergy, grasps: &[Synthesized]) -> Vec<Image> {
    let skin = energy.hand().skin();
    grasps
        .par_iter()
        .map(|end| {
            let (hand, object) = (energy.hand(), energy.object());
            let scene = Scene::of_grasp(hand, &skin, object, &end.refined);
            scene.render(&scene.best_camera(Vector3::z()), SIDE, SIDE)
        })
        .collect()
}
