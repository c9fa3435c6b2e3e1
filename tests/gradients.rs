//! Every energy of the crate: its gradient equals the central difference along the tangents of its space.

use landscape::energy::model::{
    DoubleWell, LennardJones, MullerBrown, Orientation, ThreeHole, Torsion,
};
use landscape::energy::{Energy, InBox};
use landscape::sample::{Rng, Task, stream};
use rand::RngExt;

use crate::waves::Waves;

/// Draws a point at which the energy is finite and smooth.
type Sampler = fn(&mut Rng) -> Vec<f64>;

/// The list of all tested energies.
fn energies() -> Vec<(&'static str, Box<dyn Energy>, Sampler)> {
    vec![
        ("Müller–Brown", Box::new(MullerBrown::new()), |rng| {
            vec![rng.random_range(-1.5..1.2), rng.random_range(-0.2..2.0)]
        }),
        ("three-hole", Box::new(ThreeHole::new()), |rng| {
            uniform(rng, 2, 2.0)
        }),
        ("double well", Box::new(DoubleWell::new(4)), |rng| {
            uniform(rng, 4, 1.5)
        }),
        (
            "tilted double well",
            Box::new(DoubleWell::new(3).with_tilt(0.4)),
            |rng| uniform(rng, 3, 1.5),
        ),
        (
            "torsion",
            Box::new(Torsion::new(&[(1.0, 3), (0.3, 2)])),
            |rng| uniform(rng, 2, 3.0),
        ),
        (
            "in a box",
            Box::new(InBox::new(&[-1.0, 0.5], &[2.0, 1.0], |x, gradient| {
                gradient[0] = 2.0 * x[0] * x[1];
                gradient[1] = x[0] * x[0] + libm::exp(x[1]);
                x[0] * x[0] * x[1] + libm::exp(x[1])
            })),
            |rng| uniform(rng, 2, 5.0),
        ),
        (
            "waves",
            Box::new(Waves::random(3, 2, 20, &mut stream(1, Task::Surface, 0))),
            |rng| uniform(rng, 3, 3.0),
        ),
        (
            "orientation",
            Box::new(Orientation::new([1.0, 1.5, 2.0, 3.0])),
            |rng| uniform(rng, 4, 1.0),
        ),
        ("Lennard-Jones 5", Box::new(LennardJones::new(5)), |rng| {
            loose_cluster(rng, 5)
        }),
        ("Lennard-Jones 13", Box::new(LennardJones::new(13)), |rng| {
            loose_cluster(rng, 13)
        }),
    ]
}

fn uniform(rng: &mut Rng, n: usize, half_width: f64) -> Vec<f64> {
    (0..n)
        .map(|_| rng.random_range(-half_width..half_width))
        .collect()
}

/// Atoms in a ball, no two nearer than 0.85.
fn loose_cluster(rng: &mut Rng, atoms: usize) -> Vec<f64> {
    let half_width = libm::cbrt(atoms as f64);
    let mut x: Vec<f64> = Vec::new();
    while x.len() < 3 * atoms {
        let atom = uniform(rng, 3, half_width);
        let apart = |other: &[f64]| {
            other
                .iter()
                .zip(&atom)
                .map(|(p, q)| (p - q).powi(2))
                .sum::<f64>()
                > 0.85_f64.powi(2)
        };
        if x.chunks_exact(3).all(apart) {
            x.extend(atom);
        }
    }
    x
}

/// Derivative of `energy` at `x` along tangent `k` by Richardson's fourth-order central difference.
fn difference(energy: &dyn Energy, x: &[f64], k: usize, step: f64) -> f64 {
    let space = energy.space();
    let mut scratch = vec![0.0; space.tangents()];
    let mut at = |length: f64| {
        let mut tangent = vec![0.0; space.tangents()];
        tangent[k] = length;
        let mut moved = x.to_vec();
        space.exp(&mut moved, &tangent);
        energy.evaluate(&moved, &mut scratch)
    };
    (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step)
}

#[test]
fn gradients_are_central_differences() {
    for (name, energy, sample) in energies() {
        let space = energy.space();
        let scales = space.step_scales();
        let mut rng = stream(1, Task::Start, 0);
        for _ in 0..40 {
            let x = sample(&mut rng);
            assert_eq!(x.len(), space.coordinates(), "{name}");
            let mut gradient = vec![f64::NAN; space.tangents()];
            let value = energy.evaluate(&x, &mut gradient);
            assert!(value.is_finite(), "{name} at {x:?}");
            let size = gradient
                .iter()
                .fold(1.0 + value.abs(), |size, g| size.max(g.abs()));
            for (k, g) in gradient.iter().enumerate() {
                let estimate = difference(&*energy, &x, k, 2e-4 * scales[k]);
                // Rounding 1e-16/2e-4 ≈ 1e-12 of the energy and truncation (2e-4)⁴ times the fifth derivative, which is
                // below 1e7 of the gradient on all models: 1e-7 leaves room for both, and sees any wrong factor.
                let tolerance = 1e-7 * size;
                assert!(
                    (g - estimate).abs() < tolerance,
                    "{name}: ∂E/∂τ_{k} = {g}, difference {estimate}, at {x:?}"
                );
            }
        }
    }
}

/// The Hessian of an energy agrees with fourth-order central differences of its gradient.
#[test]
fn known_hessians_are_differences_of_gradients() {
    let mut known = Vec::new();
    for (name, energy, sample) in energies() {
        let space = energy.space();
        let n = space.tangents();
        let mut hessian = vec![f64::NAN; n * n];
        let mut rng = stream(3, Task::Start, 0);
        for _ in 0..40 {
            let x = sample(&mut rng);
            if !energy.hessian(&x, &mut hessian) {
                assert!(!known.contains(&name), "{name} only sometimes knows it");
                continue;
            }
            if !known.contains(&name) {
                known.push(name);
            }
            let mut gradient = vec![0.0; n];
            let value = energy.evaluate(&x, &mut gradient);
            let size = hessian
                .iter()
                .fold(1.0 + value.abs(), |size, h| size.max(h.abs()));
            for (k, row) in hessian.chunks_exact(n).enumerate() {
                let mut at = |length: f64| {
                    let mut tangent = vec![0.0; n];
                    tangent[k] = length;
                    let mut moved = x.clone();
                    space.exp(&mut moved, &tangent);
                    energy.evaluate(&moved, &mut gradient);
                    gradient.clone()
                };
                let [ahead, behind, far, back] = [1.0, -1.0, 2.0, -2.0].map(|k| at(k * 2e-4));
                for (j, entry) in row.iter().enumerate() {
                    let near = 8.0 * (ahead[j] - behind[j]);
                    let estimate = (near - (far[j] - back[j])) / (12.0 * 2e-4);
                    assert!(
                        (entry - estimate).abs() < 1e-7 * size,
                        "{name}: entry {k}, {j} is {entry}, difference {estimate}, at {x:?}"
                    );
                }
            }
        }
    }
    assert_eq!(
        known,
        ["Müller–Brown", "Lennard-Jones 5", "Lennard-Jones 13"]
    );
}

/// An energy is a function of x alone: another evaluation, after other points, gives the same bits.
#[test]
fn energies_have_no_memory() {
    for (name, energy, sample) in energies() {
        let mut rng = stream(2, Task::Start, 0);
        let (x, other) = (sample(&mut rng), sample(&mut rng));
        let mut first = vec![0.0; energy.space().tangents()];
        let mut again = vec![f64::NAN; first.len()];
        let value = energy.evaluate(&x, &mut first);
        energy.evaluate(&other, &mut again);
        assert_eq!(
            value.to_bits(),
            energy.evaluate(&x, &mut again).to_bits(),
            "{name}"
        );
        assert_eq!(first, again, "{name}");
    }
}
