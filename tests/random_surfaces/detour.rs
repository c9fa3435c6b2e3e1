//! A detour in the poses of a hand: two minima whose straight line crosses a high ridge, and a long valley around it through
//! minima that the map is not given.

use std::f64::consts::{PI, TAU};

use landscape::energy::{Energy, check_gradient};
use landscape::hand::Hand;
use landscape::sample::{Mala, Rng, Task, stream};
use landscape::space::{PoseSpace, Space, Symmetry};
use landscape::topography::{MapSettings, Minimum, Run, build_landscape};
use rand::RngExt;

use super::planted::Judged;

/// Stiffness across the valley and of all coordinates beside its plane.
const STIFFNESS: f64 = 20.0;

/// Height of the ridge on the short way; those on the long way are about 1 high.
const RIDGE: f64 = 3.0;

/// Metres in a unit of the plane.
const UNIT_M: f64 = 0.05;

/// Radians in a unit of the plane.
const UNIT_RAD: f64 = 0.5;

/// A ring of four wells in a plane, bent into the poses of a hand.
///
/// ```text
/// E = W(u, v) + s/2 Σ zᵢ² + s (1 − q_w²),   W = s (ρ² − 1)² + ρ² (2 − ρ²) V(φ),   V = A(φ) (1 + cos 4φ)/2
/// A(φ) = 1 + (H − 1) exp(4 (cos(φ − π) − 1))
/// ```
///
/// ρ, φ: polar coordinates of (u, v). u: the first coordinate of the centroid; v: the second and a wave of u; zᵢ: each of
/// the others, a joint or the third coordinate, and a wave of u; q: the rotation of the hand. The map from the pose to these is
/// one to one, and on the ring ρ = 1 the slopes across it vanish, so that minima and passes of E are those of V.
struct Ring {
    space: PoseSpace,
    /// Height a, wave number k and phase of the wave in each coordinate but the first: the rest of the centroid, then joints.
    bends: Vec<[f64; 3]>,
}

/// V and its derivative.
fn around(phi: f64) -> (f64, f64) {
    let (sine, cosine) = libm::sincos(phi - PI);
    let bump = (RIDGE - 1.0) * libm::exp(4.0 * (cosine - 1.0));
    let (sine4, cosine4) = libm::sincos(4.0 * phi);
    let wave = f64::midpoint(1.0, cosine4);
    (
        (1.0 + bump) * wave,
        -4.0 * sine * bump * wave - 2.0 * (1.0 + bump) * sine4,
    )
}

impl Ring {
    fn random(rng: &mut Rng) -> Self {
        let metric = Hand::human().pose_metric();
        let bends = (0..metric.joint_levers_m.len() + 2).map(|_| {
            let height = 0.3 * rng.random::<f64>();
            [
                height,
                rng.random_range(0.5..2.0),
                rng.random_range(0.0..TAU),
            ]
        });
        Self {
            bends: bends.collect(),
            space: PoseSpace::new(metric, Symmetry::None),
        }
    }

    fn wave(&self, coordinate: usize, u: f64) -> (f64, f64) {
        let [a, k, phase] = self.bends[coordinate];
        let (sine, cosine) = libm::sincos(k * u + phase);
        (a * sine, a * k * cosine)
    }

    /// Place of v among the coordinates with waves.
    const SECOND: usize = 0;

    /// The pose at the place φ of the ring.
    fn pose(&self, phi: f64) -> Vec<f64> {
        let (v, u) = libm::sincos(phi);
        let level = |coordinate: usize| {
            let base = if coordinate == Self::SECOND { v } else { 0.0 };
            base - self.wave(coordinate, u).0
        };
        let centre = self.space.metric().centroid;
        let mut x = vec![
            UNIT_M * u - centre.x,
            UNIT_M * level(0) - centre.y,
            UNIT_M * level(1) - centre.z,
            1.0,
            0.0,
            0.0,
            0.0,
        ];
        x.extend((2..self.bends.len()).map(|coordinate| UNIT_RAD * level(coordinate)));
        x
    }

    /// The minima of the map: both sides of the ridge.
    fn minima(&self) -> Vec<Minimum> {
        let minima = [0.75 * PI, -0.75 * PI].map(|phi| {
            let start = Minimum {
                coordinates: self.pose(phi),
                energy: 0.0,
                members: Vec::new(),
            };
            assert!(
                self.evaluate(&start.coordinates, &mut vec![0.0; self.space.tangents()]) < 1e-9
            );
            start
        });
        minima.to_vec()
    }
}

impl Energy for Ring {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let metric = self.space.metric();
        let quaternion = nalgebra::Quaternion::new(x[3], x[4], x[5], x[6]);
        let rotation = nalgebra::UnitQuaternion::new_normalize(quaternion);
        let centroid = nalgebra::Vector3::new(x[0], x[1], x[2]) + rotation * metric.centroid;
        let u = centroid.x / UNIT_M;
        let levels = [centroid.y / UNIT_M, centroid.z / UNIT_M];
        let joints = x[7..].iter().map(|angle| angle / UNIT_RAD);
        let levels: Vec<f64> = levels.into_iter().chain(joints).collect();

        let mut slopes = vec![0.0; levels.len()];
        let mut energy = 0.0;
        let (mut v, mut along_u) = (0.0, 0.0);
        for (coordinate, level) in levels.iter().enumerate() {
            let (wave, slope) = self.wave(coordinate, u);
            let z = level + wave;
            if coordinate == Self::SECOND {
                v = z;
                continue;
            }
            energy += 0.5 * STIFFNESS * z * z;
            slopes[coordinate] = STIFFNESS * z;
            along_u += STIFFNESS * z * slope;
        }
        let (square, phi) = (u * u + v * v, libm::atan2(v, u));
        let (well, turn) = around(phi);
        energy += STIFFNESS * (square - 1.0).powi(2) + square * (2.0 - square) * well;
        // Slope along the square of ρ, and along φ over the square of ρ.
        let outward = 2.0 * STIFFNESS * (square - 1.0) + (2.0 - 2.0 * square) * well;
        let across = (2.0 - square) * turn;
        let (of_u, of_v) = (
            2.0 * u * outward - v * across,
            2.0 * v * outward + u * across,
        );
        slopes[Self::SECOND] = of_v;
        along_u += of_u + of_v * self.wave(Self::SECOND, u).1;

        let w = rotation.w;
        energy += STIFFNESS * (1.0 - w * w);
        gradient[0] = along_u / UNIT_M;
        gradient[1] = slopes[0] / UNIT_M;
        gradient[2] = slopes[1] / UNIT_M;
        for (axis, slope) in rotation.imag().iter().enumerate() {
            gradient[3 + axis] = STIFFNESS * w * slope / metric.radius_of_gyration_m;
        }
        for (joint, lever) in metric.joint_levers_m.iter().enumerate() {
            gradient[6 + joint] = slopes[2 + joint] / UNIT_RAD / lever;
        }
        energy
    }
}

/// The merge of the two minima on ring `id`.
pub(super) fn judged(id: u64) -> Vec<Judged> {
    let energy = Ring::random(&mut stream(77, Task::Surface, id));
    let minima = energy.minima();
    let settings = MapSettings {
        seed: id,
        ..MapSettings::for_minima(&energy, &minima)
    };
    let map = build_landscape(
        &energy,
        &Mala::new(&energy),
        minima,
        &settings,
        &Run::default(),
    )
    .unwrap();
    // The highest pass of the long way, by a fine scan.
    let scan = (0..=10_000).map(|k| around(f64::from(k) * 0.75e-4 * PI).0);
    let known = scan.fold(0.0, f64::max);
    assert!(known > 1.0 && known < 1.2, "{known}");
    let top = map.tree.nodes.last().unwrap();
    let searched = map.attempts.of_merges(&map.tree);
    let searched = searched.last().unwrap().unwrap();
    println!(
        "ring {id}: {:.3} (known {known:.3}), {} of {} searches ended there",
        top.energy, searched.ended_here, searched.searches
    );
    assert!(top.energy > known - 1e-3, "below the tree");
    vec![Judged {
        lower: searched.lower,
        uncertainty: searched.uncertainty,
        above: top.energy - known,
    }]
}

#[test]
fn its_gradient_is_that_of_its_energy() {
    let mut rng = stream(5, Task::Surface, 0);
    let ring = Ring::random(&mut rng);
    let points: Vec<Vec<f64>> = (0..20)
        .map(|k| {
            let mut x = ring.pose(f64::from(k));
            let step: Vec<f64> = (0..ring.space.tangents())
                .map(|_| rng.random_range(-0.01..0.01))
                .collect();
            ring.space.exp(&mut x, &step);
            x
        })
        .collect();
    check_gradient(&ring, &points, 1e-6).unwrap();
}
