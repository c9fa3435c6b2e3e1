//! Layout of the barrier graph: points in the plane whose distances follow the lengths of paths on the graph.

use std::cmp::Reverse;

use faer::{Mat, Side};
use petgraph::algo::dijkstra;
use petgraph::graph::{NodeIndex, UnGraph};
use petgraph::unionfind::UnionFind;
use rand::RngExt;

use crate::sample::{Task, stream};

/// Majorisation stops if a sweep lowers the stress by less than this part of it,
const TOLERANCE: f64 = 1e-5;
/// or if the average relative error of the distances is this small; rounding errors dominate far below.
const NEGLIGIBLE: f64 = 1e-7;
/// Largest number of sweeps.
const SWEEPS: usize = 500;

/// Points in the plane and the history of the stress.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GraphLayout {
    /// Place of each node.
    pub points: Vec<[f64; 2]>,
    /// Stress at the start and after each sweep; it never rises.
    pub stress: Vec<f64>,
}

/// Lengths of the shortest paths between all pairs of `count` nodes over undirected `links` (ends, length ≥ 0), as a
/// row-major count × count matrix. The length is infinite if there is no path. The method is Dijkstra's algorithm from
/// every node.
pub fn shortest_paths(count: usize, links: &[([usize; 2], f64)]) -> Vec<f64> {
    let mut graph = UnGraph::<(), f64>::with_capacity(count, links.len());
    for _ in 0..count {
        graph.add_node(());
    }
    for &([a, b], length) in links {
        graph.add_edge(NodeIndex::new(a), NodeIndex::new(b), length);
    }
    let row = |source| {
        let lengths = dijkstra(&graph, source, None, |edge| *edge.weight());
        let length = move |node| lengths.get(&node).copied().unwrap_or(f64::INFINITY);
        graph.node_indices().map(length)
    };
    graph.node_indices().flat_map(row).collect()
}

/// Connected components over `links` (ends, length), as sorted lists of nodes. The largest comes first; ties are ordered by
/// their lowest node.
pub fn components(count: usize, links: &[([usize; 2], f64)]) -> Vec<Vec<usize>> {
    let mut sets = UnionFind::new(count);
    for &([a, b], _) in links {
        sets.union(a, b);
    }
    let mut parts = vec![Vec::new(); count];
    for (node, part) in sets.into_labeling().into_iter().enumerate() {
        parts[part].push(node);
    }
    parts.retain(|part: &Vec<usize>| !part.is_empty());
    parts.sort_by_key(|part| (Reverse(part.len()), part[0]));
    parts
}

/// Weighted stress `Σ (‖p_i − p_j‖ − D_ij)² / D_ij²` over pairs `i < j` with `0 < D_ij < ∞`.
///
/// # Panics
/// If `distances` has not count × count entries.
pub fn stress(points: &[[f64; 2]], distances: &[f64]) -> f64 {
    let count = points.len();
    assert_eq!(distances.len(), count * count, "one distance a pair");
    let mut sum = 0.0;
    for i in 0..count {
        for j in 0..i {
            let target = distances[i * count + j];
            if target > 0.0 && target.is_finite() {
                let length = libm::hypot(points[i][0] - points[j][0], points[i][1] - points[j][1]);
                sum += ((length - target) / target).powi(2);
            }
        }
    }
    sum
}

/// Places points so that their distances follow `distances` (row-major, symmetric). The method is stress majorisation with
/// weights D⁻² (de Leeuw 1977), one point at a time (Gansner, Koren and North 2005), started from classical scaling.
///
/// Every move minimises a function that bounds the stress from above and touches it, so the stress never rises. `seed` only
/// separates points that start in the same place.
///
/// # Panics
/// If `distances` is not `count` × `count`.
pub fn majorise(count: usize, distances: &[f64], seed: u64) -> GraphLayout {
    assert_eq!(distances.len(), count * count, "one distance a pair");
    let mut points = classical_scaling(count, distances);
    let scale = distances
        .iter()
        .copied()
        .filter(|distance| distance.is_finite())
        .fold(0.0, f64::max);
    let mut rng = stream(seed, Task::Layout, 0);
    for coordinate in points.iter_mut().flatten() {
        *coordinate += 1e-3 * scale * (rng.random::<f64>() - 0.5);
    }
    let mut history = vec![stress(&points, distances)];
    for _ in 0..SWEEPS {
        for i in 0..count {
            let others = (0..count).filter(|j| *j != i);
            let others = others.map(|j| (points[j], distances[i * count + j]));
            points[i] = best_place(points[i], others);
        }
        let before = history[history.len() - 1];
        history.push(stress(&points, distances));
        let negligible = NEGLIGIBLE.powi(2) * (count * count) as f64;
        if before - history[history.len() - 1] <= TOLERANCE * before || before <= negligible {
            break;
        }
    }
    GraphLayout {
        points,
        stress: history,
    }
}

/// Minimum over `p_i`, now at `here`, of the majorant. It is the weighted mean of the places at distance `D_ij` from each
/// other point j (its place and this distance) in the present direction.
fn best_place(here: [f64; 2], others: impl Iterator<Item = ([f64; 2], f64)>) -> [f64; 2] {
    let (mut sum, mut total) = ([0.0; 2], 0.0);
    for (other, target) in others {
        if !(target > 0.0 && target.is_finite()) {
            continue;
        }
        let apart = [here[0] - other[0], here[1] - other[1]];
        let length = libm::hypot(apart[0], apart[1]);
        let stretch = if length > 0.0 { target / length } else { 0.0 };
        let weight = target.powi(-2);
        for axis in 0..2 {
            sum[axis] += weight * (other[axis] + stretch * apart[axis]);
        }
        total += weight;
    }
    if total > 0.0 {
        sum.map(|value| value / total)
    } else {
        here
    }
}

/// The place of one more point at these `distances` from `points`, which stay where they are: the steps of [`majorise`] for
/// this point alone, from the nearest of them.
///
/// # Panics
/// If there are not as many distances as points.
pub fn place_among(points: &[[f64; 2]], distances: &[f64]) -> [f64; 2] {
    assert_eq!(points.len(), distances.len(), "one distance a point");
    let others = || points.iter().copied().zip(distances.iter().copied());
    let nearest = others().min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((mut here, distance)) = nearest else {
        return [0.0; 2];
    };
    for _ in 0..SWEEPS {
        let next = best_place(here, others());
        let step = libm::hypot(next[0] - here[0], next[1] - here[1]);
        here = next;
        if step <= 1e-3 * distance {
            break;
        }
    }
    here
}

/// Classical scaling (Torgerson 1952): the two leading eigenvectors of −½ J D² J times the square roots of their
/// eigenvalues.
fn classical_scaling(count: usize, distances: &[f64]) -> Vec<[f64; 2]> {
    let square = |i: usize, j: usize| distances[i * count + j].powi(2);
    let finite = distances.iter().all(|distance| distance.is_finite());
    if count < 3 || !finite {
        return circle(count, distances);
    }
    let means: Vec<f64> = (0..count)
        .map(|i| (0..count).map(|j| square(i, j)).sum::<f64>() / count as f64)
        .collect();
    let mean = means.iter().sum::<f64>() / count as f64;
    let inner = Mat::from_fn(count, count, |i, j| {
        -0.5 * (square(i, j) - means[i] - means[j] + mean)
    });
    let Ok(eigen) = inner.self_adjoint_eigen(Side::Lower) else {
        return circle(count, distances);
    };
    let mut points = vec![[0.0; 2]; count];
    for axis in 0..2 {
        let column = count - 1 - axis;
        let size = eigen.S()[column].max(0.0).sqrt();
        // faer chooses its code by the processor, so that the last digits differ between processors.
        let vector: Vec<f64> = (0..count)
            .map(|index| (1e9 * eigen.U()[(index, column)]).round() / 1e9)
            .collect();
        // The sign of an eigenvector is arbitrary; its largest component is made positive.
        let largest = (0..count)
            .max_by(|&a, &b| vector[a].abs().total_cmp(&vector[b].abs()))
            .unwrap_or(0);
        let sign = vector[largest].signum();
        for (point, index) in points.iter_mut().zip(0..) {
            point[axis] = sign * size * vector[index];
        }
    }
    points
}

/// Start on a circle, for distances that do not allow classical scaling.
fn circle(count: usize, distances: &[f64]) -> Vec<[f64; 2]> {
    let radius = 0.5
        * distances
            .iter()
            .copied()
            .filter(|distance| distance.is_finite())
            .fold(0.0, f64::max);
    (0..count)
        .map(|index| {
            let angle = std::f64::consts::TAU * index as f64 / count as f64;
            [radius * libm::cos(angle), radius * libm::sin(angle)]
        })
        .collect()
}

/// Moves overlapping discs apart by the least distance. Afterwards centres are at least `r_i + r_j + gap` apart, unless 200
/// rounds do not suffice.
///
/// # Panics
/// If there are not as many radii as points.
pub fn separate(points: &mut [[f64; 2]], radii: &[f64], gap: f64) {
    assert_eq!(points.len(), radii.len(), "one radius a point");
    for _ in 0..200 {
        let mut moved = false;
        for i in 0..points.len() {
            for j in 0..i {
                let apart = [points[i][0] - points[j][0], points[i][1] - points[j][1]];
                let length = libm::hypot(apart[0], apart[1]);
                let wanted = radii[i] + radii[j] + gap;
                if length >= wanted - 1e-6 {
                    continue;
                }
                moved = true;
                let direction = if length > 0.0 {
                    apart.map(|value| value / length)
                } else {
                    [1.0, 0.0]
                };
                let push = 0.5 * (wanted - length);
                for axis in 0..2 {
                    points[i][axis] += push * direction[axis];
                    points[j][axis] -= push * direction[axis];
                }
            }
        }
        if !moved {
            return;
        }
    }
}

/// Places rectangles (width, height) side by side without overlap. It chooses rows or columns, whichever fills a sheet of
/// the given `aspect` (width / height) better, and returns the upper left corners and the size of the whole.
pub fn pack(sizes: &[[f64; 2]], aspect: f64) -> (Vec<[f64; 2]>, [f64; 2]) {
    let mut best: Option<(f64, Vec<[f64; 2]>, [f64; 2])> = None;
    for columns in [false, true] {
        let turn = |[a, b]: [f64; 2]| if columns { [b, a] } else { [a, b] };
        let turned: Vec<[f64; 2]> = sizes.iter().map(|&size| turn(size)).collect();
        let widest = turned.iter().map(|size| size[0]).fold(0.0, f64::max);
        let total: f64 = turned.iter().map(|size| size[0]).sum();
        for step in 0..=60 {
            let limit = widest
                * libm::pow(
                    total / widest.max(f64::MIN_POSITIVE),
                    f64::from(step) / 60.0,
                );
            let (corners, extent) = shelves(&turned, limit * (1.0 + 1e-9));
            let extent = turn(extent);
            let needed = extent[0].max(extent[1] * aspect);
            if best.as_ref().is_none_or(|(least, ..)| needed < *least) {
                best = Some((needed, corners.into_iter().map(turn).collect(), extent));
            }
        }
    }
    best.map_or((Vec::new(), [0.0; 2]), |(_, corners, extent)| {
        (corners, extent)
    })
}

/// Fills rows from left to right, the tallest rectangles first, up to the width `limit`.
fn shelves(sizes: &[[f64; 2]], limit: f64) -> (Vec<[f64; 2]>, [f64; 2]) {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by(|&a, &b| sizes[b][1].total_cmp(&sizes[a][1]).then(a.cmp(&b)));
    let mut corners = vec![[0.0; 2]; sizes.len()];
    let (mut x, mut y, mut row, mut width) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    for index in order {
        let size = sizes[index];
        if x > 0.0 && x + size[0] > limit {
            (x, y, row) = (0.0, y + row, 0.0);
        }
        corners[index] = [x, y];
        x += size[0];
        row = row.max(size[1]);
        width = width.max(x);
    }
    (corners, [width, y + row])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::super::testing::random_links;
    use super::*;

    proptest! {
        #[test]
        fn paths_agree_with_floyd_and_warshall(seed in 0u64..200, count in 1usize..25) {
            let links = random_links(seed, count, count);
            let lengths = shortest_paths(count, &links);
            let mut table = vec![f64::INFINITY; count * count];
            for i in 0..count {
                table[i * count + i] = 0.0;
            }
            for &([a, b], length) in &links {
                table[a * count + b] = table[a * count + b].min(length);
                table[b * count + a] = table[a * count + b];
            }
            for k in 0..count {
                for i in 0..count {
                    for j in 0..count {
                        table[i * count + j] = table[i * count + j].min(table[i * count + k] + table[k * count + j]);
                    }
                }
            }
            for (ours, theirs) in lengths.iter().zip(&table) {
                prop_assert!((ours - theirs).abs() < 1e-9);
            }
        }

        #[test]
        fn stress_never_rises(seed in 0u64..200, count in 2usize..30) {
            let lengths = shortest_paths(count, &random_links(seed, count, 2 * count));
            let layout = majorise(count, &lengths, seed);
            prop_assert!(layout.stress.len() > 1);
            prop_assert!(layout.stress.windows(2).all(|pair| pair[1] <= pair[0] * (1.0 + 1e-12)), "{:?}", layout.stress);
            prop_assert_eq!(majorise(count, &lengths, seed), layout);
        }

        #[test]
        fn packed_rectangles_do_not_overlap(sizes in prop::collection::vec((0.1f64..5.0, 0.1f64..5.0), 0..20)) {
            let sizes: Vec<[f64; 2]> = sizes.into_iter().map(|(a, b)| [a, b]).collect();
            let (corners, extent) = pack(&sizes, 1.3);
            for i in 0..sizes.len() {
                for axis in 0..2 {
                    prop_assert!(corners[i][axis] >= 0.0 && corners[i][axis] + sizes[i][axis] <= extent[axis] + 1e-9);
                }
                for j in 0..i {
                    prop_assert!((0..2).any(|axis| corners[i][axis] + sizes[i][axis] <= corners[j][axis] + 1e-9
                        || corners[j][axis] + sizes[j][axis] <= corners[i][axis] + 1e-9));
                }
            }
        }
    }

    #[test]
    fn distances_in_the_plane_are_recovered() {
        let truth = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [-1.0, 2.0], [0.5, 5.0]];
        let distances: Vec<f64> = truth
            .iter()
            .flat_map(|a| {
                truth
                    .iter()
                    .map(|b: &[f64; 2]| libm::hypot(a[0] - b[0], a[1] - b[1]))
            })
            .collect();
        let layout = majorise(5, &distances, 1);
        // The start is exact up to the seeded jitter, and the sweeps remove that.
        assert!(
            layout.stress[layout.stress.len() - 1] < 1e-6,
            "{:?}",
            layout.stress
        );
    }

    #[test]
    fn one_more_point_finds_its_place() {
        let points = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [-1.0, 2.0]];
        for truth in [[1.0, 1.0], [2.5, 3.0], [3.0, 4.0]] {
            let distances = points.map(|p: [f64; 2]| libm::hypot(p[0] - truth[0], p[1] - truth[1]));
            let place = place_among(&points, &distances);
            let gap = libm::hypot(place[0] - truth[0], place[1] - truth[1]);
            assert!(gap < 0.02, "{truth:?}: {place:?}");
        }
        assert!(
            place_among(&[], &[])
                .iter()
                .all(|x| x.abs() < f64::MIN_POSITIVE)
        );
    }

    #[test]
    fn coinciding_points_part() {
        // A star whose arms are equal: classical scaling in the plane puts arms on top of each other.
        let links: Vec<_> = (1..9).map(|leaf| ([0, leaf], 1.0)).collect();
        let layout = majorise(9, &shortest_paths(9, &links), 3);
        for i in 0..9 {
            for j in 0..i {
                let [a, b] = [layout.points[i], layout.points[j]];
                assert!(
                    libm::hypot(a[0] - b[0], a[1] - b[1]) > 0.3,
                    "{i} and {j} coincide"
                );
            }
        }
    }

    #[test]
    fn overlapping_discs_are_moved_apart() {
        let mut points = vec![[0.0, 0.0]; 12];
        let radii: Vec<f64> = (0..12).map(|i| 1.0 + f64::from(i % 3)).collect();
        // All in one place: pushed along x first, so give them a little height.
        for (index, point) in points.iter_mut().enumerate() {
            point[1] = 0.01 * index as f64;
        }
        separate(&mut points, &radii, 0.5);
        for i in 0..12 {
            for j in 0..i {
                let length = libm::hypot(points[i][0] - points[j][0], points[i][1] - points[j][1]);
                assert!(length >= radii[i] + radii[j] + 0.5 - 1e-3, "{length}");
            }
        }
    }

    #[test]
    fn components_come_largest_first() {
        assert_eq!(
            components(6, &[([4, 5], 1.0), ([1, 5], 1.0)]),
            [vec![1, 4, 5], vec![0], vec![2], vec![3]]
        );
        assert!(components(0, &[]).is_empty());
        assert_eq!(majorise(0, &[], 0).points.len(), 0);
        assert_eq!(majorise(1, &[0.0], 0).points, [[0.0, 0.0]]);
    }
}
