//! A surface under construction: points, rings of points, and the triangles between them, in millimetres.

use std::collections::BTreeSet;

use landscape::mesh::{Mesh, MeshError};
use nalgebra::Vector3;

#[derive(Default)]
pub(super) struct Parts {
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
}

impl Parts {
    pub(super) fn point(&mut self, point: Vector3<f64>) -> u32 {
        let index = u32::try_from(self.vertices.len()).expect("a mesh has fewer than 2³² vertices");
        self.vertices.push(point);
        index
    }

    pub(super) fn at(&self, index: u32) -> Vector3<f64> {
        self.vertices[index as usize]
    }

    /// Adds a ring of points around a direction of growth, counter-clockwise seen against it.
    pub(super) fn ring(&mut self, points: impl IntoIterator<Item = Vector3<f64>>) -> Vec<u32> {
        points.into_iter().map(|point| self.point(point)).collect()
    }

    /// Closes a ring with a fan around `pole`, on the side from which the ring grows.
    pub(super) fn close_below(&mut self, pole: u32, ring: &[u32]) {
        let count = ring.len();
        self.triangles
            .extend((0..count).map(|i| [pole, ring[(i + 1) % count], ring[i]]));
    }

    /// Closes a ring with a fan around `pole`, on the side toward which the ring grows.
    pub(super) fn close_above(&mut self, pole: u32, ring: &[u32]) {
        let count = ring.len();
        self.triangles
            .extend((0..count).map(|i| [pole, ring[i], ring[(i + 1) % count]]));
    }

    /// Adds triangles between two rings. The upper ring has as many, half or twice as many vertices.
    pub(super) fn stitch(&mut self, below: &[u32], above: &[u32]) {
        let (few, many) = (below.len().min(above.len()), below.len().max(above.len()));
        if few == many {
            for i in 0..few {
                let j = (i + 1) % few;
                self.triangles.extend([
                    [below[i], below[j], above[j]],
                    [below[i], above[j], above[i]],
                ]);
            }
            return;
        }
        let (coarse, fine) = if below.len() == few {
            (below, above)
        } else {
            (above, below)
        };
        for i in 0..few {
            let j = (i + 1) % few;
            let [a, b, c] = [fine[2 * i], fine[2 * i + 1], fine[(2 * i + 2) % many]];
            for [p, q, r] in [
                [a, b, coarse[i]],
                [b, coarse[j], coarse[i]],
                [b, c, coarse[j]],
            ] {
                self.triangles.push(if coarse == below {
                    [q, p, r]
                } else {
                    [p, q, r]
                });
            }
        }
    }

    /// Cuts a hole of whole quadrangles into neighbouring rings of the same size, `sectors` wide from sector `first` on.
    /// Returns its border from the lower left corner on, counter-clockwise seen from outside.
    pub(super) fn open(&mut self, rings: &[Vec<u32>], first: usize, sectors: usize) -> Vec<u32> {
        let corner = |ring: usize, sector: usize| {
            let ring = &rings[ring];
            ring[(first + sector) % ring.len()]
        };
        let inside: BTreeSet<u32> = (0..rings.len())
            .flat_map(|ring| (0..=sectors).map(move |sector| (ring, sector)))
            .map(|(ring, sector)| corner(ring, sector))
            .collect();
        self.triangles
            .retain(|triangle| !triangle.iter().all(|vertex| inside.contains(vertex)));
        let top = rings.len() - 1;
        let bottom_side = (0..sectors).map(|sector| corner(0, sector));
        let right_side = (0..top).map(|ring| corner(ring, sectors));
        let top_side = (0..sectors).map(|sector| corner(top, sectors - sector));
        let left_side = (0..top).map(|ring| corner(top - ring, 0));
        bottom_side
            .chain(right_side)
            .chain(top_side)
            .chain(left_side)
            .collect()
    }

    pub(super) fn into_mesh(self, name: &str) -> Result<Mesh, MeshError> {
        let metres = self.vertices.into_iter().map(|v| v * 1e-3).collect();
        Mesh::new(name, metres, self.triangles)
    }
}
