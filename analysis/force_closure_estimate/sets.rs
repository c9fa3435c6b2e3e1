//! Random contact sets on the unit sphere, and the results of both tests for them.

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
    pub(crate) verdict: Verdict,
}

/// Results of both tests for some contacts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Verdict {
    /// ‖Gc‖.
    pub(crate) net_wrench: f64,
    /// Exact force closure at [`FRICTIONS`].
    pub(crate) closed: [bool; 2],
}

/// The contact points of set number `id`, independent and uniform.
pub(crate) fn points(contacts: usize, id: u64) -> Vec<Vector3<f64>> {
    let mut rng = stream(contacts as u64, Task::Start, id);
    (0..contacts)
        .map(|_| Vector3::from(UnitSphere.sample(&mut rng)))
        .collect()
}

/// The contacts at points of the unit sphere.
pub(crate) fn contacts(points: &[Vector3<f64>]) -> Vec<PointContact> {
    points
        .iter()
        .map(|&arm| PointContact {
            arm,
            inward_normal: -arm,
        })
        .collect()
}

impl Verdict {
    pub(crate) fn of(contacts: &[PointContact]) -> Self {
        Self {
            net_wrench: net_wrench(contacts),
            closed: FRICTIONS.map(|friction| is_force_closure(contacts, friction)),
        }
    }
}

/// `count` sets of three, in ascending order of least friction.
pub(crate) fn threes(count: u64) -> Vec<Set> {
    let set = |id: u64| {
        let contacts = contacts(&points(3, id));
        Set {
            least_friction: least_friction(&contacts),
            verdict: Verdict::of(&contacts),
        }
    };
    let mut sets: Vec<Set> = (0..count).into_par_iter().map(set).collect();
    sets.sort_by(|a, b| a.least_friction.total_cmp(&b.least_friction));
    sets
}
