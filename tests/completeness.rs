//! Claims of completeness, tested on surfaces with known numbers of minima and saddles. `odd_energies.rs` has surfaces without
//! a finite number of them.

use landscape::optimize::{QuenchSettings, quench};
use landscape::topography::Exploration;
use rayon::prelude::*;
use surfaces::{Counted, NEEDLE, Run};
use valleys::Valley;

#[path = "../analysis/completeness/surfaces.rs"]
mod surfaces;
#[path = "completeness/valleys.rs"]
mod valleys;

/// The number of runs that are 99 % sure, and the number of complete ones among them.
fn claims(runs: &[Run]) -> [usize; 2] {
    let claims = || runs.iter().filter(|run| run.found.coverage.sure >= 0.99);
    [
        claims().count(),
        claims().filter(|run| run.complete).count(),
    ]
}

fn runs(surface: &Counted, seeds: std::ops::Range<u64>) -> Vec<Run> {
    seeds
        .into_par_iter()
        .map(|seed| surface.search(seed))
        .collect()
}

/// Requires that of runs that claim 99 %, at least 95 of 100 are complete, and that at least `least` runs claim it.
fn check(claims: [usize; 2], least: usize) {
    assert!(claims[0] >= least, "{} claims", claims[0]);
    assert!(100 * claims[1] >= 95 * claims[0], "{claims:?}");
}

#[test]
fn claims_hold_on_simple_surfaces() {
    for (words, known, least) in [
        ("double-well 3", [8, 12], 10),
        ("torsion 1 3 1 3", [9, 18], 10),
        ("double-well 4", [16, 32], 10),
    ] {
        check(claims(&runs(&Counted::named(words, known), 0..12)), least);
    }
    // Two or three saddles met a few dozen times say little, but something.
    for (words, known) in [("muller-brown", [3, 2]), ("three-hole", [3, 3])] {
        for run in runs(&Counted::named(words, known), 0..8) {
            assert!(
                run.complete && run.found.coverage.sure > 0.9,
                "{:?}",
                run.found.coverage
            );
        }
    }
}

#[test]
fn claims_hold_on_random_surfaces() {
    let runs: Vec<Run> = (0..60_u64)
        .into_par_iter()
        .map(|id| Counted::random(id).search(id))
        .collect();
    check(claims(&runs), 0);
    let sure: f64 = runs.iter().map(|run| run.found.coverage.sure).sum();
    let complete = runs.iter().filter(|run| run.complete).count();
    // Rather too modest than too bold.
    assert!(
        complete as f64 >= sure,
        "{complete} complete, {sure} expected"
    );
}

/// Hits of other saddles tell nothing of a minimum whose basin is small. What bounds it is the number of descents.
#[test]
fn descents_bound_the_share_of_a_basin_that_was_missed() {
    const GRID: u32 = 100;
    let needle = Counted::needle();
    let place = |k: u32| -2.0 + 4.0 * (f64::from(k) + 0.5) / f64::from(GRID);
    let ends = (0..GRID * GRID).into_par_iter().filter(|k| {
        let start = [place(k / GRID), place(k % GRID)];
        let end = quench(&*needle.energy, &start, &QuenchSettings::default()).x;
        libm::hypot(end[0] - NEEDLE[0], end[1] - NEEDLE[1]) < 0.02
    });
    let share = ends.count() as f64 / f64::from(GRID * GRID);
    assert!(share > 0.001, "{share}");
    let runs = runs(&needle, 0..40);
    let missed = || runs.iter().filter(|run| run.found.minima.len() == 6);
    let bounded = missed().filter(|run| share <= run.found.coverage.undrawn_share_below);
    assert!(missed().count() > 0 && missed().count() - bounded.count() <= 2);
}

#[test]
fn what_has_rare_saddles_is_not_claimed() {
    // One of the saddles of LJ₇ is met a few times, the others dozens of times.
    for run in runs(&Counted::named("lj 7", [4, 12]), 0..2) {
        let coverage = run.found.coverage;
        assert!(
            coverage.sure < 0.99 && coverage.doubt.is_none(),
            "{coverage:?}"
        );
        assert!(run.missed <= coverage.unseen_below.unwrap(), "{coverage:?}");
        let hits: usize = run.found.saddles.iter().map(|saddle| saddle.hits).sum();
        assert_eq!(hits, coverage.arrived);
    }
}

/// Whether a run claims more than is true: certainty beside missing points, or a bound on what is missing that is too low.
fn is_false(found: &Exploration, known: [usize; 2]) -> bool {
    let coverage = &found.coverage;
    let missed = known[1].saturating_sub(found.saddles.len());
    let is_complete = [found.minima.len(), found.saddles.len()] == known;
    (coverage.sure >= 0.95 && !is_complete)
        || coverage.unseen_below.is_some_and(|most| most < missed)
}

/// Of this valley of three dimensions, with walls 3·10⁵ times as stiff as its bottom, 5 of 23 minima and 4 of 22 saddles were
/// found with limits that do not rise, and at most 2 saddles were said to be missing.
#[test]
fn a_stiff_valley_is_not_claimed_to_be_complete() {
    let valley = Valley::random(8);
    let mut settings = valley.settings(8);
    settings.max_searches = 1000;
    let found = valley.search_with(&settings);
    assert!(!is_false(&found, valley.known()), "{:?}", found.coverage);
    let limits = found.limits.unwrap();
    assert!(limits.few().is_some() && limits.rises > 0, "{limits:?}");
}

/// At each end of this valley a minimum and a saddle are so close together that their curvatures are below 10⁻⁶ of the walls',
/// which is the accuracy of a Hessian. The search cannot find them and must not claim that nothing is missing.
#[test]
fn a_minimum_and_a_saddle_that_merge_are_doubted() {
    let valley = Valley::random(95);
    for seed in 0..8 {
        let found = valley.search(seed);
        assert!(
            !is_false(&found, valley.known()),
            "{seed}: {:?}",
            found.coverage
        );
    }
}
