//! Grasps of everyday objects that people posed and named: folder `ycb_affordance` of the test data.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use landscape::evaluation::taxonomy::{Labeller, Rule, Taxonomy};
use landscape::hand::{Hand, HandFiles};
use landscape::object::Object;
use rayon::prelude::*;
use serde::Deserialize;

use crate::Failure;
use crate::case::Case;
use crate::contact::{Contact, NEAR_MM, PARTS, agrees};

/// The objects whose grasps nobody looked at before the rule was final: the third of the 29 objects with the smallest 64-bit
/// FNV-1a hash of "25 NAME". Number 25 is the seed. Chosen on 24 November 2026 before any of their
/// labels, pictures or results was opened.
pub(crate) const UNSEEN: [&str; 10] = [
    "010_potted_meat_can",
    "011_banana",
    "014_lemon",
    "025_mug",
    "031_spoon",
    "035_power_drill",
    "036_wood_block",
    "037_scissors",
    "053_mini_soccer_ball",
    "058_golf_ball",
];
const SEED: &str = "25";

#[derive(Deserialize)]
struct File {
    mano_joints: Vec<String>,
    grasps: Vec<Annotated>,
}

#[derive(Deserialize)]
struct Annotated {
    id: u64,
    object: String,
    label: u8,
    mano: Posed,
    gap_mm: BTreeMap<String, f64>,
    touching: BTreeSet<usize>,
    label_agrees_with_contact: bool,
}

impl Annotated {
    fn contact(&self) -> Contact {
        let least = |part: &str| {
            let own = self
                .gap_mm
                .iter()
                .filter(|(name, _)| name.starts_with(part));
            own.map(|(_, gap)| *gap).fold(f64::INFINITY, f64::min)
        };
        Contact {
            parts_mm: PARTS.map(least),
            bones_mm: self.gap_mm.values().copied().collect(),
        }
    }
}

#[derive(Deserialize)]
struct Posed {
    t: [f64; 3],
    q_wxyz: [f64; 4],
    joints: Vec<f64>,
}

/// The third of these objects that is not looked at: see [`UNSEEN`].
pub(crate) fn third_not_looked_at(objects: &[String]) -> Vec<String> {
    let hash = |name: &str| {
        let bytes = SEED.bytes().chain(*b" ").chain(name.bytes());
        bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        })
    };
    let mut order = objects.to_vec();
    order.sort_by_key(|name| hash(name));
    order.truncate(objects.len().div_ceil(3));
    order.sort();
    order
}

/// Labels of the grasps of a folder: those of the objects that `wanted` chooses.
pub(crate) fn cases(
    folder: &Path,
    rule: &Rule,
    wanted: impl Fn(&str) -> bool + Sync,
) -> Result<Vec<Case>, Failure> {
    let file: File = serde_json::from_str(&std::fs::read_to_string(folder.join("grasps.json"))?)?;
    let hand = hand_of(folder)?;
    let places = hand.joints.iter().map(|joint| {
        let mut order = file.mano_joints.iter();
        let place = order.position(|name| *name == joint.name);
        place.ok_or_else(|| format!("no angle of {}", joint.name))
    });
    let places: Vec<usize> = places.collect::<Result<_, _>>()?;
    let mut of_object: BTreeMap<&str, Vec<&Annotated>> = BTreeMap::new();
    for grasp in &file.grasps {
        of_object.entry(&grasp.object).or_default().push(grasp);
    }
    let names: Vec<String> = of_object.keys().map(ToString::to_string).collect();
    if third_not_looked_at(&names) != UNSEEN {
        return Err("these are not the objects among which the third was chosen".into());
    }
    of_object.retain(|object, _| wanted(object));
    let of_one = |(name, grasps): (&&str, &Vec<&Annotated>)| -> Result<Vec<Case>, Failure> {
        let object = Object::load(mesh_of(folder, name)?)?;
        let labeller = Labeller::new(&hand, &object, rule);
        let case = |grasp: &&Annotated| {
            let posed = &grasp.mano;
            let mut x = posed.t.to_vec();
            x.extend(posed.q_wxyz);
            x.extend(places.iter().map(|&place| posed.joints[place]));
            let truth = Taxonomy::feix().numbered(grasp.label);
            let truth = truth.ok_or_else(|| format!("no type {}", grasp.label))?;
            let contact = grasp.contact();
            let touching = contact.touching(NEAR_MM);
            let agrees = agrees(truth, &touching);
            if touching != grasp.touching || agrees != grasp.label_agrees_with_contact {
                return Err(format!("grasp {}: contact is not as the data say", grasp.id).into());
            }
            Ok(Case {
                id: grasp.id.to_string(),
                object: grasp.object.clone(),
                truth,
                contact,
                agrees,
                label: labeller.label(&x),
                x,
            })
        };
        grasps.iter().map(case).collect()
    };
    let all: Vec<Vec<Case>> = of_object.par_iter().map(of_one).collect::<Result<_, _>>()?;
    Ok(all.into_iter().flatten().collect())
}

/// The MANO-like hand of the annotators, with which they posed.
pub(crate) fn hand_of(folder: &Path) -> Result<Hand, Failure> {
    let files = HandFiles::load(&folder.join("hand/mano_ycba.xml"))?;
    Ok(Hand::from_files(&files)?)
}

pub(crate) fn mesh_of(folder: &Path, object: &str) -> Result<std::path::PathBuf, Failure> {
    let files = ["obj", "stl"].map(|ending| folder.join(format!("objects/{object}.{ending}")));
    let found = files.into_iter().find(|path| path.exists());
    found.ok_or_else(|| format!("no mesh of {object}").into())
}
