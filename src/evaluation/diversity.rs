//! How diverse a population of grasps is, by the measures in use elsewhere and by the sets of contact regions.
//!
//! None of them knows the object's symmetry, and all grow or shrink with the number of grasps: compare populations of the
//! same object and size. Sets of any size are compared by effective numbers of kinds
//! (`study::compare_diversity`).

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, UnitQuaternion, Vector3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::agreement::rarefied_hill_numbers;
use crate::grasp::Grasp;
use crate::hand::{Hand, PosedHand};
use crate::object::Object;
use crate::space::vector::product;
use crate::space::{Pose, object_from_hand};

/// Bins of the entropies, as `GraspQP` has them: a joint that takes all its range alike has the entropy ln 32 = 3.47.
pub const BINS: usize = 32;

/// Half the edge of the box about the object's centroid over which positions are binned, metres; what lies outside falls
/// into the outermost bins.
pub const BOX_M: f64 = 0.1;

/// How many principal components are reported.
const COMPONENTS: usize = 5;

/// Number of grasps to which [`Diversity::contact_region_sets_per_hundred`] is reduced.
const HUNDRED: usize = 100;

/// Greatest gap of a touching point, metres: that of a contact in the strict filter.
pub const TOUCHING_M: f64 = 0.002;

/// The contact regions of the pose `x`: the digits, and the palm, with a surface point at most [`TOUCHING_M`] off the exact
/// mesh of the object, or in it. Links that may not touch do not count.
///
/// `synth`, `survey` and `diversity` all count different sets of these. Finer regions would make almost every grasp a kind of
/// its own, and numbers of kinds that are all met once tell nothing.
///
/// # Panics
/// If `x` is no pose of the hand.
pub fn contact_regions<'a>(hand: &'a Hand, object: &Object, x: &[f64]) -> BTreeSet<&'a str> {
    regions_within(hand, object, x, TOUCHING_M)
}

/// As [`contact_regions`], but with surface points at most `gap_m` off the object.
///
/// # Panics
/// As [`contact_regions`].
pub fn regions_within<'a>(
    hand: &'a Hand,
    object: &Object,
    x: &[f64],
    gap_m: f64,
) -> BTreeSet<&'a str> {
    let mut posed = PosedHand::default();
    hand.pose(x, &mut posed);
    let points = posed.points.iter().zip(&hand.surface);
    points
        .filter(|(_, point)| hand.may_touch(point))
        .filter(|(place, _)| object.exact.distance(place) <= gap_m)
        .map(|(_, point)| hand.digits[hand.links[point.link.0].digit].as_str())
        .collect()
}

/// Measures of diversity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diversity {
    /// Number of grasps.
    pub grasps: usize,
    /// Number of different sets of [`contact_regions`].
    pub contact_region_sets: usize,
    /// Expected number of different sets among a hundred of the grasps drawn without replacement; `None` where there are
    /// fewer.
    pub contact_region_sets_per_hundred: Option<f64>,
    /// Share of the variance of (translation, rotation vector, joints) in the first 1, 2, … 5 principal components, in
    /// metres and radians without scaling, as `DexGraspBench` has it. *Lower* is more diverse.
    pub explained_variance: [f64; COMPONENTS],
    /// Shannon entropy of each joint over [`BINS`] bins between its limits, nats, mean over the joints (after `GraspQP`).
    pub joint_entropy: f64,
    /// Shannon entropy of each of the three coordinates of the hand's origin (over ±[`BOX_M`] about the centroid) and of
    /// the three components of its rotation vector (over ±π), [`BINS`] bins each, nats, mean over the six.
    pub pose_entropy: f64,
}

impl Diversity {
    /// Measures grasps of `hand` on `object`. `None` without grasps.
    ///
    /// # Panics
    /// If a grasp is one of another hand.
    pub fn of<'a>(
        hand: &Hand,
        object: &Object,
        grasps: impl Iterator<Item = &'a Grasp>,
    ) -> Option<Self> {
        let grasps: Vec<&Grasp> = grasps.collect();
        let touching = |grasp: &&Grasp| contact_regions(hand, object, &grasp.pose);
        let touching: Vec<BTreeSet<&str>> = grasps.par_iter().map(touching).collect();
        let mut sets: BTreeMap<BTreeSet<&str>, usize> = BTreeMap::new();
        for set in touching {
            *sets.entry(set).or_insert(0) += 1;
        }
        let centroid = &object.centroid;
        let rows: Vec<Vec<f64>> = (grasps.iter())
            .map(|grasp| row(&grasp.pose, centroid))
            .collect();
        let counts: Vec<usize> = sets.values().copied().collect();
        (!rows.is_empty()).then(|| Self::of_rows(hand, &rows, &counts))
    }

    /// Measures poses as [`row`] gives them, of which `counts` have equal sets of contact regions.
    fn of_rows(hand: &Hand, rows: &[Vec<f64>], counts: &[usize]) -> Self {
        let mut pose = [(-BOX_M, BOX_M); 6];
        pose[3..].fill((-std::f64::consts::PI, std::f64::consts::PI));
        let mean_entropy = |first: usize, ranges: &[(f64, f64)]| {
            let sum: f64 = ranges
                .iter()
                .enumerate()
                .map(|(k, range)| entropy(rows.iter().map(|row| row[first + k]), *range))
                .sum();
            sum / ranges.len().max(1) as f64
        };
        let limits: Vec<(f64, f64)> = hand.joints.iter().map(|j| j.limits.into()).collect();
        Self {
            grasps: rows.len(),
            contact_region_sets: counts.len(),
            contact_region_sets_per_hundred: (rows.len() >= HUNDRED)
                .then(|| rarefied_hill_numbers(counts, HUNDRED)[0]),
            explained_variance: explained_variance(rows),
            joint_entropy: mean_entropy(6, &limits),
            pose_entropy: mean_entropy(0, &pose),
        }
    }
}

/// Translation from the centroid, rotation vector, joints.
fn row(x: &Pose, centroid: &Vector3<f64>) -> Vec<f64> {
    let pose = object_from_hand(x);
    let rotation: UnitQuaternion<f64> = pose.rotation;
    let mut row: Vec<f64> = (pose.translation.vector - centroid)
        .iter()
        .copied()
        .collect();
    row.extend(rotation.scaled_axis().iter());
    row.extend(x.joints());
    row
}

/// Shannon entropy, nats, of values over equal bins of a range; what lies outside falls into the outermost bins.
pub(crate) fn entropy(values: impl Iterator<Item = f64>, (low, high): (f64, f64)) -> f64 {
    let mut counts = [0usize; BINS];
    let mut total = 0usize;
    for value in values {
        let scaled = ((value - low) / (high - low) * BINS as f64).clamp(0.0, (BINS - 1) as f64);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to 0..BINS just above; the cut-off fraction is meant"
        )]
        let bin = scaled as usize;
        counts[bin] += 1;
        total += 1;
    }
    counts
        .iter()
        .filter(|&&count| count > 0)
        .map(|&count| {
            let (count, total) = (count as f64, total as f64);
            count / total * libm::log(total / count)
        })
        .sum()
}

/// Cumulative shares of the first principal components of `rows`; 1 throughout where nothing varies.
pub(crate) fn explained_variance(rows: &[Vec<f64>]) -> [f64; COMPONENTS] {
    let (count, width) = (rows.len(), rows[0].len());
    let mut data = DMatrix::from_fn(count, width, |i, k| rows[i][k]);
    for mut column in data.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    }
    let mut variances: Vec<f64> = product(&data.transpose(), &data)
        .symmetric_eigenvalues()
        .iter()
        .map(|value| value.max(0.0))
        .collect();
    variances.sort_by(|a, b| b.total_cmp(a));
    let total: f64 = variances.iter().sum();
    let mut sum = 0.0;
    std::array::from_fn(|k| {
        sum += variances.get(k).copied().unwrap_or(0.0);
        if total > 0.0 { sum / total } else { 1.0 }
    })
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::sample::{Task, stream};
    use crate::space::joints_of_mut;

    fn poses(hand: &Hand, count: usize, spread: f64) -> Vec<Vec<f64>> {
        let mut rng = stream(1, Task::Start, 0);
        (0..count)
            .map(|_| {
                let mut x = hand.rest_coordinates();
                for (q, joint) in joints_of_mut(&mut x).iter_mut().zip(&hand.joints) {
                    let [low, high] = joint.limits;
                    let anywhere = rng.random_range(low..high);
                    *q += spread * (anywhere - *q);
                }
                x
            })
            .collect()
    }

    fn grasps(poses: &[Vec<f64>]) -> Vec<Grasp> {
        let grasp = |x: &Vec<f64>| Grasp::new(x.clone(), Vec::new());
        poses.iter().map(grasp).collect()
    }

    /// Without the contact regions, which take most of the time.
    fn measure(hand: &Hand, poses: &[Vec<f64>]) -> Diversity {
        let rows: Vec<Vec<f64>> = (grasps(poses).iter())
            .map(|grasp| row(&grasp.pose, &Vector3::zeros()))
            .collect();
        Diversity::of_rows(hand, &rows, &[rows.len()])
    }

    fn ball() -> Object {
        Object::named("ball").unwrap()
    }

    #[test]
    fn one_grasp_again_and_again_has_none() {
        let hand = Hand::human();
        let of = |count| {
            let grasps = grasps(&poses(&hand, count, 0.0));
            Diversity::of(&hand, &ball(), grasps.iter()).unwrap()
        };
        let same = of(50);
        assert_eq!(same.contact_region_sets, 1);
        assert_eq!(
            same.contact_region_sets_per_hundred, None,
            "the count of fifty is no rate of a hundred"
        );
        let hundred = of(100);
        assert!((hundred.contact_region_sets_per_hundred.unwrap() - 1.0).abs() < 1e-12);
        assert!(
            same.explained_variance
                .iter()
                .all(|share| (share - 1.0).abs() < 1e-12)
        );
        assert!(same.joint_entropy.abs() < 1e-12 && same.pose_entropy.abs() < 1e-12);
        let none = Diversity::of(&hand, &ball(), std::iter::empty());
        assert!(none.is_none());
    }

    /// The palm lies 1 mm off the ball, then 3 mm.
    #[test]
    fn what_is_within_two_millimetres_touches() {
        let hand = Hand::human();
        let ball = ball();
        let mut x = hand.rest_coordinates();
        x[2] += 1.0;
        assert!(contact_regions(&hand, &ball, &x).is_empty(), "a metre off");
        // The nearest point of all, moved on to the ball along the line between the two.
        let nearest = |x: &[f64]| {
            let mut posed = PosedHand::default();
            hand.pose(x, &mut posed);
            let gaps = posed.points.iter().zip(&hand.surface);
            let gaps = gaps.filter(|(_, point)| hand.may_touch(point));
            let gaps = gaps.map(|(place, point)| (ball.exact.distance(place), point));
            let (gap, point) = gaps.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            (gap, hand.digits[hand.links[point.link.0].digit].clone())
        };
        for _ in 0..200 {
            let (gap, _) = nearest(&x);
            x[2] -= gap - 0.001;
        }
        let (gap, digit) = nearest(&x);
        assert!((gap - 0.001).abs() < 1e-5, "{gap}");
        assert!(contact_regions(&hand, &ball, &x).contains(digit.as_str()));
        x[2] += 0.01;
        let (gap, _) = nearest(&x);
        assert!(gap > 0.002, "{gap}");
        assert!(contact_regions(&hand, &ball, &x).is_empty());
    }

    #[test]
    fn uniform_joints_have_the_largest_entropy() {
        let hand = Hand::human();
        let wide = measure(&hand, &poses(&hand, 20_000, 1.0));
        assert!(
            (wide.joint_entropy - libm::log(BINS as f64)).abs() < 0.01,
            "{wide:?}"
        );
        let narrow = measure(&hand, &poses(&hand, 20_000, 0.25));
        // A quarter of the range: ln(32/4), up to the bins at the ends that are cut.
        assert!(
            (narrow.joint_entropy - libm::log(8f64)).abs() < 0.15,
            "{narrow:?}"
        );
        assert!(wide.explained_variance.is_sorted() && wide.explained_variance[4] < 1.0);
    }

    #[test]
    fn variance_along_one_line_is_explained_by_one_component() {
        let hand = Hand::human();
        let line: Vec<Vec<f64>> = (0..20)
            .map(|i| {
                let mut x = hand.rest_coordinates();
                x[0] += 1e-3 * f64::from(i);
                x[8] += 0.02 * f64::from(i);
                x
            })
            .collect();
        let found = measure(&hand, &line);
        assert!(
            (found.explained_variance[0] - 1.0).abs() < 1e-9,
            "{found:?}"
        );
    }
}
