//! A detour: two minima whose straight line crosses a high ridge, and a long valley around it through minima that the map is not
//! given.

use std::f64::consts::PI;

use landscape::energy::{Energy, check_gradient};
use landscape::sample::Mala;
use landscape::space::{Euclidean, Space};
use landscape::topography::{MapSettings, Minimum, Run, build_landscape};

use super::planted::Judged;

/// Stiffness across the valley and of all coordinates beside its plane.
const STIFFNESS: f64 = 20.0;

/// Height of the ridge on the short way; those on the long way are about 1 high.
const RIDGE: f64 = 3.0;

/// Number of coordinates.
const SIZE: usize = 8;

/// A ring of four wells in the plane of the first two coordinates.
///
/// ```text
/// E = s (ρ² − 1)² + ρ² (2 − ρ²) V(φ) + s/2 Σ zᵢ²,   V = A(φ) (1 + cos 4φ)/2,   A(φ) = 1 + (H − 1) exp(4 (cos(φ − π) − 1))
/// ```
///
/// On the ring ρ = 1 the slopes across it vanish, so that minima and passes of E are those of V.
struct Ring(Euclidean);

/// V and its derivative.
fn around(phi: f64) -> (f64, f64) {
    let (sine, cosine) = libm::sincos(phi - PI);
    let bump = (RIDGE - 1.0) * libm::exp(4.0 * (cosine - 1.0));
    let (sine4, cosine4) = libm::sincos(4.0 * phi);
    let wave = f64::midpoint(1.0, cosine4);
    let slope = -4.0 * sine * bump * wave - 2.0 * (1.0 + bump) * sine4;
    ((1.0 + bump) * wave, slope)
}

/// The point at the place φ of the ring.
fn place(phi: f64) -> Vec<f64> {
    let mut x = vec![0.0; SIZE];
    (x[1], x[0]) = libm::sincos(phi);
    x
}

impl Energy for Ring {
    fn space(&self) -> &dyn Space {
        &self.0
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let [u, v] = [x[0], x[1]];
        let (square, (well, turn)) = (u * u + v * v, around(libm::atan2(v, u)));
        // Slope along the square of ρ, and along φ over the square of ρ.
        let outward = 2.0 * STIFFNESS * (square - 1.0) + (2.0 - 2.0 * square) * well;
        let across = (2.0 - square) * turn;
        let mut energy = STIFFNESS * (square - 1.0).powi(2) + square * (2.0 - square) * well;
        for (slope, z) in gradient.iter_mut().zip(x) {
            *slope = STIFFNESS * z;
            energy += 0.5 * STIFFNESS * z * z;
        }
        energy -= 0.5 * STIFFNESS * square;
        gradient[0] = 2.0 * u * outward - v * across;
        gradient[1] = 2.0 * v * outward + u * across;
        energy
    }
}

/// The merge of the minima on both sides of the ridge, with the random numbers of a seed.
pub(super) fn judged(seed: u64) -> Vec<Judged> {
    let energy = Ring(Euclidean::new(SIZE));
    let minima = [0.75 * PI, -0.75 * PI].map(|phi| Minimum {
        coordinates: place(phi),
        energy: 0.0,
        members: Vec::new(),
    });
    let settings = MapSettings {
        seed,
        ..MapSettings::for_minima(&energy, &minima)
    };
    let kernel = Mala::new(&energy);
    let run = Run::default();
    let map = build_landscape(&energy, &kernel, minima.to_vec(), &settings, &run).unwrap();
    // The highest pass of the long way, by a fine scan.
    let scan = (0..=10_000).map(|k| around(f64::from(k) * 0.75e-4 * PI).0);
    let known = scan.fold(0.0, f64::max);
    let top = map.tree.nodes.last().unwrap();
    assert!(top.energy > known - 1e-3, "below the tree");
    let searched = map.attempts.of_merges(&map.tree);
    let searched = searched.last().unwrap().unwrap();
    vec![Judged {
        lower: searched.lower,
        uncertainty: searched.uncertainty,
        above: top.energy - known,
    }]
}

#[test]
fn its_gradient_is_that_of_its_energy() {
    let points: Vec<Vec<f64>> = (0..9)
        .map(|k| {
            let mut x = place(f64::from(k));
            for value in &mut x {
                *value = 1.1 * *value + 0.02;
            }
            x
        })
        .collect();
    check_gradient(&Ring(Euclidean::new(SIZE)), &points, 1e-6).unwrap();
}
