//! The one quaternion of a rotation that files hold.

/// Quaternions within this distance of unit length are kept bit for bit.
const UNIT_EXACT: f64 = 1e-12;

/// The length of a quaternion.
pub(super) fn norm(quaternion: [f64; 4]) -> f64 {
    quaternion
        .iter()
        .map(|component| component * component)
        .sum::<f64>()
        .sqrt()
}

/// The unit quaternion of the same rotation whose first non-zero component is positive.
pub(super) fn canonical(mut quaternion: [f64; 4]) -> [f64; 4] {
    let norm = norm(quaternion);
    if (norm - 1.0).abs() > UNIT_EXACT {
        quaternion = quaternion.map(|component| component / norm);
    }
    if quaternion
        .iter()
        .find(|component| **component != 0.0)
        .is_some_and(|first| *first < 0.0)
    {
        quaternion = quaternion.map(|component| -component);
    }
    quaternion
}
