//! The group SO(3) of rotations as unit quaternions, with its logarithm and exponential.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::Space;

/// Rotations as unit quaternions `[w, x, y, z]`, w ≥ 0; a tangent is `radius · ω` in the body's own frame.
///
/// ```text
/// Exp_q(u) = q exp(u/r),   Log_a(b) = r log(a⁻¹ b),   d(a, b) = r · angle(a⁻¹ b) ≤ π r
/// ```
///
/// Two rotations exactly half a turn apart are joined about the axis whose first non-zero component is positive;
/// [`Space::log_other_way`] gives the other path, which is equally short.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation {
    radius: f64,
}

impl Rotation {
    /// Rotations for which one radian has the length `radius`.
    ///
    /// # Panics
    /// If `radius` is not positive and finite.
    pub fn new(radius: f64) -> Self {
        assert!(
            radius > 0.0 && radius.is_finite(),
            "a radius of {radius} measures no rotation"
        );
        Self { radius }
    }
}

impl Space for Rotation {
    fn coordinates(&self) -> usize {
        4
    }

    fn tangents(&self) -> usize {
        3
    }

    fn exp(&self, x: &mut [f64], tangent: &[f64]) {
        assert_eq!((x.len(), tangent.len()), (4, 3));
        let moved = read(x) * exp(&(Vector3::from_column_slice(tangent) / self.radius));
        write(&moved, x);
    }

    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        let step = log(&(read(a).inverse() * read(b))) * self.radius;
        tangent.copy_from_slice(step.as_slice());
        step.norm()
    }

    /// The rotated axes: a rotation by an angle moves two of them by that angle at most.
    fn landmarks(&self, x: &[f64]) -> Vec<f64> {
        axes(&read(x), self.radius)
    }

    fn log_other_way(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> Option<f64> {
        let step = other_way(&log(&(read(a).inverse() * read(b))))? * self.radius;
        tangent.copy_from_slice(step.as_slice());
        Some(step.norm())
    }
}

/// The axes turned by a rotation. Their length is such that a change of rotation moves all of them together by no more than
/// its arc at `radius`.
pub(super) fn axes(rotation: &UnitQuaternion<f64>, radius: f64) -> Vec<f64> {
    let matrix = rotation.to_rotation_matrix().into_inner();
    (matrix * (radius / std::f64::consts::SQRT_2))
        .as_slice()
        .to_vec()
}

/// Rotation by the vector `turn` (axis times angle, radians).
pub(crate) fn exp(turn: &Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = turn.norm();
    let (sine, cosine) = libm::sincos(0.5 * angle);
    // sin(θ/2)/θ → ½ − θ²/48; below 1e-4 the next term is less than the rounding error of 1.
    let scale = if angle < 1e-4 {
        0.5 - angle * angle / 48.0
    } else {
        sine / angle
    };
    UnitQuaternion::new_unchecked(Quaternion::from_parts(cosine, turn * scale))
}

/// Shortest rotation vector (axis times angle, at most π) of `rotation`. At exactly half a turn its first non-zero
/// component is positive.
pub(crate) fn log(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let (w, v) = (rotation.w, rotation.imag());
    let flip = w < 0.0
        || (w == 0.0
            && v.iter()
                .find(|component| **component != 0.0)
                .is_some_and(|c| *c < 0.0));
    let sine = v.norm();
    // atan2 keeps full accuracy at both ends, where the arc cosine would lose half the digits.
    let scale = if sine == 0.0 {
        2.0
    } else {
        2.0 * libm::atan2(sine, w.abs()) / sine
    };
    if flip { -v * scale } else { v * scale }
}

/// The same rotation about the opposite axis, by 2π − angle; `None` for the identity, which has no axis.
pub(crate) fn other_way(turn: &Vector3<f64>) -> Option<Vector3<f64>> {
    let angle = turn.norm();
    (angle > 0.0).then(|| turn * (1.0 - std::f64::consts::TAU / angle))
}

/// Quaternion of coordinates `[w, x, y, z]`, normalised.
pub(crate) fn read(wxyz: &[f64]) -> UnitQuaternion<f64> {
    let [w, x, y, z] = *wxyz else {
        panic!("a quaternion has 4 coordinates, not {}", wxyz.len());
    };
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}

/// Writes `rotation` as `[w, x, y, z]`, of unit length and with w ≥ 0.
pub(crate) fn write(rotation: &UnitQuaternion<f64>, wxyz: &mut [f64]) {
    let scale = rotation.norm().recip().copysign(rotation.w);
    wxyz.copy_from_slice(&[
        rotation.w * scale,
        rotation.i * scale,
        rotation.j * scale,
        rotation.k * scale,
    ]);
}

/// A unit vector perpendicular to `v`.
pub(crate) fn any_normal(v: &Vector3<f64>) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[v.iamin()] = 1.0;
    v.cross(&axis).try_normalize(0.0).unwrap_or_else(Vector3::x)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn a_quarter_turn_about_z() {
        let space = Rotation::new(2.0);
        let mut x = [1.0, 0.0, 0.0, 0.0];
        space.exp(&mut x, &[0.0, 0.0, PI]);
        let half = 0.5_f64.sqrt();
        approx::assert_abs_diff_eq!(
            x.as_slice(),
            [half, 0.0, 0.0, half].as_slice(),
            epsilon = 1e-15
        );
        approx::assert_abs_diff_eq!(
            space.distance(&[1.0, 0.0, 0.0, 0.0], &x),
            PI,
            epsilon = 1e-15
        );
    }

    #[test]
    fn half_a_turn_goes_about_the_positive_axis_and_the_other_way_about_the_negative() {
        let space = Rotation::new(1.0);
        let (mut short, mut long) = ([0.0; 3], [0.0; 3]);
        for end in [[0.0, -0.6, 0.8, 0.0], [0.0, 0.6, -0.8, 0.0]] {
            space.log(&[1.0, 0.0, 0.0, 0.0], &end, &mut short);
            approx::assert_abs_diff_eq!(
                short.as_slice(),
                [0.6 * PI, -0.8 * PI, 0.0].as_slice(),
                epsilon = 1e-14
            );
            let length = space
                .log_other_way(&[1.0, 0.0, 0.0, 0.0], &end, &mut long)
                .unwrap();
            approx::assert_abs_diff_eq!(
                long.as_slice(),
                [-0.6 * PI, 0.8 * PI, 0.0].as_slice(),
                epsilon = 1e-14
            );
            approx::assert_abs_diff_eq!(length, PI, epsilon = 1e-14);
        }
        let mut tangent = [0.0; 3];
        assert!(
            space
                .log_other_way(&[1.0, 0.0, 0.0, 0.0], &[1.0, 0.0, 0.0, 0.0], &mut tangent)
                .is_none()
        );
    }

    #[test]
    fn tiny_turns_keep_their_digits() {
        for angle in [1e-3, 0.99e-4, 1.01e-4, 1e-9, 1e-150] {
            let turn = Vector3::new(angle, -2.0 * angle, 0.5 * angle);
            approx::assert_relative_eq!(log(&exp(&turn)), turn, max_relative = 1e-13);
        }
    }
}
