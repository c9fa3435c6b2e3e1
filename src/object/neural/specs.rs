//! The specs file of a `DeepSDF` experiment.

use std::fs;
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::NeuralError;
use crate::limits::MOST_NETWORK_WIDTH;

/// The description of the network in a specs file. Training settings in the file are skipped.
///
/// The names are those of `specs.json` in the authors' code.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Specs {
    /// The architecture: `deep_sdf_decoder`.
    #[serde(rename = "NetworkArch", default = "Specs::architecture")]
    pub network_arch: String,
    /// The layers.
    #[serde(rename = "NetworkSpecs")]
    pub network: NetworkSpecs,
    /// Length of a latent code.
    #[serde(rename = "CodeLength")]
    pub code_length: usize,
}

/// The layers of a decoder.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "these are the keys of the file"
)]
pub struct NetworkSpecs {
    /// Widths of the hidden layers.
    pub dims: Vec<usize>,
    /// Layers whose input also contains the network's input (code and coordinates).
    #[serde(default)]
    pub latent_in: Vec<usize>,
    /// Layers with normalisation.
    #[serde(default)]
    pub norm_layers: Vec<usize>,
    /// Whether normalisation is weight normalisation, w = g v/‖v‖. Layer normalisation is not supported.
    #[serde(default)]
    pub weight_norm: bool,
    /// Whether the coordinates join the input of every layer.
    #[serde(default)]
    pub xyz_in_all: bool,
    /// Whether a hyperbolic tangent comes *before* the final one.
    #[serde(default)]
    pub use_tanh: bool,
    /// Whether there is a final hyperbolic tangent, as in the authors' code. Some later networks omit it. This key is not
    /// part of the authors' format.
    #[serde(default = "NetworkSpecs::has_final_tanh")]
    pub final_tanh: bool,
    // The following keys matter only in training.
    #[serde(default, rename = "dropout")]
    _dropout: IgnoredAny,
    #[serde(default, rename = "dropout_prob")]
    _dropout_prob: IgnoredAny,
    #[serde(default, rename = "latent_dropout")]
    _latent_dropout: IgnoredAny,
}

impl Specs {
    /// Reads a specs file.
    ///
    /// # Errors
    /// If the file cannot be read or does not describe a decoder.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, NeuralError> {
        let path = path.as_ref();
        let text = fs::read_to_string(path).map_err(|source| NeuralError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::from_json(&path.display().to_string(), &text)
    }

    /// Reads the text of a specs file. `name` is its name in errors.
    ///
    /// # Errors
    /// If the text does not describe a decoder.
    pub fn from_json(name: &str, text: &str) -> Result<Self, NeuralError> {
        let specs: Self = serde_json::from_str(text).map_err(|source| NeuralError::Specs {
            name: name.to_owned(),
            source,
        })?;
        specs.validate(name)?;
        Ok(specs)
    }

    fn architecture() -> String {
        ARCHITECTURE.to_owned()
    }

    /// Length of the network's input: the code and three coordinates.
    pub(super) fn input(&self) -> usize {
        self.code_length + 3
    }

    /// Number of linear layers.
    pub(super) fn layers(&self) -> usize {
        self.network.dims.len() + 1
    }

    /// Whether layer `layer` has weight normalisation.
    pub(super) fn is_normalised(&self, layer: usize) -> bool {
        self.network.weight_norm && self.network.norm_layers.contains(&layer)
    }

    /// Rows and columns of the weight of layer `layer`, as in the authors' code.
    pub(super) fn shape(&self, layer: usize) -> [usize; 2] {
        let network = &self.network;
        let width = |index: usize| match index {
            0 => self.input(),
            _ => network.dims.get(index - 1).copied().unwrap_or(1),
        };
        let last = self.layers() - 1;
        let joined = if network.latent_in.contains(&(layer + 1)) {
            self.input()
        } else if network.xyz_in_all && layer != last {
            3
        } else {
            0
        };
        [width(layer + 1) - joined, width(layer)]
    }

    fn validate(&self, name: &str) -> Result<(), NeuralError> {
        let invalid = |field, problem: String| {
            Err(NeuralError::Value {
                name: name.to_owned(),
                field,
                problem,
            })
        };
        let network = &self.network;
        if self.network_arch != ARCHITECTURE {
            let problem = format!(
                "`{}` is not supported, only {ARCHITECTURE} is",
                self.network_arch
            );
            return invalid("NetworkArch", problem);
        }
        if network.dims.is_empty() || network.dims.contains(&0) {
            return invalid(
                "dims",
                "at least one layer is needed, and none may be empty".to_owned(),
            );
        }
        let widths = network.dims.iter().chain([&self.code_length]);
        if let Some(width) = widths.copied().find(|width| *width > MOST_NETWORK_WIDTH) {
            let problem = format!(
                "a layer or the code has {width} numbers, but at most {MOST_NETWORK_WIDTH} are allowed"
            );
            return invalid("dims", problem);
        }
        if !network.weight_norm && !network.norm_layers.is_empty() {
            let problem = "with weight_norm false these layers have layer normalisation, which is not supported";
            return invalid("norm_layers", problem.to_owned());
        }
        if let Some(layer) = network
            .latent_in
            .iter()
            .find(|&&layer| layer == 0 || layer >= self.layers())
        {
            let problem = format!(
                "layer {layer} cannot be joined by the input, only layers 1 to {} can",
                self.layers() - 1
            );
            return invalid("latent_in", problem);
        }
        let narrowest = (0..network.dims.len()).find(|&layer| {
            let joins = network.latent_in.contains(&(layer + 1));
            let joined = if joins {
                self.input()
            } else {
                3 * usize::from(network.xyz_in_all)
            };
            network.dims[layer] <= joined
        });
        if let Some(layer) = narrowest {
            let problem = format!("layer {layer} is too narrow to be joined by the input");
            return invalid("dims", problem);
        }
        Ok(())
    }
}

impl NetworkSpecs {
    fn has_final_tanh() -> bool {
        true
    }
}

const ARCHITECTURE: &str = "deep_sdf_decoder";
