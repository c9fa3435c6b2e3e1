//! Eigenvectors of symmetric matrices by nalgebra and by faer on one core. Hessians have 6 to some 60 rows; the matrix of a
//! layout has as many rows as there are minima.

use std::hint::black_box;
use std::time::Instant;

use faer::{Mat, Side};
use landscape::sample::{Task, stream};
use nalgebra::{DMatrix, SymmetricEigen};
use rand::RngExt;

/// Time of the fastest of five turns, seconds per call.
fn fastest(calls: usize, mut call: impl FnMut()) -> f64 {
    let turn = |_| {
        let start = Instant::now();
        (0..calls).for_each(|_| call());
        start.elapsed().as_secs_f64() / calls as f64
    };
    (0..5).map(turn).fold(f64::INFINITY, f64::min)
}

fn main() {
    println!("rows   nalgebra us       faer us   nalgebra / faer");
    for rows in [6usize, 12, 18, 39, 60, 100, 200, 400, 800] {
        let mut rng = stream(0, Task::Layout, rows as u64);
        let mut dense = DMatrix::from_fn(rows, rows, |_, _| rng.random_range(-0.5..0.5));
        dense.fill_upper_triangle_with_lower_triangle();
        let mirrored = Mat::from_fn(rows, rows, |i, j| dense[(i, j)]);
        let calls = (10_000_000 / rows.pow(3)).clamp(1, 3000);
        let nalgebra = fastest(calls, || {
            black_box(SymmetricEigen::new(black_box(dense.clone())));
        });
        let faer = fastest(calls, || {
            let eigen = black_box(&mirrored).self_adjoint_eigen(Side::Lower);
            black_box(eigen.is_ok());
        });
        println!(
            "{rows:4} {:13.1} {:13.1} {:17.2}",
            1e6 * nalgebra,
            1e6 * faer,
            nalgebra / faer
        );
    }
}
