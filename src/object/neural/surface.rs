//! Meshes of the zero level set of a network.

use fast_surface_nets::ndshape::{RuntimeShape, Shape as _};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};
use nalgebra::Vector3;

use super::{NeuralError, NeuralField, Real};
use crate::mesh::Mesh;
use crate::mesh::signed_volume;
use crate::object::Shape as _;

/// Resolution of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SurfaceSettings {
    /// Number of cells along each axis of the cube around the network's ball. The object has about as many along its
    /// longest side.
    pub cells: u32,
}

impl Default for SurfaceSettings {
    fn default() -> Self {
        Self { cells: 128 }
    }
}

/// The surface of a neural shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// The mesh, metres.
    pub mesh: Mesh,
    /// Cell of the grid used to find it, metres.
    pub cell_m: f64,
    /// Largest absolute distance of the network at a vertex, metres.
    pub residual_m: f64,
    /// Number of islands and cavities that were left out because each has less than a hundredth of the volume. Networks
    /// often have such small pieces.
    pub crumbs: usize,
}

/// Half the side of the cube that is searched for the surface, units of the network.
const REACH: f64 = 1.1;
/// Nodes along a side of a block. A block far from the surface takes the value at its middle.
const BLOCK: u32 = 4;
/// Number of Newton steps that move the vertices onto the surface.
const STEPS: usize = 6;
/// Largest volume of a crumb, as a share of the whole.
const CRUMB: f64 = 0.01;

impl<T: Real> NeuralField<T> {
    /// The surface d = 0 as a closed mesh. `name` is the name of the shape in errors.
    ///
    /// The method is surface nets (Gibson 1998, *Constrained Elastic Surface Nets*). Each vertex is then moved along the
    /// gradient onto the surface. Only nodes near the surface are evaluated, on all threads of the current pool. The result
    /// does not depend on their number.
    ///
    /// # Errors
    /// If there is no surface, it is not closed within the ball of the network, or its size cannot be metres.
    pub fn surface(&self, name: &str, settings: &SurfaceSettings) -> Result<Surface, NeuralError> {
        let blocks = settings.cells.max(BLOCK).div_ceil(BLOCK) + 1;
        let nodes = blocks * BLOCK;
        let cell_m = 2.0 * REACH * self.scale_m() / f64::from(settings.cells.max(BLOCK));
        let grid = Grid {
            cell_m,
            low_m: -0.5 * f64::from(nodes - 1) * cell_m,
            shape: RuntimeShape::<u32, 3>::new([nodes; 3]),
            blocks,
        };
        let values = grid.sample(self);
        if grid.is_negative_at_border(&values) {
            return Err(NeuralError::Unbounded(name.to_owned()));
        }
        let mut net = SurfaceNetsBuffer::default();
        surface_nets(&values, &grid.shape, [0; 3], [nodes - 1; 3], &mut net);
        if net.indices.is_empty() {
            return Err(NeuralError::NoSurface(name.to_owned()));
        }
        let mut vertices: Vec<Vector3<f64>> = net
            .positions
            .iter()
            .map(|position| Vector3::from(position.map(|node| grid.coordinate(f64::from(node)))))
            .collect();
        self.settle(&mut vertices, cell_m);
        let triangles = net.indices.as_chunks::<3>().0.to_vec();
        let (mesh, crumbs) = without_crumbs(name, Mesh::new(name, vertices, triangles)?)?;
        mesh.check_size(name)?;
        let residuals = self.distances(mesh.vertices());
        Ok(Surface {
            mesh,
            cell_m,
            residual_m: residuals.into_iter().fold(0.0, |most, d| most.max(d.abs())),
            crumbs,
        })
    }

    /// Moves points near the surface onto it, each by at most one cell.
    fn settle(&self, points: &mut [Vector3<f64>], cell_m: f64) {
        let starts = points.to_vec();
        for _ in 0..STEPS {
            let answers = self.answers(points);
            for ((point, start), (distance_m, gradient, _)) in
                points.iter_mut().zip(&starts).zip(answers)
            {
                let steepness = gradient.norm_squared();
                if steepness == 0.0 {
                    continue;
                }
                let moved = *point - gradient * (distance_m / steepness) - start;
                *point = start + moved.cap_magnitude(cell_m);
            }
        }
    }
}

/// Nodes in a cube around the origin, x varying fastest.
struct Grid {
    cell_m: f64,
    low_m: f64,
    shape: RuntimeShape<u32, 3>,
    /// Number of blocks along each axis.
    blocks: u32,
}

impl Grid {
    fn coordinate(&self, node: f64) -> f64 {
        self.low_m + node * self.cell_m
    }

    fn point(&self, node: [u32; 3]) -> Vector3<f64> {
        Vector3::from(node.map(|index| self.coordinate(index.into())))
    }

    /// Signed distances at the nodes, metres: exact wherever a cell can contain the surface, elsewhere of the right sign.
    fn sample<T: Real>(&self, field: &NeuralField<T>) -> Vec<f32> {
        let corners: Vec<[u32; 3]> = (0..self.blocks.pow(3))
            .map(|block| {
                [
                    block % self.blocks,
                    block / self.blocks % self.blocks,
                    block / self.blocks.pow(2),
                ]
                .map(|index| index * BLOCK)
            })
            .collect();
        let half_m = 0.5 * f64::from(BLOCK - 1) * self.cell_m;
        let middles: Vec<_> = corners
            .iter()
            .map(|&corner| self.point(corner).add_scalar(half_m))
            .collect();
        let by_middle = field.distances(&middles);
        // The distance from the middle of a block to its farthest node, plus a diagonal of a cell that the surface crosses.
        let reach_m = field.lipschitz() * 3.0_f64.sqrt() * (half_m + self.cell_m);
        let offsets =
            || (0..BLOCK.pow(3)).map(|k| [k % BLOCK, k / BLOCK % BLOCK, k / BLOCK.pow(2)]);
        let node = |corner: [u32; 3], offset: [u32; 3]| {
            std::array::from_fn(|axis| corner[axis] + offset[axis])
        };
        let asked: Vec<[u32; 3]> = corners
            .iter()
            .zip(&by_middle)
            .filter(|(_, distance_m)| distance_m.abs() <= reach_m)
            .flat_map(|(&corner, _)| offsets().map(move |offset| node(corner, offset)))
            .collect();
        let places: Vec<_> = asked.iter().map(|&node| self.point(node)).collect();
        let mut values = vec![0.0; self.shape.usize()];
        for (&corner, distance_m) in corners.iter().zip(by_middle) {
            for offset in offsets() {
                values[self.shape.linearize(node(corner, offset)) as usize] = narrow(distance_m);
            }
        }
        for (&node, distance_m) in asked.iter().zip(field.distances(&places)) {
            values[self.shape.linearize(node) as usize] = narrow(distance_m);
        }
        values
    }

    fn is_negative_at_border(&self, values: &[f32]) -> bool {
        let last = self.blocks * BLOCK - 1;
        (0..).zip(values).any(|(index, value)| {
            let node = self.shape.delinearize(index);
            *value < 0.0 && node.iter().any(|&index| index == 0 || index == last)
        })
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "the grid only needs to find the surface, not to place it"
)]
fn narrow(value: f64) -> f32 {
    value as f32
}

/// The mesh without its small pieces, and the number of these.
fn without_crumbs(name: &str, mesh: Mesh) -> Result<(Mesh, usize), NeuralError> {
    let pieces = mesh.pieces();
    let volumes: Vec<f64> = pieces
        .iter()
        .map(|piece| signed_volume(&mesh, piece).abs())
        .collect();
    let largest = volumes
        .iter()
        .fold(0.0, |most: f64, &volume| most.max(volume));
    let (kept, crumbs): (Vec<_>, Vec<_>) = pieces
        .into_iter()
        .zip(volumes)
        .partition(|(_, volume)| *volume >= CRUMB * largest);
    if crumbs.is_empty() {
        return Ok((mesh, 0));
    }
    let triangles = kept.into_iter().flat_map(|(piece, _)| piece).collect();
    Ok((
        Mesh::new(name, mesh.vertices().to_vec(), triangles)?,
        crumbs.len(),
    ))
}
