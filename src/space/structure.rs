//! Invariants of a cluster of atoms under rigid motions: moments of inertia and point group.

use nalgebra::{Matrix3, Vector3};

/// Principal moments of inertia about the centroid, ascending, all masses 1; `positions` is `[x₁, y₁, z₁, x₂, …]`.
///
/// # Panics
/// If the number of coordinates is no multiple of three.
pub fn moments_of_inertia(positions: &[f64]) -> [f64; 3] {
    let mut tensor = Matrix3::zeros();
    for atom in centred(positions) {
        tensor += Matrix3::identity() * atom.norm_squared() - atom * atom.transpose();
    }
    let mut moments: [f64; 3] = tensor.symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    // Rounding may make the zero moment of a line about itself negative.
    moments.map(|moment| moment.max(0.0))
}

/// Order of the point group: the number of rotations and rotary reflections about the centroid that map every atom onto an
/// atom of its kind, for atoms at `[x₁, y₁, z₁, x₂, …]`. `kinds` may be empty, if all are of one kind. The group of points on a line is infinite; then only the operations that
/// differ on the line count (1 or 2), and a single point gives 1.
///
/// Atoms coincide within `tolerance` times the distance of the farthest atom from the centroid. The cost is O(n⁴) at worst
/// for n atoms, but in practice O(n²), because a frame of three atoms must coincide with its copy.
///
/// # Panics
/// If the number of coordinates is no multiple of three, or there are kinds but not one for each atom.
pub fn point_group_order(positions: &[f64], kinds: &[usize], tolerance: f64) -> u32 {
    let atoms = centred(positions);
    assert!(kinds.is_empty() || kinds.len() == atoms.len());
    let equal = |one: usize, other: usize| kinds.is_empty() || kinds[one] == kinds[other];
    let radius = atoms.iter().map(Vector3::norm).fold(0.0, f64::max);
    let near = tolerance * radius;
    let Some(frame) = Frame::of(&atoms, radius) else {
        // On a line only the inversion can differ from the identity.
        let inverted = |(place, atom): (usize, &Vector3<f64>)| {
            let mut others = atoms.iter().enumerate();
            others.any(|(other, image)| equal(place, other) && (image + atom).norm() <= near)
        };
        return if radius > 0.0 && atoms.iter().enumerate().all(inverted) {
            2
        } else {
            1
        };
    };
    let [a, b] = [frame.first, frame.second];
    let mut order = 0;
    for first in atoms.iter().filter(|x| (x.norm() - a.norm()).abs() <= near) {
        for second in atoms.iter().filter(|x| (x.norm() - b.norm()).abs() <= near) {
            if ((second - first).norm() - (b - a).norm()).abs() > 2.0 * near {
                continue;
            }
            for side in [1.0, -1.0] {
                let Some(image) = basis(first, second, side) else {
                    continue;
                };
                let turn = image * frame.basis.transpose();
                let maps = |(place, atom): (usize, &Vector3<f64>)| {
                    let moved = turn * atom;
                    let mut others = atoms.iter().enumerate();
                    // The frame itself coincides only within the tolerance, and levers increase the error.
                    others.any(|(other, image)| {
                        equal(place, other) && (image - moved).norm() <= 4.0 * near
                    })
                };
                if atoms.iter().enumerate().all(maps) {
                    order += 1;
                }
            }
        }
    }
    order
}

/// Two atoms that span a plane with the centroid.
struct Frame {
    first: Vector3<f64>,
    second: Vector3<f64>,
    basis: Matrix3<f64>,
}

impl Frame {
    /// The atom farthest from the centroid and the atom farthest from the line through it.
    fn of(atoms: &[Vector3<f64>], radius: f64) -> Option<Self> {
        let first = *(atoms.iter()).max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
        let second = *(atoms.iter())
            .max_by(|a, b| a.cross(&first).norm().total_cmp(&b.cross(&first).norm()))?;
        if second.cross(&first).norm() <= 1e-3 * radius * radius {
            return None;
        }
        Some(Self {
            first,
            second,
            basis: basis(&first, &second, 1.0)?,
        })
    }
}

/// The orthonormal basis whose first axis points to `first` and whose second points to the side of `second`; `side` = −1
/// gives its mirror image in their plane.
fn basis(first: &Vector3<f64>, second: &Vector3<f64>, side: f64) -> Option<Matrix3<f64>> {
    let one = first.try_normalize(0.0)?;
    let two = (second - one * one.dot(second)).try_normalize(1e-9 * second.norm())?;
    Some(Matrix3::from_columns(&[one, two, one.cross(&two) * side]))
}

fn centred(positions: &[f64]) -> Vec<Vector3<f64>> {
    assert!(
        positions.len().is_multiple_of(3),
        "an atom has three coordinates"
    );
    let atoms: Vec<Vector3<f64>> = positions
        .chunks_exact(3)
        .map(Vector3::from_column_slice)
        .collect();
    let sum: Vector3<f64> = atoms.iter().sum();
    let centroid = sum / atoms.len().max(1) as f64;
    atoms.into_iter().map(|atom| atom - centroid).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;

    /// Turned and moved, so that nothing lies along an axis.
    fn placed(atoms: &[[f64; 3]]) -> Vec<f64> {
        let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
        let place = |atom: &[f64; 3]| turn * Vector3::from(*atom) + Vector3::new(3.0, -1.0, 0.5);
        atoms
            .iter()
            .flat_map(|atom| <[f64; 3]>::from(place(atom)))
            .collect()
    }

    #[test]
    fn orders_of_known_point_groups() {
        let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
        let mut icosahedron = vec![[0.0; 3]];
        for a in [-1.0, 1.0] {
            for b in [-golden, golden] {
                icosahedron.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
            }
        }
        let ring = |n: u32| {
            (0..n).map(move |k| {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(n);
                [libm::cos(angle), libm::sin(angle), 0.0]
            })
        };
        let bipyramid: Vec<_> = ring(5).chain([[0.0, 0.0, 0.6], [0.0, 0.0, -0.6]]).collect();
        let pyramid: Vec<_> = ring(4).chain([[0.0, 0.0, 0.9]]).collect();
        let tetrahedron = [
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ];
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.3, 0.8, 0.0]];
        let twisted = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.1],
            [0.3, 0.8, 0.0],
            [0.2, 0.1, 1.3],
        ];
        for (name, atoms, order) in [
            ("I_h", &icosahedron[..], 120),
            ("D_5h", &bipyramid, 20),
            ("C_4v", &pyramid, 8),
            ("T_d", &tetrahedron, 24),
            ("C_s", &triangle, 2),
            ("C_1", &twisted, 1),
            ("line", &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], 2),
            (
                "lopsided line",
                &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]],
                1,
            ),
            ("point", &[[1.0, 0.0, 0.0]], 1),
        ] {
            let placed = placed(atoms);
            assert_eq!(point_group_order(&placed, &[], 1e-3), order, "{name}");
            let kinds = vec![7; atoms.len()];
            assert_eq!(point_group_order(&placed, &kinds, 1e-3), order, "{name}");
        }
        // A corner of its own leaves the tetrahedron a threefold axis, and an end of its own turns a line into a lopsided one.
        let ammonia_like = point_group_order(&placed(&tetrahedron), &[1, 1, 1, 7], 1e-3);
        assert_eq!(ammonia_like, 6);
        let line = placed(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
        assert_eq!(point_group_order(&line, &[1, 9], 1e-3), 1);
    }

    #[test]
    fn moments_of_a_dumbbell_and_a_square() {
        let moments = moments_of_inertia(&placed(&[[0.0; 3], [2.0, 0.0, 0.0]]));
        for (found, known) in moments.iter().zip([0.0, 2.0, 2.0]) {
            approx::assert_abs_diff_eq!(*found, known, epsilon = 1e-12);
        }
        let square = [
            [1.0, 1.0, 0.0],
            [1.0, -1.0, 0.0],
            [-1.0, 1.0, 0.0],
            [-1.0, -1.0, 0.0],
        ];
        for (found, known) in moments_of_inertia(&placed(&square))
            .iter()
            .zip([4.0, 4.0, 8.0])
        {
            approx::assert_abs_diff_eq!(*found, known, epsilon = 1e-12);
        }
    }
}
