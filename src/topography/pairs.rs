//! Selects the pairs of minima to connect.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::network::Minimum;
use crate::space::Space;

/// Up to so many minima, all their distances are kept in memory (half a matrix of 8 bytes each, 64 MB).
const KEPT: usize = 4000;
/// Rows that are computed at a time, in parallel.
const BLOCK: usize = 64;

/// Distances between sites, which are minima or basins. They are asked for by rows, because a matrix of many thousands of
/// sites does not fit in memory.
pub(super) trait Distances: Sync {
    /// Number of sites.
    fn len(&self) -> usize;

    /// Distance of two sites.
    fn between(&self, i: usize, j: usize) -> f64;

    /// Distances of site `i` to all sites.
    fn row(&self, i: usize) -> Vec<f64> {
        (0..self.len()).map(|j| self.between(i, j)).collect()
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
    /// Row i has the distances to minima 0 to i - 1; empty if there are too many minima.
    kept: Vec<Vec<f64>>,
}

impl<'a> BetweenMinima<'a> {
    pub(super) fn new(space: &'a dyn Space, minima: &'a [Minimum]) -> Self {
        let mut distances = Self {
            space,
            minima,
            kept: Vec::new(),
        };
        if minima.len() <= KEPT {
            let rows = (0..minima.len()).into_par_iter();
            distances.kept = rows
                .map(|i| (0..i).map(|j| distances.measured(j, i)).collect())
                .collect();
        }
        distances
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
            0.0
        } else if let Some(row) = self.kept.get(higher) {
            row[lower]
        } else {
            self.measured(lower, higher)
        }
    }

    fn row(&self, i: usize) -> Vec<f64> {
        if self.kept.is_empty() {
            let all = (0..self.len()).into_par_iter().with_min_len(256);
            return all.map(|j| self.between(i, j)).collect();
        }
        (0..self.len()).map(|j| self.between(i, j)).collect()
    }
}

/// Pairs of each site with its `neighbours` nearest sites, and the edges of the minimum spanning tree, so that the pairs
/// connect all sites. Pairs (i, j) have i < j and come nearest first. Memory grows with the number of pairs.
pub(super) fn candidates(distances: &dyn Distances, neighbours: usize) -> Vec<(usize, usize)> {
    let n = distances.len();
    let nearest = |i: usize| {
        let row = distances.row(i);
        let mut others: Vec<usize> = (0..n).filter(|j| *j != i).collect();
        let order = |a: &usize, b: &usize| row[*a].total_cmp(&row[*b]).then(a.cmp(b));
        if neighbours < others.len() {
            others.select_nth_unstable_by(neighbours, order);
            others.truncate(neighbours);
        }
        let pair = |j: &usize| ((i.min(*j), i.max(*j)), row[*j]);
        others.iter().map(pair).collect::<Vec<_>>()
    };
    let near: Vec<Vec<_>> = (0..n).into_par_iter().map(nearest).collect();
    let mut pairs: BTreeMap<(usize, usize), f64> = near.into_iter().flatten().collect();
    pairs.extend(spanning_tree(distances));
    sorted(pairs)
}

/// The shortest untried pair from every component to another one; `component[i]` is that of site i.
pub(super) fn bridges(
    distances: &dyn Distances,
    component: &[usize],
    tried: &impl Fn((usize, usize)) -> bool,
) -> Vec<(usize, usize)> {
    let n = distances.len();
    let mut shortest: Vec<Option<((usize, usize), f64)>> = vec![None; n];
    for block in (0..n).collect::<Vec<_>>().chunks(BLOCK) {
        let rows: Vec<Vec<f64>> = block.par_iter().map(|i| distances.row(*i)).collect();
        for (i, row) in block.iter().zip(rows) {
            for j in i + 1..n {
                if component[*i] == component[j] {
                    continue;
                }
                for c in [component[*i], component[j]] {
                    let shorter = shortest[c].is_none_or(|(_, known)| row[j] < known);
                    if shorter && !tried((*i, j)) {
                        shortest[c] = Some(((*i, j), row[j]));
                    }
                }
            }
        }
    }
    sorted(shortest.into_iter().flatten().collect())
}

fn sorted(pairs: BTreeMap<(usize, usize), f64>) -> Vec<(usize, usize)> {
    let mut pairs: Vec<_> = pairs.into_iter().collect();
    pairs.sort_by(|(a, one), (b, other)| one.total_cmp(other).then(a.cmp(b)));
    pairs.into_iter().map(|(pair, _)| pair).collect()
}

/// The edges of the minimum spanning tree and their lengths, by Prim's algorithm: O(n²) distances, O(n) memory.
fn spanning_tree(distances: &dyn Distances) -> Vec<((usize, usize), f64)> {
    let n = distances.len();
    let mut joined = vec![false; n];
    // Nearest joined site, and its distance.
    let mut link = vec![(0, f64::INFINITY); n];
    let mut tree = Vec::new();
    let mut last = 0;
    for _ in 1..n {
        joined[last] = true;
        for (i, distance) in distances.row(last).into_iter().enumerate() {
            // Everything is nearest to the first site until another one is nearer, even at an infinite distance.
            if !joined[i] && (last == 0 || distance < link[i].1) {
                link[i] = (last, distance);
            }
        }
        let next = (0..n)
            .filter(|i| !joined[*i])
            .min_by(|a, b| link[*a].1.total_cmp(&link[*b].1));
        let Some(next) = next else { break };
        let (from, length) = link[next];
        tree.push(((next.min(from), next.max(from)), length));
        last = next;
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
        let minima: Vec<Minimum> = (0..150)
            .map(|i| Minimum {
                coordinates: point(i),
                energy: 0.0,
                choice: Vec::new(),
                members: Vec::new(),
            })
            .collect();
        let kept = BetweenMinima::new(&space, &minima);
        let measured = BetweenMinima {
            kept: Vec::new(),
            ..BetweenMinima::new(&space, &minima)
        };
        let component: Vec<usize> = (0..150).map(|i| i / 50 * 50).collect();
        let pairs = |distances: &BetweenMinima<'_>| {
            (
                candidates(distances, 4),
                bridges(distances, &component, &|(i, _)| i % 2 == 0),
            )
        };
        assert_eq!(pairs(&kept), pairs(&measured));
        assert_eq!(pairs(&kept).1.len(), 2);
    }
}
