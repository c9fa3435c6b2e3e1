//! Experiment files: the settings of energy and synthesis as TOML.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::formats::toml_text;
use crate::grasp::EnergySettings;
use crate::grasp::energy::EnergySettingsError;
use crate::grasp::synthesis::{SynthesisSettings, SynthesisSettingsError};

/// The settings of an experiment. In an experiment file every section and key may be left out: it has the value of the preset
/// that the key `preset` names, or else of `closed`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Section `[energy]`.
    pub energy: EnergySettings,
    /// Section `[synthesis]`.
    pub synthesis: SynthesisSettings,
}

/// The keys of an experiment file and their types, so that errors name lines.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ExperimentFile {
    #[serde(default)]
    preset: Option<String>,
    #[serde(default, rename = "energy")]
    _energy: Option<EnergySettings>,
    #[serde(default, rename = "synthesis")]
    _synthesis: Option<SynthesisSettings>,
}

/// The name of the preset that holds unless another is named.
pub const DEFAULT_PRESET: &str = "closed";

const PRESETS: [(&str, &str); 4] = [
    ("closed", include_str!("../../data/experiments/closed.toml")),
    (
        "four_points",
        include_str!("../../data/experiments/four_points.toml"),
    ),
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
    #[error("preset {0} does not exist; the presets are {list}", list = PRESETS.map(|(known, _)| known).join(", "))]
    Preset(String),
    /// A file changes a preset that does not exist.
    #[error("{}, key preset", path.display())]
    FilePreset {
        /// The file.
        path: PathBuf,
        /// Which presets there are.
        source: Box<Self>,
    },
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
    /// The preset of this name: `closed`, `four_points`, `paper` or `released`.
    ///
    /// # Errors
    /// If there is none of that name.
    ///
    /// # Panics
    /// Never: the presets are constants that the tests read.
    pub fn preset(name: &str) -> Result<Self, ExperimentError> {
        let text = preset_text(name)?;
        Ok(toml::from_str(text).expect("the tests read the presets"))
    }

    /// The preset whose energy has these terms, and its name. No two presets have the same.
    pub fn of_terms(terms: &[String]) -> Option<(&'static str, Self)> {
        let terms: BTreeSet<&String> = terms.iter().collect();
        PRESETS.iter().find_map(|(name, _)| {
            let preset = Self::preset(name).ok()?;
            (preset.energy.term_names().iter().collect::<BTreeSet<_>>() == terms)
                .then_some((*name, preset))
        })
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
        let refused = |source| {
            let path = owned();
            ExperimentError::Toml { path, source }
        };
        let file: ExperimentFile = toml_text::parse(&text).map_err(refused)?;
        let preset = file.preset.as_deref().unwrap_or(DEFAULT_PRESET);
        let preset = preset_text(preset).map_err(|source| ExperimentError::FilePreset {
            path: owned(),
            source: Box::new(source),
        })?;
        let mut table: toml::Table = toml::from_str(preset).map_err(refused)?;
        let mut given: toml::Table = toml::from_str(&text).map_err(refused)?;
        given.remove("preset");
        overlay(&mut table, given);
        let experiment: Self = table.try_into().map_err(refused)?;
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

fn preset_text(name: &str) -> Result<&'static str, ExperimentError> {
    let preset = PRESETS.iter().find(|(known, _)| *known == name);
    let (_, text) = preset.ok_or_else(|| ExperimentError::Preset(name.to_owned()))?;
    Ok(text)
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

    /// What a file leaves out is that of its preset, or of the default preset; a layer may be changed in part.
    #[test]
    fn a_file_changes_a_preset() {
        let found = read("[energy.layer]\nfriction = 0.3\n").unwrap();
        let mut expected = Experiment::default();
        expected.energy.layer.as_mut().unwrap().friction = 0.3;
        assert_eq!(found, expected);

        let found = read("preset = \"four_points\"\n[energy]\ncontacts = 3\n").unwrap();
        let mut expected = Experiment::preset("four_points").unwrap();
        expected.energy.contacts = 3;
        assert_eq!(found, expected);

        let error = read("preset = \"six_points\"\n").unwrap_err();
        assert!(error.to_string().contains("mine.toml"), "{error}");
        let source = std::error::Error::source(&error).unwrap().to_string();
        assert!(source.contains("four_points"), "{source}");
        assert!(read("[energy]\nfrictoin = 1.0\n").is_err());
    }

    #[test]
    fn presets_are_the_library_defaults() {
        assert_eq!(
            Experiment::preset(DEFAULT_PRESET).unwrap(),
            Experiment::default()
        );
        let closed = Experiment {
            energy: EnergySettings::closed(),
            synthesis: SynthesisSettings::closed(),
        };
        assert_eq!(Experiment::preset("closed").unwrap(), closed);
        let four_points = Experiment {
            energy: EnergySettings::four_points(),
            synthesis: SynthesisSettings::four_points(),
        };
        assert_eq!(Experiment::preset("four_points").unwrap(), four_points);
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
    fn terms_tell_the_preset() {
        for (name, _) in PRESETS {
            let preset = Experiment::preset(name).unwrap();
            let mut terms = preset.energy.term_names();
            terms.reverse();
            assert_eq!(Experiment::of_terms(&terms), Some((name, preset)));
            terms.pop();
            assert_eq!(Experiment::of_terms(&terms), None, "{name}");
        }
    }

    #[test]
    fn unknown_keys_are_refused() {
        assert!(toml::from_str::<Experiment>("[energy]\nprior_wieght = 1.0").is_err());
    }
}
