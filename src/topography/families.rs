//! Families: minima joined by low relative barriers, at the level with the most stable partition.

use petgraph::unionfind::UnionFind;
use petgraph::visit::EdgeRef;
use rand::RngExt;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::network::{Evidence, MinimumId, Network};
use crate::agreement::adjusted_rand_of_pairs;
use crate::sample::{Task, stream};

/// Relative difference below which barriers are equal: two refinements of one pass differ by rounding only.
const TIE: f64 = 1e-7;
/// Difference of barriers, relative to the highest, that is rounding: searches know heights to about this.
const ROUNDING: f64 = 1e-6;
/// Greatest number of relative barriers to try, quantiles of those of the network. Each costs a partition in every resampling.
const LEVELS: usize = 24;
/// Seed of the resamplings. It is no setting, because families must not change with the seed of the search.
const SEED: u64 = 0;

/// Settings of [`Families::new`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FamilySettings {
    /// Relative barrier b that joins two minima. By default it is the one with the most stable partition. Families of two
    /// landscapes are comparable only at the same b.
    pub barrier: Option<f64>,
    /// Number of resamplings of the connections. With 0, the level below the widest gap of the barriers is chosen from all of
    /// them, which suits connections that are known well.
    pub resamplings: usize,
    /// Worst evidence that joins two minima.
    pub worst: Evidence,
}

impl Default for FamilySettings {
    fn default() -> Self {
        Self {
            barrier: None,
            resamplings: 64,
            worst: Evidence::Path,
        }
    }
}

impl FamilySettings {
    /// Settings for minima whose lowest saddles are known: no seed decides.
    pub fn of_saddles() -> Self {
        Self {
            resamplings: 0,
            ..Self::default()
        }
    }
}

/// One level of the scan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// Relative barrier b.
    pub barrier: f64,
    /// Mean adjusted Rand index between the partition of the network and those of its resamplings. Without resamplings, 1 − b/b′
    /// for the next greater barrier b′ that joins families (0 if there is none).
    pub stability: f64,
    /// Number of families.
    pub families: usize,
    /// Size of the largest family.
    pub largest: usize,
}

/// A partition of the minima.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Families {
    /// Greatest relative barrier `B − max(E_i, E_j)` that joins two minima.
    pub barrier: f64,
    /// The members of each family, sorted by energy. The families are sorted by their lowest member.
    pub members: Vec<Vec<MinimumId>>,
    /// All levels tried, by ascending barrier.
    pub scan: Vec<Level>,
}

impl Families {
    /// Components of minima joined by connections with evidence `worst` or better and relative barrier at most `barrier`.
    pub fn below(network: &Network, barrier: f64, worst: Evidence) -> Self {
        let links = links(network, worst);
        let labels = partition(network.node_count(), &links, barrier, |_| true);
        Self {
            barrier,
            members: members(&labels),
            scan: Vec::new(),
        }
    }

    /// The family number of each minimum.
    pub fn family_of(&self) -> Vec<usize> {
        let mut family_of = vec![0; self.members.iter().map(Vec::len).sum()];
        for (family, members) in self.members.iter().enumerate() {
            for member in members {
                family_of[member.0] = family;
            }
        }
        family_of
    }

    /// The partition at the level b of the settings, or else at the level where it is most stable.
    ///
    /// The stability of a level is the mean adjusted Rand index (L. Hubert and P. Arabie, J. Classif. 2, 193 (1985))
    /// between its partition and those of connections resampled with replacement. Levels at which all minima are separate
    /// or all are one family are ignored. Two other kinds count only if there is nothing else: levels at which one family
    /// holds more than half of the minima (it has percolated), and levels with more families than half the minima (joining
    /// has hardly begun). Of equally stable levels the lowest wins. If no level is left, every minimum is a family of its
    /// own.
    pub fn new(network: &Network, settings: &FamilySettings) -> Self {
        if let Some(barrier) = settings.barrier {
            return Self::below(network, barrier, settings.worst);
        }
        let links = links(network, settings.worst);
        let n = network.node_count();
        if settings.resamplings == 0 {
            let scan = gaps(n, &links);
            let barrier = most_stable(&scan, n).map_or(0.0, |level| level.barrier);
            return Self {
                scan,
                ..Self::below(network, barrier, settings.worst)
            };
        }
        let mut barriers: Vec<f64> = links.iter().map(|link| link.2).collect();
        barriers.sort_by(f64::total_cmp);
        barriers.dedup_by(|b, a| *b <= *a + TIE * a.abs());
        let count = LEVELS.min(barriers.len());
        let grid: Vec<f64> = (1..=count)
            .map(|k| barriers[k * barriers.len() / count - 1])
            .collect();
        // The links sorted by the first level that includes them, without those above all levels.
        let mut rising: Vec<(usize, usize)> = (links.iter().enumerate())
            .map(|(k, link)| (grid.partition_point(|b| b + TIE * b < link.2), k))
            .filter(|(level, _)| *level < grid.len())
            .collect();
        rising.sort_unstable();
        let whole: Vec<Joined> = joined(n, &links, &rising, grid.len(), |_| true);
        let resampled: Vec<Vec<f64>> = (0..settings.resamplings)
            .into_par_iter()
            .map(|id| {
                let mut rng = stream(SEED, Task::Resampling, id as u64);
                let mut drawn = vec![false; links.len()];
                for _ in 0..links.len() {
                    drawn[rng.random_range(0..links.len())] = true;
                }
                let parts = joined(n, &links, &rising, grid.len(), |k| drawn[k]);
                let both = whole.iter().zip(&parts);
                both.map(|(whole, part)| agreement_with_part(n, whole.pairs, part.pairs))
                    .collect()
            })
            .collect();
        let scan: Vec<Level> = (grid.iter().zip(&whole).enumerate())
            .map(|(row, (barrier, whole))| {
                let total: f64 = resampled.iter().map(|indices| indices[row]).sum();
                Level {
                    barrier: *barrier,
                    stability: total / resampled.len().max(1) as f64,
                    families: whole.families,
                    largest: whole.largest,
                }
            })
            .collect();
        let barrier = most_stable(&scan, n).map_or(0.0, |level| level.barrier);
        Self {
            scan,
            ..Self::below(network, barrier, settings.worst)
        }
    }
}

/// The levels at which families of `n` minima join. Barriers that differ by rounding are one level, so the levels do not depend on
/// the order in which saddles were found.
fn gaps(n: usize, links: &[(usize, usize, f64)]) -> Vec<Level> {
    let mut barriers: Vec<f64> = links.iter().map(|link| link.2).collect();
    barriers.sort_by(f64::total_cmp);
    let rounding = ROUNDING * barriers.last().copied().unwrap_or(0.0);
    let runs = barriers.chunk_by(|a, b| b - a <= rounding);
    let grid: Vec<f64> = runs.filter_map(|run| run.last().copied()).collect();
    let mut rising: Vec<(usize, usize)> = (links.iter().enumerate())
        .map(|(k, link)| (grid.partition_point(|b| *b < link.2), k))
        .collect();
    rising.sort_unstable();
    let mut scan: Vec<Level> = Vec::new();
    let mut families = n;
    for (barrier, joined) in grid
        .iter()
        .zip(joined(n, links, &rising, grid.len(), |_| true))
    {
        if joined.families == families {
            continue;
        }
        families = joined.families;
        if let Some(last) = scan.last_mut() {
            last.stability = 1.0 - last.barrier / barrier;
        }
        scan.push(Level {
            barrier: *barrier,
            stability: 0.0,
            families,
            largest: joined.largest,
        });
    }
    scan
}

/// The most stable informative level of `n` minima, by the rules of [`Families::new`].
fn most_stable(scan: &[Level], n: usize) -> Option<Level> {
    let telling = |level: &&Level| level.families > 1 && level.families < n;
    let best = |levels: &mut dyn Iterator<Item = &Level>| {
        levels.fold(None, |best: Option<Level>, level| match best {
            Some(known) if known.stability >= level.stability => Some(known),
            _ => Some(*level),
        })
    };
    let whole = |level: &&Level| 2 * level.largest <= n;
    let begun = |level: &&Level| 2 * level.families <= n;
    best(&mut scan.iter().filter(telling).filter(whole).filter(begun))
        .or_else(|| best(&mut scan.iter().filter(telling).filter(whole)))
        .or_else(|| best(&mut scan.iter().filter(telling)))
}

fn links(network: &Network, worst: Evidence) -> Vec<(usize, usize, f64)> {
    let usable = network.edge_references().filter(|edge| {
        edge.weight().evidence <= worst
            && edge.weight().height.is_finite()
            && edge.source() != edge.target()
    });
    usable
        .map(|edge| {
            let above = network[edge.source()]
                .energy
                .max(network[edge.target()].energy);
            let relative = (edge.weight().height - above).max(0.0);
            (edge.source().index(), edge.target().index(), relative)
        })
        .collect()
}

fn partition(
    n: usize,
    links: &[(usize, usize, f64)],
    barrier: f64,
    keep: impl Fn(usize) -> bool,
) -> Vec<usize> {
    let mut sets = UnionFind::new(n);
    for (k, (i, j, relative)) in links.iter().enumerate() {
        if *relative <= barrier + TIE * barrier && keep(k) {
            sets.union(*i, *j);
        }
    }
    sets.into_labeling()
}

/// Statistics of a partition.
#[derive(Clone, Copy)]
struct Joined {
    families: usize,
    largest: usize,
    /// Number of pairs of minima in the same family.
    pairs: f64,
}

/// The partitions at all levels by those `rising` links (level and index) that are kept, in one pass over the levels.
fn joined(
    n: usize,
    links: &[(usize, usize, f64)],
    rising: &[(usize, usize)],
    levels: usize,
    keep: impl Fn(usize) -> bool,
) -> Vec<Joined> {
    let mut sets = UnionFind::new(n);
    let mut sizes = vec![1_usize; n];
    let mut now = Joined {
        families: n,
        largest: n.min(1),
        pairs: 0.0,
    };
    let mut next = rising.iter().peekable();
    (0..levels)
        .map(|level| {
            while let Some((_, k)) = next.next_if(|(first, _)| *first <= level) {
                let [a, b] = [links[*k].0, links[*k].1].map(|end| sets.find_mut(end));
                if keep(*k) && sets.union(a, b) {
                    let size = sizes[a] + sizes[b];
                    now.pairs += (sizes[a] * sizes[b]) as f64;
                    sizes[sets.find(a)] = size;
                    now.families -= 1;
                    now.largest = now.largest.max(size);
                }
            }
            now
        })
        .collect()
}

fn members(labels: &[usize]) -> Vec<Vec<MinimumId>> {
    let mut place = vec![None; labels.len()];
    let mut members: Vec<Vec<MinimumId>> = Vec::new();
    for (i, label) in labels.iter().enumerate() {
        let family = *place[*label].get_or_insert_with(|| {
            members.push(Vec::new());
            members.len() - 1
        });
        members[family].push(MinimumId(i));
    }
    members
}

/// The adjusted Rand index of a partition of `n` and a refinement of it. Pairs that are together in the refinement are
/// together in both, so the numbers of pairs in the families of the `whole` and the `part` determine the index.
fn agreement_with_part(n: usize, whole: f64, part: f64) -> f64 {
    let total = (n * n.saturating_sub(1)) as f64 / 2.0;
    adjusted_rand_of_pairs(part, [whole, part], total)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agreement::adjusted_rand;
    use crate::topography::tree::tests::{any_network, network};
    use proptest::prelude::*;

    /// The level that joins all `links` (ends and relative barrier) up to `barrier`, with stability 1, and the family labels.
    fn level(n: usize, links: &[(usize, usize, f64)], barrier: f64) -> (Level, Vec<usize>) {
        let labels = partition(n, links, barrier, |_| true);
        let sizes: Vec<usize> = members(&labels).iter().map(Vec::len).collect();
        let level = Level {
            barrier,
            stability: 1.0,
            families: sizes.len(),
            largest: sizes.into_iter().max().unwrap_or(0),
        };
        (level, labels)
    }

    proptest! {
        #[test]
        fn the_scan_is_that_of_each_level_by_itself(network in any_network()) {
            let settings = FamilySettings { resamplings: 5, ..FamilySettings::default() };
            let found = Families::new(&network, &settings);
            let (links, n) = (links(&network, settings.worst), network.node_count());
            for known in found.scan {
                let (expected, labels) = level(n, &links, known.barrier);
                let total: f64 = (0..5)
                    .map(|id| {
                        let mut rng = stream(SEED, Task::Resampling, id);
                        let drawn: Vec<usize> = links.iter().map(|_| rng.random_range(0..links.len())).collect();
                        let parts = partition(n, &links, known.barrier, |k| drawn.contains(&k));
                        adjusted_rand(&labels, &parts)
                    })
                    .sum();
                prop_assert_eq!(known, Level { stability: total / 5.0, ..expected });
            }
        }
    }

    #[test]
    fn two_tight_families_are_found() {
        // Two complete families of five with barriers near 0.1, joined by high ones.
        let mut edges = Vec::new();
        for family in [0, 5] {
            for i in 0..5 {
                for j in i + 1..5 {
                    let height = 0.1 + 0.001 * (i + j) as f64;
                    edges.push((family + i, family + j, height, Evidence::Saddle));
                }
            }
        }
        edges.push((0, 5, 1.0, Evidence::Path));
        edges.push((3, 9, 1.2, Evidence::Path));
        edges.push((1, 6, 0.01, Evidence::Chain));
        let families = Families::new(&network(&[0.0; 10], &edges), &FamilySettings::default());
        assert_eq!(families.members.len(), 2, "{families:?}");
        assert!(families.members.iter().all(|members| members.len() == 5));
        assert!((0.1..1.0).contains(&families.barrier));
    }

    /// Three pairs whose members are 0.1 apart, while different pairs are 1.0 or more apart.
    fn three_pairs() -> Network {
        let near = |a: usize| (a, a + 1, 0.1 + 0.001 * a as f64, Evidence::Saddle);
        let far = |a: usize, b: usize| (a, b, 1.0 + 0.01 * (a + b) as f64, Evidence::Path);
        let edges = [near(0), near(2), near(4), far(1, 2), far(3, 4), far(0, 5)];
        network(&[0.0; 6], &edges)
    }

    #[test]
    fn families_at_a_given_barrier() {
        let at = |barrier| {
            let settings = FamilySettings {
                barrier: Some(barrier),
                ..FamilySettings::default()
            };
            Families::new(&three_pairs(), &settings)
        };
        assert_eq!(at(0.2).members.len(), 3);
        assert!((at(0.2).barrier - 0.2).abs() < 1e-15);
        assert_eq!(at(9.0).members.len(), 1);
    }

    /// Wells on a line, in two orders and with other rounding, as two seeds find them.
    #[test]
    fn gaps_do_not_depend_on_order_or_rounding() {
        let heights = [0.1, 1.0, 0.1, 1.0, 0.1, 3.0, 0.1, 1.0, 0.1];
        let found = |backward: bool| {
            let at = |k: usize| if backward { 9 - k } else { k };
            let edge = |(k, height): (usize, &f64)| {
                let noise = 1e-9 * at(k) as f64;
                (at(k), at(k + 1), height + noise, Evidence::Saddle)
            };
            let edges: Vec<_> = heights.iter().enumerate().map(edge).collect();
            Families::new(&network(&[0.0; 10], &edges), &FamilySettings::of_saddles())
        };
        let sizes = [false, true].map(|backward| {
            let members = found(backward).members;
            let mut sizes: Vec<usize> = members.iter().map(Vec::len).collect();
            sizes.sort_unstable();
            sizes
        });
        assert_eq!(sizes[0], [2; 5]);
        assert_eq!(sizes[0], sizes[1]);
        // All barriers are equal, so that no level divides the minima.
        let edges: Vec<_> = (0..3)
            .map(|k| (k, k + 1, 1.0 + 1e-9 * k as f64, Evidence::Saddle))
            .collect();
        let even = Families::new(&network(&[0.0; 4], &edges), &FamilySettings::of_saddles());
        assert_eq!(even.members.len(), 4);
    }

    #[test]
    fn a_lone_minimum_is_its_own_family() {
        let families = Families::new(&network(&[1.0], &[]), &FamilySettings::default());
        assert_eq!(families.members, [[MinimumId(0)]]);
    }
}
