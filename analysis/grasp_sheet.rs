//! Sixty grasps of a file, evenly taken → `figures/grasp_sheet.png`
//!
//! `cargo run --release --example grasp_sheet [FILE]`, by default data/grasps.parquet.

use std::sync::Arc;

use landscape::figure::{Scene, contact_sheet};
use landscape::hand::{Hand, HandFiles};
use landscape::object::{Mesh, Object};
use landscape::store::{Grasp, GraspFile, Overrides};
use nalgebra::Vector3;
use rayon::prelude::*;

const GRASPS: usize = 60;
const COLUMNS: usize = 10;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "data/grasps.parquet".to_owned());
    let (file, _) = GraspFile::read(path.as_ref(), Overrides::default())?;
    let description = file
        .metadata
        .hands
        .first()
        .ok_or("the file describes no hand")?;
    let texts = description.description.iter();
    let files = HandFiles::of_texts(texts.map(|file| [file.name.as_str(), file.text.as_str()]));
    let hand = Arc::new(Hand::from_files(&files)?);
    let object = file
        .metadata
        .objects
        .first()
        .ok_or("the file describes no object")?;
    let mesh = object
        .mesh_obj
        .as_ref()
        .ok_or("the file holds no mesh of the object")?;
    let object = Object::from_mesh(
        &object.name,
        Mesh::from_obj(&object.name, &mut mesh.as_bytes())?,
        &serde_json::from_value(object.description.clone())?,
    )?;
    let skin = hand.skin();
    let count = file.grasps.len().min(GRASPS);
    let chosen: Vec<&Grasp> = (0..count)
        .map(|i| &file.grasps[i * file.grasps.len() / count])
        .collect();
    let images: Vec<_> = chosen
        .par_iter()
        .map(|grasp| {
            let mut x = grasp.translation_m.to_vec();
            x.extend(grasp.rotation_wxyz);
            x.extend(&grasp.joints_rad);
            let scene = Scene::of_grasp(&hand, &skin, &object, &x, &grasp.contacts);
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
