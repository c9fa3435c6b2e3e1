//! Landscapes with exactly known merge heights, mapped from random starts through public functions, without knowledge of
//! the number of minima.

use landscape::energy::model::{MullerBrown, ThreeHole, Torsion};
use landscape::energy::{Energy, Piecewise};
use landscape::optimize::{QuenchSettings, quench};
use landscape::sample::{Mala, Task, stream};
use landscape::space::{Euclidean, Space};
use landscape::topography::{
    Evidence, Landscape, MapSettings, MatchTolerance, MemoryJournal, Minimum, MinimumId, Run,
    SeamSettings, Tree, build_landscape, distinct, quench_all,
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

/// The minimum of several bowls `c + ½ Σ k_d (x_d − m_d)²`: an envelope with concave kinks, like that of a grasp energy
/// over its contact sets. Every pass between two bowls is the lowest point of a seam.
struct Bowls {
    space: Euclidean,
    bowls: Vec<Bowl>,
}

struct Bowl {
    depth: f64,
    stiffness: Vec<f64>,
    centre: Vec<f64>,
}

impl Bowl {
    fn energy(&self, x: &[f64]) -> f64 {
        let squares = x.iter().zip(&self.centre).zip(&self.stiffness);
        self.depth
            + squares
                .map(|((x, m), k)| 0.5 * k * (x - m) * (x - m))
                .sum::<f64>()
    }

    /// Least height at which the two bowls touch: max over λ of min over x of (1 − λ) E₁ + λ E₂, by ternary search
    /// (concave in λ, since both are convex in x).
    fn contact(&self, other: &Self) -> f64 {
        let dual = |share: f64| {
            let x: Vec<f64> = (0..self.centre.len())
                .map(|d| {
                    let (k, l) = (
                        (1.0 - share) * self.stiffness[d],
                        share * other.stiffness[d],
                    );
                    (k * self.centre[d] + l * other.centre[d]) / (k + l)
                })
                .collect();
            (1.0 - share) * self.energy(&x) + share * other.energy(&x)
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..200 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if dual(a) < dual(b) {
                low = a;
            } else {
                high = b;
            }
        }
        dual(low)
    }
}

impl Bowls {
    fn random(dimensions: usize, count: u64) -> Self {
        let bowls = (0..count)
            .map(|id| {
                let mut rng = stream(3, Task::Start, id);
                let mut draw = |low, high| {
                    (0..dimensions)
                        .map(|_| rng.random_range(low..high))
                        .collect::<Vec<f64>>()
                };
                Bowl {
                    stiffness: draw(1.0, 6.0),
                    centre: draw(-1.0, 1.0),
                    depth: draw(0.0, 0.4)[0],
                }
            })
            .collect();
        Self {
            space: Euclidean::new(dimensions),
            bowls,
        }
    }

    /// Exact minimax heights: the set below a level is a union of ellipsoids, so bowls touch in pairs.
    fn exact(&self, order: &[usize]) -> Vec<Vec<f64>> {
        let n = order.len();
        let bowl = |i: usize| &self.bowls[order[i]];
        let mut best: Vec<Vec<f64>> = (0..n)
            .map(|i| {
                (0..n)
                    .map(|j| {
                        if i == j {
                            bowl(i).depth
                        } else {
                            bowl(i).contact(bowl(j))
                        }
                    })
                    .collect()
            })
            .collect();
        for k in 0..n {
            for i in 0..n {
                for j in 0..n {
                    if i != j {
                        best[i][j] = best[i][j].min(best[i][k].max(best[k][j]));
                    }
                }
            }
        }
        best
    }
}

impl Energy for Bowls {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let choice = self.active_piece(x);
        self.evaluate_piece(x, &choice, gradient)
    }

    fn piecewise(&self) -> Option<&dyn Piecewise> {
        Some(self)
    }
}

impl Piecewise for Bowls {
    fn active_piece(&self, x: &[f64]) -> Vec<u32> {
        let energies = (0..).zip(self.bowls.iter().map(|bowl| bowl.energy(x)));
        let best = energies.min_by(|a, b| a.1.total_cmp(&b.1));
        best.map(|(bowl, _)| bowl).into_iter().collect()
    }

    fn evaluate_piece(&self, x: &[f64], choice: &[u32], gradient: &mut [f64]) -> f64 {
        let bowl = &self.bowls[choice[0] as usize];
        for (d, g) in gradient.iter_mut().enumerate() {
            *g = bowl.stiffness[d] * (x[d] - bowl.centre[d]);
        }
        bowl.energy(x)
    }

    fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], _cutoff: f64) -> f64 {
        self.evaluate(x, gradient)
    }

    fn evaluate_roughly_above(
        &self,
        x: &[f64],
        gradient: &mut [f64],
        _ceiling: f64,
    ) -> (f64, Vec<u32>) {
        (self.evaluate(x, gradient), self.active_piece(x))
    }

    fn with_cache(&self) -> Option<Box<dyn Energy + '_>> {
        None
    }
}

fn bowls_map(energy: &Bowls, minima: Vec<Minimum>) -> Landscape {
    let settings = MapSettings::for_minima(energy, &minima);
    build_landscape(
        energy,
        &Mala::new(energy),
        minima,
        &settings,
        &Run::default(),
    )
    .unwrap()
}

#[test]
fn passes_on_seams_are_exact() {
    for (dimensions, count) in [(2, 5), (6, 8), (12, 6)] {
        let energy = Bowls::random(dimensions, count);
        let (low, high) = (vec![-1.2; dimensions], vec![1.2; dimensions]);
        let minima = minima(&energy, &low, &high, 300);
        let order: Vec<usize> = minima.iter().map(|m| m.choice[0] as usize).collect();
        let exact = energy.exact(&order);
        let found = bowls_map(&energy, minima);
        for (i, row) in exact.iter().enumerate() {
            for (j, known) in row.iter().enumerate() {
                let height = found.tree.minimax(MinimumId(i), MinimumId(j)).unwrap();
                assert!(
                    (height - known).abs() < 1e-4,
                    "{dimensions} dimensions, {i} {j}: {height} {known}"
                );
            }
        }
        for merge in found
            .tree
            .nodes
            .iter()
            .filter(|node| node.minimum.is_none())
        {
            assert_eq!(merge.evidence, Evidence::Seam);
        }
    }
}

#[test]
fn every_descent_ends_in_the_bottom_of_a_bowl() {
    let energy = Bowls::random(6, 8);
    for id in 0..50 {
        let mut rng = stream(9, Task::Start, id);
        let start: Vec<f64> = (0..6).map(|_| rng.random_range(-1.5..1.5)).collect();
        let found = quench(&energy, &start, &QuenchSettings::default());
        let bowl = &energy.bowls[energy.active_piece(&found.x)[0] as usize];
        assert!((found.energy - bowl.depth).abs() < 1e-9);
    }
}

/// All properties of a map that could differ.
fn fingerprint(found: &Landscape) -> String {
    let paths: Vec<_> = found.connections.iter().map(|c| &c.path).collect();
    format!("{}{paths:?}", found.to_json())
}

#[test]
fn threads_order_and_interruption_change_nothing() {
    let energy = Bowls::random(6, 8);
    let mut minima = minima(&energy, &[-1.2; 6], &[1.2; 6], 100);
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
fn a_tree_of_paths_only_may_fall_apart() {
    let energy = Bowls::random(2, 5);
    let minima = minima(&energy, &[-1.2; 2], &[1.2; 2], 100);
    let found = bowls_map(&energy, minima);
    let strict = Tree::from_network(&found.network, Evidence::Saddle);
    // All passes are seams: without them nothing is joined.
    assert_eq!(strict.roots.len(), found.network.node_count());
}

/// A double well cut into bowls at distances of a tenth: it has kinks everywhere but exact heights.
fn rugged() -> Bowls {
    let mut rng = stream(21, Task::Start, 0);
    let mut bowls = Vec::new();
    for column in -14..=14 {
        for row in -7..=7 {
            let mut jitter = || rng.random_range(-0.03..0.03);
            let (x, y) = (
                0.1 * f64::from(column) + jitter(),
                0.1 * f64::from(row) + jitter(),
            );
            let bend = y - 0.4 * (1.0 - x * x);
            bowls.push(Bowl {
                depth: (x * x - 1.0).powi(2) + 2.0 * bend * bend + 0.3 * jitter(),
                stiffness: vec![rng.random_range(10.0..30.0), rng.random_range(10.0..30.0)],
                centre: vec![x, y],
            });
        }
    }
    Bowls {
        space: Euclidean::new(2),
        bowls,
    }
}

#[test]
fn tops_over_close_kinks_are_lowered_to_their_passes() {
    let energy = rugged();
    let deepest = |side: f64| {
        let all = (0..energy.bowls.len()).filter(|i| side * energy.bowls[*i].centre[0] > 0.3);
        all.min_by(|i, j| energy.bowls[*i].depth.total_cmp(&energy.bowls[*j].depth))
            .unwrap()
    };
    let ends = [deepest(-1.0), deepest(1.0)];
    let order: Vec<usize> = ends
        .into_iter()
        .chain((0..energy.bowls.len()).filter(|i| !ends.contains(i)))
        .collect();
    let exact = energy.exact(&order)[0][1];
    let minimum = |i: usize| Minimum {
        coordinates: energy.bowls[i].centre.clone(),
        energy: energy.bowls[i].depth,
        members: vec![i],
        choice: vec![u32::try_from(i).unwrap()],
    };
    let minima = ends.map(minimum).to_vec();
    let mut settings = MapSettings::for_scales(1.0, 1.0);
    settings.path.energy_tolerance = 0.02;
    settings.path.seams = Some(SeamSettings {
        spacing: 0.02,
        moves: 200,
        halvings: 1,
    });
    let found = build_landscape(
        &energy,
        &Mala::new(&energy),
        minima,
        &settings,
        &Run::default(),
    )
    .unwrap();
    let edge = &found.connection(MinimumId(0), MinimumId(1)).unwrap().edge;
    let straight = (0..=1000)
        .map(|k| {
            let t = f64::from(k) / 1000.0;
            let [a, b] = ends.map(|i| &energy.bowls[i].centre);
            let x: Vec<f64> = (0..2).map(|d| a[d] + t * (b[d] - a[d])).collect();
            energy
                .bowls
                .iter()
                .map(|bowl| bowl.energy(&x))
                .fold(f64::INFINITY, f64::min)
        })
        .fold(f64::NEG_INFINITY, f64::max);
    assert!(edge.evidence <= Evidence::Path, "{:?}", edge.evidence);
    assert!(edge.height > exact - 1e-9, "{} {exact}", edge.height);
    // Not above the best sequence of bowls by more than what bowls differ by, and far below the straight line.
    assert!(edge.height < exact + 0.03, "{} {exact}", edge.height);
    assert!(straight > exact + 0.2, "{straight} {exact}");
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
        choice: Vec::new(),
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
