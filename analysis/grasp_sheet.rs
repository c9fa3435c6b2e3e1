//! Sixty evenly selected grasps of a file → `figures/grasp_sheet.png`
//!
//! `cargo run --release --example grasp_sheet [FILE]`, by default data/grasps.parquet.

use landscape::figure::{Scene, contact_sheet};
use landscape::store::{GraspFile, GraspRow, Overrides};
use nalgebra::Vector3;
use rayon::prelude::*;

const GRASPS: usize = 60;
const COLUMNS: usize = 10;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "data/grasps.parquet".to_owned());
    let (file, _) = GraspFile::read(path.as_ref(), Overrides::default())?;
    let [population] = &file.landscapes()[..] else {
        return Err("grasps of one hand on one object are needed".into());
    };
    let (hand, object) = (population.hand()?, population.object()?);
    let skin = hand.skin();
    let count = file.grasps.len().min(GRASPS);
    let chosen: Vec<&GraspRow> = (0..count)
        .map(|i| &file.grasps[i * file.grasps.len() / count])
        .collect();
    let images: Vec<_> = chosen
        .par_iter()
        .map(|grasp| {
            let scene = Scene::of_grasp(&hand, &skin, &object, &grasp.grasp);
            scene.render(&scene.best_camera(Vector3::z()), 240, 240)
        })
        .collect();
    let captions: Vec<String> = chosen
        .iter()
        .map(|grasp| format!("{}   E {:.3}", grasp.id, grasp.energy))
        .collect();
    contact_sheet(
        &images,
        &captions,
        COLUMNS,
        "figures/grasp_sheet.png".as_ref(),
    )?;
    Ok(())
}
