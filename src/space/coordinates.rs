//! The layout `x = (t, q, θ)` of a hand's coordinates, which is defined only here.

use std::ops::{Deref, DerefMut};

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::rotation::{read, write};

/// Index of the first number of the quaternion, and of the first joint.
const ROTATION: usize = 3;
const JOINTS: usize = 7;

/// A pose of a hand, which is a point of [`PoseSpace`](super::PoseSpace): position t of the hand's root in the object's
/// frame (metres), unit quaternion q (scalar first, object from hand) and joint coordinates θ (radians, metres of slides).
/// It dereferences to the `7 + k` flat numbers that energies take.
///
/// ```
/// use landscape::space::Pose;
///
/// let pose = Pose::new([0.1, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], &[0.5]);
/// assert_eq!(pose.joints(), [0.5]);
/// assert_eq!(pose.len(), 8);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Pose(Vec<f64>);

impl Pose {
    /// The pose with these parts, which are not normalised.
    pub fn new(translation_m: [f64; 3], rotation_wxyz: [f64; 4], joints: &[f64]) -> Self {
        Self([&translation_m[..], &rotation_wxyz, joints].concat())
    }

    /// The pose of a hand whose root frame is the object's frame.
    pub fn at_origin(joints: &[f64]) -> Self {
        Self::new([0.0; 3], [1.0, 0.0, 0.0, 0.0], joints)
    }

    /// Position of the hand's root in the object's frame, metres.
    pub fn translation_m(&self) -> &[f64] {
        &self[..ROTATION]
    }

    /// Quaternion, scalar first, object from hand.
    pub fn rotation_wxyz(&self) -> [f64; 4] {
        std::array::from_fn(|k| self[ROTATION + k])
    }

    /// Replaces the quaternion.
    pub fn set_rotation_wxyz(&mut self, rotation_wxyz: [f64; 4]) {
        self[ROTATION..JOINTS].copy_from_slice(&rotation_wxyz);
    }

    /// Joint coordinates, radians (metres of slides).
    pub fn joints(&self) -> &[f64] {
        joints_of(self)
    }
}

/// A hand without joints whose root frame is the object's frame.
impl Default for Pose {
    fn default() -> Self {
        Self::at_origin(&[])
    }
}

/// Takes flat coordinates without normalising them.
///
/// # Panics
/// If there are fewer than 7 numbers.
impl From<Vec<f64>> for Pose {
    fn from(x: Vec<f64>) -> Self {
        assert!(x.len() >= JOINTS, "a pose has 7 numbers and the joints");
        Self(x)
    }
}

impl From<Pose> for Vec<f64> {
    fn from(pose: Pose) -> Self {
        pose.0
    }
}

impl Deref for Pose {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.0
    }
}

impl DerefMut for Pose {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

/// Joint coordinates θ of flat pose coordinates, radians (metres of slides).
///
/// # Panics
/// If `x` has fewer than 7 numbers, as for the other functions of this file.
pub fn joints_of(x: &[f64]) -> &[f64] {
    &x[JOINTS..]
}

/// Mutable joint coordinates θ of flat pose coordinates.
///
/// # Panics
/// If `x` has fewer than 7 numbers.
pub fn joints_of_mut(x: &mut [f64]) -> &mut [f64] {
    &mut x[JOINTS..]
}

/// Position t of flat pose coordinates.
pub(crate) fn translation_of(x: &[f64]) -> Vector3<f64> {
    Vector3::from_column_slice(&x[..ROTATION])
}

/// Quaternion q of flat pose coordinates, not normalised.
#[cfg(feature = "grasp")]
pub(crate) fn quaternion_of(x: &[f64]) -> nalgebra::Quaternion<f64> {
    nalgebra::Quaternion::new(x[3], x[4], x[5], x[6])
}

/// Rotation of flat pose coordinates.
pub(super) fn rotation_of(x: &[f64]) -> UnitQuaternion<f64> {
    read(&x[ROTATION..JOINTS])
}

/// Writes position and rotation (w ≥ 0) into flat pose coordinates.
pub(crate) fn put_root(
    x: &mut [f64],
    translation_m: &Vector3<f64>,
    rotation: &UnitQuaternion<f64>,
) {
    x[..ROTATION].copy_from_slice(translation_m.as_slice());
    write(rotation, &mut x[ROTATION..JOINTS]);
}

/// The transform `object_from_hand` of pose coordinates.
///
/// # Panics
/// If `x` has fewer than 7 numbers.
pub fn object_from_hand(x: &[f64]) -> Isometry3<f64> {
    Isometry3::from_parts(translation_of(x).into(), rotation_of(x))
}

/// Pose coordinates `[t, q wxyz (w ≥ 0), joints]` of a transform `object_from_hand` and joint coordinates.
pub fn pose_coordinates(object_from_hand: &Isometry3<f64>, joints: &[f64]) -> Vec<f64> {
    let mut x = vec![0.0; JOINTS + joints.len()];
    let translation_m = &object_from_hand.translation.vector;
    put_root(&mut x, translation_m, &object_from_hand.rotation);
    x[JOINTS..].copy_from_slice(joints);
    x
}
