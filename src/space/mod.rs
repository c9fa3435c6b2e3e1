//! What "move" and "towards" mean for a point of a landscape.
//!
//! Every path quantity of this crate (tangent, length, projection, update) is written with the two maps of
//! [`Space`]: [`Space::log`] (the logarithm) and [`Space::exp`] (the exponential). Nothing here knows an energy.

mod assignment;
mod cluster;
mod euclidean;
mod mirrored;
mod pose;
mod rotation;
mod structure;
mod symmetry;
mod torus;
pub(crate) mod vector;

pub use cluster::Cluster;
pub use euclidean::Euclidean;
pub use mirrored::Mirrored;
pub use pose::{PoseMetric, PoseSpace, object_from_hand, pose_coordinates};
pub use rotation::Rotation;
pub use structure::{moments_of_inertia, point_group_order};
pub use symmetry::Symmetry;
pub use torus::Torus;

/// A Riemannian manifold whose points are flat coordinate slices and whose tangents are orthonormal.
///
/// `coordinates()` numbers make a point, `tangents()` numbers a direction; they differ where a point carries a
/// quaternion. Tangent components are orthonormal in the metric, so the Euclidean dot product of two tangents at one
/// point is their inner product and the norm of a tangent is a length.
///
/// A space with a symmetry (an object of revolution, a cluster of equal atoms) measures *modulo* it:
/// `log(a, b)` then leads to that copy of `b` which is nearest to `a`.
pub trait Space: Sync {
    /// How many numbers describe a point.
    fn coordinates(&self) -> usize;

    /// How many numbers describe a tangent.
    fn tangents(&self) -> usize;

    /// Exponential map: moves `x` along the geodesic with initial velocity `tangent` for unit time.
    ///
    /// Gradients of an [`Energy`](crate::energy::Energy) are derivatives along this move, and are checked that way.
    /// Moving back by the negated tangent returns to the start (frames are carried along: a rotation is a tangent in the
    /// body's own frame), so the reverse of a Metropolis proposal is its negation.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    fn exp(&self, x: &mut [f64], tangent: &[f64]);

    /// Logarithm map: writes the shortest tangent at `a` that leads to (a copy of) `b` and returns its length.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64;

    /// The other way from `a` to the copy of `b` that [`Space::log`] leads to: its rotation the long way round, or the angle
    /// nearest to half a turn past the other side. Writes the tangent and returns its length. `None` where there is no
    /// second way.
    ///
    /// Near half a turn the two ways are almost equally short; a path search that starts from straight lines should try
    /// both when the second is not much longer.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    fn toward_other_way(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> Option<f64> {
        let _ = (a, b, tangent);
        None
    }

    /// As [`Space::log`], for points whose coordinates are known to run on smoothly from one to the other (neighbours
    /// on a path, a chain and the copy of its target it set out for): no search for a nearer copy is made.
    ///
    /// Spaces with a costly symmetry override this. By default the same as [`Space::log`].
    ///
    /// # Panics
    /// If a slice has the wrong length.
    fn log_near(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        self.log(a, b, tangent)
    }

    /// Length of the shortest path between `a` and `b`, modulo the symmetry of the space.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        self.log(a, b, &mut vec![0.0; self.tangents()])
    }

    /// Numbers that tell points apart without measuring: between two points they differ, as vectors, by no more than the
    /// distance of the points, and they are the same for all copies of a point. Who looks for points near another measures
    /// only those whose landmarks are near.
    ///
    /// None by default, by which everything may be near.
    ///
    /// # Panics
    /// If `x` has the wrong length.
    fn landmarks(&self, x: &[f64]) -> Vec<f64> {
        let _ = x;
        Vec::new()
    }

    /// Typical size of a sensible move along each tangent, relative to the first one: what samplers and optimisers
    /// multiply a step with.
    ///
    /// The metric is made for distance; as a mass matrix it may be badly conditioned (a fingertip joint moves its pad
    /// ten times farther than the average point of the hand). All ones by default.
    fn step_scales(&self) -> Vec<f64> {
        vec![1.0; self.tangents()]
    }

    /// Directions at `x` along which nothing changes (overall translation and rotation of a cluster): `rows` of
    /// orthonormal tangents, concatenated. Empty by default. Saddle searches project them out.
    fn zero_modes(&self, x: &[f64]) -> Vec<f64> {
        let _ = x;
        Vec::new()
    }
}

/// Point a fraction `t` of the way from `a` to (the nearest copy of) `b` along the geodesic.
///
/// # Panics
/// If a slice has the wrong length.
pub fn interpolate(space: &dyn Space, a: &[f64], b: &[f64], t: f64) -> Vec<f64> {
    let mut tangent = vec![0.0; space.tangents()];
    space.log(a, b, &mut tangent);
    for component in &mut tangent {
        *component *= t;
    }
    let mut x = a.to_vec();
    space.exp(&mut x, &tangent);
    x
}
