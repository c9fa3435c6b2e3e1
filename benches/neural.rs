//! Cost of a neural shape compared with the limit of the machine: the standard `DeepSDF` network (eight layers of 512, code
//! of 256, random weights) at as many points as on a hand, on one thread, beside a large square product of the same
//! library.
//!
//! ```text
//! cargo bench --bench neural
//! ```
//!
//! Throughput is in operations of the matrix products, so that Gelem/s reads GFLOP/s.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use landscape::sample::{Task, stream};
use nalgebra::{DMatrix, Vector3};
use rand::RngExt;

#[path = "../analysis/force_closure_cost/network.rs"]
mod network;

const POINTS: usize = 773;
/// Side of the square matrices, so large that only the arithmetic counts.
const SIDE: usize = 1536;

fn benches(criterion: &mut Criterion) {
    // The only pool of the process. Batches larger than the network's own go to it, and smaller ones run in this thread.
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global()
        .expect("no other pool was started before");
    let field = network::field(1.0).expect("the made-up network is valid");
    let network = field.network();
    let mut rng = stream(0, Task::Start, 1);
    let points: Vec<Vector3<f64>> = (0..POINTS)
        .map(|_| Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)))
        .collect();

    let mut group = criterion.benchmark_group("neural");
    group.sample_size(20);
    let (a, b) = (
        DMatrix::from_element(SIDE, SIDE, 0.5_f32),
        DMatrix::from_element(SIDE, SIDE, 0.25_f32),
    );
    let mut c = DMatrix::zeros(SIDE, SIDE);
    group.throughput(Throughput::Elements((2 * SIDE.pow(3)) as u64));
    group.bench_function("product of large matrices", |bencher| {
        bencher.iter(|| c.gemm(1.0, black_box(&a), &b, 0.0));
    });
    for count in [1, 5, POINTS] {
        let points = &points[..count];
        let operations = (count * network.operations()) as u64;
        group.throughput(Throughput::Elements(operations));
        group.bench_function(format!("{count} points: value"), |bencher| {
            bencher.iter(|| network.values(black_box(points)));
        });
        group.throughput(Throughput::Elements(2 * operations));
        group.bench_function(format!("{count} points: value, gradient"), |bencher| {
            bencher.iter(|| network.answers(black_box(points)));
        });
    }
    group.finish();
}

criterion_group!(neural, benches);
criterion_main!(neural);
