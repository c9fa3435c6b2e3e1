//! The bending surface and the ball joints of MANO.
//!
//! ```text
//! p = Σₖ wₖ (Rₖ (v − Jₖ + c) + oₖ),    c = P vec(R(θ₁) − I, …),    θ = θ₀ + M q
//! ```
//!
//! Linear blend skinning with pose-corrective shapes (Romero, Tzionas, Black 2017, after Loper et al. 2015). wₖ:
//! weights of vertex v; Rₖ, oₖ: frame of link k; Jₖ: its joint at rest; P: corrections by the entries, in row-major
//! order, of the joints' rotations R(θ) = exp [θ]ₓ; θ: three angles per ball joint; q: joint coordinates, which are
//! the angles themselves or the weights of their principal components.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

use super::mirror::reflected;
use super::{LinkId, PosedHand};

/// Number of entries of a rotation matrix.
const ENTRIES: usize = 9;

/// The bending surface of a hand, and the map from its coordinates to the angles of its ball joints.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Blend {
    /// θ at q = 0, three angles per ball joint, radians.
    pub(super) offset_rad: DVector<f64>,
    /// ∂θ/∂q.
    pub(super) map: DMatrix<f64>,
    /// Vertices in the order of [`Hand::surface`].
    pub(super) vertices: Vec<BlendVertex>,
    /// Triangles of vertex indices.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// A vertex of the surface.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BlendVertex {
    /// For each link that carries the vertex: link, position in its frame at rest (metres), weight. The weights sum to 1.
    pub(super) bindings: Vec<(LinkId, Vector3<f64>, f64)>,
    /// Outward unit normal at rest.
    pub(super) normal: Vector3<f64>,
    /// Metres per entry of the joints' rotations: all entries for x, then for y, then for z.
    pub(super) corrections: Vec<f64>,
}

/// R(θ) = exp [θ]ₓ.
fn rotation(angles: &Vector3<f64>) -> Matrix3<f64> {
    *Rotation3::new(*angles).matrix()
}

/// J with ω = J θ̇ for the turn R(θ): the left Jacobian of SO(3).
fn left_jacobian(angles: &Vector3<f64>) -> Matrix3<f64> {
    let square = angles.norm_squared();
    let k = angles.cross_matrix();
    // (1 − cos φ)/φ² and (φ − sin φ)/φ³.
    let (first, second) = if square < 1e-6 {
        (0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0)
    } else {
        let angle = square.sqrt();
        let (sin, cos) = libm::sincos(angle);
        ((1.0 - cos) / square, (angle - sin) / (square * angle))
    };
    Matrix3::identity() + k * first + k * k * second
}

fn angles_of(posed: &PosedHand, ball: usize) -> Vector3<f64> {
    Vector3::from_column_slice(&posed.angles_rad[3 * ball..3 * ball + 3])
}

impl Blend {
    /// Writes θ and the entries of R(θ) − I into `posed`.
    pub(super) fn prepare(&self, joints: &[f64], posed: &mut PosedHand) {
        posed.angles_rad.clear();
        posed
            .angles_rad
            .extend_from_slice(self.offset_rad.as_slice());
        for (column, &value) in self.map.column_iter().zip(joints) {
            for (angle, slope) in posed.angles_rad.iter_mut().zip(column.iter()) {
                *angle += slope * value;
            }
        }
        posed.entries.clear();
        for angles in posed.angles_rad.chunks_exact(3) {
            let turned = rotation(&Vector3::from_column_slice(angles)) - Matrix3::identity();
            posed.entries.extend(turned.transpose().iter());
        }
    }

    /// The mirror image at x = 0, as in [`Hand::mirrored`]: at the same coordinates, every point and joint is mirrored.
    ///
    /// With M = diag(−1, 1, 1), M R(θ) M = R(−M θ): angles about x stay, those about y and z change their sign.
    pub(super) fn mirrored(&self) -> Self {
        const SIGNS: [f64; 3] = [-1.0, 1.0, 1.0];
        let mut image = self.clone();
        for angle in (0..image.offset_rad.len()).filter(|angle| angle % 3 != 0) {
            image.offset_rad[angle] *= -1.0;
            image.map.row_mut(angle).neg_mut();
        }
        for vertex in &mut image.vertices {
            for (_, point, _) in &mut vertex.bindings {
                *point = reflected(point);
            }
            vertex.normal = reflected(&vertex.normal);
            let entries = (vertex.corrections.len() / 3).max(1);
            for (k, slope) in vertex.corrections.iter_mut().enumerate() {
                let (axis, entry) = (k / entries, k % entries % ENTRIES);
                *slope *= SIGNS[axis] * SIGNS[entry / 3] * SIGNS[entry % 3];
            }
        }
        for triangle in &mut image.triangles {
            triangle.swap(1, 2);
        }
        image
    }

    /// R(θ) of a ball joint of a posed hand.
    pub(super) fn ball(posed: &PosedHand, ball: usize) -> Matrix3<f64> {
        rotation(&angles_of(posed, ball))
    }

    /// The rate of rotation of ball joint `ball` per unit of coordinate `joint`, in the frame that carries the ball joint.
    pub(super) fn rate(&self, posed: &PosedHand, ball: usize, joint: usize) -> Vector3<f64> {
        let slopes = self.map.fixed_view::<3, 1>(3 * ball, joint);
        left_jacobian(&angles_of(posed, ball)) * slopes
    }

    /// Adds the gradient of the coordinates that follows from a moment on ball joint `ball`, in the frame that carries it.
    pub(super) fn pull_back(
        &self,
        posed: &PosedHand,
        ball: usize,
        moment: &Vector3<f64>,
        gradient: &mut [f64],
    ) {
        let by_angles = left_jacobian(&angles_of(posed, ball)).tr_mul(moment);
        for (j, slope) in gradient.iter_mut().enumerate() {
            *slope += by_angles.dot(&self.map.fixed_view::<3, 1>(3 * ball, j));
        }
    }

    /// Surface point `index`, object frame.
    pub(super) fn point(&self, posed: &PosedHand, index: usize) -> Vector3<f64> {
        let vertex = &self.vertices[index];
        let correction = vertex.correction(posed);
        let parts = vertex.bindings.iter().map(|(link, point, weight)| {
            posed.object_from_link[link.0].point(&(point + correction)) * *weight
        });
        parts.sum()
    }

    /// The normal of surface point `index`: the weighted sum of the normals turned with each link, not yet of unit length.
    fn mixed_normal(&self, posed: &PosedHand, index: usize) -> Vector3<f64> {
        let vertex = &self.vertices[index];
        let parts = (vertex.bindings.iter()).map(|(link, _, weight)| {
            posed.object_from_link[link.0].direction(&vertex.normal) * *weight
        });
        parts.sum()
    }

    /// Outward unit normal of surface point `index`, object frame.
    pub(super) fn normal(&self, posed: &PosedHand, index: usize) -> Vector3<f64> {
        let mixed = self.mixed_normal(posed, index);
        mixed.try_normalize(1e-12).unwrap_or_else(Vector3::z)
    }
}

impl BlendVertex {
    fn correction(&self, posed: &PosedHand) -> Vector3<f64> {
        let mut correction = Vector3::zeros();
        let rows = self.corrections.chunks_exact(posed.entries.len().max(1));
        for (value, row) in correction.iter_mut().zip(rows) {
            *value = row.iter().zip(&posed.entries).map(|(p, r)| p * r).sum();
        }
        correction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// R(θ + δ) = (I + [J δ]ₓ) R(θ) to first order, at small and large angles.
    #[test]
    fn the_left_jacobian_is_the_rate_of_turning() {
        for angles in [
            Vector3::zeros(),
            Vector3::new(1e-5, -2e-5, 1e-5),
            Vector3::new(2e-3, -1e-3, 1e-3),
            Vector3::new(0.3, -0.8, 1.1),
            Vector3::new(-2.0, 1.5, 0.4),
        ] {
            for axis in 0..3 {
                let step = Vector3::ith(axis, 1e-6);
                let change = rotation(&(angles + step)) - rotation(&(angles - step));
                let spin = change / 2e-6 * rotation(&angles).transpose();
                let rate = left_jacobian(&angles).column(axis).into_owned();
                assert!(
                    (spin - rate.cross_matrix()).amax() < 1e-8,
                    "{angles} {axis}"
                );
            }
        }
    }
}
