//! Published hands and `MuJoCo`'s results for them. They are not part of the project.

use std::fs;
use std::path::{Path, PathBuf};

use landscape::hand::{Hand, PosedHand};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use serde_json::Value;

/// The folder of the published hands, if `LANDSCAPE_TEST_DATA` names one.
pub(crate) fn folder() -> Option<PathBuf> {
    Some(Path::new(&std::env::var_os("LANDSCAPE_TEST_DATA")?).join("hands"))
}

/// All hands with a reference: the description and `MuJoCo`'s results.
pub(crate) const REFERENCES: [[&str; 2]; 8] = [
    [
        "shadow_dexgraspnet/shadow_hand_vis.xml",
        "shadow_dexgraspnet/fk_reference_vis.json",
    ],
    [
        "shadow_dexgraspnet/shadow_hand_wrist_free.xml",
        "shadow_dexgraspnet/fk_reference_wrist_free.json",
    ],
    [
        "shadow_dexonomy/shadow_right.xml",
        "shadow_dexonomy/fk_reference.json",
    ],
    [
        "shadow_dexonomy/shadow_right_primitives.xml",
        "shadow_dexonomy/fk_reference_primitives.json",
    ],
    ["mano/mano_right.xml", "mano/fk_reference.json"],
    [
        "allegro/allegro_right_nomesh.xml",
        "allegro/fk_reference.json",
    ],
    [
        "urdf/allegro_hand_right_nomesh.urdf",
        "urdf/fk_reference_allegro_urdf.json",
    ],
    [
        "urdf/shadow_hand_right_nomesh.urdf",
        "urdf/fk_reference_shadow_urdf.json",
    ],
];

/// Hands as URDF with the meshes of their collision shapes, and the names of `MuJoCo`'s results in `tests/published`.
pub(crate) const DEX_URDF: [[&str; 2]; 5] = [
    [
        "dex_urdf/allegro_hand/allegro_hand_right.urdf",
        "allegro_hand",
    ],
    ["dex_urdf/barrett_hand/bhand_model.urdf", "barrett_hand"],
    ["dex_urdf/dclaw_gripper/dclaw_gripper.urdf", "dclaw_gripper"],
    [
        "dex_urdf/inspire_hand/inspire_hand_right.urdf",
        "inspire_hand",
    ],
    ["dex_urdf/shadow_hand/shadow_hand_right.urdf", "shadow_hand"],
];

/// The reference of a hand of [`DEX_URDF`], which `analysis/published_hands/reference.py` makes.
pub(crate) fn of_dex_urdf(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/published/dex_urdf");
    folder.join(format!("{name}.json"))
}

/// A reference file.
pub(crate) fn reference(path: &Path) -> Value {
    let text = fs::read_to_string(path).expect("a reference lies beside each hand");
    serde_json::from_str(&text).expect("references are JSON")
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    let numbers = value.as_array().into_iter().flatten();
    numbers.filter_map(Value::as_f64).collect()
}

/// Largest differences of link frames from those of a reference.
#[derive(Debug, Default)]
pub(crate) struct Difference {
    /// Number of compared frames.
    pub(crate) frames: usize,
    /// Largest distance of origins, metres.
    pub(crate) metres: f64,
    /// Largest rotation, radians.
    pub(crate) radians: f64,
}

impl Difference {
    /// Maximum over all bodies and configurations; infinite if the hand lacks bodies of the reference.
    pub(crate) fn of(hand: &Hand, reference: &Value) -> Self {
        let mut worst = Self::default();
        let mut posed = PosedHand::default();
        let order = reference["joint_order"].as_array().into_iter().flatten();
        let order: Vec<Option<usize>> = order.map(|name| hand.joint(name.as_str()?)).collect();
        for configuration in reference["configurations"].as_array().into_iter().flatten() {
            let mut x = hand.rest_coordinates();
            for (joint, angle) in order.iter().zip(numbers(&configuration["qpos"])) {
                match joint {
                    Some(joint) => x[7 + joint] = angle,
                    None => worst.radians = f64::INFINITY,
                }
            }
            hand.pose(&x, &mut posed);
            for (name, body) in configuration["bodies"].as_object().into_iter().flatten() {
                let Some(link) = hand.link(name) else {
                    if name != "world" {
                        worst.metres = f64::INFINITY;
                    }
                    continue;
                };
                let frame = &posed.object_from_link[link.0];
                let position = Vector3::from_row_slice(&numbers(&body["pos"]));
                worst.metres = worst.metres.max((frame.translation - position).norm());
                // For small turns the difference of the matrices is the angle, √2 times as large as its norm says.
                let difference = frame.rotation - rotation(&numbers(&body["quat_wxyz"]));
                worst.radians = worst.radians.max(difference.norm() / 2f64.sqrt());
                worst.frames += 1;
            }
        }
        worst
    }
}

fn rotation(wxyz: &[f64]) -> Matrix3<f64> {
    let rotation = Quaternion::new(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    *UnitQuaternion::from_quaternion(rotation)
        .to_rotation_matrix()
        .matrix()
}
