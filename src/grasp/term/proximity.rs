//! Lists of the parts of hand and object that may overlap, valid while the hand moves a little.
//!
//! Two parts cannot touch if their distance was greater than both have moved since. Nothing else is left out, so terms that
//! use these lists give bitwise the same result as over all parts, only faster.

use nalgebra::Vector3;

use crate::hand::{Hand, PosedHand, closest_points};
use crate::object::Object;

/// Distance from a capsule within which object samples are listed. The list is valid until the capsule has moved that far.
const MARGIN_M: f64 = 0.008;

/// Self-pairs with a greater gap are tested only after some part has moved half as far.
const NEIGHBOURHOOD_M: f64 = 0.01;

/// Rounding error of distances below a metre.
const ROUNDING_M: f64 = 1e-12;

/// Parts that may overlap at the last pose, for one hand and one object.
#[derive(Debug, Clone, Default)]
pub struct Proximity {
    intruders: Vec<Intruders>,
    folds: Folds,
    pairs: Vec<u32>,
}

#[derive(Debug, Clone, Default)]
struct Intruders {
    /// Axis of the capsule when the list was made.
    axis: [Vector3<f64>; 2],
    /// Greatest movement of the ends of the axis for which the list is valid.
    margin_m: f64,
    samples: Vec<u32>,
}

/// Gaps between the parts of the hand at the joint angles of their measurement.
#[derive(Debug, Clone, Default)]
struct Folds {
    /// Axes of all capsules, in the root frame.
    axes: Vec<[Vector3<f64>; 2]>,
    gaps_m: Vec<f64>,
    /// Self-pairs with a gap up to [`NEIGHBOURHOOD_M`].
    neighbours: Vec<u32>,
    /// Movement of each capsule in the root frame since then.
    moved_m: Vec<f64>,
    /// Numbers of pairs listed at first and in vain since. Gaps are measured again when these are many.
    fewest: usize,
    wasted: usize,
}

impl Proximity {
    /// Updates the lists of object samples.
    pub fn update_intruders(&mut self, hand: &Hand, posed: &PosedHand, object: &Object) {
        self.intruders
            .resize(hand.capsules.len(), Intruders::default());
        let axes = hand.capsules.iter().zip(&posed.capsules);
        for (list, (capsule, axis)) in self.intruders.iter_mut().zip(axes) {
            if farthest_squared(&list.axis, axis) >= list.margin_m * list.margin_m {
                list.renew(axis, capsule.radius_m, object);
            }
        }
    }

    /// Ascending indices of the object's samples that may be inside `capsule`.
    pub fn intruders(&self, capsule: usize) -> &[u32] {
        &self.intruders[capsule].samples
    }

    /// Updates the list of self-pairs.
    pub fn update_pairs(&mut self, hand: &Hand, posed: &PosedHand) {
        let root = &posed.object_from_link[0];
        let in_root =
            |axis: &[Vector3<f64>; 2]| [root.inverse_point(&axis[0]), root.inverse_point(&axis[1])];
        let folds = &mut self.folds;
        if folds.axes.len() == posed.capsules.len() {
            folds.moved_m.clear();
            let axes = folds.axes.iter().zip(&posed.capsules);
            folds
                .moved_m
                .extend(axes.map(|(old, new)| farthest_squared(old, &in_root(new)).sqrt()));
            list_pairs(hand, folds, &mut self.pairs);
            folds.wasted += self.pairs.len() - folds.fewest.min(self.pairs.len());
            if folds.wasted <= hand.self_pairs.len() {
                return;
            }
        }
        folds.axes.clear();
        folds.axes.extend(posed.capsules.iter().map(in_root));
        folds.gaps_m.clear();
        folds
            .gaps_m
            .extend(hand.self_pairs.iter().map(|&[first, second]| {
                let nearest = closest_points(&posed.capsules[first], &posed.capsules[second]);
                let radii = hand.capsules[first].radius_m + hand.capsules[second].radius_m;
                nearest.offset.norm() - radii
            }));
        folds.neighbours.clear();
        folds.neighbours.extend(
            (0u32..)
                .zip(&folds.gaps_m)
                .filter(|(_, gap_m)| **gap_m <= NEIGHBOURHOOD_M)
                .map(|(number, _)| number),
        );
        folds.moved_m.clear();
        folds.moved_m.resize(posed.capsules.len(), 0.0);
        list_pairs(hand, folds, &mut self.pairs);
        folds.fewest = self.pairs.len();
        folds.wasted = 0;
    }

    /// Ascending indices of the self-pairs that may overlap.
    pub fn pairs(&self) -> &[u32] {
        &self.pairs
    }
}

impl Intruders {
    fn renew(&mut self, axis: &[Vector3<f64>; 2], radius_m: f64, object: &Object) {
        let listed_squared = (radius_m + MARGIN_M).powi(2);
        let along = axis[1] - axis[0];
        let inverse = 1.0 / along.norm_squared().max(f64::MIN_POSITIVE);
        let mut nearest_squared = f64::INFINITY;
        self.samples.clear();
        for &index in &object.held_samples {
            let from = object.surface_samples[index as usize].point - axis[0];
            let share = (from.dot(&along) * inverse).clamp(0.0, 1.0);
            let squared = (from - along * share).norm_squared();
            nearest_squared = nearest_squared.min(squared);
            if squared < listed_squared {
                self.samples.push(index);
            }
        }
        self.axis = *axis;
        self.margin_m = MARGIN_M.max(nearest_squared.sqrt() - radius_m) - ROUNDING_M;
    }
}

fn list_pairs(hand: &Hand, folds: &Folds, pairs: &mut Vec<u32>) {
    pairs.clear();
    let may_overlap = |number: &u32| {
        let number = *number as usize;
        let [first, second] = hand.self_pairs[number];
        folds.gaps_m[number] <= folds.moved_m[first] + folds.moved_m[second] + ROUNDING_M
    };
    let farthest_m = folds.moved_m.iter().copied().fold(0.0, f64::max);
    if 2.0 * farthest_m + ROUNDING_M <= NEIGHBOURHOOD_M {
        pairs.extend(folds.neighbours.iter().copied().filter(may_overlap));
    } else {
        pairs.extend((0u32..).take(folds.gaps_m.len()).filter(may_overlap));
    }
}

/// Squared greatest movement of a point of a segment, which is at one of its ends.
fn farthest_squared(old: &[Vector3<f64>; 2], new: &[Vector3<f64>; 2]) -> f64 {
    (new[0] - old[0])
        .norm_squared()
        .max((new[1] - old[1]).norm_squared())
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::sample::{Task, stream};
    use crate::space::joints_of_mut;

    /// Holds for any movement of the fingers since the gaps were measured.
    #[test]
    fn every_pair_that_overlaps_is_listed() {
        let hand = Hand::human();
        let mut rng = stream(0, Task::Start, 0);
        let mut posed = PosedHand::default();
        let mut proximity = Proximity::default();
        let mut x = hand.rest_coordinates();
        let (mut seen, mut listed) = (0, 0);
        for n in 0..300 {
            let share = [0.001, 0.01, 0.05, 0.3][n % 4];
            for (q, joint) in joints_of_mut(&mut x).iter_mut().zip(&hand.joints) {
                let [low, high] = joint.limits_rad;
                *q += share * (rng.random_range(low..=high) - *q);
            }
            hand.pose_links(&x, &mut posed);
            proximity.update_pairs(&hand, &posed);
            listed += proximity.pairs().len();
            for (number, &[first, second]) in (0u32..).zip(&hand.self_pairs) {
                let nearest = closest_points(&posed.capsules[first], &posed.capsules[second]);
                let radii = hand.capsules[first].radius_m + hand.capsules[second].radius_m;
                if nearest.offset.norm() < radii {
                    seen += 1;
                    assert!(
                        proximity.pairs().contains(&number),
                        "pair {number} at step {n}"
                    );
                }
            }
        }
        assert!(
            seen > 100 && listed < 300 * hand.self_pairs.len() / 2,
            "{seen} {listed}"
        );
    }
}
