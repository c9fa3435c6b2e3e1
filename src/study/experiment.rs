//! Experiment files: the settings of energy and synthesis as TOML.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::formats::toml_text;
use crate::grasp::EnergySettings;
use crate::grasp::energy::EnergySettingsError;
use crate::grasp::synthesis::{SynthesisSettings, SynthesisSettingsError};

/// What an experiment file holds; every section and key may be left out.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Experiment {
    /// Section `[energy]`.
    pub energy: EnergySettings,
    /// Section `[synthesis]`.
    pub synthesis: SynthesisSettings,
}

const PRESETS: [(&str, &str); 4] = [
    (
        "default",
        include_str!("../../data/experiments/default.toml"),
    ),
    ("closed", include_str!("../../data/experiments/closed.toml")),
    ("paper", include_str!("../../data/experiments/paper.toml")),
    (
        "released",
        include_str!("../../data/experiments/released.toml"),
    ),
];

/// Why there is no such experiment.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// No preset has this name.
    #[error("--preset {0}: there is no such preset; the presets are {list}", list = PRESETS.map(|(known, _)| known).join(", "))]
    Preset(String),
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
    /// The preset of this name: `default`, `closed`, `paper` or `released`.
    ///
    /// # Errors
    /// If there is none of that name.
    ///
    /// # Panics
    /// Never: the presets are constants that the tests read.
    pub fn preset(name: &str) -> Result<Self, ExperimentError> {
        let preset = PRESETS.iter().find(|(known, _)| *known == name);
        let (_, text) = preset.ok_or_else(|| ExperimentError::Preset(name.to_owned()))?;
        Ok(toml::from_str(text).expect("the tests read the presets"))
    }

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
        let experiment: Self = toml_text::parse(&text).map_err(|source| {
            let path = owned();
            ExperimentError::Toml { path, source }
        })?;
        (experiment.energy.validate())
            .and_then(|()| experiment.energy.ask_for_contacts())
            .map_err(|source| {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_the_library_defaults() {
        assert_eq!(
            Experiment::preset("default").unwrap(),
            Experiment::default()
        );
        let closed = Experiment {
            energy: EnergySettings::closed(),
            synthesis: SynthesisSettings::closed(),
        };
        assert_eq!(Experiment::preset("closed").unwrap(), closed);
        let paper = Experiment {
            energy: EnergySettings::paper(),
            synthesis: SynthesisSettings::paper(),
        };
        assert_eq!(Experiment::preset("paper").unwrap(), paper);
        let released = Experiment {
            energy: EnergySettings::released(),
            synthesis: SynthesisSettings::released(),
        };
        assert_eq!(Experiment::preset("released").unwrap(), released);
    }

    #[test]
    fn unknown_keys_are_refused() {
        assert!(toml::from_str::<Experiment>("[energy]\nprior_wieght = 1.0").is_err());
    }
}
