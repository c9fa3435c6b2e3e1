//! Sixty evenly selected grasps of a file → `figures/grasp_sheet.png`
//!
//! `cargo run --release --example grasp_sheet [FILE [PICTURE [SIDE]]]`, by default data/grasps.parquet with pictures of 240
//! pixels. `figures/grasp_sheets/OBJECT.png` are such sheets of other objects, of 150 pixels.

use std::path::Path;

use landscape::figure::{Scene, contact_sheet};
use landscape::store::{GraspFile, GraspRow, Overrides};
use nalgebra::Vector3;
use rayon::prelude::*;

const GRASPS: usize = 60;
const COLUMNS: usize = 10;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut or = |default: &str| arguments.next().unwrap_or_else(|| default.to_owned());
    let (path, picture) = (or("data/grasps.parquet"), or("figures/grasp_sheet.png"));
    let side: u32 = or("240").parse()?;
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
            scene.render(&scene.best_camera(Vector3::z()), side, side)
        })
        .collect();
    let captions: Vec<String> = chosen
        .iter()
        .map(|grasp| format!("{}   E {:.3}", grasp.id, grasp.energy))
        .collect();
    if let Some(folder) = Path::new(&picture).parent() {
        std::fs::create_dir_all(folder)?;
    }
    contact_sheet(&images, &captions, COLUMNS, picture.as_ref())?;
    Ok(())
}
