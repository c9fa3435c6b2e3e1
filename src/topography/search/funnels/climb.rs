//! Climbs to saddles with gradients alone, for surfaces of so many dimensions that Hessians cost more than whole descents.
//!
//! Hybrid eigenvector following (L. J. Munro and D. J. Wales, Phys. Rev. B 59, 3969 (1999)): the lowest mode is found by
//! minimising the Rayleigh quotient, a step goes uphill along it, and a few L-BFGS steps go downhill across it.

use std::collections::VecDeque;

use nalgebra::Matrix3;

use crate::space::vector::{add, dot, norm, scale};
use crate::topography::eigen::Scaled;
use crate::topography::search::outcome::SearchEnd;

/// Greatest number of improvements of the mode at the start and after each step.
const FIRST: usize = 30;
const NEXT: usize = 3;
/// Residual of the mode, relative to its curvature, below which it is good enough.
const SHARP: f64 = 0.02;
/// Greatest number of steps across the mode after each step along it: before and after the curvature along it has become
/// negative, and when the steps along it are short.
const ACROSS: [usize; 3] = [4, 10, 25];
/// Steps along the mode below this share of the longest are short.
const SHORT: f64 = 0.05;
/// Steps across the mode that are remembered.
const MEMORY: usize = 8;
/// How often a step across the mode that leaves the domain is shortened, and the factor.
const SHORTENED: (usize, f64) = (6, 0.25);

/// Settings of a climb, in scaled tangents.
#[derive(Clone, Copy)]
pub(super) struct Climbing {
    /// Converged when the norm of the gradient is at most this, energy per length.
    pub(super) tolerance: f64,
    /// Longest step.
    pub(super) longest: f64,
    /// Step of the finite differences of gradients.
    pub(super) difference: f64,
    /// Greatest number of steps along the mode.
    pub(super) steps: usize,
    /// Greatest energy of a saddle of interest.
    pub(super) ceiling: f64,
}

/// The point at which a climb converged. That it is a saddle of index 1 remains to be verified.
pub(super) struct Summit {
    pub(super) x: Vec<f64>,
    pub(super) energy: f64,
    /// The direction of negative curvature, a plain unit tangent.
    pub(super) mode: Vec<f64>,
}

/// A unit tangent, the Hessian times it, and the curvature along it.
struct Mode {
    tangent: Vec<f64>,
    bent: Vec<f64>,
    curvature: f64,
}

struct Climber<'a> {
    surface: &'a Scaled<'a>,
    settings: Climbing,
    free: Vec<Vec<f64>>,
}

/// Climbs from `start`, at first along the lowest mode that resembles `hint` (scaled tangent).
pub(super) fn climb(
    surface: &Scaled<'_>,
    start: &[f64],
    hint: &[f64],
    settings: Climbing,
) -> Result<Summit, SearchEnd> {
    let mut x = start.to_vec();
    let mut gradient = vec![0.0; hint.len()];
    let mut energy = surface.evaluate(&x, &mut gradient);
    if !energy.is_finite() {
        return Err(SearchEnd::Outside);
    }
    // On the way a climb may be higher than the saddle, before it has descended across its mode.
    let most = settings.ceiling.max(energy) + (settings.ceiling - energy).abs();
    let mut climber = Climber {
        surface,
        settings,
        free: Vec::new(),
    };
    let mut direction = hint.to_vec();
    let mut memory = Memory::default();
    for step in 0..settings.steps {
        climber.free = surface.free(&x);
        let effort = if step == 0 { FIRST } else { NEXT };
        let mode = climber
            .sharpened(&x, direction, effort)
            .ok_or(SearchEnd::Outside)?;
        let uphill = mode.curvature >= 0.0;
        if !uphill && norm(&gradient) <= settings.tolerance {
            if energy > settings.ceiling {
                return Err(SearchEnd::High);
            }
            return Ok(Summit {
                x,
                energy,
                mode: plain(surface, &mode.tangent),
            });
        }
        let slope = dot(&gradient, &mode.tangent);
        let newton = if uphill {
            settings.longest.copysign(slope)
        } else {
            slope / -mode.curvature
        };
        let along = newton.clamp(-settings.longest, settings.longest);
        (x, energy) = climber.step(&x, &mode.tangent, along, &mut gradient)?;
        let short = along.abs() < SHORT * settings.longest;
        let across = match (uphill, short) {
            (true, _) => ACROSS[0],
            (false, false) => ACROSS[1],
            (false, true) => ACROSS[2],
        };
        if !short {
            memory.pairs.clear();
        }
        energy = climber.descend(&mut x, energy, &mut gradient, &mode, across, &mut memory);
        if energy > most {
            return Err(SearchEnd::High);
        }
        direction = mode.tangent;
    }
    Err(SearchEnd::Steps)
}

fn plain(surface: &Scaled<'_>, tangent: &[f64]) -> Vec<f64> {
    let mut mode = crate::space::vector::times(tangent, &surface.scales);
    let length = norm(&mode);
    scale(&mut mode, length.recip());
    mode
}

impl Climber<'_> {
    /// The point after a step along the mode, shortened until it is in the domain.
    fn step(
        &self,
        x: &[f64],
        tangent: &[f64],
        mut along: f64,
        gradient: &mut [f64],
    ) -> Result<(Vec<f64>, f64), SearchEnd> {
        for _ in 0..SHORTENED.0 {
            let mut step = tangent.to_vec();
            scale(&mut step, along);
            let there = self.surface.moved(x, &step);
            let energy = self.surface.evaluate(&there, gradient);
            if energy.is_finite() {
                return Ok((there, energy));
            }
            along *= SHORTENED.1;
        }
        Err(SearchEnd::Outside)
    }

    /// L-BFGS steps in the directions perpendicular to the mode. Returns the energy.
    fn descend(
        &self,
        x: &mut Vec<f64>,
        mut energy: f64,
        gradient: &mut Vec<f64>,
        mode: &Mode,
        steps: usize,
        memory: &mut Memory,
    ) -> f64 {
        let across = |gradient: &[f64]| {
            let mut across = gradient.to_vec();
            let along = dot(&across, &mode.tangent);
            add(&mut across, -along, &mode.tangent);
            across
        };
        let mut slope = across(gradient);
        for _ in 0..steps {
            let size = norm(&slope);
            if size <= 0.1 * self.settings.tolerance {
                break;
            }
            let mut step = memory.direction(&slope, self.settings.longest);
            let along = dot(&step, &mode.tangent);
            add(&mut step, -along, &mode.tangent);
            if dot(&step, &slope) >= 0.0 {
                memory.pairs.clear();
                step = memory.direction(&slope, self.settings.longest);
            }
            let length = norm(&step);
            if length > self.settings.longest {
                scale(&mut step, self.settings.longest / length);
            }
            let mut ahead = vec![0.0; gradient.len()];
            let mut accepted = false;
            for _ in 0..SHORTENED.0 {
                let there = self.surface.moved(x, &step);
                let height = self.surface.evaluate(&there, &mut ahead);
                // A small rise is due to the curvature of the path; a large one is a step too far.
                if height.is_finite() && height <= energy + 0.5 * size * norm(&step) {
                    (*x, energy, accepted) = (there, height, true);
                    break;
                }
                memory.pairs.clear();
                scale(&mut step, SHORTENED.1);
            }
            if !accepted {
                break;
            }
            let next = across(&ahead);
            let mut change = next.clone();
            add(&mut change, -1.0, &slope);
            memory.learn(step, change);
            gradient.clone_from(&ahead);
            slope = next;
        }
        energy
    }

    /// The Hessian times a scaled tangent, by a central difference of gradients.
    fn bend(&self, x: &[f64], tangent: &[f64]) -> Option<Vec<f64>> {
        let difference = self.settings.difference;
        let at = |side: f64| {
            let mut step = tangent.to_vec();
            scale(&mut step, side * difference);
            let mut gradient = vec![0.0; tangent.len()];
            let energy = self
                .surface
                .evaluate(&self.surface.moved(x, &step), &mut gradient);
            energy.is_finite().then_some(gradient)
        };
        let (mut ahead, behind) = (at(1.0)?, at(-1.0)?);
        add(&mut ahead, -1.0, &behind);
        scale(&mut ahead, 0.5 / difference);
        Some(ahead)
    }

    fn without_free(&self, tangent: &mut [f64]) {
        for free in &self.free {
            let share = dot(free, tangent);
            add(tangent, -share, free);
        }
    }

    /// Minimises the Rayleigh quotient from `direction` with locally optimal conjugate gradients (A. V. Knyazev, SIAM J. Sci.
    /// Comput. 23, 517 (2001)): each round takes the lowest Ritz vector of the mode, its residual and the last correction.
    /// `None` at the edge of the domain.
    fn sharpened(&self, x: &[f64], mut direction: Vec<f64>, rounds: usize) -> Option<Mode> {
        self.without_free(&mut direction);
        let length = norm(&direction);
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        scale(&mut direction, length.recip());
        let bent = self.bend(x, &direction)?;
        let mut mode = Mode {
            curvature: dot(&direction, &bent),
            tangent: direction,
            bent,
        };
        let mut last: Option<(Vec<f64>, Vec<f64>)> = None;
        for _ in 0..rounds {
            let mut residual = mode.bent.clone();
            add(&mut residual, -mode.curvature, &mode.tangent);
            self.without_free(&mut residual);
            let size = norm(&residual);
            if size <= SHARP * mode.curvature.abs() {
                break;
            }
            scale(&mut residual, size.recip());
            let bent = self.bend(x, &residual)?;
            let mut basis = vec![(mode.tangent, mode.bent), (residual, bent)];
            if let Some(mut correction) = last.take() {
                for (tangent, bent) in &basis {
                    let share = dot(&correction.0, tangent);
                    add(&mut correction.0, -share, tangent);
                    add(&mut correction.1, -share, bent);
                }
                let length = norm(&correction.0);
                if length > 1e-4 {
                    scale(&mut correction.0, length.recip());
                    scale(&mut correction.1, length.recip());
                    basis.push(correction);
                }
            }
            let mut small = Matrix3::zeros();
            for (i, (tangent, _)) in basis.iter().enumerate() {
                for (j, (_, bent)) in basis.iter().enumerate() {
                    small[(i, j)] = dot(tangent, bent);
                }
            }
            if basis.len() < 3 {
                // The unused direction must not be the lowest.
                small[(2, 2)] = 2.0 * small.norm() + f64::MIN_POSITIVE;
            }
            let small = 0.5 * (small + small.transpose());
            let eigen = small.symmetric_eigen();
            let weights = eigen.eigenvectors.column(eigen.eigenvalues.imin());
            let combined = |from: usize| {
                let n = basis[0].0.len();
                let mut sum = (vec![0.0; n], vec![0.0; n]);
                for (weight, (tangent, bent)) in weights.iter().zip(&basis).skip(from) {
                    add(&mut sum.0, *weight, tangent);
                    add(&mut sum.1, *weight, bent);
                }
                sum
            };
            let (mut tangent, mut bent) = combined(0);
            last = Some(combined(1));
            let length = norm(&tangent);
            scale(&mut tangent, length.recip());
            scale(&mut bent, length.recip());
            mode = Mode {
                curvature: dot(&tangent, &bent),
                tangent,
                bent,
            };
        }
        mode.curvature.is_finite().then_some(mode)
    }
}

/// The last steps across the mode and the changes of the gradient.
#[derive(Default)]
struct Memory {
    pairs: VecDeque<(Vec<f64>, Vec<f64>)>,
    /// Inverse curvature along the last step.
    softness: Option<f64>,
}

impl Memory {
    fn learn(&mut self, step: Vec<f64>, change: Vec<f64>) {
        if dot(&step, &change) > 1e-10 * norm(&step) * norm(&change) {
            if self.pairs.len() == MEMORY {
                self.pairs.pop_front();
            }
            self.softness = Some(dot(&step, &change) / dot(&change, &change));
            self.pairs.push_back((step, change));
        }
    }

    /// −H⁻¹g by the two-loop recursion; a tenth of the longest step downhill while nothing is known.
    fn direction(&self, slope: &[f64], longest: f64) -> Vec<f64> {
        let mut direction: Vec<f64> = slope.iter().map(|g| -g).collect();
        let Some(softness) = self.softness else {
            let size = norm(&direction);
            scale(&mut direction, 0.1 * longest / size);
            return direction;
        };
        let mut shares = Vec::with_capacity(self.pairs.len());
        for (step, change) in self.pairs.iter().rev() {
            let share = dot(step, &direction) / dot(step, change);
            add(&mut direction, -share, change);
            shares.push(share);
        }
        scale(&mut direction, softness);
        for ((step, change), share) in self.pairs.iter().zip(shares.into_iter().rev()) {
            let back = dot(change, &direction) / dot(step, change);
            add(&mut direction, share - back, step);
        }
        direction
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::model::{LennardJones, MullerBrown};

    const CLIMBING: Climbing = Climbing {
        tolerance: 1e-5,
        longest: 0.1,
        difference: 1e-5,
        steps: 100,
        ceiling: f64::INFINITY,
    };

    #[test]
    fn climbs_end_at_published_saddles() {
        let energy = MullerBrown::new();
        let surface = Scaled::new(&energy);
        for (start, hint, height) in [
            // Where the lowest mode leads down already.
            ([-0.80, 0.68], [-0.3, -0.8], -40.664843508657),
            ([0.25, 0.27], [-0.8, 0.6], -72.248940112325),
        ] {
            let summit = climb(&surface, &start, &hint, CLIMBING);
            let summit = summit.unwrap_or_else(|end| panic!("from {start:?}: {end:?}"));
            assert!((summit.energy - height).abs() < 1e-8, "{}", summit.energy);
            assert!((norm(&summit.mode) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_climb_leaves_free_directions_alone() {
        // From the octahedron of six atoms.
        let energy = LennardJones::new(6);
        let a = 0.7937;
        let mut x = vec![0.0; 18];
        for (atom, place) in x.chunks_exact_mut(3).enumerate() {
            place[atom / 2] = if atom % 2 == 0 { a } else { -a };
        }
        let hint: Vec<f64> = (0..18).map(|k| f64::from(k % 5) - 1.7).collect();
        let summit = climb(&Scaled::new(&energy), &x, &hint, CLIMBING)
            .ok()
            .unwrap();
        let known = [-12.079031, -11.630307, -11.334033];
        assert!(
            known.iter().any(|e| (e - summit.energy).abs() < 1e-5),
            "{}",
            summit.energy
        );
    }

    #[test]
    fn a_climb_that_leads_nowhere_is_told() {
        let energy = MullerBrown::new();
        let surface = Scaled::new(&energy);
        let low = Climbing {
            ceiling: -100.0,
            ..CLIMBING
        };
        let found = climb(&surface, &[-0.558, 1.44], &[-0.7, -0.7], low);
        assert_eq!(found.err(), Some(SearchEnd::High));
        let short = Climbing {
            steps: 1,
            ..CLIMBING
        };
        let found = climb(&surface, &[-0.558, 1.44], &[-0.7, -0.7], short);
        assert_eq!(found.err(), Some(SearchEnd::Steps));
        let apart = LennardJones::new(2);
        let surface = Scaled::new(&apart);
        let found = climb(&surface, &[0.0; 6], &[1.0; 6], CLIMBING);
        assert_eq!(found.err(), Some(SearchEnd::Outside));
    }
}
