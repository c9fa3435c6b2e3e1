//! Time and evaluations to find all minima and saddles of the reference surfaces from random points on one core, until the
//! search stops by itself.
//!
//! `cargo bench --bench landscapes -- lj9` runs the surfaces whose name contains `lj9`.

use std::time::Instant;

use landscape::energy::Energy;
use landscape::energy::model::{LennardJones, MullerBrown};
use landscape::sample::Rng;
use landscape::topography::{Draw, Run, SearchSettings, explore};
use rand::RngExt;

fn in_box(low: Vec<f64>, high: Vec<f64>) -> impl Fn(&mut Rng) -> Vec<f64> + Sync {
    move |rng| {
        let pairs = low.iter().zip(&high);
        pairs.map(|(a, b)| rng.random_range(*a..*b)).collect()
    }
}

fn main() {
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let mut surfaces: Vec<(String, Box<dyn Energy>, Box<Draw<'_>>)> = vec![(
        "muller-brown".to_owned(),
        Box::new(MullerBrown::new()),
        Box::new(in_box(vec![-1.5, -0.3], vec![1.0, 1.8])),
    )];
    for atoms in 4..=9 {
        surfaces.push((
            format!("lj{atoms}"),
            Box::new(LennardJones::new(atoms)),
            Box::new(in_box(vec![-1.2; 3 * atoms], vec![1.2; 3 * atoms])),
        ));
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("one thread can be had");
    let seeds: u64 = std::env::var("SEEDS")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(1);
    println!(
        "| surface | seed | minima | saddles | once | unseen | searches | last new | evaluations | seconds |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for (name, energy, draw) in &surfaces {
        if !wanted.is_empty() && !wanted.iter().any(|part| name.contains(part)) {
            continue;
        }
        for seed in 0..seeds {
            let started = Instant::now();
            let found = pool.install(|| {
                let mut settings = SearchSettings::measured(&**energy, &**draw, seed);
                if let Some(p) = std::env::var("PATIENCE").ok().and_then(|s| s.parse().ok()) {
                    settings.patience = p;
                }
                if std::env::var("VERBOSE").is_ok() {
                    eprintln!(
                        "{} {} {:?}",
                        settings.length, settings.energy, settings.quench
                    );
                }
                explore(&**energy, &**draw, &settings, &Run::default())
                    .expect("without a journal nothing fails")
            });
            let c = found.coverage;
            println!(
                "| {name} | {seed} | {} | {} | {} | {} | {} | {} | {} | {:.3} |",
                found.minima.len(),
                found.saddles.len(),
                c.once,
                c.unseen
                    .map_or("–".to_owned(), |unseen| format!("{unseen:.1}")),
                c.searches,
                c.last_new,
                found.evaluations,
                started.elapsed().as_secs_f64()
            );
            if std::env::var("VERBOSE").is_ok() {
                eprintln!("{:?}", found.search_ends);
                for s in &found.saddles {
                    eprintln!(
                        "{:.6} {:?} {} {:?}",
                        s.energy,
                        s.ends.map(|e| e.0),
                        s.hits,
                        s.audit.curvatures[0]
                    );
                }
            }
        }
    }
}
