//! The Metropolis-adjusted Langevin kernel for any energy.

use std::fmt;

use super::{Kernel, Rng, State, TargetDensity, langevin};
use crate::energy::Energy;
use crate::space::Space;

/// Preconditioned Langevin steps with the exact Metropolis–Hastings correction: see [`langevin`].
///
/// # Examples
/// A proposal from a minimum of the Müller–Brown surface.
///
/// ```
/// use landscape::energy::model::MullerBrown;
/// use landscape::sample::{Kernel, Mala, TargetDensity, Task, stream};
///
/// let energy = MullerBrown::new();
/// let kernel = Mala::new(&energy);
/// let density = TargetDensity { temperature: 10.0, attraction: None };
/// let state = kernel.start(&[-0.558, 1.442]);
/// let mut proposal = state.clone();
/// let mut rng = stream(0, Task::Start, 0);
/// let acceptance = kernel.propose(&state, &density, 0.01, &mut rng, &mut proposal).exp();
/// assert!(acceptance > 0.0 && proposal.coordinates != state.coordinates);
/// ```
pub struct Mala<'a> {
    energy: &'a dyn Energy,
    scales: Vec<f64>,
}

impl<'a> Mala<'a> {
    /// Langevin steps on `energy`.
    pub fn new(energy: &'a dyn Energy) -> Self {
        Self {
            energy,
            scales: energy.space().step_scales(),
        }
    }
}

impl fmt::Debug for Mala<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Mala")
            .field("scales", &self.scales)
            .finish_non_exhaustive()
    }
}

impl Kernel for Mala<'_> {
    fn space(&self) -> &dyn Space {
        self.energy.space()
    }

    fn start(&self, x: &[f64]) -> State {
        let mut gradient = vec![0.0; self.space().tangents()];
        let energy = self.energy.evaluate(x, &mut gradient);
        State {
            coordinates: x.to_vec(),
            energy,
            gradient,
        }
    }

    fn propose(
        &self,
        state: &State,
        law: &TargetDensity<'_>,
        step: f64,
        rng: &mut Rng,
        proposal: &mut State,
    ) -> f64 {
        langevin(
            self.space(),
            &self.scales,
            state,
            law,
            step,
            rng,
            proposal,
            |x, gradient| self.energy.evaluate(x, gradient),
        )
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::energy::model::MullerBrown;
    use crate::sample::langevin::pull;
    use crate::sample::{Attraction, Task, stream};
    use crate::space::Euclidean;

    /// ½ xᵀ K x with stiffnesses 1 and 25, in a space that says so.
    struct Bowl;

    impl Space for Bowl {
        fn coordinates(&self) -> usize {
            2
        }
        fn tangents(&self) -> usize {
            2
        }
        fn exp(&self, x: &mut [f64], tangent: &[f64]) {
            Euclidean::new(2).exp(x, tangent);
        }
        fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
            Euclidean::new(2).log(a, b, tangent)
        }
        fn step_scales(&self) -> Vec<f64> {
            vec![1.0, 0.2]
        }
    }

    impl Energy for Bowl {
        fn space(&self) -> &dyn Space {
            self
        }
        fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
            gradient.copy_from_slice(&[x[0], 25.0 * x[1]]);
            0.5 * (x[0] * x[0] + 25.0 * x[1] * x[1])
        }
    }

    /// (x² − 1)² in one dimension.
    struct Double(Euclidean);

    impl Energy for Double {
        fn space(&self) -> &dyn Space {
            &self.0
        }
        fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
            let well = x[0] * x[0] - 1.0;
            gradient[0] = 4.0 * x[0] * well;
            well * well
        }
    }

    /// Means of `observe` along a chain.
    fn averages<const N: usize>(
        energy: &dyn Energy,
        start: &[f64],
        law: &TargetDensity<'_>,
        step: f64,
        observe: impl Fn(&[f64]) -> [f64; N],
    ) -> [f64; N] {
        let kernel = Mala::new(energy);
        let mut rng = stream(7, Task::AttractionDiffusion, 0);
        let mut state = kernel.start(start);
        let mut proposal = State::default();
        let (mut sums, steps) = ([0.0; N], 400_000);
        for _ in 0..steps {
            let ratio = kernel.propose(&state, law, step, &mut rng, &mut proposal);
            if libm::log(rng.random::<f64>()) < ratio {
                std::mem::swap(&mut state, &mut proposal);
            }
            for (sum, value) in sums.iter_mut().zip(observe(&state.coordinates)) {
                *sum += value / f64::from(steps);
            }
        }
        sums
    }

    #[test]
    fn gaussian_moments() {
        let law = TargetDensity {
            temperature: 0.5,
            attraction: None,
        };
        let [mean, soft, stiff, fourth] = averages(&Bowl, &[1.0, 0.0], &law, 0.9, |x| {
            [x[0], x[0] * x[0], x[1] * x[1], x[0].powi(4)]
        });
        // ⟨x²⟩ = T/K, ⟨x⁴⟩ = 3 (T/K)²; the chain decorrelates in a few steps, so 400 000 of them leave about 0.5 %.
        assert!(mean.abs() < 0.01, "{mean}");
        assert!((soft - 0.5).abs() < 0.01, "{soft}");
        assert!((stiff - 0.02).abs() < 4e-4, "{stiff}");
        assert!((fourth - 0.75).abs() < 0.03, "{fourth}");
    }

    #[test]
    fn double_well_under_a_pull() {
        // A coarse step: without the correction the averages would be off by far more than the tolerance.
        let (temperature, force, target, step) = (0.5, 0.4, [1.5], 0.7);
        let law = TargetDensity {
            temperature,
            attraction: Some(Attraction {
                target: &target,
                force,
            }),
        };
        let [mean, square] = averages(&Double(Euclidean::new(1)), &[-1.0], &law, step, |x| {
            [x[0], x[0] * x[0]]
        });
        let (mut total, mut first, mut second) = (0.0, 0.0, 0.0);
        for k in -4000..4000 {
            let x = f64::from(k) * 1e-3;
            let potential = (x * x - 1.0).powi(2) + force * libm::hypot(x - target[0], step);
            let weight = libm::exp(-potential / temperature);
            total += weight;
            first += weight * x;
            second += weight * x * x;
        }
        assert!((mean - first / total).abs() < 0.02, "{mean}");
        assert!((square - second / total).abs() < 0.02, "{square}");
    }

    #[test]
    fn acceptance_ratio_balances() {
        // π(x) q(x → x') a(x → x') = π(x') q(x' → x) a(x' → x): the ratio of the way back is the negated one.
        let energy = MullerBrown::new();
        let (kernel, target) = (Mala::new(&energy), [0.6, 0.0]);
        let law = TargetDensity {
            temperature: 20.0,
            attraction: Some(Attraction {
                target: &target,
                force: 100.0,
            }),
        };
        let (step, mut proposal) = (0.05, State::default());
        let mut rng = stream(3, Task::AttractionDiffusion, 1);
        let state = kernel.start(&[-0.3, 0.9]);
        for _ in 0..20 {
            let ratio = kernel.propose(&state, &law, step, &mut rng, &mut proposal);
            let density = |from: &State, to: &State| {
                let mut slope = from.gradient.clone();
                let bias = pull(
                    &Euclidean::new(2),
                    &law,
                    &from.coordinates,
                    step,
                    &mut slope,
                );
                let mut exponent = -(from.energy + bias) / law.temperature;
                for (k, g) in slope.iter().enumerate() {
                    let u = to.coordinates[k] - from.coordinates[k];
                    let mean = -0.5 * step * step * g / law.temperature;
                    exponent -= (u - mean).powi(2) / (2.0 * step * step);
                }
                exponent
            };
            let expected = density(&proposal, &state) - density(&state, &proposal);
            assert!((ratio - expected).abs() < 1e-9 * (1.0 + expected.abs()));
        }
    }
}
