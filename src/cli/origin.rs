//! Input of `landscape synth`: hand and object of the flags, or those of the given grasps.

use std::sync::Arc;

use anyhow::Context;

use super::input;
use super::synth::Synth;
use crate::object::Object;
use crate::store::{GraspRow, HandMetadata, ObjectMetadata};

/// Hand, object and, with `--from`, the grasps to start from.
pub(super) struct Origin {
    pub(super) hand: HandMetadata,
    pub(super) object: Arc<Object>,
    pub(super) object_metadata: ObjectMetadata,
    /// Scale of the object relative to its metadata.
    pub(super) scale: f64,
    /// Grasps to start from; empty without `--from`.
    pub(super) given: Vec<GraspRow>,
}

impl Origin {
    pub(super) fn read(command: &Synth, quiet: bool) -> anyhow::Result<Self> {
        if command.from.is_some() {
            return Self::of_file(command, quiet);
        }
        let object = command.object.as_deref();
        let object = object.context("--object: the object to be grasped must be named")?;
        let (mut object_metadata, mut notes) = input::object(object, command.scale)?;
        input::rename(&mut object_metadata, command.name.as_deref())?;
        let scale = command.scale.unwrap_or(1.0);
        // Uses the stored mesh, so that runs from a flag and from a file agree bit for bit.
        let object = object_metadata.build(scale)?;
        notes.extend(object.notes.iter().cloned());
        if !quiet {
            input::warn(&notes);
        }
        Ok(Self {
            hand: input::hand(
                command.hand.as_deref().unwrap_or("human"),
                command.hand_folder.as_deref(),
                command.mirror,
            )?,
            object,
            object_metadata,
            scale,
            given: Vec::new(),
        })
    }

    fn of_file(command: &Synth, quiet: bool) -> anyhow::Result<Self> {
        let path = command
            .from
            .as_deref()
            .context("--from: a file is needed")?;
        let (file, warnings) =
            input::read(path, command.hand.as_deref(), command.object.as_deref())?;
        if !quiet {
            input::warn(&warnings);
        }
        let populations = file.landscapes();
        let [population] = populations.as_slice() else {
            anyhow::bail!(
                "--from {}: holds grasps of {} pairs of hand and object; chains start from one at a time",
                path.display(),
                populations.len()
            );
        };
        population
            .hand()
            .with_context(|| path.display().to_string())?;
        Ok(Self {
            hand: population.hand.clone(),
            object: population.object()?,
            object_metadata: population.object.clone(),
            scale: population.scale,
            given: population.grasps.iter().copied().cloned().collect(),
        })
    }

    /// The grasp from which chain number `chain` starts.
    pub(super) fn given(&self, chain: u64) -> Option<&GraspRow> {
        let count = u64::try_from(self.given.len())
            .ok()
            .filter(|count| *count > 0)?;
        self.given.get(usize::try_from(chain % count).ok()?)
    }
}
