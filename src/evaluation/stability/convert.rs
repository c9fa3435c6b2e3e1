//! Conversion between the vectors of nalgebra and of the physics engine.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d_f64::math::{Pose, Rotation, Vector};

use crate::hand::Frame;

pub(super) fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(super) fn from_vector(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

pub(super) fn frame(frame: &Frame) -> Pose {
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(frame.rotation);
    let q = UnitQuaternion::from_rotation_matrix(&rotation);
    Pose::from_parts(
        vector(&frame.translation),
        Rotation::from_xyzw(q.i, q.j, q.k, q.w),
    )
}

pub(super) fn isometry(pose: &Pose) -> Isometry3<f64> {
    let q = pose.rotation;
    Isometry3::from_parts(
        Translation3::from(from_vector(pose.translation)),
        UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z)),
    )
}
