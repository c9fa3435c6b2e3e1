//! Settings of the search, and how they are measured.

use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use super::Draw;
use crate::energy::Energy;
use crate::optimize::{QuenchSettings, quench};
use crate::sample::{Rng, Task, stream};
use crate::space::vector::{norm, scale};
use crate::topography::audit::AuditSettings;
use crate::topography::eigen::Piece;
use crate::topography::minima::Sameness;
use crate::topography::path::{PathMethod, near};

/// Starts from which the scales of a surface are measured.
const PROBES: u64 = 5;
/// Share by which the Hessian changes over the length of the surface.
const CHANGE: f64 = 0.5;

/// Settings of [`explore`](super::explore). [`SearchSettings::measured`] sets everything that has a unit from the surface
/// itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SearchSettings {
    /// Distance over which the surface's curvature changes: the longest step of a search.
    pub length: f64,
    /// Energy of its largest curvatures over that distance.
    pub energy: f64,
    /// Descents.
    pub quench: QuenchSettings,
    /// When two stationary points are one.
    pub sameness: Sameness,
    /// Steps of one search.
    pub steps: usize,
    /// Modes followed from each minimum, both ways; the softest first.
    pub modes: usize,
    /// Searches between two looks at what is known. Part of the result, so it must not depend on threads.
    pub batch: usize,
    /// The search ends after this many searches without anything new for every stationary point found.
    pub patience: usize,
    /// Most searches.
    pub max_searches: usize,
    /// Rounds that join minima which no saddle joins, by relaxing paths.
    pub join_rounds: usize,
    /// What keeps the images of those paths apart.
    pub paths: PathMethod,
    /// Seed of every draw.
    pub seed: u64,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self::for_scales(1.0, 1.0)
    }
}

impl SearchSettings {
    /// Settings for a surface whose curvature changes over `length` and that rises by about `energy` over it.
    pub fn for_scales(energy: f64, length: f64) -> Self {
        Self {
            length,
            energy,
            quench: QuenchSettings::default()
                .with_max_step(length)
                .with_gradient_tolerance(1e-8 * energy / length),
            sameness: Sameness {
                energy: 1e-6 * energy,
                distance: 0.01 * length,
            },
            steps: 80,
            modes: 1000,
            batch: 32,
            patience: 30,
            max_searches: 100_000,
            join_rounds: 2,
            paths: PathMethod::default(),
            seed: 0,
        }
    }

    /// Settings from the surface: below a few random points, the length over which its Hessian changes by half, and the
    /// energy of the largest curvature over that length (medians).
    ///
    /// Where no descent ends in a finite energy the distances between the points themselves have to do.
    pub fn measured(energy: &dyn Energy, draw: &Draw<'_>, seed: u64) -> Self {
        let points: Vec<Vec<f64>> = (0..PROBES)
            .map(|id| draw(&mut stream(seed, Task::Start, u64::MAX - id)))
            .collect();
        let space = energy.space();
        let pairs = points
            .windows(2)
            .map(|pair| near(space, &pair[0], &pair[1]));
        let size = median(pairs.collect())
            .filter(|size| *size > 0.0)
            .unwrap_or(1.0);
        let coarse = QuenchSettings::default()
            .with_max_step(0.05 * size)
            .with_gradient_tolerance(0.0)
            .with_max_evaluations(200);
        let (mut lengths, mut energies) = (Vec::new(), Vec::new());
        for (id, point) in points.iter().enumerate() {
            let bottom = quench(energy, point, &coarse);
            if let Some((length, stiffness)) = reach(energy, &bottom.x, size, id, seed) {
                lengths.push(length);
                energies.push(stiffness * length * length);
            }
        }
        let length = median(lengths).unwrap_or(0.05 * size);
        let mut settings = Self::for_scales(median(energies).unwrap_or(1.0), length);
        settings.seed = seed;
        settings
    }

    /// Replaces the seed.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Replaces the number of idle searches for every stationary point found.
    #[must_use]
    pub fn with_patience(mut self, patience: usize) -> Self {
        self.patience = patience;
        self
    }

    /// How the points found are audited.
    pub fn audit(&self) -> AuditSettings {
        AuditSettings {
            // Where rounding ends a descent a little early the point is as good.
            gradient_tolerance: 10.0 * self.quench.gradient_tolerance,
            difference: 1e-4 * self.length,
            sameness: self.sameness,
            quench: self.quench.clone(),
        }
    }
}

/// How far from `bottom`, in a random direction, the Hessian has changed by [`CHANGE`] (at most `size`), and the largest
/// curvature at `bottom`.
fn reach(
    energy: &dyn Energy,
    bottom: &[f64],
    size: f64,
    id: usize,
    seed: u64,
) -> Option<(f64, f64)> {
    let piece = Piece::new(energy, energy.choice(bottom));
    let difference = 1e-5 * size;
    let here = piece.hessian(bottom, difference)?;
    let stiffness = piece.modes(bottom, difference)?.stiffest();
    let mut rng = stream(seed, Task::Saddle, u64::MAX - id as u64);
    let mut step = random_tangent(piece.scales.len(), 1e-3 * size, &mut rng);
    let mut length = 1e-3 * size;
    while length < size {
        let Some(there) = piece.hessian(&piece.moved(bottom, &step), difference) else {
            break;
        };
        if (&there - &here).norm() >= CHANGE * here.norm() {
            break;
        }
        length *= 1.5;
        scale(&mut step, 1.5);
    }
    (stiffness > 0.0).then_some((length, stiffness))
}

/// A tangent of this length in a random direction.
pub(super) fn random_tangent(dimensions: usize, length: f64, rng: &mut Rng) -> Vec<f64> {
    let mut tangent: Vec<f64> = (0..dimensions)
        .map(|_| StandardNormal.sample(rng))
        .collect();
    let norm = norm(&tangent);
    scale(&mut tangent, length / norm);
    tangent
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
