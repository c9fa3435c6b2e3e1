//! Experiment files: the library's settings structures as TOML.

use std::path::Path;

use anyhow::{Context, bail};
use serde::{Deserialize, Serialize};

use crate::grasp::EnergySettings;
use crate::grasp::synthesis::SynthesisSettings;

/// Content of an experiment file. Every section and key is optional.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Experiment {
    pub(super) energy: EnergySettings,
    pub(super) synthesis: SynthesisSettings,
}

const PRESETS: [(&str, &str); 3] = [
    (
        "default",
        include_str!("../../data/experiments/default.toml"),
    ),
    ("paper", include_str!("../../data/experiments/paper.toml")),
    (
        "released",
        include_str!("../../data/experiments/released.toml"),
    ),
];

impl Experiment {
    pub(super) fn preset(name: &str) -> anyhow::Result<Self> {
        let Some((_, text)) = PRESETS.iter().find(|(known, _)| *known == name) else {
            let known = PRESETS.map(|(known, _)| known).join(", ");
            bail!("--preset {name}: unknown; there are {known}");
        };
        Ok(toml::from_str(text).expect("the tests read the presets"))
    }

    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("cannot read {}", path.display()))?;
        let experiment: Self = crate::formats::toml_text::parse(&text)
            .with_context(|| format!("{} is not an experiment", path.display()))?;
        experiment
            .energy
            .validate()
            .and_then(|()| experiment.energy.ask_for_contacts())
            .with_context(|| format!("{}, section [energy]", path.display()))?;
        experiment
            .synthesis
            .validate()
            .with_context(|| format!("{}, section [synthesis]", path.display()))?;
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
