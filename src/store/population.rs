//! The grasps of one hand on one object.

use super::grasps::{GraspFile, GraspRow};
use super::metadata::{HandMetadata, Metadata, ObjectMetadata, Source};

/// The grasps of one landscape: one hand, one object, one scale.
#[derive(Debug, Clone, PartialEq)]
pub struct Population<'a> {
    pub(super) metadata: &'a Metadata,
    /// The hand.
    pub hand: &'a HandMetadata,
    /// The object.
    pub object: &'a ObjectMetadata,
    /// The scale.
    pub scale: f64,
    /// The grasps, in file order.
    pub grasps: Vec<&'a GraspRow>,
}

impl Population<'_> {
    /// A file of these grasps alone, made by `command` from `inputs`.
    pub fn to_file(&self, command: &str, inputs: Vec<Source>) -> GraspFile {
        let mut metadata = self.metadata.clone();
        metadata.hands = vec![self.hand.clone()];
        metadata.objects = vec![self.object.clone()];
        metadata.remade_by(command, inputs);
        GraspFile {
            metadata,
            grasps: self.grasps.iter().map(|row| (*row).clone()).collect(),
        }
    }
}
