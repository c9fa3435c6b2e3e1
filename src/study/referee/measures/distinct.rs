//! Numbers of different grasps.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::facts::{GraspFacts, MeasuredObject};
use crate::space::{Space, object_from_hand};

/// Distance from which on two grasps are distinct, metres in the metric of poses.
pub const DISTINCT_M: f64 = 0.005;

/// The nominal cell of `GraspQP`'s "2 cm": position in metres, joints in radians, angle in radians.
const CELL_M: f64 = 0.02;
const CELL_RAD: f64 = 0.2;
const CELL_ANGLE_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// For each grasp of an object the earlier ones that count as the same.
pub(super) struct Sameness(Vec<Vec<usize>>);

impl Sameness {
    fn of(count: usize, same: impl Fn(usize, usize) -> bool + Sync) -> Self {
        let earlier = |grasp: usize| (0..grasp).filter(|other| same(*other, grasp)).collect();
        Self((0..count).into_par_iter().map(earlier).collect())
    }

    /// Grasps closer than [`DISTINCT_M`] in the metric of poses, modulo the symmetry of the object.
    pub(super) fn in_metric(object: &MeasuredObject) -> Self {
        let pose = |grasp: usize| &object.grasps[grasp].pose;
        Self::of(object.grasps.len(), |a, b| {
            object.space.within(pose(a), pose(b), DISTINCT_M)
        })
    }

    /// Grasps within 2 cm, 5° and 0.2 rad of each joint.
    pub(super) fn in_cells(object: &MeasuredObject) -> Self {
        let pose = |grasp: usize| &object.grasps[grasp].pose;
        Self::of(object.grasps.len(), |a, b| {
            let (a, b) = (pose(a), pose(b));
            let [from, to] = [a, b].map(|pose| object_from_hand(pose));
            let joints = || a.joints().iter().zip(b.joints());
            (from.translation.vector - to.translation.vector).norm() <= CELL_M
                && joints().all(|(a, b)| (a - b).abs() <= CELL_RAD)
                && from.rotation.angle_to(&to.rotation) <= CELL_ANGLE_RAD
        })
    }

    /// The number of different grasps among these: in the order of the file, each counts that is not the same as one that
    /// counted before.
    pub(super) fn count(&self, grasps: &[usize]) -> usize {
        let mut wanted = vec![false; self.0.len()];
        for grasp in grasps {
            wanted[*grasp] = true;
        }
        let mut counted = vec![false; self.0.len()];
        for grasp in (0..wanted.len()).filter(|grasp| wanted[*grasp]) {
            counted[grasp] = !self.0[grasp].iter().any(|earlier| counted[*earlier]);
        }
        counted.into_iter().filter(|counted| *counted).count()
    }
}

/// Number of different rows after rounding to multiples of a position (metres) and of an angle of joints (radians), half to
/// even. Orientations do not count: `GraspQP` rounds them to multiples of 286 rad at least, because degrees are turned to
/// radians the wrong way.
fn rounded<'a>(
    grasps: impl Iterator<Item = &'a GraspFacts>,
    position_m: f64,
    joint_rad: f64,
) -> usize {
    let row = |facts: &GraspFacts| -> Vec<i64> {
        let places = facts.pose.translation_m().iter().map(|x| x / position_m);
        let joints = facts.pose.joints().iter().map(|q| q / joint_rad);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "whole numbers, and poses are metres and radians"
        )]
        let whole = |x: f64| x.round_ties_even() as i64;
        places.chain(joints).map(whole).collect()
    };
    grasps.map(row).collect::<BTreeSet<_>>().len()
}

/// Unique grasps at `GraspQP`'s "2 cm" with its two faults: the angle is lost, and the precisions of position and joints are
/// exchanged, so that cells are 0.2 m and 0.02 rad.
pub(super) fn unique_published<'a>(grasps: impl Iterator<Item = &'a GraspFacts>) -> usize {
    rounded(grasps, CELL_RAD, CELL_M)
}

/// The same with position and joints in order; the angle is lost still.
pub(super) fn unique_ordered<'a>(grasps: impl Iterator<Item = &'a GraspFacts>) -> usize {
    rounded(grasps, CELL_M, CELL_RAD)
}
