//! Cost of one evaluation of the grasp energy, of a contact set, of one step of a chain, and of judging a grasp.

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use landscape::energy::Energy;
use landscape::grasp::synthesis::{SynthesisSettings, synthesize};
use landscape::grasp::{EnergySettings, Grasp, GraspEnergy, GraspKernel, judge};
use landscape::hand::{Hand, HandFiles, PosedHand};
use landscape::object::Object;
use landscape::optimize::QuenchSettings;
use landscape::sample::{Kernel, State, TargetDensity, Task, stream};
use landscape::store::{GraspFile, Overrides};
use rand::RngExt;
use rayon::prelude::*;

/// The energy of a hand on the round bottle.
fn energy(hand: Hand, settings: EnergySettings) -> GraspEnergy {
    let object = Object::named("bottle_round").expect("the bottle comes with the crate");
    GraspEnergy::new(Arc::new(hand), Arc::new(object), settings).expect("the settings make sense")
}

/// A walk of small steps around a synthesized grasp, as in a descent or a chain.
fn walk(energy: &GraspEnergy, step_m: f64) -> (Vec<u32>, Vec<Vec<f64>>) {
    let settings = SynthesisSettings::default();
    let grasp = synthesize(energy, &settings, &QuenchSettings::default(), 1, 0);
    let points = around(energy, &grasp.refined, step_m);
    (grasp.refined.contacts, points)
}

/// Random poses near that of a grasp.
fn around(energy: &GraspEnergy, grasp: &Grasp, step_m: f64) -> Vec<Vec<f64>> {
    let mut rng = stream(0, Task::Start, 0);
    let scales = energy.space().step_scales();
    (0..256)
        .map(|_| {
            let tangent: Vec<f64> = scales
                .iter()
                .map(|scale| scale * rng.random_range(-step_m..step_m))
                .collect();
            let mut x = grasp.pose.to_vec();
            energy.space().exp(&mut x, &tangent);
            x
        })
        .collect()
}

fn evaluations(criterion: &mut Criterion) {
    let energy = energy(Hand::human(), EnergySettings::default());
    let (_, points) = walk(&energy, 5e-4);
    let mut group = criterion.benchmark_group("grasp");
    let mut next = (0..points.len()).cycle();
    group.bench_function("contact set", |bencher| {
        bencher.iter(|| energy.contacts(black_box(&points[next.next().unwrap_or(0)])));
    });
    let kernel = GraspKernel::new(&energy);
    let state = kernel.start(&points[0]);
    let law = TargetDensity {
        temperature: 0.0025,
        attraction: None,
    };
    let mut rng = stream(0, Task::Synthesis, 0);
    group.bench_function("step of a chain", |bencher| {
        bencher.iter_batched_ref(
            State::default,
            |proposal| kernel.propose(&state, &law, 1e-3, &mut rng, proposal),
            BatchSize::SmallInput,
        );
    });
    group.finish();
    let hand = Hand::human();
    let x = hand.rest_coordinates();
    let mut posed = PosedHand::default();
    criterion.bench_function("grasp/forward kinematics, 773 points", |bencher| {
        bencher.iter(|| hand.pose(black_box(&x), &mut posed));
    });
}

/// The energy of an elastic layer, at a grasp and around it.
fn layer(criterion: &mut Criterion) {
    let energy = energy(Hand::human(), EnergySettings::default());
    let settings = SynthesisSettings::default();
    let mut gradient = vec![0.0; energy.space().tangents()];
    let mut group = criterion.benchmark_group("grasp/layer");
    for chain in 0..4 {
        let grasp = synthesize(&energy, &settings, &QuenchSettings::default(), 1, chain);
        let points = around(&energy, &grasp.refined, 5e-4);
        let mut next = (0..points.len()).cycle();
        group.bench_function(
            format!("evaluation near the grasp of chain {chain}"),
            |bencher| {
                bencher.iter(|| {
                    let x = &points[next.next().unwrap_or(0)];
                    energy.evaluate(black_box(x), &mut gradient)
                });
            },
        );
    }
    group.finish();
}

/// Energies and gradients of all grasps that come with the project, on all cores. `python/benches/batch.py` does the same from
/// Python.
fn batch(criterion: &mut Criterion) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/grasps.parquet");
    let (file, _) = GraspFile::read(&path, Overrides::default()).expect("the file is whole");
    let poses: Vec<Vec<f64>> = (file.grasps.iter())
        .map(|row| row.grasp.pose.to_vec())
        .collect();
    let energy = energy(Hand::human(), EnergySettings::default());
    let tangents = energy.space().tangents();
    let mut energies = vec![0.0; poses.len()];
    let mut gradients = vec![0.0; poses.len() * tangents];
    let mut group = criterion.benchmark_group("grasp/batch");
    group.throughput(Throughput::Elements(poses.len() as u64));
    group.bench_function("all cores", |bencher| {
        bencher.iter(|| {
            (black_box(&poses).par_iter().zip(&mut energies))
                .zip(gradients.par_chunks_mut(tangents))
                .for_each(|((x, value), gradient)| *value = energy.evaluate(x, gradient));
        });
    });
    group.finish();
}

/// Other hands beside the human one, whose cost per surface point is the reference. Published hands are sought in
/// `LANDSCAPE_TEST_DATA`.
fn other_hands(criterion: &mut Criterion) {
    let mut hands = vec![
        ("human".to_owned(), Hand::human()),
        (
            "three fingers".to_owned(),
            Hand::named("gripper_three_finger").expect("the gripper comes with the crate"),
        ),
    ];
    let folder = std::env::var_os("LANDSCAPE_TEST_DATA").map(|data| Path::new(&data).join("hands"));
    let published = [
        "shadow_dexgraspnet/shadow_hand_vis.xml",
        "shadow_dexonomy/shadow_right.xml",
        "allegro/allegro_right_nomesh.xml",
        "urdf/shadow_hand_right_nomesh.urdf",
    ];
    for name in published {
        let Some(path) = folder.as_ref().map(|folder| folder.join(name)) else {
            continue;
        };
        let read = || {
            let files = HandFiles::load(&path).expect("the test data are whole");
            Hand::from_files(&files).expect("the test data are whole")
        };
        let mut group = criterion.benchmark_group("grasp/read and derive");
        group.sample_size(10);
        group.bench_function(name, |bencher| bencher.iter(read));
        group.finish();
        hands.push((name.to_owned(), read()));
    }
    let mut group = criterion.benchmark_group("grasp/hands");
    for (name, hand) in hands {
        let energy = energy(hand, EnergySettings::default());
        let (choice, points) = walk(&energy, 5e-4);
        let mut gradient = vec![0.0; energy.space().tangents()];
        let mut next = (0..points.len()).cycle();
        group.bench_function(format!("{name}, evaluation"), |bencher| {
            bencher.iter(|| {
                let x = &points[next.next().unwrap_or(0)];
                energy.evaluate(black_box(x), &mut gradient)
            });
        });
        group.bench_function(format!("{name}, judge"), |bencher| {
            bencher.iter(|| {
                let x = &points[next.next().unwrap_or(0)];
                judge(&energy, black_box(&Grasp::new(x.clone(), choice.clone())))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, evaluations, layer, batch, other_hands);
criterion_main!(benches);
