//! Which pairs of minima to join and where to climb: shortest paths over estimated costs, and effort where the tree is
//! uncertain.

use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap};

use petgraph::unionfind::UnionFind;

use super::pool::Pool;

/// A merge of the tree of the lowest minima.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fork {
    /// Energy of the saddle; infinite if nothing joins the two sides.
    pub(super) height: f64,
    /// The lowest minima of both sides, the lower one first.
    pub(super) bottoms: [usize; 2],
    /// Height above the shallower bottom.
    pub(super) depth: f64,
}

/// The merges of the tree of all minima, restricted to `targets` (lowest first), lowest merge first.
pub(super) fn forks(pool: &Pool<'_>, targets: &[usize]) -> Vec<Fork> {
    let mut sets = UnionFind::new(pool.sites.len());
    // The lowest target of each set, by representative.
    let mut bottom: Vec<Option<usize>> = vec![None; pool.sites.len()];
    for target in targets {
        bottom[*target] = Some(*target);
    }
    let energy = |site: usize| pool.sites[site].energy;
    let fork = |height: f64, a: usize, b: usize| {
        let bottoms = if energy(a) <= energy(b) {
            [a, b]
        } else {
            [b, a]
        };
        Fork {
            height,
            bottoms,
            depth: height - energy(bottoms[1]),
        }
    };
    let mut forks = Vec::new();
    for gate in pool.gates_by_energy().map(|number| &pool.gates[number]) {
        let roots = gate.ends.map(|end| sets.find(end));
        if roots[0] == roots[1] {
            continue;
        }
        let bottoms = roots.map(|root| bottom[root]);
        sets.union(roots[0], roots[1]);
        let lower = match bottoms {
            [Some(a), Some(b)] => {
                let fork = fork(gate.energy, a, b);
                forks.push(fork);
                Some(fork.bottoms[0])
            }
            [a, b] => a.or(b),
        };
        bottom[sets.find(roots[0])] = lower;
    }
    let mut apart: Vec<usize> = targets
        .iter()
        .copied()
        .filter(|target| bottom[sets.find(*target)] == Some(*target))
        .collect();
    if !apart.is_empty() {
        let lowest = apart.remove(0);
        forks.extend(
            apart
                .into_iter()
                .map(|other| fork(f64::INFINITY, lowest, other)),
        );
    }
    forks
}

/// The set of minima that saddles below `height` join to each of `seeds`: for each minimum, the number of its seed.
pub(super) fn sides(pool: &Pool<'_>, seeds: [usize; 2], height: f64) -> Vec<Option<usize>> {
    let mut sets = UnionFind::new(pool.sites.len());
    for gate in pool.gates.iter().filter(|gate| gate.energy < height) {
        sets.union(gate.ends[0], gate.ends[1]);
    }
    let roots = seeds.map(|seed| sets.find(seed));
    (0..pool.sites.len())
        .map(|site| {
            let root = sets.find(site);
            roots.iter().position(|seed| *seed == root)
        })
        .collect()
}

#[derive(PartialEq)]
struct Reached(f64, usize);

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.total_cmp(&self.0).then(other.1.cmp(&self.1))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Connections below a height, and pairs that were tried in vain.
pub(super) struct Roads<'a> {
    pool: &'a Pool<'a>,
    height: f64,
    joined: Vec<Vec<usize>>,
    near: Vec<Vec<(f64, usize)>>,
}

impl<'a> Roads<'a> {
    /// Uses minima and saddles below `height`.
    pub(super) fn below(pool: &'a Pool<'a>, height: f64) -> Self {
        let count = pool.sites.len();
        let (mut joined, mut near) = (vec![Vec::new(); count], vec![Vec::new(); count]);
        for gate in pool.gates.iter().filter(|gate| gate.energy < height) {
            let [a, b] = gate.ends;
            joined[a].push(b);
            joined[b].push(a);
        }
        for (site, known) in pool.sites.iter().enumerate() {
            for (bound, other) in &known.neighbours {
                near[site].push((*bound, *other));
                near[*other].push((*bound, site));
            }
        }
        Self {
            pool,
            height,
            joined,
            near,
        }
    }

    /// The pairs without a known connection on the cheapest way between two minima; `None` if there is no way.
    ///
    /// A known connection costs nothing, an untried pair the square of its estimated distance, and a pair that was tried is
    /// closed (J. M. Carr, S. A. Trygubenko and D. J. Wales, J. Chem. Phys. 122, 234903 (2005)). The square prefers many
    /// short steps.
    pub(super) fn missing(
        &self,
        [from, to]: [usize; 2],
        tried: &BTreeSet<[usize; 2]>,
    ) -> Option<Vec<[usize; 2]>> {
        let count = self.pool.sites.len();
        let mut cost = vec![f64::INFINITY; count];
        let mut before = vec![usize::MAX; count];
        let mut gap = vec![false; count];
        let mut heap = BinaryHeap::from([Reached(0.0, from)]);
        cost[from] = 0.0;
        while let Some(Reached(spent, here)) = heap.pop() {
            if spent > cost[here] {
                continue;
            }
            if here == to {
                break;
            }
            let known = self.joined[here].iter().map(|next| (0.0, *next, false));
            let direct = (here == from).then(|| (self.pool.bound(from, to), to));
            let untried = (self.near[here].iter().copied().chain(direct))
                .filter(|(_, next)| {
                    self.pool.sites[*next].energy < self.height
                        && !tried.contains(&[here.min(*next), here.max(*next)])
                })
                .map(|(bound, next)| (bound * bound, next, true));
            for (price, next, missing) in known.chain(untried) {
                if spent + price < cost[next] {
                    cost[next] = spent + price;
                    before[next] = here;
                    gap[next] = missing;
                    heap.push(Reached(spent + price, next));
                }
            }
        }
        if !cost[to].is_finite() {
            return None;
        }
        let (mut pairs, mut here) = (Vec::new(), to);
        while here != from {
            let last = before[here];
            if gap[here] {
                pairs.push([last.min(here), last.max(here)]);
            }
            here = last;
        }
        pairs.reverse();
        Some(pairs)
    }
}
