//! Scales of energy and length of a surface. Tolerances and steps are set in these units.

use crate::sample::standard_normal;
use serde::{Deserialize, Serialize};

use super::audit::AuditSettings;
use super::eigen::Scaled;
use super::minima::MatchTolerance;
use super::path::near;
use crate::energy::Energy;
use crate::optimize::{QuenchSettings, quench};
use crate::sample::{Rng, Task, stream};
use crate::space::vector::{norm, scale};

/// Descents from which the scales of a surface are measured.
pub(super) const PROBES: usize = 5;
/// Relative change of the Hessian that defines the length of the surface.
const CHANGE: f64 = 0.5;

/// The two scales of a surface. Tolerances and steps made of them mean the same in any unit of length and energy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// Largest curvature times the squared length. Directions far stiffer than most do not count.
    pub energy: f64,
    /// Distance over which the surface's curvature changes.
    pub length: f64,
}

impl Scales {
    /// Measures the scales of the surface below `points`: the length over which its Hessian changes by half, and the energy
    /// of its largest curvature over that length. Both are medians over the ends of descents from at most five points,
    /// spread evenly over the list. A curvature above thirty times the typical one is cut to that value: such a direction
    /// holds the surface together, and its energies are not those of barriers.
    ///
    /// If no descent ends at a finite energy, `energy` is 1 and `length` is a twentieth of the distance between the points.
    pub fn measured(energy: &dyn Energy, points: &[Vec<f64>]) -> Self {
        let count = points.len().min(PROBES);
        let probes: Vec<_> = (0..count)
            .map(|k| points[k * points.len() / count].clone())
            .collect();
        Self::below(energy, &probes, 0)
    }

    /// Like [`Scales::measured`], but below all of `points` and with random directions drawn from `seed`.
    pub(super) fn below(energy: &dyn Energy, points: &[Vec<f64>], seed: u64) -> Self {
        let space = energy.space();
        let pairs = points
            .windows(2)
            .map(|pair| near(space, &pair[0], &pair[1]));
        let size = median(pairs.collect())
            .filter(|size| *size > 0.0)
            .or_else(|| points.first().map(|x| norm(x)))
            .filter(|size| *size > 0.0 && size.is_finite())
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
        Self {
            energy: median(energies).unwrap_or(1.0),
            length: median(lengths).unwrap_or(0.05 * size),
        }
    }

    /// Settings of descents on this surface.
    pub fn quench(&self) -> QuenchSettings {
        QuenchSettings::default()
            .with_max_step(self.length)
            .with_gradient_tolerance(1e-8 * self.energy / self.length)
    }

    /// Tolerance within which two stationary points of this surface are the same.
    pub fn sameness(&self) -> MatchTolerance {
        MatchTolerance::for_scales(self.energy, self.length)
    }

    /// Greatest gradient norm of a minimum, in energy per length (from [`Scales::audit`]).
    pub fn gradient_tolerance(&self) -> f64 {
        self.audit().gradient_tolerance
    }

    /// Settings of the audit of points found with [`Scales::quench`].
    pub fn audit(&self) -> AuditSettings {
        AuditSettings::for_descents(&self.quench(), &self.sameness(), self.length)
    }
}

/// Returns the distance from `bottom`, in a random direction, at which the Hessian has changed by [`CHANGE`] (at most
/// `size`), and the largest curvature at `bottom`. Outlying curvatures are cut to
/// [`Modes::stiffness`](super::eigen::Modes).
fn reach(
    energy: &dyn Energy,
    bottom: &[f64],
    size: f64,
    id: usize,
    seed: u64,
) -> Option<(f64, f64)> {
    let surface = Scaled::new(energy);
    let difference = 1e-5 * size;
    let modes = surface.modes(bottom, difference)?;
    let stiffness = modes.stiffness();
    let here = modes.tempered(surface.hessian(bottom, difference)?);
    let mut rng = stream(seed, Task::Saddle, u64::MAX - id as u64);
    let mut step = random_tangent(surface.scales.len(), 1e-3 * size, &mut rng);
    let mut length = 1e-3 * size;
    while length < size {
        let Some(there) = surface.hessian(&surface.moved(bottom, &step), difference) else {
            break;
        };
        if (modes.tempered(there) - &here).norm() >= CHANGE * here.norm() {
            break;
        }
        length *= 1.5;
        scale(&mut step, 1.5);
    }
    (stiffness > 0.0).then_some((length, stiffness))
}

/// Draws a tangent of the given length in a random direction.
pub(super) fn random_tangent(dimensions: usize, length: f64, rng: &mut Rng) -> Vec<f64> {
    let mut tangent: Vec<f64> = (0..dimensions).map(|_| standard_normal(rng)).collect();
    let norm = norm(&tangent);
    scale(&mut tangent, length / norm);
    tangent
}

/// The median, the upper one of an even number of values.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
