//! Hands and grasps as models of other simulators: URDF ([`hand_urdf`]) and scenes of `MuJoCo` ([`MujocoScene`]).
//!
//! Both are sets of files: a description, and the meshes that it refers to beside it. The kinematics are those of
//! [`Hand`]: `tree` turns its links into joints whose coordinate zero is that of the description.

mod mujoco;
mod roadmap;
mod text;
mod tree;
mod urdf;

pub use mujoco::MujocoScene;
pub use roadmap::roadmap;
pub use urdf::hand_urdf;

use crate::evaluation::stability::{
    Build, Closing, ClosingRule, LoadTest, Protocol, Solid, joint_targets,
};
use crate::grasp::Grasp;
use crate::grasp::closing::opened;
use crate::hand::Hand;
use crate::mesh::{ExactMesh, Mesh};
use crate::store::Metadata;

/// One file of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportedFile {
    /// Its name, without folder.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Reason why a hand cannot be described to another simulator.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The hand is one of MANO.
    #[error(
        "hand `{0}` has a skin that bends, and its coordinates are not joints: this format supports only rigid links"
    )]
    Bends(String),
}

/// Refuses hands whose coordinates are not joints of rigid links.
///
/// # Errors
/// If the skin of the hand bends.
pub fn check_rigid(hand: &Hand) -> Result<(), ExportError> {
    if hand.bends() {
        return Err(ExportError::Bends(hand.name.clone()));
    }
    Ok(())
}

/// Joint coordinates before, during and after closing, for controllers.
#[derive(Debug, Clone, PartialEq)]
pub struct Approach {
    /// The contacts are about [`OPENED_M`] away from the object.
    pub before: Vec<f64>,
    /// Targets of joint springs that press as the test of [`squeezing_test`] does.
    pub squeezed: Vec<f64>,
}

/// The test with loads by which the grasps of a file were simulated, if the hand closed in it; otherwise the standard one.
pub fn squeezing_test(metadata: &Metadata) -> LoadTest {
    let protocol = metadata.stability["protocol"].clone();
    match serde_json::from_value(protocol) {
        Ok(Protocol::Loads(test)) if test.closing.rule != ClosingRule::None => test,
        _ => LoadTest::default(),
    }
}

/// A test as one with loads. `drop` has none: its hand does not close and has the springs of the standard test, and the mass
/// is that of the object.
fn closing_test(protocol: &Protocol) -> LoadTest {
    match protocol {
        Protocol::Loads(test) => test.clone(),
        Protocol::Drop(drop) => {
            let usual = LoadTest::default();
            LoadTest {
                protocol: "drop".to_owned(),
                mass_kg: None,
                friction: drop.friction,
                solver: drop.solver,
                closing: Closing {
                    rule: ClosingRule::None,
                    ..usual.closing
                },
                ..usual
            }
        }
    }
}

/// Distance of the contacts from the object before the hand closes, metres: the first stage of the published pipelines.
pub const OPENED_M: f64 = 0.01;

/// Coordinates from which the hand closes and to which it presses, for each of some grasps on one object.
pub fn approaches(hand: &Hand, mesh: &Mesh, grasps: &[&Grasp], test: &LoadTest) -> Vec<Approach> {
    let exact = ExactMesh::new(mesh);
    // Only the surface and the centre of mass are needed, so the object is not cut into pieces.
    let solid = Solid::new(mesh, Build::Triangles);
    let approach = |grasp: &&Grasp| Approach {
        before: opened(hand, &exact, grasp, OPENED_M),
        squeezed: joint_targets(hand, grasp, None, &solid, test),
    };
    grasps.iter().map(approach).collect()
}
