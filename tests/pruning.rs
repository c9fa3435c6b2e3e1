//! Pruning is exact: the tree is the same with and without it.

use landscape::optimize::QuenchSettings;
use landscape::sample::{Mala, Task, stream};
use landscape::topography::{
    Landscape, MapSettings, MatchTolerance, Minimum, MinimumId, Run, SequentialSettings, Tree,
    build_landscape, distinct, in_box, quench_all, sequential,
};
use rayon::prelude::*;

use crate::waves::Waves;

/// A random surface of two angles and the minima that random starts fall into.
fn surface(id: u64) -> (Waves, Vec<Minimum>) {
    let energy = Waves::random(2, 3, 24, &mut stream(4, Task::Surface, id));
    let minima = minima_of(&energy, 150, id);
    (energy, minima)
}

/// The minima of a surface of two angles that `starts` random starts fall into.
pub(crate) fn minima_of(energy: &Waves, starts: u64, id: u64) -> Vec<Minimum> {
    let half = std::f64::consts::PI;
    let (low, high) = ([-half; 2], [half; 2]);
    let draw = in_box(&low, &high);
    let starts: Vec<Vec<f64>> = (0..starts)
        .map(|start| draw(&mut stream(id, Task::Start, start)))
        .collect();
    let settings = QuenchSettings::default().with_gradient_tolerance(1e-9);
    let found = quench_all(energy, &starts, &settings, &Run::default()).unwrap();
    let sameness = MatchTolerance {
        energy: 1e-7,
        distance: 1e-4,
    };
    distinct(energy, &found, &sameness, 1e-6).0
}

/// Largest difference between the heights at which two trees join a pair of minima.
pub(crate) fn difference(a: &Tree, b: &Tree, count: usize) -> f64 {
    let height = |tree: &Tree, i, j| {
        let height = tree.minimax(MinimumId(i), MinimumId(j));
        height.unwrap_or(f64::MAX)
    };
    (0..count)
        .flat_map(|j| (0..j).map(move |i| (i, j)))
        .map(|(i, j)| (height(a, i, j) - height(b, i, j)).abs())
        .fold(0.0, f64::max)
}

/// Number of pairs with chains.
fn tried(found: &Landscape) -> usize {
    found.attempts.list.len()
}

#[test]
fn raw_chains_stop_early_and_the_tree_is_the_same() {
    let spent: Vec<[usize; 3]> = (0..24_u64)
        .into_par_iter()
        .map(|id| {
            let (energy, minima) = surface(id);
            let scales = MapSettings::for_minima(&energy, &minima);
            let kernel = Mala::new(&energy);
            let run = |pruned: bool, energy_tolerance: f64| {
                let mut settings = SequentialSettings {
                    chain: scales.chain.clone(),
                    quench: scales.quench.clone(),
                    sameness: scales.sameness,
                    pruned,
                    seed: id,
                };
                settings.sameness.energy = energy_tolerance;
                // A weak pull at first: many families, and a tree of many representatives.
                settings.chain.force *= 0.1;
                settings.chain.escalation = 4.0;
                settings.chain.replicas = 2;
                sequential(&energy, &kernel, &minima, &settings, &Run::default()).unwrap()
            };
            let tolerance = scales.sameness.energy;
            let (whole, pruned) = (run(false, tolerance), run(true, tolerance));
            assert_eq!(
                whole.landscape.families.members, pruned.landscape.families.members,
                "surface {id}"
            );
            let count = minima.len();
            let off = difference(&whole.landscape.tree, &pruned.landscape.tree, count);
            assert!(
                off <= tolerance,
                "surface {id}: {off:.2e} > {tolerance:.2e}"
            );
            [
                whole.representatives.len(),
                whole.landscape.evaluations,
                pruned.landscape.evaluations,
            ]
        })
        .collect();
    let [families, whole, pruned] =
        [0, 1, 2].map(|k| spent.iter().map(|row| row[k]).sum::<usize>());
    println!("{families} families on 24 surfaces; {pruned} evaluations instead of {whole}");
    // Or the test would say nothing.
    assert!(families > 72 && pruned < whole);
}

#[test]
fn pairs_joined_at_the_bottom_are_skipped_and_the_tree_is_the_same() {
    let skipped: Vec<usize> = (0..24_u64)
        .into_par_iter()
        .map(|id| {
            let (energy, minima) = surface(id);
            let mut scales = MapSettings::for_minima(&energy, &minima);
            scales.seed = id;
            // Barriers below this are none.
            let tolerance = 0.3;
            scales.sameness.energy = tolerance;
            let kernel = Mala::new(&energy);
            let run = |pruned: bool| {
                let settings = MapSettings {
                    pruned,
                    batch: 4,
                    searches: 0,
                    ..scales.clone()
                };
                build_landscape(&energy, &kernel, minima.clone(), &settings, &Run::default())
                    .unwrap()
            };
            let (whole, pruned) = (run(false), run(true));
            let off = difference(&whole.tree, &pruned.tree, minima.len());
            assert!(off <= tolerance, "surface {id}: {off}");
            tried(&whole) - tried(&pruned)
        })
        .collect();
    assert!(skipped.iter().sum::<usize>() > 24);
}
