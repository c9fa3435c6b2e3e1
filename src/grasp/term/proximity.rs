//! Lists of the parts of a hand that may overlap, valid while the hand moves a little.
//!
//! Two parts cannot touch if their distance was greater than both have moved since. Nothing else is left out, so terms that
//! use these lists give bitwise the same result as over all parts, only faster.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::hand::{Hand, PosedHand, closest_points};

/// Self-pairs with a greater gap are tested only after some part has moved half as far.
const NEIGHBOURHOOD_M: f64 = 0.01;

/// Rounding error of distances below a metre.
const ROUNDING_M: f64 = 1e-12;

/// Parts that may overlap at the last pose, for one hand.
#[derive(Debug, Clone, Default)]
pub struct Proximity {
    folds: Folds,
    pairs: Vec<u32>,
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
    /// Greatest movement of a capsule of each link.
    moved_links_m: Vec<f64>,
    /// The self-pairs by pairs of links, for a hand with many.
    blocks: Vec<Block>,
    /// Numbers of pairs listed at first and in vain since. Gaps are measured again when these are many.
    fewest: usize,
    wasted: usize,
}

/// Self-pairs of two links.
#[derive(Debug, Clone)]
struct Block {
    links: [usize; 2],
    /// Ascending indices of the pairs.
    pairs: Vec<u32>,
    /// The least gap, metres.
    gap_m: f64,
}

/// Hands with more self-pairs than this are searched by pairs of links.
const MANY_PAIRS: usize = 500;

/// Pairs of links whose balls are farther apart than this get that distance as the gap of all their capsules, metres.
const FAR_M: f64 = 2.0 * NEIGHBOURHOOD_M;

/// The pairs of `hand` by pairs of links; none if there are few.
fn blocks(hand: &Hand) -> Vec<Block> {
    let mut blocks: BTreeMap<[usize; 2], Vec<u32>> = BTreeMap::new();
    if hand.self_pairs.len() > MANY_PAIRS {
        for (number, pair) in (0u32..).zip(&hand.self_pairs) {
            let links = pair.map(|capsule| hand.capsules[capsule].link.0);
            blocks.entry(links).or_default().push(number);
        }
    }
    let blocks = blocks.into_iter().map(|(links, pairs)| Block {
        links,
        pairs,
        gap_m: f64::NEG_INFINITY,
    });
    blocks.collect()
}

/// A ball around the capsules of each link: centre and radius, metres.
fn link_balls(hand: &Hand, posed: &PosedHand) -> Vec<(Vector3<f64>, f64)> {
    let mut balls = vec![(Vector3::zeros(), 0.0); hand.links.len()];
    let mut first = 0;
    while let Some(capsule) = hand.capsules.get(first) {
        let link = capsule.link;
        let end = hand
            .capsules
            .partition_point(|capsule| capsule.link <= link);
        let axes = &posed.capsules[first..end];
        let centre = axes
            .iter()
            .map(|[a, b]| (a + b) * 0.5)
            .sum::<Vector3<f64>>()
            / (end - first) as f64;
        let radii = axes.iter().zip(&hand.capsules[first..end]);
        let radii = radii.map(|([a, b], capsule)| {
            (a - centre).norm().max((b - centre).norm()) + capsule.radius_m
        });
        balls[link.0] = (centre, radii.fold(0.0, f64::max));
        first = end;
    }
    balls
}

impl Proximity {
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
            folds.spread_movement(hand);
            list_pairs(hand, folds, &mut self.pairs);
            folds.wasted += self.pairs.len() - folds.fewest.min(self.pairs.len());
            if folds.wasted <= hand.self_pairs.len() {
                return;
            }
        }
        folds.axes.clear();
        folds.axes.extend(posed.capsules.iter().map(in_root));
        measure_gaps(hand, posed, folds);
        folds.neighbours.clear();
        folds.neighbours.extend(
            (0u32..)
                .zip(&folds.gaps_m)
                .filter(|(_, gap_m)| **gap_m <= NEIGHBOURHOOD_M)
                .map(|(number, _)| number),
        );
        folds.moved_m.clear();
        folds.moved_m.resize(posed.capsules.len(), 0.0);
        folds.spread_movement(hand);
        list_pairs(hand, folds, &mut self.pairs);
        folds.fewest = self.pairs.len();
        folds.wasted = 0;
    }

    /// Ascending indices of the self-pairs that may overlap.
    pub fn pairs(&self) -> &[u32] {
        &self.pairs
    }
}

impl Folds {
    /// Finds the greatest movement of a capsule of each link.
    fn spread_movement(&mut self, hand: &Hand) {
        if self.blocks.is_empty() {
            return;
        }
        self.moved_links_m.clear();
        self.moved_links_m.resize(hand.links.len(), 0.0);
        for (capsule, moved_m) in hand.capsules.iter().zip(&self.moved_m) {
            let most = &mut self.moved_links_m[capsule.link.0];
            *most = most.max(*moved_m);
        }
    }
}

/// Measures the gaps of all pairs. Those of links that are far apart get a lower bound.
fn measure_gaps(hand: &Hand, posed: &PosedHand, folds: &mut Folds) {
    let gap_m = |&[first, second]: &[usize; 2]| {
        let nearest = closest_points(&posed.capsules[first], &posed.capsules[second]);
        let radii = hand.capsules[first].radius_m + hand.capsules[second].radius_m;
        nearest.offset.norm() - radii
    };
    if folds.gaps_m.len() != hand.self_pairs.len() {
        folds.blocks = blocks(hand);
    }
    if folds.blocks.is_empty() {
        folds.gaps_m.clear();
        folds.gaps_m.extend(hand.self_pairs.iter().map(gap_m));
        return;
    }
    folds.gaps_m.resize(hand.self_pairs.len(), 0.0);
    let balls = link_balls(hand, posed);
    for block in &mut folds.blocks {
        let [(first, first_m), (second, second_m)] = block.links.map(|link| balls[link]);
        let apart_m = (second - first).norm() - first_m - second_m - ROUNDING_M;
        block.gap_m = f64::INFINITY;
        for &number in &block.pairs {
            let found_m = if apart_m > FAR_M {
                apart_m
            } else {
                gap_m(&hand.self_pairs[number as usize])
            };
            folds.gaps_m[number as usize] = found_m;
            block.gap_m = block.gap_m.min(found_m);
        }
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
    } else if folds.blocks.is_empty() {
        pairs.extend((0u32..).take(folds.gaps_m.len()).filter(may_overlap));
    } else {
        for block in &folds.blocks {
            let [first, second] = block.links.map(|link| folds.moved_links_m[link]);
            if block.gap_m <= first + second + ROUNDING_M {
                pairs.extend(block.pairs.iter().copied().filter(may_overlap));
            }
        }
        pairs.sort_unstable();
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
        lists_overlaps(&Hand::human());
    }

    /// The same for a hand with so many pairs that they are searched by pairs of links.
    #[test]
    fn every_pair_of_many_that_overlaps_is_listed() {
        let mut hand = Hand::named("gripper_three_finger").unwrap();
        // Its fingers are far apart; thicker ones overlap.
        for capsule in &mut hand.capsules {
            capsule.radius_m += 0.02;
        }
        assert!(!blocks(&hand).is_empty() && blocks(&Hand::human()).is_empty());
        lists_overlaps(&hand);
    }

    fn lists_overlaps(hand: &Hand) {
        let mut rng = stream(0, Task::Start, 0);
        let mut posed = PosedHand::default();
        let mut proximity = Proximity::default();
        let mut x = hand.rest_coordinates();
        let (mut seen, mut listed) = (0, 0);
        for n in 0..300 {
            let share = [0.001, 0.01, 0.05, 0.3][n % 4];
            for (q, joint) in joints_of_mut(&mut x).iter_mut().zip(&hand.joints) {
                let [low, high] = joint.limits;
                *q += share * (rng.random_range(low..=high) - *q);
            }
            hand.pose_links(&x, &mut posed);
            proximity.update_pairs(hand, &posed);
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
