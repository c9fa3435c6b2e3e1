//! Minimum-energy paths, computed only with Log and Exp of the space.
//!
//! A path is relaxed as a string ([`images`]), and its highest point is refined to a pass ([`pass`]).
//! Descents from the pass decide the evidence ([`relax`]).

mod across;
mod images;
mod lower;
mod pass;
mod relax;
mod rough;
mod settings;
#[cfg(feature = "chemistry")]
mod tops;

pub use pass::Pass;
pub(super) use pass::{descend, descend_one_way, leave_ridges};
pub(super) use relax::relax;
use serde::{Deserialize, Serialize};
pub(super) use settings::HEIGHT_TOLERANCE;
pub use settings::{LoweringSettings, PathSettings};
#[cfg(feature = "chemistry")]
pub(super) use tops::tops;

use super::journal::bits;
use crate::energy::Energy;
use crate::space::Space;
use crate::space::vector::scale;

/// A sequence of points and their energies, stored bit for bit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Path {
    /// Points, as coordinates of the space.
    #[serde(with = "bits::points")]
    pub images: Vec<Vec<f64>>,
    /// Energy of each point.
    #[serde(with = "bits::list")]
    pub energies: Vec<f64>,
}

impl Path {
    /// Highest energy (−∞ for an empty path).
    pub fn height(&self) -> f64 {
        self.energies
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Index of the highest point, the first of equal ones.
    pub fn top(&self) -> usize {
        let height = self.height();
        self.energies.iter().position(|e| *e >= height).unwrap_or(0)
    }

    /// Sum of the distances between neighbours, whose coordinates must be continuous.
    pub fn length(&self, space: &dyn Space) -> f64 {
        self.images
            .windows(2)
            .map(|pair| near(space, &pair[0], &pair[1]))
            .sum()
    }

    /// The reversed path.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        self.images.reverse();
        self.energies.reverse();
        self
    }

    /// Appends a path that starts where this one ends.
    pub(in crate::topography) fn append(&mut self, next: &Self) {
        let skipped = usize::from(!self.images.is_empty());
        self.images
            .extend(next.images.iter().skip(skipped).cloned());
        self.energies.extend(next.energies.iter().skip(skipped));
    }

    /// At most `count` of the points, including the first and the last.
    pub(super) fn thinned(self, count: usize) -> Self {
        let last = self.images.len().saturating_sub(1);
        if last < count {
            return self;
        }
        let rows = (0..count).map(|k| k * last / (count - 1));
        Self {
            images: rows.clone().map(|row| self.images[row].clone()).collect(),
            energies: rows.map(|row| self.energies[row]).collect(),
        }
    }

    /// Adds the highest point of the lines from the top to its neighbours, so that the height is not below that of the way
    /// through the points. Found by golden sections, to about 10⁻⁹ of a line.
    pub(super) fn crest(&mut self, energy: &dyn Energy) {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let (space, top) = (energy.space(), self.top());
        let mut gradient = vec![0.0; space.tangents()];
        let mut tangent = gradient.clone();
        let ends = [
            top.checked_sub(1),
            (top + 1 < self.images.len()).then_some(top + 1),
        ];
        let mut best: Option<(f64, usize, Vec<f64>)> = None;
        for end in ends.into_iter().flatten() {
            let (from, to) = (&self.images[top], &self.images[end]);
            let mut at = |t: f64| {
                let x = between(space, from, to, t, &mut tangent);
                (energy.evaluate(&x, &mut gradient), x)
            };
            let (mut low, mut high) = (0.0, 1.0);
            while high - low > 1e-9 {
                let [a, b] = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
                if at(a).0 >= at(b).0 {
                    high = b;
                } else {
                    low = a;
                }
            }
            let (height, x) = at(0.5 * (low + high));
            if height.is_finite()
                && height > best.as_ref().map_or(self.energies[top], |best| best.0)
            {
                best = Some((height, top.max(end), x));
            }
        }
        if let Some((height, place, x)) = best {
            self.images.insert(place, x);
            self.energies.insert(place, height);
        }
    }

    pub(in crate::topography) fn through(energy: &dyn Energy, images: Vec<Vec<f64>>) -> Self {
        let mut gradient = vec![0.0; energy.space().tangents()];
        let energies = images
            .iter()
            .map(|x| energy.evaluate(x, &mut gradient))
            .collect();
        Self { images, energies }
    }

    /// Replaces every point by its copy nearest to the previous point, so that the coordinates are continuous.
    pub(in crate::topography) fn unfold(&mut self, space: &dyn Space) {
        let mut tangent = vec![0.0; space.tangents()];
        for i in 1..self.images.len() {
            let (before, here) = self.images.split_at_mut(i);
            space.log(&before[i - 1], &here[0], &mut tangent);
            here[0].clone_from(&before[i - 1]);
            space.exp(&mut here[0], &tangent);
        }
    }

    /// As [`Path::unfold`] for points that follow each other, without a search for nearer copies.
    pub(super) fn follow(&mut self, space: &dyn Space) {
        let mut tangent = vec![0.0; space.tangents()];
        for i in 1..self.images.len() {
            let (before, here) = self.images.split_at_mut(i);
            space.log_near(&before[i - 1], &here[0], &mut tangent);
            here[0].clone_from(&before[i - 1]);
            space.exp(&mut here[0], &tangent);
        }
    }
}

pub(super) fn near(space: &dyn Space, a: &[f64], b: &[f64]) -> f64 {
    space.log_near(a, b, &mut vec![0.0; space.tangents()])
}

/// The point at the fraction `t` of the way from `a` to `b`.
fn between(space: &dyn Space, a: &[f64], b: &[f64], t: f64, tangent: &mut [f64]) -> Vec<f64> {
    space.log_near(a, b, tangent);
    scale(tangent, t);
    let mut x = a.to_vec();
    space.exp(&mut x, tangent);
    x
}

/// Points of the geodesic to the nearest copy of `to`, and of the other way round if at most `detour` times as long.
pub(super) fn geodesics(
    space: &dyn Space,
    from: &[f64],
    to: &[f64],
    detour: f64,
) -> Vec<Vec<Vec<f64>>> {
    let mut tangent = vec![0.0; space.tangents()];
    let along = |tangent: &[f64], parts: usize| {
        let point = |k: usize| {
            let mut x = from.to_vec();
            let step: Vec<f64> = (tangent.iter())
                .map(|t| t * k as f64 / parts as f64)
                .collect();
            space.exp(&mut x, &step);
            x
        };
        (0..=parts).map(point).collect::<Vec<_>>()
    };
    let length = space.log(from, to, &mut tangent);
    let mut ways = vec![along(&tangent, 1)];
    let other = space.log_other_way(from, to, &mut tangent);
    if other.is_some_and(|other| other <= detour * length) {
        // This geodesic is longer than half a turn, so only its parts are shortest paths between their ends.
        ways.push(along(&tangent, 4));
    }
    ways
}

/// `segments` + 1 points at equal distances along the polygon through `points`; both ends are kept.
fn spread(space: &dyn Space, points: &[Vec<f64>], segments: usize) -> Vec<Vec<f64>> {
    spread_by(space, points, &vec![1.0; segments])
}

/// Points along the polygon through `points`, spaced in proportion to `shares`; both ends are kept.
fn spread_by(space: &dyn Space, points: &[Vec<f64>], shares: &[f64]) -> Vec<Vec<f64>> {
    let lengths: Vec<f64> = points
        .windows(2)
        .map(|pair| near(space, &pair[0], &pair[1]))
        .collect();
    let total: f64 = lengths.iter().sum();
    let mut tangent = vec![0.0; space.tangents()];
    let (mut segment, mut passed) = (0, 0.0);
    let mut images = vec![points[0].clone()];
    let (whole, mut share_passed) = (shares.iter().sum::<f64>(), 0.0);
    for share in &shares[..shares.len() - 1] {
        share_passed += share;
        let place = total * share_passed / whole;
        while segment + 1 < lengths.len() && passed + lengths[segment] < place {
            passed += lengths[segment];
            segment += 1;
        }
        let share = if lengths[segment] > 0.0 {
            ((place - passed) / lengths[segment]).clamp(0.0, 1.0)
        } else {
            0.0
        };
        images.push(between(
            space,
            &points[segment],
            &points[segment + 1],
            share,
            &mut tangent,
        ));
    }
    images.push(points[points.len() - 1].clone());
    images
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Euclidean;

    #[test]
    fn spread_is_even_and_keeps_the_ends() {
        let space = Euclidean::new(2);
        let points = [vec![0.0, 0.0], vec![3.0, 0.0], vec![3.0, 1.0]];
        let images = spread(&space, &points, 8);
        let path = Path {
            energies: vec![0.0; images.len()],
            images,
        };
        assert_eq!(path.images.len(), 9);
        assert_eq!(path.images[8], points[2]);
        for pair in path.images.windows(2) {
            assert!((space.distance(&pair[0], &pair[1]) - 0.5).abs() < 1e-12);
        }
        assert!((path.length(&space) - 4.0).abs() < 1e-12);
    }
}
