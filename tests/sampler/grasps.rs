//! A hand that moves together with its contact sets, in a case whose distribution can be summed.
//!
//! All contact candidates lie on one rigid link and the object is a ball. The pose therefore matters only through the
//! position v of the ball's centre in that link's frame and the angle of the joint that carries the link. Poses with the
//! same v and angle have equal probability, and equal volumes of v do too (the measures of translations and rotations are
//! invariant):
//!
//! ```text
//! p(S, v, q) ∝ exp(−E(S, v)/T) exp(−E(q)/T),   S: three of six points
//! ```

use std::sync::Arc;

use landscape::energy::{Energy, Piecewise};
use landscape::grasp::energy::Candidates;
use landscape::grasp::synthesis::ContactMoves;
use landscape::grasp::{EnergySettings, GraspEnergy, GraspKernel};
use landscape::hand::{Hand, HandFiles, PosedHand, SurfacePoint};
use landscape::object::Object;
use landscape::sample::{Kernel, Rng, State, TargetDensity, Task, stream};
use landscape::space::Space;
use nalgebra::Vector3;
use rand::RngExt;

use crate::chain::{Rule, Run, Seen, run};
use crate::contacts::{propose_contact, sets};
use crate::statistics::{count, deviation, quantiles};
use crate::{CHANCE, WRONG};

const TEMPERATURE: f64 = 0.1;
const POINTS: usize = 6;
const CONTACTS: usize = 3;
const SETS: usize = 20;
const BALL_M: f64 = 0.035;
const ROUNDING_M: f64 = 0.004;
/// Half the side of the cube of positions v, metres. Farther away three contacts would cost twenty temperatures.
const HALF_M: f64 = 0.16;

/// A palm and one thick finger; six contact candidates spread over the finger.
fn hand() -> Hand {
    let link = |name: &str, length: f64, radius: f64| {
        format!(
            r#"<link name="{name}"><collision><origin xyz="0 0 {}"/><geometry>
               <capsule radius="{radius}" length="{length}"/></geometry></collision></link>"#,
            0.5 * length
        )
    };
    let text = format!(
        r#"<robot name="one_finger">{}{}<joint name="knuckle" type="revolute"><parent link="palm"/><child link="finger"/>
           <origin xyz="0.01 0.02 0.05" rpy="0.3 0.2 -0.4"/><axis xyz="0.6 0.8 0"/>
           <limit lower="-0.9" upper="0.7" effort="1" velocity="1"/></joint></robot>"#,
        link("palm", 0.03, 0.03),
        link("finger", 0.05, 0.02)
    );
    let mut hand = Hand::from_files(&HandFiles::of_texts([["hand", &text]])).unwrap();
    let finger = hand.link("finger").unwrap();
    let of_palm = hand.surface.iter().filter(|p| p.link != finger).step_by(20);
    let of_finger: Vec<SurfacePoint> = hand
        .surface
        .iter()
        .filter(|p| p.link == finger)
        .copied()
        .collect();
    // Farthest first.
    let mut chosen = vec![of_finger[0]];
    while chosen.len() < POINTS {
        let away = |p: &SurfacePoint| {
            let distances = chosen.iter().map(|c| (c.point - p.point).norm());
            distances.fold(f64::INFINITY, f64::min)
        };
        let next = of_finger
            .iter()
            .max_by(|a, b| away(a).total_cmp(&away(b)))
            .unwrap();
        chosen.push(*next);
    }
    hand.surface = of_palm.copied().chain(chosen).collect();
    // Finds the points of each link anew.
    hand.thinned(1)
}

fn energy() -> GraspEnergy {
    let object = Object::named("ball").unwrap();
    let settings = EnergySettings {
        contacts: CONTACTS,
        candidates: Candidates::Fingertips,
        force_closure_weight: 0.4,
        force_closure_rounding: 0.3,
        // One temperature every 6 mm.
        distance_weight: TEMPERATURE * object.radius_m / 0.006,
        distance_rounding_m: ROUNDING_M,
        penetration_weight: 0.0,
        intrusion_weight: 0.0,
        self_penetration_weight: 0.0,
        joint_limits_weight: 1.0,
        joint_limits_rounding_rad: 0.3,
        prior_weight: 0.1,
        ..EnergySettings::four_points()
    };
    GraspEnergy::new(Arc::new(hand()), Arc::new(object), settings).unwrap()
}

/// The contact candidates, in the frame of their link.
fn candidates(energy: &GraspEnergy) -> Vec<Vector3<f64>> {
    let surface = &energy.hand().surface;
    energy
        .contact_candidates()
        .iter()
        .map(|&i| surface[i as usize].point)
        .collect()
}

/// Position of the ball's centre in the frame of the finger.
fn centre(energy: &GraspEnergy, x: &[f64]) -> Vector3<f64> {
    let mut posed = PosedHand::default();
    energy.hand().pose(x, &mut posed);
    let finger = energy.hand().link("finger").unwrap();
    posed.object_from_link[finger.0].inverse_point(&energy.object().centroid)
}

/// Costs and inward normals of the single candidates with the ball at `v`.
fn contacts(
    energy: &GraspEnergy,
    candidates: &[Vector3<f64>],
    v: &Vector3<f64>,
) -> Vec<(f64, Vector3<f64>)> {
    let weight = energy.settings().distance_weight / energy.unit_m();
    let contact = |point: &Vector3<f64>| {
        let from = point - v;
        let distance_m = from.norm() - BALL_M;
        let cost = weight * (libm::hypot(distance_m, ROUNDING_M) - ROUNDING_M);
        (cost, -from.normalize())
    };
    candidates.iter().map(contact).collect()
}

/// E(S, v): distances and ‖Gc‖. Normals pass through the centre, so there is no torque.
fn contact_energy(energy: &GraspEnergy, contacts: &[(f64, Vector3<f64>)], set: &[u32]) -> f64 {
    let members = || set.iter().map(|&i| contacts[i as usize]);
    let own: f64 = members().map(|(cost, _)| cost).sum();
    let net: Vector3<f64> = members().map(|(_, normal)| normal).sum();
    let rounding = energy.settings().force_closure_rounding;
    own + energy.settings().force_closure_weight * (libm::hypot(net.norm(), rounding) - rounding)
}

/// Number of observables of (S, v): the shares of all sets but one, mean and second moments of v (in units of a
/// centimetre), and the energy in units of the temperature.
const OBSERVABLES: usize = SETS - 1 + 3 + 6 + 1;

fn observables(set: usize, v: &Vector3<f64>, energy: f64) -> [f64; OBSERVABLES] {
    let mut values = [0.0; OBSERVABLES];
    if set < SETS - 1 {
        values[set] = 1.0;
    }
    let v = v * 100.0;
    let products = [
        v.x * v.x,
        v.y * v.y,
        v.z * v.z,
        v.x * v.y,
        v.y * v.z,
        v.z * v.x,
    ];
    let rest = v
        .iter()
        .chain(&products)
        .copied()
        .chain([energy / TEMPERATURE]);
    for (value, number) in values[SETS - 1..].iter_mut().zip(rest) {
        *value = number;
    }
    values
}

/// Expectations by summation over all sets and a grid of v with `steps` steps to either side of the centre of the points.
fn expectations(energy: &GraspEnergy, steps: i32) -> [f64; OBSERVABLES] {
    let candidates = candidates(energy);
    let sets = sets(6, CONTACTS);
    let (mut sums, mut total) = ([0.0; OBSERVABLES], 0.0);
    let middle = candidates.iter().sum::<Vector3<f64>>() / POINTS as f64;
    let place = |k: i32| HALF_M * (f64::from(k) + 0.5) / f64::from(steps);
    for i in -steps..steps {
        for j in -steps..steps {
            for k in -steps..steps {
                let v = middle + Vector3::new(place(i), place(j), place(k));
                let contacts = contacts(energy, &candidates, &v);
                let mut costs: Vec<f64> = contacts.iter().map(|(cost, _)| *cost).collect();
                costs.sort_by(f64::total_cmp);
                if costs[..CONTACTS].iter().sum::<f64>() > 20.0 * TEMPERATURE {
                    continue;
                }
                for (number, set) in sets.iter().enumerate() {
                    let cost = contact_energy(energy, &contacts, set);
                    let weight = libm::exp(-cost / TEMPERATURE);
                    total += weight;
                    for (sum, value) in sums.iter_mut().zip(observables(number, &v, cost)) {
                        *sum += weight * value;
                    }
                }
            }
        }
    }
    sums.map(|sum| sum / total)
}

/// Energy of the joint alone.
fn joint_energy(energy: &GraspEnergy, angle: f64) -> f64 {
    let hand = energy.hand();
    let [lower, upper] = hand.joints[0].limits_rad;
    let prior = &hand.prior;
    let rounding = energy.settings().joint_limits_rounding_rad;
    let hinge = |s: f64| match s {
        s if s <= 0.0 => 0.0,
        s if s < rounding => 0.5 * s * s / rounding,
        s => s - 0.5 * rounding,
    };
    0.5 * energy.settings().prior_weight * prior.precision[0] * (angle - prior.rest_rad[0]).powi(2)
        + energy.settings().joint_limits_weight
            * (hinge(angle - upper + rounding) + hinge(lower - angle + rounding))
}

/// Both kinds of moves, with equal probability.
struct Mixed<'a> {
    kernel: GraspKernel<'a>,
    moves: ContactMoves,
}

impl Kernel for Mixed<'_> {
    fn space(&self) -> &dyn Space {
        self.kernel.space()
    }

    fn start(&self, x: &[f64]) -> State {
        self.kernel.start(x)
    }

    fn propose(
        &self,
        state: &State,
        law: &TargetDensity<'_>,
        step: f64,
        rng: &mut Rng,
        proposal: &mut State,
    ) -> f64 {
        if rng.random::<f64>() < 0.5 {
            propose_contact(&self.kernel, self.moves, state, law, rng, proposal)
        } else {
            self.kernel.move_pose(state, law, step, rng, proposal)
        }
    }
}

const BINS: usize = 8;

fn start(energy: &GraspEnergy) -> Vec<f64> {
    let mut x = energy.hand().rest_coordinates();
    x[2] -= 0.05;
    x
}

fn chains(energy: &GraspEnergy, kernel: &dyn Kernel, rule: Rule) -> Seen {
    let sets = sets(6, CONTACTS);
    let first = energy.contact_candidates()[0];
    let edges = quantiles(-3.0, 3.0, BINS.try_into().unwrap(), |q| {
        libm::exp(-joint_energy(energy, q) / TEMPERATURE)
    });
    let settings = Run {
        rule,
        temperature: TEMPERATURE,
        step: 0.012,
        chains: 4,
        batches: 60,
        length: 1500,
    };
    let candidates = candidates(energy);
    run(
        kernel,
        &start(energy),
        settings,
        OBSERVABLES + BINS - 1,
        |state, sums| {
            let mut set: Vec<u32> = state.discrete.iter().map(|i| i - first).collect();
            set.sort_unstable();
            let number = sets.binary_search(&set).expect("every set is listed");
            let v = centre(energy, &state.coordinates);
            let cost = contact_energy(energy, &contacts(energy, &candidates, &v), &set);
            for (sum, value) in sums.iter_mut().zip(observables(number, &v, cost)) {
                *sum += value;
            }
            count(state.coordinates[7], &edges, &mut sums[OBSERVABLES..]);
        },
    )
}

/// Deviations for contact sets and ball, and for the distribution of the joint's angle; and the acceptance.
fn deviates(energy: &GraspEnergy, expected: &[f64], kernel: &dyn Kernel, rule: Rule) -> [f64; 3] {
    let seen = chains(energy, kernel, rule);
    let part = |from: usize, to: usize| -> Vec<Vec<f64>> {
        seen.batches
            .iter()
            .map(|batch| batch[from..to].to_vec())
            .collect()
    };
    [
        deviation(&part(0, OBSERVABLES), expected),
        deviation(
            &part(OBSERVABLES, OBSERVABLES + BINS - 1),
            &[1.0 / BINS as f64; BINS - 1],
        ),
        seen.acceptance,
    ]
}

#[test]
fn poses_and_contact_sets_have_their_joint_law() {
    let energy = energy();
    let expected = expectations(&energy, 54);
    let coarser = expectations(&energy, 40);
    for (fine, coarse) in expected.iter().zip(&coarser) {
        assert!(
            (fine - coarse).abs() < 2e-4 * (1.0 + fine.abs()),
            "{fine} {coarse}"
        );
    }
    let mixed = |moves| Mixed {
        kernel: GraspKernel::new(&energy),
        moves,
    };
    // The library's own mixture: a contact move in every fifth step.
    let kernel = GraspKernel::new(&energy);
    let [both, joint, acceptance] = deviates(&energy, &expected, &kernel, Rule::Exact);
    assert!(
        both < CHANCE && joint < CHANCE,
        "{both} {joint} {acceptance}"
    );
    let uniform = mixed(ContactMoves::Uniform);
    let [both, joint, acceptance] = deviates(&energy, &expected, &uniform, Rule::Exact);
    assert!(
        both < CHANCE && joint < CHANCE,
        "{both} {joint} {acceptance}"
    );

    let bath = mixed(ContactMoves::HeatBath);
    for (kernel, rule) in [
        (&bath, Rule::Plain),
        (&bath, Rule::Always),
        (&uniform, Rule::Plain),
    ] {
        let [both, ..] = deviates(&energy, &expected, kernel, rule);
        assert!(both > WRONG, "{rule:?} {both}");
    }
}

/// The sums of this file are the energy, up to what is the same for all sets and poses.
#[test]
fn the_energy_depends_on_the_place_of_the_ball_and_the_angle() {
    let energy = energy();
    let first = energy.contact_candidates()[0];
    assert_eq!(energy.contact_candidates().len(), POINTS);
    let candidates = candidates(&energy);
    let mut rng = stream(1, Task::Start, 0);
    let mut x = start(&energy);
    let mut unused = vec![0.0; energy.space().tangents()];
    for _ in 0..200 {
        let tangent: Vec<f64> = unused
            .iter()
            .map(|_| rng.random_range(-0.02..0.02))
            .collect();
        energy.space().exp(&mut x, &tangent);
        x[7] = rng.random_range(-1.5..1.5);
        let contacts = contacts(&energy, &candidates, &centre(&energy, &x));
        for set in sets(6, CONTACTS) {
            let indices: Vec<u32> = set.iter().map(|i| i + first).collect();
            let whole = energy.evaluate_piece(&x, &indices, &mut unused);
            let parts = contact_energy(&energy, &contacts, &set) + joint_energy(&energy, x[7]);
            // The mesh's centroid is that of the ball up to the mesh's own accuracy.
            assert!((whole - parts).abs() < 1e-5, "{whole} {parts}");
        }
    }
}
