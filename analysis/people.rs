//! Grasps of everyday objects that people posed and named: the folder `ycb_affordance` of the test data.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use landscape::hand::{Hand, HandFiles};
use landscape::object::Object;
use serde::Deserialize;

use crate::Failure;

#[derive(Deserialize)]
struct File {
    mano_joints: Vec<String>,
    grasps: Vec<Annotated>,
}

#[derive(Deserialize)]
struct Annotated {
    object: String,
    label: u8,
    mano: Pose,
    label_agrees_with_contact: bool,
}

#[derive(Deserialize)]
struct Pose {
    t: [f64; 3],
    q_wxyz: [f64; 4],
    joints: Vec<f64>,
}

/// A grasp that a person posed.
pub(crate) struct Posed {
    /// Number of the type that the person gave it.
    pub(crate) label: u8,
    /// Whether the digits and the palm that touch are those of this type.
    pub(crate) agrees: bool,
    /// The pose of the hand, object frame.
    pub(crate) x: Vec<f64>,
}

/// All these grasps, by object.
pub(crate) struct People {
    /// The MANO-like hand with which people posed.
    pub(crate) hand: Hand,
    pub(crate) grasps: BTreeMap<String, Vec<Posed>>,
    folder: PathBuf,
}

impl People {
    /// Reads them from the folder that `LANDSCAPE_TEST_DATA` names.
    pub(crate) fn read() -> Result<Self, Failure> {
        let data = std::env::var_os("LANDSCAPE_TEST_DATA");
        let folder = Path::new(&data.ok_or("set LANDSCAPE_TEST_DATA")?).join("ycb_affordance");
        let text = std::fs::read_to_string(folder.join("grasps.json"))?;
        let file: File = serde_json::from_str(&text)?;
        let hand = Hand::from_files(&HandFiles::load(&folder.join("hand/mano_ycba.xml"))?)?;
        let places = hand.joints.iter().map(|joint| {
            let place = file.mano_joints.iter().position(|name| *name == joint.name);
            place.ok_or_else(|| format!("no angle of {}", joint.name))
        });
        let places: Vec<usize> = places.collect::<Result<_, _>>()?;
        let mut grasps: BTreeMap<String, Vec<Posed>> = BTreeMap::new();
        for grasp in file.grasps {
            let pose = grasp.mano;
            let joints = places.iter().map(|&place| pose.joints[place]);
            let own = grasps.entry(grasp.object).or_default();
            own.push(Posed {
                label: grasp.label,
                agrees: grasp.label_agrees_with_contact,
                x: (pose.t.into_iter().chain(pose.q_wxyz).chain(joints)).collect(),
            });
        }
        Ok(Self {
            hand,
            grasps,
            folder,
        })
    }

    /// The object of this name.
    pub(crate) fn object(&self, name: &str) -> Result<Object, Failure> {
        let file = |ending| self.folder.join(format!("objects/{name}.{ending}"));
        let mut files = ["obj", "stl"].map(file).into_iter();
        let mesh = files.find(|path| path.exists());
        Ok(Object::load(
            mesh.ok_or_else(|| format!("no mesh of {name}"))?,
        )?)
    }
}
