//! Selects the pairs of minima to connect.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::network::Minimum;
use crate::space::Space;

pub(super) fn distances(space: &dyn Space, minima: &[Minimum]) -> Vec<Vec<f64>> {
    let half: Vec<Vec<f64>> = minima
        .par_iter()
        .enumerate()
        .map(|(i, a)| {
            let below = minima[..i].iter();
            below
                .map(|b| space.distance(&b.coordinates, &a.coordinates))
                .collect()
        })
        .collect();
    let distance = |i: usize, j: usize| match i.cmp(&j) {
        std::cmp::Ordering::Less => half[j][i],
        std::cmp::Ordering::Equal => 0.0,
        std::cmp::Ordering::Greater => half[i][j],
    };
    (0..minima.len())
        .map(|i| (0..minima.len()).map(|j| distance(i, j)).collect())
        .collect()
}

/// Pairs of each minimum with its `neighbours` nearest minima, and the edges of the minimum spanning tree, so that the
/// pairs connect all minima. Pairs (i, j) have i < j and come nearest first.
pub(super) fn candidates(distances: &[Vec<f64>], neighbours: usize) -> Vec<(usize, usize)> {
    let n = distances.len();
    let mut pairs = BTreeSet::new();
    for (i, row) in distances.iter().enumerate() {
        let mut others: Vec<usize> = (0..n).filter(|j| *j != i).collect();
        others.sort_by(|a, b| row[*a].total_cmp(&row[*b]).then(a.cmp(b)));
        pairs.extend(
            others
                .into_iter()
                .take(neighbours)
                .map(|j| (i.min(j), i.max(j))),
        );
    }
    pairs.extend(spanning_tree(distances));
    sorted(pairs, distances)
}

/// The shortest untried pair from every component to another one; `component[i]` is that of minimum i.
pub(super) fn bridges(
    distances: &[Vec<f64>],
    component: &[usize],
    tried: &impl Fn((usize, usize)) -> bool,
) -> Vec<(usize, usize)> {
    let n = distances.len();
    let mut shortest: Vec<Option<(usize, usize)>> = vec![None; n];
    for i in 0..n {
        for j in i + 1..n {
            if component[i] == component[j] || tried((i, j)) {
                continue;
            }
            for c in [component[i], component[j]] {
                if shortest[c].is_none_or(|(a, b)| distances[i][j] < distances[a][b]) {
                    shortest[c] = Some((i, j));
                }
            }
        }
    }
    sorted(shortest.into_iter().flatten().collect(), distances)
}

fn sorted(pairs: BTreeSet<(usize, usize)>, distances: &[Vec<f64>]) -> Vec<(usize, usize)> {
    let mut pairs: Vec<_> = pairs.into_iter().collect();
    pairs.sort_by(|a, b| {
        let (one, other) = (distances[a.0][a.1], distances[b.0][b.1]);
        one.total_cmp(&other).then(a.cmp(b))
    });
    pairs
}

/// Prim's algorithm, O(n²).
fn spanning_tree(distances: &[Vec<f64>]) -> Vec<(usize, usize)> {
    let n = distances.len();
    let mut joined = vec![false; n];
    // Nearest joined minimum.
    let mut link = vec![0; n];
    let mut tree = Vec::new();
    if n > 0 {
        joined[0] = true;
    }
    for _ in 1..n {
        let next = (0..n)
            .filter(|i| !joined[*i])
            .min_by(|a, b| distances[*a][link[*a]].total_cmp(&distances[*b][link[*b]]));
        let Some(next) = next else { break };
        joined[next] = true;
        tree.push((next.min(link[next]), next.max(link[next])));
        for i in 0..n {
            if !joined[i] && distances[i][next] < distances[i][link[i]] {
                link[i] = next;
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
        assert!(candidates(&[], 3).is_empty());
        assert!(candidates(&line(&[1.0]), 3).is_empty());
    }
}
