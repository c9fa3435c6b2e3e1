//! Mass properties of a uniform body.
//!
//! The engine's own (`MassProperties::from_trimesh`, parry 0.31) finds the principal axes of inertia with an eigensolver
//! (glamx 0.3) that takes a matrix for a multiple of the identity if products of its entries are below 10⁻²⁰, whatever its
//! scale. In SI units all objects that a hand can hold are below that: their smallest moment is given to the x axis. A pen
//! along z then turns end over end as easily as about its axis.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use rapier3d_f64::math::Rotation;
use rapier3d_f64::parry::mass_properties::MassProperties;

use super::convert::vector;
use crate::mesh::Mesh;

/// The mass properties of the uniform body of 1 kg inside a closed mesh.
///
/// For the tetrahedra between a point and the triangles, of vertices p₁, p₂, p₃ relative to it and signed volumes V, the
/// second moment is ∫ x xᵀ = Σ V/20 (Σ pᵢpᵢᵀ + (Σ pᵢ)(Σ pᵢ)ᵀ), and the tensor of inertia is tr(∫ x xᵀ) 1 − ∫ x xᵀ.
pub(super) fn uniform(mesh: &Mesh) -> MassProperties {
    // About a distant origin the sums would cancel.
    let (vertices, triangles) = mesh.boundary();
    let middle = vertices.iter().sum::<Vector3<f64>>() / vertices.len().max(1) as f64;
    let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for triangle in triangles {
        let corners = triangle.map(|vertex| vertices[vertex as usize] - middle);
        let [a, b, c] = corners;
        let part = a.dot(&b.cross(&c)) / 6.0;
        let sum = a + b + c;
        volume += part;
        first += sum * (part / 4.0);
        let squares: Matrix3<f64> = corners.iter().map(|p| p * p.transpose()).sum();
        second += (squares + sum * sum.transpose()) * (part / 20.0);
    }
    let offset = first / volume;
    let second = second / volume - offset * offset.transpose();
    let inertia = Matrix3::from_diagonal_element(second.trace()) - second;
    of_inertia(&(middle + offset), 1.0, &inertia)
}

/// A body with this centre of mass (metres) and this tensor of inertia about it (kg m²), in the same axes.
fn of_inertia(centre: &Vector3<f64>, mass_kg: f64, inertia: &Matrix3<f64>) -> MassProperties {
    let mut eigen = inertia.symmetric_eigen();
    if eigen.eigenvectors.determinant() < 0.0 {
        eigen.eigenvectors.column_mut(0).neg_mut();
    }
    let axes = Rotation3::from_matrix_unchecked(eigen.eigenvectors);
    let Quaternion { coords: q } = *UnitQuaternion::from_rotation_matrix(&axes).quaternion();
    MassProperties::with_principal_inertia_frame(
        vector(centre),
        mass_kg,
        vector(&eigen.eigenvalues.map(|moment| moment.max(0.0))),
        Rotation::from_xyzw(q.x, q.y, q.z, q.w),
    )
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::convert::from_vector;
    use super::*;
    use crate::object::Object;

    fn tensor(body: &MassProperties) -> Matrix3<f64> {
        let matrix = body.reconstruct_inertia_matrix();
        let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        Matrix3::from_columns(&columns.map(from_vector))
    }

    /// A block of any size, place and direction has the moments (b² + c²)/12 about its axes.
    #[test]
    fn a_block_has_its_moments_about_its_own_axes() {
        for scale in [1e-3, 1.0, 1e3] {
            let size = Vector3::new(0.02, 0.05, 0.11) * scale;
            let turn = Rotation3::from_euler_angles(0.3, -0.7, 1.9);
            let place = Vector3::new(1.0, -2.0, 0.5) * scale;
            let corner = |k: usize| {
                let side = |axis: usize| if k >> axis & 1 == 1 { 0.5 } else { -0.5 };
                let corner = Vector3::new(side(0), side(1), side(2)).component_mul(&size);
                turn * corner + place
            };
            let faces = [
                [0, 2, 3],
                [0, 3, 1],
                [4, 5, 7],
                [4, 7, 6],
                [0, 1, 5],
                [0, 5, 4],
                [2, 6, 7],
                [2, 7, 3],
                [0, 4, 6],
                [0, 6, 2],
                [1, 3, 7],
                [1, 7, 5],
            ];
            let mesh = Mesh::new("block", (0..8).map(corner).collect(), faces.to_vec()).unwrap();
            let body = uniform(&mesh);
            let squares = size.component_mul(&size);
            let moments = (Vector3::repeat(squares.sum()) - squares) / 12.0;
            let axes = turn.matrix();
            let expected = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
            assert!((tensor(&body) - expected).norm() < 1e-10 * expected.norm());
            assert!((from_vector(body.local_com) - place).norm() < 1e-12 * place.norm());
        }
    }

    /// A pen turns more easily about its axis, z, than end over end.
    #[test]
    fn a_pen_turns_about_its_axis() {
        let pen = Object::named("pen").unwrap();
        let body = tensor(&uniform(&pen.mesh));
        assert!(body[(2, 2)] < 0.02 * body[(0, 0)] && body[(2, 2)] < 0.02 * body[(1, 1)]);
    }
}
