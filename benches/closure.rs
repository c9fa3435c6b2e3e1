//! Cost of the relaxed and of the exact force-closure test of bare contact points.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use landscape::grasp::closure::{PointContact, is_force_closure, least_friction};
use landscape::object::{Object, Shape, Sphere};
use landscape::sample::{Task, stream};
use nalgebra::Vector3;
use rand::RngExt;
use relaxed::{RelaxedForceClosure, Touch};

#[expect(
    dead_code,
    unused_imports,
    reason = "a benchmark leaves out the tests in it"
)]
#[path = "../analysis/relaxed.rs"]
mod relaxed;

const SETS: usize = 64;

const BALL: Sphere = Sphere {
    centre: Vector3::new(0.0, 0.0, 0.0),
    radius_m: 0.04,
};

/// Sets of contacts all over the ball.
fn sets(contacts: usize) -> Vec<Vec<Vector3<f64>>> {
    let mut rng = stream(0, Task::Start, 0);
    let mut point = || loop {
        let point = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        if (0.01..1.0).contains(&point.norm_squared()) {
            return BALL.radius_m * point.normalize();
        }
    };
    (0..SETS)
        .map(|_| (0..contacts).map(|_| point()).collect())
        .collect()
}

/// Sets of contacts within 2 mm of an object's surface.
fn sets_near(object: &Object, contacts: usize) -> Vec<Vec<Vector3<f64>>> {
    let mut rng = stream(0, Task::Start, 1);
    let mut point = || {
        let sample = &object.surface_samples[rng.random_range(0..object.surface_samples.len())];
        sample.point + sample.normal * rng.random_range(-0.002..0.002)
    };
    (0..SETS)
        .map(|_| (0..contacts).map(|_| point()).collect())
        .collect()
}

fn relaxed_on<S: Shape + ?Sized>(
    criterion: &mut Criterion,
    name: &str,
    shape: &S,
    test: &RelaxedForceClosure,
    sets: impl Fn(usize) -> Vec<Vec<Vector3<f64>>>,
) {
    let mut group = criterion.benchmark_group(format!("closure/relaxed on a {name}"));
    for contacts in [3, 5, 100] {
        let sets = sets(contacts);
        let mut next = sets.iter().cycle();
        group.bench_function(BenchmarkId::new("value", contacts), |bencher| {
            bencher.iter(|| {
                next.next()
                    .map(|points| test.value(shape, black_box(points)))
            });
        });
        let mut next = sets.iter().cycle();
        let mut touches = vec![Touch::at(Vector3::zeros()); contacts];
        group.bench_function(BenchmarkId::new("value and forces", contacts), |bencher| {
            bencher.iter(|| {
                for (touch, point) in touches.iter_mut().zip(next.next().into_iter().flatten()) {
                    touch.point = *point;
                }
                test.value_and_forces(shape, black_box(&mut touches))
            });
        });
    }
}

fn relaxed(criterion: &mut Criterion) {
    let test = RelaxedForceClosure::paper(BALL.centre, BALL.radius_m);
    relaxed_on(criterion, "ball", &BALL, &test, sets);
    let active = RelaxedForceClosure {
        rank_epsilon: 1e3,
        ..test
    };
    relaxed_on(criterion, "ball, lacking rank", &BALL, &active, sets);
    let bottle = Object::named("bottle_round").expect("the bottle comes with the crate");
    let test = RelaxedForceClosure::of_object(&bottle);
    relaxed_on(criterion, "bottle", &*bottle.shape, &test, |contacts| {
        sets_near(&bottle, contacts)
    });
}

fn exact(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("closure/exact");
    for contacts in [3, 4, 5] {
        let sets: Vec<Vec<PointContact>> = sets(contacts)
            .iter()
            .map(|points| {
                let contact = |point: &Vector3<f64>| PointContact {
                    arm: point / BALL.radius_m,
                    inward_normal: -point.normalize(),
                };
                points.iter().map(contact).collect()
            })
            .collect();
        let mut next = sets.iter().cycle();
        group.bench_function(
            BenchmarkId::new("force closure at 0.5", contacts),
            |bencher| {
                bencher.iter(|| {
                    next.next()
                        .map(|contacts| is_force_closure(black_box(contacts), 0.5))
                });
            },
        );
        let mut next = sets.iter().cycle();
        group.bench_function(BenchmarkId::new("least friction", contacts), |bencher| {
            bencher.iter(|| {
                next.next()
                    .map(|contacts| least_friction(black_box(contacts)))
            });
        });
    }
}

criterion_group!(benches, relaxed, exact);
criterion_main!(benches);
