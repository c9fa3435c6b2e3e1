//! Leads a rough path over verified passes, for a smooth energy with ripples.
//!
//! On such a surface the two descents from a pass seldom end in the two minima that a path joins: they end in ripples beside
//! them. The path is then made of legs: the descents on both sides of the pass, and straight ways from their ends to the
//! ends of the path. The highest leg is relaxed as a string and led over a pass of its own, until the highest leg is a pass
//! (as in the growing databases of D. J. Wales, Mol. Phys. 100, 3285 (2002)). No leg is higher than this pass, and the
//! descents from it end on both sides, so it is a verified saddle between the two minima.

use super::images::Images;
use super::pass::{Pass, Peak, Refined};
use super::relax::{Outcome, Relaxation};
use super::{Path, near};
use crate::energy::Energy;
use crate::space::interpolate;
use crate::topography::network::Evidence;

/// Segments of the straight way from the end of a descent.
const PARTS: usize = 8;

/// Greatest number of relaxations of the string of one leg.
const RELAXED: usize = 3;

/// Least distance of the ends of two descents on which a path can be led, as a share of that of two minima: both may end in
/// parts of one minimum.
const APART: f64 = 0.1;

/// A part of a path: a pass with its descents, or a way between two minima with its string, once it is relaxed.
struct Leg<'e> {
    path: Path,
    over_pass: bool,
    images: Option<Images<'e>>,
    /// How often its string was relaxed.
    relaxed: usize,
}

impl Leg<'_> {
    fn way(energy: &dyn Energy, from: &[f64], to: &[f64]) -> Self {
        let space = energy.space();
        let point = |k: usize| interpolate(space, from, to, k as f64 / PARTS as f64);
        Self {
            path: Path::through(energy, (0..=PARTS).map(point).collect()),
            over_pass: false,
            images: None,
            relaxed: 0,
        }
    }
}

impl<'e> Relaxation<'e> {
    /// Leads a roughly relaxed path over passes. Its evidence is that of its highest pass; [`Evidence::Path`] if it rises by
    /// less than a ripple, so that its height is settled to within one; and [`Evidence::Chain`] if a top was no pass.
    pub(super) fn finish_rough(&self, images: Images<'e>, floor: f64) -> Outcome {
        let mut legs = vec![Leg {
            path: images.path.clone(),
            over_pass: false,
            images: Some(images),
            relaxed: 1,
        }];
        let mut passes: Vec<Pass> = Vec::new();
        let mut evidence = Evidence::Chain;
        for _ in 0..3 * self.settings.rounds {
            let highest = highest(&legs);
            let leg = &mut legs[highest];
            if leg.path.height() <= floor + self.settings.roughness {
                evidence = Evidence::Path;
                break;
            }
            if leg.over_pass {
                evidence = Evidence::Saddle;
                break;
            }
            let Some(images) = &leg.images else {
                let images = self.string(&leg.path.images);
                leg.path.clone_from(&images.path);
                (leg.images, leg.relaxed) = (Some(images), 1);
                continue;
            };
            let peak = Peak::of(self.energy, images);
            let found = peak.and_then(|peak| {
                peak.refine(
                    self.energy,
                    floor,
                    self.settings,
                    self.descent,
                    self.sameness,
                )
            });
            let parts = found.and_then(|Refined { pass, .. }| {
                let parts = self.split(&leg.path, &pass, &passes);
                passes.push(pass);
                parts
            });
            if let Some(parts) = parts {
                legs.splice(highest..=highest, parts);
                continue;
            }
            // A top that leads to no new pass may lead to one from a better path.
            let Some(images) = leg.images.as_mut().filter(|_| leg.relaxed < RELAXED) else {
                break;
            };
            images.relax(self.settings.iterations, self.settings.force_tolerance);
            leg.path.clone_from(&images.path);
            leg.relaxed += 1;
        }
        let (path, top) = self.joined(&legs);
        let (height, top) = (path.height(), path.images[top].clone());
        self.verdict(path, height, top, evidence, passes)
    }

    fn string(&self, points: &[Vec<f64>]) -> Images<'e> {
        let mut images = Images::new(
            self.energy,
            points,
            self.settings.segments.div_ceil(2),
            self.settings.max_step,
        );
        images.relax(
            self.settings.coarse_iterations,
            self.settings.force_tolerance,
        );
        images
    }

    /// The way to the nearer foot of a pass, the pass, and the way from its other foot. `None` if the pass leads nowhere
    /// new: both descents end in one minimum, or it is known.
    fn split(&self, leg: &Path, pass: &Pass, known: &[Pass]) -> Option<[Leg<'e>; 3]> {
        let space = self.energy.space();
        let foot = |side: usize| &pass.descents[side].images[pass.descents[side].images.len() - 1];
        let (start, end) = (&leg.images[0], &leg.images[leg.images.len() - 1]);
        let same = |a: &[f64], b: &[f64]| space.distance(a, b) <= APART * self.sameness.distance;
        let old = known.iter().any(|old| {
            (old.energy - pass.energy).abs() <= 1e-3 * self.sameness.energy && same(&old.x, &pass.x)
        });
        if old || same(foot(0), foot(1)) {
            return None;
        }
        let along = |a, b| space.distance(start, foot(a)) + space.distance(foot(b), end);
        let (before, after) = if along(0, 1) <= along(1, 0) {
            (0, 1)
        } else {
            (1, 0)
        };
        let mut over = pass.descents[before].clone().reversed();
        over.images
            .extend_from_slice(&pass.descents[after].images[1..]);
        over.energies
            .extend_from_slice(&pass.descents[after].energies[1..]);
        let (first, last) = (foot(before).clone(), foot(after).clone());
        Some([
            Leg::way(self.energy, start, &first),
            Leg {
                path: over,
                over_pass: true,
                images: None,
                relaxed: 0,
            },
            Leg::way(self.energy, &last, end),
        ])
    }

    /// The points of all legs in order, thinned, and the number of the highest.
    fn joined(&self, legs: &[Leg<'_>]) -> (Path, usize) {
        let mut whole = Path::default();
        for leg in legs {
            whole.images.extend_from_slice(&leg.path.images);
            whole.energies.extend_from_slice(&leg.path.energies);
        }
        let (top, last) = (whole.top(), whole.images.len() - 1);
        whole.images[0].clone_from(&self.ends.0.coordinates);
        whole.images[last].clone_from(&self.ends.1.coordinates);
        whole.unfold(self.energy.space());
        let mut thin = Path::default();
        let mut place = 0;
        for (i, (x, energy)) in whole.images.iter().zip(&whole.energies).enumerate() {
            let far = thin.images.last().is_none_or(|before: &Vec<f64>| {
                near(self.energy.space(), before, x) >= 0.5 * self.settings.max_step
            });
            if far || i == top || i == last {
                if i == top {
                    place = thin.images.len();
                }
                thin.images.push(x.clone());
                thin.energies.push(*energy);
            }
        }
        (thin, place)
    }
}

/// Number of the highest leg, a pass before a way of the same height.
fn highest(legs: &[Leg<'_>]) -> usize {
    let higher = |a: &usize, b: &usize| {
        let (one, other) = (&legs[*a], &legs[*b]);
        let heights = one.path.height().total_cmp(&other.path.height());
        heights.then(one.over_pass.cmp(&other.over_pass))
    };
    (0..legs.len()).max_by(higher).unwrap_or(0)
}
