//! Matrix Fisher distributions on the rotation group.

use landscape::energy::Energy;
use landscape::sample::{Mala, State};
use landscape::space::{Rotation, Space};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

use crate::chain::{Rule, Run, Seen, run};
use crate::statistics::{count, deviation, quantiles};
use crate::{CHANCE, WRONG};

const RADIUS_M: f64 = 0.05;
const TEMPERATURE: f64 = 1.3;

/// Density ∝ exp(tr(Fᵀ R)) with respect to the invariant measure: E = −T tr(Fᵀ R).
struct Fisher {
    space: Rotation,
    parameter: Matrix3<f64>,
}

impl Fisher {
    fn new(parameter: Matrix3<f64>) -> Self {
        Self {
            space: Rotation::new(RADIUS_M),
            parameter,
        }
    }
}

fn rotation(x: &[f64]) -> Matrix3<f64> {
    let unit = UnitQuaternion::new_normalize(Quaternion::new(x[0], x[1], x[2], x[3]));
    unit.to_rotation_matrix().into_inner()
}

impl Energy for Fisher {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        // tr(M [δ]ₓ) for a turn δ of the body.
        let m = self.parameter.tr_mul(&rotation(x));
        let by_turn = Vector3::new(
            m[(1, 2)] - m[(2, 1)],
            m[(2, 0)] - m[(0, 2)],
            m[(0, 1)] - m[(1, 0)],
        );
        gradient.copy_from_slice((by_turn * (-TEMPERATURE / RADIUS_M)).as_slice());
        -TEMPERATURE * m.trace()
    }
}

/// Mean of `f` over [a, b] by the midpoint rule.
fn mean(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    const POINTS: u32 = 4000;
    let at = |k: u32| f(a + (b - a) * (f64::from(k) + 0.5) / f64::from(POINTS));
    (0..POINTS).map(at).sum::<f64>() / f64::from(POINTS)
}

/// Modified Bessel function I₀: the mean of exp(z cos φ).
fn bessel(z: f64) -> f64 {
    // Periodic, so sixty-four points are exact to rounding for these arguments.
    (0..64)
        .map(|k| libm::exp(z * libm::cos(std::f64::consts::TAU * f64::from(k) / 64.0)))
        .sum::<f64>()
        / 64.0
}

/// Mean of the diagonal of Uᵀ R V for F = U diag(s) Vᵀ.
///
/// The normalising constant is ∫ I₀(½(sᵢ − sⱼ)(1 − u)) I₀(½(sᵢ + sⱼ)(1 + u)) exp(sₖ u) du over [−1, 1], for any order i, j,
/// k (T. Lee, IEEE Trans. Autom. Control 63, 3377 (2018), Eq. 10). Its derivative by sₖ has an additional factor u.
fn mean_diagonal(s: [f64; 3]) -> Vector3<f64> {
    Vector3::from_fn(|k, _| {
        let [i, j] = [(k + 1) % 3, (k + 2) % 3];
        let weight = |u: f64| {
            bessel(0.5 * (s[i] - s[j]) * (1.0 - u))
                * bessel(0.5 * (s[i] + s[j]) * (1.0 + u))
                * libm::exp(s[k] * u)
        };
        mean(-1.0, 1.0, |u| u * weight(u)) / mean(-1.0, 1.0, weight)
    })
}

const BINS: usize = 12;

fn chains(
    fisher: &Fisher,
    rule: Rule,
    observables: usize,
    observe: impl Fn(&State, &mut [f64]) + Sync,
) -> Seen {
    let settings = Run {
        rule,
        temperature: TEMPERATURE,
        // More than a radian: a move often goes the long way round.
        step: 1.1 * RADIUS_M,
        chains: 4,
        batches: 60,
        length: 2000,
    };
    run(
        &Mala::new(fisher),
        &[1.0, 0.0, 0.0, 0.0],
        settings,
        observables,
        observe,
    )
}

/// Singular values s (one negative) in frames that are not aligned with any axis.
fn skewed() -> (Fisher, Matrix3<f64>) {
    let turn = |a, b, c| Rotation3::from_euler_angles(a, b, c).into_inner();
    let (u, v) = (turn(0.4, -0.9, 1.3), turn(-1.1, 0.3, 0.8));
    let s = [2.0, 0.9, -0.4];
    let fisher = Fisher::new(u * Matrix3::from_diagonal(&s.into()) * v.transpose());
    (
        fisher,
        u * Matrix3::from_diagonal(&mean_diagonal(s)) * v.transpose(),
    )
}

fn deviate_of_mean(rule: Rule) -> (f64, f64) {
    let (fisher, expected) = skewed();
    let seen = chains(&fisher, rule, 9, |state, sums| {
        for (sum, entry) in sums.iter_mut().zip(&rotation(&state.coordinates)) {
            *sum += entry;
        }
    });
    (
        deviation(&seen.batches, expected.as_slice()),
        seen.acceptance,
    )
}

#[test]
fn the_gradient_is_the_derivative() {
    let (fisher, _) = skewed();
    let mut x = vec![1.0, 0.0, 0.0, 0.0];
    fisher.space.exp(&mut x, &[0.05, -0.02, 0.07]);
    let (mut gradient, mut unused) = ([0.0; 3], [0.0; 3]);
    fisher.evaluate(&x, &mut gradient);
    for k in 0..3 {
        let mut at = |h: f64| {
            let (mut tangent, mut moved) = ([0.0; 3], x.clone());
            tangent[k] = h;
            fisher.space.exp(&mut moved, &tangent);
            fisher.evaluate(&moved, &mut unused)
        };
        let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
        assert!(
            (slope - gradient[k]).abs() < 1e-6 * (1.0 + slope.abs()),
            "{k}: {slope}"
        );
    }
}

/// The constants of the law: for F = κ I the mean of R is that of (1 + 2 cos θ)/3 under (1 − cos θ) exp(2κ cos θ).
#[test]
fn the_expected_mean_agrees_with_the_law_of_the_angle() {
    let kappa = 0.8;
    let weight = |angle: f64| (1.0 - libm::cos(angle)) * libm::exp(2.0 * kappa * libm::cos(angle));
    let pi = std::f64::consts::PI;
    let cosine = mean(0.0, pi, |a| libm::cos(a) * weight(a)) / mean(0.0, pi, weight);
    let diagonal = mean_diagonal([kappa; 3]);
    assert!((diagonal - Vector3::repeat((1.0 + 2.0 * cosine) / 3.0)).norm() < 1e-6);
}

#[test]
fn rotations_have_the_mean_of_their_law() {
    let (deviate, acceptance) = deviate_of_mean(Rule::Exact);
    assert!((0.3..0.8).contains(&acceptance), "{acceptance}");
    assert!(deviate < CHANCE, "{deviate}");
}

#[test]
fn wrong_ratios_are_found_out() {
    for rule in [Rule::Plain, Rule::Always] {
        let (deviate, _) = deviate_of_mean(rule);
        assert!(deviate > WRONG, "{rule:?}: {deviate}");
    }
}

/// exp(2κ cos θ): the whole distribution of the angle, which counts volumes of the group and not of rotation vectors.
#[test]
fn angles_have_their_law() {
    let kappa = 0.8;
    let fisher = Fisher::new(Matrix3::identity() * kappa);
    let pi = std::f64::consts::PI;
    let deviate = |volume: &dyn Fn(f64) -> f64| {
        let density = |angle: f64| volume(angle) * libm::exp(2.0 * kappa * libm::cos(angle));
        let edges = quantiles(0.0, pi, BINS.try_into().unwrap(), density);
        let seen = chains(&fisher, Rule::Exact, BINS - 1, |state, sums| {
            let x = &state.coordinates;
            let angle = 2.0 * libm::atan2(libm::hypot(libm::hypot(x[1], x[2]), x[3]), x[0].abs());
            count(angle, &edges, sums);
        });
        deviation(&seen.batches, &[1.0 / BINS as f64; BINS - 1])
    };
    let right = deviate(&|angle| 1.0 - libm::cos(angle));
    assert!(right < CHANCE, "{right}");
    let wrong = deviate(&|angle| angle * angle);
    assert!(wrong > WRONG, "{wrong}");
}
