//! Which parts of hand and object may overlap at all: lists that stay right while the hand moves a little.
//!
//! A part that was farther from another than both have moved since cannot touch it. Nothing else is left out, so terms
//! that walk these lists give the same bits as if they walked everything; only the price differs.

use nalgebra::Vector3;

use crate::grasp::hand::{Hand, PosedHand, closest_points};
use crate::grasp::object::Object;

/// Object samples nearer to a capsule than this are listed: the list holds until the capsule has moved as far.
const MARGIN_M: f64 = 0.008;

/// Distances are sums of a few roundings of lengths below a metre.
const ROUNDING_M: f64 = 1e-12;

/// What may overlap at the pose of the last update, for one hand and one object.
#[derive(Debug, Clone, Default)]
pub struct Proximity {
    intruders: Vec<Intruders>,
    folds: Folds,
    /// Self-pairs that may overlap.
    pairs: Vec<u32>,
}

/// The object's samples near one capsule.
#[derive(Debug, Clone, Default)]
struct Intruders {
    /// Where the capsule's axis was when the list was made.
    axis: [Vector3<f64>; 2],
    /// How far the ends of the axis may move before it must be made again.
    margin_m: f64,
    samples: Vec<u32>,
}

/// Gaps between the parts of the hand, at the joint angles at which they were measured.
#[derive(Debug, Clone, Default)]
struct Folds {
    /// Axes of all capsules, root frame.
    axes: Vec<[Vector3<f64>; 2]>,
    /// Gap of each self-pair.
    gaps_m: Vec<f64>,
    /// How far each capsule has moved in the root frame since.
    moved_m: Vec<f64>,
    /// Pairs listed at once and pairs listed in vain since: new gaps pay when these are many.
    fewest: usize,
    wasted: usize,
}

impl Proximity {
    /// Brings the lists of object samples up to date.
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

    /// Numbers of the object's samples that may lie inside `capsule`, rising.
    pub fn intruders(&self, capsule: usize) -> &[u32] {
        &self.intruders[capsule].samples
    }

    /// Brings the list of self-pairs up to date.
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
        folds.moved_m.clear();
        folds.moved_m.resize(posed.capsules.len(), 0.0);
        list_pairs(hand, folds, &mut self.pairs);
        folds.fewest = self.pairs.len();
        folds.wasted = 0;
    }

    /// Numbers of the self-pairs that may overlap, rising.
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
    let gaps = (0u32..).zip(&hand.self_pairs).zip(&folds.gaps_m);
    for ((number, &[first, second]), gap_m) in gaps {
        if *gap_m <= folds.moved_m[first] + folds.moved_m[second] + ROUNDING_M {
            pairs.push(number);
        }
    }
}

/// Square of the farthest that a point of a segment has moved: that of one of its ends.
fn farthest_squared(old: &[Vector3<f64>; 2], new: &[Vector3<f64>; 2]) -> f64 {
    (new[0] - old[0])
        .norm_squared()
        .max((new[1] - old[1]).norm_squared())
}
