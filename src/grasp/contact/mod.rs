//! The best contact set of a posed hand: the exact minimum over all sets of n candidates.
//!
//! The contact part of the energy is Σ aᵢ + w·h(‖Σ wᵢ‖) with non-negative own costs aᵢ, candidate wrenches wᵢ and an
//! increasing h. Candidates are tried in order of own cost. A branch is cut if its own costs (each further member costs at
//! least as much as the last) exceed the best known total, or if unit forces can no longer cancel the remaining wrench.
//! Nothing else is cut, so the result is the minimum; of equal sets the lexicographically first wins.

mod lanes;

use lanes::{BLOCK, Directions, LANES, Lanes};

use super::term::NormForm;

/// Energy of a net wrench: `weight · (√(‖Gc‖² + rounding²) − rounding)` or `weight · ‖Gc‖²`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrenchCost {
    /// Energy per unit of ‖Gc‖ far from zero.
    pub weight: f64,
    /// Shape of the norm.
    pub form: NormForm,
    /// Radius of the rounding of the norm near zero (0 for the plain norm).
    pub rounding: f64,
}

impl WrenchCost {
    /// Energy of a net wrench whose squared norm is given.
    pub fn of_squared(&self, norm_squared: f64) -> f64 {
        self.weight
            * match self.form {
                NormForm::Norm => {
                    (norm_squared + self.rounding * self.rounding).sqrt() - self.rounding
                }
                NormForm::Square => norm_squared,
            }
    }

    /// The inverse of this cost.
    fn reach(&self) -> Reach {
        let (linear, quadratic) = match self.form {
            NormForm::Norm => (2.0 * self.rounding, 1.0),
            NormForm::Square => (1.0, 0.0),
        };
        Reach {
            per_energy: self.weight.max(f64::MIN_POSITIVE).recip(),
            linear,
            quadratic,
        }
    }
}

/// The inverse of a [`WrenchCost`]: the squared norm for a given energy, without a root and in one form.
#[derive(Debug, Clone, Copy, Default)]
struct Reach {
    per_energy: f64,
    linear: f64,
    quadratic: f64,
}

impl Reach {
    /// Largest norm squared that costs at most `energy`.
    fn squared(&self, energy: f64) -> f64 {
        // If wrenches cost nothing, the clamp keeps the unlimited reach finite.
        let e = (energy * self.per_energy).clamp(0.0, 1e100);
        e * (self.linear + self.quadratic * e)
    }
}

/// A surface point that may become a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Index into the hand's surface points.
    pub index: u32,
    /// Its own cost aᵢ ≥ 0.
    pub cost: f64,
    /// Unit force and torque (with scaled arms) of its contact.
    pub wrench: [f64; 6],
}

/// Tolerance for sums taken in another order, far below any energy of interest.
const SLACK: f64 = 1e-12;

/// Searches for the best set among `candidates`. Buffers are kept between calls.
#[derive(Debug, Clone, Default)]
pub struct ContactSearch {
    candidates: Vec<Candidate>,
    /// The same in groups for vector instructions.
    lanes: Vec<Lanes>,
    /// The same in input order, and the sort keys.
    unsorted: Vec<Candidate>,
    order: Vec<(i64, u32, usize)>,
    /// Members of the current branch or descent.
    chosen: Vec<usize>,
    best: Vec<u32>,
    best_total: f64,
    /// Greatest cost of interest, even if it is below the best known.
    limit: f64,
    reach: Reach,
    directions: Directions,
}

impl ContactSearch {
    /// Starts a new search among `candidates`.
    pub fn begin(&mut self, candidates: impl IntoIterator<Item = Candidate>) {
        self.unsorted.clear();
        self.unsorted.extend(candidates);
        self.order.clear();
        let keys = self.unsorted.iter().enumerate();
        self.order
            .extend(keys.map(|(place, c)| (rank(c.cost), c.index, place)));
        self.order.sort_unstable();
        self.candidates.clear();
        let places = self.order.iter().map(|(_, _, place)| *place);
        self.candidates
            .extend(places.map(|place| self.unsorted[place]));
        self.lanes.clear();
        self.lanes
            .extend(self.candidates.chunks(LANES).map(Lanes::of));
        self.best.clear();
        self.best_total = f64::INFINITY;
    }

    /// Number of candidates.
    pub fn len(&self) -> usize {
        self.candidates.len()
    }

    /// Whether there are no candidates.
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty()
    }

    /// Total of a set of positions, summed in index order, so that it does not depend on how the set was found.
    fn total(&self, positions: &mut [usize], cost: &WrenchCost) -> f64 {
        positions.sort_unstable_by_key(|&p| self.candidates[p].index);
        let mut own = 0.0;
        let mut wrench = [0.0; 6];
        for &p in positions.iter() {
            own += self.candidates[p].cost;
            add(&mut wrench, &self.candidates[p].wrench);
        }
        own + cost.of_squared(norm_squared(&wrench))
    }

    /// Offers a set as the best one and returns its total.
    fn offer(&mut self, positions: &mut [usize], cost: &WrenchCost) -> f64 {
        let total = self.total(positions, cost);
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

    /// A good set that depends only on the candidates: the best of coordinate descents from the cheapest candidates and
    /// from opposed pairs along the axes. It stops at the first set that costs at most `enough`. Otherwise like
    /// [`ContactSearch::descend`].
    pub fn descend_cold(&mut self, size: usize, cost: &WrenchCost, enough: f64) -> f64 {
        self.descend(size, &[], cost);
        for axes in [[0, 1], [0, 2], [1, 2]] {
            if self.best_total <= enough {
                break;
            }
            let mut start = [0; 4];
            let mut ends = 0;
            for axis in axes {
                let along = |a: &&Candidate, b: &&Candidate| {
                    a.wrench[axis]
                        .total_cmp(&b.wrench[axis])
                        .then(a.index.cmp(&b.index))
                };
                let (low, high) = (
                    self.candidates.iter().min_by(along),
                    self.candidates.iter().max_by(along),
                );
                for end in [low, high].into_iter().flatten() {
                    start[ends] = end.index;
                    ends += 1;
                }
            }
            self.descend(size, &start[..ends], cost);
        }
        self.best_total
    }

    /// A good set by coordinate descent from `start` (surface-point indices; missing ones are replaced by the cheapest
    /// candidates). It is never worse than `start` if all of it is among the candidates, nor than earlier descents of this
    /// search.
    ///
    /// Returns its total, or infinity for fewer than `size` candidates; the set itself is [`ContactSearch::best`].
    pub fn descend(&mut self, size: usize, start: &[u32], cost: &WrenchCost) -> f64 {
        if self.candidates.len() < size || size == 0 {
            return self.best_total;
        }
        let mut set: Vec<usize> = std::mem::take(&mut self.chosen);
        set.clear();
        for index in start.iter().take(size) {
            if let Some(position) = self.candidates.iter().position(|c| c.index == *index)
                && !set.contains(&position)
            {
                set.push(position);
            }
        }
        let mut next = 0;
        while set.len() < size {
            if !set.contains(&next) {
                set.push(next);
            }
            next += 1;
        }
        let mut here = self.offer(&mut set.clone(), cost);
        loop {
            for slot in 0..size {
                set[slot] = self.best_in_slot(&set, slot, cost);
            }
            let next = self.offer(&mut set.clone(), cost);
            if next >= here - SLACK {
                break;
            }
            here = next;
        }
        self.chosen = set;
        self.best_total
    }

    /// The best candidate for `slot` with the other members of `set`.
    fn best_in_slot(&self, set: &[usize], slot: usize, cost: &WrenchCost) -> usize {
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
            let totals = lanes.totals(own, &others, cost);
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

    /// Proves or improves the set of [`ContactSearch::descend`] until it is the exact minimum over all sets of `size`
    /// candidates, and returns its total. If that exceeds `limit`, any bound above `limit` may be returned.
    pub fn prove(&mut self, size: usize, cost: &WrenchCost, limit: f64) -> f64 {
        if self.candidates.len() < size || size == 0 {
            return self.best_total;
        }
        self.limit = limit;
        self.reach = cost.reach();
        // Later positions cannot occur, because the other members cost at least as much as the cheapest ones.
        let floor = self.floor(size - 1);
        let usable = self
            .candidates
            .partition_point(|c| c.cost + floor <= self.worst());
        self.directions.list(&self.candidates[..usable]);
        let mut chosen = std::mem::take(&mut self.chosen);
        chosen.clear();
        self.extend(&mut chosen, size, usable, 0.0, &[0.0; 6], cost);
        self.chosen = chosen;
        if self.best_total > limit {
            return limit.next_up();
        }
        self.best_total
    }

    fn worst(&self) -> f64 {
        self.best_total.min(self.limit) + SLACK
    }

    /// Tries every further member after the last one of the branch `chosen`.
    fn extend(
        &mut self,
        chosen: &mut Vec<usize>,
        size: usize,
        usable: usize,
        own: f64,
        wrench: &[f64; 6],
        cost: &WrenchCost,
    ) {
        let missing = size - chosen.len();
        let from = chosen.last().map_or(0, |last| last + 1);
        if from + missing > usable {
            return;
        }
        if missing == 1 {
            self.close(chosen, from, own, wrench, cost);
            return;
        }
        if missing == 2 {
            self.extend_by_two(chosen, usable, own, wrench, cost);
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
            self.extend(chosen, size, usable, own, &sum, cost);
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
        cost: &WrenchCost,
    ) {
        let from = chosen.last().map_or(0, |last| last + 1);
        for block in from / LANES..usable.div_ceil(LANES) {
            let first = LANES * block;
            let cheapest = &self.candidates[from.max(first)];
            if own + 2.0 * cheapest.cost > self.worst() {
                return;
            }
            let spare = self.lanes[block].spare(wrench, self.worst() - own, &self.reach);
            // The last candidate has no successor.
            for p in from.max(first)..(usable - 1).min(first + LANES) {
                if spare[p - first] >= 0.0 {
                    let candidate = &self.candidates[p];
                    let own = own + candidate.cost;
                    let mut sum = *wrench;
                    add(&mut sum, &candidate.wrench);
                    chosen.push(p);
                    self.close(chosen, p + 1, own, &sum, cost);
                    chosen.pop();
                }
            }
        }
    }

    /// Tries every last member whose force comes close enough to cancelling `wrench`.
    fn close(
        &mut self,
        chosen: &[usize],
        from: usize,
        own: f64,
        wrench: &[f64; 6],
        cost: &WrenchCost,
    ) {
        let left = self.worst() - own;
        let reach = self.reach.squared(left - self.candidates[from].cost).sqrt();
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
                if squared > self.reach.squared(left) {
                    continue;
                }
                let total = own + candidate.cost + cost.of_squared(squared);
                if total <= self.worst() {
                    let mut set: Vec<usize> = chosen.to_vec();
                    set.push(p);
                    self.offer(&mut set, cost);
                }
            }
        }
    }

    /// The least own cost of any `count` candidates; infinite with fewer.
    pub fn floor(&self, count: usize) -> f64 {
        if self.candidates.len() < count {
            return f64::INFINITY;
        }
        self.candidates[..count].iter().map(|c| c.cost).sum()
    }

    /// The least own cost of any `count` points, if points that are not candidates cost at least `outside` each.
    pub fn floor_with(&self, count: usize, outside: f64) -> f64 {
        let known = self.candidates.iter().map(|c| c.cost.min(outside));
        known.chain(std::iter::repeat(outside)).take(count).sum()
    }

    /// The best set found, as sorted surface-point indices.
    pub fn best(&self) -> &[u32] {
        &self.best
    }
}

/// Integer key that orders costs like `total_cmp`.
fn rank(cost: f64) -> i64 {
    let bits = cost.to_bits().cast_signed();
    bits ^ ((bits >> 63).cast_unsigned() >> 1).cast_signed()
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

    fn brute_force(candidates: &[Candidate], size: usize, cost: &WrenchCost) -> (f64, Vec<u32>) {
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
            let total = own + cost.of_squared(norm_squared(&wrench));
            if total < best.0 {
                best = (total, set.iter().map(|&p| candidates[p].index).collect());
            }
        }
        best
    }

    #[test]
    fn exact_minimum_for_every_size_and_rounding() {
        for seed in 0..20 {
            let (norm, square) = (NormForm::Norm, NormForm::Square);
            for (size, form, rounding) in [
                (2, norm, 0.05),
                (3, norm, 0.0),
                (3, norm, 0.05),
                (4, norm, 0.05),
                (5, norm, 0.05),
                (3, square, 0.0),
                (5, square, 0.0),
            ] {
                let candidates = random_candidates(18, seed);
                let cost = WrenchCost {
                    weight: 1.0,
                    form,
                    rounding,
                };
                let (total, set) = brute_force(&candidates, size, &cost);
                let mut search = ContactSearch::default();
                search.begin(candidates.iter().rev().copied());
                let descended = search.descend(size, &[3, 5], &cost);
                let proven = search.prove(size, &cost, f64::INFINITY);
                assert!(descended >= proven);
                assert!((proven - total).abs() < 1e-12, "{proven} against {total}");
                assert_eq!(search.best(), set);
                for limit in [0.5 * total, total - 1e-9, total + 1e-9, 2.0 * total] {
                    search.begin(candidates.iter().copied());
                    search.descend(size, &[0, 1], &cost);
                    let proven = search.prove(size, &cost, limit);
                    if total > limit {
                        assert!(proven > limit);
                    } else {
                        assert!((proven - total).abs() < 1e-12);
                        assert_eq!(search.best(), set);
                    }
                }
            }
        }
    }

    #[test]
    fn too_few_candidates() {
        let cost = WrenchCost {
            weight: 1.0,
            form: NormForm::Norm,
            rounding: 0.0,
        };
        let mut search = ContactSearch::default();
        search.begin(random_candidates(2, 0));
        assert!(search.descend(3, &[], &cost).is_infinite());
        assert!(search.prove(3, &cost, f64::INFINITY).is_infinite());
    }
}
