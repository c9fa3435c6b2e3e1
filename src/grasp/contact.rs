//! Which contact set is best for a posed hand: the exact minimum over all sets of n candidates.
//!
//! The contact part of the energy is Σ aᵢ + w·h(‖Σ wᵢ‖) with non-negative own costs aᵢ, candidate wrenches wᵢ and an
//! increasing h. Candidates are tried in order of own cost; a branch is cut when its own costs (each further member
//! costs at least as much as the last one) exceed the best known total, or when unit forces can no longer cancel what is
//! left over. Nothing else is cut, so the result is the minimum; ties go to the lexicographically first set.

/// How the left-over wrench is turned into an energy: `weight · (√(‖Gc‖² + rounding²) − rounding)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrenchCost {
    /// Energy per unit of ‖Gc‖ far from zero.
    pub weight: f64,
    /// Radius within which the norm is rounded off (0: the plain norm).
    pub rounding: f64,
}

impl WrenchCost {
    /// Energy of a left-over wrench of this norm squared.
    pub fn of_squared(&self, norm_squared: f64) -> f64 {
        self.weight * ((norm_squared + self.rounding * self.rounding).sqrt() - self.rounding)
    }

    /// Largest norm that costs at most `energy`.
    fn reach(&self, energy: f64) -> f64 {
        if energy <= 0.0 {
            return 0.0;
        }
        if self.weight == 0.0 {
            return f64::INFINITY;
        }
        let total = energy / self.weight + self.rounding;
        (total * total - self.rounding * self.rounding)
            .max(0.0)
            .sqrt()
    }
}

/// A surface point that may become a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Index into the hand's surface points.
    pub index: u32,
    /// Its own cost aᵢ ≥ 0.
    pub cost: f64,
    /// Unit force and torque (arms scaled) of its contact.
    pub wrench: [f64; 6],
}

/// Slack for sums taken in another order; far below any energy of interest.
const SLACK: f64 = 1e-12;

/// Searches the best sets among `candidates`; keeps its buffers between calls.
#[derive(Debug, Clone, Default)]
pub struct ContactSearch {
    candidates: Vec<Candidate>,
    chosen: Vec<usize>,
    best: Vec<u32>,
    best_total: f64,
    /// Candidates by the octant cell of their force direction, for the last contact.
    cells: Vec<Vec<u16>>,
}

/// Cells per axis of the grid over force directions.
const CELLS: usize = 8;

impl ContactSearch {
    /// Starts a new search, handing out the (emptied) list of candidates to fill.
    pub fn candidates_mut(&mut self) -> &mut Vec<Candidate> {
        &mut self.candidates
    }

    /// Total of a given set of positions in the candidate list, summed in index order so that it does not depend on the
    /// way the set was found.
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

    fn offer(&mut self, positions: &mut [usize], cost: &WrenchCost) {
        let total = self.total(positions, cost);
        if total > self.best_total {
            return;
        }
        let set = positions.iter().map(|&p| self.candidates[p].index);
        if total < self.best_total || set.clone().lt(self.best.iter().copied()) {
            self.best_total = total;
            self.best.clear();
            self.best.extend(set);
        }
    }

    /// A good set that depends on the candidates alone: the best of coordinate descents from opposed pairs of candidates
    /// along the axes and from the cheapest candidates. Otherwise as [`ContactSearch::descend`].
    pub fn descend_cold(&mut self, size: usize, cost: &WrenchCost) -> f64 {
        let mut best = (self.descend(size, &[], cost), self.best.clone());
        for axes in [[0, 1], [0, 2], [1, 2]] {
            let mut start: Vec<u32> = Vec::new();
            for axis in axes {
                let along = |a: &&Candidate, b: &&Candidate| {
                    a.wrench[axis]
                        .total_cmp(&b.wrench[axis])
                        .then(a.index.cmp(&b.index))
                };
                let ends = [
                    self.candidates.iter().min_by(along),
                    self.candidates.iter().max_by(along),
                ];
                start.extend(ends.into_iter().flatten().map(|c| c.index));
            }
            let total = self.descend(size, &start, cost);
            if total < best.0 {
                best = (total, self.best.clone());
            }
        }
        (self.best_total, self.best) = best;
        self.best_total
    }

    /// A good set by coordinate descent from `warm` (positions are looked up by index; missing ones are replaced by the
    /// cheapest candidates). Never worse than `warm` where all of it is among the candidates.
    ///
    /// Returns its total, or infinity with fewer than `size` candidates; the set is read with [`ContactSearch::best`].
    pub fn descend(&mut self, size: usize, warm: &[u32], cost: &WrenchCost) -> f64 {
        self.candidates
            .sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost).then(a.index.cmp(&b.index)));
        self.best.clear();
        self.best_total = f64::INFINITY;
        if self.candidates.len() < size || size == 0 {
            return self.best_total;
        }
        let mut set: Vec<usize> = std::mem::take(&mut self.chosen);
        set.clear();
        for index in warm.iter().take(size) {
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
        self.offer(&mut set.clone(), cost);
        loop {
            let before = self.best_total;
            for slot in 0..size {
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
                for (p, candidate) in self.candidates.iter().enumerate() {
                    if own + candidate.cost >= least {
                        break;
                    }
                    let total = own
                        + candidate.cost
                        + cost.of_squared(sum_norm_squared(&others, &candidate.wrench));
                    if total < least && !set.iter().enumerate().any(|(k, &q)| k != slot && q == p) {
                        least = total;
                        choice = p;
                    }
                }
                set[slot] = choice;
            }
            self.offer(&mut set.clone(), cost);
            if self.best_total >= before - SLACK {
                break;
            }
        }
        self.chosen = set;
        self.best_total
    }

    /// Proves or improves the set left by [`ContactSearch::descend`] until it is the exact minimum over all sets of
    /// `size` candidates, and returns its total.
    ///
    /// # Panics
    /// With more than 65,536 candidates.
    pub fn prove(&mut self, size: usize, cost: &WrenchCost) -> f64 {
        if self.candidates.len() < size || size == 0 {
            return self.best_total;
        }
        // Members beyond this position cannot occur: the others cost at least as much as the cheapest ones.
        let floor = self.floor(size - 1);
        let usable = self
            .candidates
            .partition_point(|c| c.cost + floor <= self.best_total + SLACK);
        self.cells.resize_with(CELLS * CELLS * CELLS, Vec::new);
        for cell in &mut self.cells {
            cell.clear();
        }
        for p in 0..usable {
            let w = &self.candidates[p].wrench;
            let position = u16::try_from(p).expect("a hand has fewer than 65536 surface points");
            self.cells[cell_of(w[0]) * CELLS * CELLS + cell_of(w[1]) * CELLS + cell_of(w[2])]
                .push(position);
        }
        let mut chosen = std::mem::take(&mut self.chosen);
        chosen.clear();
        self.extend(&mut chosen, size, usable, 0, 0.0, [0.0; 6], cost);
        self.chosen = chosen;
        self.best_total
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "the state of one branch; a struct would be built and torn down millions of times"
    )]
    fn extend(
        &mut self,
        chosen: &mut Vec<usize>,
        size: usize,
        usable: usize,
        from: usize,
        own: f64,
        wrench: [f64; 6],
        cost: &WrenchCost,
    ) {
        let missing = size - chosen.len();
        if missing == 1 {
            self.close(chosen, from, own, &wrench, cost);
            return;
        }
        for p in from..usable {
            let candidate = self.candidates[p];
            let least_own = own + missing as f64 * candidate.cost;
            if least_own > self.best_total + SLACK {
                break;
            }
            let mut sum = wrench;
            add(&mut sum, &candidate.wrench);
            let force = (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt();
            let reach = cost.reach(self.best_total + SLACK - least_own);
            if force - (missing - 1) as f64 > reach || (missing == 2 && 1.0 - force > reach) {
                continue;
            }
            chosen.push(p);
            self.extend(chosen, size, usable, p + 1, own + candidate.cost, sum, cost);
            chosen.pop();
        }
    }

    /// Tries every last member whose force lies within reach of cancelling `wrench`.
    fn close(
        &mut self,
        chosen: &[usize],
        from: usize,
        own: f64,
        wrench: &[f64; 6],
        cost: &WrenchCost,
    ) {
        let Some(cheapest) = self.candidates.get(from) else {
            return;
        };
        let reach = cost.reach(self.best_total + SLACK - own - cheapest.cost);
        let range = |k: usize| cell_of(-wrench[k] - reach)..=cell_of(-wrench[k] + reach);
        let (xs, ys, zs) = (range(0), range(1), range(2));
        for x in xs {
            for y in ys.clone() {
                for z in zs.clone() {
                    let cell = x * CELLS * CELLS + y * CELLS + z;
                    for slot in 0..self.cells[cell].len() {
                        let p = usize::from(self.cells[cell][slot]);
                        if p < from {
                            continue;
                        }
                        let candidate = &self.candidates[p];
                        if own + candidate.cost > self.best_total + SLACK {
                            break;
                        }
                        let total = own
                            + candidate.cost
                            + cost.of_squared(sum_norm_squared(wrench, &candidate.wrench));
                        if total <= self.best_total + SLACK {
                            let mut set: Vec<usize> = chosen.to_vec();
                            set.push(p);
                            self.offer(&mut set, cost);
                        }
                    }
                }
            }
        }
    }

    /// Least own cost of any `count` candidates together; infinite with fewer.
    pub fn floor(&self, count: usize) -> f64 {
        if self.candidates.len() < count {
            return f64::INFINITY;
        }
        self.candidates[..count].iter().map(|c| c.cost).sum()
    }

    /// The best set found, as sorted surface-point indices.
    pub fn best(&self) -> &[u32] {
        &self.best
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

/// Cell of one component of a unit vector; components beyond ±1 fall into the outermost cells.
fn cell_of(component: f64) -> usize {
    let scaled = ((component + 1.0) * 0.5 * CELLS as f64).clamp(0.0, (CELLS - 1) as f64);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to 0..CELLS just above; the cut-off fraction is meant"
    )]
    let cell = scaled as usize;
    cell
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
            for (size, rounding) in [(2, 0.05), (3, 0.0), (3, 0.05), (4, 0.05), (5, 0.05)] {
                let candidates = random_candidates(18, seed);
                let cost = WrenchCost {
                    weight: 1.0,
                    rounding,
                };
                let (total, set) = brute_force(&candidates, size, &cost);
                let mut search = ContactSearch::default();
                search.candidates_mut().extend(candidates.iter().rev());
                let descended = search.descend(size, &[3, 5], &cost);
                let proven = search.prove(size, &cost);
                assert!(descended >= proven);
                assert!((proven - total).abs() < 1e-12, "{proven} against {total}");
                assert_eq!(search.best(), set);
            }
        }
    }

    #[test]
    fn too_few_candidates() {
        let cost = WrenchCost {
            weight: 1.0,
            rounding: 0.0,
        };
        let mut search = ContactSearch::default();
        search.candidates_mut().extend(random_candidates(2, 0));
        assert!(search.descend(3, &[], &cost).is_infinite());
        assert!(search.prove(3, &cost).is_infinite());
    }
}
