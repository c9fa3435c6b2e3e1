//! A Gaussian in tangent coordinates of poses.

use landscape::energy::Energy;
use landscape::sample::{Mala, State};
use landscape::space::{PoseMetric, PoseSpace, Space, Symmetry};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use crate::sampler::chain::{Rule, Run, run};
use crate::sampler::statistics::{count, deviation, quantiles};
use crate::sampler::{CHANCE, WRONG};

/// Number of tangents of a hand with two joints.
const SIZE: usize = 8;
const TEMPERATURE: f64 = 0.7;
/// Standard deviation of the rotation, radians. Half a turn is five of them, so the probability beyond is negligible.
const ROTATION: f64 = 0.6;

type Tangent = SVector<f64, SIZE>;
type Square = SMatrix<f64, SIZE, SIZE>;

/// The energy whose Boltzmann law makes the logarithm u of a pose, relative to `centre`, normal with covariance Σ.
///
/// ```text
/// E = T (½ uᵀ Σ⁻¹ u + ln J(ω)),   J = (sin ½θ / ½θ)²,   θ = |ω|
/// ```
///
/// J is the volume of rotations (Haar) per volume of rotation vectors ω. The density of the pose must be divided by it.
struct Gaussian {
    space: PoseSpace,
    centre: Vec<f64>,
    covariance: Square,
    precision: Square,
    /// Whether to divide by J.
    haar: bool,
}

impl Gaussian {
    fn new(haar: bool) -> Self {
        let metric = PoseMetric {
            centroid: Vector3::new(0.01, -0.02, 0.07),
            radius_of_gyration_m: 0.056,
            joint_levers_m: vec![0.02, 0.004],
            joint_reaches_m: vec![0.05, 0.02],
            rotation_reach_m: 0.08,
            wraps: vec![false, true],
        };
        let [r, a, b] = [0.056, 0.02, 0.004];
        let spread = [
            0.02,
            0.03,
            0.025,
            ROTATION * r,
            ROTATION * r,
            ROTATION * r,
            0.5 * a,
            0.4 * b,
        ];
        // Any correlations will do, as long as all kinds of tangents are correlated with each other.
        let mixed = Square::from_fn(|i, j| (((3 * i + 5 * j * j) % 7) as f64 - 3.0) / 12.0);
        let mixed = Square::identity() + mixed * mixed.transpose();
        let covariance = Square::from_fn(|i, j| {
            spread[i] * spread[j] * mixed[(i, j)] / (mixed[(i, i)] * mixed[(j, j)]).sqrt()
        });
        let space = PoseSpace::new(metric, Symmetry::None);
        let mut centre = vec![0.3, -0.1, 0.2, 1.0, 0.0, 0.0, 0.0, 0.4, 3.0];
        space.exp(&mut centre, &[0.0, 0.0, 0.0, 0.06, -0.09, 0.05, 0.0, 0.0]);
        Self {
            space,
            centre,
            covariance,
            precision: covariance.try_inverse().unwrap(),
            haar,
        }
    }

    fn logarithm(&self, x: &[f64]) -> Tangent {
        let mut u = Tangent::zeros();
        self.space.log(&self.centre, x, u.as_mut_slice());
        u
    }
}

impl Energy for Gaussian {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let u = self.logarithm(x);
        let radius = self.space.metric().radius_of_gyration_m;
        let turn: Vector3<f64> = u.fixed_rows::<3>(3) / radius;
        let angle = turn.norm().max(1e-6);
        let (sine, cosine) = libm::sincos(0.5 * angle);
        let mut slope = self.precision * u;
        let mut exponent = 0.5 * u.dot(&slope);
        // Of the logarithm by a turn of the body: the inverse of the right Jacobian of SO(3).
        let cross = turn.cross_matrix();
        let bend = (angle.recip() - 0.5 * cosine / sine) / angle;
        let by_body = Matrix3::identity() + cross * 0.5 + cross * cross * bend;
        let mut by_turn: Vector3<f64> = by_body.tr_mul(&slope.fixed_rows::<3>(3));
        if self.haar {
            exponent += 2.0 * libm::log(2.0 * sine / angle);
            by_turn += turn * ((cosine / sine - 2.0 / angle) / (angle * radius));
        }
        slope.fixed_rows_mut::<3>(3).copy_from(&by_turn);
        gradient.copy_from_slice((slope * TEMPERATURE).as_slice());
        TEMPERATURE * exponent
    }
}

/// Density of χ² with 8 degrees of freedom, up to a factor.
fn chi_squared(squared: f64) -> f64 {
    squared.powi(3) * libm::exp(-0.5 * squared)
}

const MOMENTS: usize = SIZE + SIZE * (SIZE + 1) / 2;
const BINS: usize = 10;

/// Deviations of a chain from its law.
struct Deviates {
    /// For the first and second moments of u.
    moments: f64,
    /// For the distribution of uᵀ Σ⁻¹ u.
    lengths: f64,
    /// For the mean square of the angle.
    angle: f64,
    acceptance: f64,
}

fn deviates(haar: bool, rule: Rule, step: f64) -> Deviates {
    let energy = Gaussian::new(haar);
    let settings = Run {
        rule,
        temperature: TEMPERATURE,
        step,
        chains: 4,
        batches: 100,
        length: 3000,
    };
    let edges = quantiles(0.0, 80.0, BINS.try_into().unwrap(), chi_squared);
    let observe = |state: &State, sums: &mut [f64]| {
        let u = energy.logarithm(&state.coordinates);
        let products = (0..SIZE).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let moments = u.iter().copied().chain(products.map(|(i, j)| u[i] * u[j]));
        for (sum, moment) in sums.iter_mut().zip(moments) {
            *sum += moment;
        }
        count(u.dot(&(energy.precision * u)), &edges, &mut sums[MOMENTS..]);
    };
    let seen = run(
        &Mala::new(&energy),
        &energy.centre,
        settings,
        MOMENTS + BINS - 1,
        observe,
    );
    let mut expected = vec![0.0; SIZE];
    expected.extend(
        (0..SIZE)
            .flat_map(|i| (0..=i).map(move |j| (i, j)))
            .map(|ij| energy.covariance[ij]),
    );
    let part = |from: usize, to: usize| -> Vec<Vec<f64>> {
        seen.batches
            .iter()
            .map(|batch| batch[from..to].to_vec())
            .collect()
    };
    let shares = [1.0 / BINS as f64; BINS - 1];
    let angle = |moments: &[f64]| vec![(3..6).map(|i| moments[SIZE + i * (i + 3) / 2]).sum()];
    let angles: Vec<Vec<f64>> = seen.batches.iter().map(|batch| angle(batch)).collect();
    Deviates {
        moments: deviation(&part(0, MOMENTS), &expected),
        lengths: deviation(&part(MOMENTS, MOMENTS + BINS - 1), &shares),
        angle: deviation(&angles, &angle(&expected)),
        acceptance: seen.acceptance,
    }
}

const STEP: f64 = 0.014;

#[test]
fn the_gradient_is_the_derivative() {
    let energy = Gaussian::new(true);
    let mut x = energy.centre.clone();
    let far = [0.01, 0.02, -0.01, 0.03, -0.02, 0.05, 0.01, 0.002];
    energy.space.exp(&mut x, &far);
    let (mut gradient, mut unused) = ([0.0; SIZE], [0.0; SIZE]);
    energy.evaluate(&x, &mut gradient);
    for k in 0..SIZE {
        let mut at = |h: f64| {
            let (mut tangent, mut moved) = ([0.0; SIZE], x.clone());
            tangent[k] = h;
            energy.space.exp(&mut moved, &tangent);
            energy.evaluate(&moved, &mut unused)
        };
        let slope = (at(1e-7) - at(-1e-7)) / 2e-7;
        assert!(
            (slope - gradient[k]).abs() < 1e-4 * (1.0 + slope.abs()),
            "{k}: {slope}"
        );
    }
}

#[test]
fn poses_are_normal() {
    let seen = deviates(true, Rule::Exact, STEP);
    assert!((0.3..0.8).contains(&seen.acceptance), "{}", seen.acceptance);
    for deviate in [seen.moments, seen.lengths, seen.angle] {
        assert!(deviate < CHANCE, "{deviate}");
    }
}

#[test]
fn wrong_ratios_and_measures_are_found_out() {
    for rule in [Rule::Plain, Rule::Always] {
        let seen = deviates(true, rule, STEP);
        assert!(seen.moments > WRONG, "{rule:?}: {}", seen.moments);
    }
    // The law against the wrong measure: volumes of rotation vectors.
    let seen = deviates(false, Rule::Exact, STEP);
    assert!(seen.angle > WRONG, "{}", seen.angle);
}
