//! Scratch.
use landscape::energy::model;
use landscape::topography::{LowestSettings, Run, SearchSettings, explore_lowest, in_box};
use std::time::Instant;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let seed: u64 = words[2].parse().unwrap();
    let limit: f64 = words[3].parse().unwrap();
    let surface = model::named(&words[..2]).unwrap();
    let draw = in_box(&surface.low, &surface.high);
    let settings = SearchSettings::measured(&*surface.energy, &draw, seed);
    println!(
        "length {} energy {} sameness {:?} quench {:?}",
        settings.length, settings.energy, settings.sameness, settings.quench
    );
    let start = Instant::now();
    let last = std::sync::Mutex::new((0, String::new()));
    let run = Run {
        observer: &|news| {
            let mut last = last.lock().unwrap();
            let now = format!("{:?}", news.phase);
            if now != last.1 {
                println!(
                    "{:.1} s {:?} {}",
                    start.elapsed().as_secs_f64(),
                    news.phase,
                    news.done
                );
                last.1 = now;
            }
        },
        enough: &|| start.elapsed().as_secs_f64() > limit,
        ..Run::default()
    };
    let (found, report) = explore_lowest(
        &*surface.energy,
        &draw,
        &[],
        &settings,
        &LowestSettings::default(),
        &run,
    )
    .unwrap();
    println!(
        "{:.1} s, {} evaluations, {} minima, {} saddles",
        start.elapsed().as_secs_f64(),
        found.evaluations,
        found.minima.len(),
        found.saddles.len()
    );
    println!(
        "hops {} runs {} finds {} rounds {} last change {} stopped {}",
        report.hops, report.runs, report.finds, report.rounds, report.last_change, report.stopped
    );
    for t in &report.trace {
        if t.round % 10 == 0 {
            println!(
                "r{} ev {:.1}M min {} sad {} comp {} depths {:.3} deepest {:?} {:?}",
                t.round,
                t.evaluations as f64 / 1e6,
                t.minima,
                t.saddles,
                t.components,
                t.depths,
                t.deepest,
                t.sides
            );
        }
    }
    println!("{:?}", found.search_ends);
    println!("refused {}", found.refused.len());
    for m in found.minima.iter().take(12) {
        println!("{:.6}", m.energy);
    }
}
