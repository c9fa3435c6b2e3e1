//! Random sets of three contacts on the unit sphere, the results of both tests for them, and fits of ‖Gc‖ against μ₀.

use landscape::grasp::closure::{PointContact, is_force_closure, least_friction, net_wrench};
use landscape::sample::{Task, stream};
use nalgebra::Vector3;
use rand_distr::{Distribution, UnitSphere};
use rayon::prelude::*;

/// Frictions of the exact test.
pub(crate) const FRICTIONS: [f64; 2] = [0.5, 1.0];

/// Results for three contacts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Set {
    /// μ₀.
    pub(crate) least_friction: f64,
    /// ‖Gc‖.
    pub(crate) net_wrench: f64,
    /// Exact force closure at [`FRICTIONS`].
    pub(crate) closed: [bool; 2],
}

/// The contacts at points of the unit sphere.
pub(crate) fn contacts(points: &[Vector3<f64>]) -> Vec<PointContact> {
    let contact = |&arm: &Vector3<f64>| PointContact {
        arm,
        inward_normal: -arm,
    };
    points.iter().map(contact).collect()
}

/// `count` sets of independent and uniform points, in ascending order of least friction.
pub(crate) fn threes(count: u64) -> Vec<Set> {
    let set = |id: u64| {
        let mut rng = stream(3, Task::Start, id);
        let points = [(); 3].map(|()| Vector3::from(UnitSphere.sample(&mut rng)));
        let contacts = contacts(&points);
        Set {
            least_friction: least_friction(&contacts),
            net_wrench: net_wrench(&contacts),
            closed: FRICTIONS.map(|friction| is_force_closure(&contacts, friction)),
        }
    };
    let mut sets: Vec<Set> = (0..count).into_par_iter().map(set).collect();
    sets.sort_by(|a, b| a.least_friction.total_cmp(&b.least_friction));
    sets
}

/// Least squares of the sets with μ₀ up to a limit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fit {
    pub(crate) sets: usize,
    /// a of ‖Gc‖ = a μ₀.
    pub(crate) through_origin: f64,
    /// a and b of ‖Gc‖ = a μ₀ + b.
    pub(crate) slope: f64,
    pub(crate) offset: f64,
    /// Pearson's r.
    pub(crate) correlation: f64,
}

impl Fit {
    /// Fits to the sets with μ₀ ≤ `limit`. `sets` must be in ascending order of μ₀.
    pub(crate) fn up_to(sets: &[Set], limit: f64) -> Self {
        let sets = &sets[..sets.partition_point(|set| set.least_friction <= limit)];
        let points = || sets.iter().map(|set| [set.least_friction, set.net_wrench]);
        let count = sets.len() as f64;
        let centre =
            [0, 1].map(|axis: usize| points().map(|point| point[axis]).sum::<f64>() / count);
        let moment = |a: usize, b: usize, about: [f64; 2]| -> f64 {
            points()
                .map(|point| (point[a] - about[a]) * (point[b] - about[b]))
                .sum()
        };
        let slope = moment(0, 1, centre) / moment(0, 0, centre);
        let residual = moment(1, 1, centre) - slope * moment(0, 1, centre);
        let explained = 1.0 - residual / moment(1, 1, centre);
        Self {
            sets: sets.len(),
            through_origin: moment(0, 1, [0.0; 2]) / moment(0, 0, [0.0; 2]),
            slope,
            offset: centre[1] - slope * centre[0],
            correlation: explained.sqrt().copysign(slope),
        }
    }
}

/// The limit of μ₀ between the given two at which the slope through the origin is `slope`. The slope falls with the limit.
pub(crate) fn limit_with_slope(sets: &[Set], slope: f64, between: [f64; 2]) -> f64 {
    let [mut low, mut high] = between;
    while high - low > 1e-6 {
        let middle = 0.5 * (low + high);
        if Fit::up_to(sets, middle).through_origin > slope {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
