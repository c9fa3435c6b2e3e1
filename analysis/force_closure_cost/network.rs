//! A network of the standard size of `DeepSDF` (eight layers of 512, code of 256) with random weights.

use std::collections::BTreeMap;

use landscape::object::neural::{
    Decoder, Network, NeuralError, NeuralField, Specs, Tensor, Tensors,
};
use landscape::sample::{Rng, Task, stream};
use rand::RngExt;

const SPECS: &str = r#"{
    "NetworkArch": "deep_sdf_decoder",
    "NetworkSpecs": {
        "dims": [512, 512, 512, 512, 512, 512, 512, 512], "latent_in": [4],
        "norm_layers": [0, 1, 2, 3, 4, 5, 6, 7], "weight_norm": true
    },
    "CodeLength": 256
}"#;
const CODE: usize = 256;
fn tensor(rng: &mut Rng, shape: &[usize]) -> Tensor {
    let count = shape.iter().product::<usize>();
    Tensor {
        shape: shape.to_vec(),
        values: (0..count).map(|_| rng.random_range(-1.0..1.0)).collect(),
    }
}

/// The network as a shape.
pub(crate) fn field(scale_m: f64) -> Result<NeuralField<f32>, NeuralError> {
    let mut rng = stream(0, Task::Start, 0);
    let mut tensors = BTreeMap::new();
    for layer in 0..8 {
        let rows = if layer == 3 { 512 - CODE - 3 } else { 512 };
        let columns = if layer == 0 { CODE + 3 } else { 512 };
        let named = |ending: &str| format!("lin{layer}.{ending}");
        tensors.insert(named("weight_v"), tensor(&mut rng, &[rows, columns]));
        tensors.insert(named("weight_g"), tensor(&mut rng, &[rows, 1]));
        tensors.insert(named("bias"), tensor(&mut rng, &[rows]));
    }
    tensors.insert("lin8.weight".to_owned(), tensor(&mut rng, &[1, 512]));
    tensors.insert("lin8.bias".to_owned(), tensor(&mut rng, &[1]));
    let tensors = Tensors {
        name: "made up".to_owned(),
        tensors,
    };
    let code: Vec<f64> = (0..CODE).map(|_| rng.random_range(-0.1..0.1)).collect();
    let decoder = Decoder::new(Specs::from_json("specs", SPECS)?, &tensors)?;
    NeuralField::new(Network::new(&decoder, &code)?, scale_m)
}
