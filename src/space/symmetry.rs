//! Rigid motions of an object onto itself.

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};

/// The rotations that map an object onto itself, in the object's frame. Poses that differ by one of them are the same
/// grasp.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Symmetry {
    /// Only the identity.
    #[default]
    None,
    /// Every rotation about an axis (a bottle).
    Axis {
        /// A point on the axis, metres.
        point: Vector3<f64>,
        /// Its direction, of any positive length.
        direction: Vector3<f64>,
    },
    /// Every rotation about a point (a ball).
    Sphere {
        /// The centre, metres.
        centre: Vector3<f64>,
    },
    /// The listed motions (a cube, a mug without print). They must form a group, or distances are not symmetric; the
    /// identity may be left out.
    Finite(Vec<Isometry3<f64>>),
}

impl Symmetry {
    pub(super) fn normalized(self) -> Self {
        match self {
            Self::Axis { point, direction } => Self::Axis {
                point,
                direction: direction
                    .try_normalize(0.0)
                    .expect("the direction of an axis is not zero"),
            },
            other => other,
        }
    }
}
