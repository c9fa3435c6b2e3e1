//! A known failure of relaxed force closure (Liu et al. 2021, Fig. 11): all contacts lie in one concavity.

use nalgebra::Vector3;

use crate::mesh::ExactMesh;

/// Greatest depth in the solid of a line of sight that counts as free, metres.
const GRAZING_M: f64 = 1e-4;
/// Least and greatest step along a line of sight, metres.
const STEP_M: [f64; 2] = [2.5e-4, 5e-3];

/// Whether all pairs of these surface points can see each other outside the solid.
///
/// On a convex solid no two points can, except very close neighbours. Points that see each other *and* push against each
/// other lie in one concavity, such as the inside of a bowl, a mug or a handle.
pub fn in_one_concavity(exact: &ExactMesh, points: &[Vector3<f64>]) -> bool {
    points.iter().enumerate().all(|(index, point)| {
        points[..index]
            .iter()
            .all(|other| sees(exact, point, other))
    })
}

/// Whether the straight line between two points stays outside the solid.
pub fn sees(exact: &ExactMesh, from: &Vector3<f64>, to: &Vector3<f64>) -> bool {
    let line = to - from;
    let length = line.norm();
    let mut along = 0.0;
    while along < length {
        let distance = exact.distance(&(from + line * (along / length)));
        if distance < -GRAZING_M {
            return false;
        }
        // The signed distance is a safe step.
        along += distance.clamp(STEP_M[0], STEP_M[1]);
    }
    true
}
