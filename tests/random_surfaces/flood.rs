//! The exact merge tree of a surface on a grid by flooding, that is, 0-dimensional persistence by union-find.
//!
//! The torus is cut into right triangles with legs h = 2π/n, and the surface replaced by its linear interpolant L. The
//! sublevel sets of L are connected exactly as the graph of vertices and triangle sides below the level, so flooding the
//! vertices (six neighbours each) gives the merge tree of L without error. L is within
//!
//! ```text
//! e = ½ M R² = M h² / 4
//! ```
//!
//! of V: M bounds the second derivative along any direction, R = h/√2 is the circumradius (S. Waldron, *The error in
//! linear interpolation at the vertices of a simplex*, SIAM J. Numer. Anal. 35, 1191 (1998)). A minimax height is a
//! minimum of maxima, so it moves by no more than e between V and L.

use std::f64::consts::TAU;

use petgraph::unionfind::UnionFind;

use crate::random_surfaces::surface::Surface;

/// A flooded grid.
pub(crate) struct Flood {
    n: usize,
    heights: Vec<f64>,
    /// Vertices in ascending order of height.
    order: Vec<usize>,
    /// Upper bound of |V − L|.
    pub(crate) error: f64,
}

/// Results of a flood for given places.
pub(crate) struct Merges {
    /// Height of L at which the vertices next to two places become connected. On the diagonal, the height of the vertex.
    pub(crate) minimax: Vec<Vec<f64>>,
    /// Greatest height that a component without any of the places reaches above its lowest vertex before it merges.
    pub(crate) missed: f64,
}

impl Flood {
    pub(crate) fn new(surface: &Surface, n: usize) -> Self {
        let heights = surface.on_grid(n);
        let mut order: Vec<usize> = (0..).take(heights.len()).collect();
        order.sort_unstable_by(|a, b| {
            let [x, y] = [a, b].map(|v| heights[*v]);
            x.total_cmp(&y).then(a.cmp(b))
        });
        let h = TAU / n as f64;
        Self {
            n,
            heights,
            order,
            error: surface.curvature_bound() * h * h / 4.0,
        }
    }

    /// The vertex next to a point.
    fn vertex(&self, x: &[f64]) -> usize {
        let [i, j] = [0, 1].map(|k| {
            let place = (x[k].rem_euclid(TAU) / TAU * self.n as f64).round();
            crate::random_surfaces::surface::whole(place) % self.n
        });
        i * self.n + j
    }

    /// Neighbours in the triangulation with diagonals from (i, j) to (i + 1, j + 1).
    fn neighbours(&self, vertex: usize) -> [usize; 6] {
        let n = self.n;
        let (i, j) = (vertex / n, vertex % n);
        let (up, down) = ((i + 1) % n, (i + n - 1) % n);
        let (right, left) = ((j + 1) % n, (j + n - 1) % n);
        [
            up * n + j,
            down * n + j,
            i * n + right,
            i * n + left,
            up * n + right,
            down * n + left,
        ]
    }

    /// Floods the grid from below.
    pub(crate) fn merges(&self, places: &[&[f64]]) -> Merges {
        let count = places.len();
        let vertices: Vec<usize> = places.iter().map(|x| self.vertex(x)).collect();
        let mut minimax = vec![vec![f64::INFINITY; count]; count];
        let mut sets = UnionFind::<usize>::new(self.heights.len());
        let mut wet = vec![false; self.heights.len()];
        // By representative: lowest height, and the places inside.
        let mut bottom = self.heights.clone();
        let mut inside: Vec<Vec<usize>> = vec![Vec::new(); self.heights.len()];
        for (place, &vertex) in vertices.iter().enumerate() {
            for &other in &inside[vertex] {
                minimax[place][other] = self.heights[vertex];
                minimax[other][place] = self.heights[vertex];
            }
            minimax[place][place] = self.heights[vertex];
            inside[vertex].push(place);
        }
        let mut missed: f64 = 0.0;
        for &vertex in &self.order {
            let level = self.heights[vertex];
            wet[vertex] = true;
            for neighbour in self.neighbours(vertex) {
                if !wet[neighbour] {
                    continue;
                }
                let [a, b] = [vertex, neighbour].map(|v| sets.find_mut(v));
                if a == b {
                    continue;
                }
                let [one, two] = [a, b].map(|set| std::mem::take(&mut inside[set]));
                for &i in &one {
                    for &j in &two {
                        minimax[i][j] = level;
                        minimax[j][i] = level;
                    }
                }
                let bottoms = [a, b].map(|set| bottom[set]);
                for (places, lowest) in [&one, &two].into_iter().zip(bottoms) {
                    if places.is_empty() {
                        missed = missed.max(level - lowest);
                    }
                }
                sets.union(a, b);
                let set = sets.find_mut(a);
                bottom[set] = bottoms[0].min(bottoms[1]);
                inside[set] = one;
                inside[set].extend(two);
            }
        }
        Merges { minimax, missed }
    }
}
