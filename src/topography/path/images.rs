//! Images along a path that relax together as a string.
//!
//! Every image moves by the force across the path, and the images are redistributed at even distances (W. E, W. Ren and E.
//! Vanden-Eijnden, J. Chem. Phys. 126, 164103 (2007)). The tangent is the upwind one of G. Henkelman and H. Jónsson, J. Chem.
//! Phys. 113, 9978 (2000).

use super::{Path, between, near, spread_by};
use crate::energy::Energy;
use crate::optimize::Fire;
use crate::space::vector::{add, dot, norm, scale, times};

/// Ratio of segment lengths (relative to their shares) above which a string is redistributed.
const UNEVEN: f64 = 1.5;

/// Images joined by geodesics. The ends and the pinned images are fixed.
///
/// Each image has its own FIRE optimiser. Given the tangents, the forces on different images are independent, so a stiff
/// image does not slow the others. There is no total energy; only the forces show convergence.
#[derive(Clone)]
pub(super) struct Images<'e> {
    energy: &'e dyn Energy,
    scales: Vec<f64>,
    /// Longest step of an image in an iteration.
    longest: f64,
    pub(super) path: Path,
    pub(super) gradients: Vec<Vec<f64>>,
    pub(super) pinned: Vec<bool>,
    /// Length of each segment relative to the others.
    shares: Vec<f64>,
    fire: Vec<Fire>,
}

impl<'e> Images<'e> {
    /// Places images at the ends of `segments` equal segments of the polygon through `points`.
    pub(super) fn new(
        energy: &'e dyn Energy,
        points: &[Vec<f64>],
        segments: usize,
        longest: f64,
    ) -> Self {
        let space = energy.space();
        let shares = vec![1.0; segments];
        let mut images = Self {
            energy,
            scales: space.step_scales(),
            longest,
            path: Path::default(),
            gradients: Vec::new(),
            pinned: Vec::new(),
            fire: Vec::new(),
            shares: Vec::new(),
        };
        for x in spread_by(space, points, &shares) {
            images.push(x);
        }
        images.shares = shares;
        images.pinned[0] = true;
        images.pinned[segments] = true;
        images
    }

    fn push(&mut self, x: Vec<f64>) {
        let mut gradient = vec![0.0; self.scales.len()];
        let energy = self.energy.evaluate(&x, &mut gradient);
        self.path.images.push(x);
        self.path.energies.push(energy);
        self.gradients.push(gradient);
        self.pinned.push(false);
        self.fire.push(Fire::new(self.scales.len(), self.longest));
    }

    /// The same path with an image added in the middle of every segment.
    pub(super) fn doubled(self) -> Self {
        self.split(&mut |_, _| true)
    }

    /// The same path with an image added in the middle of each segment where the surface differs by more than `tolerance`
    /// from the cubic through the energies and slopes at both ends. `None` if there is no such segment.
    ///
    /// F. Draxler et al. (2018), arXiv:1803.00885, insert images in this way, with a straight line instead of the cubic.
    pub(super) fn inserted(&self, tolerance: f64) -> Option<Self> {
        let space = self.energy.space();
        let mut tangent = vec![0.0; self.scales.len()];
        let mut expected = Vec::with_capacity(self.shares.len());
        for i in 0..self.shares.len() {
            let (images, energies) = (&self.path.images, &self.path.energies);
            space.log_near(&images[i], &images[i + 1], &mut tangent);
            let out = dot(&self.slope(i), &tangent);
            space.log_near(&images[i + 1], &images[i], &mut tangent);
            let back = dot(&self.slope(i + 1), &tangent);
            expected.push(f64::midpoint(energies[i], energies[i + 1]) + (out + back) / 8.0);
        }
        let finer = self.clone().split(&mut |i, height| {
            expected[i].is_finite() && (height - expected[i]).abs() > tolerance
        });
        (finer.shares.len() > self.shares.len()).then_some(finer)
    }

    /// The gradient at an image; zero for pinned images.
    fn slope(&self, i: usize) -> Vec<f64> {
        if self.pinned[i] {
            vec![0.0; self.scales.len()]
        } else {
            self.gradients[i].clone()
        }
    }

    /// The same path with an image added in the middle of the segments for which `wanted(segment, energy there)` holds.
    fn split(self, wanted: &mut dyn FnMut(usize, f64) -> bool) -> Self {
        let space = self.energy.space();
        let mut tangent = vec![0.0; self.scales.len()];
        let mut finer = Self {
            scales: self.scales.clone(),
            path: Path::default(),
            gradients: Vec::new(),
            pinned: Vec::new(),
            shares: Vec::new(),
            fire: Vec::new(),
            ..self
        };
        let old = self
            .path
            .images
            .into_iter()
            .zip(self.path.energies)
            .zip(self.gradients.into_iter().zip(self.pinned))
            .zip(self.fire);
        for (i, (((x, energy), (gradient, pinned)), fire)) in old.enumerate() {
            if let Some(before) = i.checked_sub(1) {
                let last = finer.path.images.len() - 1;
                finer.push(between(
                    space,
                    &finer.path.images[last],
                    &x,
                    0.5,
                    &mut tangent,
                ));
                let share = self.shares[before];
                if wanted(before, finer.path.energies[last + 1]) {
                    finer.shares.extend([0.5 * share; 2]);
                } else {
                    finer.pop();
                    finer.shares.push(share);
                }
            }
            finer.path.images.push(x);
            finer.path.energies.push(energy);
            finer.gradients.push(gradient);
            finer.pinned.push(pinned);
            finer.fire.push(fire);
        }
        finer
    }

    fn pop(&mut self) {
        self.path.images.pop();
        self.path.energies.pop();
        self.gradients.pop();
        self.pinned.pop();
        self.fire.pop();
    }

    pub(super) fn pin(&mut self, i: usize, x: &[f64], energy: f64) {
        self.path.images[i] = x.to_vec();
        self.path.energies[i] = energy;
        self.gradients[i].fill(0.0);
        self.pinned[i] = true;
    }

    /// Relaxes until the greatest force across the path is at most `tolerance`, or for `iterations`, and returns that force.
    pub(super) fn relax(&mut self, iterations: usize, tolerance: f64) -> f64 {
        let mut left = iterations;
        loop {
            let forces: Vec<Vec<f64>> = (0..self.path.images.len())
                .map(|i| self.force_across(i))
                .collect();
            let worst = self.worst(&forces);
            if worst <= tolerance || left == 0 {
                return worst;
            }
            left -= 1;
            self.advance(&forces);
        }
    }

    fn worst(&self, forces: &[Vec<f64>]) -> f64 {
        let free = forces.iter().zip(&self.pinned).filter(|(_, pin)| !**pin);
        free.map(|(force, _)| norm(&times(force, &self.scales)))
            .fold(0.0, f64::max)
    }

    /// Unit tangent at an inner image, by the upwind rule.
    pub(super) fn tangent(&self, i: usize) -> Vec<f64> {
        let (space, images, energies) =
            (self.energy.space(), &self.path.images, &self.path.energies);
        let mut ahead = vec![0.0; self.scales.len()];
        let mut behind = ahead.clone();
        space.log_near(&images[i], &images[i + 1], &mut ahead);
        space.log_near(&images[i], &images[i - 1], &mut behind);
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

    /// The force of the surface across the path at image `i`; zero at pinned images and outside the domain.
    fn force_across(&self, i: usize) -> Vec<f64> {
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
                space.exp(image, &times(&step, &self.scales));
            }
        }
        self.even_out(&mut images);
        for (i, image) in images.into_iter().enumerate() {
            if self.pinned[i] {
                continue;
            }
            let mut gradient = vec![0.0; self.scales.len()];
            let energy = self.energy.evaluate(&image, &mut gradient);
            if energy.is_finite() || !self.path.energies[i].is_finite() {
                self.path.images[i] = image;
                self.path.energies[i] = energy;
                self.gradients[i] = gradient;
            } else {
                self.fire[i].refuse();
            }
        }
    }

    /// Whether the segment lengths of a range differ much from their shares.
    fn is_uneven(&self, images: &[Vec<f64>], (first, last): (usize, usize)) -> bool {
        let space = self.energy.space();
        let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
        for i in first..last {
            let length = near(space, &images[i], &images[i + 1]) / self.shares[i];
            shortest = shortest.min(length);
            longest = longest.max(length);
        }
        longest > UNEVEN * shortest
    }

    /// Redistributes the images between pinned images by their shares, if the lengths differ much.
    fn even_out(&self, images: &mut [Vec<f64>]) {
        let pins: Vec<usize> = (0..self.pinned.len()).filter(|i| self.pinned[*i]).collect();
        for ends in pins.windows(2) {
            let (first, last) = (ends[0], ends[1]);
            if self.is_uneven(images, (first, last)) {
                let even = spread_by(
                    self.energy.space(),
                    &images[first..=last],
                    &self.shares[first..last],
                );
                images[first + 1..last].clone_from_slice(&even[1..last - first]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::Counted;
    use crate::energy::model::MullerBrown;

    /// Two minima of the surface.
    const ENDS: [[f64; 2]; 2] = [[-0.558224, 1.441726], [-0.050011, 0.466694]];

    fn images(energy: &dyn Energy) -> Images<'_> {
        Images::new(energy, &ENDS.map(|end| end.to_vec()), 12, 0.05)
    }

    #[test]
    fn splitting_keeps_what_is_known() {
        let well = MullerBrown::new();
        let energy = Counted::new(&well);
        let mut images = images(&energy);
        images.relax(20, 0.0);
        let before = energy.evaluations();
        let doubled = images.clone().doubled();
        assert_eq!(energy.evaluations(), before + 12);
        assert_eq!(doubled.path.images.len(), 25);
        for (i, x) in images.path.images.iter().enumerate() {
            assert_eq!(doubled.path.images[2 * i], *x);
            assert_eq!(
                doubled.path.energies[2 * i].to_bits(),
                images.path.energies[i].to_bits()
            );
        }
        assert!(images.inserted(f64::INFINITY).is_none());
        // A cubic describes a smooth path to within a hundredth of its barrier, but not to a billionth.
        assert!(images.inserted(1.0).is_none());
        assert!(images.inserted(1e-7).is_some());
    }
}
