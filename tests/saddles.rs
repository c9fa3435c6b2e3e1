//! All minima and saddles of surfaces with known numbers of them, from random points. The search knows no reference value,
//! no expected number and no scale.
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use landscape::energy::model::{LennardJones, Surface, named};
use landscape::energy::{Energy, FunctionOn};
use landscape::space::Euclidean;
use landscape::topography::{
    AuditSettings, Exploration, FamilySettings, Journal, Landscape, MemoryJournal, MinimumId, Run,
    SearchSettings, Verdict, audit, explore, in_box,
};
use serde_json::Value;

fn reference(name: &str) -> Value {
    let all: Value = serde_json::from_str(include_str!("reference/landscapes.json")).unwrap();
    all[name].clone()
}

fn explored(surface: &Surface) -> (Exploration, Landscape) {
    explored_from(surface, 1)
}

fn explored_from(surface: &Surface, seed: u64) -> (Exploration, Landscape) {
    let energy = &*surface.energy;
    let draw = in_box(&surface.low, &surface.high);
    let settings = SearchSettings::measured(energy, &draw, seed);
    let found = explore(energy, &draw, &settings, &Run::default()).unwrap();
    check_audits(energy, &found);
    let landscape = found.landscape(energy, &FamilySettings::default());
    (found, landscape)
}

fn model(words: &str) -> Surface {
    named(&words.split(' ').collect::<Vec<_>>()).unwrap()
}

/// Checks the audit of each stationary point by measuring it again.
fn check_audits(energy: &dyn Energy, found: &Exploration) {
    let settings = AuditSettings {
        gradient_tolerance: 1e-3,
        ..AuditSettings::default()
    };
    let minima: Vec<_> = found.minima.iter().map(|m| m.coordinates.clone()).collect();
    let saddles: Vec<_> = found
        .saddles
        .iter()
        .map(|s| s.coordinates.clone())
        .collect();
    for (index, points) in [minima, saddles].iter().enumerate() {
        for audit in audit(energy, points, index, &settings) {
            assert_eq!(audit.verdict, Verdict::Sound, "{audit:?}");
            assert_eq!(audit.index, index);
        }
    }
    for saddle in &found.saddles {
        assert_eq!(saddle.audit.verdict, Verdict::Sound);
        assert!((saddle.path.height() - saddle.energy).abs() < 1e-12);
        let last = saddle.path.images.len() - 1;
        for (end, image) in saddle.ends.iter().zip([0, last]) {
            let known = &found.minima[end.0];
            assert!((saddle.path.energies[image] - known.energy).abs() < 1e-6);
            let space = energy.space();
            assert!(space.distance(&saddle.path.images[image], &known.coordinates) < 1e-2);
        }
    }
}

/// Compares sorted energies one by one.
fn assert_energies(found: impl Iterator<Item = f64>, known: &[f64]) {
    let found: Vec<f64> = found.collect();
    assert_eq!(found.len(), known.len(), "{found:?}");
    for (found, known) in found.iter().zip(known) {
        assert!((found - known).abs() < 1e-5, "{found} instead of {known}");
    }
}

/// Minima, saddles with the minima they join, and merge heights of a Lennard-Jones cluster.
fn check_cluster(atoms: usize) {
    let reference = reference(&format!("LJ{atoms}"));
    let (found, landscape) = explored(&model(&format!("lj {atoms}")));
    let minima: Vec<f64> = serde_json::from_value(reference["minima"].clone()).unwrap();
    assert_energies(found.minima.iter().map(|m| m.energy), &minima);
    let saddles = reference["ts"].as_array().unwrap();
    let energies: Vec<f64> = saddles
        .iter()
        .map(|ts| ts["energy"].as_f64().unwrap())
        .collect();
    assert_energies(found.saddles.iter().map(|s| s.energy), &energies);
    for (saddle, known) in found.saddles.iter().zip(saddles) {
        let ends: [usize; 2] = serde_json::from_value(known["connects"].clone()).unwrap();
        assert_eq!(saddle.ends, ends.map(MinimumId), "at {}", saddle.energy);
    }
    for i in 0..minima.len() {
        for j in 0..minima.len() {
            let height = landscape.tree.minimax(MinimumId(i), MinimumId(j)).unwrap();
            let known = reference["minimax"][i][j].as_f64().unwrap();
            assert!((height - known).abs() < 1e-5, "{i} {j}: {height} {known}");
        }
    }
}

#[test]
fn four_to_six_atoms() {
    (4..=6).for_each(check_cluster);
}

#[test]
fn seven_atoms() {
    check_cluster(7);
}

#[test]
fn eight_atoms() {
    for seed in 0..4 {
        let (found, landscape) = explored_from(&model("lj 8"), seed);
        // Doye and Wales (2002). Of one saddle one search in four hundred finds the way.
        assert_eq!(found.minima.len(), 8);
        assert_eq!(found.saddles.len(), 42, "seed {seed}");
        assert_eq!(landscape.tree.roots.len(), 1);
    }
}

#[test]
fn plane_surfaces() {
    for (name, words) in [
        ("muller_brown", "muller-brown"),
        ("three_hole", "three-hole"),
    ] {
        let reference = reference(name);
        let (found, landscape) = explored(&model(words));
        let energies = |kind: &str| -> Vec<f64> {
            let points = reference[kind].as_array().unwrap().iter();
            points.map(|p| p["energy"].as_f64().unwrap()).collect()
        };
        assert_energies(found.minima.iter().map(|m| m.energy), &energies("minima"));
        assert_energies(found.saddles.iter().map(|s| s.energy), &energies("saddles"));
        for i in 0..found.minima.len() {
            for j in 0..found.minima.len() {
                let height = landscape.tree.minimax(MinimumId(i), MinimumId(j)).unwrap();
                let known = reference["minimax"][i][j].as_f64().unwrap();
                assert!((height - known).abs() < 1e-5, "{i} {j}: {height} {known}");
            }
        }
    }
}

#[test]
fn separable_wells() {
    for d in 1..=5 {
        let (found, landscape) = explored(&model(&format!("double-well {d}")));
        assert_energies(found.minima.iter().map(|m| m.energy), &vec![0.0; 1 << d]);
        assert_energies(
            found.saddles.iter().map(|s| s.energy),
            &vec![1.0; d << (d - 1)],
        );
        // One merge of all at height 1.
        assert_eq!(landscape.tree.nodes.len(), (1 << d) + 1);
    }
}

#[test]
fn angles_on_a_torus() {
    // Π folds minima at 0, and as many saddles for each angle, at twice its height.
    let (found, landscape) = explored(&model("torsion 0.5 3 1 2 2 1"));
    assert_energies(found.minima.iter().map(|m| m.energy), &[0.0; 6]);
    let known: Vec<f64> = [1.0, 2.0, 4.0].iter().flat_map(|h| [*h; 6]).collect();
    assert_energies(found.saddles.iter().map(|s| s.energy), &known);
    let merges: Vec<f64> = landscape.tree.nodes[6..]
        .iter()
        .map(|node| node.energy)
        .collect();
    assert_energies(merges.into_iter(), &[1.0, 1.0, 2.0]);
    // The third angle has one minimum: its pass joins every minimum with itself, once around.
    for saddle in found.saddles.iter().filter(|saddle| saddle.energy > 3.0) {
        assert_eq!(saddle.ends[0], saddle.ends[1]);
    }
}

#[test]
fn rotations() {
    let c = [3.0, 2.0, 1.5, 1.0];
    let (found, landscape) = explored(&model("orientation 1 1.5 2 3"));
    assert_energies(found.minima.iter().map(|m| m.energy), &c.map(|c| -c));
    let pass = |i: usize, j: usize| -1.0 / (1.0 / c[i] + 1.0 / c[j]);
    // Two ways round between any two minima, each with curvatures −2/σ, 1/σ, 1/σ.
    let mut known: Vec<f64> = (0..4)
        .flat_map(|j| (0..j).flat_map(move |i| [pass(i, j); 2]))
        .collect();
    known.sort_by(f64::total_cmp);
    assert_energies(found.saddles.iter().map(|s| s.energy), &known);
    for saddle in &found.saddles {
        let sharpness = -saddle.energy;
        let expected = [-2.0, 1.0, 1.0].map(|factor| factor * sharpness);
        for (curvature, expected) in saddle.audit.curvatures.iter().zip(expected) {
            assert!((curvature - expected).abs() < 1e-5, "{:?}", saddle.audit);
        }
    }
    for j in 1..4 {
        let height = landscape.tree.minimax(MinimumId(0), MinimumId(j)).unwrap();
        assert!((height - pass(0, j)).abs() < 1e-5);
    }
}

#[test]
fn threads_and_interruptions_change_nothing() {
    let surface = model("lj 6");
    let energy = &*surface.energy;
    let draw = in_box(&surface.low, &surface.high);
    let settings = SearchSettings::measured(energy, &draw, 3);
    let run = |threads: usize, journal: &MemoryJournal| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            format!(
                "{:?}",
                explore(
                    energy,
                    &draw,
                    &settings,
                    &Run {
                        journal,
                        ..Run::default()
                    }
                )
                .unwrap()
            )
        })
    };
    let journal = MemoryJournal::default();
    let first = run(1, &journal);
    assert_eq!(first, run(3, &MemoryJournal::default()));
    // Resumed with the first batch done.
    let partly = MemoryJournal::default();
    partly
        .put("search/0", &journal.get("search/0").unwrap())
        .unwrap();
    assert_eq!(first, run(2, &partly));
    assert_eq!(first, run(2, &journal));
}

#[test]
fn an_audit_finds_what_is_wrong() {
    let energy = LennardJones::new(5);
    let reference = reference("LJ5");
    let point = |list: &str, k: usize| -> Vec<f64> {
        serde_json::from_value(reference[list][k].clone()).unwrap()
    };
    let (minimum, saddle) = (point("minima_coords", 0), point("ts_coords", 0));
    // Renumbered: still the same.
    let copy: Vec<f64> = minimum.chunks_exact(3).rev().flatten().copied().collect();
    let mut shaken = minimum.clone();
    shaken[0] += 1e-4;
    // A tetrahedron whose fifth atom left: no force any more, and no cluster either.
    let four: Vec<f64> =
        serde_json::from_value(self::reference("LJ4")["minima_coords"][0].clone()).unwrap();
    let apart = [four, vec![25.0, 0.0, 0.0]].concat();
    let coinciding = vec![0.0; 15];
    let points = [minimum, saddle, copy, shaken, apart, coinciding];
    let audits = audit(&energy, &points, 0, &AuditSettings::default());
    let verdicts: Vec<Verdict> = audits.iter().map(|audit| audit.verdict).collect();
    assert_eq!(
        verdicts,
        [
            Verdict::Sound,
            Verdict::Index,
            Verdict::Duplicate,
            Verdict::Moving,
            Verdict::Evaporated,
            Verdict::Outside
        ]
    );
    assert_eq!(audits[2].duplicate_of, Some(0));
    assert_eq!((audits[1].index, audits[1].flat), (1, 0));
    assert_eq!(audits[0].curvatures.len(), 9);
    assert!(audits[4].flat >= 3);
}

/// Saddles at the origin whose second direction is soft. Clusters of eleven and twelve atoms have such.
#[test]
fn soft_saddles_are_isolated() {
    let verdict = |soft: &(dyn Fn(f64) -> (f64, f64) + Sync)| {
        let energy = FunctionOn::new(Euclidean::new(2), |p: &[f64], gradient: &mut [f64]| {
            let (height, slope) = soft(p[1]);
            gradient.copy_from_slice(&[-10.0 * p[0], slope]);
            -5.0 * p[0] * p[0] + height
        });
        audit(&energy, &[vec![0.0, 0.0]], 1, &AuditSettings::default())[0].verdict
    };
    // A point of index 2 beside it, 7e-7 higher, where the tolerance of the energy is 1e-6.
    let fold = |y: f64| {
        let (curvature, gap) = (0.08, 7e-3);
        let height = curvature * y * y * (0.5 + y / (3.0 * gap));
        (height, curvature * y * (1.0 + y / gap))
    };
    assert_eq!(verdict(&fold), Verdict::Sound);
    // The gradient is within its tolerance of 1e-6 up to twice the tolerance of distance, or six times.
    for [square, fourth] in [[2e-4, 10.0], [2e-4, 0.0], [1e-6, 1.0]] {
        let soft = |y: f64| {
            let height = y * y * (square + fourth * y * y);
            (height, y * (2.0 * square + 4.0 * fourth * y * y))
        };
        assert_eq!(verdict(&soft), Verdict::Sound, "{square} {fourth}");
    }
    let level = |_: f64| (0.0, 0.0);
    assert_eq!(verdict(&level), Verdict::Degenerate);
}
