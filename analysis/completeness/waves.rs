//! A rugged surface: random waves on a torus.

use std::f64::consts::TAU;

use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use landscape::energy::Energy;
use landscape::space::{Space, Torus};

/// A sum of random waves of angles: smooth, periodic, and with any desired number of minima.
///
/// ```text
/// V(θ) = Σ_k a_k cos(k · θ + φ_k),   a_k ~ N(0, 1) / |k|,   φ_k ~ U(0, 2π)
/// ```
///
/// θ: angles in radians; k: nonzero integer wave vectors, drawn uniformly from those with components up to a number of
/// modes. Its minima are known only from a fine grid.
#[derive(Debug, Clone)]
pub(crate) struct Waves {
    space: Torus,
    waves: Vec<Wave>,
}

#[derive(Debug, Clone)]
struct Wave {
    vector: Vec<f64>,
    amplitude: f64,
    phase: f64,
}

impl Waves {
    /// A sum of `count` waves of `angles` angles, with components of k up to `modes`.
    ///
    /// # Panics
    /// If there are no angles or no modes.
    pub(crate) fn random(angles: usize, modes: u8, count: usize, rng: &mut impl Rng) -> Self {
        assert!(angles > 0 && modes > 0, "a wave needs a direction");
        let modes = i32::from(modes);
        let waves = (0..count).map(|_| {
            let vector = loop {
                let vector: Vec<f64> = (0..angles)
                    .map(|_| f64::from(rng.random_range(-modes..=modes)))
                    .collect();
                if vector.iter().any(|component| *component != 0.0) {
                    break vector;
                }
            };
            let normal: f64 = StandardNormal.sample(rng);
            Wave {
                amplitude: normal / vector.iter().map(|k| k * k).sum::<f64>().sqrt(),
                phase: rng.random_range(0.0..TAU),
                vector,
            }
        });
        Self {
            waves: waves.collect(),
            space: Torus::new(angles),
        }
    }
}

impl Energy for Waves {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let angles = self.space.coordinates();
        assert_eq!((x.len(), gradient.len()), (angles, angles));
        gradient.fill(0.0);
        let mut energy = 0.0;
        for wave in &self.waves {
            let phase = wave.vector.iter().zip(x).map(|(k, x)| k * x).sum::<f64>() + wave.phase;
            let (sine, cosine) = libm::sincos(phase);
            energy += wave.amplitude * cosine;
            for (slope, k) in gradient.iter_mut().zip(&wave.vector) {
                *slope -= wave.amplitude * k * sine;
            }
        }
        if energy.is_finite() {
            energy
        } else {
            f64::INFINITY
        }
    }
}
