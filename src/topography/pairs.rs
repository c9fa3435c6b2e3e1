//! Selects the pairs of minima to connect.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::network::Minimum;
use super::places::widened;
use crate::space::Space;

/// Up to so many minima, distances that were measured are kept (half a matrix of 8 bytes each, 64 MB).
const KEPT: usize = 4000;

/// Distances between sites, which are minima or basins. A distance modulo symmetries is dear, so that bounds come first.
pub(super) trait Distances: Sync {
    /// Number of sites.
    fn len(&self) -> usize;

    /// Distance of two sites.
    fn between(&self, i: usize, j: usize) -> f64;

    /// A cheap lower bound of their distance.
    fn least(&self, i: usize, j: usize) -> f64 {
        let _ = (i, j);
        0.0
    }
}

/// A matrix.
impl Distances for Vec<Vec<f64>> {
    fn len(&self) -> usize {
        self.len()
    }

    fn between(&self, i: usize, j: usize) -> f64 {
        self[i][j]
    }
}

/// Distances of minima in their space.
pub(super) struct BetweenMinima<'a> {
    space: &'a dyn Space,
    minima: &'a [Minimum],
    landmarks: Vec<Vec<f64>>,
    /// The bits of the distances of minima 1 and 0, 2 and 0, 2 and 1 and so on, 0 if it was not measured yet; empty if there
    /// are too many minima.
    kept: Vec<AtomicU64>,
}

impl<'a> BetweenMinima<'a> {
    pub(super) fn new(space: &'a dyn Space, minima: &'a [Minimum]) -> Self {
        let n = minima.len();
        let kept = if n <= KEPT {
            n * n.saturating_sub(1) / 2
        } else {
            0
        };
        Self {
            space,
            minima,
            landmarks: (minima.par_iter())
                .map(|minimum| space.landmarks(&minimum.coordinates))
                .collect(),
            kept: std::iter::repeat_with(AtomicU64::default)
                .take(kept)
                .collect(),
        }
    }

    fn measured(&self, lower: usize, higher: usize) -> f64 {
        let [a, b] = [lower, higher].map(|i| self.minima[i].coordinates.as_slice());
        self.space.distance(a, b)
    }
}

impl Distances for BetweenMinima<'_> {
    fn len(&self) -> usize {
        self.minima.len()
    }

    fn between(&self, i: usize, j: usize) -> f64 {
        let (lower, higher) = (i.min(j), i.max(j));
        if lower == higher {
            return 0.0;
        }
        let Some(kept) = self.kept.get(higher * (higher - 1) / 2 + lower) else {
            return self.measured(lower, higher);
        };
        // Threads may measure a distance twice; they agree.
        match kept.load(Ordering::Relaxed) {
            0 => {
                let distance = self.measured(lower, higher);
                kept.store(distance.to_bits(), Ordering::Relaxed);
                distance
            }
            bits => f64::from_bits(bits),
        }
    }

    fn least(&self, i: usize, j: usize) -> f64 {
        let sides = self.landmarks[i].iter().zip(&self.landmarks[j]);
        let squared: f64 = sides.map(|(a, b)| (a - b) * (a - b)).sum();
        let apart = squared.sqrt();
        // What rounding may have added. A NaN bounds nothing.
        (apart - (widened(apart, &self.landmarks[i]) - apart)).max(0.0)
    }
}

/// Up to `count` sites nearest to site `i` with their distances, nearest first, of equal ones those with the lowest numbers.
/// Only sites for which `wanted` holds, first of all with the number and then with the distance, too.
pub(super) fn nearest(
    distances: &dyn Distances,
    i: usize,
    count: usize,
    wanted: impl Fn(usize, Option<f64>) -> bool,
) -> Vec<(f64, usize)> {
    let mut found: Vec<(f64, usize)> = Vec::new();
    for j in (0..distances.len()).filter(|j| *j != i) {
        let full = found.len() == count;
        let farthest = found.last().filter(|_| full);
        let far = farthest.is_some_and(|(far, _)| distances.least(i, j) > *far);
        if far || !wanted(j, None) {
            continue;
        }
        let here = (distances.between(i, j), j);
        let before = |(far, k): &(f64, usize)| far.total_cmp(&here.0).then(k.cmp(&here.1)).is_lt();
        let place = found.partition_point(before);
        if place < count && wanted(j, Some(here.0)) {
            found.truncate(count - 1);
            found.insert(place, here);
        }
    }
    found
}

/// Pairs of each site with its `neighbours` nearest sites, and the edges of the minimum spanning tree, so that the pairs
/// connect all sites. Pairs (i, j) have i < j and come nearest first. Memory grows with the number of pairs, and only
/// distances are measured whose lower bounds do not exclude them.
pub(super) fn candidates(distances: &dyn Distances, neighbours: usize) -> Vec<(usize, usize)> {
    let near = |i: usize| {
        let near = nearest(distances, i, neighbours, |_, _| true).into_iter();
        near.map(|(distance, j)| ((i.min(j), i.max(j)), distance))
            .collect::<Vec<_>>()
    };
    let near: Vec<Vec<_>> = (0..distances.len()).into_par_iter().map(near).collect();
    let mut pairs: BTreeMap<(usize, usize), f64> = near.into_iter().flatten().collect();
    pairs.extend(spanning_tree(distances));
    sorted(pairs)
}

/// The shortest untried pair from every component to another one; `component[i]` is that of site i.
pub(super) fn bridges(
    distances: &dyn Distances,
    component: &[usize],
    tried: &(impl Fn((usize, usize)) -> bool + Sync),
) -> Vec<(usize, usize)> {
    sorted(shortest(distances, component, tried))
}

/// The pairs of [`bridges`] with their distances.
fn shortest(
    distances: &dyn Distances,
    component: &[usize],
    tried: &(impl Fn((usize, usize)) -> bool + Sync),
) -> BTreeMap<(usize, usize), f64> {
    let pair = |i: usize, j: usize| (i.min(j), i.max(j));
    let across = |i: usize| {
        let wanted = |j: usize, _: Option<f64>| component[i] != component[j] && !tried(pair(i, j));
        nearest(distances, i, 1, wanted).pop()
    };
    let across: Vec<Option<(f64, usize)>> =
        (0..distances.len()).into_par_iter().map(across).collect();
    let mut shortest: Vec<Option<(f64, (usize, usize))>> = vec![None; distances.len()];
    for (i, found) in across.into_iter().enumerate() {
        let Some((distance, j)) = found else { continue };
        let here = (distance, pair(i, j));
        let best = &mut shortest[component[i]];
        let nearer = |(known, other): &(f64, (usize, usize))| {
            distance.total_cmp(known).then(here.1.cmp(other)).is_lt()
        };
        if best.as_ref().is_none_or(nearer) {
            *best = Some(here);
        }
    }
    let shortest = shortest.into_iter().flatten();
    shortest.map(|(distance, pair)| (pair, distance)).collect()
}

fn sorted(pairs: BTreeMap<(usize, usize), f64>) -> Vec<(usize, usize)> {
    let mut pairs: Vec<_> = pairs.into_iter().collect();
    pairs.sort_by(|(a, one), (b, other)| one.total_cmp(other).then(a.cmp(b)));
    pairs.into_iter().map(|(pair, _)| pair).collect()
}

/// The edges of the minimum spanning tree and their lengths, by Borůvka's algorithm. Of edges of equal length the one with
/// the lowest numbers comes first, so that there is one such tree.
fn spanning_tree(distances: &dyn Distances) -> Vec<((usize, usize), f64)> {
    let n = distances.len();
    let mut sets = petgraph::unionfind::UnionFind::new(n);
    let mut tree = Vec::new();
    while tree.len() + 1 < n {
        let component: Vec<usize> = sets.clone().into_labeling();
        for (pair, length) in shortest(distances, &component, &|_| false) {
            if sets.union(pair.0, pair.1) {
                tree.push((pair, length));
            }
        }
    }
    tree
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(places: &[f64]) -> Vec<Vec<f64>> {
        let row = |a: &f64| places.iter().map(|b| (a - b).abs()).collect();
        places.iter().map(row).collect()
    }

    #[test]
    fn two_clouds_are_joined_by_their_shortest_link() {
        let distances = line(&[0.0, 1.0, 2.0, 10.0, 11.0, 12.5]);
        assert_eq!(
            candidates(&distances, 1),
            [(0, 1), (1, 2), (3, 4), (4, 5), (2, 3)]
        );
        let component = [0, 0, 0, 3, 3, 3];
        assert_eq!(bridges(&distances, &component, &|_| false), [(2, 3)]);
        assert_eq!(
            bridges(&distances, &component, &|pair| pair == (2, 3)),
            [(1, 3)]
        );
    }

    #[test]
    fn nothing_to_join() {
        assert!(candidates(&line(&[]), 3).is_empty());
        assert!(candidates(&line(&[1.0]), 3).is_empty());
    }

    /// Without a matrix the distances are measured anew each time.
    #[test]
    fn pairs_do_not_depend_on_what_is_kept() {
        let space = crate::space::Euclidean::new(2);
        let point = |i: u32| {
            let angle = 2.399_963 * f64::from(i);
            let radius = f64::from(i).sqrt();
            vec![radius * libm::cos(angle), radius * libm::sin(angle)]
        };
        let minima: Vec<Minimum> = (0..150).map(|i| Minimum::bare(point(i), 0.0)).collect();
        let kept = BetweenMinima::new(&space, &minima);
        let measured = BetweenMinima {
            kept: Vec::new(),
            ..BetweenMinima::new(&space, &minima)
        };
        let matrix: Vec<Vec<f64>> = (0..150)
            .map(|i| (0..150).map(|j| measured.between(i, j)).collect())
            .collect();
        let component: Vec<usize> = (0..150).map(|i| i / 50 * 50).collect();
        let pairs = |distances: &dyn Distances| {
            (
                candidates(distances, 4),
                bridges(distances, &component, &|(i, _)| i % 2 == 0),
            )
        };
        assert_eq!(pairs(&kept), pairs(&measured));
        assert_eq!(pairs(&kept), pairs(&matrix), "bounds exclude nothing");
        assert_eq!(pairs(&kept).1.len(), 2);
    }

    /// Counts the distances that are measured.
    struct Counting<'a>(BetweenMinima<'a>, AtomicU64);

    impl Distances for Counting<'_> {
        fn len(&self) -> usize {
            self.0.len()
        }

        fn between(&self, i: usize, j: usize) -> f64 {
            self.1.fetch_add(1, Ordering::Relaxed);
            self.0.between(i, j)
        }

        fn least(&self, i: usize, j: usize) -> f64 {
            self.0.least(i, j)
        }
    }

    /// Points of a plane, and clusters, whose bounds are weak.
    #[test]
    fn bounds_spare_distances_and_change_no_pair() {
        let plane = crate::space::Euclidean::new(2);
        let clusters = crate::space::Cluster::new(4);
        assert!(measured(&plane, 300) < 300 * 300 / 4);
        // Each pair twice for the neighbours, and at most as often again for each of six rounds of the tree.
        assert!(measured(&clusters, 60) < 7 * 60 * 59);
    }

    /// The number of distances that are asked for between random points, whose pairs must be those of a matrix.
    fn measured(space: &dyn Space, n: usize) -> u64 {
        use crate::sample::{Task, stream};
        use rand::RngExt;

        let mut rng = stream(5, Task::Start, 0);
        let mut point = || {
            let coordinates = 0..space.coordinates();
            coordinates.map(|_| rng.random_range(-1.0..1.0)).collect()
        };
        let minima: Vec<Minimum> = (0..n).map(|_| Minimum::bare(point(), 0.0)).collect();
        let counting = Counting(BetweenMinima::new(space, &minima), AtomicU64::new(0));
        let pairs = candidates(&counting, 3);
        let matrix: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|j| counting.0.between(i, j)).collect())
            .collect();
        assert_eq!(pairs, candidates(&matrix, 3));
        counting.1.load(Ordering::Relaxed)
    }
}
