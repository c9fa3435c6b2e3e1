//! A surface with an additional direction that is a million times as stiff and not aligned with any axis.

use landscape::energy::Energy;
use landscape::energy::model::Surface;
use landscape::sample::{Rng, Task, stream};
use landscape::space::{Euclidean, Space};
use landscape::topography::{
    Exploration, FamilySettings, Run, Scales, SearchSettings, distinct, explore, in_box, quench_all,
};
use rand::RngExt;

/// E(x) + ½ k u² for a surface in the plane, with (x, u) rotated.
struct Stiff<'a> {
    surface: &'a Surface,
    stiffness: f64,
    space: Euclidean,
}

/// An orthonormal matrix: the quaternion (1, 2, 3, 4) as a rotation.
const TURN: [[f64; 3]; 3] = [
    [-20.0 / 30.0, 4.0 / 30.0, 22.0 / 30.0],
    [20.0 / 30.0, -10.0 / 30.0, 20.0 / 30.0],
    [10.0 / 30.0, 28.0 / 30.0, 4.0 / 30.0],
];

impl<'a> Stiff<'a> {
    fn new(surface: &'a Surface, stiffness: f64) -> Self {
        assert_eq!(surface.energy.space().tangents(), 2);
        Self {
            surface,
            stiffness,
            space: Euclidean::new(3),
        }
    }

    fn turned(x: &[f64; 3]) -> Vec<f64> {
        (0..3)
            .map(|i| (0..3).map(|j| TURN[i][j] * x[j]).sum())
            .collect()
    }

    fn back(x: &[f64]) -> [f64; 3] {
        [0, 1, 2].map(|j| (0..3).map(|i| TURN[i][j] * x[i]).sum())
    }

    fn draw(&self, rng: &mut Rng) -> Vec<f64> {
        let x = in_box(&self.surface.low, &self.surface.high)(rng);
        Self::turned(&[x[0], x[1], rng.random_range(-0.5..0.5)])
    }
}

impl Energy for Stiff<'_> {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let [x, y, u] = Self::back(x);
        let mut slope = [0.0; 3];
        let energy = self.surface.energy.evaluate(&[x, y], &mut slope[..2]);
        slope[2] = self.stiffness * u;
        gradient.copy_from_slice(&Self::turned(&slope));
        energy + 0.5 * self.stiffness * u * u
    }
}

/// Surfaces in the plane and the largest curvature of their minima.
fn surfaces() -> Vec<(Surface, f64)> {
    let known = super::scaled::surfaces().into_iter();
    let plane = known.filter(|surface| surface.coordinates == "flat");
    plane
        .map(|surface| {
            let (found, _) = explored(&*surface.energy, &in_box(&surface.low, &surface.high));
            let stiffest = found.audits.iter().flat_map(|audit| &audit.curvatures);
            let stiffest = stiffest.copied().fold(0.0, f64::max);
            (surface, stiffest)
        })
        .collect()
}

fn explored(
    energy: &dyn Energy,
    draw: &(dyn Fn(&mut Rng) -> Vec<f64> + Sync),
) -> (Exploration, Vec<f64>) {
    let settings = SearchSettings::measured(energy, draw, 1);
    let found = explore(energy, draw, &settings, &Run::default()).unwrap();
    let landscape = found.landscape(energy, &FamilySettings::default());
    let merges = landscape.tree.nodes.iter().filter(|n| n.minimum.is_none());
    let heights = merges.map(|node| node.energy).collect();
    (found, heights)
}

fn assert_near(found: &[f64], known: &[f64], what: &str) {
    assert_eq!(found.len(), known.len(), "{what}: {found:?}, {known:?}");
    for (found, known) in found.iter().zip(known) {
        let near = (found - known).abs() < 1e-6 * (1.0 + known.abs());
        assert!(near, "{what}: {found} instead of {known}");
    }
}

#[test]
fn one_stiff_direction_hides_nothing() {
    for (surface, stiffest) in surfaces() {
        let plain = in_box(&surface.low, &surface.high);
        let (known, heights) = explored(&*surface.energy, &plain);
        for ratio in [1e2, 1e4, 1e6] {
            let what = format!("{}, {ratio:e}", surface.name);
            let energy = Stiff::new(&surface, ratio * stiffest);
            let (found, merges) = explored(&energy, &|rng: &mut Rng| energy.draw(rng));
            let points = |found: &Exploration| -> (Vec<f64>, Vec<f64>) {
                let minima = found.minima.iter().map(|m| m.energy).collect();
                (minima, found.saddles.iter().map(|s| s.energy).collect())
            };
            let ((minima, saddles), (known_minima, known_saddles)) =
                (points(&found), points(&known));
            assert_near(&minima, &known_minima, &what);
            assert_near(&saddles, &known_saddles, &what);
            assert_near(&merges, &heights, &what);
            let saddles = found.saddles.iter().map(|saddle| &saddle.audit);
            for audit in found.audits.iter().chain(saddles) {
                // A thousandth of a millionth of what the surface's own curvatures give over a length of 1.
                let gradient = audit.gradient_norm;
                assert!(gradient < 1e-5 * stiffest, "{what}: {gradient}");
            }
        }
    }
}

#[test]
fn descents_are_not_misled_by_a_stiff_direction() {
    for (surface, stiffest) in surfaces() {
        let (known, _) = explored(&*surface.energy, &in_box(&surface.low, &surface.high));
        let energy = Stiff::new(&surface, 1e6 * stiffest);
        let starts: Vec<Vec<f64>> = (0..60)
            .map(|id| energy.draw(&mut stream(1, Task::Start, id)))
            .collect();
        let scales = Scales::measured(&energy, &starts);
        let quenches = quench_all(&energy, &starts, &scales.quench(), &Run::default()).unwrap();
        let tolerance = scales.gradient_tolerance();
        let (minima, rejected) = distinct(&energy, &quenches, &scales.sameness(), tolerance);
        assert!(rejected.is_empty(), "{}: {rejected:?}", surface.name);
        let energies: Vec<f64> = minima.iter().map(|m| m.energy).collect();
        let known: Vec<f64> = known.minima.iter().map(|m| m.energy).collect();
        assert_near(&energies, &known, &surface.name);
    }
}
