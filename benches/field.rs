//! Cost of one evaluation of a baked field, near the object and around it.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use landscape::object::{Object, Shape};
use nalgebra::Vector3;

fn answers(criterion: &mut Criterion) {
    let object = Object::named("bottle_round").expect("the bottle comes with the crate");
    let shape: &dyn Shape = &*object.shape;
    for (place, reach_m) in [("near", 0.02), ("around", 0.1)] {
        // As many points as on a hand, each slightly off the surface.
        let points: Vec<Vector3<f64>> = object.surface_samples[..773]
            .iter()
            .enumerate()
            .map(|(index, sample)| {
                sample.point + sample.normal * (reach_m * (index % 10) as f64 / 10.0)
            })
            .collect();
        let mut group = criterion.benchmark_group(format!("field/773 points {place}"));
        group.bench_function("value", |bencher| {
            bencher.iter(|| {
                points
                    .iter()
                    .map(|p| shape.distance(black_box(p)))
                    .sum::<f64>()
            });
        });
        group.bench_function("gradient", |bencher| {
            bencher.iter(|| {
                points
                    .iter()
                    .map(|p| shape.gradient(black_box(p)).1.x)
                    .sum::<f64>()
            });
        });
        group.bench_function("hessian", |bencher| {
            bencher.iter(|| {
                points
                    .iter()
                    .map(|p| shape.hessian(black_box(p)).2.m12)
                    .sum::<f64>()
            });
        });
    }
}

criterion_group!(benches, answers);
criterion_main!(benches);
