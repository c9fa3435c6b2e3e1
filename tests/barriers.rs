//! Landscapes with exactly known merge heights, mapped from random starts through public functions, without knowledge of
//! the number of minima.

use landscape::energy::Energy;
use landscape::energy::model::{MullerBrown, ThreeHole, Torsion};
use landscape::optimize::QuenchSettings;
use landscape::sample::{Mala, Task, stream};
use landscape::topography::{
    Evidence, Landscape, MapSettings, MatchTolerance, MemoryJournal, Minimum, MinimumId, Run,
    build_landscape, distinct, quench_all,
};
use rand::RngExt;

/// Minima reached from `count` random points of a box.
fn minima(energy: &dyn Energy, low: &[f64], high: &[f64], count: u64) -> Vec<Minimum> {
    let start = |id| {
        let mut rng = stream(11, Task::Start, id);
        low.iter()
            .zip(high)
            .map(|(a, b)| rng.random_range(*a..*b))
            .collect()
    };
    let starts: Vec<Vec<f64>> = (0..count).map(start).collect();
    let found = quench_all(energy, &starts, &QuenchSettings::default(), &Run::default()).unwrap();
    distinct(energy, &found, &MatchTolerance::default(), 1e-6).0
}

#[test]
fn three_hole_passes_through_the_shallow_hole() {
    let reference: serde_json::Value =
        serde_json::from_str(include_str!("reference/landscapes.json")).unwrap();
    let energy = ThreeHole::new();
    let minima = minima(&energy, &[-2.0, -1.0], &[2.0, 2.0], 40);
    assert_eq!(minima.len(), 3);
    let settings = MapSettings::for_minima(&energy, &minima);
    let found = build_landscape(
        &energy,
        &Mala::new(&energy),
        minima,
        &settings,
        &Run::default(),
    )
    .unwrap();
    for i in 0..3 {
        for j in 0..3 {
            let height = found.tree.minimax(MinimumId(i), MinimumId(j)).unwrap();
            let known = reference["three_hole"]["minimax"][i][j].as_f64().unwrap();
            assert!((height - known).abs() < 1e-5, "{i} {j}: {height} {known}");
        }
    }
    // The direct pass between the deep holes is found too, and is higher.
    let direct = found.connection(MinimumId(0), MinimumId(1)).unwrap();
    assert!((direct.edge.height + 1.384587).abs() < 1e-5);
    assert_eq!(direct.edge.evidence, Evidence::Saddle);
    // One merge of three: the two passes tie.
    assert_eq!(found.tree.nodes.len(), 4);
    assert_eq!(found.tree.nodes[3].evidence, Evidence::Saddle);
}

#[test]
fn angles_wrap() {
    // Four minima at 0 on a torus; crossing one barrier of the first angle costs 2 · 1, of the second 2 · 3.
    let energy = Torsion::new(&[(1.0, 2), (3.0, 2)]);
    let minima = minima(&energy, &[-3.1; 2], &[3.1; 2], 60);
    assert_eq!(minima.len(), 4);
    let settings = MapSettings::for_minima(&energy, &minima);
    let found = build_landscape(
        &energy,
        &Mala::new(&energy),
        minima,
        &settings,
        &Run::default(),
    )
    .unwrap();
    let merges: Vec<f64> = found.tree.nodes[4..]
        .iter()
        .map(|node| node.energy)
        .collect();
    assert_eq!(merges.len(), 3);
    for (height, known) in merges.iter().zip([2.0, 2.0, 6.0]) {
        assert!((height - known).abs() < 1e-5, "{merges:?}");
    }
}

/// All properties of a map that could differ.
fn fingerprint(found: &Landscape) -> String {
    let (tree, families) = (&found.tree, &found.families);
    format!(
        "{:?}{:?}{tree:?}{families:?}",
        found.network, found.connections
    )
}

#[test]
fn threads_order_and_interruption_change_nothing() {
    let energy = MullerBrown::new();
    let mut minima = minima(&energy, &[-1.5, -0.3], &[1.0, 1.8], 40);
    let settings = MapSettings {
        neighbours: 3,
        ..MapSettings::for_minima(&energy, &minima)
    };
    let journal = MemoryJournal::default();
    let run = |minima: Vec<Minimum>, journal: &MemoryJournal, threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let run = Run {
                journal,
                ..Run::default()
            };
            let kernel = Mala::new(&energy);
            fingerprint(&build_landscape(&energy, &kernel, minima, &settings, &run).unwrap())
        })
    };
    let first = run(minima.clone(), &journal, 1);
    assert_eq!(first, run(minima.clone(), &MemoryJournal::default(), 2));
    minima.reverse();
    assert_eq!(first, run(minima.clone(), &MemoryJournal::default(), 2));
    // Resumed with half of the work done.
    let half = journal.half();
    assert!(!half.is_empty());
    assert_eq!(first, run(minima, &half, 2));
}

trait Half {
    fn half(&self) -> Self;
}

impl Half for MemoryJournal {
    fn half(&self) -> Self {
        use landscape::topography::Journal;
        let half = Self::default();
        for i in 0..10 {
            for j in (i + 1..10).step_by(2) {
                let key = format!("pair/{i}-{j}/0");
                if let Some(record) = self.get(&key) {
                    half.put(&key, &record).unwrap();
                }
            }
        }
        half
    }
}

#[test]
fn what_is_no_minimum_has_no_part_in_the_map() {
    let energy = MullerBrown::new();
    let known = minima(&energy, &[-1.5, -0.3], &[1.0, 1.8], 40);
    assert_eq!(known.len(), 3);
    let mut given = known.clone();
    let like = |x: [f64; 2]| Minimum {
        coordinates: x.to_vec(),
        energy: energy.evaluate(&x, &mut [0.0; 2]),
        members: vec![99],
    };
    let copy = [0, 1].map(|k| known[1].coordinates[k] + 1e-7);
    given.insert(0, like([0.2, 1.3]));
    given.insert(2, like(copy));
    given.push(like([f64::NAN, 0.5]));
    given.push(Minimum {
        energy: f64::NAN,
        ..known[0].clone()
    });
    given.push(Minimum {
        energy: known[0].energy - 1.0,
        ..known[0].clone()
    });
    let run = |given: Vec<Minimum>| {
        let settings = MapSettings::for_minima(&energy, &given);
        build_landscape(
            &energy,
            &Mala::new(&energy),
            given,
            &settings,
            &Run::default(),
        )
        .unwrap()
    };
    let (whole, found) = (run(known.clone()), run(given));
    let rows: Vec<usize> = found.rejected.iter().map(|rejected| rejected.row).collect();
    assert_eq!(rows, [0, 5, 6, 7]);
    assert!(found.rejected[0].gradient_norm > 1.0);
    assert!(whole.rejected.is_empty());
    let nodes = |landscape: &Landscape| -> Vec<Minimum> {
        landscape.network.node_weights().cloned().collect()
    };
    assert_eq!(nodes(&found).len(), 3);
    assert!(nodes(&found)[1].members.contains(&99));
    for (one, other) in nodes(&found).iter().zip(nodes(&whole)) {
        assert_eq!(one.coordinates, other.coordinates);
    }
    for i in 0..3 {
        let ends = (MinimumId(0), MinimumId(i));
        let [height, known] = [&found, &whole].map(|map| map.tree.minimax(ends.0, ends.1).unwrap());
        assert!((height - known).abs() < 1e-6);
    }
}
