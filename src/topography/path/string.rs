//! A string of images that relaxes perpendicular to itself.

use std::sync::Arc;

use super::{Path, near, spread};
use crate::energy::Energy;
use crate::optimize::Fire;
use crate::space::vector::{add, dot, norm, scale, times};

/// Segments may differ in length by this factor before they are made equal again.
const UNEVEN: f64 = 1.5;

/// Images joined by geodesics; the ends and the pinned images stay where they are.
///
/// The string method of W. E, W. Ren and E. Vanden-Eijnden, J. Chem. Phys. 126, 164103 (2007), with the upwind tangent
/// of G. Henkelman and H. Jónsson, J. Chem. Phys. 113, 9978 (2000), and one FIRE an image: with the tangent given, the
/// perpendicular forces of different images know nothing of each other, so a stiff image does not slow the others.
#[derive(Clone)]
pub(super) struct Band<'e> {
    energy: &'e dyn Energy,
    /// The energy as each image sees it, where it has a memory.
    local: Vec<Option<Arc<dyn Energy + 'e>>>,
    scales: Vec<f64>,
    longest: f64,
    pub(super) path: Path,
    pub(super) gradients: Vec<Vec<f64>>,
    pub(super) pinned: Vec<bool>,
    /// Energy above which images need not be known exactly.
    pub(super) ceiling: f64,
    fire: Vec<Fire>,
}

impl<'e> Band<'e> {
    /// A string through `points` with `segments` equal segments. Moves at most `longest` an
    /// iteration; energies above `ceiling` need not be exact.
    pub(super) fn new(
        energy: &'e dyn Energy,
        points: &[Vec<f64>],
        segments: usize,
        (longest, ceiling): (f64, f64),
    ) -> Self {
        let images = spread(energy.space(), points, segments);
        let pinned = vec![false; images.len()];
        Self::with_images(energy, images, pinned, (longest, ceiling))
    }

    fn with_images(
        energy: &'e dyn Energy,
        images: Vec<Vec<f64>>,
        mut pinned: Vec<bool>,
        (longest, ceiling): (f64, f64),
    ) -> Self {
        let space = energy.space();
        let count = images.len();
        let mut gradients = vec![vec![0.0; space.tangents()]; count];
        let local: Vec<Option<Arc<dyn Energy + 'e>>> =
            (0..count).map(|_| energy.local().map(Arc::from)).collect();
        let energies = (images.iter().zip(&local))
            .zip(&mut gradients)
            .map(|((x, local), gradient)| {
                let energy = local.as_deref().unwrap_or(energy);
                energy.evaluate_roughly_above(x, gradient, ceiling)
            })
            .collect();
        pinned[0] = true;
        pinned[count - 1] = true;
        Self {
            energy,
            local,
            scales: space.step_scales(),
            longest,
            path: Path { images, energies },
            gradients,
            pinned,
            ceiling,
            fire: vec![Fire::new(space.tangents(), longest); count],
        }
    }

    /// The same string with an image in the middle of every segment.
    pub(super) fn doubled(self) -> Self {
        let space = self.energy.space();
        let mut tangent = vec![0.0; space.tangents()];
        let (mut images, mut pinned) = (Vec::new(), Vec::new());
        let mut previous: Option<Vec<f64>> = None;
        for (image, pin) in self.path.images.into_iter().zip(self.pinned) {
            if let Some(last) = &previous {
                images.push(super::between(space, last, &image, 0.5, &mut tangent));
                pinned.push(false);
            }
            images.push(image.clone());
            pinned.push(pin);
            previous = Some(image);
        }
        Self::with_images(self.energy, images, pinned, (self.longest, self.ceiling))
    }

    /// Holds image `i` at `x` from now on.
    pub(super) fn pin(&mut self, i: usize, x: &[f64], energy: f64) {
        self.path.images[i] = x.to_vec();
        self.path.energies[i] = energy;
        self.gradients[i].fill(0.0);
        self.pinned[i] = true;
    }

    /// Relaxes until the greatest perpendicular force is at most `tolerance`, or for `iterations`; returns that force.
    pub(super) fn relax(&mut self, iterations: usize, tolerance: f64) -> f64 {
        for _ in 0..iterations {
            let forces: Vec<Vec<f64>> = (0..self.path.images.len())
                .map(|i| self.perpendicular(i))
                .collect();
            let worst = self.worst(&forces);
            if worst <= tolerance {
                return worst;
            }
            self.advance(&forces);
        }
        let forces: Vec<Vec<f64>> = (0..self.path.images.len())
            .map(|i| self.perpendicular(i))
            .collect();
        self.worst(&forces)
    }

    fn worst(&self, forces: &[Vec<f64>]) -> f64 {
        let free = forces.iter().zip(&self.pinned).filter(|(_, pin)| !**pin);
        free.map(|(force, _)| norm(&times(force, &self.scales)))
            .fold(0.0, f64::max)
    }

    /// Unit tangent at an inner image, toward rising energy.
    pub(super) fn tangent(&self, i: usize) -> Vec<f64> {
        let space = self.energy.space();
        let (images, energies) = (&self.path.images, &self.path.energies);
        let mut ahead = vec![0.0; space.tangents()];
        let mut behind = ahead.clone();
        space.toward_near(&images[i], &images[i + 1], &mut ahead);
        space.toward_near(&images[i], &images[i - 1], &mut behind);
        scale(&mut behind, -1.0);
        let (up, down) = (energies[i + 1] - energies[i], energies[i - 1] - energies[i]);
        let (most, least) = (up.abs().max(down.abs()), up.abs().min(down.abs()));
        let (forward, backward) = if !most.is_finite() {
            (1.0, 1.0)
        } else if up > 0.0 && down <= 0.0 {
            (1.0, 0.0)
        } else if up <= 0.0 && down > 0.0 {
            (0.0, 1.0)
        } else if energies[i + 1] > energies[i - 1] {
            (most, least)
        } else {
            (least, most)
        };
        scale(&mut ahead, forward);
        add(&mut ahead, backward, &behind);
        let length = norm(&ahead);
        if length > 0.0 {
            scale(&mut ahead, length.recip());
        }
        ahead
    }

    /// Force across the path at image `i`; zero at pinned images and outside the domain.
    fn perpendicular(&self, i: usize) -> Vec<f64> {
        let mut force = vec![0.0; self.scales.len()];
        if !self.pinned[i] && self.path.energies[i].is_finite() {
            let tangent = self.tangent(i);
            add(&mut force, -1.0, &self.gradients[i]);
            let along = dot(&force, &tangent);
            add(&mut force, -along, &tangent);
        }
        force
    }

    fn advance(&mut self, forces: &[Vec<f64>]) {
        let space = self.energy.space();
        let mut images = self.path.images.clone();
        let mut step = vec![0.0; self.scales.len()];
        for (i, image) in images.iter_mut().enumerate() {
            if !self.pinned[i] {
                self.fire[i].advance(&times(&forces[i], &self.scales), &mut step);
                space.shift(image, &times(&step, &self.scales));
            }
        }
        self.even_out(&mut images);
        for (i, image) in images.into_iter().enumerate() {
            if self.pinned[i] {
                continue;
            }
            let mut gradient = vec![0.0; self.scales.len()];
            let local = self.local[i].as_deref().unwrap_or(self.energy);
            let energy = local.evaluate_roughly_above(&image, &mut gradient, self.ceiling);
            if energy.is_finite() || !self.path.energies[i].is_finite() {
                self.path.images[i] = image;
                self.path.energies[i] = energy;
                self.gradients[i] = gradient;
            } else {
                self.fire[i].refuse();
            }
        }
    }

    /// Makes the segments between two pinned images equally long, where they differ much.
    fn even_out(&self, images: &mut [Vec<f64>]) {
        let space = self.energy.space();
        let pins: Vec<usize> = (0..images.len()).filter(|i| self.pinned[*i]).collect();
        for ends in pins.windows(2) {
            let section = &images[ends[0]..=ends[1]];
            let lengths: Vec<f64> = section
                .windows(2)
                .map(|pair| near(space, &pair[0], &pair[1]))
                .collect();
            let longest = lengths.iter().copied().fold(0.0, f64::max);
            let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
            if longest > UNEVEN * shortest {
                let even = spread(space, section, lengths.len());
                images[ends[0] + 1..ends[1]].clone_from_slice(&even[1..lengths.len()]);
            }
        }
    }
}
