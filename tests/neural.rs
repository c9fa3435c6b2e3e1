//! Neural shapes, compared with an independent implementation (torch, double precision) and with each other.
#![cfg(feature = "neural")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::LazyLock;

use crate::table::rows;
use landscape::object::Shape;
use landscape::object::neural::{
    Answer, Decoder, Network, NeuralError, NeuralField, Real, Specs, SurfaceSettings, Tensor,
    Tensors,
};
use landscape::sample::{Task, stream};
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use serde_json::Value;

fn file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/reference/deepsdf")
        .join(name)
}

fn json(name: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(file(name)).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

fn vectors(value: &Value) -> Vec<Vector3<f64>> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|v| Vector3::from_column_slice(&numbers(v)))
        .collect()
}

fn matrices(value: &Value) -> Vec<Matrix3<f64>> {
    let matrix = |m: &Value| Matrix3::from_rows(&[0, 1, 2].map(|row| vectors(m)[row].transpose()));
    value.as_array().unwrap().iter().map(matrix).collect()
}

fn small() -> (Specs, Tensors) {
    (
        Specs::load(file("small_specs.json")).unwrap(),
        Tensors::load(file("small_model.safetensors")).unwrap(),
    )
}

fn small_network<T: Real>(shape: usize) -> Network<T> {
    let (specs, tensors) = small();
    let code = tensors.code(shape).unwrap();
    Network::new(&Decoder::new(specs, &tensors).unwrap(), &code).unwrap()
}

static BOTTLE: LazyLock<NeuralField<f64>> =
    LazyLock::new(|| NeuralField::new(small_network(0), 0.1).unwrap());

/// Largest differences of value, gradient, Hessian and its product with a vector from a reference.
fn differences(answers: &[Answer], reference: &Value) -> [f64; 4] {
    let largest = |differences: &mut dyn Iterator<Item = f64>| {
        differences.fold(0.0, |most: f64, x| if x.is_nan() { x } else { most.max(x) })
    };
    let (sdf, gradients) = (numbers(&reference["sdf"]), vectors(&reference["gradient"]));
    let (hessians, products) = (matrices(&reference["hessian"]), vectors(&reference["hvp"]));
    let along = vectors(&reference["hvp_vectors"]);
    assert_eq!(answers.len(), sdf.len());
    assert_eq!(
        [gradients.len(), products.len(), along.len()],
        [sdf.len(); 3]
    );
    assert!(hessians.len() >= 8);
    [
        largest(&mut answers.iter().zip(&sdf).map(|(a, b)| (a.0 - b).abs())),
        largest(
            &mut answers
                .iter()
                .zip(&gradients)
                .map(|(a, b)| (a.1 - b).amax()),
        ),
        largest(&mut answers.iter().zip(&hessians).map(|(a, b)| (a.2 - b).amax())),
        largest(
            &mut answers
                .iter()
                .zip(along.iter().zip(&products))
                .map(|(a, (v, b))| (a.2 * v - b).amax()),
        ),
    ]
}

fn small_differences<T: Real>() -> [f64; 4] {
    let reference = json("small_reference.json");
    let mut most = [0.0; 4];
    for result in reference["results"].as_array().unwrap() {
        let shape = usize::try_from(result["latent_index"].as_u64().unwrap()).unwrap();
        let answers = small_network::<T>(shape).answers(&vectors(&result["points"]));
        for (most, difference) in most.iter_mut().zip(differences(&answers, result)) {
            *most = difference.max(*most);
        }
    }
    most
}

#[test]
fn a_trained_network_in_double_precision() {
    let differences = small_differences::<f64>();
    assert!(differences.iter().all(|&d| d <= 1e-12), "{differences:?}");
}

#[test]
fn a_trained_network_in_single_precision() {
    let differences = small_differences::<f32>();
    assert!(differences.iter().all(|&d| d <= 1e-6), "{differences:?}");
}

/// The standard network with weights given by a formula.
fn standard<T: Real>() -> (Network<T>, Value) {
    let reference = json("standard_formula_reference.json");
    let mut tensors = BTreeMap::new();
    for (j, key) in reference["keys"].as_array().unwrap().iter().enumerate() {
        let name = key[0].as_str().unwrap().to_owned();
        let shape: Vec<usize> = serde_json::from_value(key[1].clone()).unwrap();
        let n = shape.iter().product::<usize>();
        let value = |a: usize| {
            let a = a as f64;
            let w = libm::sin(0.7 * a + 0.3 * a * a / n as f64 + 1.1 * j as f64);
            if name.ends_with("weight_g") {
                1.4 + 0.2 * w
            } else if name.ends_with("bias") {
                0.02 * w
            } else {
                0.05 * w
            }
        };
        let values = (0..n).map(value).collect();
        tensors.insert(name, Tensor { shape, values });
    }
    let tensors = Tensors {
        name: "formula".to_owned(),
        tensors,
    };
    let specs = Specs::load(file("standard_specs.json")).unwrap();
    let code: Vec<f64> = (0..256)
        .map(|i| 0.5 * libm::sin(0.37 * f64::from(i)))
        .collect();
    let decoder = Decoder::new(specs, &tensors).unwrap();
    (Network::new(&decoder, &code).unwrap(), reference)
}

#[test]
fn the_standard_network_in_both_precisions() {
    let (network, reference) = standard::<f64>();
    let points = vectors(&reference["points"]);
    let double = differences(&network.answers(&points), &reference);
    assert!(double.iter().all(|&d| d <= 1e-12), "{double:?}");
    let single = differences(&standard::<f32>().0.answers(&points), &reference);
    assert!(single.iter().all(|&d| d <= 1e-6), "{single:?}");
}

#[test]
fn answers_do_not_depend_on_threads_and_hardly_on_company() {
    let network = small_network::<f32>(1);
    let mut rng = stream(0, Task::Start, 0);
    let points: Vec<_> = (0..300)
        .map(|_| Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)))
        .collect();
    let together = network.answers(&points);
    let values = network.values(&points);
    for (index, point) in points.iter().enumerate() {
        assert_eq!(together[index].0.to_bits(), values[index].to_bits());
        // One by one there is no product of matrices, so sums are rounded in another order.
        let alone = network.answers(&[*point])[0];
        assert_eq!(alone.0.to_bits(), network.values(&[*point])[0].to_bits());
        assert!((alone.0 - together[index].0).abs() < 1e-6);
        assert!((alone.1 - together[index].1).amax() < 1e-5);
    }
    assert_eq!(network.answers(&points[100..200]), together[100..200]);
    let pool = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
    };
    for threads in [1, 3] {
        assert!(pool(threads).install(|| network.answers(&points)) == together);
    }
    assert!(network.answers(&[]).is_empty());
}

/// Specs of a small network with random tensors that fit them.
fn made_up(network: &str, shapes: &[(&str, &[usize])]) -> Decoder {
    let specs = format!("{{\"NetworkSpecs\": {network}, \"CodeLength\": 2}}");
    let mut rng = stream(0, Task::Start, 1);
    let tensors = shapes.iter().map(|(name, shape)| {
        let count = shape.iter().product::<usize>();
        let values = (0..count).map(|_| rng.random_range(-1.0..1.0)).collect();
        (
            format!("module.{name}"),
            Tensor {
                shape: shape.to_vec(),
                values,
            },
        )
    });
    let tensors = Tensors {
        name: "made up".to_owned(),
        tensors: tensors.collect(),
    };
    Decoder::new(Specs::from_json("specs", &specs).unwrap(), &tensors).unwrap()
}

#[test]
fn every_option_has_the_derivatives_of_its_value() {
    const STEP: f64 = 1e-5;
    let shapes: &[(&str, &[usize])] = &[
        ("lin0.weight", &[17, 5]),
        ("lin0.bias", &[17]),
        ("lin1.parametrizations.weight.original0", &[15, 1]),
        ("lin1.parametrizations.weight.original1", &[15, 20]),
        ("lin1.bias", &[15]),
        ("lin2.weight", &[1, 20]),
        ("lin2.bias", &[1]),
    ];
    for end in [
        "\"use_tanh\": false, \"final_tanh\": false",
        "\"use_tanh\": false, \"final_tanh\": true",
        "\"use_tanh\": true",
    ] {
        let options = format!(
            "{{\"dims\": [20, 20], \"latent_in\": [2], \"xyz_in_all\": true, \"norm_layers\": [1], \
             \"weight_norm\": true, {end}}}"
        );
        let network = Network::<f64>::new(&made_up(&options, shapes), &[0.3, -0.2]).unwrap();
        let mut rng = stream(0, Task::Start, 2);
        let mut smooth = 0;
        for _ in 0..200 {
            let point = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
            let around: Vec<_> = (0..6)
                .map(|k| point + Vector3::ith(k / 2, if k % 2 == 0 { STEP } else { -STEP }))
                .collect();
            let (_, gradient, hessian) = network.answers(&[point])[0];
            let answers = network.answers(&around);
            let central = |k: usize| (answers[2 * k].0 - answers[2 * k + 1].0) / (2.0 * STEP);
            let central_gradient = Vector3::from_fn(|k, _| central(k));
            let columns =
                [0, 1, 2].map(|k| (answers[2 * k].1 - answers[2 * k + 1].1) / (2.0 * STEP));
            let off = (central_gradient - gradient)
                .amax()
                .max((Matrix3::from_columns(&columns) - hessian).amax());
            smooth += usize::from(off < 1e-6);
        }
        // The others lie within a step of a corner of a rectifier, of which there are 32.
        assert!(smooth >= 195, "{end}: {smooth}");
    }
}

#[test]
fn a_neural_shape_has_the_derivatives_of_its_distance() {
    const STEP_M: f64 = 1e-7;
    let mut rng = stream(0, Task::Start, 3);
    let (mut smooth, mut beyond) = (0, 0);
    for _ in 0..400 {
        let point = Vector3::from_fn(|_, _| rng.random_range(-0.15..0.15));
        let (value, gradient) = BOTTLE.gradient(&point);
        let (again, _, hessian) = BOTTLE.hessian(&point);
        assert_eq!(value.to_bits(), BOTTLE.distance(&point).to_bits());
        assert_eq!(value.to_bits(), again.to_bits());
        assert!(value < 0.0 || gradient.norm() <= BOTTLE.lipschitz());
        assert!((hessian - hessian.transpose()).amax() < 1e-12 * hessian.amax().max(1.0));
        let side = |k: usize, step: f64| BOTTLE.hessian(&(point + Vector3::ith(k, step)));
        let off = |k: usize| {
            let (ahead, behind) = (side(k, STEP_M), side(k, -STEP_M));
            let slope = (ahead.0 - behind.0) / (2.0 * STEP_M) - gradient[k];
            let bend = (ahead.1 - behind.1) / (2.0 * STEP_M) - hessian.column(k);
            (slope.abs() / 1e-6).max(bend.amax() / 1e-4)
        };
        if (0..3).all(|k| off(k) < 1.0) {
            smooth += 1;
            beyond += usize::from(point.norm() > 0.1);
        }
    }
    assert!(smooth >= 390 && beyond > 100, "{smooth} {beyond}");
}

#[test]
fn the_surface_is_where_the_network_is_zero() {
    let field = NeuralField::<f32>::new(small_network(0), 0.1).unwrap();
    let settings = SurfaceSettings { cells: 64 };
    let surface = field.surface("bottle", &settings).unwrap();
    // But for a crevice narrower than a cell, whose walls a vertex cannot reach.
    let off = surface
        .mesh
        .vertices()
        .iter()
        .map(|v| field.distance(v).abs());
    let off: Vec<f64> = off.filter(|off| *off > 1e-7).collect();
    assert!(off.len() <= surface.mesh.vertices().len() / 1000, "{off:?}");
    assert!(
        surface.residual_m < 0.1 * surface.cell_m,
        "{}",
        surface.residual_m
    );
    // The bottle has a radius of 0.98 about the middle of its box.
    let [low, high] = surface.mesh.bounds();
    let size = high - low;
    assert!(size.max() > 0.15 && size.norm() < 0.21, "{size}");
    // Between the vertices, too: points of the triangles lie within a chord of the surface.
    let samples = surface.mesh.sample_surface(500, 0);
    let farthest = samples
        .iter()
        .map(|s| field.distance(&s.point).abs())
        .fold(0.0, f64::max);
    assert!(farthest < 0.25 * surface.cell_m, "{farthest}");
    // And normals agree with gradients, but for edges.
    let agreeing = samples
        .iter()
        .filter(|s| field.gradient(&s.point).1.normalize().dot(&s.normal) > 0.9);
    assert!(agreeing.count() > 450);

    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(
        pool.install(|| field.surface("bottle", &settings)).unwrap(),
        surface
    );
}

#[test]
fn mistakes_have_sentences() {
    let (specs, tensors) = small();
    let says = |result: Result<Decoder, NeuralError>, words: &[&str]| {
        let sentence = result.unwrap_err().to_string();
        for word in words {
            assert!(sentence.contains(word), "{sentence}");
        }
    };
    let mut without = tensors.clone();
    without.tensors.remove("lin2.weight_g");
    says(
        Decoder::new(specs.clone(), &without),
        &["small_model.safetensors has no tensor lin2.weight_g"],
    );
    let mut narrow = tensors.clone();
    narrow.tensors.get_mut("lin1.bias").unwrap().shape = vec![108];
    says(
        Decoder::new(specs.clone(), &narrow),
        &["lin1.bias", "[108]", "[109]"],
    );
    let mut flat = tensors.clone();
    flat.tensors.get_mut("lin3.weight_v").unwrap().values[128..256].fill(0.0);
    says(
        Decoder::new(specs.clone(), &flat),
        &["row 1 of tensor lin3.weight_v"],
    );

    let text = std::fs::read_to_string(file("small_specs.json")).unwrap();
    let cases = r#"
        "use_tanh" | "use_tahn" | unknown field `use_tahn` | `use_tanh`
        "CodeLength" | "Codes" | missing field `CodeLength`
        deep_sdf_decoder | siren | NetworkArch | siren
        "weight_norm": true | "weight_norm": false | norm_layers | layer normalisation
        "CodeLength": 16 | "CodeLength": 126 | dims | too narrow
        "CodeLength": 16 | "CodeLength": 16, | not a valid specs file | line
    "#;
    for case in rows(cases) {
        assert!(text.contains(case[0]));
        let sentence = Specs::from_json("s.json", &text.replace(case[0], case[1]))
            .unwrap_err()
            .to_string();
        for word in case[2..].iter().chain(&["s.json"]) {
            assert!(sentence.contains(word), "{sentence}");
        }
    }
    assert!(
        tensors
            .code(3)
            .unwrap_err()
            .to_string()
            .contains("latent code 3 does not exist")
    );
    let bytes = std::fs::read(file("small_model.safetensors")).unwrap();
    for length in [0, 7, 100, bytes.len() - 1] {
        let sentence = Tensors::from_bytes("torn", &bytes[..length])
            .unwrap_err()
            .to_string();
        assert!(
            sentence.contains("torn is not a valid .safetensors file"),
            "{sentence}"
        );
    }
    assert!(NeuralField::new(small_network::<f32>(0), -1.0).is_err());
    let tiny = NeuralField::new(small_network::<f32>(0), 1e-4).unwrap();
    let sentence = tiny
        .surface("tiny", &SurfaceSettings { cells: 16 })
        .unwrap_err()
        .to_string();
    assert!(sentence.contains("tiny is 0.000"), "{sentence}");
}
