//! Random smooth periodic surfaces, and their rigid motions.

use std::f64::consts::TAU;

use landscape::energy::Energy;
use landscape::sample::{Rng, Task, stream};
use landscape::space::{Space, Torus};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

/// A random Fourier sum on the torus of two angles.
///
/// ```text
/// V(θ) = Σ_k a_k cos(k · θ + φ_k),   a_k ~ N(0, 1) / |k|,   φ_k ~ U(0, 2π)
/// ```
///
/// over half of the wave vectors k with components up to the number of modes (the other half is the same).
pub(crate) struct Surface {
    space: Torus,
    waves: Vec<Wave>,
}

struct Wave {
    k: [f64; 2],
    amplitude: f64,
    phase: f64,
}

impl Surface {
    /// Surface number `id`.
    pub(crate) fn random(modes: i32, id: u64) -> Self {
        let mut rng: Rng = stream(2026, Task::Surface, id);
        let mut waves = Vec::new();
        for k0 in 0..=modes {
            for k1 in -modes..=modes {
                if k0 == 0 && k1 <= 0 {
                    continue;
                }
                let k = [f64::from(k0), f64::from(k1)];
                let normal: f64 = StandardNormal.sample(&mut rng);
                waves.push(Wave {
                    k,
                    amplitude: normal / libm::hypot(k[0], k[1]),
                    phase: rng.random_range(0.0..TAU),
                });
            }
        }
        Self {
            space: Torus::new(2),
            waves,
        }
    }

    /// Bound of the second derivative along any direction: Σ |aₖ| |k|².
    pub(crate) fn curvature_bound(&self) -> f64 {
        let waves = self.waves.iter();
        waves
            .map(|wave| wave.amplitude.abs() * (wave.k[0] * wave.k[0] + wave.k[1] * wave.k[1]))
            .sum()
    }

    /// The energies at (2π i / n, 2π j / n) in row-major order. On the grid every wave takes only n values.
    pub(crate) fn on_grid(&self, n: usize) -> Vec<f64> {
        let mut heights = vec![0.0; n * n];
        for wave in &self.waves {
            let table: Vec<f64> = (0..n)
                .map(|m| wave.amplitude * libm::cos(TAU * m as f64 / n as f64 + wave.phase))
                .collect();
            // Whole numbers modulo n.
            let [step0, step1] = wave.k.map(|k| whole(k.rem_euclid(n as f64)));
            for (i, row) in heights.chunks_exact_mut(n).enumerate() {
                let mut m = (i * step0) % n;
                for height in row {
                    *height += table[m];
                    m += step1;
                    if m >= n {
                        m -= n;
                    }
                }
            }
        }
        heights
    }
}

impl Energy for Surface {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        gradient.fill(0.0);
        let mut energy = 0.0;
        for wave in &self.waves {
            let (sine, cosine) = libm::sincos(wave.k[0] * x[0] + wave.k[1] * x[1] + wave.phase);
            energy += wave.amplitude * cosine;
            gradient[0] -= wave.amplitude * wave.k[0] * sine;
            gradient[1] -= wave.amplitude * wave.k[1] * sine;
        }
        energy
    }
}

/// Converts a whole number to an integer.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "callers pass small whole numbers that are not negative"
)]
pub(crate) fn whole(number: f64) -> usize {
    number as usize
}
