//! The contact set of a posed hand, which filters judge and files name: the exact minimum over all sets of four candidates.
//!
//! It is no part of the energy. It minimises Σ aᵢ + h(‖Σ wᵢ‖) with non-negative own costs aᵢ (distances from the surface),
//! candidate wrenches wᵢ and a rounded norm h. Candidates are tried in order of own cost. A branch is cut if its own costs
//! (each further member costs at least as much as the last) exceed the best known total, or if unit forces can no longer
//! cancel the remaining wrench. Nothing else is cut, so the result is the minimum; of equal sets the lexicographically first
//! wins.

mod lanes;

use lanes::{BLOCK, Directions, LANES, Lanes};

use super::closure::PointContact;
use super::filter::MOST_GAP_M;
use crate::hand::{Hand, PosedHand};
use crate::object::Object;

/// Number of contacts of a set. Three equal unit forces balance only at 120°, so pinches need four.
pub const CONTACTS: usize = 4;
/// Cost of a distance of the object's radius, and the rounding of distances, metres.
const DISTANCE_WEIGHT: f64 = 40.0;
const DISTANCE_ROUNDING_M: f64 = 0.002;
/// Rounding of the norm of the net wrench.
const ROUNDING: f64 = 0.05;

/// The best contact set of a posed hand, as ascending indices of surface points. Only points within 2 mm of the object count,
/// or all points if these are too few. Without this limit a hand whose fingertips have few points would get contacts where it
/// does not touch, since these balance better.
///
/// # Panics
/// If `posed` belongs to another hand.
pub fn best_contacts(hand: &Hand, object: &Object, posed: &PosedHand) -> Vec<u32> {
    let mut all = Vec::new();
    let mut touching = Vec::new();
    for (index, at) in (0u32..).zip(&hand.surface) {
        if !hand.may_touch(at) {
            continue;
        }
        let point = hand.surface_point(posed, index as usize);
        let (distance_m, gradient) = object.shape.gradient(&point);
        let length = gradient.norm();
        if length > 0.0 {
            let contact = PointContact {
                arm: (point - object.centroid) / object.radius_m,
                inward_normal: -gradient / length,
            };
            let candidate = Candidate {
                index,
                cost: distance_cost(distance_m, object.radius_m),
                wrench: contact.wrench().into(),
            };
            all.push(candidate);
            if distance_m.abs() <= MOST_GAP_M {
                touching.push(candidate);
            }
        }
    }
    let candidates = if touching.len() < CONTACTS {
        all
    } else {
        touching
    };
    let mut search = ContactSearch::new(candidates);
    search.descend(CONTACTS);
    search.prove(CONTACTS);
    search.best
}

fn distance_cost(distance_m: f64, unit_m: f64) -> f64 {
    let (s, rounding) = (distance_m / unit_m, DISTANCE_ROUNDING_M / unit_m);
    DISTANCE_WEIGHT * ((s * s + rounding * rounding).sqrt() - rounding)
}

/// Cost of a net wrench whose squared norm is given: √(‖Gc‖² + r²) − r.
fn wrench_cost(norm_squared: f64) -> f64 {
    (norm_squared + ROUNDING * ROUNDING).sqrt() - ROUNDING
}

/// The inverse of [`wrench_cost`]: the largest norm squared that costs at most `energy`.
fn reach_squared(energy: f64) -> f64 {
    let e = energy.clamp(0.0, 1e100);
    e * (2.0 * ROUNDING + e)
}

/// A surface point that may become a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Candidate {
    /// Index into the hand's surface points.
    index: u32,
    /// Its own cost aᵢ ≥ 0.
    cost: f64,
    /// Unit force and torque (with scaled arms) of its contact.
    wrench: [f64; 6],
}

/// Tolerance for sums taken in another order, far below any energy of interest.
const SLACK: f64 = 1e-12;

/// Searches for the best set among candidates.
struct ContactSearch {
    /// In the order of their own costs.
    candidates: Vec<Candidate>,
    /// The same in groups for vector instructions.
    lanes: Vec<Lanes>,
    /// The best set found, as ascending indices of surface points; empty if there is none.
    best: Vec<u32>,
    best_total: f64,
    directions: Directions,
}

impl ContactSearch {
    fn new(mut candidates: Vec<Candidate>) -> Self {
        candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.index.cmp(&b.index)));
        Self {
            lanes: candidates.chunks(LANES).map(Lanes::of).collect(),
            candidates,
            best: Vec::new(),
            best_total: f64::INFINITY,
            directions: Directions::default(),
        }
    }

    /// Total of a set of positions, summed in index order, so that it does not depend on how the set was found.
    fn total(&self, positions: &mut [usize]) -> f64 {
        positions.sort_unstable_by_key(|&p| self.candidates[p].index);
        let mut own = 0.0;
        let mut wrench = [0.0; 6];
        for &p in positions.iter() {
            own += self.candidates[p].cost;
            add(&mut wrench, &self.candidates[p].wrench);
        }
        own + wrench_cost(norm_squared(&wrench))
    }

    /// Offers a set as the best one and returns its total.
    fn offer(&mut self, positions: &mut [usize]) -> f64 {
        let total = self.total(positions);
        if total > self.best_total {
            return total;
        }
        let set = positions.iter().map(|&p| self.candidates[p].index);
        if total < self.best_total || set.clone().lt(self.best.iter().copied()) {
            self.best_total = total;
            self.best.clear();
            self.best.extend(set);
        }
        total
    }

    /// Finds a good set of `size` members by coordinate descent from the cheapest candidates.
    fn descend(&mut self, size: usize) {
        if self.candidates.len() < size {
            return;
        }
        let mut set: Vec<usize> = (0..size).collect();
        let mut here = self.offer(&mut set.clone());
        loop {
            for slot in 0..size {
                set[slot] = self.best_in_slot(&set, slot);
            }
            let next = self.offer(&mut set.clone());
            if next >= here - SLACK {
                break;
            }
            here = next;
        }
    }

    /// The best candidate for `slot` with the other members of `set`.
    fn best_in_slot(&self, set: &[usize], slot: usize) -> usize {
        let mut others = [0.0; 6];
        let mut own = 0.0;
        for (k, &p) in set.iter().enumerate() {
            if k != slot {
                add(&mut others, &self.candidates[p].wrench);
                own += self.candidates[p].cost;
            }
        }
        let mut least = f64::INFINITY;
        let mut choice = set[slot];
        for (block, lanes) in self.lanes.iter().enumerate() {
            let totals = lanes.totals(own, &others);
            for (lane, total) in totals.into_iter().enumerate() {
                if own + lanes.cost[lane] >= least {
                    return choice;
                }
                let p = LANES * block + lane;
                if total < least && !set.iter().enumerate().any(|(k, &q)| k != slot && q == p) {
                    least = total;
                    choice = p;
                }
            }
        }
        choice
    }

    /// Improves the set of [`ContactSearch::descend`] until it is the minimum over all sets of `size` candidates.
    fn prove(&mut self, size: usize) {
        if self.candidates.len() < size {
            return;
        }
        // Later positions cannot occur, because the other members cost at least as much as the cheapest ones.
        let floor: f64 = self.candidates[..size - 1].iter().map(|c| c.cost).sum();
        let usable = self
            .candidates
            .partition_point(|c| c.cost + floor <= self.worst());
        self.directions.list(&self.candidates[..usable]);
        self.extend(&mut Vec::new(), size, usable, 0.0, &[0.0; 6]);
    }

    fn worst(&self) -> f64 {
        self.best_total + SLACK
    }

    /// Tries every further member after the last one of the branch `chosen`.
    fn extend(
        &mut self,
        chosen: &mut Vec<usize>,
        size: usize,
        usable: usize,
        own: f64,
        wrench: &[f64; 6],
    ) {
        let missing = size - chosen.len();
        let from = chosen.last().map_or(0, |last| last + 1);
        if from + missing > usable {
            return;
        }
        if missing == 1 {
            self.close(chosen, from, own, wrench);
            return;
        }
        if missing == 2 {
            self.extend_by_two(chosen, usable, own, wrench);
            return;
        }
        for p in from..usable {
            let candidate = &self.candidates[p];
            if own + missing as f64 * candidate.cost > self.worst() {
                break;
            }
            let mut sum = *wrench;
            add(&mut sum, &candidate.wrench);
            let own = own + candidate.cost;
            chosen.push(p);
            self.extend(chosen, size, usable, own, &sum);
            chosen.pop();
        }
    }

    /// [`ContactSearch::extend`] for the last but one member, after which the net force must be close to a unit force.
    fn extend_by_two(
        &mut self,
        chosen: &mut Vec<usize>,
        usable: usize,
        own: f64,
        wrench: &[f64; 6],
    ) {
        let from = chosen.last().map_or(0, |last| last + 1);
        for block in from / LANES..usable.div_ceil(LANES) {
            let first = LANES * block;
            let cheapest = &self.candidates[from.max(first)];
            if own + 2.0 * cheapest.cost > self.worst() {
                return;
            }
            let spare = self.lanes[block].spare(wrench, self.worst() - own);
            // The last candidate has no successor.
            for p in from.max(first)..(usable - 1).min(first + LANES) {
                if spare[p - first] >= 0.0 {
                    let candidate = &self.candidates[p];
                    let own = own + candidate.cost;
                    let mut sum = *wrench;
                    add(&mut sum, &candidate.wrench);
                    chosen.push(p);
                    self.close(chosen, p + 1, own, &sum);
                    chosen.pop();
                }
            }
        }
    }

    /// Tries every last member whose force comes close enough to cancelling `wrench`.
    fn close(&mut self, chosen: &[usize], from: usize, own: f64, wrench: &[f64; 6]) {
        let left = self.worst() - own;
        let reach = reach_squared(left - self.candidates[from].cost).sqrt();
        for block in from / BLOCK..self.directions.blocks.len() {
            let mut opposed = self.directions.blocks[block].opposed(wrench, reach);
            if block == from / BLOCK {
                opposed &= u64::MAX << (from % BLOCK);
            }
            while opposed != 0 {
                let p = BLOCK * block + opposed.trailing_zeros() as usize;
                opposed &= opposed - 1;
                let candidate = &self.candidates[p];
                let left = self.worst() - own - candidate.cost;
                if left < 0.0 {
                    return;
                }
                let squared = sum_norm_squared(wrench, &candidate.wrench);
                if squared > reach_squared(left) {
                    continue;
                }
                let total = own + candidate.cost + wrench_cost(squared);
                if total <= self.worst() {
                    let mut set: Vec<usize> = chosen.to_vec();
                    set.push(p);
                    self.offer(&mut set);
                }
            }
        }
    }
}

fn add(sum: &mut [f64; 6], wrench: &[f64; 6]) {
    for (s, w) in sum.iter_mut().zip(wrench) {
        *s += w;
    }
}

fn norm_squared(wrench: &[f64; 6]) -> f64 {
    wrench.iter().map(|w| w * w).sum()
}

fn sum_norm_squared(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a + b) * (a + b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Task, stream};
    use rand::RngExt;

    fn random_candidates(count: u32, seed: u64) -> Vec<Candidate> {
        let mut rng = stream(seed, Task::Start, 0);
        (0..count)
            .map(|index| {
                let mut direction: Vec<f64> = (0..3).map(|_| rng.random_range(-1.0..1.0)).collect();
                let norm = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
                for d in &mut direction {
                    *d /= norm;
                }
                let torque: Vec<f64> = (0..3).map(|_| rng.random_range(-0.5..0.5)).collect();
                Candidate {
                    index,
                    cost: rng.random_range(0.0..0.3),
                    wrench: [
                        direction[0],
                        direction[1],
                        direction[2],
                        torque[0],
                        torque[1],
                        torque[2],
                    ],
                }
            })
            .collect()
    }

    fn brute_force(candidates: &[Candidate], size: usize) -> (f64, Vec<u32>) {
        let mut best = (f64::INFINITY, Vec::new());
        let mut sets: Vec<Vec<usize>> = vec![vec![]];
        for _ in 0..size {
            sets = sets
                .into_iter()
                .flat_map(|s| {
                    let from = s.last().map_or(0, |l| l + 1);
                    (from..candidates.len()).map(move |p| {
                        let mut t = s.clone();
                        t.push(p);
                        t
                    })
                })
                .collect();
        }
        for set in sets {
            let mut wrench = [0.0; 6];
            let mut own = 0.0;
            for &p in &set {
                add(&mut wrench, &candidates[p].wrench);
                own += candidates[p].cost;
            }
            let total = own + wrench_cost(norm_squared(&wrench));
            if total < best.0 {
                best = (total, set.iter().map(|&p| candidates[p].index).collect());
            }
        }
        best
    }

    #[test]
    fn the_set_found_is_the_exact_minimum() {
        for seed in 0..20 {
            for size in [2, 3, 4, 5] {
                let candidates = random_candidates(18, seed);
                let (total, set) = brute_force(&candidates, size);
                let mut search = ContactSearch::new(candidates.into_iter().rev().collect());
                search.descend(size);
                let descended = search.best_total;
                search.prove(size);
                let proven = search.best_total;
                assert!(descended >= proven);
                assert!((proven - total).abs() < 1e-12, "{proven} against {total}");
                assert_eq!(search.best, set);
            }
        }
    }

    #[test]
    fn too_few_candidates_give_no_set() {
        let mut search = ContactSearch::new(random_candidates(2, 0));
        search.descend(3);
        search.prove(3);
        assert!(search.best.is_empty());
    }
}
