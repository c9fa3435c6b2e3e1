//! Angles about the fixed axes x, y and z.

use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Quaternion of R = Rz(c) Ry(b) Rx(a): angles about fixed axes, as in transforms3d's `sxyz`.
pub(super) fn of_euler([a, b, c]: [f64; 3]) -> [f64; 4] {
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), c)
        * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), b)
        * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), a);
    [rotation.w, rotation.i, rotation.j, rotation.k]
}

/// Quaternion of R = Rx(a) Ry(b) Rz(c): angles about the axes as they have turned, as in transforms3d's `rxyz` and in
/// `pytorch3d.euler_angles_to_matrix(…, "XYZ")`.
pub(super) fn of_moving_euler([a, b, c]: [f64; 3]) -> [f64; 4] {
    // The same rotation backwards, with the angles reversed.
    let [w, x, y, z] = of_euler([-a, -b, -c]);
    [w, -x, -y, -z]
}

/// The angles of [`of_euler`]; the second is within ±90°.
pub(super) fn to_euler([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    let rotation = Rotation3::from(UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)));
    let m = rotation.matrix();
    let level = libm::hypot(m[(0, 0)], m[(1, 0)]);
    let second = libm::atan2(-m[(2, 0)], level);
    if level > 1e-8 {
        [
            libm::atan2(m[(2, 1)], m[(2, 2)]),
            second,
            libm::atan2(m[(1, 0)], m[(0, 0)]),
        ]
    } else {
        // The first and third axes coincide, so the first angle takes the whole rotation.
        [libm::atan2(-m[(1, 2)], m[(1, 1)]), second, 0.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_quaternions_agree() {
        for angles in [
            [0.3, -0.7, 2.9],
            [-3.0, 1.2, 0.1],
            [0.4, std::f64::consts::FRAC_PI_2, 0.0],
            [1.0, -1.55, -2.0],
        ] {
            let quaternion = of_euler(angles);
            let again = of_euler(to_euler(quaternion));
            let dot: f64 = quaternion.iter().zip(again).map(|(a, b)| a * b).sum();
            assert!((dot.abs() - 1.0).abs() < 1e-12, "{angles:?}: {dot}");
        }
        // A quarter turn about x, then one about the z that has turned, which is −y: x goes to z.
        let quarter = std::f64::consts::FRAC_PI_2;
        let [w, x, y, z] = of_moving_euler([quarter, 0.0, quarter]);
        let q = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        assert!((q * Vector3::x() - Vector3::z()).norm() < 1e-12);
        // A quarter turn about x, then one about z: y goes to z and stays there.
        let [w, x, y, z] = of_euler([
            std::f64::consts::FRAC_PI_2,
            0.0,
            std::f64::consts::FRAC_PI_2,
        ]);
        let q = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        assert!((q * Vector3::y() - Vector3::z()).norm() < 1e-12);
    }
}
