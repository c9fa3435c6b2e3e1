//! Scenes of a hand on an object.

use crate::grasp::Grasp;
use crate::hand::{Hand, PosedHand, Skin};
use crate::mesh::Mesh;
use crate::object::Object;

use super::{Marker, Scene, Surface};

const SKIN: [u8; 3] = [232, 190, 162];
const OBJECT: [u8; 3] = [128, 164, 190];
const CONTACT: [u8; 3] = [213, 40, 20];
const CONTACT_RADIUS_M: f64 = 0.005;

impl Surface {
    /// The skin of a posed hand.
    ///
    /// # Panics
    /// If `skin` belongs to another hand.
    pub fn of_hand(skin: &Skin, posed: &PosedHand) -> Self {
        Self {
            vertices: skin.pose(posed),
            triangles: skin.triangles.clone(),
            colour: SKIN,
        }
    }

    /// The mesh of an object.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        Self {
            vertices: mesh.vertices().to_vec(),
            triangles: mesh.triangles().to_vec(),
            colour: OBJECT,
        }
    }
}

impl Scene {
    /// A grasp of `hand` on `object`, a marker at each contact.
    ///
    /// # Panics
    /// If skin or grasp is that of another hand.
    pub fn of_grasp(hand: &Hand, skin: &Skin, object: &Object, grasp: &Grasp) -> Self {
        Self::of_grasp_on(hand, skin, &object.mesh, grasp)
    }

    /// [`Scene::of_grasp`] on the bare mesh of an object.
    ///
    /// # Panics
    /// If skin or grasp is that of another hand.
    pub fn of_grasp_on(hand: &Hand, skin: &Skin, mesh: &Mesh, grasp: &Grasp) -> Self {
        let mut posed = PosedHand::default();
        hand.pose(&grasp.pose, &mut posed);
        let marker = |&contact: &u32| Marker {
            centre: posed.points[contact as usize],
            radius_m: CONTACT_RADIUS_M,
            colour: CONTACT,
        };
        Self {
            surfaces: vec![Surface::of_hand(skin, &posed), Surface::of_mesh(mesh)],
            markers: grasp.contacts.iter().map(marker).collect(),
            cones: Vec::new(),
        }
    }
}
