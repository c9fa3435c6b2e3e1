//! Alignment of the normals of hand and object at the contacts.

use nalgebra::Vector3;

use super::force_closure::push;
use super::{Forces, Scene, Stage, Term, point_contact};

/// Mean alignment of the hand's outward normals nᵢ with the object's inward normals cᵢ at the contacts.
///
/// ```text
/// E = −w/n Σᵢ nᵢ · cᵢ,   cᵢ = −∇d/‖∇d‖ at pᵢ
/// ```
///
/// The energy lies between −w (palm to surface) and w. The term is not in the text of Liu et al. (2021), but in their code.
/// The hand's normals turn with their links, and the object's normals vary along its surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alignment {
    /// Weight w.
    pub weight: f64,
}

impl Alignment {
    /// Cost of one of `contacts` contacts relative to the minimum, w (1 − n·c)/n ≥ 0.
    pub fn cost(
        &self,
        hand_normal: &Vector3<f64>,
        inward_normal: &Vector3<f64>,
        contacts: usize,
    ) -> f64 {
        self.weight * (1.0 - hand_normal.dot(inward_normal)) / contacts as f64
    }
}

impl Term for Alignment {
    fn name(&self) -> &'static str {
        "alignment"
    }

    fn weight(&self) -> f64 {
        self.weight
    }

    fn stage(&self) -> Stage {
        Stage::Contacts
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let scale = -self.weight / scene.contacts.len().max(1) as f64;
        let mut energy = 0.0;
        for contact in scene.contacts {
            let inward = point_contact(contact, &scene.object.centroid, scene.unit_m).inward_normal;
            let outward = scene.hand.point_normal(scene.posed, contact.index as usize);
            energy += scale * outward.dot(&inward);
            push(
                contact,
                scene.unit_m,
                &(outward * scale),
                &Vector3::zeros(),
                forces,
            );
            // A rotation of the link by δω changes n by δω × n, and n·c by δω·(n × c).
            forces.turn_surface(
                contact.index,
                contact.link,
                &(outward.cross(&inward) * scale),
            );
        }
        energy
    }
}
