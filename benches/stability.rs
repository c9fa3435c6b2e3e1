//! Simulation of grasps: the drop test and that of `DexGraspBench` of one grasp on the round bottle, one core.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use landscape::evaluation::stability::{Build, Solid, named, simulate};
use landscape::grasp::Grasp;
use landscape::hand::Hand;
use landscape::object::Object;

/// Poses and contacts of grasps on `bottle_round`, found by `landscape synth --object bottle_round --seed 6`.
const GRASPS: &str = include_str!("stability_grasps.json");

fn stability(criterion: &mut Criterion) {
    let hand = Hand::human();
    let (mesh, description) =
        Object::parts_of_named("bottle_round").expect("the bottle comes with the crate");
    let solid = Solid::new(&mesh, Build::Pieces);
    let mass_kg = description.mass_kg.expect("the bottle has a mass");
    let grasps: Vec<(Vec<f64>, Vec<u32>)> =
        serde_json::from_str(GRASPS).expect("the file holds poses and contacts");
    let grasps: Vec<Grasp> = (grasps.into_iter().map(|(x, set)| Grasp::new(x, set))).collect();
    for name in ["drop", "dexgraspbench"] {
        let protocol = named(name).expect("a published test");
        let mut group = criterion.benchmark_group("stability");
        group.sample_size(10);
        // Each round simulates all grasps.
        group.throughput(criterion::Throughput::Elements(grasps.len() as u64));
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                for grasp in &grasps {
                    black_box(simulate(&hand, grasp, None, &solid, mass_kg, &protocol));
                }
            });
        });
        group.finish();
    }
}

criterion_group!(benches, stability);
criterion_main!(benches);
