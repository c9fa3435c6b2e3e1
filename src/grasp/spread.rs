//! Thins a population so that its grasps are spread over the object and not crowded where it is easy to hold.

use nalgebra::Vector3;

use crate::space::Symmetry;

/// Chooses `keep` evenly spread points by repeatedly dropping the costlier of the closest pair. Returns ascending indices.
///
/// `points` are the places where each grasp holds the object (the mean of its contacts), in metres in the object frame.
/// They are compared modulo the symmetry of the object.
///
/// # Panics
/// If `points` and `costs` have different lengths.
pub fn spread(
    points: &[Vector3<f64>],
    costs: &[f64],
    symmetry: &Symmetry,
    keep: usize,
) -> Vec<usize> {
    assert_eq!(points.len(), costs.len(), "one cost a point");
    let places: Vec<Vector3<f64>> = points.iter().map(|p| place(p, symmetry)).collect();
    let mut left: Vec<usize> = (0..points.len()).collect();
    let nearest = |i: usize, left: &[usize]| {
        left.iter()
            .filter(|&&j| j != i)
            .map(|&j| ((places[i] - places[j]).norm_squared(), j))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    };
    let mut neighbour: Vec<Option<(f64, usize)>> =
        (0..points.len()).map(|i| nearest(i, &left)).collect();
    while left.len() > keep.max(1) {
        let closest = left
            .iter()
            .filter_map(|&i| neighbour[i].map(|(d, j)| (d, i, j)))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let Some((_, i, j)) = closest else { break };
        let drop = if costs[i].total_cmp(&costs[j]).is_gt() {
            i
        } else {
            j
        };
        left.retain(|&k| k != drop);
        for &k in &left {
            if neighbour[k].is_some_and(|(_, j)| j == drop) {
                neighbour[k] = nearest(k, &left);
            }
        }
    }
    left
}

/// The representative of `point` under the symmetry.
fn place(point: &Vector3<f64>, symmetry: &Symmetry) -> Vector3<f64> {
    match symmetry {
        Symmetry::Axis {
            point: origin,
            direction,
        } => {
            let axis = direction.normalize();
            let offset = point - origin;
            let along = offset.dot(&axis);
            Vector3::new((offset - axis * along).norm(), 0.0, along)
        }
        Symmetry::Sphere { centre } => Vector3::new((point - centre).norm(), 0.0, 0.0),
        Symmetry::None | Symmetry::Finite(_) => *point,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crowd_is_thinned_and_loners_stay() {
        let mut points: Vec<Vector3<f64>> = (0..20)
            .map(|i| Vector3::x() * (1e-3 * f64::from(i)))
            .collect();
        points.push(Vector3::x());
        points.push(-Vector3::x());
        let costs: Vec<f64> = (0..points.len()).map(|i| i as f64).collect();
        let kept = spread(&points, &costs, &Symmetry::None, 5);
        assert_eq!(kept.len(), 5);
        assert!(kept.contains(&20) && kept.contains(&21));
    }

    #[test]
    fn around_an_axis_only_height_and_radius_count() {
        let axis = Symmetry::Axis {
            point: Vector3::zeros(),
            direction: Vector3::z(),
        };
        let points = [Vector3::x(), Vector3::y(), Vector3::new(1.0, 0.0, 3.0)];
        assert_eq!(spread(&points, &[2.0, 1.0, 3.0], &axis, 2), [1, 2]);
    }
}
