//! How people use the hand: the grasps of the folder `ycb_affordance` of the test data.

use std::collections::BTreeMap;
use std::path::Path;

use landscape::evaluation::HandUse;
use landscape::evaluation::taxonomy::Anatomy;
use landscape::hand::{Hand, HandFiles};
use landscape::object::Object;
use rayon::prelude::*;
use serde::Deserialize;

use crate::{Failure, Uses};

#[derive(Deserialize)]
struct File {
    mano_joints: Vec<String>,
    grasps: Vec<Posed>,
}

#[derive(Deserialize)]
struct Posed {
    object: String,
    mano: Pose,
}

#[derive(Deserialize)]
struct Pose {
    t: [f64; 3],
    q_wxyz: [f64; 4],
    joints: Vec<f64>,
}

/// The use of the hand in all grasps that people posed, by object. Their labels are not read.
pub(crate) fn uses(folder: &Path) -> Result<Uses, Failure> {
    let file: File = serde_json::from_str(&std::fs::read_to_string(folder.join("grasps.json"))?)?;
    let hand = Hand::from_files(&HandFiles::load(&folder.join("hand/mano_ycba.xml"))?)?;
    let anatomy = Anatomy::of(&hand)?;
    let places = hand.joints.iter().map(|joint| {
        let place = file.mano_joints.iter().position(|name| *name == joint.name);
        place.ok_or_else(|| format!("no angle of {}", joint.name))
    });
    let places: Vec<usize> = places.collect::<Result<_, _>>()?;
    let mut of_object: BTreeMap<&String, Vec<&Pose>> = BTreeMap::new();
    for grasp in &file.grasps {
        of_object
            .entry(&grasp.object)
            .or_default()
            .push(&grasp.mano);
    }
    let one = |(name, poses): (&&String, &Vec<&Pose>)| -> Result<_, Failure> {
        let files = ["obj", "stl"].map(|ending| folder.join(format!("objects/{name}.{ending}")));
        let mesh = files.into_iter().find(|path| path.exists());
        let object = Object::load(mesh.ok_or_else(|| format!("no mesh of {name}"))?)?;
        let uses = poses.iter().filter_map(|pose| {
            let mut x = pose.t.to_vec();
            x.extend(pose.q_wxyz);
            x.extend(places.iter().map(|&place| pose.joints[place]));
            HandUse::of(&hand, &anatomy, &object, &x)
        });
        Ok(((*name).clone(), uses.collect()))
    };
    of_object.par_iter().map(one).collect()
}
