//! Experiment files: the settings of energy and synthesis as TOML.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::configuration;
use crate::grasp::EnergySettings;
use crate::grasp::energy::EnergySettingsError;
use crate::grasp::synthesis::{SynthesisSettings, SynthesisSettingsError};

/// The settings of an experiment. An experiment file sets keys that `landscape config synth` prints and may leave out any.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Experiment {
    /// Section `[energy]`.
    pub energy: EnergySettings,
    /// Section `[synthesis]`.
    pub synthesis: SynthesisSettings,
}

/// Why there is no such experiment.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is not an experiment.
    #[error("{} is not an experiment", path.display())]
    Toml {
        /// The file.
        path: PathBuf,
        /// Why.
        source: toml::de::Error,
    },
    /// A setting of the energy is out of its range.
    #[error("{}, section [energy]", path.display())]
    Energy {
        /// The file.
        path: PathBuf,
        /// Which, and why.
        source: EnergySettingsError,
    },
    /// A setting of the synthesis is out of its range.
    #[error("{}, section [synthesis]", path.display())]
    Synthesis {
        /// The file.
        path: PathBuf,
        /// Which, and why.
        source: SynthesisSettingsError,
    },
}

impl Experiment {
    /// Reads an experiment file.
    ///
    /// # Errors
    /// If the file cannot be read, is not an experiment, or a setting is out of its range.
    pub fn read(path: &Path) -> Result<Self, ExperimentError> {
        let owned = || path.to_path_buf();
        let text = std::fs::read_to_string(path).map_err(|source| {
            let path = owned();
            ExperimentError::Read { path, source }
        })?;
        let experiment: Self =
            configuration::parse(configuration::SYNTH, &text).map_err(|source| {
                let path = owned();
                ExperimentError::Toml { path, source }
            })?;
        experiment.energy.validate().map_err(|source| {
            let path = owned();
            ExperimentError::Energy { path, source }
        })?;
        experiment.synthesis.validate().map_err(|source| {
            let path = owned();
            ExperimentError::Synthesis { path, source }
        })?;
        Ok(experiment)
    }
}

/// Replaces the values of `table` by those that `given` has; tables within tables are overlaid, too.
pub(super) fn overlay(table: &mut toml::Table, given: toml::Table) {
    for (key, value) in given {
        match (table.get_mut(&key), value) {
            (Some(toml::Value::Table(under)), toml::Value::Table(over)) => overlay(under, over),
            (_, value) => {
                table.insert(key, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Experiment, ExperimentError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, text).unwrap();
        Experiment::read(&path)
    }

    /// What a file leaves out is that of the default; a layer may be changed in part.
    #[test]
    fn a_file_changes_the_default() {
        let found = read("[energy.layer]\nfriction = 0.3\n").unwrap();
        let mut expected = Experiment::default();
        expected.energy.layer.friction = 0.3;
        assert_eq!(found, expected);
        let found = read("[synthesis]\nsteps = 3\n[synthesis.grips]\npinch = 1.0\n").unwrap();
        let mut expected = Experiment::default();
        expected.synthesis.steps = 3;
        expected.synthesis.grips.pinch = 1.0;
        assert_eq!(found, expected);
        assert!(read("[energy]\nfrictoin = 1.0\n").is_err());
        assert!(read("preset = \"paper\"\n").is_err());
    }

    #[test]
    fn the_example_is_the_default() {
        let text = include_str!("../../data/experiments/closed.toml");
        assert_eq!(read(text).unwrap(), Experiment::default());
    }
}
