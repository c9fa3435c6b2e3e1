//! Chains with the default energy: how many end in a grasp, how many of these hold when the object drops, and a picture.

use std::error::Error;
use std::sync::Arc;

use landscape::figure::{Image, Scene};
use landscape::hand::Hand;
use landscape::object::Object;
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::chains::{self, Chains};

pub(crate) const CHAINS: u64 = 24;
pub(crate) const OBJECT: &str = "bottle_round";
pub(crate) const SEED: u64 = 0;
const SIDE: u32 = 320;

fn chains(hand: &Arc<Hand>) -> Result<Chains, Box<dyn Error>> {
    let object = Arc::new(Object::named(OBJECT)?);
    Ok(Chains::new(hand, &object, SEED)?)
}

/// Grasps that pass the strict filter, those of them that hold, and the shown chain. The shown chain is the first that holds, otherwise the first that is kept, otherwise the first.
pub(crate) fn measure(hand: &Arc<Hand>) -> Result<[f64; 3], Box<dyn Error>> {
    let chains = chains(hand)?;
    let judged: Vec<[bool; 2]> = (0..CHAINS)
        .into_par_iter()
        .map(|chain| {
            let end = chains.end(chain);
            let kept = chains.judge(&end).passes_strict();
            [kept, kept && chains.holds(&end, &chains::drop())]
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
    let chains = chains(hand)?;
    let grasp = chains.end(shown as u64).refined;
    let scene = Scene::of_grasp(hand, &hand.skin(), chains.energy.object(), &grasp);
    Ok(scene.render(&scene.best_camera(Vector3::z()), SIDE, SIDE))
}
