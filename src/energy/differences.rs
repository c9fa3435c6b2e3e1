//! Second derivatives from gradients that are computed together.

use crate::space::Space;

/// Writes the Hessian of an energy at `x` by central differences of its gradient, for an energy that computes many gradients
/// at once faster than one by one:
///
/// ```text
/// H_jk = (g_k(x + h e_j) − g_k(x − h e_j)) / 2h
/// ```
///
/// `gradients` gets the 2n points of all differences (n is the number of tangents) and returns their gradients, one after
/// the other, or `None` if a point is outside the domain. Returns whether it did. `step` is h, a length of `space`.
///
/// # Panics
/// If `x`, `hessian` (n² numbers) or the answer of `gradients` (2n² numbers) has the wrong length.
pub fn hessian_from_gradients(
    space: &dyn Space,
    x: &[f64],
    step: f64,
    gradients: impl FnOnce(&[Vec<f64>]) -> Option<Vec<f64>>,
    hessian: &mut [f64],
) -> bool {
    let n = space.tangents();
    assert_eq!(hessian.len(), n * n);
    if n == 0 {
        return true;
    }
    let mut tangent = vec![0.0; n];
    let mut points = Vec::with_capacity(2 * n);
    for along in 0..n {
        for side in [step, -step] {
            tangent[along] = side;
            let mut point = x.to_vec();
            space.exp(&mut point, &tangent);
            points.push(point);
        }
        tangent[along] = 0.0;
    }
    let Some(gradients) = gradients(&points) else {
        return false;
    };
    assert_eq!(gradients.len(), 2 * n * n);
    let rows = hessian.chunks_exact_mut(n);
    for (row, pair) in rows.zip(gradients.chunks_exact(2 * n)) {
        let (ahead, behind) = pair.split_at(n);
        for (entry, (ahead, behind)) in row.iter_mut().zip(ahead.iter().zip(behind)) {
            *entry = (ahead - behind) / (2.0 * step);
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Euclidean, Rotation};

    #[test]
    fn a_quadratic_gives_its_matrix() {
        let matrix = [2.0, -1.0, -1.0, 5.0];
        let gradients = |points: &[Vec<f64>]| {
            let rows = points
                .iter()
                .flat_map(|p| [2.0 * p[0] - p[1], -p[0] + 5.0 * p[1]]);
            Some(rows.collect())
        };
        let mut hessian = [0.0; 4];
        let space = Euclidean::new(2);
        assert!(hessian_from_gradients(
            &space,
            &[0.3, -0.7],
            1e-3,
            gradients,
            &mut hessian
        ));
        assert!(
            hessian
                .iter()
                .zip(matrix)
                .all(|(a, b)| (a - b).abs() < 1e-9),
            "{hessian:?}"
        );
        assert!(!hessian_from_gradients(
            &space,
            &[0.3, -0.7],
            1e-3,
            |_| None,
            &mut hessian
        ));
    }

    #[test]
    fn points_are_moves_of_the_space() {
        // A quaternion has four numbers and three tangents.
        let mut hessian = [0.0; 9];
        let gradients = |points: &[Vec<f64>]| {
            assert!(points.len() == 6 && points.iter().all(|point| point.len() == 4));
            Some(vec![0.0; 18])
        };
        let x = [1.0, 0.0, 0.0, 0.0];
        assert!(hessian_from_gradients(
            &Rotation::new(1.0),
            &x,
            1e-3,
            gradients,
            &mut hessian
        ));
    }
}
