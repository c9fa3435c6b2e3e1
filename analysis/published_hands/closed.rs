//! Chains with the default energy: how many end in a grasp, how many of these hold when the object drops, and a picture.

use std::error::Error;
use std::sync::Arc;

use landscape::evaluation::stability::{Build, Drop, Protocol, Solid, simulate};
use landscape::figure::{Image, Scene};
use landscape::grasp::synthesis::{SynthesisSettings, Synthesized, synthesize};
use landscape::grasp::{EnergySettings, GraspEnergy, judge};
use landscape::hand::Hand;
use landscape::object::Object;
use landscape::optimize::QuenchSettings;
use nalgebra::Vector3;
use rayon::prelude::*;

pub(crate) const CHAINS: u64 = 24;
pub(crate) const OBJECT: &str = "bottle_round";
pub(crate) const SEED: u64 = 0;
const SIDE: u32 = 320;

fn energy(hand: &Arc<Hand>) -> Result<GraspEnergy, Box<dyn Error>> {
    let object = Arc::new(Object::named(OBJECT)?);
    let settings = EnergySettings::default();
    Ok(GraspEnergy::new(hand.clone(), object, settings)?)
}

fn end(energy: &GraspEnergy, chain: u64) -> Synthesized {
    let (settings, refine) = (SynthesisSettings::default(), QuenchSettings::default());
    synthesize(energy, &settings, &refine, SEED, chain)
}

/// Grasps that pass the strict filter, those of them that hold, and the shown chain. The shown chain is the first that holds, otherwise the first that is kept, otherwise the first.
pub(crate) fn measure(hand: &Arc<Hand>) -> Result<[f64; 3], Box<dyn Error>> {
    let energy = energy(hand)?;
    let (mesh, description) = Object::parts_of_named(OBJECT)?;
    let mass_kg = description.mass_of(&mesh);
    let solid = Solid::new(&Object::named(OBJECT)?.mesh, Build::Pieces);
    let drop = Protocol::Drop(Drop::default());
    let judged: Vec<[bool; 2]> = (0..CHAINS)
        .into_par_iter()
        .map(|chain| {
            let grasp = end(&energy, chain).refined;
            let kept = judge(&energy, &grasp).passes_strict();
            [
                kept,
                kept && simulate(hand, &grasp, &solid, mass_kg, &drop).is_stable(),
            ]
        })
        .collect();
    let count = |which: usize| judged.iter().filter(|ends| ends[which]).count() as f64;
    let first = |which: usize| judged.iter().position(|ends| ends[which]);
    let shown = first(1).or(first(0)).unwrap_or(0);
    Ok([count(0), count(1), shown as f64])
}

/// The end of the chain that [`measure`] chose.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the number of a chain, which the table keeps as text"
)]
pub(crate) fn picture(hand: &Arc<Hand>, shown: f64) -> Result<Image, Box<dyn Error>> {
    let chain = shown as u64;
    let energy = energy(hand)?;
    let scene = Scene::of_grasp(
        hand,
        &hand.skin(),
        energy.object(),
        &end(&energy, chain).refined,
    );
    Ok(scene.render(&scene.best_camera(Vector3::z()), SIDE, SIDE))
}
