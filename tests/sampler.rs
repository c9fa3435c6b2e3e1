//! Chains sample a known density of rotations with respect to the measure of the group, also with moves that go the long way
//! round.

use std::f64::consts::PI;

use landscape::energy::{Energy, check_gradient};
use landscape::sample::{Kernel, Mala, State, TargetDensity, Task, stream};
use landscape::space::{Rotation, Space};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::RngExt;
use rayon::prelude::*;

const RADIUS_M: f64 = 0.05;
const TEMPERATURE: f64 = 1.3;

/// The parameter of a matrix Fisher distribution: density ∝ exp(κ tr R) with respect to the invariant measure.
const KAPPA: f64 = 0.8;

/// E = −T κ tr R.
struct Fisher(Rotation);

impl Energy for Fisher {
    fn space(&self) -> &dyn Space {
        &self.0
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let turn = UnitQuaternion::new_normalize(Quaternion::new(x[0], x[1], x[2], x[3]));
        let m = turn.to_rotation_matrix().into_inner() * KAPPA;
        // tr(M [δ]ₓ) for a turn δ of the body.
        let [x, y, z] = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| m[(i, j)] - m[(j, i)]);
        let by_turn = Vector3::new(x, y, z) * (-TEMPERATURE / RADIUS_M);
        gradient.copy_from_slice(by_turn.as_slice());
        -TEMPERATURE * m.trace()
    }
}

/// Mean of cos θ over the angles θ of rotations, if a small range of angles has this volume.
fn expected(volume: fn(f64) -> f64) -> f64 {
    let (mut total, mut sum) = (0.0, 0.0);
    for k in 0..4000 {
        let angle = PI * (f64::from(k) + 0.5) / 4000.0;
        let weight = volume(angle) * libm::exp(2.0 * KAPPA * libm::cos(angle));
        total += weight;
        sum += weight * libm::cos(angle);
    }
    sum / total
}

/// Means of cos θ along parts of four chains, after a first part that is left out.
fn batches() -> Vec<f64> {
    let energy = Fisher(Rotation::new(RADIUS_M));
    let kernel = Mala::new(&energy);
    let law = TargetDensity {
        temperature: TEMPERATURE,
        attraction: None,
    };
    let chain = |chain: u64| -> Vec<f64> {
        let mut rng = stream(11, Task::Synthesis, chain);
        let mut state = kernel.start(&[1.0, 0.0, 0.0, 0.0]);
        let mut proposal = State::default();
        let mut batch = || {
            let mut sum = 0.0;
            for _ in 0..2000 {
                // More than a radian: a move often goes the long way round.
                let step = 1.1 * RADIUS_M;
                let ratio = kernel.propose(&state, &law, step, &mut rng, &mut proposal);
                if libm::log(rng.random::<f64>()) < ratio {
                    std::mem::swap(&mut state, &mut proposal);
                }
                sum += 2.0 * state.coordinates[0] * state.coordinates[0] - 1.0;
            }
            sum / 2000.0
        };
        (0..=60).map(|_| batch()).skip(1).collect()
    };
    (0..4_u64).into_par_iter().flat_map_iter(chain).collect()
}

#[test]
fn rotations_have_the_mean_of_their_law() {
    let batches = batches();
    let count = batches.len() as f64;
    let mean = batches.iter().sum::<f64>() / count;
    let variance = batches.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let deviations = |value: f64| (mean - value).abs() / (variance / count).sqrt();
    let right = deviations(expected(|angle| 1.0 - libm::cos(angle)));
    assert!(right < 4.5, "{right} standard deviations");
    // Volumes of rotation vectors in place of those of the group.
    let wrong = deviations(expected(|angle| angle * angle));
    assert!(wrong > 8.0, "{wrong} standard deviations");
}

#[test]
fn the_gradient_is_the_derivative() {
    let energy = Fisher(Rotation::new(RADIUS_M));
    let points = [vec![0.5, 0.5, -0.1, 0.7], vec![0.9, 0.1, 0.3, -0.2]].map(|x: Vec<f64>| {
        let norm = x.iter().map(|q| q * q).sum::<f64>().sqrt();
        x.iter().map(|q| q / norm).collect::<Vec<f64>>()
    });
    check_gradient(&energy, &points, 1e-6).unwrap();
}
