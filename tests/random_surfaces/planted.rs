//! Is the support of merges worth what it says? Random surfaces whose trees are known are bent into spaces of 2 to 20 angles,
//! where straight lines between their minima cross walls.

use std::f64::consts::TAU;

use landscape::energy::Energy;
use landscape::sample::{Mala, Task, stream};
use landscape::space::{Space, Torus};
use landscape::topography::{
    Evidence, FamilySettings, MapSettings, Minimum, MinimumId, Run, Tree, build_landscape,
};
use rand::RngExt;
use rayon::prelude::*;

use super::{Surface, detour, search};

/// Modes of the plane surfaces: about twelve minima.
const MODES: i32 = 3;

/// Two heights that differ by less are one.
const SAME: f64 = 1e-3;

/// A plane surface V, bent into more angles.
///
/// ```text
/// E(x) = V(y₀, y₁) + s Σ_{i ≥ 2} (1 − cos yᵢ),   y₀ = x₀,   yᵢ = xᵢ + aᵢ sin(kᵢ x_{i−1} + φᵢ)
/// ```
///
/// The map from x to y has an inverse, and no pass of V is as high as s, so that E has the minima, passes and tree of V.
struct Bent {
    space: Torus,
    plane: Surface,
    stiffness: f64,
    bends: Vec<[f64; 3]>,
}

impl Bent {
    /// Surface `id` in 2 to 20 dimensions.
    fn random(id: u64) -> Self {
        let mut rng = stream(4051, Task::Surface, id);
        let dimensions = rng.random_range(2..=20);
        let plane = Surface::random(MODES, id + 10_000);
        let steep = rng.random_range(0.0..2.0);
        let bends = (1..dimensions)
            .map(|_| {
                let wave = f64::from(rng.random_range(1..=2));
                [
                    steep * rng.random::<f64>(),
                    wave,
                    rng.random_range(0.0..TAU),
                ]
            })
            .collect();
        Self {
            space: Torus::new(dimensions),
            stiffness: plane.curvature_bound(),
            plane,
            bends,
        }
    }

    fn bend(&self, i: usize, before: f64) -> (f64, f64) {
        let [a, k, phase] = self.bends[i - 1];
        let (sine, cosine) = libm::sincos(k * before + phase);
        (a * sine, a * k * cosine)
    }

    /// The point of a minimum of V.
    fn lifted(&self, y: &[f64]) -> Vec<f64> {
        let mut x = vec![y[0]];
        for i in 1..self.space.tangents() {
            let level = y.get(i).copied().unwrap_or(0.0);
            x.push(level - self.bend(i, x[i - 1]).0);
        }
        x
    }
}

impl Energy for Bent {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let count = x.len();
        let bent: Vec<(f64, f64)> = (1..count).map(|i| self.bend(i, x[i - 1])).collect();
        let y = |i: usize| x[i] + bent[i - 1].0;
        let mut plane = [0.0; 2];
        let mut energy = self.plane.evaluate(&[x[0], y(1)], &mut plane);
        gradient[0] = plane[0];
        gradient[1] = plane[1];
        for (i, slope) in gradient.iter_mut().enumerate().skip(2) {
            let (sine, cosine) = libm::sincos(y(i));
            energy += self.stiffness * (1.0 - cosine);
            *slope = self.stiffness * sine;
        }
        for i in 1..count {
            gradient[i - 1] += gradient[i] * bent[i - 1].1;
        }
        energy
    }
}

/// What the map says of a merge, and whether it is the lowest.
pub(super) struct Judged {
    pub(super) lower: f64,
    pub(super) uncertainty: f64,
    /// How much too high it is.
    pub(super) above: f64,
}

/// The merges of the map of a surface.
fn judged(id: u64) -> Vec<Judged> {
    let energy = Bent::random(id);
    let found = search(&energy.plane, id);
    if found.minima.len() < 3 {
        return Vec::new();
    }
    let truth = found
        .landscape(&energy.plane, &FamilySettings::default())
        .tree;
    let minima: Vec<Minimum> = found
        .minima
        .iter()
        .map(|minimum| Minimum {
            coordinates: energy.lifted(&minimum.coordinates),
            ..minimum.clone()
        })
        .collect();
    let settings = MapSettings {
        neighbours: 1 + usize::try_from(id % 4).unwrap(),
        seed: id,
        ..MapSettings::for_minima(&energy, &minima)
    };
    let map = build_landscape(
        &energy,
        &Mala::new(&energy),
        minima,
        &settings,
        &Run::default(),
    )
    .unwrap();
    assert!(
        map.rejected.is_empty() && map.network.node_count() == found.minima.len(),
        "surface {id}"
    );
    let lowest = |tree: &Tree, branch: usize| -> usize {
        let mut rest = vec![branch];
        let mut least = usize::MAX;
        while let Some(node) = rest.pop() {
            if tree.nodes[node].children.is_empty() {
                least = least.min(node);
            }
            rest.extend(tree.nodes[node].children.iter().map(|child| child.0));
        }
        least
    };
    let searched = map.attempts.of_merges(&map.tree);
    let merges = map.tree.nodes.iter().zip(searched);
    merges
        .filter_map(|(node, searched)| {
            let searched = searched?;
            let sides: Vec<usize> = node
                .children
                .iter()
                .map(|child| lowest(&map.tree, child.0))
                .collect();
            let least = sides[1..].iter().map(|side| {
                truth
                    .minimax(MinimumId(sides[0]), MinimumId(*side))
                    .unwrap()
            });
            let above = node.energy - least.fold(f64::INFINITY, f64::min);
            // The images of a chain may miss a ridge between them.
            assert!(
                above > -SAME || node.evidence == Evidence::Chain,
                "surface {id}: a merge is {above} below the tree"
            );
            Some(Judged {
                lower: searched.lower,
                uncertainty: searched.uncertainty,
                above,
            })
        })
        .collect()
}

/// Bins of the chance of a lower way.
const BINS: [(f64, f64); 4] = [(0.0, 0.05), (0.05, 0.15), (0.15, 0.4), (0.4, 1.0)];

/// The table of reliability: a merge is told right if a lower way exists as often as its chance says.
fn check(surfaces: std::ops::Range<u64>, judged: impl Fn(u64) -> Vec<Judged> + Sync + Send) {
    let all: Vec<Judged> = surfaces.into_par_iter().flat_map_iter(judged).collect();
    let mut complaints = Vec::new();
    for (low, high) in BINS {
        let within = all
            .iter()
            .filter(|merge| merge.lower > low && merge.lower <= high);
        let within: Vec<&Judged> = within.collect();
        let count = within.len() as f64;
        let told: f64 = within.iter().map(|merge| merge.lower).sum();
        let spread: f64 = within
            .iter()
            .map(|merge| merge.lower * (1.0 - merge.lower))
            .sum::<f64>()
            .sqrt();
        let false_ones = within.iter().filter(|merge| merge.above > SAME).count();
        let beyond = within
            .iter()
            .filter(|merge| merge.above > merge.uncertainty + SAME)
            .count();
        let largest = within.iter().map(|merge| merge.above).fold(0.0, f64::max);
        println!(
            "chance {low} to {high}: {count} merges, lower ways told {told:.1}, exist {false_ones}, above by more than the \
             uncertainty {beyond}, largest {largest:.2}"
        );
        if false_ones as f64 > told + 2.0 * spread + 1.0 {
            complaints.push(format!("{low} to {high}"));
        }
    }
    assert!(
        complaints.is_empty(),
        "more lower ways exist than told: {complaints:?}"
    );
}

#[test]
fn support_is_worth_what_it_says() {
    check(0..16, judged);
}

#[test]
#[ignore = "minutes: 200 surfaces"]
fn support_is_worth_what_it_says_on_many_surfaces() {
    check(16..216, judged);
}

#[test]
fn searches_find_detours_that_lead_away() {
    check(0..6, detour::judged);
}
