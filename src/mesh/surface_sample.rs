//! Points spread over the surface of a mesh.

use nalgebra::Vector3;
use rand::RngExt;

use super::Mesh;
use crate::sample::{Rng, Task, stream};

/// A point of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSample {
    /// Position, metres.
    pub point: Vector3<f64>,
    /// Outward unit normal of its triangle.
    pub normal: Vector3<f64>,
}

impl Mesh {
    /// Points spread evenly over the surface. They depend only on the mesh, `count` and `seed`.
    ///
    /// Farthest-point sampling of uniform candidates: each point is the candidate farthest from all points before it, so
    /// each prefix of the list is evenly spread too. The cost grows with `count`².
    pub fn sample_surface(&self, count: usize, seed: u64) -> Vec<SurfaceSample> {
        const CANDIDATES_PER_SAMPLE: usize = 5;
        let mut rng = stream(seed, Task::Surface, 0);
        let candidates = self.uniform_samples(CANDIDATES_PER_SAMPLE * count, &mut rng);
        let mut gaps = vec![f64::INFINITY; candidates.len()];
        let mut taken = Vec::with_capacity(count);
        let mut next = 0;
        for _ in 0..count {
            let sample = candidates[next];
            taken.push(sample);
            let mut widest = f64::NEG_INFINITY;
            for (index, (gap, candidate)) in gaps.iter_mut().zip(&candidates).enumerate() {
                *gap = gap.min((candidate.point - sample.point).norm_squared());
                if *gap > widest {
                    (widest, next) = (*gap, index);
                }
            }
        }
        taken
    }

    /// Points drawn uniformly by area (as in Osada et al. 2002, eq. 1).
    fn uniform_samples(&self, count: usize, rng: &mut Rng) -> Vec<SurfaceSample> {
        let mut total = 0.0;
        let cumulative: Vec<f64> = self
            .areas()
            .map(|area| {
                total += area;
                total
            })
            .collect();
        let (vertices, triangles) = self.boundary();
        let boundary_corners = |index: usize| triangles[index].map(|v| vertices[v as usize]);
        let draw = |_| {
            let target = rng.random::<f64>() * total;
            let index = cumulative
                .partition_point(|&area| area <= target)
                .min(triangles.len() - 1);
            let [a, b, c] = boundary_corners(index);
            let (root, along) = (rng.random::<f64>().sqrt(), rng.random::<f64>());
            let point = a * (1.0 - root) + b * (root * (1.0 - along)) + c * (root * along);
            SurfaceSample {
                point,
                normal: (b - a).cross(&(c - a)).normalize(),
            }
        };
        (0..count).map(draw).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::box_mesh;
    use super::*;

    #[test]
    fn samples_are_spread_evenly_and_are_the_same_again() {
        let cube = box_mesh(&[([0.0; 3], [0.1; 3], false)]);
        let samples = cube.sample_surface(600, 7);
        assert_eq!(samples, cube.sample_surface(600, 7));
        assert_ne!(samples, cube.sample_surface(600, 8));
        let gap = |a: &SurfaceSample| {
            let others = samples.iter().filter(|b| b.point != a.point);
            others
                .map(|b| (b.point - a.point).norm())
                .fold(f64::INFINITY, f64::min)
        };
        // 600 points on 0.06 m² in a triangular lattice would be 10.7 mm apart; random ones come arbitrarily close.
        assert!(samples.iter().map(gap).fold(f64::INFINITY, f64::min) > 6e-3);
        for axis in 0..3 {
            let on_face = samples
                .iter()
                .filter(|sample| sample.normal[axis] > 0.5)
                .count();
            assert!(
                (85..=115).contains(&on_face),
                "{on_face} points on a sixth of the surface"
            );
            assert!(
                samples
                    .iter()
                    .all(|s| s.normal[axis] < 0.5 || (s.point[axis] - 0.1).abs() < 1e-12)
            );
        }
    }
}
