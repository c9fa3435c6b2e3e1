//! Geometry of the space of a landscape.
//!
//! Tangents, lengths, projections and updates of paths in this crate are all written with two maps of [`Space`]:
//! [`Space::log`] (the logarithm) and [`Space::exp`] (the exponential). Nothing here depends on an energy.

mod assignment;
mod cluster;
mod coordinates;
mod copies;
mod euclidean;
mod fixed_frame;
mod mirrored;
mod periodic;
mod pose;
mod rotation;
mod structure;
mod symmetry;
mod torus;
pub(crate) mod vector;

pub use cluster::Cluster;
#[cfg(test)]
pub(crate) use coordinates::put_root;
pub use coordinates::{Pose, joints_of, joints_of_mut, object_from_hand, pose_coordinates};
#[cfg(feature = "grasp")]
pub(crate) use coordinates::{quaternion_of, translation_of};
pub use copies::{Copies, Symmetries, SymmetryError};
pub use euclidean::Euclidean;
pub use fixed_frame::FixedFrame;
pub use mirrored::Mirrored;
pub use periodic::Periodic;
pub use pose::{PoseMetric, PoseSpace};
pub use rotation::Rotation;
pub use structure::{moments_of_inertia, point_group_order};
pub use symmetry::Symmetry;
pub use torus::Torus;

/// A Riemannian manifold. Points are slices of coordinates, and tangents are given in an orthonormal basis.
///
/// A point has `coordinates()` numbers and a tangent `tangents()` numbers; they differ if a point contains a quaternion.
/// The Euclidean dot product of two tangents at one point is their inner product, and the norm of a tangent is a length.
///
/// A space with a symmetry (an object of revolution, a cluster of equal atoms) measures *modulo* it: `log(a, b)` leads to
/// the copy of `b` that is nearest to `a`.
///
/// # Examples
/// On a torus the short way from 3 to −3 radians leads past half a turn.
///
/// ```
/// use landscape::space::{Space, Torus};
///
/// let torus = Torus::new(1);
/// let mut tangent = [0.0];
/// let distance = torus.log(&[3.0], &[-3.0], &mut tangent);
/// assert!((distance - 0.283).abs() < 1e-3 && tangent[0] > 0.0);
/// let mut x = [3.0];
/// torus.exp(&mut x, &tangent);
/// assert!((x[0] + 3.0).abs() < 1e-12);
/// ```
pub trait Space: Sync {
    /// How many numbers describe a point.
    fn coordinates(&self) -> usize;

    /// How many numbers describe a tangent.
    fn tangents(&self) -> usize;

    /// Exponential map: moves `x` along the geodesic with initial velocity `tangent` for unit time.
    ///
    /// Gradients of an [`Energy`](crate::energy::Energy) are derivatives along this motion, and are checked that way.
    /// Moving back by the negated tangent returns to the start, because frames are carried along (a rotation is a tangent
    /// in the body's own frame). So the reverse of a Metropolis proposal is its negation.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    fn exp(&self, x: &mut [f64], tangent: &[f64]);

    /// Logarithm map: writes the shortest tangent at `a` that leads to (a copy of) `b` and returns its length.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64;

    /// The second path from `a` to the copy of `b` that [`Space::log`] leads to: its rotation goes the long way round, or
    /// else the angle nearest to half a turn does. Writes the tangent and returns its length. `None` if there is no second
    /// path.
    ///
    /// Near half a turn the two paths have almost the same length. A path search that starts from straight lines should try
    /// both if the second is not much longer.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    fn log_other_way(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> Option<f64> {
        let _ = (a, b, tangent);
        None
    }

    /// As [`Space::log`] with less effort to find the nearest copy: it may lead to a copy farther away. By default the same as
    /// [`Space::log`].
    ///
    /// # Panics
    /// If a slice has the wrong length.
    fn log_quickly(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        self.log(a, b, tangent)
    }

    /// As [`Space::log`] without a search for a nearer copy, for points whose coordinates vary smoothly from one to the
    /// other (neighbours on a path, or a chain and the copy of its target that it set out for).
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

    /// Whether the distance between `a` and `b` is at most `reach`. By default it measures the distance; spaces with a costly
    /// symmetry override this with a test that is fast both for copies and for points that are far apart.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    fn within(&self, a: &[f64], b: &[f64], reach: f64) -> bool {
        self.distance(a, b) <= reach
    }

    /// Numbers that bound the distance from below: the Euclidean distance of two points' landmarks is at most the distance
    /// of the points, and all copies of a point have the same landmarks. A search for nearby points measures only those
    /// whose landmarks are near.
    ///
    /// Empty by default, which excludes no point.
    ///
    /// # Panics
    /// If `x` has the wrong length.
    fn landmarks(&self, x: &[f64]) -> Vec<f64> {
        let _ = x;
        Vec::new()
    }

    /// Typical size of a step along each tangent, relative to the first one; samplers and optimisers multiply steps by it.
    ///
    /// The metric is made for distance, and as a mass matrix it may be badly conditioned (a fingertip joint moves its pad
    /// ten times farther than the average point of the hand). All ones by default.
    fn step_scales(&self) -> Vec<f64> {
        vec![1.0; self.tangents()]
    }

    /// Directions at `x` along which nothing changes (overall translation and rotation of a cluster), as orthonormal
    /// tangents, concatenated. Empty by default. Saddle searches project them out.
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
