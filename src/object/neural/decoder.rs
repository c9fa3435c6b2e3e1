//! The trained decoder: weights of all layers, for any latent code.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use nalgebra::{DMatrix, DVector};
use safetensors::{Dtype, SafeTensors};

use super::{NeuralError, Specs};
use crate::limits::NETWORK_WEIGHT;

/// A multi-dimensional array of numbers in row-major order.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensor {
    /// Length of each dimension.
    pub shape: Vec<usize>,
    /// The numbers.
    pub values: Vec<f64>,
}

/// Tensors by name, and the name of their source in errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensors {
    /// The source.
    pub name: String,
    /// The tensors. Names may begin with `module.`, the prefix of torch's `DataParallel`.
    pub tensors: BTreeMap<String, Tensor>,
}

/// A `DeepSDF` decoder f(code, x): Park et al. 2019, *Learning Continuous Signed Distance Functions for Shape
/// Representation*.
///
/// ```text
/// h₀ = (code, x),   hₖ₊₁ = relu(Wₖ hₖ + bₖ)   with (hₖ, code, x) instead of hₖ for k in latent_in,
/// f = tanh(W h + b)
/// ```
///
/// Values have no unit: shapes are scaled into a ball of radius 1, and f is negative inside. Weights with normalisation are
/// W = g v/‖v‖ by rows; they are computed here once.
#[derive(Debug, Clone, PartialEq)]
pub struct Decoder {
    pub(super) specs: Specs,
    pub(super) layers: Vec<Linear>,
}

/// W and b of a layer.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Linear {
    pub(super) weight: DMatrix<f64>,
    pub(super) bias: DVector<f64>,
}

impl Tensors {
    /// Reads a `.safetensors` file.
    ///
    /// # Errors
    /// If the file cannot be read, is of another format, or if a tensor holds anything but finite F32 or F64 numbers.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, NeuralError> {
        let path = path.as_ref();
        let kind = path
            .extension()
            .map(|kind| kind.to_string_lossy().to_lowercase());
        if matches!(kind.as_deref(), Some("pth" | "pt" | "ckpt")) {
            return Err(NeuralError::Checkpoint(path.to_owned()));
        }
        let bytes = fs::read(path).map_err(|source| NeuralError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::from_bytes(&path.display().to_string(), &bytes)
    }

    /// Reads the bytes of a `.safetensors` file. `name` is its name in errors.
    ///
    /// # Errors
    /// If the bytes are of another format, or if a tensor holds anything but finite F32 or F64 numbers.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, NeuralError> {
        let file = SafeTensors::deserialize(bytes).map_err(|source| NeuralError::Safetensors {
            name: name.to_owned(),
            source,
        })?;
        let mut tensors = BTreeMap::new();
        let mut views = file.tensors();
        // Sorted, so that the same error is reported every time if there are several.
        views.sort_by(|a, b| a.0.cmp(&b.0));
        for (tensor, view) in views {
            let data = view.data();
            let values: Vec<f64> = match view.dtype() {
                Dtype::F32 => data
                    .as_chunks()
                    .0
                    .iter()
                    .map(|&b| f32::from_le_bytes(b).into())
                    .collect(),
                Dtype::F64 => data
                    .as_chunks()
                    .0
                    .iter()
                    .map(|&b| f64::from_le_bytes(b))
                    .collect(),
                other => {
                    return Err(NeuralError::Kind {
                        name: name.to_owned(),
                        tensor,
                        found: format!("{other:?}"),
                    });
                }
            };
            let beyond = |value: &f64| NETWORK_WEIGHT.check(*value).err();
            if let Some(beyond) = values.iter().find_map(beyond) {
                return Err(NeuralError::Beyond {
                    name: name.to_owned(),
                    tensor,
                    beyond,
                });
            }
            let shape = view.shape().to_vec();
            tensors.insert(tensor, Tensor { shape, values });
        }
        Ok(Self {
            name: name.to_owned(),
            tensors,
        })
    }

    /// The latent code of shape number `index`: a row of the tensor `latent_codes`, or of `weight` in a file of codes only.
    ///
    /// # Errors
    /// If there are no codes or not enough of them.
    pub fn code(&self, index: usize) -> Result<Vec<f64>, NeuralError> {
        let codes = ["latent_codes", "latent_codes.weight", "weight"]
            .iter()
            .find_map(|name| self.tensors.get(*name))
            .filter(|codes| codes.shape.len() == 2);
        let Some(Tensor { shape, values }) = codes else {
            return Err(NeuralError::NoCodes(self.name.clone()));
        };
        let (count, length) = (shape[0], shape[1]);
        if index >= count {
            return Err(NeuralError::Code {
                name: self.name.clone(),
                index,
                count,
            });
        }
        Ok(values[index * length..(index + 1) * length].to_vec())
    }

    fn find(&self, tensor: &str) -> Option<&Tensor> {
        let find = |name: &str| self.tensors.get(name);
        find(tensor).or_else(|| find(&format!("module.{tensor}")))
    }

    /// The values of the first tensor found under one of these names. It must have the expected shape.
    fn values(&self, names: &[String], expected: &[usize]) -> Result<&[f64], NeuralError> {
        let found = names.iter().find_map(|name| Some((name, self.find(name)?)));
        let Some((tensor, found)) = found else {
            return Err(NeuralError::Missing {
                name: self.name.clone(),
                tensor: names[0].clone(),
            });
        };
        if found.shape != expected {
            return Err(NeuralError::Shape {
                name: self.name.clone(),
                tensor: tensor.clone(),
                found: found.shape.clone(),
                expected: expected.to_vec(),
            });
        }
        Ok(&found.values)
    }

    fn linear(
        &self,
        layer: usize,
        [rows, columns]: [usize; 2],
        normalised: bool,
    ) -> Result<Linear, NeuralError> {
        let named = |ending: &str| format!("lin{layer}.{ending}");
        let bias = self.values(&[named("bias")], &[rows])?;
        // The second of two names is that of later versions of torch.
        let weight = if normalised {
            [
                named("weight_v"),
                named("parametrizations.weight.original1"),
            ]
        } else {
            [named("weight"), named("weight")]
        };
        let values = self.values(&weight, &[rows, columns])?;
        let mut matrix = DMatrix::from_row_slice(rows, columns, values);
        if normalised {
            let names = [
                named("weight_g"),
                named("parametrizations.weight.original0"),
            ];
            let lengths = self.values(&names, &[rows, 1])?;
            for (row, (mut direction, length)) in matrix.row_iter_mut().zip(lengths).enumerate() {
                let norm = direction.norm();
                if norm == 0.0 {
                    return Err(NeuralError::NoDirection {
                        name: self.name.clone(),
                        tensor: weight[0].clone(),
                        row,
                    });
                }
                direction *= length / norm;
            }
        }
        Ok(Linear {
            weight: matrix,
            bias: DVector::from_column_slice(bias),
        })
    }
}

impl Decoder {
    /// The decoder of `specs` with the weights of `tensors`.
    ///
    /// # Errors
    /// If a tensor is missing or has another shape than in the specs.
    pub fn new(specs: Specs, tensors: &Tensors) -> Result<Self, NeuralError> {
        let layer = |layer| tensors.linear(layer, specs.shape(layer), specs.is_normalised(layer));
        let layers = (0..specs.layers()).map(layer).collect::<Result<_, _>>()?;
        Ok(Self { specs, layers })
    }
}
