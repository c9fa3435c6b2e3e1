//! Mirror images of hands, for example a left hand from a right one.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::solid::Parts;
use super::{Frame, Hand, JointKind};

/// Suffix of the name of a mirrored hand.
const MIRRORED: &str = "_mirrored";

/// The reflection x ↦ −x of the root frame; the frames of all links are reflected in the same way.
pub(super) fn reflected(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(-v.x, v.y, v.z)
}

fn reflected_frame(frame: &Frame) -> Frame {
    let m = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0));
    Frame {
        rotation: m * frame.rotation * m,
        translation: reflected(&frame.translation),
    }
}

impl Hand {
    /// The mirror image at the plane x = 0 of the root frame, with the same joints and limits: at the same coordinates
    /// every link, point and capsule is the mirror image of the original's.
    ///
    /// With M = diag(−1, 1, 1), frames become M F M, points M p, directions of slides M a and axes of hinges −M a, since a
    /// rotation changes its sense in a mirror. Angles of ball joints about y and z change their sign.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let mut hand = self.clone();
        hand.name = match self.name.strip_suffix(MIRRORED) {
            Some(name) => name.to_owned(),
            None => format!("{}{MIRRORED}", self.name),
        };
        for link in &mut hand.links {
            link.parent_from_link = reflected_frame(&link.parent_from_link);
            if let Some(motion) = &mut link.motion {
                let axis = reflected(&motion.axis);
                motion.axis = match motion.kind {
                    JointKind::Hinge => -axis,
                    JointKind::Slide => axis,
                };
            }
        }
        for capsule in &mut hand.capsules {
            (capsule.a, capsule.b) = (reflected(&capsule.a), reflected(&capsule.b));
        }
        for point in &mut hand.surface {
            (point.point, point.normal) = (reflected(&point.point), reflected(&point.normal));
        }
        for mesh in &mut hand.meshes {
            for vertex in &mut mesh.vertices {
                *vertex = reflected(vertex);
            }
            for triangle in &mut mesh.triangles {
                triangle.swap(1, 2);
            }
        }
        hand.virtual_wrist = None;
        hand.parts = Parts::default();
        hand.inscribed = super::inscribed::Cache::default();
        hand.blend = self.blend.as_ref().map(|blend| Arc::new(blend.mirrored()));
        let palm = &mut hand.palm;
        palm.centre = reflected(&palm.centre);
        palm.volar = reflected(&palm.volar);
        palm.distal = reflected(&palm.distal);
        hand
    }
}
